"""The numbers of one project that go into the summary, read from its current versions, unrounded and unchanged."""

import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from orient.batch.values import Ending
from orient.errors import OrientError
from orient.pipeline.registry import is_optional
from orient.report.status import Standing, standing
from orient.values import Row, Scalar

if TYPE_CHECKING:
    from orient.pipeline.runner import Result
    from orient.store.project import Project, RunInfo

PHOTO = "SELECT name, platform FROM photo WHERE run_id = ?"
ORIENTATION = """
SELECT frame, X_S_m, Y_S_m, Z_S_m, B_S_deg, L_S_deg, H_S_m, q_w, q_x, q_y, q_z, f_mm, n_control, n_equations,
       n_unknowns, redundancy, sigma0_mm, sigma0_apriori_mm, variance_basis, variance_scale, iterations, termination
FROM orientation WHERE run_id = ?
"""
ANGLES = """
SELECT angle, value_deg, sigma_deg FROM orientation_angle WHERE run_id = ? AND triple = 'aok' AND frame = 'ground'
"""
COFACTORS = """
SELECT unknowns, i, j, unknown_i, unknown_j, value FROM cofactor
WHERE run_id = ? AND unknowns IN ('aok', 'rotation') AND i <= 6 AND j <= 6 ORDER BY unknowns, i, j
"""
RESIDUALS = """
SELECT count(*), sum(vx_mm * vx_mm), sum(vy_mm * vy_mm) FROM image_residual WHERE run_id = ? AND role = 'control'
"""
COUNT_OF = {"error": "n_errors", "warning": "n_warnings", "info": "n_notes"}
STATION = ("X_S", "Y_S", "Z_S")


def ending_of(project: "Project", path: str, results: "Sequence[Result]") -> Ending:
    """What the summary keeps of an open project after its run; one moment of the file."""
    with project.snapshot():
        status, heads = standing(project), project.heads()
        numbers: dict[str, Scalar] = {"verdict": status.verdict.word, "sentence": status.verdict.sentence}
        numbers |= _counts(status) | {"n_computed": sum(result.computed for result in results)}
        if "photo" in heads:
            ((numbers["photo"], numbers["platform"]),) = project.query(PHOTO, (heads["photo"].run_id,))[1]
        covariances: list[Row] = []
        if _is_current(status, "resection"):
            head = heads["resection"]
            numbers |= _orientation(project, head) | {"resection_version": head.version}
            covariances = list(_covariances(project, head, numbers))
            numbers |= _station_sigmas(covariances)
    stages, findings = list(_stages(status, heads, results)), list(_findings(status))
    ending = Ending(path, 0, "", "", _in_small_letters(numbers), covariances, stages, findings)
    if refusal := _refusal(status, results):
        return replace(ending, exit_code=refusal.exit_code, message=refusal.message, hint=refusal.hint)
    return ending


def _refusal(status: Standing, results: "Sequence[Result]") -> OrientError | None:
    """What `orient run` says when a stage fails; a photo that is not oriented has no result either."""
    for result in results:
        if result.failed and result.run:
            return OrientError(f"{result.stage}: {result.run.error}", result.hint)
    if status.verdict.word != "incomplete":
        return None
    waiting = [one for one in results if one.waits_for and not is_optional(one.stage, one.waits_for)]
    what = ", ".join(f"{one.stage} waits for {one.waits_for}" for one in waiting[:1])
    return OrientError(f"not oriented: {what}", "Add what is missing: orient add PROJECT LIST FILE")


def _is_current(status: Standing, stage: str) -> bool:
    return any((entry["stage"], entry["state"]) == (stage, "current") for entry in status.stages)


def _counts(status: Standing) -> dict[str, Scalar]:
    severities = Counter(finding.severity for finding in status.findings)
    return {column: severities[severity] for severity, column in COUNT_OF.items()}  # type: ignore[index]


def _orientation(project: "Project", head: "RunInfo") -> dict[str, Scalar]:
    answer = project.query(ORIENTATION, (head.run_id,))
    numbers: dict[str, Scalar] = dict(zip(answer[0], answer[1][0], strict=True))
    for angle, value, sigma in project.query(ANGLES, (head.run_id,))[1]:
        numbers |= {f"{angle}_deg": value, f"sigma_{angle}_deg": sigma}
    ((count, xx, yy),) = project.query(RESIDUALS, (head.run_id,))[1]
    if count:
        numbers |= {"rms_x_mm": math.sqrt(xx / count), "rms_y_mm": math.sqrt(yy / count)}
    return numbers


def _covariances(project: "Project", head: "RunInfo", numbers: Row) -> Iterator[Row]:
    """The upper triangle of both 6 x 6 matrices: covariance = variance_scale x cofactor."""
    scale = float(numbers["variance_scale"] or 0.0)
    for unknowns, i, j, unknown_i, unknown_j, cofactor in project.query(COFACTORS, (head.run_id,))[1]:
        yield {
            "unknowns": unknowns, "i": i, "j": j, "unknown_i": unknown_i, "unknown_j": unknown_j,
            "cofactor": cofactor, "covariance": scale * float(cofactor),
        }  # fmt: skip


def _station_sigmas(covariances: Sequence[Row]) -> dict[str, Scalar]:
    variances = {row["unknown_i"]: row["covariance"] for row in covariances if row["i"] == row["j"]}
    return {f"sigma_{name}_m": math.sqrt(float(variances[name] or 0.0)) for name in STATION if name in variances}


def _stages(status: Standing, heads: "dict[str, RunInfo]", results: "Sequence[Result]") -> Iterator[Row]:
    """The current version of each stage, or what failed, with its digests."""
    ran = {result.stage: result for result in results}
    for place, entry in enumerate(status.stages):
        name = str(entry["stage"])
        result = ran.get(name)
        run = result.run if result and result.failed else heads.get(name)
        yield {
            "place": place,
            "stage": name,
            "state": str(entry["state"]),
            "version": run.version if run else None,
            "stage_version": run.stage_version if run else None,
            "is_computed": int(bool(result and result.computed)),
            "settings": json.dumps(run.settings) if run else None,
            "input_digest": run.input_digest if run else None,
            "output_digest": run.output_digest if run else None,
            "tool_version": run.tool_version if run else None,
            "told": str(entry["told"]),
        }


def _findings(status: Standing) -> Iterator[Row]:
    """How often each kind of finding is told, with its first message."""
    counts = Counter((finding.stage, finding.code, finding.severity) for finding in status.findings)
    first = {(finding.stage, finding.code, finding.severity): finding for finding in reversed(status.findings)}
    for kind, count in counts.items():
        told = first[kind]
        yield {
            "stage": told.stage, "code": told.code, "severity": told.severity, "n": count,
            "subject": told.subject, "message": told.message,
        }  # fmt: skip


def _in_small_letters(numbers: Row) -> dict[str, Scalar]:
    """Column names that no database has to quote."""
    return {name.lower(): value for name, value in numbers.items()}
