"""The photos and points that all candidates get."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_opk

Array = NDArray[np.float64]
F_MM, HEIGHT_M, SIGMA_MM = 300.0, 250_000.0, 0.005
POINT_SIGMA_M = np.array([20.0, 20.0, 30.0])


@dataclass(frozen=True)
class Photo:
    """A space photo: 180 mm format, relief 3 km; rough values 3 % of the height and 5 degrees off."""

    image: Array
    ground: Array
    given: Array
    R0: Array
    S0: Array


def photo(n: int, seed: int = 7) -> Photo:
    """`given`: the ground with errors of `POINT_SIGMA_M`."""
    rng = np.random.default_rng(seed)
    ground = np.column_stack([rng.uniform(-75_000, 75_000, (n, 2)), rng.uniform(0, 3000, n)])
    R, S = matrix_from_opk(*rng.uniform(-0.1, 0.1, 2), rng.uniform(-3, 3)).T, np.array([3000.0, -2000.0, HEIGHT_M])
    image = project(ground, S, R, F_MM)[0] + rng.normal(scale=SIGMA_MM, size=(n, 2))
    turn = matrix_from_opk(*rng.uniform(-0.09, 0.09, 3))
    given = ground + rng.normal(size=(n, 3)) * POINT_SIGMA_M
    return Photo(image, ground, given, turn @ R, S + rng.normal(size=3) * 7500)


def photos(p: int, n: int) -> tuple[Array, Array, Array, Array]:
    """image (p, n, 2), ground (p, n, 3), R0 (p, 3, 3), S0 (p, 3) of p photos."""
    made = [photo(n, seed) for seed in range(p)]
    stacks = (np.array([getattr(one, name) for one in made]) for name in ("image", "ground", "R0", "S0"))
    image, ground, R0, S0 = stacks
    return image, ground, R0, S0
