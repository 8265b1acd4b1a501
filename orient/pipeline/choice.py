"""Which points carry an adjustment: all but those left out by hand, by robust estimation and by data snooping."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic

import numpy as np
from numpy.typing import NDArray

from orient.pipeline.tables import Array
from orient.solvers.critical_values import Limits, chance
from orient.solvers.reliability import Blocks, Reliability, most_correlated
from orient.solvers.snooping import MOST_PROPOSALS, MOST_ROUNDS, Adjusted, Decision, Verdicts, snoop
from orient.values import Settings

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Choice(Generic[Adjusted]):
    """Points (n,) that take part, those that robust estimation left out, the steps of the snooping.

    `decisions` were carried out with --reject, else they are proposals; `tested` is the adjustment of the points that
    take part with its tests, None when they have no result.
    """

    kept: Mask
    by_robust: list[int]
    decisions: tuple[Decision, ...]
    tested: Adjusted | None


def choose_points(
    start: Mask,
    settings: Settings,
    verdicts: Callable[[Mask, Adjusted | None], Verdicts[Adjusted] | None],
    agreeing: Callable[[Mask], Mask],
) -> Choice[Adjusted]:
    """From the points `start` that nobody left out by hand: robust estimation and snooping as the settings ask.

    `verdicts` adjusts and tests some of the points, for a proposal perhaps from the adjustment of all, `agreeing` finds
    those that agree. Without `reject` all points that robust estimation kept stay. RobustFailed when no set agrees.
    """
    robust: list[int] = []
    if settings["robust"]:
        consensus = agreeing(start)
        robust = np.flatnonzero(start & ~consensus).tolist()
        start = consensus
    is_rejecting = bool(settings["reject"])
    snooped = snoop(verdicts, start, MOST_ROUNDS if is_rejecting else MOST_PROPOSALS, keep_last=is_rejecting)
    if snooped is None:
        return Choice(start, robust, (), None)
    if is_rejecting:
        return Choice(snooped.kept, robust, snooped.decisions, snooped.last.adjusted)
    return Choice(start, robust, snooped.decisions, snooped.first.adjusted)


def point_verdicts(
    adjusted: Adjusted,
    redundancy: int,
    points: Blocks,
    reliability: Reliability,
    limits: Limits,
    inside: Sequence[int],
    probability: Array,
) -> Verdicts[Adjusted]:
    """What the tests say of n points: `points` are the blocks of those `inside`, the first group of the tests.

    `probability` (n,): chance of the misfit of those that took no part.
    """
    n = len(probability)
    w = np.nan_to_num(np.abs(reliability.tests[0].w), nan=0.0)
    statistic = np.full(n, np.nan)
    freedom, worst = np.zeros(n, dtype=np.int64), np.full(n, -1)
    at = list(inside)
    statistic[at], freedom[at], worst[at] = w.max(axis=1), points.freedom, np.argmax(w, axis=1)

    def twin(point: int) -> tuple[int, float] | None:
        place = (0, at.index(point), int(worst[point]))
        nearest = most_correlated(reliability.tests, [place], only_group=0).get(place)
        return None if nearest is None else (at[nearest.partner[1]], nearest.rho)

    return Verdicts(adjusted, redundancy, statistic, worst, limits.critical, freedom, probability, twin)


def surprise(reliability: Reliability, limits: Limits, redundancy: int) -> float:
    """Chance that any test of an adjustment without gross errors is as large as the largest one (Bonferroni)."""
    w = [np.abs(test.w[test.is_tested]) for test in reliability.tests]
    largest = max((float(values.max(initial=0.0)) for values in w), default=0.0)
    tests = sum(len(values) for values in w)
    return min(1.0, tests * chance(largest, limits, redundancy)) if largest else 1.0
