"""v = a1 d(u1) + ... + a7 d(u7) + l at the solution: the correction equations in the forms of the papers.

The adjustment itself turns by a small rotation, which has no blind view; these are the equations that a reader of
seeds 000 and 002 expects, of every given coordinate, as the table of compact equations is for a photo.
"""

from collections.abc import Callable

from orient.geometry.rotation import matrix_from_aok
from orient.geometry.similarity import (
    ground_by_homothety,
    ground_by_joint_homothety,
    ground_by_scale,
    matrix_from_fixed_axes,
    partials_homothety,
    partials_joint_homothety,
    partials_scale,
)
from orient.pipeline.absolute_zone import Zone
from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.absolute_views import element_view
from orient.values import Row

GIVEN_AXES = {"XYZ": (0, 1, 2), "plan": (0, 1), "height": (2,)}


def equation_rows(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> list[Row]:
    """Rows of `absolute_equation`: a1 ... a7 in the order of the form's elements, l = computed minus given [m].

    Axes of the right-handed ground (east, north, up of T'; local: X, Y, Z); a height-only point has its Z.
    """
    given = frame.right_handed(zone.control_ground)
    rows: list[Row] = []
    for form, equations in FORMS.items():
        computed, partials = equations(zone.control_model, element_view(found, form).values)
        for i, (point, known) in enumerate(zip(zone.control_points, zone.known_words, strict=True)):
            rows += [
                {
                    "zone": zone.name,
                    "form": form,
                    "point": point,
                    "axis": "XYZ"[axis],
                    **{f"a{k + 1}": float(partials[i, axis, k]) for k in range(7)},
                    "l_m": float(computed[i, axis] - given[i, axis]),
                }
                for axis in GIVEN_AXES[known]
            ]
    return rows


def _homothety(model: Array, values: Array) -> tuple[Array, Array]:
    """(2'): xi, eta, theta, H, X_0, Y_0, Z_0."""
    angles, H = values[:3], float(values[3])
    computed = ground_by_homothety(model, matrix_from_fixed_axes(*angles), H, values[4:])
    return computed, partials_homothety(model, angles, H)


def _joint(model: Array, values: Array) -> tuple[Array, Array]:
    """(4'): xi, eta, theta, H, T_X, T_Y, T_Z, T = H X0."""
    angles, H, T = values[:3], float(values[3]), values[4:]
    computed = ground_by_joint_homothety(model, matrix_from_fixed_axes(*angles), H, T)
    return computed, partials_joint_homothety(model, angles, H, T)


def _scale(model: Array, values: Array) -> tuple[Array, Array]:
    """(108): X_0, Y_0, Z_0, t, xi, eta, theta (tilts)."""
    X0, t, angles = values[:3], float(values[3]), values[4:]
    return ground_by_scale(model, matrix_from_aok(*angles), t, X0), partials_scale(model, angles, t)


FORMS: dict[str, Callable[[Array, Array], tuple[Array, Array]]] = {
    "homothety": _homothety,
    "joint": _joint,
    "scale": _scale,
}
