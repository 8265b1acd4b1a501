"""Gross errors in a model or its control, as a user meets them: named, left out, taken back, or refused."""

import csv
import shutil
from pathlib import Path

import pytest

from tests.cli.commands import SAMPLES, orient
from tests.cli.test_blunders import asked

MODEL = SAMPLES / "simulated-model-two-zones"
WIDTH = 80
Errors = dict[tuple[str, str], tuple[float, float, float]]
ONE: Errors = {("west", "W04"): (0.0, 0.3, 0.0)}
TWO: Errors = {("west", "W04"): (0.0, 0.3, 0.0), ("west", "W01"): (0.4, 0.0, 0.3)}
HALF: Errors = {
    ("west", f"W0{i + 1}"): (0.7 * i - 2.0, 1.0 - 0.5 * i, 0.4 * i) for i in range(6)
}  # fmt: skip
"""mm in the model, whose points are good to 4 um (7 um in z): 6 m on the ground is 0.3 mm."""


def project(folder: Path, errors: Errors, *, drop_sigmas: bool = False) -> Path:
    """The sample with wrong model coordinates, before the first run."""
    source = shutil.copytree(MODEL, folder / "source")
    rows = _read(source / "model.csv")
    for row in rows:
        for axis, error in zip("xyz", errors.get((row["zone"], row["point"]), (0.0, 0.0, 0.0)), strict=True):
            row[axis] = str(float(row[axis]) + error)
        for name in [name for name in row if drop_sigmas and name.startswith("cov_")]:
            del row[name]
    _write(source / "model.csv", rows)
    if drop_sigmas:
        control = _read(source / "control.csv")
        _write(source / "control.csv", [{k: v for k, v in row.items() if not k.startswith("sigma")} for row in control])
    path = folder / "model.sqlite"
    assert orient("new", path, "--from", source).code == 0
    return path


def _read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _write(path: Path, rows: list[dict[str, str]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


EXCLUDED = "SELECT part, point, decided_by, action, reason FROM v_exclusion WHERE is_current"
ROLES = "SELECT zone, point FROM absolute_residual r JOIN v_current c USING (run_id) WHERE r.role = 'excluded'"


def shift(path: Path) -> list[float]:
    sql = "SELECT X_0_m, Y_0_m, Z_0_m FROM absolute_orientation JOIN v_current USING (run_id) WHERE zone = 'west'"
    return [float(cell) for cell in asked(path, sql)[0]]


@pytest.fixture(scope="module")
def true_shift(tmp_path_factory: pytest.TempPathFactory) -> list[float]:
    path = project(tmp_path_factory.mktemp("clean"), {})
    assert orient("run", path).code == 0
    return shift(path)


def test_one_wrong_point_is_named_proposed_left_out_and_taken_back(tmp_path: Path, true_shift: list[float]) -> None:
    path = project(tmp_path, ONE)
    said = orient("run", path)
    assert said.code == 0, said.err
    assert "the global test fails: a gross error or too small sigmas; W04 fits worst" in said.out
    assert "west/W04 (|tau|" in said.out and "is suspected of a gross error and kept" in said.out
    assert [row[:4] for row in asked(path, EXCLUDED)] == [["west", "W04", "snooping", "proposed"]]
    assert asked(path, ROLES) == []

    said = orient("absolute", path, "--reject", "-m", "without what contradicts")
    assert said.code == 0 and "1 point excluded" in said.out
    assert [row[:4] for row in asked(path, EXCLUDED)] == [["west", "W04", "snooping", "excluded"]]
    assert asked(path, ROLES) == [["west", "W04"]]
    assert shift(path) == pytest.approx(true_shift, abs=0.05)  # sd 0.045 m with W04
    # one of the ways back, and all of them
    assert orient("absolute", path, "--variance", "priori").code == 0
    assert len(asked(path, ROLES)) == 1  # settings hold
    for back in (("--keep",), ("--exclude", "none"), ("--defaults",)):
        assert orient("select", path, "absolute", "2", "-m", "back").code == 0
        assert orient("absolute", path, *back).code == 0
        assert asked(path, ROLES) == [], back
    assert orient("check", path).code == 0


def test_robust_finds_two_that_hide_each_other(tmp_path: Path, true_shift: list[float]) -> None:
    path = project(tmp_path, TWO)
    assert orient("run", path).code == 0
    said = orient("absolute", path, "--reject")
    assert "no single observation stands out: several errors may hide one another" in said.out
    assert "--robust starts from the points that agree" in said.out
    said = orient("absolute", path, "--keep", "--robust")
    assert said.code == 0, said.err
    assert "zone west: robust estimation left out 2 of 10 control points: W01, W04" in said.out
    assert [row[1:4] for row in asked(path, EXCLUDED)] == [["W01", "robust", "excluded"], ["W04", "robust", "excluded"]]
    assert shift(path) == pytest.approx(true_shift, abs=0.1)
    # with the sigmas given instead of sigma0 found, one by one is enough
    assert orient("absolute", path, "--plain", "--reject", "--test", "w").code == 0
    assert sorted(row[1] for row in asked(path, EXCLUDED)) == ["W01", "W04"]


def test_more_than_half_wrong_is_a_failure_without_a_result(tmp_path: Path) -> None:
    path = project(tmp_path, HALF)
    for stage in ("bl", "topocentric"):
        assert orient(stage, path).code == 0
    said = orient("absolute", path, "--robust")
    assert said.code == 1
    assert said.err.startswith("orient: absolute: zone west: ROBUST_FAILED: ")
    assert asked(path, "SELECT count(*) FROM absolute_orientation") == [["0"]]
    assert asked(path, "SELECT stage FROM v_current WHERE stage = 'absolute'") == []


def test_exclusion_by_hand_names_the_zone_where_it_must(tmp_path: Path) -> None:
    path = project(tmp_path, {})
    assert orient("run", path).code == 0
    # T01 is control of both zones
    assert orient("absolute", path, "--exclude", "T01", "--reason", "moved since").code == 0
    assert asked(path, ROLES) == [["east", "T01"], ["west", "T01"]]
    assert orient("absolute", path, "--exclude", "west/T01,W02", "--reason", "moved since").code == 0
    assert sorted(asked(path, EXCLUDED)) == [
        ["west", "T01", "hand", "excluded", "moved since"], ["west", "W02", "hand", "excluded", "moved since"],
    ]  # fmt: skip
    unknown = orient("absolute", path, "--exclude", "west/E01", "--reason", "typo")
    assert unknown.code == 1 and 'names "west/E01", which is no control point' in unknown.err
    assert orient("absolute", path, "--exclude", "T01").code == 2


def test_reliability_of_both_sides_is_shown_and_asked(tmp_path: Path) -> None:
    path = project(tmp_path, {})
    assert orient("run", path).code == 0
    lines = orient("show", path, "absolute").out.splitlines()
    assert "global test at 5 %: v'Pv/sigma0^2 = 13.70, accepted from 6.26 to 27.49: accepted" in lines
    first = next(i for i, line in enumerate(lines) if line.startswith("Reliability: "))
    assert max(len(line.rstrip()) for line in lines[first + 1 :]) <= WIDTH
    sums = asked(
        path, "SELECT part, sum(redundancy_number), min(share), max(share), count(critical) FROM v_reliability "
        "WHERE is_current GROUP BY part ORDER BY part",
    )  # fmt: skip
    assert [float(row[1]) for row in sums] == pytest.approx([10.0, 15.0], abs=1e-9)
    assert all(0 <= float(row[2]) <= float(row[3]) <= 1 for row in sums)
    assert [int(row[4]) for row in sums] == [44, 52]  # both sides of every coordinate that was given, one test each
    kinds = asked(path, "SELECT DISTINCT kind, unit FROM v_reliability WHERE is_current ORDER BY kind")
    assert kinds == [["ground", "m"], ["model", "model"]]
    unknowns = asked(path, "SELECT DISTINCT unknown, unit FROM external_reliability ORDER BY unknown")
    assert unknowns == [
        ["H", "model/m"], ["X_0", "m"], ["Y_0", "m"], ["Z_0", "m"], ["eta", "deg"], ["theta", "deg"], ["xi", "deg"],
    ]  # fmt: skip
    for question in ("suspects", "reliability", "excluded", "global-test"):
        assert orient("sql", path, question).code == 0
    assert len(asked(path, "SELECT * FROM v_adjustment_test WHERE is_current")) == 2


def test_without_sigmas_tau_is_tested_and_what_needs_them_is_refused(tmp_path: Path) -> None:
    path = project(tmp_path, ONE, drop_sigmas=True)
    said = orient("run", path)
    assert said.code == 0, said.err
    assert asked(path, "SELECT DISTINCT test, verdict FROM v_adjustment_test WHERE is_current") == [["tau", ""]]
    assert asked(path, "SELECT DISTINCT kind FROM v_reliability WHERE is_current") == [["ground"]]
    for option, value in (("--test", "w"), ("--robust", "")):
        said = orient("absolute", path, *filter(None, (option, value)))
        assert said.code == 1
        assert f"{option}{' w' if value else ''} needs standard deviations" in said.err
        assert "--sigma-model" in said.err
    assert orient("absolute", path, "--sigma-model", "0.01", "--robust").code == 0


def test_a_project_with_exclusions_is_verified(tmp_path: Path) -> None:
    path = project(tmp_path, ONE)
    orient("run", path)
    orient("absolute", path, "--reject")
    said = orient("verify", path)
    assert said.code == 0, said.out
    lines = said.out.splitlines()
    solved = [lines[i + 1] for i, line in enumerate(lines) if line.startswith("absolute ")]
    assert len(solved) == 2 and all(line.strip().startswith("scipy least_squares: rotation") for line in solved)
