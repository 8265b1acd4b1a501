"""Control that cannot orient a model is refused by name, and a singular end is explained by the layout."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.solvers.absolute_cofactors import Weight, diagonal_blocks
from orient.solvers.absolute_problem import UNKNOWNS, AbsoluteProblem, Similarity
from orient.solvers.absolute_start import full_points
from orient.units import listed

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ERRORLESS = 1e-14
ON_LINE = 1e-4
NAMED = 5


def known_rank(known: FloatArray) -> IntArray:
    """Known coordinates of each point: 3 full, 2 plan, 1 height."""
    return np.asarray(np.rint(np.trace(known, axis1=1, axis2=2)), dtype=np.int64)


def check_shapes(arrays: Sequence[FloatArray | None], names: Sequence[str]) -> None:
    """Refuse, naming the point, numbers that are not finite."""
    for array in arrays:
        if array is None or np.isfinite(array).all():
            continue
        bad = ~np.isfinite(array.reshape(len(names), -1)).all(axis=1)
        raise GeometryError(f"Point {names[int(np.argmax(bad))]} has a coordinate or weight that is no finite number.")


def check_counts(known: FloatArray, names: Sequence[str]) -> None:
    """Refuse control with fewer than seven equations, and control without any height or any plan position."""
    rank = known_rank(known)
    full, plan, height = (int(np.count_nonzero(rank == k)) for k in (3, 2, 1))
    given = f"{full} full, {plan} plan-only and {height} height-only control points"
    equations = 3 * full + 2 * plan + height
    if equations < UNKNOWNS:
        raise GeometryError(
            f"{given} give {equations} equations; the absolute orientation has {UNKNOWNS} unknowns.",
            "Give more control points: at least two with plan position and three with height.",
        )
    if full + height == 0:
        raise GeometryError(
            f"{given}: without any height Z_0 is not determined.", "Give the heights of at least three points."
        )
    if full + plan == 0:
        raise GeometryError(
            f"{given}: without any plan position X_0, Y_0 and theta are not determined.",
            "Give the plan position of at least two points.",
        )


def check_problem(problem: AbsoluteProblem, names: Sequence[str]) -> Weight:
    """Refuse control in one place, and coordinates errorless on the ground and in the model; the weight at a guess."""
    size = float(np.max(np.ptp(problem.model, axis=0)))
    if not (size > 0 and problem.extent > 0):
        where = "in the model" if size == 0 else "on the ground"
        raise GeometryError(
            f"All control points lie in one place {where}: H is not determined.", "Correct the coordinates."
        )
    _check_errors(problem, size, names)
    try:
        return problem.weight(np.eye(3), problem.extent / size)
    except np.linalg.LinAlgError as error:
        raise GeometryError(
            "The covariance of the control coordinates is not positive definite.", "Correct the covariances."
        ) from error


def _check_errors(problem: AbsoluteProblem, size: float, names: Sequence[str]) -> None:
    """Every known coordinate needs an error on one of the two sides."""
    total = diagonal_blocks(problem.ground_cofactor)
    if problem.model_cofactor is not None:
        # only whether an error is there at all counts: the model's own directions are turned unknown ones
        smallest = np.linalg.eigvalsh(diagonal_blocks(problem.model_cofactor))[:, 0]
        total = total + np.maximum(smallest, 0.0)[:, None, None] * (problem.extent / size) ** 2 * np.eye(3)
    largest = np.max(np.abs(total), axis=(1, 2))
    inside = problem.known @ total @ problem.known + (np.eye(3) - problem.known) * largest[:, None, None]
    bad = np.linalg.eigvalsh(inside)[:, 0] <= ERRORLESS * largest
    if bad.any():
        raise GeometryError(
            f"A coordinate of point {names[int(np.argmax(bad))]} has no error on the ground and none in the model, "
            "or its covariance is not positive.",
            "Give the standard deviation of the model coordinates, or of every coordinate of the control.",
        )


def cause(problem: AbsoluteProblem, state: Similarity, names: Sequence[str]) -> str:
    """Why a layout is singular, in words; empty when it is none of the known cases."""
    rank = known_rank(problem.known)
    full = full_points(problem.known)
    line = _line(problem.ground[full])
    if line is not None and np.all(full | (rank == 0)):
        return f"the control points {_listed(names, full)} lie on one line: the model can turn about it"
    heights = (rank == 1) & ~full
    if line is not None and np.count_nonzero(rank == 2) == 0:
        placed = state.centre + problem.model[heights] @ state.rotation.T / state.H
        if _in_vertical_plane(placed, *line):
            return (
                f"in the vertical plane through {_listed(names, full)} lies every other height "
                f"({_listed(names, heights)}): the model can turn about that line"
            )
    on_heights = full | heights
    if np.count_nonzero(on_heights) < 3:
        return (
            f"three heights are needed where there are {np.count_nonzero(on_heights)}: "
            "the plan positions of a flat model do not tell its tilt"
        )
    if _line(problem.model[on_heights]) is not None:
        return f"the points with a height, {_listed(names, on_heights)}, lie on one line"
    return ""


def _line(points: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """A point and the direction of the line that all points lie on; None if they do not or are fewer than two."""
    if len(points) < 2:
        return None
    centre = points.mean(axis=0)
    _, values, axes = np.linalg.svd(points - centre, full_matrices=False)
    return (centre, axes[0]) if values[1] <= ON_LINE * values[0] else None


def _in_vertical_plane(points: FloatArray, centre: FloatArray, direction: FloatArray) -> bool:
    across = np.cross(direction, [0.0, 0.0, 1.0])
    length = np.linalg.norm(across)
    arms = points - centre
    size = np.max(np.linalg.norm(arms, axis=1), initial=0.0)
    return bool(length > 0 and np.all(np.abs(arms @ across) <= 10 * ON_LINE * length * size))


def _listed(names: Sequence[str], chosen: NDArray[np.bool_]) -> str:
    return listed([name for name, take in zip(names, chosen, strict=True) if take], NAMED)
