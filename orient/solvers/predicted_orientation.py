"""Q = (sum A_i' S_i^-1 A_i)^-1, S_i = sigma^2 I + A_P Q_P A_P': the orientation of a photo that is only planned.

What the resection will find, by the same engine; all covariances are a priori, sigma included.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.collinearity import partials_rotation
from orient.geometry.rotation import aok_by_rotation, near_blind_aok, opk_by_rotation
from orient.solvers.functional_iteration import SINGULAR_RATIO, condition_ratio, undetermined_combination
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.linear_adjustment import adjust
from orient.solvers.planned_photo import PlannedPhoto
from orient.solvers.resection_problem import ELEMENTS, Orientation, ResectionProblem

FloatArray = NDArray[np.float64]

EQUAL_DECIMALS = 9
"""Correlations that are equal by symmetry keep the order of their elements."""


@dataclass(frozen=True, slots=True)
class Prediction:
    """The orientation as the layout will determine it.

    `names` of the six elements: X_S, Y_S, Z_S and alpha, omega, kappa (omega, phi, kappa near the blind view).
    `factor` F (6, 6): the covariance of r, S [rad, m] is F F'; `named_factor`: the same for the named ones [m, rad].
    `shares` (n, 2, 6): the rows W_i F of each point's whitened equations, together orthonormal.
    """

    names: tuple[str, ...]
    factor: FloatArray
    named_factor: FloatArray
    shares: FloatArray
    condition_ratio: float

    @property
    def covariance(self) -> FloatArray:
        """Covariance (6, 6) of the named elements [m, rad]."""
        return np.asarray(self.named_factor @ self.named_factor.T)

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations (6,) of the named elements [m, rad]."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def redundancy(self) -> int:
        """2n - 6."""
        return 2 * len(self.shares) - len(ELEMENTS)

    @property
    def redundancy_numbers(self) -> FloatArray:
        """How much of a point's two equations the others check, 0 ... 2, (n,); their sum is the redundancy."""
        return np.asarray(2.0 - np.sum(self.shares**2, axis=(1, 2)))

    def correlations(self) -> tuple[tuple[str, str, float], ...]:
        """All pairs of elements with their correlation, the strongest first."""
        scaled = self.covariance / np.outer(self.sigma, self.sigma)
        pairs = [(self.names[i], self.names[j], float(scaled[i, j])) for i in range(6) for j in range(i + 1, 6)]
        return tuple(sorted(pairs, key=lambda pair: -round(abs(pair[2]), EQUAL_DECIMALS)))


def predict(photo: PlannedPhoto) -> Prediction:
    """Q = F F', F = s R^-1 of the whitened, scaled design: the covariance that the resection will have a priori.

    Unknown ground coordinates with their own weight are eliminated by adding their image A_P Q_P A_P' to the reading.
    Raises GeometryError, naming the combination of elements, when the layout does not determine the orientation.
    """
    distance = float(np.mean(np.linalg.norm(photo.ground - photo.station, axis=1)))
    scales = np.array([1.0, 1.0, 1.0, distance, distance, distance])
    rows = (whitened_partials(photo, photo.ground) * scales).reshape(-1, 6)
    ratio = condition_ratio(rows)
    if ratio < SINGULAR_RATIO:
        raise _singular(photo)
    adjustment = adjust(ELEMENTS, rows, np.zeros(len(rows)))
    F = scales[:, None] * adjustment.R_inverse
    names, J = named_elements(photo.rotation)
    return Prediction(names, F, J @ F, adjustment.shares.reshape(-1, 2, 6), ratio)


def whitened_partials(photo: PlannedPhoto, ground: FloatArray) -> FloatArray:
    """W_i = S_i^-1/2 A_i (n, 2, 6), S_i = sigma^2 I + A_P Q_P A_P'."""
    partials = partials_rotation(ground, photo.station, photo.rotation, photo.f_mm)
    sigmas = photo.sigmas
    by_ground = partials[:, :, 6:] * np.array([sigmas.control_m, sigmas.control_m, sigmas.height_m])
    S = sigmas.image_mm**2 * np.eye(2) + by_ground @ by_ground.transpose(0, 2, 1)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(S), partials[:, :, :6]))


def named_elements(rotation: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
    """Names of the elements, and J (6, 6): d(X_S, Y_S, Z_S, three angles) / d(r, S)."""
    angles, by_rotation = named_angles(rotation)
    J = np.zeros((6, 6))
    J[:3, 3:] = np.eye(3)
    J[3:, :3] = by_rotation
    return ("X_S", "Y_S", "Z_S", *angles), J


def named_angles(rotation: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
    """alpha, omega, kappa, or near their blind view omega, phi, kappa; and their partials (3, 3) by r."""
    if near_blind_aok(rotation):
        return ("omega", "phi", "kappa"), opk_by_rotation(rotation)
    return ("alpha", "omega", "kappa"), aok_by_rotation(rotation)


def _singular(photo: PlannedPhoto) -> GeometryError:
    known = ground_knowledge(photo.ground, None, None)
    problem = ResectionProblem(photo.image, np.tile(np.eye(2), (len(photo.image), 1, 1)), known, photo.f_mm)
    linear = problem.linearise(Orientation(photo.rotation, photo.station, photo.ground))
    free = undetermined_combination(linear, ELEMENTS)
    return GeometryError(
        f"The layout does not determine the orientation. Undetermined: {free} (angles in rad, lengths in units of "
        f"{linear.distance:.6g} m).",
        "Add a point away from the others; three points and the camera must not lie on one upright cylinder.",
    )
