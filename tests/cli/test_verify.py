"""`orient verify` as a user gives it: what it says, what it keeps, and its exit codes."""

import json
import os
from pathlib import Path

import pytest

from orient.store.project import open_project
from tests.cli.commands import orient, orient_process
from tests.pipeline.forger import forge


def test_a_sound_file_is_verified_and_the_evidence_shown_everywhere(aerial: Path) -> None:
    said = orient("verify", aerial, "-m", "before the report")
    assert (said.code, said.err) == (0, "")
    assert "all bits equal" in said.out and "Kept as evidence: verify version 1" in said.out
    assert "verified 20" in orient("status", aerial).out
    assert "second engine agrees" in orient("show", aerial, "resection").out
    assert "before the report" in orient("log", aerial).out
    assert "scipy least_squares" in orient("show", aerial, "verify").out
    assert {row["verdict"] for row in json.loads(orient("sql", aerial, "verification", "--json").out)} == {"identical"}
    assert orient("check", aerial).code == 0
    assert "up to date" in orient("run", aerial).out


def test_status_says_what_is_not_verified(aerial: Path) -> None:
    assert "verified" not in orient("status", aerial).out
    orient("verify", aerial)
    assert orient("resection", aerial, "--engine", "qr").code == 0
    assert "not verified: resection 2" in orient("status", aerial).out


def test_a_difference_is_named_kept_and_ends_with_1(aerial: Path) -> None:
    forge(aerial, lambda bare: bare.execute("UPDATE orientation SET f_mm = f_mm + 0.001"))
    said = orient("verify", aerial)
    assert said.code == 1
    assert "DIFFERS orientation: f_mm stored" in said.out
    assert "not verified" in said.err
    assert "NOT VERIFIED" in orient("show", aerial, "verify").out
    assert "not verified: resection 1" in orient("status", aerial).out
    assert json.loads(orient("verify", aerial, "--json", "--no-record").out)["verified"] is False


def test_no_record_leaves_the_file_alone(aerial: Path) -> None:
    before = aerial.read_bytes()
    assert "Not kept" in orient("verify", aerial, "--no-record").out
    assert aerial.read_bytes() == before


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everything")
def test_a_read_only_file_can_be_verified(aerial: Path) -> None:
    aerial.chmod(0o400)
    said = orient("verify", aerial)
    assert (said.code, "--no-record" in said.err) == (3, True)
    assert orient("verify", aerial, "--no-record").code == 0


def test_a_simulation_is_told_and_kept(aerial: Path) -> None:
    said = orient("verify", aerial, "--simulate", "50", "--seed", "3")
    assert said.code == 0 and "50 simulated adjustments" in said.out
    with open_project(aerial) as project:
        settings = project.run("verify", 1).settings
        _, rows = project.query("SELECT unknown, n, agrees FROM simulated_spread ORDER BY unknown")
    assert settings == {"simulate": 50, "seed": 3}
    assert rows == [(name, 50, 1) for name in ("X_S", "Y_S", "Z_S", "r_X", "r_Y", "r_Z")]


def test_another_processor_is_compared_to_1e_9(aerial: Path) -> None:
    """OpenBLAS is told to use the code for an old processor, so that the last bits really differ (where it is x86)."""
    said = orient_process("verify", aerial, "--json", env={"OPENBLAS_CORETYPE": "Prescott"})
    assert said.code == 0, said.err
    rows = [row for row in json.loads(said.out)["tables"]["verified_run"] if row["method"] == "recomputed"]
    assert {row["compared"] for row in rows} == {"1e-9"}
    assert all("made by orient" in row["because"] for row in rows)
    assert all(row["largest_difference"] <= 1e-9 for row in rows)
