"""model.csv: points of a photogrammetric model, by zone."""

from orient.intake.cells import CellReader
from orient.intake.checks import Places, check_apart
from orient.intake.control_covariance import LARGEST_VARIANCE, check_positive_definite
from orient.intake.csv_table import CsvTable, Layout, open_csv
from orient.intake.findings import Findings, shown
from orient.intake.names import NameRegister
from orient.intake.options import ReadOptions
from orient.intake.readings import Files
from orient.values import InputTables, Row, Scalar

COVARIANCES = ("cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz")
LAYOUT = Layout(required=("zone", "point", "x", "y", "z"), optional=COVARIANCES)
NO_ERROR = "Leave all of them empty for a point without covariances"


def read_model(files: Files, options: ReadOptions, findings: Findings) -> InputTables:
    """The rows of `model_point`."""
    rows: list[Row] = []
    places = Places()
    for path, file in files:
        table = open_csv(path, file, (LAYOUT,), options, findings)
        if table is not None:
            rows += _rows(table, options, places, findings)
    names = tuple(file for _, file in files)
    check_apart(", ".join(names), rows, "point", ("x", "y", "z"), findings)
    return InputTables("model", {"model_point": rows}, (), names)


def _rows(table: CsvTable, options: ReadOptions, places: Places, findings: Findings) -> list[Row]:
    zones = NameRegister(table.file, "zone", findings)
    points = NameRegister(table.file, "point", findings)
    rows: list[Row] = []
    for record in table.records:
        cells = CellReader(table.file, record, options, findings)
        row: Row = {
            "zone": cells.name("zone", zones),
            "point": cells.name("point", points),
            **{axis: cells.number(axis, required=True) for axis in "xyz"},
            **_covariance(cells),
        }
        called = f'point "{shown(str(row["point"]))}" of zone "{shown(str(row["zone"]))}"'
        if cells.ok and places.is_new(cells, (row["zone"], row["point"]), called):
            rows.append(row)
    return rows


def _covariance(cells: CellReader) -> dict[str, Scalar]:
    """The six columns cov_*, in model units squared; all None for a point of which nothing is said."""
    if not any(cells.has(column) for column in COVARIANCES):
        return dict.fromkeys(COVARIANCES)
    for column in COVARIANCES:
        if not cells.has(column):
            cells.problem(f'column "{column}": value is missing', NO_ERROR)
    covariance: dict[str, Scalar] = {column: cells.number(column, LARGEST_VARIANCE) for column in COVARIANCES}
    if cells.ok:
        check_positive_definite(cells, [[covariance[f"cov_{min(i, j)}{max(i, j)}"] for j in "xyz"] for i in "xyz"])
    return covariance
