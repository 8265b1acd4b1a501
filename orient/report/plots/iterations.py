"""How the adjustment converged: the sum of squares and the steps, and the correction of every element."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from orient.errors import OrientError, UsageError
from orient.report.language import tr
from orient.report.plots import PlotData
from orient.report.plots.canvas import BLUE, GREY, RED, Array, numbers, panels, shown_name, source
from orient.units import DEGREES_PER_RADIAN
from orient.values import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHADES = ("#0072b2", "#d55e00", "#007a5a", "#cc79a7", "#e69f00", "#56b4e9", "#222222", "#888888")
SIGNS = ("o", "^", "s", "D", "v", "P", "X", "*")
TABLES = {
    "resection": ("iteration", "iteration_parameter"),
    "absolute": ("absolute_iteration", "absolute_iteration_parameter"),
}
MOST_CURVES = 16


def draw(data: PlotData) -> "Figure":
    """Three panels over the iterations: v'Pv and the largest step, corrections in angle, corrections in the others."""
    stage = next(name for name in TABLES if name in data.tables)
    steps, parameters = (_of_part(data.tables[stage].get(name, ()), data.part) for name in TABLES[stage])
    if not steps:
        raise OrientError("this version has no iterations", "See what happened: orient show PROJECT")
    elements = [row for row in parameters if not row.get("point")]
    title = tr("How the adjustment converged: {n} iterations", n=len(steps))
    if "zone" in steps[0]:
        title += "; " + tr("zone {zone}", zone=shown_name(str(steps[0]["zone"])))
    figure, (above, angles, others) = panels(title, source(data), 3)
    _draw_steps(above, steps)
    turned = [row for row in elements if row["unit"] in ("rad", "deg")]
    _draw_corrections(angles, turned, tr("angles: |correction|, deg"))
    rest = [row for row in elements if row["unit"] not in ("rad", "deg")]
    _draw_corrections(others, rest, tr("others: |correction|, own unit"))
    others.set_xlabel(tr("iteration"))
    return figure


def _of_part(rows: Sequence[Row], part: str) -> list[Row]:
    """Rows of the zone, or of the first one; a resection has no zones."""
    if not rows or "zone" not in rows[0]:
        return list(rows)
    zone, zones = part or rows[0]["zone"], list(dict.fromkeys(str(row["zone"]) for row in rows))
    if zone not in zones:
        raise UsageError(f'there is no zone "{shown_name(part)}"', f"Zones are {', '.join(zones)}.")
    return [row for row in rows if row["zone"] == zone]


def _draw_steps(axes: "Axes", steps: Sequence[Row]) -> None:
    count, vPv, step = numbers(steps, "iteration", "vPv", "max_scaled_step").T
    axes.set_yscale("log")
    axes.plot(count, _visible(vPv), "o-", color=BLUE, markersize=4, label="v′Pv")
    axes.plot(count, _visible(step), "^--", color=RED, markersize=4, label=tr("largest scaled step"))
    _finish(axes, tr("v′Pv, largest step"), count)


def _draw_corrections(axes: "Axes", rows: Sequence[Row], label: str) -> None:
    names = list(dict.fromkeys(str(row["unknown"]) for row in rows))[:MOST_CURVES]
    axes.set_yscale("log")
    count: Array = np.zeros(0)
    for i, name in enumerate(names):
        chosen = [row for row in rows if row["unknown"] == name]
        count, change = numbers(chosen, "iteration", "correction").T
        factor = DEGREES_PER_RADIAN if chosen[0]["unit"] == "rad" else 1.0
        unit = chosen[0]["unit"]
        told = name if unit in ("rad", "deg", "1") else f"{name}, {unit}"
        sign, colour = SIGNS[i % len(SIGNS)], SHADES[i % len(SHADES)]
        axes.plot(count, _visible(np.abs(change) * factor), f"{sign}-", color=colour, markersize=4, label=told)
    _finish(axes, label, count)


def _visible(values: Array) -> Array:
    """A logarithmic axis has no zero."""
    return np.where(values > 0, values, np.nan)


def _finish(axes: "Axes", label: str, count: Array) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0e}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel(label, fontsize=8)
    axes.grid(color=GREY, alpha=0.25, linewidth=0.5)
    axes.tick_params(labelsize=8)
    if len(count):
        axes.legend(fontsize=7.5, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.03), borderaxespad=0.2)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
