"""Start values of an absolute orientation: the closed form, the turn about a line, the grid of theta.

Angles 0 and H = 1 are no safe start (EQUATIONS 1.4): Newton in H needs 0 < H < 2 H_true, and theta below 90 degrees.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import rotation_exp
from orient.solvers.absolute_cofactors import diagonal_blocks
from orient.solvers.absolute_problem import AbsoluteProblem, Similarity

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

STEP = np.pi / 6
TILT = np.pi / 6
LINE = 1e-7
SMALLEST_GAIN = 1e-3
"""Fit of t below this share of the ratio of extents: theta is wrong, or the control says nothing of the scale."""


def closed_form(model: FloatArray, ground: FloatArray, weights: FloatArray) -> Similarity:
    """R = V diag(1, 1, +-1) U' of the SVD of sum p x P', H = sqrt(sum p |x|^2 / sum p |P|^2): no iteration.

    `model`, `ground` (n, 3) with at least three points off one line, `weights` p (n,); centred here. R is always a
    rotation: mirrored points get the best rotation, not the mirror image. The scale by the norms treats model and
    ground alike (symmetric in their errors); the adjustment that follows refines it. Sources: Horn (1987), Arun, Huang,
    Blostein (1987), Umeyama (1991).
    """
    p = (weights / weights.sum())[:, None]
    model_centre, ground_centre = np.sum(p * model, axis=0), np.sum(p * ground, axis=0)
    x, P = model - model_centre, ground - ground_centre
    U, _, Vt = np.linalg.svd((p * x).T @ P)
    sign = np.linalg.det(U @ Vt)
    R = Vt.T @ np.diag([1.0, 1.0, 1.0 if sign > 0 else -1.0]) @ U.T
    H = float(np.sqrt(np.sum(p * x**2) / np.sum(p * P**2)))
    return Similarity(np.asarray(R), H, ground_centre - R @ model_centre / H)


def start_values(problem: AbsoluteProblem) -> list[Similarity]:
    """The closed form when three full points span a triangle; else turns about their line and the grid of theta."""
    full = full_points(problem.known)
    if spans_triangle(problem.model[full]) and spans_triangle(problem.ground[full]):
        return [weighted_closed_form(problem, full)]
    starts = list(_about_line(problem, full)) if np.count_nonzero(full) >= 2 else []
    return starts + list(grid(problem, (0.0,)))


def may_be_mirrored(problem: AbsoluteProblem) -> bool:
    """Can the mirrored model fit better? Not when three full points span a triangle and det(sum p x P') > 0."""
    full = full_points(problem.known)
    if not (spans_triangle(problem.model[full]) and spans_triangle(problem.ground[full])):
        return True
    x = problem.model[full] - problem.model[full].mean(axis=0)
    U, _, Vt = np.linalg.svd(x.T @ (problem.ground[full] - problem.ground[full].mean(axis=0)))
    return bool(np.linalg.det(U @ Vt) < 0)


def tilted_starts(problem: AbsoluteProblem) -> list[Similarity]:
    """The grid of theta with the model tilted by 30 degrees to four sides: for where no flat start leads anywhere."""
    return list(grid(problem, (TILT,)))


def full_points(known: FloatArray) -> BoolArray:
    """Points with three known coordinates (n,)."""
    return np.asarray(np.rint(np.trace(known, axis1=1, axis2=2)) == 3)


def spans_triangle(points: FloatArray) -> bool:
    """At least three points, not all on one line."""
    if len(points) < 3:
        return False
    values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(values[1] > LINE * values[0])


def weighted_closed_form(problem: AbsoluteProblem, full: BoolArray) -> Similarity:
    """Closed form with equal weights first, then with 3 / trace Q_e at the scale found."""
    model, ground = problem.model[full], problem.ground[full]
    first = closed_form(model, ground, np.ones(len(model)))
    own = np.trace(diagonal_blocks(problem.cofactor(first.rotation, first.t))[full], axis1=1, axis2=2)
    return closed_form(model, ground, own.min() / own)


def _about_line(problem: AbsoluteProblem, full: BoolArray) -> Iterator[Similarity]:
    """Two full points leave the turn about the line through them: every 30 degrees of it."""
    model, ground = problem.model[full], problem.ground[full]
    first, last = _most_distant(model)
    along_model, along_ground = model[last] - model[first], ground[last] - ground[first]
    length_model, length_ground = np.linalg.norm(along_model), np.linalg.norm(along_ground)
    if length_model == 0 or length_ground == 0:
        return
    axis = along_ground / length_ground
    onto = _triad(axis) @ _triad(along_model / length_model).T
    H = float(length_model / length_ground)
    for angle in np.arange(0.0, 2 * np.pi - 1e-9, STEP):
        R = rotation_exp(angle * axis) @ onto
        yield Similarity(R, H, ground[first] - R @ model[first] / H)


def grid(problem: AbsoluteProblem, tilts: tuple[float, ...]) -> Iterator[Similarity]:
    """theta every 30 degrees with t and the translation by linear least squares; where t comes out negative, none."""
    for tilt in tilts:
        sides = (0.0,) if tilt == 0 else (0.0, np.pi / 2, np.pi, 3 * np.pi / 2)
        for side in sides:
            leaning = rotation_exp(tilt * np.array([np.cos(side), np.sin(side), 0.0]))
            for theta in np.arange(0.0, 2 * np.pi - 1e-9, STEP):
                start = _with_linear_elements(problem, leaning @ rotation_exp([0.0, 0.0, theta]))
                if start is not None:
                    yield start


def _with_linear_elements(problem: AbsoluteProblem, rotation: FloatArray) -> Similarity | None:
    """t and C that fit a given rotation best."""
    guess = _ratio_of_extents(problem)
    arms = problem.model @ rotation.T * guess
    translation = np.broadcast_to(np.eye(3) * problem.extent, (len(arms), 3, 3))
    rows = np.concatenate([arms[:, :, None], translation, problem.ground[:, :, None]], axis=2)
    white = problem.weight(rotation, guess).whiten(np.asarray(problem.known @ rows)).reshape(-1, 5)
    gain, *centre = np.linalg.lstsq(white[:, :4], white[:, 4], rcond=1e-10)[0]
    if gain < -SMALLEST_GAIN:
        return None
    t = guess if gain < SMALLEST_GAIN else gain * guess
    return Similarity(rotation, float(1 / t), np.array(centre) * problem.extent)


def _ratio_of_extents(problem: AbsoluteProblem) -> float:
    """t guessed from the spread of the known coordinates; of the plan, when there is one."""
    by_plan = np.rint(np.trace(problem.known, axis1=1, axis2=2)) >= 2
    chosen = by_plan if np.count_nonzero(by_plan) >= 2 else np.ones(len(by_plan), dtype=bool)
    x = problem.model[chosen] - problem.model[chosen].mean(axis=0)
    P = problem.ground[chosen] - problem.ground[chosen].mean(axis=0)
    known = problem.known[chosen]
    on_ground = np.sum((known @ P[:, :, None]) ** 2)
    in_model = np.sum((known @ x[:, :, None]) ** 2)
    return float(np.sqrt(on_ground / in_model)) if min(on_ground, in_model) > 0 else 1.0


def _most_distant(points: FloatArray) -> tuple[int, int]:
    """The point farthest from the first, and the one farthest from that."""
    first = int(np.argmax(np.linalg.norm(points - points[0], axis=1)))
    return first, int(np.argmax(np.linalg.norm(points - points[first], axis=1)))


def _triad(axis: FloatArray) -> FloatArray:
    """A rotation whose first column is the axis."""
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    second = np.cross(axis, other)
    second = second / np.linalg.norm(second)
    return np.column_stack([axis, second, np.cross(axis, second)])
