"""The frame with the residual vectors, computed minus measured, the error ellipses, and their scale."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from orient.report.language import tr
from orient.report.plots import PlotData
from orient.report.plots.canvas import (
    BAR_ROOM,
    COLOURS,
    Array,
    draw_frame,
    draw_legend,
    draw_points,
    draw_scale,
    largest_first,
    magnification,
    new_figure,
    numbers,
    source,
    title_of_part,
)
from orient.values import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MICROMETRES = 1000.0
ROOM, MOST_ROOM = 0.06, 0.35
"""Length of a vector that is longer than nine of ten, and of the longest one, as part of the frame."""
GREEN = "#007a5a"
MOST_ELLIPSES = 60


def draw(data: PlotData) -> "Figure":
    """The figure: x right, y up in mm; vectors v = computed - measured and ellipses, magnified as the bar says."""
    every = data.tables["resection"]["image_residual"]
    rows = largest_first(every, np.hypot(*numbers(every, "vx_mm", "vy_mm").T))
    places, v = numbers(rows, "x_mm", "y_mm"), numbers(rows, "vx_mm", "vy_mm")
    photo = data.tables["photo"]["photo"][0]
    side = float(np.max(numbers([photo], "frame_width_mm", "frame_height_mm")))
    lengths = np.hypot(*v.T)
    scale, bar = magnification(max(np.quantile(lengths, 0.9), np.max(lengths) * ROOM / MOST_ROOM), ROOM * side)
    figure, axes = new_figure(title_of_part(_title(data), len(rows), len(every)), source(data))
    draw_frame(axes, photo, np.vstack([places, places + scale * v]), BAR_ROOM)
    _draw_ellipses(axes, rows, data, scale)
    for role, colour in COLOURS.items():
        chosen = [i for i, row in enumerate(rows) if row["role"] == role]
        axes.quiver(
            *places[chosen].T,
            *(scale * v[chosen]).T,
            angles="xy",
            scale_units="xy",
            scale=1,
            color=colour,
            width=0.0035,
            zorder=2,
        )
    draw_points(axes, rows, places, v)
    if bar > 0:
        size, times = f"{MICROMETRES * bar:g}", f"{scale:g}"
        draw_scale(axes, scale * bar, tr("residual {size} µm ({times} times)", size=size, times=times))
    draw_legend(figure)
    return figure


def _title(data: PlotData) -> str:
    found = data.tables["resection"]["orientation"][0]
    if found["sigma0_mm"] is None:
        return tr("Residuals, computed minus measured; no redundancy")
    sigma0, apriori = (MICROMETRES * float(found[name] or 0.0) for name in ("sigma0_mm", "sigma0_apriori_mm"))
    return tr(
        "Residuals, computed minus measured; sigma0 {sigma0} µm (a priori {apriori} µm)",
        sigma0=f"{sigma0:.3g}",
        apriori=f"{apriori:.3g}",
    )


def _draw_ellipses(axes: "Axes", rows: Sequence[Row], data: PlotData, scale: float) -> None:
    """Standard error ellipses of the ground points in the scale of the image, as large as the vectors are drawn."""
    from matplotlib.patches import Ellipse

    found = data.tables.get("covariance", {}).get("ground_covariance_image", ())
    by_point = {row["point"]: row for row in found}
    chosen = [row for row in rows if row["point"] in by_point]
    if not chosen or len(chosen) > MOST_ELLIPSES:
        return
    places = numbers(chosen, "x_mm", "y_mm")
    shapes: Array = numbers(
        [by_point[row["point"]] for row in chosen], "ellipse_a_mm", "ellipse_b_mm", "ellipse_direction_deg"
    )
    label: str | None = tr("standard ellipse")
    for (x, y), (a, b, direction) in zip(places, shapes, strict=True):
        ellipse = Ellipse(
            (x, y), 2 * scale * a, 2 * scale * b, angle=direction, fill=False, edgecolor=GREEN, linewidth=0.8
        )
        ellipse.set_label(label or "_")
        axes.add_patch(ellipse)
        label = None
