"""How far the stored result of an adjustment and the solution of a second engine agree.

Two engines that minimise the same v'Pv stop at the same place but for rounding: a millionth of a standard deviation is
allowed, which no use of a result could see. Programs of others stop earlier, and say so by what they are allowed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.pipeline.tables import Array

ALLOWED = 1e-6
SIGMAS, VALUE, BOTH_SIGMAS = "standard deviation", "value", "standard deviations of both unknowns"
TINY = 1e-300


@dataclass(frozen=True, slots=True)
class Agreement:
    """Largest difference of one kind of quantity between the stored result and the second engine."""

    engine: str
    subject: str
    quantity: str
    difference: float
    relative_to: str
    allowed: float = ALLOWED

    @property
    def agrees(self) -> bool:
        return self.difference <= self.allowed


@dataclass(frozen=True, slots=True)
class Solved:
    """What second engines found, or in `left_out` why one was not asked; `remarks` on the programs of others."""

    agreements: Sequence[Agreement] = ()
    left_out: str = ""
    remarks: Sequence[str] = ()


def largest(values: Array) -> float:
    """max |values|, 0 without any."""
    return float(np.max(np.abs(values), initial=0.0))


def relative(one: float, other: float, scale: float) -> float:
    """|a - b| in units of the larger one, or of `scale` where both are smaller."""
    return abs(one - other) / max(abs(one), abs(other), scale)


def relative_all(one: Array, other: Array) -> float:
    """The same of the worst pair."""
    return largest((one - other) / np.maximum(np.maximum(np.abs(one), np.abs(other)), TINY))


def cofactor_gap(one: Array, other: Array) -> float:
    """Largest |Q_ij - Q'_ij| / sqrt(Q'_ii Q'_jj); an unknown that is fixed has none."""
    sigma = np.sqrt(np.diag(other))
    units = np.outer(sigma, sigma)
    return largest((one - other) / np.where(units > 0, units, 1.0))


def turned_apart(one: Array, other: Array) -> Array:
    """(3,) rad: the small turn about the ground axes from rotation `other` to `one`, both (3, 3)."""
    turn = one @ other.T
    return np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
