"""Lens distortion: a named model d(x, y) and a named direction; the convention travels with the coefficients.

    correction          corrected = measured + d(measured)
    displacement        corrected = measured - d(measured)       (certificates: x (1 - D(r)/r))
    ideal_to_distorted  measured  = ideal + d(ideal), solved for the ideal position

Coordinates in mm from the principal point, x right, y up. Models: none, brown (coefficients in powers of mm), opencv
(normalised coordinates, always ideal_to_distorted, OpenCV's own signs with y down), radial_table. EQUATIONS 5.2.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import GeometryError, OrientError
from orient.geometry import distortion_field
from orient.geometry.distortion_field import Radial, brown_radial, opencv_radial, table_radial

Array = NDArray[np.float64]

MODELS = ("none", "brown", "opencv", "radial_table")
DIRECTIONS = ("correction", "displacement", "ideal_to_distorted")
COEFFICIENT_NAMES: Mapping[str, tuple[str, ...]] = {
    "none": (),
    "brown": distortion_field.BROWN_NAMES,
    "opencv": distortion_field.OPENCV_NAMES,
    "radial_table": (),
}
STEP_MM = 1e-12
MAX_STEPS = 50
RADIUS_SAMPLES = 2000


@dataclass(frozen=True, eq=False)
class Distortion:
    """A distortion model of one camera, checked when it is made (OrientError names what is wrong).

    `coefficients`: see `COEFFICIENT_NAMES`, missing ones are 0. `table` (k, 2): radius and D(r) in mm, for
    `radial_table` only. `f_mm`: focal length, needed by `opencv`. `direction` is ignored for `none`.
    """

    model: str = "none"
    direction: str = "correction"
    coefficients: Mapping[str, float] = field(default_factory=dict)
    table: Array | None = None
    f_mm: float = 0.0

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise OrientError(f'distortion: unknown model "{self.model}"', f"Which model? {', '.join(MODELS)}.")
        if self.model == "none":
            return
        if self.direction not in DIRECTIONS:
            raise OrientError(
                f'distortion: unknown direction "{self.direction}"', f"Which direction? {', '.join(DIRECTIONS)}."
            )
        check_coefficients(self)
        if self.model == "opencv":
            check_opencv(self)
        if self.model == "radial_table":
            check_table(self.table)


def check_coefficients(distortion: Distortion) -> None:
    allowed = COEFFICIENT_NAMES[distortion.model]
    for name, value in distortion.coefficients.items():
        if name not in allowed:
            hint = f"It knows {', '.join(allowed)}." if allowed else "It has a table instead of coefficients."
            raise OrientError(f'distortion: the model {distortion.model} has no coefficient "{name}"', hint)
        if not np.isfinite(value):
            raise OrientError(f"distortion: the coefficient {name} must be a finite number")


def check_opencv(distortion: Distortion) -> None:
    if distortion.direction != "ideal_to_distorted":
        raise OrientError(
            f"distortion: the model opencv goes from ideal to distorted, not by {distortion.direction}",
            "Write direction = 'ideal_to_distorted'.",
        )
    if not distortion.f_mm > 0.0:
        raise OrientError("distortion: the model opencv needs the focal length it was calibrated with")


def check_table(table: Array | None) -> None:
    if table is None or table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
        raise OrientError("distortion: a radial table needs at least two rows of radius and distortion")
    if not np.all(np.isfinite(table)) or table[0, 0] < 0.0 or np.any(np.diff(table[:, 0]) <= 0.0):
        raise OrientError("distortion: the radii of the radial table must be finite, not negative, and grow")


def radial_of(distortion: Distortion) -> Radial:
    """r in mm (n,) -> g(r), dg/dr per mm, of the model's radial part."""
    if distortion.model == "brown":
        return brown_radial(distortion.coefficients)
    if distortion.table is not None and distortion.model == "radial_table":
        return table_radial(distortion.table)
    normalised, f = opencv_radial(distortion.coefficients), distortion.f_mm

    def radial(r: Array) -> tuple[Array, Array]:
        g, g_by_r = normalised(r / f)
        return g, g_by_r / f

    return radial


def field_of(distortion: Distortion, xy: Array) -> tuple[Array, Array]:
    """d(x, y) (n, 2) mm and its Jacobian (n, 2, 2) of the model at xy (n, 2) mm, whatever the direction."""
    if distortion.model == "none":
        return np.zeros_like(xy), np.zeros((len(xy), 2, 2))
    if distortion.model != "opencv":
        return distortion_field.field(radial_of(distortion), distortion.coefficients, xy)
    tangential = distortion_field.opencv_coefficients(distortion.coefficients)
    f = distortion.f_mm
    d, jacobian = distortion_field.field(opencv_radial(distortion.coefficients), tangential, xy / f)
    return f * d, jacobian


def coefficient_partials(distortion: Distortion, names: Sequence[str], xy: Array) -> Array:
    """dd/dc (n, 2, m) of the coefficients k1 k2 k3 p1 p2 that are named, at xy (n, 2) mm, per unit of the model.

    brown and none: the field itself. opencv: f times the field of x/f, k_i divided by 1 + k4 r^2 + k5 r^4 + k6 r^6,
    p1 = -p2 and p2 = p1 of Brown (y points up here).
    """
    if distortion.model != "opencv" or not names:
        return distortion_field.coefficient_partials(names, xy)
    u = xy / distortion.f_mm
    s = np.sum(u * u, axis=1)
    k4, k5, k6 = (distortion.coefficients.get(name, 0.0) for name in ("k4", "k5", "k6"))
    bottom = 1.0 + s * (k4 + s * (k5 + s * k6))
    turned = {"p1": ("p2", -1.0), "p2": ("p1", 1.0)}
    partials = distortion_field.coefficient_partials([turned.get(name, (name, 1.0))[0] for name in names], u)
    factors = [turned[name][1] * np.ones_like(s) if name in turned else 1.0 / bottom for name in names]
    return np.asarray(distortion.f_mm * partials * np.stack(factors, axis=-1)[:, None, :])


def correction(distortion: Distortion, xy: ArrayLike) -> Array:
    """corrected - measured: (n, 2) mm to ADD to the measured xy (n, 2) mm, reduced to the principal point.

    `ideal_to_distorted` is inverted by Newton's method to 1e-12 mm; where it has no inverse (beyond the fold of the
    radial function) GeometryError names the position.
    """
    measured = np.asarray(xy, dtype=np.float64)
    if distortion.model == "none":
        return np.zeros_like(measured)
    if distortion.direction == "ideal_to_distorted":
        return ideal_position(distortion, measured) - measured
    d, _ = field_of(distortion, measured)
    return d if distortion.direction == "correction" else -d


def distort(distortion: Distortion, ideal: ArrayLike) -> Array:
    """measured (n, 2) mm of the ideal position (n, 2) mm: the inverse of `xy + correction(xy)`."""
    xy = np.asarray(ideal, dtype=np.float64)
    if distortion.model == "none":
        return xy.copy()
    if distortion.direction == "ideal_to_distorted":
        return xy + field_of(distortion, xy)[0]
    sign = 1.0 if distortion.direction == "correction" else -1.0
    return solve_position(distortion, xy, sign)


def ideal_position(distortion: Distortion, measured: Array) -> Array:
    """q with q + d(q) = measured, on the branch that starts at the principal point."""
    q = solve_position(distortion, measured, 1.0)
    radii = np.linalg.norm(q, axis=-1)
    fold = first_fold(distortion, float(np.max(radii, initial=0.0)))
    if fold is not None:
        raise no_inverse(measured[int(np.argmax(radii >= fold))])
    return q


def solve_position(distortion: Distortion, target: Array, sign: float) -> Array:
    """q (n, 2) with q + sign d(q) = target (n, 2), by Newton's method from q = target, to steps below 1e-12 mm."""
    q, step = target.copy(), np.zeros_like(target)
    enough = max(STEP_MM, 4.0 * np.finfo(float).eps * float(np.max(np.abs(target), initial=0.0)))
    for _ in range(MAX_STEPS):
        with np.errstate(over="ignore", invalid="ignore"):  # of a target far outside every frame; refused below
            d, jacobian = field_of(distortion, q)
            A = np.eye(2) + sign * jacobian
            determinant = A[:, 0, 0] * A[:, 1, 1] - A[:, 0, 1] * A[:, 1, 0]
        bad = ~(np.abs(determinant) > 1e-9)  # also catches nan
        if np.any(bad):
            raise no_inverse(target[int(np.argmax(bad))])
        misclosure = target - q - sign * d
        step = np.linalg.solve(A, misclosure[:, :, None])[:, :, 0].astype(np.float64)
        q = q + step
        if np.max(np.abs(step), initial=0.0) <= enough:
            return q
    raise no_inverse(target[int(np.argmax(np.max(np.abs(step), axis=-1)))])


def no_inverse(position: Array) -> GeometryError:
    x, y = position
    return GeometryError(
        f"distortion: cannot be inverted at x = {x:.3f} mm, y = {y:.3f} mm (radius {np.hypot(x, y):.1f} mm)",
        "Check the coefficients, their unit and the direction, or leave out points so far from the centre.",
    )


def fold_radius(distortion: Distortion, r_max_mm: float) -> float | None:
    """The MEASURED radius [mm] within r_max_mm from which the radial function has no inverse; None if there is none.

    `correction`, `displacement`: the first r with d(corrected r)/dr <= 0. `ideal_to_distorted`: the largest distorted
    radius that can occur, r + r g(r) at the first ideal r where its derivative is <= 0 (the ideal radius itself may be
    larger than r_max_mm). Only the radial part of the model is looked at; a table is looked at as far as it goes.
    """
    if distortion.model == "none":
        return None
    if distortion.direction != "ideal_to_distorted":
        return first_fold(distortion, r_max_mm)
    limit = r_max_mm
    for _ in range(20):  # doubling: barrel distortion can ask for ideal radii far outside the frame
        fold = first_fold(distortion, limit)
        reached = radial_image(distortion, limit if fold is None else fold)
        if reached >= r_max_mm:
            return None
        if fold is not None or limit >= table_end(distortion):
            return reached
        limit *= 2.0
    return reached


def table_end(distortion: Distortion) -> float:
    return float(distortion.table[-1, 0]) if distortion.table is not None else np.inf


def radial_image(distortion: Distortion, r: float) -> float:
    """r + r g(r) [mm]; the table's last radius stands for all beyond it."""
    inside = min(r, table_end(distortion))
    return inside * (1.0 + float(radial_of(distortion)(np.array([inside]))[0][0]))


def first_fold(distortion: Distortion, r_max: float) -> float | None:
    """First r in (0, r_max] with d(r +- r g(r))/dr = 1 +- (g + r g') <= 0, + but for `displacement`; by bisection."""
    radial = radial_of(distortion)
    sign = -1.0 if distortion.direction == "displacement" else 1.0

    def folded(r: Array) -> NDArray[np.bool_]:
        g, g_by_r = radial(r)
        return ~(1.0 + sign * (g + r * g_by_r) > 0.0)

    radii = np.linspace(0.0, min(r_max, table_end(distortion)), RADIUS_SAMPLES + 1)
    where = np.flatnonzero(folded(radii))
    if len(where) == 0:
        return None
    upper = radii[where[0]]
    lower = radii[max(where[0] - 1, 0)]
    while upper - lower > 1e-9 * upper:
        middle = 0.5 * (lower + upper)
        lower, upper = (lower, middle) if folded(np.array([middle]))[0] else (middle, upper)
    return float(lower)
