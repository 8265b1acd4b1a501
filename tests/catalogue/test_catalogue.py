"""The whole bad-input catalogue (RELIABILITY.md 7, A to F), one row one id, through the real commands."""

import pytest

from tests.catalogue import camera, points, project
from tests.catalogue.case import Case, Place, examine

TABLES = (points.CASES, camera.CASES, project.CASES)
CASES: dict[str, Case] = {name: case for table in TABLES for name, case in table.items()}


@pytest.mark.parametrize("name", CASES)
def test_row(name: str, place: Place) -> None:
    examine(CASES[name], place)
