"""The exterior orientation for people: elements with sigmas, residuals, iterations."""

import math
from collections.abc import Mapping, Sequence

from orient.report.text import cell, number
from orient.units import format_dms
from orient.values import Row, Tables

MICROMETRES = 1000.0
ELEMENTS = ("X_S", "Y_S", "Z_S")
AXES = {
    "topocentric": "T': X grid north, Y grid east, Z up",
    "local_right": "local, right-handed",
    "local_left": "local, left-handed",
}
ANGLE_ORDER = {"aok": ("alpha", "omega", "kappa"), "opk": ("omega", "phi", "kappa")}
Shown = tuple[str, list[str], list[list[str]]]


def orientation_lines(tables: Tables) -> list[str]:
    """Sentences about the adjustment as a whole."""
    row = tables["orientation"][0]
    sigma0, apriori = row["sigma0_mm"], number(row["sigma0_apriori_mm"])
    quality = "no redundancy: sigma0 unknown" if sigma0 is None else _sigma0(number(sigma0), apriori)
    lines = [
        "",
        f"n = {row['n_equations']} equations, u = {row['n_unknowns']} unknowns, redundancy r = {row['redundancy']}, "
        f"{row['n_control']} control points",
        f"sigma0 = sqrt(v'Pv/r) {quality}",
        f"standard deviations are scaled by sigma0 {row['variance_basis']}",
    ]
    if row["B_S_deg"] is not None:
        lines.append(
            f"station: B {format_dms(number(row['B_S_deg']))}, L {format_dms(number(row['L_S_deg']))}, "
            f"H {number(row['H_S_m']):.2f} m"
        )
    return lines


def _sigma0(sigma0: float, apriori: float) -> str:
    return f"= {MICROMETRES * sigma0:.3f} um a posteriori, {MICROMETRES * apriori:.3f} um a priori"


def orientation_tables(tables: Tables, most: int) -> list[Shown]:
    """Title, headers, cells of each table."""
    shown = [_elements(tables)]
    if tables.get("camera_element"):
        shown.append(_camera(tables["camera_element"]))
    shown.append(_angles(tables["orientation_angle"]))
    residuals = tables.get("image_residual", ())
    control = [row for row in residuals if row["role"] == "control"]
    check = [row for row in residuals if row["role"] == "check"]
    shown.append(_residuals(f"Residuals of {len(control)} control points, {_rms(control)}", control, most))
    excluded = [row for row in residuals if row["role"] == "excluded"]
    if excluded:
        shown.append(_residuals(f"Excluded points, {_rms(excluded)}", excluded, most))
    if check:
        shown.append(_residuals(f"Check points, {_rms(check)}", check, most))
    shown.append(iteration_table(tables["iteration"]))
    return shown


def _elements(tables: Tables) -> Shown:
    row = tables["orientation"][0]
    scale = number(row["variance_scale"])
    sigma = {
        str(entry["unknown_i"]): math.sqrt(scale * number(entry["value"]))
        for entry in tables["cofactor"]
        if entry["unknowns"] == "rotation" and entry["i"] == entry["j"]
    }
    cells = [[f"{name} m", cell(row[f"{name}_m"], 4), cell(sigma[name], 4)] for name in ELEMENTS]
    for angle in sorted(tables["orientation_angle"], key=_place_of_angle):
        if angle["triple"] == "aok" and angle["frame"] == "ground":
            cells.append([f"{angle['angle']} deg", cell(angle["value_deg"], 7), cell(angle["sigma_deg"], 7)])
    return f"Exterior orientation ({AXES[str(row['frame'])]})", ["element", "value", "sigma"], cells


def _camera(rows: Sequence[Row]) -> Shown:
    """Digits down to a hundredth of the standard deviation."""
    cells = [
        [
            f"{row['unknown']} {row['unit']}".removesuffix(" 1"),
            f"{number(row['value_apriori']):.6g}",
            "free" if row["sigma_apriori"] is None else f"{number(row['sigma_apriori']):.3g}",
            _to_sigma(row["value"], row["sigma"]),
            "" if row["sigma"] is None else f"{number(row['sigma']):.3g}",
            cell(row["t"], 1),
            "yes" if row["is_significant"] else "no",
        ]
        for row in rows
    ]
    limit = number(rows[0]["t_limit"])
    headers = ["element", "a priori", "sigma", "adjusted", "sigma", "t", "signif."]
    return f"Estimated camera; t = change / sigma, significant above {limit:.2f} (1 %)", headers, cells


def _to_sigma(value: object, sigma: object) -> str:
    if not sigma or not value:
        return f"{number(value):.8g}"
    digits = math.ceil(math.log10(abs(number(value)) / number(sigma))) + 2
    return f"{number(value):.{min(max(digits, 3), 12)}g}"


def _angles(rows: Sequence[Row]) -> Shown:
    others = [row for row in rows if (row["triple"], row["frame"]) != ("aok", "ground")]
    cells = [
        [
            f"{row['triple']} {row['frame']} {row['angle']}",
            cell(row["value_deg"], 7),
            cell(row["sigma_deg"], 7),
            "near its blind view" if row["near_blind"] else "",
        ]
        for row in sorted(others, key=_place_of_angle)
    ]
    return "The same rotation in other conventions (deg)", ["angle", "value", "sigma", ""], cells


def _place_of_angle(row: Row) -> tuple[str, str, int]:
    """Ground before geocentric; the angles in the order in which they turn."""
    order = ANGLE_ORDER[str(row["triple"])]
    return str(row["frame"] == "geocentric"), str(row["triple"]), order.index(str(row["angle"]))


def _rms(rows: Sequence[Row]) -> str:
    """The divisor is stated: the number of residuals, not the redundancy."""
    if not rows:
        return "none"
    n = len(rows)
    x, y = (math.sqrt(sum(number(row[name]) ** 2 for row in rows) / n) * MICROMETRES for name in ("vx_mm", "vy_mm"))
    return f"rms sqrt(sum v^2/{n}): x {x:.2f} um, y {y:.2f} um"


def _residuals(title: str, rows: Sequence[Row], most: int) -> Shown:
    ranked = sorted(rows, key=lambda row: -(number(row["vx_mm"]) ** 2 + number(row["vy_mm"]) ** 2))
    if len(ranked) > most:
        title += f"; the {most} largest"
    cells = [
        [
            cell(row["point"]),
            cell(row["x_mm"], 4),
            cell(row["y_mm"], 4),
            cell(MICROMETRES * number(row["vx_mm"]), 2),
            cell(MICROMETRES * number(row["vy_mm"]), 2),
            cell(row["redundancy_x"], 2),
            cell(row["redundancy_y"], 2),
        ]
        for row in ranked[:most]
    ]
    return title, ["point", "x mm", "y mm", "vx um", "vy um", "r_x", "r_y"], cells


def iteration_table(rows: Sequence[Mapping[str, object]], vPv: str = "v'Pv mm^2") -> Shown:
    """How the adjustment went; `vPv` heads the column with its unit."""
    cells = [
        [
            str(row["iteration"]),
            f"{number(row['vPv']):.6g}",
            f"{number(row['max_scaled_step']):.2e}",
            f"{number(row['damping']):.1g}",
        ]
        for row in rows
    ]
    return "Iterations", ["iteration", vPv, "largest scaled step", "damping"], cells
