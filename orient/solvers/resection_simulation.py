"""Monte Carlo of a resection: adjusted values as truth, errors drawn from the given covariances, adjusted again."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import project
from orient.solvers import functional_iteration
from orient.solvers.common_unknowns import whitened
from orient.solvers.functional_iteration import Termination
from orient.solvers.ground_points import GroundKnowledge, ground_knowledge
from orient.solvers.independent_resection import ResectionObservations
from orient.solvers.resection_problem import ELEMENTS, Orientation, ResectionProblem

FloatArray = NDArray[np.float64]

NONLINEAR = 0.03
"""Q is of first order: this share of a standard deviation is no disagreement."""
CONFIDENCE = 4.0
"""Standard errors of a simulated standard deviation, 1/sqrt(2 n): one of 15 000 lies farther off by chance."""


@dataclass(frozen=True, slots=True)
class Spread:
    """Standard deviations (6,) of r_X, r_Y, r_Z [rad], X_S, Y_S, Z_S [m]: by Q, and of the simulated solutions."""

    unknowns: Sequence[str]
    predicted: FloatArray
    simulated: FloatArray
    n: int
    n_failed: int

    @property
    def allowed(self) -> float:
        """Distance of simulated / predicted from 1 that chance and second-order terms explain."""
        return NONLINEAR + CONFIDENCE / float(np.sqrt(2 * max(self.n, 1)))

    @property
    def surprises(self) -> list[str]:
        """Unknowns whose spread is not that of Q, in words."""
        ratios = self.simulated / self.predicted
        return [
            f"simulated spread of {unknown} is {ratio:.3f} of Q's (allowed 1 +- {self.allowed:.3f}, {self.n} runs)"
            for unknown, ratio in zip(self.unknowns, ratios, strict=True)
            if abs(ratio - 1) > self.allowed
        ]


def simulate_resection(
    given: ResectionObservations,
    station: FloatArray,
    rotation: FloatArray,
    ground: FloatArray,
    sigma0: float,
    n: int,
    seed: int,
    progress: Callable[[int], None] = lambda done: None,
) -> Spread:
    """Spread of `n` adjustments about the truth `station`, `rotation`, `ground` (n, 3), right-handed.

    Errors of image points, weighted ground coordinates and common unknowns are normal with sigma0^2 times their
    cofactors; sigma0 [mm] a priori. Points without error stay where they are. Each adjustment starts at the truth.
    """
    origin = ground.mean(axis=0)
    truth = Orientation(rotation, station - origin, ground - origin)
    known = ground_knowledge(truth.ground, given.free, given.weight)
    shared = whitened(given.common, len(ground))
    problem = ResectionProblem(project(truth.ground, truth.station, rotation, given.f_mm)[0], given.image_cofactor,
                               known, given.f_mm, shared)  # fmt: skip
    truth = replace(truth, common=np.zeros(shared.rank))
    Q = functional_iteration.cofactor_matrix(problem.linearise(truth))
    generator = np.random.default_rng(seed)
    found = []
    for number in range(1, n + 1):
        drawn = _drawn(problem, sigma0, generator)
        iterated = functional_iteration.iterate(drawn, replace(truth, ground=drawn.known.given.copy()))
        if iterated.termination is Termination.CONVERGED:
            found.append(_deviation(iterated.state, truth))
        progress(number)
    deviations = np.array(found).reshape(-1, 6)
    simulated = np.sqrt(np.mean(deviations**2, axis=0)) if found else np.zeros(6)
    return Spread(ELEMENTS, sigma0 * np.sqrt(np.diag(Q)), simulated, len(found), n - len(found))


def _drawn(problem: ResectionProblem, sigma0: float, generator: np.random.Generator) -> ResectionProblem:
    """The problem with errors in everything that was observed."""
    n = len(problem.image)
    errors = np.linalg.cholesky(problem.image_cofactor) @ generator.standard_normal((n, 2, 1))
    own = np.linalg.pinv(problem.known.weight_root, rcond=1e-8) @ generator.standard_normal((n, 3, 1))
    z = generator.standard_normal(problem.common.rank)  # one error of what is common, on the ground and in the image
    known: GroundKnowledge = problem.known
    moved = known.given - sigma0 * (own[:, :, 0] + problem.common.shift(z))
    image = problem.image + sigma0 * (errors[:, :, 0] - problem.common.image_shift(z))
    return replace(problem, image=image, known=replace(known, given=moved))


def _deviation(state: Orientation, truth: Orientation) -> FloatArray:
    turn = state.rotation @ truth.rotation.T
    skew = 0.5 * (turn - turn.T)
    return np.array([skew[2, 1], skew[0, 2], skew[1, 0], *(state.station - truth.station)])
