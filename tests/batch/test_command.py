"""The options of `orient batch` as a user meets them; no worker is started here."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.batch.reading import latest, rows, versions
from tests.cli.commands import ENTRY, ROOT, orient, without


@pytest.fixture
def two(projects: Path) -> Path:
    for path in sorted(projects.iterdir())[2:]:
        path.unlink()
    return projects


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--workers", "2", "--scheduler", "tcp://h:1"), "--workers and --scheduler exclude each other"),
        (("--memory-mib", "500", "--workers", "0"), "--memory-mib is for local workers"),
        (("--workers", "-1"), "-1"),
        (("--decimal", "semicolon", "--from", "x"), "--decimal"),
        (("--control", "perhaps"), "is not one of"),
        (("--from", "nowhere"), "nowhere cannot be read"),
        (("--from", "."), "no folder in . has a photo.toml"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else None,
)
def test_refused(words: tuple[str, ...], said: str, two: Path) -> None:
    done = orient("batch", two, *words)
    assert (done.code, said in done.err) == (2, True), done.err
    assert len(list(two.iterdir())) == 2


def test_dry_run_changes_nothing(two: Path) -> None:
    before = {path.name: path.read_bytes() for path in two.iterdir()}
    done = orient("batch", two, "--dry-run")
    assert (done.code, "2 photos, 2 to do; nothing was done" in done.out) == (0, True)
    assert {path.name: path.read_bytes() for path in two.iterdir()} == before
    assert orient("batch", two, "--workers", "0").code == 0
    told = json.loads(orient("batch", two, "--dry-run", "--json").out)
    assert [(Path(one["path"]).name, one["state"]) for one in told] == [
        ("P000.sqlite", "done"),
        ("P001.sqlite", "done"),
    ]


def test_what_is_done_makes_no_batch(two: Path) -> None:
    assert orient("batch", two, "--workers", "0").code == 0
    again = json.loads(orient("batch", two, "--workers", "0", "--json").out)
    assert (again["batch"], again["done_before"], again["computed"]) == (None, 2, 0)
    assert len(rows(two / "orient-summary.db", "SELECT * FROM orient_batch")) == 1


def test_a_lost_summary_is_written_anew_without_computing(two: Path) -> None:
    assert orient("batch", two, "--workers", "0").code == 0
    first = latest(two / "orient-summary.db")
    (two / "orient-summary.db").unlink()
    told = json.loads(orient("batch", two, "--workers", "0", "--json").out)
    assert (told["good"], told["computed"]) == (2, 0)
    again = latest(two / "orient-summary.db")
    for column in ("x_s_m", "sigma_kappa_deg", "sigma0_mm", "verdict"):
        assert [row[column] for row in again.values()] == [row[column] for row in first.values()]


def test_settings_and_reason_reach_every_project(two: Path) -> None:
    done = orient("batch", two, "--workers", "0", "--control", "fixed", "--reject", "-m", "archive of 1968")
    assert done.code == 0
    summary = two / "orient-summary.db"
    stored = rows(summary, "SELECT settings FROM orient_stage WHERE stage = 'resection'")
    assert [(json.loads(row["settings"])["control"], json.loads(row["settings"])["reject"]) for row in stored] == [
        ("fixed", True)
    ] * 2
    (batch,) = rows(summary, "SELECT reason, settings, n_photos FROM orient_batch")
    assert batch == {"reason": "archive of 1968", "settings": '{"control": "fixed", "reject": true}', "n_photos": 2}
    reasons = rows(two / "P000.sqlite", "SELECT DISTINCT reason FROM stage_run WHERE stage = 'resection'")
    assert reasons == [{"reason": "archive of 1968"}]


def test_a_summary_among_the_projects_is_no_project(two: Path) -> None:
    for _ in range(2):
        done = orient("batch", two, "--workers", "0", "--summary", two / "all.sqlite")
        assert (done.code, "2 photos" in done.out) == (0, True)
    assert orient("status", two / "all.sqlite").code == 3


def test_list_from_standard_input(two: Path) -> None:
    child = subprocess.run(
        [sys.executable, "-c", ENTRY, "batch", "-", "--workers", "0"],
        input=b"# the first\nP000.sqlite\n", env={**os.environ, "PYTHONPATH": str(ROOT)}, cwd=two, capture_output=True,
        check=False,
    )  # fmt: skip
    assert (child.returncode, child.stderr) == (0, b"")
    assert list(latest(two / "orient-summary.db")) == ["P000.sqlite"]
    assert not versions(two / "P001.sqlite")


def test_without_dask(two: Path) -> None:
    done = without("distributed", "batch", two)
    assert done.returncode == 2
    assert done.stderr.startswith("orient: the workers of batch need distributed, which is not installed\n")
    assert "pip install 'orient[batch]'" in done.stderr
