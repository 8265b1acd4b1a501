"""`orient verify`: every sealed run computed again from its recorded inputs and settings; the verdict is kept.

Evidence is a run of its own, stage `verify`, that reads the runs it has examined: sealed and chained as any other, but
never selected, so that no head moves and nothing becomes stale (docs/decisions/0010).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from orient.errors import OrientError, UsageError
from orient.pipeline.agreement import Solved
from orient.pipeline.registry import BY_NAME, EVIDENCE, REMEDY, Stage
from orient.pipeline.runner import current_user, outcome_of
from orient.pipeline.second_engine import solve_again
from orient.pipeline.verify_compare import Comparison, Difference, compare, seal_row
from orient.pipeline.verify_observations import NOT_SIMULATED, knows_all_unknowns, resection_observations
from orient.pipeline.verify_verdict import RunVerdict, Verification, evidence
from orient.solvers.resection_simulation import Spread, simulate_resection
from orient.store.digest import content_of, input_digest
from orient.store.errors import ReadOnly
from orient.store.ledger import tool_version
from orient.store.plain import event_rows
from orient.store.project import NewRun, Project, RunInfo, open_project
from orient.store.stage_tables import EVENT_TABLE
from orient.values import Outcome, Settings, Tables

EVIDENCE_VERSION = 1


@dataclass(frozen=True, slots=True)
class Request:
    """`simulate` adjustments of the current resection, drawn from `seed`; the verdict kept or not; the reason."""

    simulate: int = 0
    seed: int = 1
    record: bool = True
    reason: str = "verify"


@dataclass(frozen=True, slots=True)
class Watch:
    """Who is told how far it is: before a run (its place, of how many), after it, and in a simulation (done, of n)."""

    begin: Callable[[RunInfo, int, int], None] = lambda run, place, total: None
    end: Callable[[RunVerdict], None] = lambda verdict: None
    simulated: Callable[[int, int], None] = lambda done, n: None


def verify_project(path: Path, request: Request, watch: Watch | None = None) -> Verification:
    """Examine every run of the file but earlier evidence, whose seals alone are looked at; keep the verdict if asked.

    An imported list is compared with its seal; a computed run is computed again, compared, and its adjustments are
    solved by a second engine. Failed runs must fail again in the same way.
    """
    watch = watch or Watch()
    with _opened(path, request.record) as project:
        runs = project.runs()
        examined = [run for run in runs if run.stage != EVIDENCE]
        if not examined:
            raise UsageError(f"{path} has no runs to verify")
        current = {run.run_id for run in project.heads().values()}
        verdicts: list[RunVerdict] = []
        for place, run in enumerate(examined, 1):
            watch.begin(run, place, len(examined))
            verdict = _examined(project, run)
            if request.simulate and run.run_id in current and run.stage == "resection" and verdict.verdict != "differs":
                verdict = _with_spread(verdict, project, request, watch)
            verdicts.append(replace(verdict, reads=_differing_inputs(verdict, verdicts)))
            watch.end(verdicts[-1])
        ledger = project.ledger_problems()
        ledger += [text for run in runs if run.stage == EVIDENCE for text in project.digest_problems(run.run_id)]
        done = Verification(verdicts, ledger)
        return replace(done, kept=project.append(_new_run(done, request))) if request.record else done


def _differing_inputs(verdict: RunVerdict, before: Sequence[RunVerdict]) -> str:
    """Inputs of the run that differ: what follows from them is no separate fault."""
    inputs = set(verdict.run.inputs.values())
    return ", ".join(other.title for other in before if other.verdict == "differs" and other.run.run_id in inputs)


def _opened(path: Path, record: bool) -> Project:
    try:
        return open_project(path, "write" if record else "read")
    except ReadOnly as error:
        raise ReadOnly(error.message, "Verify it without keeping the verdict: --no-record") from None


def _examined(project: Project, run: RunInfo) -> RunVerdict:
    """Seal and numbers of one run."""
    seal = [Difference("seal", text, "") for text in project.digest_problems(run.run_id)]
    stage = BY_NAME.get(run.stage)
    if stage is None:
        return RunVerdict(run, "digest", "", Comparison(refused=seal))
    try:
        verdict = _recomputed(project, run, stage)
    except OrientError as error:
        verdict = RunVerdict(run, "recomputed", "", Comparison(refused=[Difference("rows", error.message, "")]))
    verdict.found.refused[:0] = seal
    return verdict


def _recomputed(project: Project, run: RunInfo, stage: Stage) -> RunVerdict:
    inputs = {name: project.read_columns(run_id) for name, run_id in run.inputs.items()}
    settings = {**stage.settings, **run.settings}
    stored = {**project.stored_tables(run.run_id), **seal_row(run.status, run.summary, run.error)}
    outcome = outcome_of(stage, inputs, settings)
    because = _why_not_bits(run, stage)
    is_older = run.stage_version != stage.version
    found = compare(stored, _as_stored(_told_as_then(outcome, stored)), exact=not because, is_older=is_older)
    solved = _solved_again(run, inputs, settings, stored)
    return RunVerdict(run, "recomputed", because, found, solved.agreements, solved.left_out, remarks=solved.remarks)


def _told_as_then(outcome: Outcome, stored: Tables) -> Outcome:
    """Failures of before it was kept with them do not say what to do."""
    if any(row["code"] == REMEDY for row in stored[EVENT_TABLE]):
        return outcome
    return replace(outcome, events=[event for event in outcome.events if event.code != REMEDY])


def _as_stored(outcome: Outcome) -> Tables:
    """The rows that the runner would store, with events and seal."""
    plain = {name: table.rows() for name, table in content_of(outcome.tables).tables.items()}
    status = "failed" if outcome.error else "succeeded"
    return {**plain, EVENT_TABLE: event_rows(outcome.events), **seal_row(status, outcome.summary, outcome.error)}


def _why_not_bits(run: RunInfo, stage: Stage) -> str:
    """Empty if the run was made by the same computation, software and kind of processor as this one."""
    if run.stage_version != stage.version:
        return f"made by version {run.stage_version} of the stage, this orient has version {stage.version}"
    return "" if run.tool_version == tool_version() else f"made by {run.tool_version}"


def _solved_again(run: RunInfo, inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> Solved:
    """The second engine; numbers that were altered may be beyond any solution."""
    if run.status == "failed":
        return Solved()
    try:
        return solve_again(run.stage, inputs, settings, stored)
    except (OrientError, ArithmeticError, LookupError, ValueError) as error:
        return Solved(left_out=f"the stored result cannot be solved again ({error})")


def _with_spread(verdict: RunVerdict, project: Project, request: Request, watch: Watch) -> RunVerdict:
    """The simulation, where it has all unknowns of the resection; else the verdict says that it is left out."""
    run = verdict.run
    settings = {**BY_NAME[run.stage].settings, **run.settings}
    if not knows_all_unknowns(settings, project.read_tables(run.inputs["photo"])):
        return replace(verdict, remarks=[*verdict.remarks, f"not simulated: {NOT_SIMULATED}"])
    return replace(verdict, spread=_simulated(project, run, request, watch))


def _simulated(project: Project, run: RunInfo, request: Request, watch: Watch) -> Spread:
    inputs = {name: project.read_columns(run_id) for name, run_id in run.inputs.items()}
    settings = {**BY_NAME[run.stage].settings, **run.settings}
    case = resection_observations(inputs, settings, project.read_tables(run.run_id))
    return simulate_resection(
        case.given, case.station, case.rotation, case.adjusted, case.sigma0, request.simulate, request.seed,
        lambda done: watch.simulated(done, request.simulate),
    )  # fmt: skip


def _new_run(done: Verification, request: Request) -> NewRun:
    """The evidence: its inputs are the results that it is about (a failed run is no input, but has its row)."""
    settings: Settings = {"simulate": request.simulate, "seed": request.seed if request.simulate else None}
    results = [verdict.run for verdict in done.verdicts if verdict.run.status == "succeeded"]
    inputs = {f"{run.stage} {run.version}": run for run in results}
    digest = input_digest(
        EVIDENCE, EVIDENCE_VERSION, settings, {role: run.output_digest for role, run in inputs.items()}
    )
    return NewRun(
        stage=EVIDENCE,
        stage_version=EVIDENCE_VERSION,
        settings=settings,
        inputs={role: run.run_id for role, run in inputs.items()},
        input_digest=digest,
        outcome=evidence(done),
        expected_heads={},
        actor=current_user(),
        reason=request.reason,
        select=False,
    )
