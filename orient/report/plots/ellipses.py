"""The ground from above: control and check points with their standard error ellipses."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from orient.report.language import mark, tr
from orient.report.plots import PlotData
from orient.report.plots.canvas import (
    COLOURS,
    Array,
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

KM = 1000.0
ROOM, ROOM_OF_ONE = 0.1, 0.6
"""Largest semi-axis, as part of the ground that is shown: at most, and times the square root of the points."""
WIDE_M = 5000.0
AXES = {
    "topocentric": (mark("Y, grid east"), mark("X, grid north")),
    "local_left": (mark("Y"), mark("X")),
    "local_right": (mark("X"), mark("Y")),
}


def draw(data: PlotData) -> "Figure":
    """The figure: north (or Y of right-handed local ground) up; ellipses magnified as the bar says."""
    every = data.tables["covariance"]["ground_covariance"]
    rows = largest_first(every, numbers(every, "ellipse_a_m")[:, 0])
    kind = str(data.tables["topocentric"]["topocentric_frame"][0]["kind"])
    places = numbers(rows, "X_m", "Y_m")
    azimuth = numbers(rows, "ellipse_azimuth_deg")[:, 0]
    angle = azimuth if kind == "local_right" else 90.0 - azimuth
    if kind != "local_right":
        places = places[:, ::-1]
    unit, name = (KM, tr("km")) if float(np.max(np.ptp(places, axis=0))) > WIDE_M else (1.0, tr("m"))
    places = places / unit
    axes_a, axes_b = numbers(rows, "ellipse_a_m", "ellipse_b_m").T
    extent = float(np.max(np.ptp(places, axis=0))) or 1.0
    scale, bar = magnification(float(np.max(axes_a)), min(ROOM, ROOM_OF_ONE / len(rows) ** 0.5) * extent)
    median = np.median(numbers(every, "ellipse_a_m"))
    title = tr("Standard error ellipses (39 %), median semi-major axis {median} m", median=f"{median:.3g}")
    figure, axes = new_figure(title_of_part(title, len(rows), len(every)), source(data))
    _limit(axes, places, scale * axes_a)
    _draw_ellipses(axes, [str(row["role"]) for row in rows], places, scale * np.column_stack([axes_a, axes_b]), angle)
    draw_points(axes, rows, places)
    if bar > 0:
        draw_scale(
            axes, scale * bar, tr("semi-axis {size} m ({times} times)", size=f"{bar:g}", times=f"{scale * unit:g}")
        )
    east, north = AXES[kind]
    axes.set_xlabel(f"{tr(east)}, {name}")
    axes.set_ylabel(f"{tr(north)}, {name}")
    axes.ticklabel_format(useOffset=False, style="plain")
    axes.locator_params(nbins=6)
    draw_legend(figure)
    return figure


def _limit(axes: "Axes", places: Array, reach: Array) -> None:
    """Room for every ellipse, and for the bar below."""
    low, high = (places - reach[:, None]).min(axis=0), (places + reach[:, None]).max(axis=0)
    margin = 0.04 * float(np.max(high - low))
    axes.set_xlim(float(low[0]) - margin, float(high[0]) + margin)
    axes.set_ylim(float(low[1]) - 2.5 * margin, float(high[1]) + margin)


def _draw_ellipses(axes: "Axes", roles: Sequence[str], places: Array, semi_axes: Array, angle: Array) -> None:
    """`semi_axes` (n, 2) in units of the axes, `angle` (n,) of the first one, degrees anticlockwise from the right."""
    from matplotlib.collections import EllipseCollection

    for role, colour in COLOURS.items():
        chosen = [i for i, each in enumerate(roles) if each == role]
        axes.add_collection(
            EllipseCollection(
                2 * semi_axes[chosen, 0],
                2 * semi_axes[chosen, 1],
                angle[chosen],
                units="xy",
                offsets=places[chosen],
                offset_transform=axes.transData,
                facecolors="none",
                edgecolors=colour,
                linewidths=0.9,
            )
        )
