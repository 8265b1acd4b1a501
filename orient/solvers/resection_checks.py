"""Control that cannot determine a photo is refused by name, before any adjustment."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.solvers.ground_points import GroundKnowledge
from orient.words import counted

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

LINE = 1e-7
COINCIDING = 1e-9
POINTS_NEEDED = 3


def check_control(
    image: FloatArray,
    image_cofactor: FloatArray,
    known: GroundKnowledge,
    full: BoolArray,
    names: Sequence[str],
    n_elements: int = 6,
    n_known: int = 0,
) -> None:
    """Refuse, naming the points: non-finite numbers, unknown points, coinciding points, points on a line, too few.

    `n_elements` are unknown, `n_known` equations say what is known of them.
    """
    _check_numbers(image, image_cofactor, known, names)
    _check_known(known, names)
    n_full = int(np.count_nonzero(full))
    if n_full < POINTS_NEEDED:
        many = counted(n_full, "control point has", "control points have")
        raise GeometryError(
            f"{many} three known coordinates, a resection needs at least 3.",
            "Measure more control points in the photo.",
        )
    full_names = [name for name, is_full in zip(names, full, strict=True) if is_full]
    _check_coinciding(image, names, "in the photo")
    _check_coinciding(known.given[full], full_names, "on the ground")
    _check_line(known.given[full], "on a line", "m")
    _check_line(image[full], "on a line in the photo", "mm")
    equations = 2 * len(image) + int(known.weight_rank.sum()) + n_known
    unknowns = n_elements + int(known.free_rank.sum())
    if unknowns > equations:
        raise GeometryError(
            f"The resection lacks {counted(unknowns - equations, 'equation')}: {equations} for {unknowns} unknowns.",
            "Measure more control points in the photo.",
        )


def _check_numbers(image: FloatArray, image_cofactor: FloatArray, known: GroundKnowledge, names: Sequence[str]) -> None:
    sound = np.isfinite(image).all(axis=1) & np.isfinite(known.given).all(axis=1)
    sound &= np.isfinite(known.weight_root).all(axis=(1, 2)) & np.isfinite(image_cofactor).all(axis=(1, 2))
    if not sound.all():
        name = names[int(np.argmin(sound))]
        raise GeometryError(f"Point {name} has a coordinate or weight that is no finite number.")
    determinants = image_cofactor[:, 0, 0] * image_cofactor[:, 1, 1] - image_cofactor[:, 0, 1] * image_cofactor[:, 1, 0]
    positive = (image_cofactor[:, 0, 0] > 0) & (determinants > 0)
    if not positive.all():
        raise GeometryError(
            f"The covariance of the image coordinates of point {names[int(np.argmin(positive))]} is not positive.",
            "Give standard deviations above zero.",
        )


def _check_known(known: GroundKnowledge, names: Sequence[str]) -> None:
    """A point that is unknown in all three directions could lie anywhere on its ray."""
    nothing = known.free_rank - known.weight_rank >= 3
    if nothing.any():
        raise GeometryError(
            f"Point {names[int(np.argmax(nothing))]} has no known ground coordinate.",
            "Give its plan position or its height, or leave it out of the control.",
        )


def _check_coinciding(points: FloatArray, names: Sequence[str], where: str) -> None:
    """Two points at the same place: sorted along the longest side, neighbours are compared."""
    extent = np.ptp(points, axis=0)
    order = np.lexsort((points[:, 1 - int(np.argmax(extent[:2]))], points[:, int(np.argmax(extent[:2]))]))
    near = np.max(np.abs(np.diff(points[order], axis=0)), axis=1) <= COINCIDING * np.max(extent)
    if near.any():
        first = int(np.argmax(near))
        raise GeometryError(
            f"Points {names[order[first]]} and {names[order[first + 1]]} coincide {where}.",
            "Correct the coordinates or leave one of them out.",
        )


def width_and_length(points: FloatArray) -> tuple[float, float]:
    """Largest distance from the line that fits the points (n, k) best, and their extent along it."""
    centred = points - points.mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][0]
    along = centred @ axis
    return float(np.max(np.linalg.norm(centred - along[:, None] * axis, axis=1))), float(np.ptp(along))


def _check_line(points: FloatArray, where: str, unit: str) -> None:
    off, length = width_and_length(points)
    if off <= LINE * length:
        raise GeometryError(
            f"The control points lie {where} (off by {off:.2g} {unit} in {length:.6g} {unit}).",
            "Measure a control point away from the line.",
        )
