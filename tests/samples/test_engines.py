"""Every stage of every sample by Algorithm Z and by QR: the same numbers to 1e-9, settings told apart."""

from pathlib import Path

import numpy as np
import pytest

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create, run_stale
from orient.store.project import open_project
from orient.values import Tables

SAMPLES = Path(__file__).parents[2] / "sample_projects"
NAMES = sorted(folder.name for folder in SAMPLES.iterdir() if (folder / "photo.toml").exists())
ADJUSTING = ("refine", "digitize", "resection", "absolute")
ON_THE_WAY = ("equation", "start_candidate", "resection_solution")
"""How the result was reached: starts and ends that are none."""
ROUNDING = 1e-12
"""mm, m or degrees: the rounding of a residual is that of the coordinates it is the difference of."""


def stages_of(name: str, engine: str, path: Path) -> dict[str, Tables]:
    """All tables of the adjusting stages of a sample, computed with one engine."""
    create(path, read_project(SAMPLES / name, ReadOptions()), "test")
    run_stale(path, {"engine": engine}, "test", lambda stage: None, lambda result: None)
    with open_project(path) as project:
        heads = {stage: head for stage, head in project.heads().items() if stage in ADJUSTING}
        assert {head.settings["engine"] for head in heads.values()} == {engine}
        return {stage: project.read_tables(head.run_id) for stage, head in heads.items()}


def results(tables: Tables) -> dict[str, np.ndarray]:
    """Columns of numbers, but for those that tell how the result was reached."""
    return {
        f"{table}.{column}": np.array([np.nan if row[column] is None else row[column] for row in rows], dtype=float)
        for table, rows in tables.items()
        if table not in ON_THE_WAY and "iteration" not in table
        for column in rows[0]
        if any(isinstance(row[column], float) for row in rows) and column not in ("condition_ratio", "last_step")
    }


@pytest.mark.parametrize("name", NAMES)
def test_both_engines_give_the_same_numbers(name: str, tmp_path: Path) -> None:
    by_Z, by_qr = (stages_of(name, engine, tmp_path / f"{engine}.sqlite") for engine in ("zlatanov", "qr"))
    assert set(by_Z) == set(by_qr)
    assert by_Z
    for stage in by_Z:
        found, expected = results(by_Z[stage]), results(by_qr[stage])
        assert set(found) == set(expected)
        for column, values in expected.items():
            largest = float(np.nanmax(np.abs(values), initial=0.0))
            np.testing.assert_allclose(
                found[column], values, rtol=1e-9, atol=max(1e-9 * largest, ROUNDING), err_msg=f"{stage} {column}"
            )
