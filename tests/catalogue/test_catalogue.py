"""The whole bad-input catalogue (RELIABILITY.md 7, A to F), one row one id, through the real commands."""

import pytest

from tests.catalogue import camera, command_line, control, output, points, project
from tests.catalogue.case import Case, Place, examine
from tests.promises import Promise

TABLES = (points.CASES, camera.CASES, control.CASES, project.CASES, command_line.CASES, output.CASES)
CASES: dict[str, Case] = {name: case for table in TABLES for name, case in table.items()}


@pytest.mark.parametrize("name", CASES)
def test_row(name: str, place: Place, promise: Promise, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place.root)
    with promise("B").trial(name):
        examine(CASES[name], place)


def test_no_name_stands_in_two_tables() -> None:
    assert len(CASES) == sum(len(table) for table in TABLES)
