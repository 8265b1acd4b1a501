"""Every command once, on a small sample: exit code, what it says, what it stores."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from orient.cli.command_line import command_line
from orient.pipeline.registry import ALL_STAGES, STAGES
from orient.store.project import open_project
from tests.cli.commands import AERIAL, orient, orient_process
from tests.faults.privilege import like_anybody
from tests.faults.privilege import modes_bind as modes_bind

COMMANDS = tuple(
    command.name or command.callback.__name__  # type: ignore[union-attr]
    for command in command_line().registered_commands
)


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help(command: str) -> None:
    said = orient(*([command] if command else []), "--help")
    assert (said.code, said.err) == (0, "")
    assert said.out.startswith("Usage: orient")


def test_no_command_is_help() -> None:
    said = orient()
    assert said.code == 2
    assert "Usage: orient" in said.out + said.err


def test_version() -> None:
    from orient import __version__

    assert orient("--version").out == f"orient {__version__}\n"


def test_new_says_what_was_read(tmp_path: Path) -> None:
    said = orient("new", tmp_path / "p.sqlite", "--from", AERIAL)
    assert (said.code, said.err) == (0, "")
    for words in ("p.sqlite made.", "calgary-28, aerial, f 153.358 mm", "8 control points", "Next: orient run"):
        assert words in said.out
    assert (tmp_path / "p.sqlite").stat().st_mode & 0o077 == 0


def test_run_says_each_stage(fresh: Path) -> None:
    said = orient("run", fresh, "-m", "the first one")
    assert (said.code, said.err) == (0, "")
    lines = [line.split()[0] for line in said.out.splitlines() if not line.startswith(" ")]
    assert lines == ["refine", "bl", "topocentric", "resection", "covariance"]
    with open_project(fresh) as project:
        assert {run.reason for name, run in project.heads().items() if name != "photo"} >= {"the first one"}


OF_A_MODEL = ("model", "absolute")


@pytest.fixture
def project_of(space: Path, model: Path) -> Callable[[str], Path]:
    """The project that has the stage."""
    return lambda stage: model if stage in OF_A_MODEL else space


@pytest.mark.parametrize("stage", [stage.name for stage in STAGES])
def test_each_stage_is_a_command(project_of: Callable[[str], Path], stage: str) -> None:
    path = project_of(stage)
    said = orient(stage, path)
    assert (said.code, said.err) == (0, "")
    assert "(unchanged)" in said.out
    assert f"See: orient show {path} {stage}" in said.out


@pytest.mark.parametrize("stage", ALL_STAGES)
def test_show_of_each_stage(project_of: Callable[[str], Path], stage: str) -> None:
    said = orient("show", project_of(stage), stage)
    assert (said.code, said.err) == (0, "")
    assert said.out.startswith(f"{stage} version ")


def test_show_of_a_resection_opens_with_the_findings(space: Path) -> None:
    lines = orient("show", space, "resection").out.splitlines()
    assert lines[0].startswith("resection version 1, ")
    assert lines[1].strip().startswith("sigma0 3.99 um")
    # no error was planted in P05: of 145 tests at 0.1 % one cries without cause, and it says so itself
    assert "strong correlations" in lines[2]
    (doubt,) = (line for line in lines if "is suspected of a gross error" in line)
    assert doubt.strip().startswith("note: P05 (|tau| 3.2 of image y exceeds 3.15)")
    assert "with so many tests a good photo shows one in" in doubt
    text = "\n".join(lines)
    for words in ("redundancy r = 44", "station: B ", "X_S m", "alpha deg", "Check points", "Iterations", "sum v^2/25"):
        assert words in text


def test_status_of_a_fresh_project(fresh: Path) -> None:
    said = orient("status", fresh)
    states = {line.split()[0]: line.split()[2] for line in said.out.splitlines() if line.split()[1:2] in (["1"], ["-"])}
    assert states["photo"] == states["readings"] == states["control"] == "current"
    assert states["resection"] == "waiting"
    assert "Next: orient run" in said.out


def test_status_of_a_finished_project(aerial: Path) -> None:
    said = orient("status", aerial)
    assert said.code == 0
    assert "stale" not in said.out
    assert "Next" not in said.out


def test_log_tells_who_and_why(aerial: Path) -> None:
    said = orient("log", aerial)
    assert said.code == 0
    for words in ("actor", "reason", "first", "resection"):
        assert words in said.out


def test_log_shows_a_selection_but_not_that_of_the_run_itself(aerial: Path) -> None:
    assert " select " not in orient("log", aerial).out
    orient("select", aerial, "resection", "1", "-m", "looked again")
    (line,) = (line for line in orient("log", aerial).out.splitlines() if " select " in line)
    assert "looked again" in line


def test_check_accepts_and_upgrade_has_nothing_to_do(aerial: Path) -> None:
    assert "is sound" in orient("check", aerial).out
    assert "nothing to do" in orient("upgrade", aerial).out
    assert [file.name for file in aerial.parent.iterdir()] == [aerial.name]


def test_sql_lists_its_questions(aerial: Path) -> None:
    assert "error-budget" in orient("sql", aerial, "--list").out
    assert orient("sql", aerial).out == orient("sql", aerial, "--list").out


STATUS_KEYS = ["stage", "version", "state", "told", "remedy"]
LOG_KEYS = ["at", "actor", "action", "stage", "version", "status", "reason", "summary"]
RUN_KEYS = [
    "run_id", "stage", "version", "stage_version", "settings", "input_digest", "output_digest", "status", "summary",
    "error", "actor", "reason", "started_at", "tool_version", "inputs",
]  # fmt: skip
EVENT_KEYS = ["severity", "code", "subject", "message", "value"]
DIFF_KEYS = ["table", "row", "column", "before", "after", "change"]


def test_keys_of_json_are_stable(space: Path) -> None:
    orient("refine", space, "--reject")
    status = json.loads(orient("status", space, "--json").out)
    assert list(status) == ["project", "verdict", "sentence", "findings", "stages", "verification"]
    assert all(list(entry) == STATUS_KEYS for entry in status["stages"])
    assert all(list(entry) == LOG_KEYS for entry in json.loads(orient("log", space, "--json").out))
    shown = json.loads(orient("show", space, "refine", "--json").out)
    assert list(shown) == ["run", "events", "tables", "verification", "later_failures", "stale"]
    assert list(shown["run"]) == RUN_KEYS
    assert all(list(event) == EVENT_KEYS for event in shown["events"])
    found = json.loads(orient("diff", space, "refine", 1, 2, "--json").out)
    assert found
    assert all(list(entry) == DIFF_KEYS for entry in found)


@pytest.mark.parametrize("stage", ALL_STAGES)
def test_json_holds_every_digit(project_of: Callable[[str], Path], stage: str) -> None:
    shown = json.loads(orient("show", project_of(stage), stage, "--json").out)
    with open_project(project_of(stage)) as project:
        run = project.heads()[stage]
        assert shown["tables"] == project.read_tables(run.run_id)
        assert shown["run"]["output_digest"] == run.output_digest


TYPED = {"my photo.sqlite": "'my photo.sqlite'", "-dash.sqlite": "./-dash.sqlite"}


@pytest.mark.parametrize("name", TYPED)
def test_what_is_to_be_typed_next_can_be_typed(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert orient("new", "--from", AERIAL, "--", name).out.endswith(f"Next: orient run {TYPED[name]}\n")
    assert orient("status", "--", name).out.endswith(f"Next: orient run {TYPED[name]}\n")
    assert orient("show", "--", name).err.endswith(f"Run: orient run {TYPED[name]}\n")
    (tmp_path / name).unlink()
    assert orient("show", "--", name).err.endswith(f"Create one with: orient new {TYPED[name]} --from FOLDER\n")


FOLDERS = {
    "new": lambda project: ("new", "sub/", "--from", AERIAL),
    "backup": lambda project: ("backup", project, "sub/"),
    "receive": lambda project: ("receive", project, "sub/"),
}


@pytest.mark.parametrize("command", FOLDERS)
def test_the_name_of_a_folder_is_no_name_of_a_file(
    command: str, fresh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    said = orient(*FOLDERS[command](fresh))
    assert (said.code, said.err.splitlines()[0]) == (2, "orient: sub/ is the name of a folder")
    assert not (tmp_path / "sub").exists()


@pytest.mark.parametrize("words", [("new", "a.sqlite", "--from", AERIAL), ("check", "a.sqlite")], ids=["new", "check"])
def test_a_current_folder_that_is_gone(
    words: tuple[object, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    said = orient(*words)
    assert (said.code, "there is no current folder any more" in said.err) == (2, True)


CLOSED = {
    "new": (lambda here: ("new", here / "b.sqlite", "--from", here / "closed/f"), 2, "f: permission denied"),
    "check": (lambda here: ("check", here / "closed/p.sqlite"), 3, "Ask for the right to read it"),
    "batch": (lambda here: ("batch", here / "closed/f"), 2, "cannot be read: Permission denied"),
    "seal": (
        lambda here: ("seal", here / "photo.sqlite", "-o", here / "s.sqlite", "--image", here / "closed/i.png"),
        2,
        "permission denied",
    ),
}


@pytest.mark.usefixtures("modes_bind")
@pytest.mark.parametrize("command", CLOSED)
def test_a_folder_that_may_not_be_searched(command: str, aerial: Path, tmp_path: Path) -> None:
    words, code, told = CLOSED[command]
    (tmp_path / "closed").mkdir(0o000)
    said = orient_process(*words(tmp_path), preexec_fn=like_anybody)
    assert said.code == code
    assert told in said.err
    assert "Restore a backup" not in said.err


def test_check_tells_the_remedy_of_what_it_found(tmp_path: Path) -> None:
    said = orient("check", tmp_path)
    assert said.code == 3
    assert said.err.splitlines()[1:] == ["        Give the name of a project file."]


def test_one_run_is_told_as_one(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    shutil.copy(AERIAL / "photo.toml", tmp_path / "in")
    assert orient("new", tmp_path / "p.sqlite", "--from", tmp_path / "in").code == 0
    assert "1 run, all sealed" in orient("check", tmp_path / "p.sqlite").out
    assert "backup, 1 run, every digest verified" in orient("backup", tmp_path / "p.sqlite", tmp_path / "b.sqlite").out
