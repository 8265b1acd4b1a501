"""Findings first: the verdict, the problems with what to do, and the exit code of what is no result."""

import csv
import json
import re
import shutil
from pathlib import Path

import pytest

from orient.report.findings import REMEDIES, SHOWN, SHOWN_OF_A_KIND, findings, print_findings, verdict
from orient.values import Event
from tests.cli.commands import AERIAL, ROOT, SAMPLES, orient


def with_control_changed(tmp_path: Path, change: dict[str, float]) -> Path:
    """The sample with the easting of some points moved, computed."""
    lines = list(csv.reader((AERIAL / "control.csv").read_text("utf-8").splitlines()))
    head = lines[0]
    column = next(i for i, name in enumerate(head) if name in ("X_m", "E_m"))
    for line in lines[1:]:
        line[column] = repr(float(line[column]) + change.get(line[0], 0.0))
    changed = tmp_path / "control.csv"
    changed.write_text("\n".join(",".join(line) for line in lines) + "\n", "utf-8")
    project = tmp_path / "photo.sqlite"
    assert orient("new", project, "--from", AERIAL).code == 0
    extra = [AERIAL / "control.toml"] if (AERIAL / "control.toml").exists() else []
    assert orient("add", project, "control", changed, *extra, "-m", "a slip").code == 0
    return project


def first_points(count: int) -> list[str]:
    rows = list(csv.reader((AERIAL / "control.csv").read_text("utf-8").splitlines()))
    return [row[0] for row in rows[1 : count + 1]]


def test_status_opens_with_the_verdict(aerial: Path) -> None:
    lines = orient("status", aerial).out.splitlines()
    assert lines[0] == f"{aerial}: Oriented, but with 2 problems: read them before you use a number."
    assert lines[1].startswith("  warning: resection: sigma0 is 1.82 times its value a priori")
    assert "200 (|tau| 2.72 of image y exceeds 2.68) is suspected" in lines[2]
    assert lines[3].strip().startswith("-> Look at the point first; leave it out with --reject")
    assert "6 points are measured on the photo but have no ground coordinates" in lines[4]
    assert lines[5].strip().startswith("-> Give these points coordinates")


def test_status_of_a_good_result(space: Path) -> None:
    assert "with a problem" in orient("status", space).out.splitlines()[0]  # the sample's planted slip in one cycle
    assert orient("run", space).code == 0
    assert orient("refine", space, "--reject", "-m", "a slip").code == 0
    assert "out of date" in orient("status", space).out.splitlines()[0]
    assert orient("run", space).code == 0
    assert orient("status", space, "--json").out.count('"severity": "warning"') == 1  # the rejection is still told


def test_status_of_a_project_that_is_not_computed(fresh: Path) -> None:
    assert orient("status", fresh).out.splitlines()[0] == f"{fresh}: Not oriented yet."


def test_a_gross_error_is_the_first_thing_that_status_says(tmp_path: Path) -> None:
    (point,) = first_points(1)
    project = with_control_changed(tmp_path, {point: 40.0})
    orient("run", project)
    lines = orient("status", project).out.splitlines()
    assert "Oriented, but with" in lines[0]
    assert "warning: resection: " in lines[1]
    told = json.loads(orient("status", project, "--json").out)
    assert told["verdict"] == "doubtful"
    assert {"global_test"} <= {finding["code"] for finding in told["findings"]}


def test_a_failed_version_is_shown_with_exit_code_1(tmp_path: Path) -> None:
    points = first_points(8)
    project = with_control_changed(tmp_path, {p: 3e4 * (-1) ** i * (i + 1) for i, p in enumerate(points)})
    assert orient("run", project).code == 1
    assert "No valid result: resection failed." in orient("status", project).out.splitlines()[0]
    said = orient("show", project, "resection")
    assert said.code == 1
    assert "FAILED, this is not a result" in said.out
    assert orient("show", project, "resection", "--json").code == 1


def test_show_without_a_stage_is_the_orientation(aerial: Path) -> None:
    assert orient("show", aerial).out == orient("show", aerial, "resection").out


def test_many_findings_of_a_kind_are_told_once(capsys) -> None:  # type: ignore[no-untyped-def]
    events = [Event("warning", "cycle_outlier", f"P{i}", f"P{i} is odd") for i in range(10)]
    print_findings(findings("refine", [*events, Event("error", "singular", "", "a line")]))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "  error: a line"
    assert sum("is odd" in line for line in lines) == SHOWN_OF_A_KIND
    assert f"P2 is odd (and {10 - SHOWN_OF_A_KIND} more of this kind)" in "\n".join(lines)
    assert SHOWN > SHOWN_OF_A_KIND


def test_verdict_of_every_state() -> None:
    problem = findings("resection", [Event("warning", "global_test", "", "bad")])
    note = findings("resection", [Event("info", "correlation", "", "so so")])
    final = ("resection",)
    assert verdict({"resection": "failed"}, [], final).word == "failed"
    assert verdict({"resection": "waiting"}, [], final).word == "incomplete"
    assert verdict({"resection": "stale"}, [], final).word == "stale"
    assert verdict({"resection": "current"}, problem, final).word == "doubtful"
    assert verdict({"resection": "current"}, note, final).word == "good"


def test_every_remedy_belongs_to_a_finding_that_exists() -> None:
    pages = [path for floor in ("pipeline", "store", "intake") for path in (ROOT / "orient" / floor).rglob("*.py")]
    words = set(re.findall(r'"([a-z_]+)"', "\n".join(page.read_text("utf-8") for page in pages)))
    assert set(REMEDIES) <= words


def test_show_says_that_a_result_is_out_of_date(aerial: Path) -> None:
    assert "OUT OF DATE" not in orient("show", aerial, "covariance").out
    assert json.loads(orient("show", aerial, "covariance", "--json").out)["stale"] == ""
    assert orient("resection", aerial, "--reject").code == 0
    why = "resection is version 2, version 1 was read"
    assert f"  OUT OF DATE: {why}; run: orient run {aerial}\n" in orient("show", aerial, "covariance").out
    assert json.loads(orient("show", aerial, "covariance", "--json").out)["stale"] == why
    assert "OUT OF DATE" not in orient("show", aerial, "resection").out


def test_a_later_version_that_failed_is_told_until_somebody_decides(aerial: Path) -> None:
    assert orient("resection", aerial, "--max-iterations", "2").code == 1
    lines = orient("status", aerial).out.splitlines()
    assert lines[0] == f"{aerial}: Oriented, but with 3 problems: read them before you use a number."
    assert lines[1].startswith("  warning: resection: version 2 failed later: MAX_ITERATIONS: ")
    assert lines[1].endswith("; version 1 is still the current one")
    assert "orient show PROJECT resection --version 2" in lines[2]
    shown = orient("show", aerial, "resection")
    assert shown.code == 0  # what is shown is a result
    assert shown.out.splitlines()[2].strip().startswith("warning: version 2 failed later")
    assert json.loads(orient("show", aerial, "--json").out)["later_failures"][0]["code"] == "later_failure"
    assert orient("show", aerial, "resection", "--version", "2").code == 1
    assert "later_failure" in orient("status", aerial, "--json").out
    # somebody decides for the older one
    assert orient("select", aerial, "resection", "1", "-m", "two iterations are too few").code == 0
    assert "failed later" not in orient("status", aerial).out + orient("show", aerial).out


def test_a_later_success_ends_the_remark(aerial: Path) -> None:
    assert orient("resection", aerial, "--max-iterations", "2").code == 1
    assert orient("resection", aerial, "--max-iterations", "60").code == 0
    assert "failed later" not in orient("status", aerial).out


@pytest.mark.parametrize("sigma_um, code", [(5.0, "global_test"), (8.0, ""), (30.0, "small_sigma0")])
def test_finding_and_table_of_the_global_test_say_the_same(tmp_path: Path, sigma_um: float, code: str) -> None:
    """sigma0 is 10.9 um with r = 10: 5 % on both sides is 0.57 ... 1.43 of the value a priori."""
    folder = shutil.copytree(SAMPLES / "calgary-28", tmp_path / "folder")
    text = (folder / "photo.toml").read_text(encoding="utf-8")
    (folder / "photo.toml").write_text(re.sub(r"sigma_image_mm = [\d.]+", f"sigma_image_mm = {sigma_um / 1e3}", text))
    path = tmp_path / "photo.sqlite"
    assert orient("new", path, "--from", folder).code == 0
    orient("run", path)
    (row,) = json.loads(orient("sql", path, "global-test", "--json").out)
    told = json.loads(orient("show", path, "--json").out)["events"]
    codes = [event["code"] for event in told if event["code"] in ("global_test", "small_sigma0")]
    assert codes == ([code] if code else [])
    assert row["verdict"] == {"global_test": "too large", "": "accepted", "small_sigma0": "too small"}[code]
