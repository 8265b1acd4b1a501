"""The frame with the residual vectors, computed minus measured, and their scale."""

from typing import TYPE_CHECKING

import numpy as np

from orient.report.plots import PlotData
from orient.report.plots.canvas import (
    BAR_ROOM,
    COLOURS,
    draw_frame,
    draw_legend,
    draw_points,
    draw_scale,
    magnification,
    new_figure,
    numbers,
    source,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MICROMETRES = 1000.0
ROOM, MOST_ROOM = 0.06, 0.35
"""Length of a vector that is longer than nine of ten, and of the longest one, as part of the frame."""


def draw(data: PlotData) -> "Figure":
    """The figure: x right, y up in mm; vectors v = computed - measured, magnified as the bar says."""
    rows = data.tables["resection"]["image_residual"]
    places, v = numbers(rows, "x_mm", "y_mm"), numbers(rows, "vx_mm", "vy_mm")
    photo = data.tables["photo"]["photo"][0]
    side = float(np.max(numbers([photo], "frame_width_mm", "frame_height_mm")))
    lengths = np.hypot(*v.T)
    scale, bar = magnification(max(np.quantile(lengths, 0.9), np.max(lengths) * ROOM / MOST_ROOM), ROOM * side)
    figure, axes = new_figure(_title(data), source(data))
    draw_frame(axes, photo, np.vstack([places, places + scale * v]), BAR_ROOM)
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
        draw_scale(axes, scale * bar, f"residual {MICROMETRES * bar:g} µm ({scale:g} times)")
    draw_legend(figure)
    return figure


def _title(data: PlotData) -> str:
    found = data.tables["resection"]["orientation"][0]
    if found["sigma0_mm"] is None:
        return "Residuals, computed minus measured; no redundancy"
    sigma0, apriori = (MICROMETRES * float(found[name] or 0.0) for name in ("sigma0_mm", "sigma0_apriori_mm"))
    return f"Residuals, computed minus measured; sigma0 {sigma0:.3g} µm (a priori {apriori:.3g} µm)"
