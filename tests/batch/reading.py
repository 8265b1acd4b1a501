"""What tests ask a summary and the projects, without the code that wrote them."""

import sqlite3
from collections import Counter
from contextlib import closing
from pathlib import Path
from typing import Any

COMPUTED = ("refine", "bl", "topocentric", "resection", "covariance")


def rows(summary: Path, query: str, parameters: tuple[Any, ...] = ()) -> list[dict[str, Any]]:
    with closing(sqlite3.connect(summary)) as base:
        base.row_factory = sqlite3.Row
        return [dict(row) for row in base.execute(query, parameters)]


def latest(summary: Path) -> dict[str, dict[str, Any]]:
    """The row of each photo by the name of its file; fails if a photo has two."""
    found = rows(summary, "SELECT * FROM orient_latest")
    by_name = {Path(row["path"]).name: row for row in found}
    assert len(by_name) == len(found)
    return by_name


def versions(project: Path) -> Counter[str]:
    """How many runs each computed stage has."""
    with closing(sqlite3.connect(project)) as base:
        stages = [stage for (stage,) in base.execute("SELECT stage FROM stage_run")]
    return Counter(stage for stage in stages if stage in COMPUTED)


def assert_each_ended_once(folder: Path, summary: Path, names: set[str]) -> None:
    """One good row per photo, one run per stage in every project, nothing beside the projects."""
    found = latest(summary)
    assert set(found) == names
    assert {row["exit_code"] for row in found.values()} == {0}
    per_batch = rows(summary, "SELECT count(*) AS n FROM orient_photo GROUP BY batch_id, path_digest")
    assert {row["n"] for row in per_batch} == {1}
    for name in names:
        assert versions(folder / name) == Counter(COMPUTED), name
    assert {entry.name for entry in folder.iterdir() if entry.suffix != ".sqlite"} <= {summary.name}
