-- Nothing that is stored is ever changed or deleted, and a sealed run takes no more rows.
-- {table} stands for every table, {run_table} for every table whose rows belong to a run that is still open.

CREATE TRIGGER guard_{table}_update BEFORE UPDATE ON {table}
BEGIN SELECT RAISE(ABORT, 'rows of {table} are never changed'); END;

CREATE TRIGGER guard_{table}_delete BEFORE DELETE ON {table}
BEGIN SELECT RAISE(ABORT, 'rows of {table} are never deleted'); END;

CREATE TRIGGER guard_{run_table}_sealed BEFORE INSERT ON {run_table}
WHEN EXISTS (SELECT 1 FROM run_seal WHERE run_id = NEW.run_id)
BEGIN SELECT RAISE(ABORT, 'the run is sealed, {run_table} takes no more rows of it'); END;

CREATE TRIGGER guard_alembic_version_insert BEFORE INSERT ON alembic_version
BEGIN SELECT RAISE(ABORT, 'the format of a project changes by orient upgrade only'); END;

CREATE TRIGGER guard_stage_run_version BEFORE INSERT ON stage_run
WHEN NEW.version IS NOT (SELECT coalesce(max(version), 0) + 1 FROM stage_run WHERE stage = NEW.stage)
BEGIN SELECT RAISE(ABORT, 'versions of a stage are counted 1, 2, 3 ... without a gap'); END;

CREATE TRIGGER guard_run_input_result BEFORE INSERT ON run_input
WHEN NOT EXISTS (SELECT 1 FROM run_seal WHERE run_id = NEW.input_run_id AND status = 'succeeded')
BEGIN SELECT RAISE(ABORT, 'a run reads only sealed results'); END;

CREATE TRIGGER guard_selection_result BEFORE INSERT ON selection
WHEN NEW.run_id IS NOT NULL AND NOT EXISTS (
    SELECT 1 FROM stage_run JOIN run_seal ON run_seal.run_id = stage_run.run_id
    WHERE stage_run.run_id = NEW.run_id AND stage_run.stage = NEW.stage AND run_seal.status = 'succeeded'
)
BEGIN SELECT RAISE(ABORT, 'only a sealed result of the same stage can be selected'); END;
