"""Map sheets: crosses.csv (crosses of the graticule or grid), digitizer.csv (points of the map), sheet.toml."""

from dataclasses import dataclass

from orient.intake.checks import check_apart, check_weights
from orient.intake.crs import crs_kind
from orient.intake.csv_table import open_csv
from orient.intake.findings import BadValue, Findings, shown
from orient.intake.names import parse_name
from orient.intake.options import ReadOptions
from orient.intake.readings import Files
from orient.intake.sheet_rows import CROSSES, DIGITIZER, Cross, SheetRows
from orient.intake.toml_file import Section, read_toml
from orient.values import InputTables, Row

HIGHEST_DEGREE = 5
DEGREES_AT_MOST = 360.0


@dataclass(frozen=True, slots=True)
class SheetEntry:
    """What sheet.toml says of one sheet."""

    section: Section | None
    title: str = ""
    crs: str | None = None
    crs_kind: str = ""
    degree: int | None = None
    sigma_mm: float | None = None
    pixel_size_mm: float | None = None


def read_sheets(files: Files, options: ReadOptions, findings: Findings) -> InputTables:
    """The rows of `map_sheet`, `graticule_cross` and `digitizer_reading`; files are told apart by their columns."""
    described = [(path, file) for path, file in files if path.suffix.lower() == ".toml"]
    entries: dict[str, SheetEntry] = {}
    complete = True
    for path, file in described:
        document = read_toml(path, file, options, findings)
        complete = complete and document is not None
        if document is not None:
            entries |= _entries(document, entries)
    sizes = {name: entry.pixel_size_mm for name, entry in entries.items()}
    lists = SheetRows(options, findings, sizes if complete else None)
    for path, file in files:
        if (path, file) not in described:
            table = open_csv(path, file, (DIGITIZER, CROSSES), options, findings)
            if table is not None:
                lists.read(table)
    names = tuple(file for _, file in files)
    _check_sheets(names, entries, lists, findings)
    return InputTables("sheet", _tables(entries, lists), (), names)


def _entries(document: Section, already: dict[str, SheetEntry]) -> dict[str, SheetEntry]:
    sheets = document.section("sheet")
    entries: dict[str, SheetEntry] = {}
    for key in sheets.data:
        section = sheets.section(key)
        try:
            name = parse_name(key)
        except BadValue as bad:
            sheets.problem(key, f'sheet "{shown(key)}": {bad.message}', bad.hint)
            continue
        if name in already or name in entries:
            sheets.problem(key, f'sheet "{shown(name)}" was already described')
        entries[name] = _entry(section)
    document.finish()
    return entries


def _entry(section: Section) -> SheetEntry:
    crs = section.text("crs")
    kind = ""
    if crs is not None:
        try:
            kind = crs_kind(crs)
            if kind not in ("geographic", "projected"):
                raise BadValue(f"{shown(crs)} is {kind}", "A sheet has geographic or projected coordinates")
        except BadValue as bad:
            section.problem("crs", f"crs: {bad.message}", bad.hint)
    entry = SheetEntry(
        section,
        section.text("title") or "",
        crs,
        kind,
        None if section.value("degree") == "auto" else section.whole("degree", 1, HIGHEST_DEGREE),
        section.sigma("sigma_mm"),
        section.number("pixel_size_mm", 1e-5, 10, "mm"),
    )
    section.finish()
    return entry


def _check_sheets(files: tuple[str, ...], entries: dict[str, SheetEntry], lists: SheetRows, findings: Findings) -> None:
    where = ", ".join(files)
    with_crosses = {cross.sheet for cross in lists.crosses} | lists.broken_sheets
    for sheet, place in lists.first_reading.items():
        if sheet not in with_crosses and not lists.crosses_unreadable:
            findings.problem(*place, f'sheet "{shown(sheet)}" has no crosses')
    for sheet, entry in entries.items():
        if sheet not in with_crosses and not lists.crosses_unreadable and entry.section is not None:
            entry.section.problem("", f'sheet "{shown(sheet)}" has no crosses', "Check the name")
    by_sheet: dict[str, list[Cross]] = {}
    for cross in lists.crosses:
        by_sheet.setdefault(cross.sheet, []).append(cross)
    for sheet, crosses in by_sheet.items():
        _check_coordinates(sheet, crosses, entries.get(sheet, SheetEntry(None)), findings)
        rows = [cross.row for cross in crosses]
        check_apart(f'{crosses[0].file}: sheet "{shown(sheet)}"', rows, "cross", ("X_mm", "Y_mm"), findings)
    check_weights(where, lists.readings, ("sigma_H_m",), findings)


def _check_coordinates(sheet: str, crosses: list[Cross], entry: SheetEntry, findings: Findings) -> None:
    """B, L or E, N, but one of them for all crosses of a sheet, and in a system of the same kind."""
    first = crosses[0]
    called = f'sheet "{shown(sheet)}"'
    on_grid = [cross for cross in crosses if cross.row["E_m"] is not None]
    if 0 < len(on_grid) < len(crosses):
        findings.problem(first.file, 0, f"{called} has crosses with B_deg, L_deg and with E_m, N_m")
    elif on_grid and entry.crs is None:
        hint = f"Give crs in [sheet.{shown(sheet)}] of sheet.toml"
        findings.problem(first.file, first.line, f"{called}: E_m, N_m need a crs", hint)
    elif on_grid and entry.crs_kind == "geographic":
        findings.problem(first.file, first.line, f"{called}: E_m, N_m, but crs {entry.crs} is in degrees")
    elif not on_grid and entry.crs_kind == "projected":
        hint = "Give the geographic system of its graticule"
        findings.problem(first.file, first.line, f"{called}: B_deg, L_deg, but crs {entry.crs} is in metres", hint)
    elif on_grid and all(look_like_degrees(cross.row) for cross in on_grid):
        findings.problem(first.file, 0, f"{called}: values look like degrees, crs {entry.crs} is in metres")


def look_like_degrees(row: Row) -> bool:
    values = (row["E_m"], row["N_m"])
    return all(isinstance(value, float) and abs(value) <= DEGREES_AT_MOST for value in values)


def _tables(entries: dict[str, SheetEntry], lists: SheetRows) -> dict[str, list[Row]]:
    sheets = dict.fromkeys(cross.sheet for cross in lists.crosses)
    tables: dict[str, list[Row]] = {
        "map_sheet": [_sheet_row(sheet, entries.get(sheet, SheetEntry(None))) for sheet in sheets],
        "graticule_cross": [{"seq": seq, **cross.row} for seq, cross in enumerate(lists.crosses, start=1)],
        "digitizer_reading": [{"seq": seq, **row} for seq, row in enumerate(lists.readings, start=1)],
    }
    return {name: rows for name, rows in tables.items() if rows}


def _sheet_row(sheet: str, entry: SheetEntry) -> Row:
    return {
        "sheet": sheet,
        "title": entry.title or sheet,
        "crs": entry.crs,
        "degree": entry.degree,
        "sigma_mm": entry.sigma_mm,
        "pixel_size_mm": entry.pixel_size_mm,
    }
