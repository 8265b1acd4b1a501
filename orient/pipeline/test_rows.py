"""Rows of the tests that every adjustment by points stores."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.pipeline.tables import Array, nullable, or_none
from orient.solvers.critical_values import Limits, global_test
from orient.solvers.reliability import HARDLY, UNTESTED, BlockTests
from orient.solvers.snooping import IntArray, fit_probability
from orient.values import Columns, Row

MOST_CORRELATED = 400
MOST_EFFECTS = 1000
"""Observations, the most suspicious or most harmful first, whose correlations and effects are stored; all of small
photos, while the cost stays linear for large ones."""
Observation = tuple[int, int, int]
"""Group, block and place within the block."""


@dataclass(frozen=True, slots=True)
class Shift:
    """Largest shift on the ground [m] by the smallest findable error of an observation, and where it happens."""

    metres: float
    point: str | None


def adjustment_row(
    part: str, component: str, vPv: float, redundancy: int, sigma0_known: float | None, limits: Limits
) -> Row:
    """The global test, where sigma0 is known, and the test of the single observations."""
    row: dict[str, str | int | float | None] = {
        "part": part,
        "component": component,
        "redundancy": redundancy,
        "sigma0_known": sigma0_known,
        **dict.fromkeys(("statistic", "lower", "upper", "probability")),
        "verdict": "no redundancy" if redundancy == 0 else None,
        "test": limits.name,
        "sigma0": limits.sigma0,
        "critical": or_none(limits.critical),
        "delta0": or_none(limits.delta0),
    }
    if redundancy and sigma0_known:
        test = global_test(vPv, redundancy, sigma0_known)
        numbers = {"statistic": test.statistic, "lower": test.lower, "upper": test.upper}
        row |= {**numbers, "probability": test.probability, "verdict": test.verdict}
    return row


def observation_row(
    head: Row,
    test: BlockTests,
    place: tuple[int, int],
    v: float,
    shift: Shift,
    near: tuple[float | None, str | None],
    limits: Limits,
) -> Row:
    """One row of observation_test; `head` names the observation, `near` is |rho_w| and the other point."""
    return {
        **head,
        "v": v,
        "redundancy_number": float(test.redundancy[place]),
        "share": float(test.share[place]),
        "w": or_none(test.w[place]),
        "smallest_error": or_none(test.mdb[place]),
        "bias_to_noise": or_none(test.bias_to_noise[place]),
        "ground_shift_m": or_none(shift.metres),
        "ground_shift_point": shift.point,
        "rho": near[0],
        "rho_with": near[1],
        "verdict": verdict(float(test.w[place]), float(test.share[place]), limits),
    }


def largest_places(values: Sequence[Array], most: int) -> list[Observation]:
    """Places of the largest finite values of all groups."""
    sizes = np.concatenate([np.ravel(value) for value in values])
    order = np.argsort(-np.where(np.isfinite(sizes), sizes, -np.inf), kind="stable")[:most]
    firsts = np.cumsum([0, *(value.size for value in values)])
    found: list[Observation] = []
    for place in order[np.isfinite(sizes[order])].tolist():
        group = int(np.searchsorted(firsts, place, side="right")) - 1
        block, k = divmod(place - int(firsts[group]), values[group].shape[1])
        found.append((group, block, k))
    return found


def verdict(w: float, share: float, limits: Limits) -> str:
    """In words: can the observation be believed?"""
    return verdicts(np.array([w]), np.array([share]), limits)[0]


def verdicts(w: Array, share: Array, limits: Limits) -> list[str]:
    """`verdict` of each."""
    cases = [share <= UNTESTED, np.abs(w) > limits.critical, share < HARDLY]
    return [str(word) for word in np.select(cases, ["not checked", "suspect", "hardly checked"], "good")]


def point_rows(
    part: str, names: Sequence[str], T: Array, freedom: IntArray, redundancy: int, limits: Limits
) -> Columns:
    """All coordinates of a reading together."""
    return Columns(
        {
            "part": [part] * len(names),
            "point": list(names),
            "statistic": nullable(T),
            "freedom": freedom.tolist(),
            "probability": nullable(_probability(T, freedom, redundancy, limits)),
        }
    )


def _probability(T: Array, freedom: IntArray, redundancy: int, limits: Limits) -> Array:
    """With estimated sigma0 the point itself is taken out of it first: F of the rest."""
    if limits.name == "w":
        return fit_probability(T, freedom, redundancy, limits)
    rest = redundancy - freedom
    share = (redundancy - T) / np.maximum(rest, 1)
    freed = np.where((rest > 0) & (share > 0), T / np.where(share > 0, share, 1.0), np.nan)
    probability = np.full(len(T), np.nan)
    for count in np.unique(rest[rest > 0]).tolist():
        alike = rest == count
        probability[alike] = fit_probability(freed[alike], freedom[alike], count, limits)
    return probability
