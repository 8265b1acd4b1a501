"""CSV files: separator and columns from the header line, then one record per line, streamed."""

import csv
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from orient.intake.findings import Findings, nearest, shown
from orient.intake.options import ReadOptions
from orient.intake.text_file import Lines, csv_lines
from orient.words import counted

SEPARATORS = ",;\t"
COMMENT = "#"


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of one kind of file.

    Of `choices` exactly one group must be there (`may_lack_choice`: or none); `mark` is the column that tells this
    kind of file from another that is read by the same command.
    """

    required: tuple[str, ...]
    choices: tuple[tuple[str, ...], ...] = ()
    optional: tuple[str, ...] = ()
    may_lack_choice: bool = False
    mark: str = ""

    @property
    def known(self) -> tuple[str, ...]:
        return (*self.required, *(column for group in self.choices for column in group), *self.optional)

    @property
    def example(self) -> str:
        return ",".join((*self.required, *(self.choices[0] if self.choices else ())))


@dataclass(frozen=True, slots=True)
class Record:
    """One data line: its cells by column name, as text."""

    line: int
    cells: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class CsvTable:
    file: str
    layout: Layout
    columns: frozenset[str]
    records: Iterator[Record]


def open_csv(
    path: Path, file: str, layouts: Sequence[Layout], options: ReadOptions, findings: Findings
) -> CsvTable | None:
    """The table of the file, or None when its header cannot be taken; the records are read as they are asked for."""
    before = findings.count(file)
    lines = csv_lines(path, file, options, findings)
    header = next((item for item in lines if not _is_blank(item[1])), None)
    if header is None:
        if findings.count(file) == before:
            findings.problem(file, 0, "the file is empty", f"Expected a header line: {layouts[0].example}")
        return None
    line, text = header
    columns, separator = _header_cells(text, layouts)
    layout = next((each for each in layouts if each.mark and each.mark in columns), layouts[-1])
    if not _header_fits(file, line, columns, layout, options, findings):
        return None
    known = frozenset(columns) & frozenset(layout.known)
    return CsvTable(file, layout, known, _records(file, lines, columns, separator, findings))


def _is_blank(text: str) -> bool:
    return not text.strip() or text.startswith(COMMENT)


def _header_cells(text: str, layouts: Sequence[Layout]) -> tuple[list[str], str]:
    """The separator is the one that finds the most known columns."""
    known = {column for layout in layouts for column in layout.known}
    splits = {mark: [cell.strip() for cell in text.replace('"', "").split(mark)] for mark in SEPARATORS}
    separator = max(SEPARATORS, key=lambda mark: len(known.intersection(splits[mark])))
    return splits[separator], separator


def _header_fits(
    file: str, line: int, columns: list[str], layout: Layout, options: ReadOptions, findings: Findings
) -> bool:
    before = findings.count(file)
    found = shown(", ".join(columns))
    for column, times in Counter(columns).items():
        if times > 1:
            words = "twice" if times == 2 else f"{times} times"
            findings.problem(file, line, f'column "{shown(column)}" appears {words}')
        elif column not in layout.known and not options.ignore_columns:
            hint = nearest(column, layout.known) or "Leave it out, or --ignore-columns"
            findings.problem(file, line, f'column "{shown(column)}" is not known', hint)
    for column in _missing(frozenset(columns), layout):
        findings.problem(file, line, f'column "{column}" is missing; found {found}')
    _check_choice(file, line, frozenset(columns), layout, found, findings)
    return findings.count(file) == before


def _missing(columns: frozenset[str], layout: Layout) -> list[str]:
    """Required columns that are not there, and the rest of a group of which one column is there."""
    missing = [column for column in layout.required if column not in columns]
    for group in layout.choices:
        if columns.intersection(group):
            missing += [column for column in group if column not in columns]
    return missing


def _check_choice(
    file: str, line: int, columns: frozenset[str], layout: Layout, found: str, findings: Findings
) -> None:
    begun = [group for group in layout.choices if columns.intersection(group)]
    groups = " or ".join(", ".join(group) for group in layout.choices)
    if len(begun) > 1:
        findings.problem(file, line, f"give {groups}: one of them, not {len(begun)}")
    elif layout.choices and not begun and not layout.may_lack_choice:
        findings.problem(file, line, f"columns {groups} are missing; found {found}")


def _records(file: str, lines: Lines, columns: list[str], separator: str, findings: Findings) -> Iterator[Record]:
    before = findings.count(file)
    any_line = False
    for line, text in lines:
        if findings.too_many(file):
            findings.stop(file, line)
            return
        if _is_blank(text):
            continue
        any_line = True
        cells = _cells(file, line, text, separator, findings)
        if cells is None:
            continue
        if len(cells) == len(columns):
            yield Record(line, dict(zip(columns, cells, strict=True)))
        else:
            findings.problem(file, line, f"{counted(len(cells), 'value')}, expected {len(columns)}")
    if not any_line and findings.count(file) == before:
        findings.problem(file, 0, "no data lines")


def _cells(file: str, line: int, text: str, separator: str, findings: Findings) -> list[str] | None:
    if '"' not in text:
        return text.split(separator)
    try:
        return next(csv.reader([text], delimiter=separator, strict=True))
    except csv.Error as error:
        if "unexpected end" in str(error):
            findings.problem(file, line, "quote opened here is never closed", "A cell ends in its own line")
        else:
            findings.problem(file, line, "quotes are not in order", 'Write "" for a quote inside quotes')
    return None
