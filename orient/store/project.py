"""The door to a project file: create, open, read, append, ask."""

import os
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self, TypeVar

from sqlalchemy import Connection
from sqlalchemy.exc import DBAPIError

from orient.errors import UsageError
from orient.store import runs
from orient.store.asking import Answer, ask
from orient.store.connection import Mode, let_spill, scalar, write_alone
from orient.store.digest import input_digest as input_digest
from orient.store.digest import output_digest as output_digest
from orient.store.error_map import error_name, explain, is_busy, translated
from orient.store.errors import OurFault, ReadOnly
from orient.store.format import Format, current_format
from orient.store.gate import Gated, pass_gate, recover, require_writable, tidy
from orient.store.images import image_bytes
from orient.store.new_file import make_file, new_name, sweep, sync_content
from orient.store.plain import event_rows
from orient.store.preflight import Preflight, preflight
from orient.store.rows import StoredTable, stored_tables
from orient.store.runs import NewRun as NewRun
from orient.store.runs import RunInfo as RunInfo
from orient.store.stage_tables import EVENT_TABLE
from orient.values import Columns, Event, Row, Scalar

COMMIT_PATIENCE_S = 60.0
MOST_IN_MEMORY = 10_000
"""Rows of a new project that is made in memory."""

Result = TypeVar("Result")


class Project:
    """An open project file. Use it with `with`; every method is one moment of the file."""

    def __init__(self, look: Preflight, mode: Mode, form: Format, with_checks: bool = True) -> None:
        self.path = look.path
        self.mode: Mode = mode
        self.warnings: list[str] = list(look.warnings)
        self._look = look
        self._form = form
        self._is_closed = False
        self._gated: Gated | None = pass_gate(look, mode, form, with_checks)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._is_closed = True
        self._drop_connection()

    def _drop_connection(self) -> None:
        if self._gated is not None:
            self._gated.close()
            self._gated = None

    # ------------------------------------------------------------------------------------------ reading

    @contextmanager
    def snapshot(self) -> Iterator[Connection]:
        """One moment: everything that is read inside belongs together. Writers wait at their commit meanwhile."""
        gated = self._open_gate()
        with translated(self.path, gated.watch):
            if gated.connection.in_transaction():
                yield gated.connection
                return
            with gated.begin():
                yield gated.connection

    def heads(self) -> dict[str, RunInfo]:
        """The current run of each stage."""
        with self.snapshot() as connection:
            return runs.heads(connection)

    def runs(self, stage: str | None = None) -> list[RunInfo]:
        """All sealed runs (of one stage) in the order they were made."""
        with self.snapshot() as connection:
            if stage is None:
                return runs.runs_where(connection, "1")
            return runs.runs_where(connection, "r.stage = ?", (stage,))

    def run(self, stage: str, version: int) -> RunInfo:
        """Version `version` of a stage; a `UsageError` names what exists if it does not."""
        known = self.runs(stage)
        for run in known:
            if run.version == version:
                return run
        if known:
            versions = ", ".join(str(run.version) for run in known)
            raise UsageError(f"{stage} has no version {version}.", f"There are versions {versions}.")
        stages = ", ".join(dict.fromkeys(run.stage for run in self.runs()))
        raise UsageError(f'there is no run of stage "{stage[:60]}".', f"There are runs of: {stages or 'nothing yet'}.")

    def find_run_by_digest(self, stage: str, input_digest: str) -> RunInfo | None:
        """The latest result of a stage with this input digest."""
        condition = "r.stage = ? AND r.input_digest = ? AND s.status = 'succeeded'"
        with self.snapshot() as connection:
            found = runs.runs_where(connection, condition, (stage, input_digest))
        return found[-1] if found else None

    def read_tables(self, run_id: int) -> dict[str, list[dict[str, Scalar]]]:
        """Rows of a run by table and column, without `run_id`, in the order of the primary key; no empty tables."""
        with self._tables(run_id) as tables:
            return {name: rows for name, table in tables.items() if (rows := table.dicts())}

    def read_columns(self, run_id: int, leave_out: Collection[str] = ()) -> dict[str, Columns]:
        """As `read_tables`, by column: less memory, and faster to compute with. `leave_out`: tables not to read."""
        with self._tables(run_id) as tables:
            wanted = {name: table for name, table in tables.items() if name not in leave_out}
            return {name: rows for name, table in wanted.items() if (rows := table.columns())}

    @contextmanager
    def _tables(self, run_id: int) -> Iterator[dict[str, StoredTable]]:
        """The tables of a run but its events."""
        with self.snapshot() as connection:
            stage = scalar(connection, "SELECT stage FROM main.stage_run WHERE run_id = ?", (run_id,))
            if stage is None:
                raise UsageError(f"there is no run {run_id}.")
            tables = stored_tables(connection, run_id, str(stage), self._form)
            yield {name: table for name, table in tables.items() if name != EVENT_TABLE}

    def events(self, run_id: int) -> list[Event]:
        with self.snapshot() as connection:
            return runs.events(connection, run_id)

    def image(self, run_id: int) -> Iterator[bytes]:
        """The bytes of an embedded image, part by part; an error at the end if they are not the file as sealed."""
        with self.snapshot() as connection:
            yield from image_bytes(connection, run_id)

    def digest_problems(self, run_id: int) -> list[str]:
        """What does not fit in the digests, the count and the ledger entry of one run; empty if all is as sealed."""
        from orient.store import verify

        with self.snapshot() as connection:
            seal = connection.exec_driver_sql(f"{verify.SEALS} WHERE run_id = ?", (run_id,)).one()
            return verify.run_problems(connection, self._form, tuple(seal))

    def ledger_problems(self) -> list[str]:
        """Runs without a seal, gaps in the numbers, rows of a strange stage, altered selections."""
        from orient.store import verify

        with self.snapshot() as connection:
            looks = (verify.unsealed_runs, verify.broken_sequences, verify.strange_rows, verify.broken_selections)
            return [problem for look in looks for problem in look(connection)]

    def stored_tables(self, run_id: int) -> dict[str, Sequence[Row]]:
        """As `read_tables`, with the run's events as table `run_event`."""
        return {**self.read_tables(run_id), EVENT_TABLE: event_rows(self.events(run_id))}

    def query(
        self,
        sql: str,
        parameters: Sequence[Any] | Mapping[str, Any] = (),
        max_rows: int | None = None,
        timeout_s: float | None = 60.0,
    ) -> Answer:
        """Columns and rows of one reading SQL statement (SELECT, WITH, VALUES, EXPLAIN)."""
        with self.snapshot() as connection:
            return ask(connection, self._open_gate().watch, sql, parameters, max_rows, timeout_s)

    # ------------------------------------------------------------------------------------------ writing

    def let_spill(self) -> None:
        """Let a large append go to the disk before its end, so that memory stays bounded.

        Only for a file that nobody else knows yet: readers are locked out meanwhile.
        """
        gated = self._open_gate()
        with gated.watch.in_phase("setup"):
            let_spill(gated.connection)

    def write_alone(self) -> None:
        """Journal in memory, no syncs: only for a new file without a name, which is synced before it gets one."""
        gated = self._open_gate()
        with gated.watch.in_phase("setup"):
            write_alone(gated.connection)

    def append(self, new: NewRun) -> RunInfo:
        """Store one run in one transaction: header, inputs, rows, events, seal, selection."""
        return self.append_all([new])[0]

    def append_all(self, new: Sequence[NewRun]) -> list[RunInfo]:
        """Store several runs in one transaction, all or none. Their expected heads are those before the first."""
        from orient.store import ledger

        return self._write(lambda connection: ledger.append_all(connection, new, self._form), self._are_stored)

    def select(self, stage: str, version: int, actor: str, reason: str) -> RunInfo:
        """Make an existing result the current version of its stage."""
        from orient.store import ledger

        run = self.run(stage, version)
        if run.status != "succeeded":
            raise UsageError(f"{stage} version {version} failed, it cannot be selected.", run.error)
        self._write(lambda connection: ledger.select(connection, stage, run.run_id, actor, reason), self._is_selected)
        return run

    def withdraw(
        self, stages: Sequence[str], actor: str, reason: str, expected_heads: Mapping[str, int | None]
    ) -> None:
        """Leave the stages without a current version, all or none of them. Their versions stay."""
        from orient.store import ledger

        def work(connection: Connection) -> str:
            ledger.check_heads(connection, expected_heads)
            return [ledger.select(connection, stage, None, actor, reason) for stage in stages][-1]

        self._write(work, self._is_selected)

    def _write(self, work: Callable[[Connection], Result], is_stored: Callable[[Result], bool] | None = None) -> Result:
        """Do `work` in one BEGIN IMMEDIATE transaction; a commit that a reader blocks is repeated with the work."""
        if self.mode != "write":
            raise ReadOnly(f"{self.path} was opened for reading.", 'Open it with mode "write".')
        give_up = time.monotonic() + COMMIT_PATIENCE_S
        while True:
            gated = self._open_gate()
            try:
                with translated(self.path, gated.watch):
                    result = self._begin_and_work(gated, work)
            except BaseException:
                self._drop_connection()  # never continue after an error
                raise
            try:
                gated.connection.commit()
            except DBAPIError as error:
                self._drop_connection()
                if is_busy(error) and time.monotonic() < give_up:
                    continue
                if is_busy(error) or is_stored is None or not is_stored(result):
                    raise explain(error.orig or error, self.path, gated.watch) from error
                self.warnings.append(f"The disk reported {error_name(error)} at the end, but everything is stored.")
            return result

    def _begin_and_work(self, gated: Gated, work: Callable[[Connection], Result]) -> Result:
        gated.begin(immediate=True)
        return work(gated.connection)

    def _are_stored(self, appended: list[RunInfo]) -> bool:
        """Look up, on a new connection, whether the runs are there: an error at COMMIT does not say so."""
        for run in appended:
            with self.snapshot() as connection:
                found = next(iter(runs.runs_where(connection, "r.run_id = ?", (run.run_id,))), None)
            if found != run:
                return False
        return True

    def _is_selected(self, record_digest: str) -> bool:
        """As `_are_stored`, for a selection."""
        query = "SELECT count(*) FROM main.selection WHERE record_digest = ?"
        with self.snapshot() as connection:
            return bool(scalar(connection, query, (record_digest,)))

    def _open_gate(self) -> Gated:
        if self._is_closed:
            raise OurFault(f"{self.path} is closed")
        if self._gated is None:
            self._gated = pass_gate(self._look, self.mode, self._form, with_checks=False)
        return self._gated


# ---------------------------------------------------------------------------------------------- open, create


def open_project(path: str | os.PathLike[str], mode: Mode = "read") -> Project:
    """Open a project; every reason not to has its own `ProjectError`. A hot journal is undone first."""
    form = current_format()
    look = preflight(path, form)
    if mode == "write":
        require_writable(look.path)
        sweep(look.path.parent)
    if look.journal == "hot":
        recover(look)
    project = Project(look, mode, form)
    try:
        if look.journal == "hot":
            _check_after_recovery(project)
        if look.journal != "live" and mode == "write" and look.journal != "none":
            tidy(project._open_gate(), form)
    except BaseException:
        project.close()
        raise
    return project


def _check_after_recovery(project: Project) -> None:
    from orient.store.check import verify_runs

    with project.snapshot() as connection:
        verify_runs(connection, current_format(), project.path)
    project.warnings.append(f"{project.path} was recovered from an interrupted command; nothing of it is stored.")


def create_project(path: str | os.PathLike[str], fill: Callable[[Project], object] | None = None) -> None:
    """Make a new project file, filled by `fill` before it gets its name. An existing name is never touched."""
    _create(path, (), fill)


def _create(path: str | os.PathLike[str], small: Sequence[NewRun], fill: Callable[[Project], object] | None) -> None:
    """`small`: runs that are stored in memory and written as a whole."""
    form = current_format()

    def write(temporary: Path) -> None:
        from orient.store.template import write_project

        write_project(temporary, form, small)
        if fill is not None:
            with Project(preflight(temporary, form), "write", form, with_checks=False) as project:
                project.write_alone()
                fill(project)
        sync_content(temporary)

    make_file(new_name(path), write)


def create_project_with(path: str | os.PathLike[str], new: Sequence[NewRun]) -> None:
    """Make a new project file of these runs, all or none: in memory if they are small, else through the file."""
    if are_small(new):
        _create(path, new, None)
    else:
        _create(path, (), lambda project: project.append_all(new))


def are_small(new: Sequence[NewRun]) -> bool:
    """Few rows and events, and no bytes of an image, which are fetched as they are stored."""
    shapes, outcomes = current_format().tables, [run.outcome for run in new]
    names = {name for outcome in outcomes for name in outcome.tables}
    n_rows = sum(len(rows) for outcome in outcomes for rows in (*outcome.tables.values(), outcome.events))
    return n_rows <= MOST_IN_MEMORY and not any(shapes[name].has_bytes for name in names & shapes.keys())
