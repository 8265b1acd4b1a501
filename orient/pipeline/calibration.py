"""Self-calibration by steps: one element of the camera after the other, while it is significant and separable."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from orient.geometry.camera import INTERIOR
from orient.pipeline.tables import Array, or_none
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.resection import Resection
from orient.values import Event, Row

ALPHA = 0.01
LIMIT = 0.95
LOWER = {"k2": "k1", "k3": "k2"}
SMALLEST_CONDITION = 1e-4
"""Smallest to largest singular value: below, an element is taken apart by rounding rather than by the photo."""

Rename = Callable[[str], str]
Solve = Callable[[CameraUnknowns, tuple[Array, Array] | None], Resection]
AddElement = Callable[[CameraUnknowns, str], CameraUnknowns]


@dataclass(frozen=True, slots=True)
class Judged:
    """One candidate in one step; `decision` is empty when it could be taken."""

    name: str
    unknowns: CameraUnknowns
    found: Resection
    value: float
    sigma: float
    t: float
    t_limit: float
    correlation: float
    partner: str
    decision: str
    reason: str


@dataclass(frozen=True, slots=True)
class Calibration:
    """The elements that were taken, the rows of `calibration_step`, and what to say."""

    unknowns: CameraUnknowns
    rows: Sequence[Row]
    events: Sequence[Event]


def calibrate(
    begin: CameraUnknowns,
    first: Resection,
    solve: Solve,
    add: AddElement,
    candidates: Sequence[str],
    sigma0: float,
    rename: Rename,
) -> Calibration:
    """In each step every candidate is tried beside those taken; the one with the largest |t| / limit is taken.

    `first`: the resection with `begin`; `rename`: the solver's words in those of the stored frame. A candidate must be
    significant (two-sided Student test at 1 %) and separable: no correlation with another unknown from 0.95, condition
    ratio at least 1e-4. k2 is tried after k1 and k3 after k2. Ends when none is left that is both.
    """
    unknowns, found = begin, first
    rows: list[Row] = []
    last: dict[str, Judged] = {}
    for step in range(1, len(candidates) + 1):
        left = [name for name in candidates if name not in unknowns.names and _has_its_turn(name, unknowns)]
        tried = [judged(name, add(unknowns, name), solve, found, sigma0, rename) for name in left]
        good = [one for one in tried if not one.decision]
        best = max(good, key=lambda one: abs(one.t) / one.t_limit, default=None)
        rows += [_row(step, one, best) for one in tried]
        last |= {one.name: one for one in tried}
        if best is None:
            break
        unknowns, found = best.unknowns, best.found
    taken = [name for name in unknowns.names if name not in begin.names]
    return Calibration(unknowns, rows, _events(taken, last))


def _has_its_turn(name: str, unknowns: CameraUnknowns) -> bool:
    """A higher power means nothing without the lower one: it would stand for it."""
    before = LOWER.get(name)
    return before is None or before in unknowns.names or unknowns.camera.values((before,))[0] != 0


def judged(
    name: str, unknowns: CameraUnknowns, solve: Solve, before: Resection, sigma0: float, rename: Rename
) -> Judged:
    """The adjustment with one element more, begun where the one before ended."""
    found = solve(unknowns, (before.rotation, before.station))
    if found.termination != "CONVERGED":
        is_inseparable = "cannot be separated" in found.message
        decision = "not separable" if is_inseparable else "not solved"
        nan = float("nan")
        return Judged(name, unknowns, found, nan, nan, nan, nan, nan, "", decision, rename(found.message))
    place = unknowns.names.index(name)
    values = significance(found, unknowns, sigma0, use_posteriori=True)
    correlation, partner = strongest_correlation(found, 6 + place)
    partner = rename(partner)
    decision, reason = "", f"|t| {abs(values.t[place]):.1f} > {values.limit:.2f}"
    if not abs(values.t[place]) > values.limit:
        decision, reason = "not significant", f"|t| {abs(values.t[place]):.1f} is not above {values.limit:.2f}"
    elif abs(correlation) >= LIMIT:
        decision, reason = "not separable", f"correlation {correlation:+.3f} with {partner}"
    elif found.condition_ratio < SMALLEST_CONDITION:
        decision, reason = "not separable", f"condition ratio {found.condition_ratio:.1e}"
    return Judged(
        name, unknowns, found, float(found.camera[place]), float(values.sigma[place]), float(values.t[place]),
        values.limit, correlation, partner, decision, reason,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Significance:
    """Standard deviations and t = correction / sigma (m,) of the camera's elements, and the limit of |t|."""

    sigma: Array
    t: Array
    limit: float


def significance(found: Resection, unknowns: CameraUnknowns, sigma0: float, use_posteriori: bool) -> Significance:
    """t against Student's law with r degrees of freedom, or the normal law with sigma0 a priori."""
    by_residuals = use_posteriori and found.redundancy > 0
    scale = found.vPv / found.redundancy if by_residuals else sigma0**2
    sigma = np.sqrt(scale * np.diagonal(found.Q)[6:])
    with np.errstate(divide="ignore", invalid="ignore"):
        t = (found.camera - unknowns.apriori) / sigma
    limit = stdtrit(found.redundancy, 1 - ALPHA / 2) if by_residuals else ndtri(1 - ALPHA / 2)
    return Significance(sigma, t, float(limit))


def strongest_correlation(found: Resection, place: int) -> tuple[float, str]:
    """With which other unknown this one is correlated most, by the solver's name."""
    sigma = np.sqrt(np.diagonal(found.Q))
    correlations = found.Q[place] / (sigma[place] * np.where(sigma == 0, np.inf, sigma))
    correlations[place] = 0.0
    partner = int(np.argmax(np.abs(correlations)))
    return float(correlations[partner]), found.unknowns[partner]


def candidates_of(unknowns: CameraUnknowns) -> list[str]:
    """Everything that can be estimated of this camera and is not yet."""
    lens = unknowns.camera.distortion
    without = ("k1", "k2", "k3", "p1", "p2") if lens.model == "radial_table" else ()
    return [name for name in INTERIOR if name not in without and name not in unknowns.names]


def _row(step: int, one: Judged, best: Judged | None) -> Row:
    decision, reason = one.decision, one.reason
    if not decision:
        is_best = one is best
        decision = "taken" if is_best else "less significant"
        reason = one.reason if is_best or best is None else f"{one.reason}, but {best.name} is more significant"
    solved = one.found.termination == "CONVERGED"
    has_sigma0 = solved and one.found.redundancy > 0
    return {
        "step": step,
        "unknown": one.name,
        "decision": decision,
        "value": or_none(one.value),
        "sigma": or_none(one.sigma),
        "t": or_none(one.t),
        "t_limit": or_none(one.t_limit),
        "correlation": or_none(one.correlation),
        "correlated_with": one.partner or None,
        "sigma0_mm": (one.found.vPv / one.found.redundancy) ** 0.5 if has_sigma0 else None,
        "condition_ratio": or_none(one.found.condition_ratio) if solved else None,
        "reason": reason,
    }


def _events(taken: Sequence[str], last: dict[str, Judged]) -> list[Event]:
    """One remark: what was taken, and why each of the others was not."""
    told = [f"calibration took {', '.join(taken)}" if taken else "calibration took no element"]
    others = [one for one in last.values() if one.name not in taken]
    for decision in dict.fromkeys(one.decision for one in others):
        told.append(f"{decision}: {', '.join(_short(one) for one in others if one.decision == decision)}")
    return [Event("info", "calibration", ", ".join(taken), "; ".join(told), float(len(taken)))]


def _short(one: Judged) -> str:
    """`k2 (t 1.7)`, `f (with Z_S)`: the row of `calibration_step` says it in full."""
    if one.decision == "not significant":
        return f"{one.name} (t {abs(one.t):.1f})"
    return f"{one.name} (with {one.partner})" if one.partner else one.name
