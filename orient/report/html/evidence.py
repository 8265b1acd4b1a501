"""What a report is made of: the runs that belong to one result, their rows, and what is said about them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from orient.pipeline.registry import ALL_STAGES, FINAL_STAGES, IMAGE
from orient.pipeline.registry import BY_NAME as COMPUTED
from orient.report.current import last_failure
from orient.report.findings import Finding, Verdict, findings, grave_first
from orient.report.html.blocks import Figure
from orient.report.html.inline_svg import inline
from orient.report.plots import BY_NAME, drawn, plot_data
from orient.report.rows import count_rows, read_rows
from orient.report.status import standing
from orient.store.project import Project, RunInfo
from orient.values import Row, Scalar


@dataclass(frozen=True, slots=True)
class Evidence:
    """`runs` by stage: the result and exactly what it was computed from, so that no section mixes versions."""

    project: Project
    runs: Mapping[str, RunInfo]
    all_runs: Sequence[RunInfo]
    heads: Mapping[str, RunInfo]
    verdict: Verdict
    findings: Sequence[Finding]
    failed: Sequence[tuple[str, str, str]]
    """Stages whose last run failed, why, and what to do about it."""
    verified: Sequence[Mapping[str, Scalar]]

    def rows(self, stage: str, table: str, columns: Sequence[str] = (), tail: str = "") -> list[Row]:
        """Rows of the run of a stage; none where there is no run."""
        if stage not in self.runs:
            return []
        return read_rows(self.project, self.runs[stage].run_id, table, columns, tail)

    def one(self, stage: str, table: str) -> Row | None:
        """The only row of a table, if it is there."""
        return next(iter(self.rows(stage, table)), None)

    def count(self, stage: str, table: str, condition: str = "1") -> int:
        return count_rows(self.project, self.runs[stage].run_id, table, condition) if stage in self.runs else 0

    @property
    def photo(self) -> Row | None:
        return self.one("photo", "photo")

    def figure(self, name: str, title: str, note: str = "", part: str = "") -> Figure:
        """A plot of the runs of this report; the tables it needs must be there."""
        plot = BY_NAME[name]
        extra = {stage: tables for stage, tables in plot.optional.items() if stage in self.runs}
        chosen = {stage: plot.one_of[stage] for stage in [s for s in plot.one_of if self._has_steps(s, part)][:1]}
        data = plot_data(self.project, self.runs, {**plot.tables, **chosen, **extra}, part)
        svg = drawn(name, data, "svg").decode("utf-8")
        return Figure(title, inline(svg, f"{name}-{part}" if part else name, title), note)

    def _has_steps(self, stage: str, part: str) -> bool:
        """A zone belongs to a model, everything else to the photo."""
        return stage in self.runs and (stage == "absolute") == bool(part)


def gather(project: Project) -> Evidence:
    """The evidence of one moment; call it inside a snapshot."""
    heads, every = project.heads(), project.runs()
    runs = _runs_of_result(heads, every)
    now = standing(project)
    no_result = [run for run in runs.values() if run.status == "failed"]
    found = [*now.findings, *(told for run in no_result for told in findings(run.stage, project.events(run.run_id)))]
    failed = [
        (str(entry["stage"]), str(entry["told"]), str(entry["remedy"]))
        for entry in now.stages
        if entry["state"] == "failed"
    ]
    return Evidence(project, runs, every, heads, now.verdict, grave_first(found), failed, now.verified)


def _runs_of_result(heads: Mapping[str, RunInfo], every: Sequence[RunInfo]) -> dict[str, RunInfo]:
    """The final results, then what they read, then the rest of what is current and contradicts none of it."""
    by_id = {run.run_id: run for run in every}
    chosen: dict[str, RunInfo] = {}
    for stage in FINAL_STAGES:
        _take(heads.get(stage) or _failed(stage, heads, every), by_id, chosen)
    for stage in (*reversed(ALL_STAGES), IMAGE):
        head = heads.get(stage)
        if head is None or any(chosen.get(by_id[i].stage, by_id[i]).run_id != i for i in head.inputs.values()):
            continue
        _take(head, by_id, chosen)
    return {stage: chosen[stage] for stage in (*ALL_STAGES, IMAGE) if stage in chosen}


def _take(run: RunInfo | None, by_id: Mapping[int, RunInfo], chosen: dict[str, RunInfo]) -> None:
    """A run and its inputs, the nearest first; what was taken before stays."""
    waiting = [] if run is None else [run]
    while waiting:
        run = waiting.pop(0)
        if run.stage in chosen:
            continue
        chosen[run.stage] = run
        waiting += [by_id[input_id] for input_id in run.inputs.values()]


def _failed(stage: str, heads: Mapping[str, RunInfo], every: Sequence[RunInfo]) -> RunInfo | None:
    """The last run of a stage that can still be computed, if it failed."""
    is_waiting = COMPUTED[stage].missing(set(heads))
    return None if is_waiting else last_failure([run for run in every if run.stage == stage])
