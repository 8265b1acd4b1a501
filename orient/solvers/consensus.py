"""Least trimmed squares: the orientation on which most points agree, whatever the others say.

sum of the h smallest misfits -> min. It survives as many gross errors as there are points left out, whatever their
size; data snooping, which goes one by one from the full adjustment, can be misled by two. It knows nothing of the
adjustment: `misfits` computes it on a few points and says how all points fit.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtr, chdtri, comb

from orient.errors import OrientError
from orient.solvers.critical_values import ALPHA0
from orient.solvers.snooping import Adjusted, Verdicts

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

BREAKDOWN = 0.4
"""Largest share of wrong points that a consensus may have; with more, another set of points could agree by chance."""
LARGEST_SCALE = 5.0
"""sigma0 of the agreeing points, in units of that a priori, above which they do not agree."""
SAMPLES = 120
BEST_SAMPLES = 6
STEPS = 10
MOST_ROUNDS = 30


class RobustFailed(OrientError):
    """Too many points contradict each other: no set of at least 60 % of them agrees."""

    def __init__(self, why: str) -> None:
        super().__init__(
            f"ROBUST_FAILED: {why}",
            "Check point names, axes, f and the coordinate system; then exclude the points that you know are wrong.",
        )


@dataclass(frozen=True, slots=True)
class Trimmed:
    """The h points that agree best, and their sigma0 in units of that a priori, freed of the trimming."""

    agreeing: BoolArray
    scale: float


def trimmed_size(n: int, needed: int) -> int:
    """h = n - floor(0.4 n), at least `needed`: points that must agree."""
    return max(n - int(BREAKDOWN * n), needed)


def samples(candidates: Sequence[int], size: int, most: int = SAMPLES) -> Iterator[tuple[int, ...]]:
    """All subsets of `size` of the candidates, or `most` random ones, the same in every run."""
    if comb(len(candidates), size) <= most:
        yield from combinations(candidates, size)
        return
    random = np.random.default_rng(len(candidates))
    for _ in range(most):
        yield tuple(sorted(random.choice(candidates, size, replace=False).tolist()))


def least_trimmed(
    starts: Sequence[FloatArray],
    freedom: NDArray[np.int64],
    unknowns: int,
    needed: int,
    misfits: Callable[[BoolArray], FloatArray | None],
) -> Trimmed:
    """min over the adjustments of the sum of the h smallest T_i, T_i the weighted squared misfit of a point.

    `starts`: misfits (n,) of all points to solutions of minimal samples, in units of sigma0^2 a priori; `freedom` (n,)
    of each T_i; `unknowns` of the adjustment, `needed` points for it with a check; `misfits` (mask): T of all points at
    the adjustment on the masked ones. From the best starts, the h best points are adjusted and chosen again until they
    stay the same. Raises RobustFailed where they agree to no better than five sigma0 a priori.
    Source: P. Rousseeuw 1984; concentration steps: Rousseeuw and Van Driessen 2006.
    """
    n = len(freedom)
    h = trimmed_size(n, needed)
    if n < h or not starts:
        raise RobustFailed(f"{n} points are too few to find wrong ones among them; {needed} must agree")
    ranked = sorted(starts, key=lambda T: float(np.sort(T)[h - 1]))
    known: dict[bytes, FloatArray | None] = {}

    def remembered(chosen: BoolArray) -> FloatArray | None:
        if (key := chosen.tobytes()) not in known:
            known[key] = misfits(chosen)
        return known[key]

    ends = [_concentrated(T, h, remembered) for T in _distinct(ranked, h)]
    found = [end for end in ends if end is not None and np.isfinite(end[0])]
    if not found:
        raise RobustFailed(f"no {h} of the {n} points determine a solution together")
    total, agreeing = min(found, key=lambda end: end[0])
    scale = _scale(total, float(np.mean(freedom)), h, n, unknowns)
    if scale > LARGEST_SCALE:
        raise RobustFailed(
            f"the {h} of {n} points that agree best do so to {scale:.3g} times the sigmas given, at most "
            f"{LARGEST_SCALE:g} times is a consensus; more than {100 * BREAKDOWN:.0f} % of the points may be wrong"
        )
    return Trimmed(agreeing, max(scale, 1.0))


def all_agreeing(
    judge: Callable[[BoolArray], Verdicts[Adjusted] | None], trimmed: Trimmed, candidates: BoolArray
) -> BoolArray:
    """The agreeing points and all other `candidates` that fit their solution: taken in or out until nothing changes.

    `judge` tests with known sigma0, `trimmed.scale` times that a priori. Raises RobustFailed when more than 40 % of
    the candidates stay outside.
    """
    kept, seen = trimmed.agreeing, set()
    for _ in range(MOST_ROUNDS):
        seen.add(kept.tobytes())
        look = judge(kept)
        if look is None:
            raise RobustFailed("the points that agree do not determine a solution")
        following = _next(look, kept, candidates)
        if following.tobytes() in seen:
            break
        kept = following
    outside, n = int(np.count_nonzero(candidates & ~kept)), int(np.count_nonzero(candidates))
    if outside > BREAKDOWN * n:
        raise RobustFailed(f"{outside} of {n} points contradict the others, more than {100 * BREAKDOWN:.0f} %")
    return kept


def _next(look: Verdicts[Adjusted], kept: BoolArray, candidates: BoolArray) -> BoolArray:
    fits = candidates & ~kept & (np.nan_to_num(look.probability, nan=0.0) > ALPHA0)
    if fits.any():
        return kept | fits
    statistic = np.where(kept, np.nan_to_num(look.statistic, nan=0.0), 0.0)
    worst = int(np.argmax(statistic))
    following = kept.copy()
    following[worst] = not statistic[worst] > look.critical
    return following


def _distinct(ranked: Sequence[FloatArray], h: int) -> list[FloatArray]:
    """The best starts whose h best points differ."""
    kept: dict[bytes, FloatArray] = {}
    for T in ranked:
        kept.setdefault(_smallest(T, h).tobytes(), T)
        if len(kept) == BEST_SAMPLES:
            break
    return list(kept.values())


def _concentrated(
    T: FloatArray, h: int, misfits: Callable[[BoolArray], FloatArray | None]
) -> tuple[float, BoolArray] | None:
    """Adjustment on the h best points, again and again: the sum of the h smallest T never grows."""
    chosen = _smallest(T, h)
    for _ in range(STEPS):
        following = misfits(chosen)
        if following is None:
            return None
        T, before = following, chosen
        chosen = _smallest(T, h)
        if (chosen == before).all():
            break
    return float(np.sum(np.sort(T)[:h])), chosen


def _smallest(T: FloatArray, h: int) -> BoolArray:
    chosen = np.zeros(len(T), dtype=np.bool_)
    chosen[np.argsort(T, kind="stable")[:h]] = True
    return chosen


def _scale(total: float, freedom: float, h: int, n: int, unknowns: int) -> float:
    """sigma0 of the h smallest of n: their mean is that of a chi^2 cut off at the share h/n."""
    share = h / n
    cut = 1.0 if h == n else float(chdtr(freedom + 2, chdtri(freedom, 1.0 - share))) / share
    return float(np.sqrt(total / (cut * max(freedom * h - unknowns, 1.0))))
