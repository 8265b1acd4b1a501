"""Rows of the tests that every adjustment by points stores."""

from collections.abc import Sequence

import numpy as np

from orient.pipeline.tables import Array, or_none
from orient.solvers.critical_values import Limits, global_test
from orient.solvers.reliability import HARDLY, UNTESTED
from orient.solvers.snooping import IntArray, fit_probability
from orient.values import Row


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


def verdict(w: float, share: float, limits: Limits) -> str:
    """In words: can the observation be believed?"""
    return verdicts(np.array([w]), np.array([share]), limits)[0]


def verdicts(w: Array, share: Array, limits: Limits) -> list[str]:
    """`verdict` of each."""
    cases = [share <= UNTESTED, np.abs(w) > limits.critical, share < HARDLY]
    return [str(word) for word in np.select(cases, ["not checked", "suspect", "hardly checked"], "good")]


def point_rows(
    part: str, names: Sequence[str], T: Array, freedom: IntArray, redundancy: int, limits: Limits
) -> list[Row]:
    """All coordinates of a reading together."""
    chance = _probability(T, freedom, redundancy, limits)
    return [
        {
            "part": part,
            "point": name,
            "statistic": or_none(T[i]),
            "freedom": int(freedom[i]),
            "probability": or_none(chance[i]),
        }
        for i, name in enumerate(names)
    ]


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
