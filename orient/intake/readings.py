"""readings.csv: what was read on the photo, in cycles, in mm of a comparator or in pixels of a scan."""

from collections.abc import Sequence
from pathlib import Path

from orient.intake.cells import CellReader
from orient.intake.checks import Places, check_apart, check_weights
from orient.intake.csv_table import CsvTable, Layout, open_csv
from orient.intake.findings import Findings, shown
from orient.intake.names import NameRegister
from orient.intake.numbers import plain
from orient.intake.options import ReadOptions
from orient.intake.photo_facts import MARGIN, PhotoFacts
from orient.values import InputTables, Row

LAYOUT = Layout(
    required=("point",),
    choices=(("x_mm", "y_mm"), ("col_px", "row_px")),
    optional=("kind", "cycle", "sigma_mm", "sigma_px"),
)
KINDS = ("point", "fiducial")
LIMIT_MM, LIMIT_PX = 1e5, 1e7
Files = Sequence[tuple[Path, str]]


def read_readings(files: Files, options: ReadOptions, photo: PhotoFacts, findings: Findings) -> InputTables:
    """The rows of `comparator_reading`, numbered through all files."""
    rows: list[Row] = []
    places = Places()
    for path, file in files:
        table = open_csv(path, file, (LAYOUT,), options, findings)
        if table is not None and _header_fits(table, photo, findings):
            rows += _rows(table, options, photo, places, findings)
    names = ", ".join(file for _, file in files)
    points = [row for row in rows if row["kind"] == "point"]
    check_apart(names, points, "point", _columns(points), findings)
    check_weights(names, rows, ("sigma",), findings)
    numbered = [{"seq": seq, **row} for seq, row in enumerate(rows, start=1)]
    return InputTables("readings", {"comparator_reading": numbered}, (), tuple(file for _, file in files))


def _columns(rows: list[Row]) -> tuple[str, ...]:
    return ("x_mm", "y_mm", "col_px", "row_px") if rows else ()


def _header_fits(table: CsvTable, photo: PhotoFacts, findings: Findings) -> bool:
    in_pixels = "col_px" in table.columns
    wrong = "sigma_mm" if in_pixels else "sigma_px"
    if wrong in table.columns:
        message = f'column "{wrong}" does not go with {"col_px, row_px" if in_pixels else "x_mm, y_mm"}'
        findings.problem(table.file, 1, message, f"Write {'sigma_px' if in_pixels else 'sigma_mm'}")
        return False
    if in_pixels and photo.known == "yes" and photo.pixel_size_mm is None:
        hint = "Give size_mm in [pixels] of photo.toml"
        findings.problem(table.file, 1, "readings in pixels need the size of a pixel", hint)
        return False
    return True


def _rows(table: CsvTable, options: ReadOptions, photo: PhotoFacts, places: Places, findings: Findings) -> list[Row]:
    x, y = ("col_px", "row_px") if "col_px" in table.columns else ("x_mm", "y_mm")
    limit = LIMIT_PX if x == "col_px" else LIMIT_MM
    register = NameRegister(table.file, "point", findings)
    rows: list[Row] = []
    for record in table.records:
        cells = CellReader(table.file, record, options, findings)
        row: dict[str, str | int | float | None] = {
            "point": cells.name("point", register),
            "kind": cells.word("kind", KINDS),
            "cycle": cells.cycle(),
            "x_mm": None,
            "y_mm": None,
            "col_px": None,
            "row_px": None,
            x: cells.number(x, limit, required=True),
            y: cells.number(y, limit, required=True),
            "sigma": cells.sigma("sigma_mm") if x == "x_mm" else cells.sigma("sigma_px"),
        }
        _check_place(cells, row, (x, y), photo)
        _check_mark(cells, row, photo)
        if cells.ok and places.is_new(cells, (row["point"], row["kind"], row["cycle"]), _called(row)):
            rows.append(row)
    return rows


def _called(row: Row) -> str:
    what = "point" if row["kind"] == "point" else "fiducial"
    return f'{what} "{shown(str(row["point"]))}", cycle {row["cycle"]},'


def _check_place(cells: CellReader, row: Row, columns: tuple[str, str], photo: PhotoFacts) -> None:
    for column in columns:
        value = row[column]
        low, high = (photo.limits or {}).get(column, (-float("inf"), float("inf")))
        margin = MARGIN * (high - low)
        if isinstance(value, float) and not low - margin <= value <= high + margin:
            unit = column[-2:]
            limits = f"{plain(low)} … {plain(high)} {unit}, 10 % margin"
            point = shown(str(row["point"]))
            cells.problem(f'point "{point}": {column} = {plain(value)} lies outside the photo ({limits})')


def _check_mark(cells: CellReader, row: Row, photo: PhotoFacts) -> None:
    mark = str(row["point"])
    if row["kind"] == "fiducial" and mark and photo.known == "yes" and mark not in photo.marks:
        names = shown(", ".join(sorted(photo.marks))) or "none"
        cells.problem(f'fiducial "{shown(mark)}" is not a mark of photo.toml (known: {names})')
