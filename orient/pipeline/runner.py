"""The runner: reads the heads, computes a stage outside any transaction, appends the result. The only writer."""

import getpass
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from orient.errors import OrientError, UsageError
from orient.pipeline.reasons import check_reason
from orient.pipeline.registry import ABOUT_RUNS, BY_NAME, EVIDENCE_TABLES, IMAGE, REMEDY, STAGES, Stage, how_to_get
from orient.pipeline.setting_values import check_settings
from orient.store.digest import content_of, input_digest
from orient.store.project import NewRun, Project, RunInfo, create_project_with, open_project
from orient.values import Event, InputTables, Outcome, Settings, Tables
from orient.words import counted

INPUT_STAGE_VERSION = 1


@dataclass(frozen=True, slots=True)
class Result:
    """What came of asking for a stage. `run` is None when there was nothing to do with (`waits_for`)."""

    stage: str
    run: RunInfo | None
    computed: bool
    events: Sequence[Event] = ()
    waits_for: str = ""
    hint: str = ""
    selected_again: bool = False

    @property
    def failed(self) -> bool:
        return self.run is not None and self.run.status == "failed"


def create(path: Path, inputs: Sequence[InputTables], reason: str) -> None:
    """A new project with version 1 of every input, in one step: the file appears whole or not at all."""
    check_reason(reason)
    create_project_with(path, [_input_run(given, reason) for given in inputs])


def add_input(path: Path, given: InputTables, reason: str, again: bool = False) -> Result:
    """Append a new version of one input; the same list twice is noticed and not stored again."""
    check_reason(reason)
    with open_project(path, "write") as project:
        return append_input(project, given, reason, again)


def append_input(project: Project, given: InputTables, reason: str, again: bool = False) -> Result:
    """A new version of one input in an open project; the same content as the current one is not stored again."""
    head, new = project.heads().get(given.stage), _input_run(given, reason)
    if head and not again and new.content and head.output_digest == new.content.digest:
        return Result(given.stage, head, computed=False, events=project.events(head.run_id))
    return Result(given.stage, project.append(new), computed=True, events=given.events)


def photo_facts(path: Path) -> Mapping[str, object] | None:
    """The current photo's row and the names of its fiducial marks, for checks of new lists; None without a photo."""
    with open_project(path, "read") as project:
        head = project.heads().get("photo")
        if head is None:
            return None
        tables = project.read_tables(head.run_id)
    return {**tables["photo"][0], "fiducials": [row["mark"] for row in tables.get("fiducial_mark", ())]}


def run_stage(
    path: Path, name: str, settings: Settings, reason: str, again: bool = False, defaults: bool = False
) -> Result:
    """Compute one stage from the current versions of its inputs.

    Settings that are not named are those of the current version, with `defaults` those of a first version.
    """
    check_reason(reason)
    with open_project(path, "write") as project:
        stage = BY_NAME[name]
        heads = project.heads()
        missing = stage.missing(set(heads))
        if missing:
            raise OrientError(f"{name} waits for {missing}", how_to_get([name], heads))
        stale = _stale_inputs(project, stage)
        if stale:
            raise OrientError(f"{name} would read {', '.join(stale)}, which is stale", "Run: orient run")
        given = {**stage.settings, **settings} if defaults else settings
        return _run(project, stage, given, reason, again)


def run_stale(
    path: Path, overrides: Settings, reason: str, begin: Callable[[Stage], None], end: Callable[[Result], None]
) -> list[Result]:
    """Compute every stage that is missing or stale, in order; a failure stops the stages that need it."""
    check_reason(reason)
    with open_project(path, "write") as project:
        return run_stale_in(project, overrides, reason, begin, end)


def run_stale_in(
    project: Project,
    overrides: Settings,
    reason: str,
    begin: Callable[[Stage], None] = lambda stage: None,
    end: Callable[[Result], None] = lambda result: None,
) -> list[Result]:
    """The same in a project that is open for writing."""
    results: list[Result] = []
    for stage in STAGES:
        result = _next_result(project, stage, overrides, reason, results, begin)
        results.append(result)
        end(result)
    return results


def select_version(path: Path, stage: str, version: int, reason: str) -> RunInfo:
    """Make another version of a stage current (undo is a new selection)."""
    if stage in ABOUT_RUNS:
        raise UsageError(f"{stage} is evidence about other runs; none of its versions is current")
    check_reason(reason)
    with open_project(path, "write") as project:
        return project.select(stage, version, current_user(), reason)


def withdraw(path: Path, name: str, reason: str) -> list[RunInfo]:
    """Leave a list or a stage without a current version, and then every stage that cannot be computed any more.

    The withdrawn ones, in order. All versions stay and can be selected again.
    """
    check_reason(reason)
    with open_project(path, "write") as project:
        heads = project.heads()
        if name not in heads:
            raise UsageError(f"{name} has no current version", f"There are {', '.join(heads)}.")
        left = dict(heads)
        gone = [left.pop(name)]
        gone += [left.pop(stage.name) for stage in STAGES if stage.name in left and stage.missing(set(left))]
        expected = {stage: heads[stage].run_id if stage in heads else None for stage in (name, *BY_NAME)}
        project.withdraw([run.stage for run in gone], current_user(), reason, expected)
    return gone


def current_user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "unknown"


def _next_result(
    project: Project,
    stage: Stage,
    overrides: Settings,
    reason: str,
    before: Sequence[Result],
    begin: Callable[[Stage], None],
) -> Result:
    failed = {result.stage for result in before if result.failed}
    without_result = failed | {result.stage for result in before if result.waits_for}
    # what failed now may have an older head: nobody may go on with that, even if the input is optional
    stops = [name for name in stage.inputs if name in failed or (name in without_result and name in stage.required)]
    heads = project.heads()
    unasked = [stage.wanted_with] if stage.wanted_with and stage.wanted_with not in heads else []
    missing = ", ".join([*unasked, *stops]) or stage.missing(set(heads) - without_result)
    if missing:
        return Result(stage.name, None, computed=False, waits_for=missing)
    begin(stage)
    own = {key: value for key, value in overrides.items() if key in stage.settings}
    return _run(project, stage, own, reason, again=False)


def _run(project: Project, stage: Stage, settings: Settings, reason: str, again: bool) -> Result:
    with project.snapshot():
        heads = project.heads()
        inputs = {name: heads[name] for name in stage.inputs if name in heads}
        full = _full_settings(stage, heads.get(stage.name), settings)
        basis = {name: run.output_digest for name, run in inputs.items()}
        digest = input_digest(stage.name, stage.version, full, basis)
        known = None if again else _known_run(project, stage, full, basis)
        wanted = {} if known else inputs
        read = {name: project.read_columns(run.run_id, EVIDENCE_TABLES) for name, run in wanted.items()}
    if known is not None:
        return _reuse(project, stage, known, reason)
    outcome = outcome_of(stage, read, full)
    del read  # what was read and what is to be stored are never in memory together
    repeated = _same_failure(project, stage, digest, outcome) if outcome.error and not again else None
    if repeated is not None:
        return Result(stage.name, repeated, computed=False, events=outcome.events, hint=outcome.hint)
    new = NewRun(
        stage=stage.name,
        stage_version=stage.version,
        settings=full,
        inputs={name: run.run_id for name, run in inputs.items()},
        input_digest=digest,
        expected_heads={name: heads[name].run_id if name in heads else None for name in stage.inputs},
        actor=current_user(),
        reason=reason,
        outcome=outcome,
        select=True,
        once=not again,
    )
    return Result(stage.name, project.append(new), computed=True, events=outcome.events, hint=outcome.hint)


def _known_run(project: Project, stage: Stage, full: Settings, basis: Mapping[str, str]) -> RunInfo | None:
    """A run on the same inputs with the same settings, or with those that it had before `formerly` was a setting."""
    short = {key: value for key, value in full.items() if key not in stage.formerly or value != stage.formerly[key]}
    for settings in (full, short) if short != full else (full,):
        digest = input_digest(stage.name, stage.version, settings, basis)
        if known := project.find_run_by_digest(stage.name, digest):
            return known
    return None


def _same_failure(project: Project, stage: Stage, digest: str, outcome: Outcome) -> RunInfo | None:
    """The stage's last run, if it failed on the same inputs with the same words: that is not stored again."""
    last = project.runs(stage.name)[-1:]
    return last[0] if last and (last[0].input_digest, last[0].error) == (digest, outcome.error) else None


def _reuse(project: Project, stage: Stage, known: RunInfo, reason: str) -> Result:
    """The same inputs and settings were computed before: make that version current instead of repeating it."""
    head = project.heads().get(stage.name)
    moves = head is None or head.run_id != known.run_id
    if moves:
        project.select(stage.name, known.version, current_user(), reason)
    return Result(stage.name, known, computed=False, events=project.events(known.run_id), selected_again=moves)


def outcome_of(stage: Stage, inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """What the stage makes of its inputs; a refusal is a failed outcome. What to do about a failure is kept with it."""
    try:
        outcome = stage.compute(inputs, settings)
    except OrientError as error:
        failure = Event("error", "refused", "", error.message)
        outcome = Outcome({}, (failure,), error=error.message, hint=error.hint)
    if not outcome.error or not outcome.hint:
        return outcome
    return replace(outcome, events=(*outcome.events, Event("info", REMEDY, "", outcome.hint)))


def _full_settings(stage: Stage, head: RunInfo | None, given: Settings) -> Settings:
    """Defaults, then what the current version was made with, then what the user says now."""
    unknown = set(given) - set(stage.settings)
    if unknown:
        raise UsageError(
            f"{stage.name} has no setting {', '.join(sorted(unknown))}", f"It has: {', '.join(stage.settings)}."
        )
    check_settings(given)
    made_with = {**stage.formerly, **head.settings} if head else {}
    kept = {key: value for key, value in made_with.items() if key in _kept_names(stage)}
    return {**stage.settings, **kept, **given}


def _input_run(given: InputTables, reason: str) -> NewRun:
    settings = {"files": ", ".join(given.files)}
    content = content_of(given.tables, given.events)
    return NewRun(
        stage=given.stage,
        stage_version=INPUT_STAGE_VERSION,
        settings=settings,
        inputs={},
        input_digest=input_digest(given.stage, INPUT_STAGE_VERSION, settings, {"content": content.digest}),
        expected_heads={},
        actor=current_user(),
        reason=reason,
        outcome=Outcome(given.tables, given.events, summary=describe(given)),
        select=True,
        content=content,
    )


def _kept_names(stage: Stage) -> set[str]:
    return set(stage.settings) - set(stage.not_kept)


def describe(given: InputTables) -> str:
    """An imported list in one line."""
    counts = {table: len(rows) for table, rows in given.tables.items()}
    if given.stage == "photo":
        photo = given.tables["photo"][0]
        marks = counted(counts.get("fiducial_mark", 0), "fiducial mark")
        return f"{photo['name']}, {photo['platform']}, f {photo['f_mm']} mm, {marks}"
    if given.stage == IMAGE:
        image = given.tables["image"][0]
        how = "embedded" if image["n_parts"] else "by its digest only"
        return f"{image['name']}, {image['size_bytes']} bytes, {how}"
    if given.stage == "readings":
        rows = given.tables["comparator_reading"]
        kinds = [kind for kind, _ in {(str(row["kind"]), row["point"]) for row in rows}]
        marks = f" and {counted(kinds.count('fiducial'), 'fiducial mark')}" if "fiducial" in kinds else ""
        cycles = counted(len({row["cycle"] for row in rows}), "cycle")
        return f"{counted(len(rows), 'reading')} of {counted(kinds.count('point'), 'point')}{marks} in {cycles}"
    if given.stage == "sheet":
        crosses = counted(counts["graticule_cross"], "cross", "crosses")
        read = counted(counts.get("digitizer_reading", 0), "reading")
        return f"{counted(counts['map_sheet'], 'sheet')}, {crosses}, {read} of points"
    if given.stage == "control":
        roles = [row["role"] for row in given.tables["control_point"]]
        control, check = roles.count("control"), roles.count("check")
        return f"{counted(control, 'control point')}, {counted(check, 'check point')}"
    return counted(counts["model_point"], "model point")


def _stale_inputs(project: Project, stage: Stage) -> list[str]:
    _, rows = project.query("SELECT stage FROM v_stale WHERE is_stale = 1")
    stale = {row[0] for row in rows}
    return [name for name in stage.inputs if name in stale and name in project.heads()]
