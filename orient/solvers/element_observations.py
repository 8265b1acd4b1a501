"""v = g(R, S) - l: a known station, height or angle as an observation of the six elements, with its weight."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Misclosure = Callable[[FloatArray, FloatArray], tuple[float, FloatArray]]
"""R (3, 3), S (3,) -> computed minus given, and its partials (6,) by the small rotation and S."""


@dataclass(frozen=True, slots=True)
class ElementObservation:
    """One known number about the camera; `cofactor` = variance / sigma0^2 in its own unit squared."""

    name: str
    cofactor: float
    misclosure: Misclosure


def along(axis: FloatArray, given: float) -> Misclosure:
    """a'S - l: a coordinate of the station along the unit vector `axis` a (3,), right-handed ground."""

    def misclosure(rotation: FloatArray, station: FloatArray) -> tuple[float, FloatArray]:
        return float(axis @ station) - given, np.concatenate([np.zeros(3), axis])

    return misclosure


def whitened_rows(
    observations: Sequence[ElementObservation], rotation: FloatArray, station: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Design (k, 6) and misclosures (k,), divided by the root of the cofactor."""
    design, free_term = np.zeros((len(observations), 6)), np.zeros(len(observations))
    for row, one in enumerate(observations):
        value, partials = one.misclosure(rotation, station)
        root = 1.0 / np.sqrt(one.cofactor)
        design[row], free_term[row] = root * partials, root * value
    return design, free_term
