"""Iterative data snooping: the worst point goes, the adjustment is repeated, those that left are tested again.

It knows nothing of the adjustment: `adjust` computes it without some points and tells what its tests say.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc

from orient.solvers.critical_values import ALPHA0, Limits

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

INSEPARABLE = 0.9
"""Correlation of two tests from which nothing tells which of the two is wrong."""
REDUNDANCY_LEFT = 2
"""Redundancy that snooping leaves: below it no test of a single observation with estimated sigma0 exists."""
MOST_ROUNDS, MOST_PROPOSALS = 200, 10
"""Rounds of a snooping that excludes, and of one that only proposes."""

Adjusted = TypeVar("Adjusted")


@dataclass(frozen=True, slots=True)
class Verdicts(Generic[Adjusted]):
    """What the tests of one adjustment say of n points.

    statistic    (n,) largest |w| or |tau| of the point's own observations; NaN where nothing is tested
    observation  (n,) which of the point's observations that is
    critical     limit of the statistic
    freedom      (n,) redundancy that the adjustment loses with the point
    probability  (n,) chance of so large a misfit of a point that takes no part; NaN for those that do
    twin         the point whose test goes most with that of a given point, and their |rho|; None without any
    """

    adjusted: Adjusted
    redundancy: int
    statistic: FloatArray
    observation: IntArray
    critical: float
    freedom: IntArray
    probability: FloatArray
    twin: Callable[[int], tuple[int, float] | None]


@dataclass(frozen=True, slots=True)
class Decision:
    """One step: `action` excluded, taken back, not separable (from `twin`), not removable (the rest is too weak)."""

    point: int
    action: str
    round: int
    statistic: float
    critical: float
    observation: int = -1
    twin: int | None = None
    rho: float | None = None


@dataclass(frozen=True, slots=True)
class Snooped(Generic[Adjusted]):
    """The points that stay, what was decided on the way, and the first and the last adjustment with their tests."""

    kept: BoolArray
    decisions: tuple[Decision, ...]
    first: Verdicts[Adjusted]
    last: Verdicts[Adjusted]


def snoop(
    adjust: Callable[[BoolArray, Adjusted | None], Verdicts[Adjusted] | None],
    start: BoolArray,
    most_rounds: int = MOST_ROUNDS,
    *,
    keep_last: bool = True,
) -> Snooped[Adjusted] | None:
    """Exclude the point with the largest |w| above its critical value, adjust again, until none is left.

    `adjust` (points that take part, adjustment to begin at or None) gives verdicts, None without a result. `start`
    (n,): the points at first; those outside were left out by others and are not tested again. Before each exclusion
    the points excluded so far are tested with the orientation of the others; one that fits it comes back. It ends
    without an exclusion when two suspects are not separable (|rho| > 0.9), when fewer than two redundant equations
    would stay, or when the rest does not determine the unknowns. None when the first adjustment has no result.
    Without `keep_last`, for who asks for proposals, only the first adjustment is kept, which `last` then repeats, and
    all later ones may begin at it.
    Source: W. Baarda 1968; iterative form e.g. H. Kok 1984.
    """
    first = look = adjust(start, None)
    if first is None or look is None:
        return None
    kept, decisions, seen = start.copy(), [], {start.tobytes()}
    for number in range(1, most_rounds + 1):
        decision = _decide(look, kept, start, number)
        if decision is None:
            break
        trial, leads_on = _without(kept, decision), decision.action in ("excluded", "taken back")
        if leads_on and trial.tobytes() in seen:
            break
        following = adjust(trial, None if keep_last else first.adjusted) if leads_on else None
        if following is None:
            decisions.append(_stopped(decision))
            break
        decisions.append(decision)
        kept, look = trial, following if keep_last else replace(following, adjusted=first.adjusted)
        following = None
        seen.add(trial.tobytes())
    return Snooped(kept, tuple(decisions), first, look)


def fit_probability(T: FloatArray, freedom: IntArray, redundancy: int, limits: Limits) -> FloatArray:
    """P(> T): T is chi^2 with `freedom`, or T / freedom is F(freedom, r) where sigma0 is estimated from the others."""
    if limits.name == "w":
        return np.asarray(chdtrc(freedom, T))
    return np.asarray(fdtrc(freedom, redundancy, T / np.maximum(freedom, 1)))


def _decide(look: Verdicts[Adjusted], kept: BoolArray, start: BoolArray, number: int) -> Decision | None:
    """The next step, or None when nothing is suspected."""
    fits = np.where(start & ~kept, np.nan_to_num(look.probability, nan=0.0), 0.0)
    back = int(np.argmax(fits))
    if fits[back] > ALPHA0:
        return Decision(back, "taken back", number, float(fits[back]), ALPHA0)
    statistic = np.where(kept, np.nan_to_num(look.statistic, nan=0.0), 0.0)
    worst = int(np.argmax(statistic))
    if not statistic[worst] > look.critical:
        return None
    found = Decision(worst, "excluded", number, float(statistic[worst]), look.critical, int(look.observation[worst]))
    twin = look.twin(worst)
    if twin is not None and twin[1] > INSEPARABLE and statistic[twin[0]] > look.critical:
        return replace(found, action="not separable", twin=twin[0], rho=twin[1])
    if look.redundancy - int(look.freedom[worst]) < REDUNDANCY_LEFT:
        return _stopped(found)
    return found


def _without(kept: BoolArray, decision: Decision) -> BoolArray:
    trial = kept.copy()
    trial[decision.point] = decision.action == "taken back"
    return trial


def _stopped(decision: Decision) -> Decision:
    """A suspect that stays, because without it the rest would be unchecked or undetermined."""
    if decision.action == "not separable":
        return decision
    return replace(decision, action="not removable")
