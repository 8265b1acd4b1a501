"""The absolute orientation of the model, zone by zone: elements in three forms, covariance, residuals, points."""

import math
from collections.abc import Sequence

import numpy as np

from orient.report.absolute import FORMS, V
from orient.report.html import kinds
from orient.report.html.blocks import Block, Paragraph, Section, Table
from orient.report.html.cells import digits, first_of, fixed, joined, name, rms, worst_of
from orient.report.html.evidence import Evidence
from orient.report.html.matrices import Matrix, matrix_tables
from orient.report.html.sections.iterations import parameter_table, step_table
from orient.report.language import tr
from orient.solvers.packed import unpack_upper
from orient.values import Row

MOST, MOST_ZONES = 50, 20
GREEK = {"xi": "ξ", "eta": "η", "theta": "θ"}
COFACTOR_UNITS = {"xi": "rad", "eta": "rad", "theta": "rad", "H": "model/m", "t": "m/model"}
MODEL_UNITS = ("T_X", "T_Y", "T_Z")


def section(evidence: Evidence) -> Section | None:
    if "absolute" not in evidence.runs:
        return None
    steps = evidence.rows("absolute", "absolute_iteration")
    zones = list(dict.fromkeys(str(row["zone"]) for row in steps))
    blocks = [block for zone in zones[:MOST_ZONES] for block in _zone(zone, evidence)]
    if left := first_of(MOST_ZONES, len(zones)):
        blocks.append(Paragraph(left, "note"))
    return Section("absolute", tr("Absolute orientation of the model"), blocks) if blocks else None


def _zone(zone: str, evidence: Evidence) -> list[Block]:
    heading = tr("Zone {zone}", zone=name(zone))
    found = next(iter(_of_zone(evidence, "absolute_orientation", zone)), None)
    steps = _of_zone(evidence, "absolute_iteration", zone)
    parameters = _of_zone(evidence, "absolute_iteration_parameter", zone)
    curves = [evidence.figure("iterations", tr("{zone}: iterations", zone=heading), part=zone)]
    if found is None:
        return [Paragraph(heading, "heading"), *curves, step_table(steps), parameter_table(parameters)]
    blocks: list[Block] = [
        Paragraph(heading, "heading"),
        Paragraph(_summary(found)),
        *_elements(zone, heading, found, evidence),
    ]
    blocks += [block for view in FORMS for block in _matrix(zone, heading, view, found, evidence)]
    blocks += [*_residuals(zone, heading, evidence), *curves, step_table(steps), parameter_table(parameters)]
    return blocks + _points(zone, heading, evidence)


def _of_zone(evidence: Evidence, table: str, zone: str) -> list[Row]:
    return [row for row in evidence.rows("absolute", table) if row["zone"] == zone]


def _summary(found: Row) -> str:
    counts = tr(
        "{full} full, {plan} plan-only, {height} height-only control points; {n} equations, {u} unknowns, r = {r}.",
        full=found["n_full"],
        plan=found["n_plan"],
        height=found["n_height"],
        n=found["n_equations"],
        u=found["n_unknowns"],
        r=found["redundancy"],
    )
    if found["sigma0"] is None:
        return joined([counts, tr("Without redundancy σ0 is unknown.")])
    unit = " m" if found["sigma0_unit"] == "m" else ""
    sigma0 = f"{digits(found['sigma0'], 4)}{unit}"
    told = tr("σ0 = √(v′Pv/r) = {sigma0}; covariances are scaled by σ0 {basis}.",
              sigma0=sigma0, basis=kinds.word(found["variance_basis"]))  # fmt: skip
    return joined([counts, told])


def _elements(zone: str, heading: str, found: Row, evidence: Evidence) -> list[Block]:
    rows = {(row["view"], row["unknown"]): row for row in _of_zone(evidence, "absolute_element", zone)}
    return [
        Table(
            f"{heading}: {form} ({kinds.frame(found['frame'])})",
            [tr("element"), tr("unit"), tr("value"), "σ"],
            [_element(rows[view, unknown]) for unknown in unknowns],
            frozenset({0, 1}),
        )
        for view, (form, unknowns) in FORMS.items()
    ]


def _element(row: Row) -> list[str]:
    sigma = tr("near its blind view") if row["near_blind"] and row["unit"] == "deg" else digits(row["sigma"], 4)
    return [GREEK.get(str(row["unknown"]), name(row["unknown"])), name(row["unit"]), digits(row["value"], 11), sigma]


def _matrix(zone: str, heading: str, view: str, found: Row, evidence: Evidence) -> list[Block]:
    rows = [row for row in _of_zone(evidence, "absolute_cofactor", zone) if row["unknowns"] == view]
    if not rows or found["variance_scale"] is None:
        return []
    names = [str(row["unknown_j"]) for row in rows if row["i"] == 1]
    units = [COFACTOR_UNITS.get(each, "model" if each in MODEL_UNITS else "m") for each in names]
    values = float(found["variance_scale"]) * unpack_upper(np.array([float(row["value"] or 0.0) for row in rows]))
    title = f"{heading}, {FORMS[view][0]}"
    return matrix_tables(Matrix(title, [GREEK.get(each, each) for each in names], units, values))


def _residuals(zone: str, heading: str, evidence: Evidence) -> list[Block]:
    rows = _of_zone(evidence, "absolute_residual", zone)
    if not rows:
        return []
    ranked = sorted(rows, key=lambda row: (row["role"] == "check", -_length(row), str(row["point"])))[:MOST]
    cells = [
        [
            name(row["point"]),
            kinds.word(row["role"]),
            kinds.word(row["known"]),
            *(fixed(row[column], 4) for column in V),
            fixed(_length(row), 4),
            *(fixed(row[f"redundancy_{axis}"], 2) for axis in "XYZ"),
        ]
        for row in ranked
    ]
    headers = [tr("point"), tr("role"), tr("known"), "v_X, m", "v_Y, m", "v_Z, m", tr("|v|, m"), "r_X", "r_Y", "r_Z"]
    note = joined([worst_of(len(cells), len(rows)), *_rms(rows)])
    title = tr("{zone}: residuals, computed minus given", zone=heading)
    return [Table(title, headers, cells, frozenset({0, 1, 2}), note)]


def _length(row: Row) -> float:
    return math.hypot(*(float(row[column] or 0.0) for column in V))


def _rms(rows: Sequence[Row]) -> list[str]:
    """Each coordinate with the number of given values as its divisor, control and check apart."""
    told = []
    for role in ("control", "check"):
        parts = []
        for column in V:
            given = [float(row[column] or 0.0) for row in rows if row["role"] == role and row[column] is not None]
            if given:
                parts.append(f"{column[1]} √(Σv²/{len(given)}) = {digits(rms(given), 4)} m")
        if parts:
            told.append(f"RMS, {kinds.word(role)}: {', '.join(parts)}.")
    return told


def _points(zone: str, heading: str, evidence: Evidence) -> list[Block]:
    rows = _of_zone(evidence, "model_ground_point", zone)
    if not rows:
        return []
    ranked = sorted(rows, key=lambda row: (-_variance(row), str(row["point"])))[:MOST]
    cells = [
        [
            name(row["point"]),
            kinds.word(row["role"]),
            *(fixed(row[column], 3) for column in ("X_m", "Y_m", "Z_m")),
            *(_root(row[f"cov_{axis}{axis}_m2"]) for axis in "XYZ"),
        ]
        for row in ranked
    ]
    headers = [tr("point"), tr("role"), "X, m", "Y, m", "Z, m", "σX, m", "σY, m", "σZ, m"]
    title = tr("{zone}: model points on the ground, the least sure first", zone=heading)
    return [Table(title, headers, cells, frozenset({0, 1}), worst_of(len(cells), len(rows)))]


def _variance(row: Row) -> float:
    return math.fsum(float(row[f"cov_{axis}{axis}_m2"] or 0.0) for axis in "XYZ")


def _root(variance: object) -> str:
    return fixed(math.sqrt(variance), 4) if isinstance(variance, float) else fixed(None, 4)
