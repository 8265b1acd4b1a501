"""The map of the ground accuracy over the frame: contours of sigma, with the points that carry the orientation."""

from typing import TYPE_CHECKING

import numpy as np

from orient.errors import OrientError
from orient.report.covariance import plan_sigma
from orient.report.language import tr
from orient.report.plots import PlotData
from orient.report.plots.canvas import (
    RED,
    WHITE_BOX,
    Array,
    draw_frame,
    draw_legend,
    draw_points,
    largest_first,
    new_figure,
    numbers,
    source,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEVELS = 8
WIDE_RANGE = 8.0
"""From this ratio of the largest to the smallest sigma on, the levels are 1, 2, 5, 10, ..."""
SAME = 1e-6
BELOW_POINTS = 2
CUBIC, FINE = 3, 121


def draw(data: PlotData) -> "Figure":
    """The figure: x right, y up in mm, sigma = sqrt((sigma_X^2 + sigma_Y^2)/2) in m at the points' mean height."""
    x, y, sigma = _grid(data)
    every = data.tables["resection"]["image_residual"]
    rows = largest_first(every, np.zeros(len(every)))
    title = tr("Ground accuracy: sigma of X and Y of a new point, in m")
    figure, axes = new_figure(title, source(data), width=7.2)
    seen = sigma[np.isfinite(sigma)]
    if seen.max() > seen.min() * (1 + SAME):
        _draw_contours(axes, *_finer(x, y, sigma))
    draw_frame(axes, data.tables["photo"]["photo"][0], np.zeros((0, 2)))
    draw_points(axes, rows, numbers(rows, "x_mm", "y_mm"))
    smallest, largest = np.nanargmin(sigma), np.nanargmax(sigma)
    for place, word, sign in ((smallest, tr("best"), "s"), (largest, tr("worst"), "x")):
        at = (float(x[place % len(x)]), float(y[place // len(x)]))
        axes.plot(
            *at,
            sign,
            color=RED,
            fillstyle="none",
            markersize=6,
            markeredgewidth=1.5,
            linestyle="none",
            label=f"{word} {sigma.flat[place]:.3g} m",
        )
    draw_legend(figure)
    return figure


def _grid(data: PlotData) -> tuple[Array, Array, Array]:
    """x (k,), y (k,) [mm] and sigma (k, k) [m], NaN where the place sees no ground."""
    rows = data.tables["covariance"].get("ground_accuracy", ())
    if not rows:
        raise OrientError("this version of covariance has no map of the frame", "Run: orient covariance PROJECT")
    side = max(int(row["place"] or 0) for row in rows)
    sigma = np.array([np.nan if value is None else value for value in map(plan_sigma, rows)]).reshape(-1, side)
    if not np.isfinite(sigma).any():
        raise OrientError("no place of the frame sees the ground", "A photo that looks at the sky has no such map.")
    places = numbers(rows, "x_mm", "y_mm")
    return places[:side, 0], places[::side, 1], sigma


def _finer(x: Array, y: Array, sigma: Array) -> tuple[Array, Array, Array]:
    """The same surface with rounder contours: a bicubic spline through the places, if all of them see ground."""
    from scipy.interpolate import RectBivariateSpline

    if min(len(x), len(y)) <= CUBIC or not np.isfinite(sigma).all():
        return x, y, sigma
    # y runs down the frame, a spline wants it to rise
    surface = RectBivariateSpline(y[::-1], x, sigma[::-1], kx=CUBIC, ky=CUBIC)
    fine_x, fine_y = np.linspace(x[0], x[-1], FINE), np.linspace(y[-1], y[0], FINE)
    return fine_x, fine_y, np.asarray(surface(fine_y, fine_x))


def _draw_contours(axes: "Axes", x: Array, y: Array, sigma: Array) -> None:
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    levels = _levels(float(np.nanmin(sigma)), float(np.nanmax(sigma)))
    pale = LinearSegmentedColormap.from_list("pale", ["#f7fbff", "#c6dbef", "#6baed6", "#2171b5"])
    shades = axes.contourf(x, y, sigma, levels=levels, cmap=pale, extend="both", norm=LogNorm())
    lines = axes.contour(x, y, sigma, levels=levels, colors="#08306b", linewidths=0.7)
    for text in axes.clabel(lines, fmt="%g", fontsize=8, colors="#08306b"):
        text.set_bbox(WHITE_BOX)
        text.set_zorder(BELOW_POINTS)
    bar = axes.figure.colorbar(shades, ax=axes, shrink=0.8, pad=0.02, ticks=levels, format="%g")
    bar.set_label(tr("sigma, m"))
    bar.minorticks_off()


def _levels(low: float, high: float) -> Array:
    """Round levels inside low ... high; one more on each side when there would be too few."""
    from matplotlib.ticker import LogLocator, MaxNLocator

    if high > WIDE_RANGE * low:
        found = LogLocator(base=10.0, subs=(1.0, 2.0, 5.0)).tick_values(low, high)
    else:
        found = MaxNLocator(LEVELS).tick_values(low, high)
    levels = np.asarray(found, dtype=np.float64)
    inside = levels[(levels > low) & (levels < high)]
    return inside if len(inside) > 1 else levels[levels > 0]
