"""Seed 003 on a real photo: do its conditions hold, and if they do, its two parts of Q and K beside the rigorous ones.

The formulas are for a vertical photo of flat ground with errorless control. Each condition becomes a row; without all
conditions of the normal case nothing is computed by them. Source: seed 003 (7)-(21), EQUATIONS 3.1, 3.2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos

import numpy as np

from orient.geometry.vertical_photo import SCALED_ELEMENTS, normalised
from orient.pipeline.tables import Array, named_packed_rows
from orient.solvers import mishchenko
from orient.units import DEGREES_PER_RADIAN
from orient.values import Row, Tables

NEAR_VERTICAL_DEG = 3.0
"""What photogrammetry calls a near-vertical photo."""
FLAT = 0.02
"""Relief in flying heights: 1 % changes K by half a percent, 20 % by 6 to 20 % (EQUATIONS 3.2)."""
EQUAL = 0.01
AGREEMENT = 0.05
"""Sigmas of the normal case further than this from the rigorous ones are not shown."""
CENTRED = 1e-3
"""A sum per control point, in units of c: for c = 100 mm 0.1 mm, more than any reading error."""
NORMAL_CASE = "normal case"


@dataclass(frozen=True, slots=True)
class Case:
    """A photo as seed 003 sees it.

    `control` (n, 2), `image` (m, 2) of the new points [mm]; `heights` (m,) of the points, `station_height` [m];
    `reading` (m, 2, 2) covariance of each reading, `K` (m, 2) variance of the orientation along the image axes, both
    in the scale of the image [mm^2] and from the adjustment; `adjusted`: control points that have errors of
    their own, `estimated`: elements of the camera that were unknowns.
    """

    control: Array
    points: Sequence[str]
    image: Array
    heights: Array
    station_height: float
    rotation: Array
    f_mm: float
    reading: Array
    K: Array
    adjusted: int
    estimated: int = 0


@dataclass(frozen=True, slots=True)
class Parts:
    """Q = Q^(f,c) + Q^(xi,eta) of the layout, and the sums of K^(f,c) and K^(xi,eta) at the points (m, 2)."""

    Q: mishchenko.Decomposition
    focal_sum: Array
    focal_largest: Array
    layout_sum: Array
    rigorous: Array

    @property
    def apart(self) -> float:
        """Largest relative difference of a sigma from the rigorous one."""
        return float(np.max(np.abs(np.sqrt(self.layout_sum / self.rigorous) - 1.0)))


def normal_case_tables(case: Case) -> Tables:
    """`closed_form_condition`; with all conditions of the normal case also `focal_cofactor` and `focal_sum`."""
    of_photo, of_layout = _of_photo(case), _of_layout(case)
    parts = _parts(case) if all(row["is_met"] for row in of_photo) else None
    apart = None if parts is None else parts.apart
    agrees = _condition("sigmas by (3) as the adjustment finds them", NORMAL_CASE, apart, AGREEMENT)
    conditions = [*of_photo, agrees, *of_layout]
    tables = {"closed_form_condition": [{"seq": seq, **row} for seq, row in enumerate(conditions, 1)]}
    if parts is None or not agrees["is_met"]:
        return tables
    return {**tables, "focal_cofactor": _cofactor_rows(case, parts), "focal_sum": _sum_rows(case, parts)}


def _of_photo(case: Case) -> list[Row]:
    """Vertical, flat, errorless control, equal readings."""
    tilt = acos(max(-1.0, min(float(case.rotation[2, 2]), 1.0))) * DEGREES_PER_RADIAN
    level = float(np.mean(case.heights))
    height, relief = case.station_height - level, float(np.max(np.abs(case.heights - level)))
    typical = float(np.mean(np.trace(case.reading, axis1=1, axis2=2))) / 2.0
    uneven = float(np.max(np.abs(case.reading / typical - np.eye(2))))
    camera = [_condition("camera known: elements that were estimated", NORMAL_CASE, float(case.estimated), 0.0)]
    return [
        *(camera if case.estimated else []),
        _condition("camera axis vertical: tilt in degrees", NORMAL_CASE, tilt, NEAR_VERTICAL_DEG),
        _condition("ground flat: relief in flying heights", NORMAL_CASE, relief / height if height > 0 else None, FLAT),
        _condition("control without errors: points that have them", NORMAL_CASE, float(case.adjusted), 0.0),
        _condition("readings of equal weight: relative difference", NORMAL_CASE, uneven, EQUAL),
    ]


def _of_layout(case: Case) -> list[Row]:
    """The sums of the layout, for one control point."""
    points, _ = normalised(case.control)
    return [
        _condition(each.name, "separation" if each.separates else "one D", each.value / len(points), CENTRED)
        for each in mishchenko.conditions(points)
    ]


def _condition(text: str, needed_for: str, value: float | None, limit: float) -> Row:
    is_met = value is not None and abs(value) <= limit
    return {
        "condition": text,
        "needed_for": needed_for,
        "value": value,
        "limit_value": limit,
        "is_met": int(is_met),
    }


def _parts(case: Case) -> Parts:
    points, c = normalised(case.control)
    g = (case.f_mm / c) ** 2
    Q = mishchenko.decomposition(points, g)
    unit = float(np.mean(np.trace(case.reading, axis1=1, axis2=2))) / 2.0
    return Parts(Q, *mishchenko.element_sums(case.image / c, Q, g), case.K / unit)


def _cofactor_rows(case: Case, parts: Parts) -> list[Row]:
    points, c = normalised(case.control)
    determinants = mishchenko.symmetry(points, CENTRED).determinants
    closed = mishchenko.closed_form(points, (case.f_mm / c) ** 2, determinants).Q if determinants else None
    rows = named_packed_rows(parts.Q.focal, SCALED_ELEMENTS)
    return [
        {
            **{key: value for key, value in row.items() if key != "value"},
            "by_focal_length": row["value"],
            "by_layout": float(parts.Q.layout[i, j]),
            "closed_form": None if closed is None else float(closed[i, j]),
        }
        for row, i, j in zip(rows, *np.triu_indices(len(SCALED_ELEMENTS)), strict=True)
    ]


def _sum_rows(case: Case, parts: Parts) -> list[Row]:
    return [
        {
            "point": point,
            "axis": axis,
            "focal_sum": float(parts.focal_sum[i, k]),
            "focal_largest": float(parts.focal_largest[i, k]),
            "layout_sum": float(parts.layout_sum[i, k]),
            "rigorous": float(parts.rigorous[i, k]),
        }
        for i, point in enumerate(case.points)
        for k, axis in enumerate("xy")
    ]
