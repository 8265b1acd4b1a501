"""Control that is refused, or left out, before any adjustment: points on a line, points in another country."""

from collections.abc import Sequence

import numpy as np

from orient.errors import GeometryError
from orient.pipeline.tables import Array
from orient.solvers.resection_checks import width_and_length
from orient.units import in_words
from orient.values import Event

LINE = 2e-5
"""Width over length of control that no ground survey can tell from a line: 1.6 mm in 80 m."""
GATES = {"space": 20.0, "aerial": 20.0, "terrestrial": 1000.0}
"""Distance from the middle of the control, in median distances, beyond which a point is no control of this photo."""
ENOUGH = 4


def check_line(ground: Array) -> None:
    """Refuse control points (n, 3) [m] that lie on a line, or so near to one that nothing would hold the photo."""
    off, length = width_and_length(ground)
    if off <= LINE * length:
        raise GeometryError(
            f"control points lie on a line (off by {in_words(off)} in {in_words(length)}): "
            "the orientation is not determined",
            "Measure a control point away from the line.",
        )


def without_far_points(
    ground: Array, is_full: Array, points: Sequence[str], platform: str
) -> tuple[list[int], list[Event]]:
    """Indices of the points to use, and an event for each full one that is left out as a gross error.

    The gate is a multiple of the median distance of the full points from their median: a terrestrial photo may show
    the next house and a summit, a photo from above cannot show another country. Not asked of fewer than four points.
    """
    full = np.flatnonzero(is_full)
    everyone = list(range(len(points)))
    if len(full) < ENOUGH:
        return everyone, []
    distances = np.linalg.norm(ground[full] - np.median(ground[full], axis=0), axis=1)
    median, gate = float(np.median(distances)), GATES[platform]
    far = {int(i): float(d) for i, d in zip(full, distances, strict=True) if d > gate * median}
    events = [
        Event(
            "warning",
            "far_point",
            points[i],
            f"{points[i]} lies {in_words(distance)} from the middle of the control, beyond {gate:.0f} times the median "
            f"distance of {in_words(median)}: not used",
            distance,
        )
        for i, distance in far.items()
    ]
    return [i for i in everyone if i not in far], events
