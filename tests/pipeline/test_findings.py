"""What is said before the numbers: the global test, and the point that contradicts the others."""

import csv
import shutil
from pathlib import Path

import pytest

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import Result, create, run_stale

SAMPLE = Path(__file__).parents[2] / "sample_projects" / "strasbourg-sxb-8937"


def resection_with(tmp_path: Path, point: str, column: str, error: float) -> Result:
    """The sample's resection with one control coordinate wrong by `error`."""
    folder = shutil.copytree(SAMPLE, tmp_path / "folder", ignore=shutil.ignore_patterns("*.jpg"))
    with (folder / "control.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        if row["point"] == point:
            row[column] = str(float(row[column]) + error)
    with (folder / "control.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    path = tmp_path / "photo.sqlite"
    create(path, read_project(folder, ReadOptions()), "test")
    results = run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    return next(result for result in results if result.stage == "resection")


def test_good_data_raise_no_warning(tmp_path: Path) -> None:
    events = resection_with(tmp_path, "317", "X_m", 0.0).events
    assert [event.code for event in events if event.severity == "warning"] == []


@pytest.mark.parametrize("error", [5.0, 100.0], ids=["5 m", "100 m"])
def test_gross_error_fails_the_global_test_and_is_named(tmp_path: Path, error: float) -> None:
    result = resection_with(tmp_path, "651", "X_m", error)
    (event,) = (event for event in result.events if event.code == "global_test")
    assert event.severity == "warning"
    assert event.message.endswith("651 fits worst")


def test_absurd_point_is_named_where_no_orientation_is_found(tmp_path: Path) -> None:
    result = resection_with(tmp_path, "317", "X_m", 4e3)
    assert result.failed
    assert [event.subject for event in result.events if event.code == "odd_point"] == ["317"]


def test_point_in_another_country_is_named_and_not_used(tmp_path: Path) -> None:
    result = resection_with(tmp_path, "317", "X_m", 5e6)
    assert not result.failed
    assert [event.subject for event in result.events if event.code == "far_point"] == ["317"]
    assert not any(event.code in ("odd_point", "global_test") for event in result.events)
