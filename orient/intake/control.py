"""control.csv: points with known coordinates in the system that control.toml states."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from orient.intake.cells import CellReader
from orient.intake.checks import Places, check_apart, check_weights, listed
from orient.intake.control_covariance import COVARIANCES, SIGMAS_HORIZON, SIGMAS_XYZ, read_covariance
from orient.intake.control_system import Columns, ControlStatement, kind_of_points, read_statement
from orient.intake.csv_table import CsvTable, Layout, open_csv
from orient.intake.findings import Findings, shown
from orient.intake.names import NameRegister
from orient.intake.options import ReadOptions
from orient.intake.photo_facts import PhotoFacts
from orient.intake.readings import Files
from orient.intake.sheet import look_like_degrees
from orient.intake.toml_file import read_toml
from orient.values import InputTables, Row, Scalar

COORDINATES = ("B_deg", "L_deg", "E_m", "N_m", "H_m", "X_m", "Y_m", "Z_m")
LAYOUT = Layout(
    required=("point",),
    choices=(("B_deg", "L_deg"), ("E_m", "N_m"), ("X_m", "Y_m", "Z_m")),
    optional=("role", "H_m", *SIGMAS_HORIZON, *SIGMAS_XYZ, *COVARIANCES),
    may_lack_choice=True,
)
ROLES = ("control", "check")


@dataclass(frozen=True, slots=True)
class PointRow:
    file: str
    line: int
    row: Row


def read_control(files: Files, options: ReadOptions, photo: PhotoFacts, findings: Findings) -> InputTables:
    """The rows of `control_point` and `control_system`."""
    statement = _statement(files, options, findings)
    handedness: str | None = None
    points: list[PointRow] = []
    places = Places()
    for path, file in files:
        if path.suffix.lower() == ".toml":
            continue
        table = open_csv(path, file, (LAYOUT,), options, findings)
        if table is None or not _header_fits(table, findings):
            continue
        kind, hand = kind_of_points(file, _columns(table), statement, photo, findings)
        handedness = handedness or hand
        points += _rows(table, kind, options, places, findings)
    names = tuple(file for _, file in files)
    rows = [point.row for point in points]
    _check_list(", ".join(names), points, rows, statement, findings)
    system: Row = {"crs": statement.crs, "handedness": handedness}
    return InputTables("control", {"control_point": rows, "control_system": [system]}, (), names)


def _statement(files: Files, options: ReadOptions, findings: Findings) -> ControlStatement:
    statements = [
        read_statement(document) if (document := read_toml(path, file, options, findings)) else None
        for path, file in files
        if path.suffix.lower() == ".toml"
    ]
    return (statements[0] or ControlStatement(readable=False)) if statements else ControlStatement()


def _columns(table: CsvTable) -> Columns:
    if "X_m" in table.columns:
        return "XYZ"
    if "E_m" in table.columns:
        return "EN"
    return "BL" if {"B_deg", "H_m"} & table.columns else "none"


def _header_fits(table: CsvTable, findings: Findings) -> bool:
    """Columns that do not go with the coordinates of the file."""
    wrong = {"XYZ": ("H_m", *SIGMAS_HORIZON), "none": (*SIGMAS_HORIZON, *SIGMAS_XYZ, *COVARIANCES)}
    unfit = [column for column in wrong.get(_columns(table), SIGMAS_XYZ) if column in table.columns]
    for column in unfit:
        findings.problem(table.file, 1, f'column "{column}" does not go with the coordinates of this file')
    return not unfit


def _rows(table: CsvTable, kind: str, options: ReadOptions, places: Places, findings: Findings) -> list[PointRow]:
    register = NameRegister(table.file, "point", findings)
    in_space = "X_m" in table.columns
    rows: list[PointRow] = []
    for record in table.records:
        cells = CellReader(table.file, record, options, findings)
        start: dict[str, Scalar] = {"point": cells.name("point", register), "role": cells.word("role", ROLES)}
        place = _coordinates(cells)
        known = _known(cells, in_space, kind)
        covariance = read_covariance(cells, SIGMAS_XYZ if in_space else SIGMAS_HORIZON, known)
        row: Row = {**start, "kind": kind if any(known) else "none", **place, **covariance}
        called = f'point "{shown(str(row["point"]))}"'
        if cells.ok and places.is_new(cells, row["point"], called):
            rows.append(PointRow(table.file, record.line, row))
    return rows


def _coordinates(cells: CellReader) -> dict[str, Scalar]:
    return {
        "B_deg": cells.latitude("B_deg"),
        "L_deg": cells.longitude("L_deg"),
        "E_m": cells.number("E_m"),
        "N_m": cells.number("N_m"),
        "H_m": cells.height("H_m"),
        "X_m": cells.number("X_m"),
        "Y_m": cells.number("Y_m"),
        "Z_m": cells.number("Z_m"),
    }


def _known(cells: CellReader, in_space: bool, kind: str) -> tuple[bool, bool, bool]:
    """Plan and height of the point; half a plan position is refused, and a geocentric point is whole or empty."""
    if in_space:
        x, y, z = (cells.has(column) for column in ("X_m", "Y_m", "Z_m"))
        names = "X_m and Y_m"
    else:
        x, y = (cells.has("N_m") or cells.has("B_deg"), cells.has("E_m") or cells.has("L_deg"))
        z = cells.has("H_m")
        names = "both plan coordinates"
    if x != y:
        cells.problem(f"half a plan position: give {names}, or none")
    elif kind == "geocentric" and x != z:
        cells.problem("a geocentric point needs X_m, Y_m and Z_m")
    return x, y, z


def _check_list(
    files: str, points: list[PointRow], rows: list[Row], statement: ControlStatement, findings: Findings
) -> None:
    placed = [row for row in rows if row["kind"] != "none"]
    check_apart(files, placed, "point", COORDINATES, findings)
    variances = ("cov_XX_m2", "cov_YY_m2", "cov_ZZ_m2")
    check_weights(files, rows, variances, findings, power=2)
    on_grid = [row for row in placed if row["kind"] == "projected" and row["E_m"] is not None]
    if on_grid and statement.crs_kind == "projected" and all(look_like_degrees(row) for row in on_grid):
        message = f"values look like degrees, crs {statement.crs} is in metres"
        findings.problem(points[0].file, 0, message)
    _warn_same_place(points, findings)


def _warn_same_place(points: list[PointRow], findings: Findings) -> None:
    first: dict[tuple[Scalar, ...], PointRow] = {}
    for point in points:
        place = tuple(point.row[column] for column in COORDINATES)
        if any(value is None for value in (place[4] or place[7], place[0] or place[2] or place[5])):
            continue
        twin = first.setdefault(place, point)
        if twin is not point:
            one, two = shown(str(twin.row["point"])), shown(str(point.row["point"]))
            message = f'{point.file}: points "{one}" (line {twin.line}) and "{two}" (line {point.line}) coincide'
            findings.warn("same_place", str(point.row["point"]), message)


def warn_without_control(
    file: str, readings: Collection[Row], control: Collection[Row], digitized: Collection[Row], findings: Findings
) -> None:
    """Readings of points that neither the control list nor a sheet knows are not used."""
    known = {row["point"] for row in (*control, *digitized)}
    names = dict.fromkeys(str(row["point"]) for row in readings if row["kind"] == "point" and row["point"] not in known)
    if names:
        what = "point is" if len(names) == 1 else "points are"
        message = f"{file}: {len(names)} {what} not used: no control ({listed(list(names))})"
        findings.warn("no_control", "", message, float(len(names)))


def check_some_control(file: str, control: Collection[Row], digitized: Collection[Row], findings: Findings) -> None:
    """At least one point must carry the orientation; a digitised point does unless it is listed as check."""
    roles: Mapping[Scalar, Scalar] = {row["point"]: row["role"] for row in control}
    names = {row["point"] for row in digitized} | set(roles)
    if names and all(roles.get(name) == "check" for name in names):
        findings.problem(file, 0, "no control points", "All points have the role check")
