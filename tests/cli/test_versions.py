"""Versions as a user meets them: rerun, again, add, undo, diff, failure."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from orient.report.html.evidence import gather
from orient.store.check import check_project
from orient.store.errors import ChangedMeanwhile
from orient.store.project import RunInfo, open_project
from orient.values import Tables
from tests.cli.commands import AERIAL, ROOT, SPACE, Said, orient

MODELS = ROOT / "sample_projects" / "simulated-model-two-zones"
HEADER, *CONTROL = (AERIAL / "control.csv").read_text("utf-8").splitlines()


def heads(path: Path) -> dict[str, RunInfo]:
    with open_project(path) as project:
        return project.heads()


def count(path: Path) -> int:
    with open_project(path) as project:
        return len(project.runs())


def tables(path: Path, stage: str, version: int) -> Tables:
    with open_project(path) as project:
        return project.read_tables(project.run(stage, version).run_id)


def states(path: Path) -> dict[str, str]:
    return {entry["stage"]: entry["state"] for entry in json.loads(orient("status", path, "--json").out)["stages"]}


def add_control(path: Path, lines: list[str]) -> Said:
    file = path.parent / "control.csv"
    file.write_text("\n".join(lines) + "\n", "utf-8")
    said = orient("add", path, "control", file, AERIAL / "control.toml", "-m", "another list")
    file.unlink()
    return said


def test_rerun_has_nothing_to_do(aerial: Path) -> None:
    before = heads(aerial)
    said = orient("run", aerial)
    assert said.code == 0
    assert said.out.splitlines()[-1] == "Everything is up to date."
    assert heads(aerial) == before


def test_again_makes_a_new_version_with_the_same_numbers(aerial: Path) -> None:
    before = heads(aerial)["resection"]
    assert orient("resection", aerial, "--again").code == 0
    after = heads(aerial)["resection"]
    assert after.version == before.version + 1
    assert (after.output_digest, after.input_digest) == (before.output_digest, before.input_digest)
    assert orient("diff", aerial, "resection", 1, 2).out == "resection versions 1 and 2 hold the same numbers.\n"
    assert "Everything is up to date." in orient("run", aerial).out


def test_the_same_list_is_noticed(aerial: Path) -> None:
    before = count(aerial)
    said = add_control(aerial, [HEADER, *CONTROL])
    assert (said.code, count(aerial)) == (0, before)
    assert "the same as version 1" in said.out
    again = orient("add", aerial, "control", AERIAL / "control.csv", AERIAL / "control.toml", "-m", "again", "--again")
    assert again.code == 0
    assert heads(aerial)["control"].version == 2


def test_undo_and_redo_reuse_the_known_versions(aerial: Path) -> None:
    first = heads(aerial)
    assert add_control(aerial, [HEADER, *CONTROL[:-1]]).code == 0
    assert states(aerial)["bl"] == "stale"
    assert orient("run", aerial).code == 0
    second, stored = heads(aerial), count(aerial)
    assert second["covariance"].version == 2
    for wanted, version in ((first, 1), (second, 2)):
        said = orient("select", aerial, "control", version, "-m", "compare")
        assert f"control: version {version} is current now" in said.out
        assert {"bl", "topocentric", "resection"} <= {
            name for name, state in states(aerial).items() if state == "stale"
        }
        assert orient("run", aerial).code == 0
        assert {name: run.version for name, run in heads(aerial).items()} == {
            name: run.version for name, run in wanted.items()
        }
        assert "stale" not in states(aerial).values()
    assert count(aerial) == stored
    assert check_project(aerial).ok


def test_a_result_can_be_selected_back(aerial: Path) -> None:
    assert orient("resection", aerial, "--control", "fixed", "--variance", "priori").code == 0
    assert states(aerial)["covariance"] == "stale"
    assert orient("select", aerial, "resection", 1, "-m", "as it was").code == 0
    assert "stale" not in states(aerial).values()


def test_diff_names_settings_inputs_and_numbers(aerial: Path) -> None:
    add_control(aerial, [HEADER, *CONTROL[:-1]])
    orient("run", aerial)
    orient("resection", aerial, "--variance", "priori")
    inputs = json.loads(orient("diff", aerial, "resection", 1, 2, "--json").out)
    assert ("inputs", "topocentric") in {(entry["table"], entry["row"]) for entry in inputs}
    (station,) = (entry for entry in inputs if (entry["table"], entry["column"]) == ("orientation", "X_S_m"))
    before, after = (tables(aerial, "resection", version)["orientation"][0]["X_S_m"] for version in (1, 2))
    assert (station["before"], station["after"], station["change"]) == (before, after, after - before)  # type: ignore[operator]
    settings = json.loads(orient("diff", aerial, "resection", 2, 3, "--json").out)
    assert {"table": "settings", "row": "", "column": "variance", "before": "posteriori", "after": "priori",
            "change": None} in settings  # fmt: skip
    last = CONTROL[-1].split(",")[0]
    gone = json.loads(orient("diff", aerial, "control", 1, 2, "--json").out)
    assert ("control_point", last, "present", None) in {
        (entry["table"], entry["row"], entry["before"], entry["after"]) for entry in gone
    }
    assert "version 2" in orient("diff", aerial, "resection", 1, 2).out


def mirrored(lines: list[str]) -> list[str]:
    """X and Y exchanged: a left-handed list that claims to be right-handed."""
    return ["point,role,Y_m,X_m,Z_m", *lines]


def on_a_line(lines: list[str]) -> list[str]:
    points = (line.split(",")[0] for line in lines)
    return [HEADER, *(f"{point},control,{100 * i},{50 * i},1000" for i, point in enumerate(points))]


BAD_CONTROL: dict[str, tuple[Callable[[list[str]], list[str]], str, bool]] = {
    "mirrored": (mirrored, "BELOW_GROUND", True),
    "on a line": (on_a_line, "control points lie on a line", False),
    "two points": (lambda lines: [HEADER, *lines[:2]], "at least 3 are needed", False),
}


@pytest.mark.parametrize("case", BAD_CONTROL)
def test_a_failed_run_is_kept_and_moves_no_head(aerial: Path, case: str) -> None:
    spoil, words, has_iterations = BAD_CONTROL[case]
    before = heads(aerial)["resection"]
    assert add_control(aerial, spoil(CONTROL)).code == 0
    said = orient("run", aerial)
    assert said.code == 1
    assert words in said.err
    assert "Traceback" not in said.err
    assert "covariance   waits for resection" in said.out
    assert heads(aerial)["resection"] == before
    with open_project(aerial) as project:
        failed = project.run("resection", 2)
        stored = project.read_tables(failed.run_id)
        assert project.events(failed.run_id)
    assert (failed.status, "orientation" in stored) == ("failed", False)
    assert bool(stored.get("iteration")) == has_iterations
    assert states(aerial)["resection"] == "failed"
    assert "FAILED, this is not a result: " in orient("show", aerial, "resection", "--version", 2).out
    told = orient("status", aerial)
    assert words in told.out
    remedy = said.err.splitlines()[1].strip()
    assert f"resection: {remedy}" in told.out.splitlines()
    assert f"    -> {remedy}" in orient("show", aerial, "resection", "--version", 2).out.splitlines()
    assert orient("select", aerial, "resection", 2, "-m", "no").code == 2
    assert check_project(aerial).ok


def test_a_failed_stage_alone_says_so_too(aerial: Path) -> None:
    add_control(aerial, mirrored(CONTROL))
    orient("run", aerial)
    said = orient("resection", aerial, "--again")
    assert said.code == 1
    assert "BELOW_GROUND" in said.err
    assert "kept as version 3" in said.err


def test_a_failure_is_forgotten_when_the_inputs_are_the_old_ones(aerial: Path) -> None:
    add_control(aerial, on_a_line(CONTROL))
    orient("run", aerial)
    orient("select", aerial, "control", 1, "-m", "the good one")
    orient("run", aerial)
    assert set(states(aerial).values()) <= {"current", "waiting"}


def test_nobody_goes_on_with_the_old_result_of_an_optional_stage_that_failed(space: Path) -> None:
    crosses = (SPACE / "crosses.csv").read_text("utf-8").splitlines()
    few = space.parent / "crosses.csv"
    few.write_text("\n".join(crosses[:3]) + "\n", "utf-8")
    lists = [few, SPACE / "digitizer.csv", SPACE / "sheet.toml"]
    assert orient("add", space, "sheet", *lists, "-m", "two crosses only").code == 0
    before = heads(space)
    said = orient("run", space)
    assert said.code == 1
    assert "bl           waits for digitize" in said.out
    assert "resection    waits for" in said.out
    assert heads(space)["bl"] == before["bl"]


def test_settings_stick(aerial: Path) -> None:
    orient("resection", aerial, "--control", "fixed", "--max-iterations", 30)
    orient("covariance", aerial, "--pairs")
    add_control(aerial, [HEADER, *CONTROL[:-1]])
    assert orient("run", aerial).code == 0
    now = heads(aerial)
    assert (now["resection"].settings["control"], now["resection"].settings["max_iterations"]) == ("fixed", 30)
    assert now["covariance"].settings["pairs"] is True
    assert orient("resection", aerial, "--control", "auto").code == 0
    assert heads(aerial)["resection"].settings["max_iterations"] == 30


def test_a_stage_does_not_read_stale_inputs(aerial: Path) -> None:
    add_control(aerial, [HEADER, *CONTROL[:-1]])
    said = orient("resection", aerial)
    assert said.code == 1
    assert "resection would read topocentric, which is stale" in said.err
    assert heads(aerial)["resection"].version == 1


def test_a_stage_waits_for_its_inputs(fresh: Path) -> None:
    said = orient("covariance", fresh)
    assert said.code == 1
    assert "covariance waits for refine, topocentric, resection" in said.err
    assert "orient run" in said.err
    assert orient("digitize", fresh).err.splitlines()[0] == "orient: digitize waits for sheet"


def test_a_list_that_was_added_by_mistake_is_taken_back(aerial: Path) -> None:
    before = states(aerial)
    assert orient("add", aerial, "model", MODELS / "model.csv", "-m", "another photo's").code == 0
    assert orient("run", aerial).code == 1
    assert json.loads(orient("status", aerial, "--json").out)["verdict"] == "failed"
    said = orient("select", aerial, "model", "none", "-m", "it belongs to another photo")
    assert said.code == 0
    assert said.out.startswith("model has no current version now. All versions are kept")
    assert states(aerial) == before
    assert orient("run", aerial).out.splitlines()[-1] == "Everything is up to date."
    assert "withdraw" in orient("log", aerial).out
    assert check_project(aerial).ok
    assert orient("select", aerial, "model", 1, "-m", "it was right").code == 0
    assert heads(aerial)["model"].version == 1


def test_what_needs_a_withdrawn_list_has_no_result_and_comes_back_with_it(aerial: Path) -> None:
    before = heads(aerial)
    said = orient("select", aerial, "control", "none", "-m", "points of another survey")
    assert "nor have bl, topocentric, resection, covariance, which need it" in said.out
    assert "orient select PROJECT control 1" in said.out
    assert list(heads(aerial)) == ["photo", "readings", "refine"]
    shown = orient("show", aerial, "resection")
    assert (shown.code, shown.out) == (2, "")
    assert "It was withdrawn. See it: --version 1; have it back: orient select" in shown.err
    assert "sigma0" in orient("show", aerial, "resection", "--version", 1).out
    assert "It failed" not in orient("export", aerial, "opk", "-o", aerial.with_suffix(".csv")).err
    with open_project(aerial) as project, project.snapshot():
        assert list(gather(project).runs) == ["photo", "readings", "refine"]
    waiting = orient("run", aerial)
    assert waiting.code == 0
    assert waiting.out.splitlines()[-1] == "Not oriented yet: bl waits for control or digitize."
    assert orient("select", aerial, "control", 1, "-m", "they were right").code == 0
    assert orient("run", aerial).code == 0
    assert heads(aerial) == before


def test_nothing_is_withdrawn_that_was_changed_meanwhile(aerial: Path) -> None:
    before = heads(aerial)
    with open_project(aerial, "write") as project, pytest.raises(ChangedMeanwhile, match="resection was changed"):
        project.withdraw(["control"], "somebody", "a race", {"control": before["control"].run_id, "resection": None})
    assert heads(aerial) == before


def test_an_optional_list_that_is_withdrawn_makes_stale_what_read_it(tmp_path: Path) -> None:
    path = tmp_path / "photo.sqlite"
    assert orient("new", path, "--from", SPACE).code == 0
    assert orient("run", path).code == 0
    assert {"control", "digitize"} <= set(heads(path)["bl"].inputs)
    assert orient("select", path, "control", "none", "-m", "sheets only").code == 0
    entry = {one["stage"]: one for one in json.loads(orient("status", path, "--json").out)["stages"]}["bl"]
    assert (entry["state"], entry["told"]) == ("stale", "control was withdrawn, version 1 was read")
    assert orient("run", path).code == 0
    assert "control" not in heads(path)["bl"].inputs


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("model", "none"), "model has no current version"),
        (("nothing", "none"), "nothing has no current version"),
        (("resection", "0"), "'0' is no version"),
        (("resection", "None"), "'None' is no version"),
        (("resection", "\u0661"), "is no version"),
        (("resection", "99999999999999999999"), "has no version 99999999999999999999"),
    ],
    ids=lambda words: "-".join(words) if isinstance(words, tuple) else "",
)
def test_select_refuses(aerial: Path, words: tuple[str, str], told: str) -> None:
    before = heads(aerial)
    said = orient("select", aerial, *words, "-m", "because")
    assert said.code == 2
    assert told in said.err
    assert heads(aerial) == before
