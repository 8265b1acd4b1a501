"""Q = (sum A_i' S_i^-1 A_i)^-1, S_i = sigma^2 I + A_P Q_P A_P': an orientation before anything is measured.

What the resection will find of a photo that is only planned: standard deviations of the elements, accuracy of the
ground over the frame, what each control point gives. All covariances are a priori, sigma included.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.collinearity import partials_rotation
from orient.geometry.rotation import aok_by_rotation, near_blind_aok, opk_by_rotation, rotation_exp
from orient.geometry.vertical_photo import element_units, normalised
from orient.solvers import mishchenko
from orient.solvers.functional_iteration import SINGULAR_RATIO, condition_ratio, undetermined_combination
from orient.solvers.ground_covariance import (
    GroundCovariance,
    RayJacobians,
    ray_at_height,
    ray_at_height_jacobians,
)
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.resection_checks import check_control
from orient.solvers.resection_problem import ELEMENTS, Orientation, ResectionProblem

FloatArray = NDArray[np.float64]

UP = np.array([0.0, 0.0, 1.0])
POINTS_NEEDED = 3
INDISPENSABLE = 1e-9
"""Part of the information of a point that the others check, below which the photo is not determined without it."""
VERTICAL = 1e-12
SAME_PLACE = 1e-3
EQUAL_DECIMALS = 9
"""Correlations that are equal by symmetry keep the order of their elements."""


@dataclass(frozen=True, slots=True)
class Sigmas:
    """A-priori standard deviations: reading of an image coordinate [mm], plan and height of the control [m]."""

    image_mm: float
    control_m: float = 0.0
    height_m: float = 0.0


@dataclass(frozen=True, slots=True)
class PlannedPhoto:
    """A photo that is not yet measured: where it stands, where its control will lie, how well all will be known.

    `image` (n, 2) [mm] from the principal point, `ground` (n, 3) [m] on the rays, right-handed, Z up; `rotation`
    R = ground_from_image; the control covariance is diag(control^2, control^2, height^2).
    """

    names: tuple[str, ...]
    image: FloatArray
    ground: FloatArray
    station: FloatArray
    rotation: FloatArray
    f_mm: float
    sigmas: Sigmas

    @property
    def is_normal_case(self) -> bool:
        """Vertical, flat and with errorless control: the case of seed 003."""
        is_vertical = bool(np.max(np.abs(self.rotation - np.eye(3))) <= VERTICAL)
        is_flat = bool(np.ptp(self.ground[:, 2]) <= VERTICAL * float(self.station[2]))
        return is_vertical and is_flat and self.sigmas.control_m == 0 and self.sigmas.height_m == 0


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


@dataclass(frozen=True, slots=True)
class GroundMap:
    """Accuracy of new ground points over the frame.

    `image` (m, 2) [mm], `ground` (m, 3) [m] where the rays meet the mean ground, NaN for rays that do not; three
    independent parts of the covariance.
    """

    image: FloatArray
    ground: FloatArray
    jacobians: RayJacobians = field(repr=False)
    covariance: GroundCovariance

    @property
    def met(self) -> NDArray[np.bool_]:
        """Places (m,) whose ray meets the ground."""
        return self.jacobians.determined

    @property
    def mean_sigma(self) -> float:
        """sqrt(mean of (sigma_X^2 + sigma_Y^2) / 2) over the places that see the ground [m]."""
        return float(np.sqrt(np.mean(self._plan_variance(self.covariance.total))))

    def _plan_variance(self, covariance: FloatArray) -> FloatArray:
        return np.asarray(0.5 * (covariance[self.met, 0, 0] + covariance[self.met, 1, 1]))


@dataclass(frozen=True, slots=True)
class Effect:
    """One point less or more: what becomes of the elements (6,) [m, rad] and of the mean ground sigma [m].

    Infinite when the photo is not determined without the point.
    """

    name: str
    x_mm: float
    y_mm: float
    sigma: FloatArray
    mean_sigma: float

    @property
    def is_determined(self) -> bool:
        return bool(np.isfinite(self.mean_sigma))


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """The normal case by the formulas of seed 003, beside the inverse of the normal equations.

    `sigma` (6,) [m, rad] by (8)-(10), or with Dx and Dy, None if the layout allows neither; `largest_error`: of a
    standard deviation by (8)-(10) with one D, relative; `corner`: sqrt of the larger of K_XX, K_YY at (c, c) in units
    of the reading sigma, whatever the focal length; `focal_terms`: largest element of K^(f,c) there, which all cancel.
    """

    c_mm: float
    sigma: FloatArray | None
    largest_error: float
    corner: float
    focal_terms: float


@dataclass(frozen=True, slots=True)
class Plan:
    """Everything that can be said before measuring. `closed` only in the normal case (vertical, flat, errorless)."""

    photo: PlannedPhoto
    prediction: Prediction
    ground: GroundMap
    without: tuple[Effect, ...]
    one_more: tuple[Effect, ...]
    symmetry: mishchenko.Symmetry
    closed: ClosedForm | None


def planned_photo(
    image: FloatArray,
    names: Sequence[str],
    f_mm: float,
    height_m: float,
    sigmas: Sigmas,
    *,
    relief: FloatArray | None = None,
    tilt: float = 0.0,
) -> PlannedPhoto:
    """P = S + u t: control where the rays of `image` (n, 2) [mm] meet the ground, from a station at (0, 0, height).

    `relief` (n,): heights dZ [m] of the control above the mean ground Z = 0; `tilt` [rad]: the camera looks that far
    away from straight down, towards its own +y. X runs along x, Y along y of the vertical photo. Raises GeometryError
    for rays that miss their height, fewer than three points, coinciding points, points on a line.
    """
    if len(image) < POINTS_NEEDED:
        hint = "Plan at least 4, so that errors can be found."
        raise GeometryError(f"The layout has {len(image)} points, an orientation needs at least 3.", hint)
    rotation, station = rotation_exp([tilt, 0.0, 0.0]), np.array([0.0, 0.0, height_m])
    heights = np.zeros((len(image), 3))
    heights[:, 2] = 0.0 if relief is None else relief
    ground = ray_at_height(image, station, rotation, f_mm, heights, np.tile(UP, (len(image), 1)))
    missed = ~np.isfinite(ground).all(axis=1)
    if missed.any():
        name = names[int(np.argmax(missed))]
        hint = "Choose points below the horizon and below the camera, or a smaller tilt."
        raise GeometryError(f"The ray of point {name} does not meet the ground at its height.", hint)
    cofactors = np.tile(np.eye(2), (len(image), 1, 1))
    check_control(image, cofactors, ground_knowledge(ground, None, None), np.full(len(image), True), names)
    return PlannedPhoto(tuple(names), image, ground, station, rotation, f_mm, sigmas)


def plan(photo: PlannedPhoto, places: FloatArray, height_sigma_m: float = 0.0) -> Plan:
    """Prediction, ground accuracy at `places` (m, 2) [mm] over the frame, and what each point less or more would do.

    One more point is tried at every place where none is planned. Raises GeometryError as `predict` and `ground_map`.
    """
    prediction = predict(photo)
    ground = ground_map(photo, prediction, places, height_sigma_m)
    apart = np.linalg.norm(places[:, None, :] - photo.image[None, :, :], axis=2).min(axis=1)
    empty = places[apart > SAME_PLACE * float(np.max(np.abs(photo.image)))]
    names = [f"{x:g}, {y:g}" for x, y in empty]
    return Plan(
        photo,
        prediction,
        ground,
        dropped(photo, prediction, ground),
        added(photo, prediction, ground, empty, names),
        mishchenko.symmetry(normalised(photo.image)[0]),
        closed_form(photo) if photo.is_normal_case else None,
    )


def predict(photo: PlannedPhoto) -> Prediction:
    """Q = F F', F = s R^-1 of the whitened, scaled design: the covariance that the resection will have a priori.

    Unknown ground coordinates with their own weight are eliminated by adding their image A_P Q_P A_P' to the reading.
    Raises GeometryError, naming the combination of elements, when the layout does not determine the orientation.
    """
    distance = float(np.mean(np.linalg.norm(photo.ground - photo.station, axis=1)))
    scales = np.array([1.0, 1.0, 1.0, distance, distance, distance])
    rows = _whitened(photo, photo.ground) * scales
    shares, R = np.linalg.qr(rows.reshape(-1, 6))
    ratio = condition_ratio(R)
    if ratio < SINGULAR_RATIO:
        raise _singular(photo)
    F = scales[:, None] * np.linalg.inv(R)
    names, J = _named_elements(photo.rotation)
    return Prediction(names, F, J @ F, shares.reshape(-1, 2, 6), ratio)


def ground_map(
    photo: PlannedPhoto, prediction: Prediction, image: FloatArray, height_sigma_m: float = 0.0
) -> GroundMap:
    """K = C Q C' + J sigma^2 J' + h sigma_H^2 h' of new points at `image` (m, 2) [mm], on the mean ground Z = 0.

    `height_sigma_m`: of the heights on which new points are found. Raises GeometryError when no ray meets the ground.
    """
    up = np.tile(UP, (len(image), 1))
    ground = ray_at_height(image, photo.station, photo.rotation, photo.f_mm, np.zeros((len(image), 3)), up)
    jacobians = ray_at_height_jacobians(ground, photo.station, photo.rotation, photo.f_mm, up)
    if not jacobians.determined.any():
        raise GeometryError("The photo sees no ground: every ray runs above the horizon.", "Choose a smaller tilt.")
    root = jacobians.C @ prediction.factor
    reading = photo.sigmas.image_mm**2 * jacobians.J @ jacobians.J.transpose(0, 2, 1)
    height = height_sigma_m**2 * jacobians.h[:, :, None] * jacobians.h[:, None, :]
    covariance = GroundCovariance(root @ root.transpose(0, 2, 1), reading, height)
    return GroundMap(image, ground, jacobians, covariance)


def dropped(photo: PlannedPhoto, prediction: Prediction, ground: GroundMap) -> tuple[Effect, ...]:
    """Q_(-i) = F (I + U (I - U'U)^-1 U') F', U' = W_i F: the prediction without each point, one by one."""
    U = prediction.shares.transpose(0, 2, 1)
    checked = np.eye(2) - prediction.shares @ U
    values, axes = np.linalg.eigh(checked)
    values[values[:, 0] < INDISPENSABLE] = np.nan
    change = (axes / values[:, None, :]) @ axes.transpose(0, 2, 1)
    return _effects(photo.names, photo.image, prediction, ground, U, change)


def added(
    photo: PlannedPhoto, prediction: Prediction, ground: GroundMap, image: FloatArray, names: Sequence[str]
) -> tuple[Effect, ...]:
    """Q_(+i) = F (I - U (I + U'U)^-1 U') F', U' = W_i F: the prediction with one more point at each of `image` (m, 2).

    The new point lies on the mean ground and is known like the control; places that see no ground are left out.
    """
    up = np.tile(UP, (len(image), 1))
    points = ray_at_height(image, photo.station, photo.rotation, photo.f_mm, np.zeros((len(image), 3)), up)
    seen = np.flatnonzero(np.isfinite(points).all(axis=1))
    rows = _whitened(photo, points[seen]) @ prediction.factor
    U = rows.transpose(0, 2, 1)
    change = np.asarray(-np.linalg.inv(np.eye(2) + rows @ U))
    return _effects([names[int(i)] for i in seen], image[seen], prediction, ground, U, change)


def ground_by_use(photo: PlannedPhoto, prediction: Prediction, ground: GroundMap) -> dict[str, float]:
    """Mean ground sigma [m] from the orientation alone if all six elements, or less of their covariance, were used.

    Keys: `six elements` (right), `standard deviations only` (the diagonal), `position only`, `angles only`.
    """
    _, J = _named_elements(photo.rotation)
    C = ground.jacobians.C[ground.met, :2] @ np.linalg.inv(J)
    groups = {"position only": (0, 1, 2), "angles only": (3, 4, 5)}
    full, diagonal, alone = mishchenko.variance_of_uses(C, prediction.named_factor, groups)
    variances = {"six elements": full, "standard deviations only": diagonal, **alone}
    return {use: float(np.sqrt(np.mean(variance))) for use, variance in variances.items()}


def closed_form(photo: PlannedPhoto) -> ClosedForm:
    """Seed 003 on the layout of a vertical photo: what its closed form gives, and how wrong (8)-(10) would be.

    Relief, tilt and errors of the control are not in it: ask `PlannedPhoto.is_normal_case` before comparing.
    """
    points, c = normalised(photo.image)
    g = (photo.f_mm / c) ** 2
    units = photo.sigmas.image_mm * element_units(photo.f_mm, c, float(photo.station[2]))
    determinants = mishchenko.symmetry(points).determinants
    sigma = units * _roots(mishchenko.closed_form(points, g, determinants).Q) if determinants else None
    one_D = _roots(mishchenko.closed_form(points, g).Q) / _roots(mishchenko.cofactors(points, g))
    corner = np.ones(2)
    K = mishchenko.covariance(points, corner[None, :])[0, :, 0, :]
    parts = mishchenko.decomposition(points, g)
    terms = [mishchenko.element_matrices((corner, axis), (corner, axis), parts, g).focal for axis in (0, 1)]
    return ClosedForm(
        c, sigma, float(np.max(np.abs(one_D - 1))), float(np.max(_roots(K))), float(np.max(np.abs(terms)))
    )


def _roots(Q: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.diag(Q)))


def _whitened(photo: PlannedPhoto, ground: FloatArray) -> FloatArray:
    """W_i = S_i^-1/2 A_i (n, 2, 6), S_i = sigma^2 I + A_P Q_P A_P'."""
    partials = partials_rotation(ground, photo.station, photo.rotation, photo.f_mm)
    sigmas = photo.sigmas
    by_ground = partials[:, :, 6:] * np.array([sigmas.control_m, sigmas.control_m, sigmas.height_m])
    S = sigmas.image_mm**2 * np.eye(2) + by_ground @ by_ground.transpose(0, 2, 1)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(S), partials[:, :, :6]))


def _named_elements(rotation: FloatArray) -> tuple[tuple[str, ...], FloatArray]:
    """Names, and J (6, 6): d(X_S, Y_S, Z_S, three angles) / d(r, S)."""
    blind = near_blind_aok(rotation)
    angles = ("omega", "phi", "kappa") if blind else ("alpha", "omega", "kappa")
    J = np.zeros((6, 6))
    J[:3, 3:] = np.eye(3)
    J[3:, :3] = opk_by_rotation(rotation) if blind else aok_by_rotation(rotation)
    return ("X_S", "Y_S", "Z_S", *angles), J


def _effects(
    names: Sequence[str],
    image: FloatArray,
    prediction: Prediction,
    ground: GroundMap,
    U: FloatArray,
    M: FloatArray,
) -> tuple[Effect, ...]:
    """F (I + U M U') F' for each U (n, 6, 2), M (n, 2, 2); not-a-number in M: nothing is determined."""
    by_element = prediction.named_factor @ U
    variance = np.diag(prediction.covariance) + np.einsum("nia,nab,nib->ni", by_element, M, by_element)
    rows = ground.jacobians.C[ground.met, :2] @ prediction.factor
    spread = np.einsum("mka,mkb->ab", rows, rows) / (2 * len(rows))
    mean = ground.mean_sigma**2 + np.einsum("nab,nbd,de,nea->n", M, U.transpose(0, 2, 1), spread, U)
    sigma = np.nan_to_num(np.sqrt(variance), nan=np.inf)
    mean_sigma = np.nan_to_num(np.sqrt(mean), nan=np.inf)
    return tuple(
        Effect(name, float(x), float(y), sigma[i], float(mean_sigma[i]))
        for i, (name, (x, y)) in enumerate(zip(names, image, strict=True))
    )


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
