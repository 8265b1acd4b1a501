"""A report of 100 000 points: it stays small, and takes neither minutes nor gigabytes. Slow."""

import json
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from orient.store.digest import input_digest
from orient.store.project import NewRun, Project, open_project
from orient.values import Outcome, Row
from tests.cli.commands import ENTRY, ROOT, orient

POINTS = 100_000
OF_POINTS = ("image_point", "image_residual", "observation_test", "point_test", "equation", "ground_covariance")
OF_POINTS += ("ground_covariance_image", "error_budget", "adjusted_point", "topocentric_point", "geographic_point")
CPU_S, PEAK_KB, FILE_BYTES = 60.0, 1_200_000, 6_000_000
"""Measured: 11 s of processor time, 0.6 GB, 3.2 MB; the limits leave room for slower machines."""


def many_points(path: Path) -> None:
    """Versions of each stage with the rows of each point repeated; only the report reads them."""
    with open_project(path, "write") as project:
        for stage in ("refine", "bl", "topocentric", "resection", "covariance"):
            _append(project, stage)


def _append(project: Project, stage: str) -> None:
    heads = project.heads()
    head, tables = heads[stage], project.read_tables(heads[stage].run_id)
    larger = {table: _repeated(rows) if table in OF_POINTS else rows for table, rows in tables.items()}
    inputs = {role: heads[role].run_id for role in head.inputs}
    outcome = Outcome(larger, project.events(head.run_id), head.summary)
    digest = input_digest(
        stage, head.stage_version, head.settings, {role: heads[role].output_digest for role in inputs}
    )
    project.append(NewRun(stage, head.stage_version, head.settings, inputs, digest, outcome, {}, "test", "many"))


def _repeated(rows: list[Row]) -> list[Row]:
    points = list(dict.fromkeys(row["point"] for row in rows))
    return [
        {
            **row,
            "point": f"{row['point']} {k}",
            **({"vx_mm": float(row["vx_mm"] or 0) + 1e-7 * k} if "vx_mm" in row else {}),
        }
        for k in range(POINTS // len(points))
        for row in rows
    ]


@pytest.mark.slow
def test_a_report_of_100_000_points_is_small_and_soon_there(aerial: Path) -> None:
    many_points(aerial)
    target = aerial.parent / "report.html"
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", ENTRY, "report", str(aerial), "-o", str(target)]
    subprocess.run(command, env=environment, check=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    text = target.read_text("utf-8")
    assert "of 100000 are shown." in text
    assert "the 2000 largest of 100000" in text
    found = {"cpu": used.ru_utime - before, "peak": used.ru_maxrss, "bytes": target.stat().st_size}
    assert found["cpu"] < CPU_S, json.dumps(found)
    assert found["peak"] < PEAK_KB, json.dumps(found)
    assert found["bytes"] < FILE_BYTES, json.dumps(found)
    assert orient("status", aerial).code == 0
