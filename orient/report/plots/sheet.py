"""A map sheet on the digitiser with its crosses, their residuals and the points that were read."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from orient.errors import UsageError
from orient.report.language import tr, trn
from orient.report.plots import PlotData
from orient.report.plots.canvas import (
    BAR_ROOM,
    BLUE,
    GREY,
    INK,
    MARGIN,
    RED,
    Array,
    draw_legend,
    draw_scale,
    label_points,
    largest_first,
    magnification,
    new_figure,
    numbers,
    shown_name,
    source,
    title_of_part,
)
from orient.units import RADIANS_PER_DEGREE
from orient.values import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREEN = "#007a5a"
ROOM = 0.15
"""Length of the longest vector, as part of the sheet."""
ROLES = {"fit": (BLUE, "+"), "check": (RED, "x"), "rejected": (GREY, "x")}
SPHERE_M = 6_371_000.0
"""Radius where the photo's ground has no ellipsoid; it only turns the vectors of one sheet by a common scale."""


def draw(data: PlotData) -> "Figure":
    """The figure: digitiser X right, Y up in mm; vectors v = polynomial minus given, in metres on the ground."""
    name = _name(data)
    every = [{**_reading(row, data), **row} for row in _of_sheet(data, "digitize", "cross_residual", name)]
    v = numbers(every, "v_E_m", "v_N_m")
    rows = largest_first(every, np.hypot(*v.T))
    places, v = numbers(rows, "X_mm", "Y_mm"), numbers(rows, "v_E_m", "v_N_m")
    points = _of_sheet(data, "digitize", "digitized_point", name)
    arrows = v @ np.linalg.inv(_metres_per_mm(every, data.tables["photo"]["photo"][0])).T
    lengths = np.hypot(*arrows.T)
    longest = int(np.argmax(lengths))
    side = float(np.max(np.ptp(places, axis=0)))
    scale, bar = magnification(float(np.hypot(*v[longest])), ROOM * side)
    factor = scale * float(np.hypot(*v[longest])) / lengths[longest] if lengths[longest] > 0 else 1.0
    title = title_of_part(_title(data, name), len(rows), len(every))
    figure, axes = new_figure(title, source(data))
    _limit(axes, np.vstack([places, places + factor * arrows, numbers(points, "X_mm", "Y_mm")]))
    _draw_crosses(axes, rows, places, factor * arrows)
    if points:
        label = trn("{n} map point", "{n} map points", len(points))
        axes.plot(*numbers(points, "X_mm", "Y_mm").T, "o", markersize=3, color=GREEN, linestyle="none", label=label)
    label_points(axes, [str(row["cross"]) for row in rows], places, factor * arrows)
    if bar > 0:
        draw_scale(axes, scale * bar, tr("residual {size} m on the ground", size=f"{bar:g}"))
    axes.set_xlabel(tr("digitiser X, mm"))
    axes.set_ylabel(tr("digitiser Y, mm"))
    draw_legend(figure)
    return figure


def _name(data: PlotData) -> str:
    names = [str(row["sheet"]) for row in data.tables["digitize"]["sheet_transform"]]
    if data.part and data.part not in names:
        raise UsageError(f'there is no sheet "{shown_name(data.part)}"', f"Sheets are {', '.join(names)}.")
    if not data.part and len(names) > 1:
        raise UsageError("there are several sheets", f"Name one: --part {' | '.join(names)}")
    return data.part or names[0]


def _title(data: PlotData, name: str) -> str:
    row = next(row for row in data.tables["digitize"]["sheet_transform"] if row["sheet"] == name)
    told = tr("Sheet {sheet}, polynomial of degree {degree}", sheet=shown_name(name), degree=row["degree"])
    if row["sigma0_N_m"] is None:
        return told
    north, east = (f"{float(row[key] or 0.0):.3g}" for key in ("sigma0_N_m", "sigma0_E_m"))
    return told + "; " + tr("sigma0 {north} m north, {east} m east", north=north, east=east)


def _of_sheet(data: PlotData, stage: str, table: str, name: str) -> list[Row]:
    return [row for row in data.tables[stage].get(table, ()) if row["sheet"] == name]


def _reading(row: Row, data: PlotData) -> Row:
    """What was read and given of a cross."""
    keys = ("sheet", "cross")
    crosses = data.tables["sheet"]["graticule_cross"]
    return next(given for given in crosses if all(given[key] == row[key] for key in keys))


def _metres_per_mm(rows: Sequence[Row], photo: Row) -> Array:
    """(2, 2) d(E, N)/d(X, Y): the sheet's scale and direction on the table, by least squares over its crosses."""
    places = numbers(rows, "X_mm", "Y_mm")
    ground = _ground(rows, photo)
    solved = np.linalg.lstsq(places - places.mean(axis=0), ground - ground.mean(axis=0), rcond=None)[0]
    return np.asarray(solved.T, dtype=np.float64)


def _ground(rows: Sequence[Row], photo: Row) -> Array:
    """(n, 2) east, north [m] of the crosses, near enough to draw by."""
    if rows[0]["E_m"] is not None:
        return numbers(rows, "E_m", "N_m")
    radius = SPHERE_M if photo["a_m"] is None else float(photo["a_m"])
    latitude, longitude = numbers(rows, "B_deg", "L_deg").T * RADIANS_PER_DEGREE
    return radius * np.column_stack([longitude * math.cos(float(latitude.mean())), latitude])


def _limit(axes: "Axes", reach: Array) -> None:
    low, high = reach.min(axis=0), reach.max(axis=0)
    extent = float(np.max(high - low))
    axes.set_xlim(float(low[0]) - 2 * MARGIN * extent, float(high[0]) + MARGIN * extent)
    axes.set_ylim(float(low[1]) - BAR_ROOM * extent, float(high[1]) + MARGIN * extent)


def _draw_crosses(axes: "Axes", rows: Sequence[Row], places: Array, arrows: Array) -> None:
    for role, (colour, sign) in ROLES.items():
        chosen = [i for i, row in enumerate(rows) if row["role"] == role]
        if not chosen:
            continue
        told = _counted(role, len(chosen))
        axes.plot(*places[chosen].T, sign, color=INK, markersize=7, linestyle="none", label=told)
        axes.quiver(
            *places[chosen].T, *arrows[chosen].T, angles="xy", scale_units="xy", scale=1, color=colour, width=0.0035
        )


def _counted(role: str, n: int) -> str:
    if role == "fit":
        return trn("{n} cross of the fit", "{n} crosses of the fit", n)
    if role == "check":
        return trn("{n} check cross", "{n} check crosses", n)
    return trn("{n} rejected cross", "{n} rejected crosses", n)
