"""The absolute orientation for people, zone by zone: elements in three forms, residuals, iterations, ground points."""

import math
from collections.abc import Callable, Sequence

from orient.report.orientation import AXES, Shown, iteration_table
from orient.report.reliability import sentences
from orient.report.text import cell, number
from orient.values import Row, Scalar, Tables

FORMS = {
    "homothety": ("X_G = R x/H + X0 (2')", ("xi", "eta", "theta", "H", "X_0", "Y_0", "Z_0")),
    "joint": ("X_G = (R x + T)/H (4')", ("xi", "eta", "theta", "H", "T_X", "T_Y", "T_Z")),
    "scale": ("X_G = X0 + t R x (108)", ("X_0", "Y_0", "Z_0", "t", "xi", "eta", "theta")),
}
DECIMALS = {"deg": 7, "m": 4}
V = ("vX_m", "vY_m", "vZ_m")
REDUNDANCY = ("redundancy_X", "redundancy_Y", "redundancy_Z")


def absolute_zones(tables: Tables) -> list[str]:
    """Zones in order of appearance; a run that failed has iterations only."""
    return list(dict.fromkeys(str(row["zone"]) for row in tables.get("absolute_iteration", ())))


def absolute_lines(zone: str, tables: Tables) -> list[str]:
    """Sentences about the adjustment of the zone as a whole."""
    orientations = _of_zone(zone, tables, "absolute_orientation")
    if not orientations:
        return ["", f"Zone {zone}"]
    (row,) = orientations
    return [
        "",
        f"Zone {zone}: {row['n_full']} full, {row['n_plan']} plan-only, {row['n_height']} height-only control points",
        f"n = {row['n_equations']} equations, u = {row['n_unknowns']} unknowns, redundancy r = {row['redundancy']}",
        f"sigma0 = sqrt(v'Pv/r) {_sigma0(row)}",
        f"standard deviations are scaled by sigma0 {row['variance_basis']}",
        *(text for test in tables.get("adjustment_test", ()) if test["part"] == zone for text in sentences(test)),
    ]


def _sigma0(row: Row) -> str:
    if row["sigma0"] is None:
        return "no redundancy: unknown"
    if row["sigma0_unit"] == "m":
        return f"= {number(row['sigma0']):.4g} m, equal weights on the ground"
    return f"= {number(row['sigma0']):.4g}, weights from covariances (1 is as expected)"


def absolute_tables(zone: str, tables: Tables, most: int) -> list[Shown]:
    """Title, headers, cells of each table that has rows."""
    makers: tuple[tuple[str, Callable[[Sequence[Row], int], list[Shown]]], ...] = (
        ("absolute_element", _elements),
        ("absolute_residual", _residuals),
        ("absolute_alternative", _alternatives),
        ("absolute_small_angle", _small_angles),
        ("absolute_iteration", _iterations),
        ("model_ground_point", _ground_points),
    )
    frame = [f" ({AXES[str(row['frame'])]})" for row in _of_zone(zone, tables, "absolute_orientation")]
    shown = [table for name, make in makers if (rows := _of_zone(zone, tables, name)) for table in make(rows, most)]
    return [(title.replace("{frame}", "".join(frame)), headers, cells) for title, headers, cells in shown]


def _of_zone(zone: str, tables: Tables, table: str) -> list[Row]:
    return [row for row in tables.get(table, ()) if row["zone"] == zone]


def _elements(rows: Sequence[Row], most: int) -> list[Shown]:
    """One table for each form, in the order of its paper."""
    found = {(row["view"], row["unknown"]): row for row in rows}
    return [
        (
            f"{form}{{frame}}" if view == "homothety" else form,
            ["element", "value", "sigma"],
            [_element(found[view, name]) for name in names],
        )
        for view, (form, names) in FORMS.items()
    ]


def _element(row: Row) -> list[str]:
    note = " (near its blind view)" if row["near_blind"] and row["unit"] == "deg" else ""
    return [
        f"{row['unknown']} {row['unit']}{note}",
        _measure(row["value"], row),
        _measure(row["sigma"], row, sigma=True),
    ]


def _measure(value: Scalar, row: Row, *, sigma: bool = False) -> str:
    """Metres and degrees with fixed decimals, scales with significant digits."""
    decimals = DECIMALS.get(str(row["unit"]))
    if value is None or decimals is not None:
        return cell(value, decimals)
    return f"{number(value):.4g}" if sigma else f"{number(value):.10g}"


def _residuals(rows: Sequence[Row], most: int) -> list[Shown]:
    ranked = sorted(rows, key=lambda row: (row["role"] != "control", -_length(row)))
    control = [row for row in rows if row["role"] == "control"]
    title = f"Residuals: computed minus given, m{_rms(control)}"
    if len(ranked) > most:
        title += f"\nThe {most} largest"
    cells = [
        [
            cell(row["point"]),
            f"{row['role']} {row['known']}",
            *(cell(row[name], 4) for name in V),
            *(cell(row[name], 2) for name in REDUNDANCY),
        ]
        for row in ranked[:most]
    ]
    return [(title, ["point", "role", "vX", "vY", "vZ", "r_X", "r_Y", "r_Z"], cells)]


def _length(row: Row) -> float:
    return math.hypot(*(number(row[name]) for name in V if row[name] is not None))


def _rms(rows: Sequence[Row]) -> str:
    """The divisor is stated: the number of given coordinates, not the redundancy."""
    parts = []
    for name in V:
        given = [number(row[name]) for row in rows if row[name] is not None]
        if given:
            parts.append(f"{name[1]} {math.sqrt(sum(v * v for v in given) / len(given)):.4f} ({len(given)})")
    return f"\nControl, rms sqrt(sum v^2/n) and (n): {', '.join(parts)}" if parts else ""


def _alternatives(rows: Sequence[Row], most: int) -> list[Shown]:
    cells = [
        [
            str(row["number"]),
            *(cell(row[name], 3) for name in ("X_0_m", "Y_0_m", "Z_0_m")),
            f"{number(row['H']):.8g}",
            cell(row["tilt_deg"], 3),
            f"{number(row['vPv']):.4g}",
            "yes" if row["is_as_good"] else "no",
        ]
        for row in rows[:most]
    ]
    headers = ["no", "X_0 m", "Y_0 m", "Z_0 m", "H", "tilt deg", "v'Pv", "as good"]
    return [("Other orientations in which the adjustment converged", headers, cells)]


def _small_angles(rows: Sequence[Row], most: int) -> list[Shown]:
    cells = [
        [
            f"{row['unknown']} {row['unit']}",
            _measure(row["value"], row),
            _measure(row["rigorous"], row),
            f"{number(row['difference']):.3g}",
        ]
        for row in rows
    ]
    return [("Small-angle formulas (111) beside the rigorous", ["element", "(111)", "rigorous", "difference"], cells)]


def _iterations(rows: Sequence[Row], most: int) -> list[Shown]:
    return [iteration_table(rows, "v'Pv")]


def _ground_points(rows: Sequence[Row], most: int) -> list[Shown]:
    title = "Model points on the ground"
    if len(rows) > most:
        title += f"; {most} of {len(rows)}\nAll: orient sql PROJECT model-points"
    cells = [
        [
            cell(row["point"]),
            cell(row["role"]),
            *(cell(row[name], 3) for name in ("X_m", "Y_m", "Z_m")),
            *(_root(row[name]) for name in ("cov_XX_m2", "cov_YY_m2", "cov_ZZ_m2")),
        ]
        for row in rows[:most]
    ]
    return [(title, ["point", "role", "X m", "Y m", "Z m", "sd X", "sd Y", "sd Z"], cells)]


def _root(variance: Scalar) -> str:
    return cell(None) if variance is None else cell(math.sqrt(number(variance)), 3)
