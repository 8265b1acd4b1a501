"""Fiducial marks and map crosses that determine nothing are refused by name, through the commands."""

import csv
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.commands import SPACE, orient

Row = dict[str, str]
Spoil = Callable[[list[Row]], list[Row]]


def keeping(keep: Callable[[Row], bool]) -> Spoil:
    return lambda rows: [row for row in rows if keep(row)]


def three_marks_on_a_line(rows: list[Row]) -> list[Row]:
    """Marks 1 and 2, and mark 5 read halfway between them."""
    one, two = (next(row for row in rows if row["point"] == mark) for mark in "12")
    middle = {axis: str((float(one[axis]) + float(two[axis])) / 2) for axis in ("x_mm", "y_mm")}
    kept = [row for row in rows if row["kind"] != "fiducial" or row["point"] in "125"]
    return [{**row, **middle} if row["kind"] == "fiducial" and row["point"] == "5" else row for row in kept]


SPOILED: dict[str, tuple[str, Spoil, str]] = {
    "two marks": (
        "readings.csv",
        keeping(lambda row: row["kind"] != "fiducial" or row["point"] in "12"),
        "2 fiducial marks are measured; affine needs 3",
    ),
    "marks on a line": (
        "readings.csv",
        three_marks_on_a_line,
        "the measured fiducial marks lie on one line",
    ),
    "three crosses": (
        "crosses.csv",
        keeping(lambda row: row["cross"] in ("40-18", "40-19", "41-18")),
        "sheet K-34: 3 crosses; 4 are needed to fit degree 1 with a check",
    ),
    "crosses on a line": (
        "crosses.csv",
        keeping(lambda row: row["cross"].endswith("-20")),
        "sheet K-34: the crosses lie on one line (off by ",
    ),
}


@pytest.mark.parametrize("case", SPOILED)
def test_refused_by_name(case: str, tmp_path: Path) -> None:
    name, spoil, message = SPOILED[case]
    folder = Path(shutil.copytree(SPACE, tmp_path / "in"))
    with (folder / name).open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with (folder / name).open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(spoil(rows))
    path = tmp_path / "p.sqlite"
    assert orient("new", path, "--from", folder).code == 0
    said = orient("run", path)
    assert said.code == 1
    assert message in said.out + said.err
    assert orient("sql", path, "orientation").out == "no rows\n"
