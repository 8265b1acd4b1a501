"""The ground accuracy for people: the map over the frame, what seed 003 says of the photo, what not to leave out."""

import math
from collections.abc import Sequence

from orient.report.text import cell, number
from orient.values import Row, Tables

MICROMETRES = 1000.0
SHOWN_SIDE = 6
NORMAL_CASE, SEPARATION = "normal case", "separation"
SHOWN_USES = ("standard deviations only", "position only", "angles only")
NEGLIGIBLE = 1e-12
Shown = tuple[str, list[str], list[list[str]]]


def covariance_lines(tables: Tables) -> list[str]:
    """Sentences about the ground accuracy as a whole; none for a version that has no map."""
    if not tables.get("ground_accuracy"):
        return []
    return ["", *_map_lines(tables["ground_accuracy"]), *_seed_lines(tables), *_advice(tables.get("element_use", ()))]


def covariance_tables(tables: Tables, most: int) -> list[Shown]:
    """Title, headers, cells of each table."""
    if not tables.get("ground_accuracy"):
        return []
    shown = [*_maps(tables["ground_accuracy"]), *_pairs(tables, most)]
    if tables.get("focal_cofactor"):
        shown += [_cofactors(tables["focal_cofactor"]), _sums(tables["focal_sum"], most)]
    uses = [_uses(tables["element_use"])] if tables.get("element_use") else []
    return [*shown, _conditions(tables["closed_form_condition"]), *uses]


def plan_sigma(row: Row) -> float | None:
    """sqrt((sigma_X^2 + sigma_Y^2)/2) [m] of a row of the map or of a point; None where there is no ground."""
    if row["sigma_X_m"] is None or row["sigma_Y_m"] is None:
        return None
    return math.sqrt((number(row["sigma_X_m"]) ** 2 + number(row["sigma_Y_m"]) ** 2) / 2)


def _map_lines(rows: Sequence[Row]) -> list[str]:
    seen = [row for row in rows if row["sigma_X_m"] is not None]
    if not seen:
        return ["The frame sees no ground at the mean height of the points: there is no map of its accuracy."]
    best, worst = (choose(seen, key=lambda row: plan_sigma(row) or 0.0) for choose in (min, max))
    lines = [
        f"A new point read once more: sigma {_short(plan_sigma(best))} m at best ({_place(best)}), "
        f"{_short(plan_sigma(worst))} m at worst ({_place(worst)})."
    ]
    if len(seen) < len(rows):
        lines.append(f"{len(rows) - len(seen)} of {len(rows)} places of the frame see no ground.")
    return lines


def _place(row: Row) -> str:
    return f"x {number(row['x_mm']):.4g}, y {number(row['y_mm']):.4g} mm"


# ---------------------------------------------------------------------------------------------- seed 003


def _seed_lines(tables: Tables) -> list[str]:
    conditions = tables["closed_form_condition"]
    failed = [row for row in conditions if row["needed_for"] == NORMAL_CASE and not row["is_met"]]
    if failed:
        why = "; ".join(_why(row) for row in failed if row["value"] is not None)
        return [
            f"The formulas of seed 003 do not apply to this photo: {why}.",
            "Nothing is computed by them; every number here is rigorous.",
        ]
    apart = number(next(row["value"] for row in conditions if str(row["condition"]).startswith("sigmas by (3)")))
    sums = tables["focal_sum"]
    largest, left = (max(abs(number(row[name])) for row in sums) for name in ("focal_largest", "focal_sum"))
    return [
        "Near-vertical, flat, control without errors: the formulas of seed 003 apply, and their sigmas of the "
        f"orientation agree with the adjustment within {100 * apart:.2g} %.",
        f"In the scale of the image the focal length is not in them, for any layout: terms with f/c as large as "
        f"{_short(largest)} sigma^2 of a reading sum to {left:.0e}.",
        *_layout_lines(conditions, tables["focal_cofactor"]),
    ]


def _why(row: Row) -> str:
    return f"{row['condition']} {_short(number(row['value']))}, at most {number(row['limit_value']):g}"


def _layout_lines(conditions: Sequence[Row], cofactors: Sequence[Row]) -> list[str]:
    """Which closed form the layout allows, or the conditions that forbid it."""
    violated = [row for row in conditions if row["needed_for"] != NORMAL_CASE and not row["is_met"]]
    names = ", ".join(f"{row['condition']} = {number(row['value']):.3g}" for row in violated)
    if any(row["needed_for"] == SEPARATION for row in violated):
        return [f"The layout is not symmetric, so there is no closed form (8)-(10): per point {names}, should be 0."]
    diagonal = [row for row in cofactors if row["i"] == row["j"]]
    ratios = [number(row["closed_form"]) / _whole(row) for row in diagonal]
    apart = max(abs(math.sqrt(ratio) - 1) for ratio in ratios)
    if violated:
        return [
            f"The closed form holds with Dx and Dy, not with one D: per point {names}, should be 0.",
            f"It gives the sigmas of the elements within {100 * apart:.2g} %.",
        ]
    return [f"The layout is symmetric: the closed form (8)-(10) gives the sigmas of the elements within "
            f"{100 * apart:.2g} %."]  # fmt: skip


def _whole(row: Row) -> float:
    return number(row["by_focal_length"]) + number(row["by_layout"])


def _advice(uses: Sequence[Row]) -> list[str]:
    if not uses:
        return ["The elements of the camera are unknowns too: use the full covariance matrix of all of them."]
    by_name = {str(row["elements"]): row for row in uses}
    right = number(by_name["six elements"]["sigma_m"])
    others = "; ".join(
        f"{use} {_short(number(by_name[use]['sigma_m']))} m (x {_short(number(by_name[use]['factor']))})"
        for use in SHOWN_USES
    )
    return [
        f"Ground sigma of the orientation alone: {_short(right)} m with all six elements and their full covariance "
        f"matrix; {others}.",
        "Use all six elements together with the full 6 x 6 matrix, never the standard deviations alone.",
    ]


# ---------------------------------------------------------------------------------------------- tables


def _maps(rows: Sequence[Row]) -> list[Shown]:
    """The frame as one sees it, on the ground and in the scale of the image; a dash for the sky."""
    side = max(int(number(row["line"])) for row in rows)
    step = math.ceil((side - 1) / (SHOWN_SIDE - 1)) or 1
    lines = [[row for row in rows if row["line"] == line] for line in range(1, side + 1)]
    chosen = [line[::step] for line in lines[::step]]
    headers = ["y \\ x mm", *(f"{number(row['x_mm']):.1f}" for row in chosen[0])]
    of_ground = [[_tick(line), *(_short(plan_sigma(row)) for row in line)] for line in chosen]
    of_image = [[_tick(line), *(_short(_in_image(row)) for row in line)] for line in chosen]
    formula = "sqrt((sX^2 + sY^2)/2)"
    return [
        (f"New ground points over the frame: {formula} in m", headers, of_ground),
        ("The same in the scale of the image, in um", headers, of_image),
    ]


def _tick(line: Sequence[Row]) -> str:
    return f"{number(line[0]['y_mm']):.1f}"


def _in_image(row: Row) -> float | None:
    if row["sigma_x_mm"] is None:
        return None
    return MICROMETRES * math.sqrt((number(row["sigma_x_mm"]) ** 2 + number(row["sigma_y_mm"]) ** 2) / 2)


def _pairs(tables: Tables, most: int) -> list[Shown]:
    """Pairs with their correlation, the strongest first."""
    if not tables.get("ground_covariance_pair"):
        return []
    sigmas = {row["point"]: (number(row["sigma_X_m"]), number(row["sigma_Y_m"])) for row in tables["ground_covariance"]}
    found = []
    for row in tables["ground_covariance_pair"]:
        (X_i, Y_i), (X_j, Y_j) = sigmas[row["point_i"]], sigmas[row["point_j"]]
        found.append((_ratio(row["K_XX_m2"], X_i * X_j), _ratio(row["K_YY_m2"], Y_i * Y_j), row))
    found.sort(key=lambda pair: -max(abs(pair[0]), abs(pair[1])))
    parts = ("K_XX_m2", "K_XY_m2", "K_YX_m2", "K_YY_m2")
    cells = [
        [
            cell(row["point_i"]),
            cell(row["point_j"]),
            *(_short(number(row[part])) for part in parts),
            f"{in_X:.3f}",
            f"{in_Y:.3f}",
        ]
        for in_X, in_Y, row in found[:most]
    ]
    title = f"Pairs of points with the strongest correlation, {len(cells)} of {len(found)} (all: orient sql pairs)"
    return [(title, ["point_i", "point_j", *parts, "corr X", "corr Y"], cells)]


def _ratio(covariance: object, product: float) -> float:
    return number(covariance) / product if product > 0 else 0.0


def _cofactors(rows: Sequence[Row]) -> Shown:
    """What is not zero of Q^(f,c) and Q^(xi,eta)."""
    largest = max(abs(_whole(row)) for row in rows)
    cells = [
        [f"{row['unknown_i']}, {row['unknown_j']}"]
        + [_short(number(row[part])) for part in ("by_focal_length", "by_layout")]
        + [_short(None if row["closed_form"] is None else number(row["closed_form"]))]
        for row in rows
        if max(abs(number(row["by_focal_length"])), abs(number(row["by_layout"]))) > NEGLIGIBLE * largest
    ]
    return "Cofactors of seed 003, Q = Q^(f,c) + Q^(xi,eta)", ["element", "Q^(f,c)", "Q^(xi,eta)", "(8)-(10)"], cells


def _sums(rows: Sequence[Row], most: int) -> Shown:
    cells = [
        [
            cell(row["point"]),
            str(row["axis"]),
            f"{number(row['focal_sum']):.0e}",
            *(_short(number(row[name])) for name in ("focal_largest", "layout_sum", "rigorous")),
        ]
        for row in rows[:most]
    ]
    headers = ["point", "axis", "sum K^(f,c)", "largest", "sum K^(xi,eta)", "adjusted"]
    return "K by its elements, in units of the variance of a reading", headers, cells


def _conditions(rows: Sequence[Row]) -> Shown:
    cells = [
        [
            str(row["condition"]),
            str(row["needed_for"]),
            _short(None if row["value"] is None else number(row["value"])),
            f"{number(row['limit_value']):g}",
            "yes" if row["is_met"] else "no",
        ]
        for row in rows
    ]
    return "Conditions of seed 003 (sums per control point)", ["condition", "for", "value", "limit", "met"], cells


def _uses(rows: Sequence[Row]) -> Shown:
    cells = [
        [str(row["elements"])]
        + [_short(number(row[name])) for name in ("sigma_m", "factor", "factor_least", "factor_most")]
        for row in sorted(rows, key=lambda row: abs(math.log(number(row["factor"]) or math.inf)))
    ]
    headers = ["elements used", "sigma m", "factor", "least", "most"]
    return "Ground sigma of the orientation if less of Q were used", headers, cells


def _short(value: float | None) -> str:
    """Four significant digits, without an exponent for what people measure."""
    if value is None:
        return cell(None)
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:,.0f}"
