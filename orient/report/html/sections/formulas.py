"""Every RMS and sigma0 of this report with its formula, its divisor and the numbers that went in."""

import math
from collections.abc import Sequence

from orient.report.html import kinds
from orient.report.html.blocks import Block, Paragraph, Section, Table
from orient.report.html.cells import MICROMETRES, digits, joined, name, rms
from orient.report.html.evidence import Evidence
from orient.report.html.sections.meaning import length_mm
from orient.report.language import tr
from orient.values import Row

ROLES = ("control", "check", "excluded")
WORDS = frozenset({0, 1, 2})


def section(evidence: Evidence) -> Section | None:
    rows = [*_resection(evidence), *_image(evidence), *_sheets(evidence), *_absolute(evidence)]
    blocks: list[Block] = [Paragraph(text) for text in _definitions(evidence)]
    headers = [tr("quantity"), tr("formula"), tr("divisor"), tr("sum of squares"), tr("result")]
    if rows:
        blocks.append(Table(tr("RMS and σ0 of this report"), headers, rows, WORDS))
    return Section("formulas", tr("How the numbers are computed"), blocks) if rows else None


def _definitions(evidence: Evidence) -> list[str]:
    signs = tr("Residuals are v = adjusted minus observed, in the image: computed minus measured.")
    divisor = tr(
        "σ0 divides the weighted sum of squares by the redundancy r = n − u (equations minus unknowns), an RMS "
        "divides the "
        "sum of squares by the number of residuals in it. σ0 judges the adjustment, an RMS only describes its "
        "residuals: "
        "with few points it is the smaller of the two."
    )
    found = evidence.one("resection", "orientation")
    if found is None:
        return [signs, divisor]
    weights = tr(
        "Weights are P = σ0² K⁻¹ with σ0 = {sigma0} µm a priori and K the covariance matrix of the observations. The "
        "covariance matrix of the unknowns is s² Q, Q = (A′PA)⁻¹, s² = {scale} mm² (σ0 {basis}).",
        sigma0=digits(MICROMETRES * float(found["sigma0_apriori_mm"] or 0.0), 6),
        scale=digits(found["variance_scale"], 6),
        basis=kinds.word(found["variance_basis"]),
    )
    return [signs, divisor, weights]


def _resection(evidence: Evidence) -> list[list[str]]:
    found = evidence.one("resection", "orientation")
    if found is None:
        return []
    residuals = evidence.rows("resection", "image_residual", ("role", "vx_mm", "vy_mm"))
    rows = []
    if found["redundancy"]:
        n, u, r = (found[key] for key in ("n_equations", "n_unknowns", "redundancy"))
        result = f"{digits(MICROMETRES * float(found['sigma0_mm'] or 0.0), 6)} µm"
        rows.append(
            [tr("σ0 of the orientation"), "√(v′Pv/r)", f"r = {n} − {u} = {r}", f"{digits(found['vPv'], 8)} mm²", result]
        )
    for role in ROLES:
        rows += _rms_rows(kinds.word(role), [row for row in residuals if row["role"] == role])
    return rows


def _rms_rows(role: str, rows: Sequence[Row]) -> list[list[str]]:
    """x, y and the length of the residual of one kind of points [mm]."""
    if not rows:
        return []
    parts = {
        "v_x": [float(row["vx_mm"] or 0.0) for row in rows],
        "v_y": [float(row["vy_mm"] or 0.0) for row in rows],
        "|v|": [length_mm(row) for row in rows],
    }
    return [_rms_row(f"RMS {label}, {role}", values, "mm", MICROMETRES, "µm") for label, values in parts.items()]


def _rms_row(label: str, values: Sequence[float], unit: str, factor: float, told: str) -> list[str]:
    total = math.fsum(value * value for value in values)
    result = f"{digits(factor * (rms(values) or 0.0), 5)} {told}"
    return [label, "√(Σv²/n)", f"n = {len(values)}", f"{digits(total, 6)} {unit}²", result]


def _image(evidence: Evidence) -> list[list[str]]:
    found = evidence.one("refine", "interior_orientation")
    if found is None or found["sigma0_mm"] is None:
        return []
    marks = evidence.rows("refine", "fiducial_residual")
    total = math.fsum(float(row[column] or 0.0) ** 2 for row in marks for column in ("vx_mm", "vy_mm"))
    result = f"{digits(MICROMETRES * float(found['sigma0_mm']), 5)} µm"
    label = tr("σ0 of the interior orientation")
    return [[label, "√(Σ(v_x² + v_y²)/r)", f"r = {found['redundancy']}", f"{digits(total, 6)} mm²", result]]


def _sheets(evidence: Evidence) -> list[list[str]]:
    rows = []
    crosses = [row for row in evidence.rows("digitize", "cross_residual") if row["role"] == "fit"]
    for sheet in evidence.rows("digitize", "sheet_transform"):
        for axis in "NE":
            if sheet[f"sigma0_{axis}_m"] is None:
                continue
            mine = [float(row[f"v_{axis}_m"] or 0.0) for row in crosses if row["sheet"] == sheet["sheet"]]
            label = joined([tr("σ0 of the sheet"), name(sheet["sheet"]), axis])
            total = f"{digits(math.fsum(v * v for v in mine), 6)} m²"
            result = f"{digits(sheet[f'sigma0_{axis}_m'], 5)} m"
            rows.append([label, "√(Σv²/r)", f"r = {sheet['redundancy']}", total, result])
    return rows


def _absolute(evidence: Evidence) -> list[list[str]]:
    rows = []
    residuals = evidence.rows("absolute", "absolute_residual")
    for found in evidence.rows("absolute", "absolute_orientation"):
        zone = name(found["zone"])
        if found["redundancy"]:
            unit = "m" if found["sigma0_unit"] == "m" else ""
            squared = "m²" if unit else ""
            label = joined([tr("σ0 of the zone"), zone])
            divisor = f"r = {found['n_equations']} − {found['n_unknowns']} = {found['redundancy']}"
            total, result = (f"{digits(found['vPv'], 8)} {squared}", f"{digits(found['sigma0'], 6)} {unit}")
            rows.append([label, "√(v′Pv/r)", divisor, total.strip(), result.strip()])
        mine = [row for row in residuals if row["zone"] == found["zone"] and row["role"] == "control"]
        for axis in "XYZ":
            given = [float(row[f"v{axis}_m"] or 0.0) for row in mine if row[f"v{axis}_m"] is not None]
            if given:
                rows.append(_rms_row(f"RMS v_{axis}, {zone}", given, "m", 1.0, "m"))
    return rows
