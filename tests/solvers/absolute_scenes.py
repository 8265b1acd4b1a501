"""Models of known orientation, seeded by the name of the test that uses them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import rotation_exp
from orient.geometry.similarity import ground_by_homothety
from tests.solvers.resection_scenes import generator as generator

FloatArray = NDArray[np.float64]

KNOWN = {"f": np.eye(3), "p": np.diag([1.0, 1.0, 0.0]), "h": np.diag([0.0, 0.0, 1.0])}
"""Full, plan-only, height-only."""


@dataclass(frozen=True)
class Scene:
    """Control points of a model with the true similarity; `kinds` holds f, p or h for each point."""

    model: FloatArray
    kinds: str
    rotation: FloatArray
    H: float
    X0: FloatArray

    @property
    def ground(self) -> FloatArray:
        return ground_by_homothety(self.model, self.rotation, self.H, self.X0)

    @property
    def known(self) -> FloatArray:
        return np.array([KNOWN[kind] for kind in self.kinds])

    def with_model(self, model: FloatArray) -> "Scene":
        return replace(self, model=model)


def attitude(tilt: float, theta: float, side: float = 0.7) -> FloatArray:
    """R of a model turned by theta and then tilted."""
    return rotation_exp([tilt * np.cos(side), tilt * np.sin(side), 0.0]) @ rotation_exp([0.0, 0.0, theta])


def scene(
    random: np.random.Generator,
    kinds: str = "ffffff",
    tilt: float = 0.1,
    theta: float | None = None,
    H: float = 0.3,
    relief: float = 0.2,
    X0: tuple[float, float, float] = (5e5, 4e6, 300.0),
) -> Scene:
    """Points over 20 x 16 model units, `relief` of that high, far from the model's origin."""
    turn = random.uniform(-np.pi, np.pi) if theta is None else theta
    model = random.uniform(-1, 1, (len(kinds), 3)) * [10.0, 8.0, 10.0 * relief] + [100.0, 50.0, 20.0]
    return Scene(model, kinds, attitude(tilt, turn, random.uniform(0, 2 * np.pi)), H, np.array(X0))


def covariances(random: np.random.Generator, n: int, sigma: float) -> FloatArray:
    """Individual correlated cofactors (n, 3, 3)."""
    roots = random.normal(size=(n, 3, 3)) + 2 * np.eye(3)
    return np.asarray(sigma**2 * roots @ roots.transpose(0, 2, 1))
