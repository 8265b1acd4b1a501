"""The lines of crosses.csv and digitizer.csv."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

from orient.intake.cells import CellReader
from orient.intake.checks import Places
from orient.intake.csv_table import CsvTable, Layout
from orient.intake.findings import Findings, shown
from orient.intake.names import NameRegister
from orient.intake.numbers import plain
from orient.intake.options import ReadOptions
from orient.values import Row, Scalar

TABLE_PLACE = (("X_mm", "Y_mm"), ("col_px", "row_px"))
DIGITIZER = Layout(
    required=("sheet", "point"), choices=TABLE_PLACE, optional=("cycle", "H_m", "sigma_H_m"), mark="point"
)
CROSSES = Layout(
    required=("sheet",),
    choices=TABLE_PLACE,
    optional=("cross", "role", "B_deg", "L_deg", "E_m", "N_m"),
)
ROLES = ("fit", "check")
LIMIT_MM, LIMIT_PX = 1e5, 1e7


@dataclass(frozen=True, slots=True)
class Cross:
    """A row of `graticule_cross` and where it was written."""

    file: str
    line: int
    sheet: str
    row: Row


class SheetRows:
    """Gathers the crosses and the digitiser readings of all files of one import.

    `pixel_sizes` by sheet, for readings in pixels; None when sheet.toml could not be read and nothing is known.
    """

    def __init__(
        self, options: ReadOptions, findings: Findings, pixel_sizes: Mapping[str, float | None] | None
    ) -> None:
        self.crosses: list[Cross] = []
        self.readings: list[Row] = []
        self.first_reading: dict[str, tuple[str, int]] = {}
        self.broken_sheets: set[str] = set()
        self.crosses_unreadable = False
        self._options = options
        self._findings = findings
        self._pixel_sizes = pixel_sizes
        self._places = Places()
        self._numbers: Counter[str] = Counter()
        self._heights: dict[tuple[str, str], tuple[float, int]] = {}
        self._without_size: set[str] = set()

    def read(self, table: CsvTable) -> None:
        if table.layout is DIGITIZER:
            self._read_digitizer(table)
        elif self._has_coordinates(table):
            self._read_crosses(table)
        else:
            self.crosses_unreadable = True

    def _has_coordinates(self, table: CsvTable) -> bool:
        groups = [{"B_deg", "L_deg"}, {"E_m", "N_m"}]
        begun = [group for group in groups if group & table.columns]
        if len(begun) == 1 and begun[0] <= table.columns:
            return True
        found = shown(", ".join(sorted(table.columns)))
        wrong = "give B_deg, L_deg or E_m, N_m: one of them" + (", not 2" if len(begun) == 2 else f"; found {found}")
        self._findings.problem(table.file, 1, wrong)
        return False

    def _read_crosses(self, table: CsvTable) -> None:
        sheets = NameRegister(table.file, "sheet", self._findings)
        names = NameRegister(table.file, "cross", self._findings)
        geographic = "B_deg" in table.columns
        for record in table.records:
            cells = CellReader(table.file, record, self._options, self._findings)
            sheet = cells.name("sheet", sheets)
            self._numbers[sheet] += 1
            name = cells.name("cross", names) if cells.has("cross") else str(self._numbers[sheet])
            row: Row = {
                "sheet": sheet,
                "cross": name,
                "role": cells.word("role", ROLES),
                **self._place(cells, table, sheet),
                "B_deg": cells.latitude("B_deg", required=geographic),
                "L_deg": cells.longitude("L_deg", required=geographic),
                "E_m": cells.number("E_m", required=not geographic),
                "N_m": cells.number("N_m", required=not geographic),
            }
            called = f'cross "{shown(name)}" of sheet "{shown(sheet)}"'
            if cells.ok and self._places.is_new(cells, ("cross", sheet, name), called):
                self.crosses.append(Cross(table.file, record.line, sheet, row))
            else:
                self.broken_sheets.add(sheet)

    def _read_digitizer(self, table: CsvTable) -> None:
        sheets = NameRegister(table.file, "sheet", self._findings)
        points = NameRegister(table.file, "point", self._findings)
        for record in table.records:
            cells = CellReader(table.file, record, self._options, self._findings)
            row: Row = {
                "sheet": cells.name("sheet", sheets),
                "point": cells.name("point", points),
                "cycle": cells.cycle(),
            }
            sheet, point = str(row["sheet"]), str(row["point"])
            row = {
                **row,
                **self._place(cells, table, sheet),
                "H_m": cells.height("H_m"),
                "sigma_H_m": cells.sigma("sigma_H_m", "Leave it empty for a height that is taken as known"),
            }
            self._check_height(cells, row)
            called = f'point "{shown(point)}", cycle {row["cycle"]}, of sheet "{shown(sheet)}"'
            if cells.ok and self._places.is_new(cells, ("point", sheet, point, row["cycle"]), called):
                self.first_reading.setdefault(sheet, (table.file, record.line))
                self.readings.append(row)

    def _place(self, cells: CellReader, table: CsvTable, sheet: str) -> dict[str, Scalar]:
        """X right, Y up on the table [mm]; of a scan X = column x size, Y = -row x size."""
        if "X_mm" in table.columns:
            return {
                "X_mm": cells.number("X_mm", LIMIT_MM, required=True),
                "Y_mm": cells.number("Y_mm", LIMIT_MM, required=True),
            }
        column = cells.number("col_px", LIMIT_PX, required=True)
        row = cells.number("row_px", LIMIT_PX, required=True)
        size = self._pixel_sizes.get(sheet) if self._pixel_sizes is not None else 1.0
        if size is None:
            self._name_sheet_without_size(cells, sheet)
        if size is None or column is None or row is None:
            return {"X_mm": None, "Y_mm": None}
        return {"X_mm": column * size, "Y_mm": -row * size + 0.0}

    def _name_sheet_without_size(self, cells: CellReader, sheet: str) -> None:
        cells.ok = False
        if sheet and sheet not in self._without_size:
            self._without_size.add(sheet)
            hint = f"Give pixel_size_mm in [sheet.{shown(sheet)}] of sheet.toml"
            cells.problem(f'sheet "{shown(sheet)}" is read in pixels, but the size of a pixel is not known', hint)

    def _check_height(self, cells: CellReader, row: Row) -> None:
        """A point has one height, though it may be written in one of its cycles only."""
        height = row["H_m"]
        if height is None and row["sigma_H_m"] is not None:
            cells.problem("sigma_H_m is given, but H_m is missing")
        if not isinstance(height, float):
            return
        key = str(row["sheet"]), str(row["point"])
        first, line = self._heights.setdefault(key, (height, cells.line))
        if first != height:
            heights = f"{plain(height)} m here, {plain(first)} m in line {line}"
            cells.problem(f'point "{shown(key[1])}" has two heights: {heights}')
