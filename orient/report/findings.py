"""Findings first: what is wrong, what to do about it, and whether the result can be used, in plain words."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

from orient.pipeline.registry import REMEDY
from orient.report.text import console, one_line, printable
from orient.values import Event, Severity

if TYPE_CHECKING:
    from rich.console import Console

    from orient.store.project import Project, RunInfo

MARKS: Mapping[Severity, str] = {"error": "error", "warning": "warning", "info": "note"}
RANKS: Mapping[Severity, int] = {"error": 0, "warning": 1, "info": 2}
UNUSED_DATA = ("no_control", "not_measured", "not_in_model")
"""Told after the other problems: they cost accuracy, they spoil nothing."""
SHOWN, SHOWN_OF_A_KIND = 12, 3

REMEDIES = {
    "ambiguous": "Give an approximate station in photo.toml, or measure one more control point.",
    "ambiguous_model": "Give one more height in the model, off the line of the full control points.",
    "bad_cross": "Look at this cross: read it again, correct its coordinates, or mark it as a check.",
    "bad_mark": "Read this fiducial mark again, or compare it with the camera's certificate.",
    "ballpark": "Install the datum's grid, or accept the stated loss of accuracy.",
    "cycle_outlier": "Read the point again, or compute without such readings: --reject.",
    "exchange": "Exchange them in the list, or correct the handedness or the sign of the image's x.",
    "far_point": "Correct its coordinates, or leave it out of the control.",
    "fiducials_unused": "Give the calibrated marks in photo.toml, or leave their readings out.",
    "fiducial_unmatched": "Give the mark the same name in photo.toml and in the readings.",
    "hardly_checked": "Measure more control near these points; until then nothing would show an error in them.",
    "level_ray": "Do not use ground places of this point: the ray hardly meets the ground.",
    "masked": "--robust starts from the points that agree; --test w tests with the sigma0 given, not with that found.",
    "mirror": "Give an approximate station, or a control point off the plane.",
    "mirrored": "Check the directions of the axes (x_axis, y_axis; handedness of the ground).",
    "no_control": "Give these points coordinates, or read past this if they are meant as new points.",
    "no_coordinates": "Digitise the point, or give its coordinates in control.csv.",
    "no_redundancy": "Measure at least one more control point: nothing checks this result.",
    "not_in_model": "Measure these points in the model, or read past this if they are not meant to be there.",
    "not_measured": "Measure these points on the photo, or read past this if they are not visible.",
    "not_checked": "Measure more control: an error in these points goes into the result unseen.",
    "not_separable": "Measure both points again; then leave one out: --exclude POINT --reason TEXT.",
    "odd_point": "Look at this point first: wrong coordinates, a wrong identification, or a swapped name.",
    "poor_fit": "Look at the named point first, then at the units of control and model.",
    "robust": "See who and why: orient sql PROJECT excluded.",
    "singular": "Add control off the line or plane of the others.",
    "suspect": "Look at the point first; leave it out with --reject or --exclude POINT --reason TEXT; many: --robust.",
    "upside_down": "Check the axes of the model; --upside-down if the model really hangs.",
    "weak_geometry": "Add control where the named combination of unknowns can be seen.",
}
"""What a user can do, by the code of the finding; a finding without an entry says it itself."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing a reader must know before any number."""

    severity: Severity
    stage: str
    code: str
    subject: str
    message: str
    remedy: str

    @property
    def is_problem(self) -> bool:
        """Does it put the result in doubt? Data that were left out do not."""
        return self.severity != "info" and self.code not in UNUSED_DATA


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether there is a result, whether it is of today's inputs, and how many problems it has."""

    word: str
    sentence: str


def findings(stage: str, events: Iterable[Event]) -> list[Finding]:
    """Findings of one run, the grave ones first; the refusal itself is told as the run's error."""
    told = [
        Finding(event.severity, stage, event.code, event.subject, event.message, REMEDIES.get(event.code, ""))
        for event in events
        if event.code not in ("refused", REMEDY)
    ]
    return grave_first(told)


def remedy_of(events: Iterable[Event]) -> str:
    """What to do about a failed run, as it said itself; empty if it said nothing."""
    return next((event.message for event in events if event.code == REMEDY), "")


def later_failures(project: "Project") -> list[Finding]:
    """Stages whose last version failed while an older one is current, and nobody chose that one since then."""
    last = {run.stage: run for run in project.runs()}
    chosen = {str(stage): str(when) for stage, when in project.query("SELECT stage, selected_at FROM v_current")[1]}
    heads = project.heads()
    return [
        Finding("warning", name, "later_failure", "", *_later(last[name], heads[name].version))
        for name in heads
        if last[name].status == "failed" and chosen[name] < last[name].started_at
    ]


def _later(failed: "RunInfo", current: int) -> tuple[str, str]:
    """What failed, and how to look at it or to settle that the older version stays."""
    why = failed.error.rstrip(".")
    message = f"version {failed.version} failed later: {why}; version {current} is still the current one"
    stage = failed.stage
    return message, (
        f"See it: orient show PROJECT {stage} --version {failed.version}; keep the older one: "
        f"orient select PROJECT {stage} {current} -m why."
    )


def grave_first(found: Iterable[Finding]) -> list[Finding]:
    return sorted(found, key=lambda finding: (RANKS[finding.severity], finding.code in UNUSED_DATA))


def verdict(states: Mapping[str, str], found: Sequence[Finding], results: Sequence[str]) -> Verdict:
    """From the state of each stage (current, stale, failed, ...) and the findings of what is current.

    `results`: the stages that may hold the final result, the first one that exists counts.
    """
    failed = [stage for stage, state in states.items() if state == "failed"]
    stale = [stage for stage, state in states.items() if state in ("stale", "to compute")]
    problems = sum(finding.is_problem for finding in found)
    if failed:
        return Verdict("failed", f"No valid result: {', '.join(failed)} failed.")
    if not any(states.get(stage) in ("current", "stale") for stage in results):
        return Verdict("incomplete", "Not oriented yet.")
    if stale:
        return Verdict("stale", f"The result is out of date: {', '.join(stale)}.")
    if problems:
        what = "a problem: read it" if problems == 1 else f"{problems} problems: read them"
        return Verdict("doubtful", f"Oriented, but with {what} before you use a number.")
    left_out = any(finding.code in UNUSED_DATA for finding in found)
    return Verdict("good", "Oriented; no problem was found" + (", but not all data are used." if left_out else "."))


def as_json(found: Sequence[Finding]) -> list[dict[str, str]]:
    return [asdict(finding) for finding in found]


def print_findings(
    found: Sequence[Finding], indent: str = "  ", *, with_stage: bool = False, out: "Console | None" = None
) -> None:
    """Problems with what to do, then notes; many findings of one kind are told once, with a count.

    `out`: the console that a moving line lives on; only it knows how to write above that line.
    """
    out = out or console()
    shown = folded(found)
    for finding, count in shown[:SHOWN]:
        more = f" (and {count - 1} more of this kind)" if count > 1 else ""
        place = f"{finding.stage}: " if with_stage else ""
        text = f"{indent}{MARKS[finding.severity]}: {place}{one_line(finding.message)}{more}"
        out.print(text, soft_wrap=True)
        if finding.remedy:
            out.print(f"{indent}  -> {printable(finding.remedy)}", soft_wrap=True)
    if len(shown) > SHOWN:
        out.print(f"{indent}... and {len(shown) - SHOWN} more: orient sql PROJECT events")


def folded(found: Sequence[Finding]) -> list[tuple[Finding, int]]:
    """The first few findings of each stage and code; the last of them stands for the rest, whose number it gets."""
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in found:
        kinds.setdefault((finding.stage, finding.code), []).append(finding)
    kept = []
    for alike in kinds.values():
        shown = alike[:SHOWN_OF_A_KIND]
        kept += [(finding, 1) for finding in shown[:-1]]
        kept.append((shown[-1], 1 + len(alike) - len(shown)))
    return kept
