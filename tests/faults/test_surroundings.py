"""Read-only places, replaced files, our own open(), locale, rights mask, missing folders, a clock that goes back."""

import re
import shutil
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.commands import orient_process
from tests.faults.operations import BY_NAME, PROJECT, QUICK, Operation, each
from tests.faults.oracle import Clean, judge, recovered, state_of
from tests.faults.privilege import modes_bind as modes_bind
from tests.faults.victims import Fault, Victims
from tests.promises import Promise

CleanOf = Callable[[str], Clean]
NOT_COMPUTING = ("new", "add", "select", "verify", "check", "upgrade", "backup", "receive", "seal")
READING = (
    ("status",), ("show", "resection"), ("sql", "residuals"), ("log",), ("check",), ("diff", "resection", "1", "1"),
    ("verify", "--no-record"),
)  # fmt: skip

# ------------------------------------------------------------------------------------------ read-only


def closed(folder: Path, what: str) -> Path:
    """Read-only: the folder with all in it, or only the project."""
    for path in folder.iterdir():
        path.chmod(0o444)
    folder.chmod(0o555 if what == "folder" else 0o755)
    return folder


@pytest.mark.usefixtures("modes_bind")
@pytest.mark.parametrize("words", READING, ids=lambda words: words[0])
def test_a_read_only_project_can_be_read(
    words: tuple[str, ...], clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    folder = closed(clean("check").scene(tmp_path / "scene"), "folder")
    command, *rest = words
    with promise("F15").trial(command):
        said = victims.run(command, folder / PROJECT, *rest, fault=Fault(unprivileged=True))
        assert (said.code, said.err) == (0, "")
        assert said.out
    folder.chmod(0o755)


@pytest.mark.usefixtures("modes_bind")
@pytest.mark.parametrize("what", ["folder", "file"])
@pytest.mark.parametrize("operation", each(quick=QUICK | {"new", "receive", "add", "upgrade"}))
def test_a_read_only_project_is_not_written(
    operation: Operation, what: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """Said before any computing: a stage that is computed fails this test."""
    if what == "file" and (operation.makes_a_file or operation.name == "check"):
        pytest.skip("it does not write into the file that it reads")
    one, kept = clean(operation.name), promise("F15")
    folder = closed(one.scene(tmp_path / "scene"), what)
    fault = Fault(unprivileged=True, before_computing=("fail",) if operation.name != "verify" else None)
    said = victims.run(*one.words(folder), fault=fault)
    folder.chmod(0o755)
    with kept.trial(f"{operation}, read-only {what}"):
        if operation.name == "check":
            assert said.code == 0
        else:
            assert said.code == 3, said
            assert "cannot be written" in said.err and len(said.err.splitlines()) <= 2, said.err
        kept.largest("s until refused", said.seconds)
        assert state_of(folder / operation.writes) == one.old
        assert {path.name for path in folder.iterdir()} == {path.name for path in one.template.iterdir()}


# ------------------------------------------------------------------------------------------ replaced, deleted, opened


@pytest.mark.parametrize("operation", each(*NOT_COMPUTING, quick=frozenset({"bl"})))
@pytest.mark.parametrize("how", ["replace", "delete"])
def test_replaced_or_deleted_while_it_computes(
    operation: Operation, how: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    one = clean(operation.name)
    folder = one.scene(tmp_path / "scene")
    path, other = folder / PROJECT, tmp_path / "other.sqlite"
    shutil.copy(path, other)
    before = other.read_bytes()
    asked = ("replace", str(other), str(path)) if how == "replace" else ("delete", str(path))
    said = victims.run(*one.words(folder), fault=Fault(before_computing=asked))
    with promise("V7").trial(f"{operation}, {how}"):
        assert said.code == 3 and "was replaced or removed" in said.err, said
        assert len(said.err.splitlines()) <= 2
        assert not path.exists() if how == "delete" else path.read_bytes() == before
        assert {file.name for file in folder.iterdir()} <= {PROJECT}


@pytest.mark.parametrize("operation", each())
def test_no_operation_opens_a_project_that_it_is_connected_to(
    operation: Operation, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """Closing it would drop SQLite's lock (RELIABILITY.md P1)."""
    one = clean(operation.name)
    folder = one.scene(tmp_path / "scene")
    with promise("F6").trial(str(operation)):
        said = victims.run(*one.words(folder), fault=Fault(watched=str(folder / PROJECT)))
        assert (said.code, said.err) == (0, "")


def test_the_watch_sees_an_open(clean: CleanOf, victims: Victims, tmp_path: Path) -> None:
    """Without this, a watch that sees nothing would pass: a copy in the middle of a command opens the project."""
    one = clean("bl")
    folder = one.scene(tmp_path / "scene")
    fault = Fault(watched=str(folder / PROJECT), before_computing=("copy", str(folder / PROJECT), str(folder / "x")))
    assert "OPENED WHILE CONNECTED" in victims.run(*one.words(folder), fault=fault).err


@pytest.mark.parametrize("operation", each())
def test_a_wrong_name_makes_no_file(
    operation: Operation, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """A typing error in the name of the project, or of the folder, is wrong use and makes nothing."""
    one = clean(operation.name)
    folder = one.scene(tmp_path / "scene")
    words = [
        Path(f"{word}x") if isinstance(word, Path) and (word.exists() or word.name == PROJECT) else word
        for word in one.words(folder)
    ]
    before = {path.name for path in folder.iterdir()}
    with promise("F16").trial(str(operation)):
        said = victims.run(*words)
        assert said.code in (1, 2) and "Traceback" not in said.err, said
        assert {path.name for path in folder.iterdir()} == before


# ------------------------------------------------------------------------------------------ rights of new files


@pytest.mark.parametrize("mask", [0o000, 0o077, pytest.param(0o022, marks=pytest.mark.slow)], ids=oct)
@pytest.mark.parametrize("name", ["new", "backup", "receive", "upgrade"])
def test_rights_of_new_files(
    name: str, mask: int, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """A new project is private; a backup and an upgraded file have the rights of the source, less the mask."""
    one = clean(name)
    folder = one.scene(tmp_path / "scene")
    source = 0o640
    if (folder / PROJECT).exists():
        (folder / PROJECT).chmod(source)
    with promise("F14").trial(f"{name}, umask {mask:03o}"):
        assert victims.run(*one.words(folder), fault=Fault(umask=mask)).code == 0
        expected = 0o600 if name in ("new", "receive") else source & ~mask
        assert stat.S_IMODE((folder / one.operation.writes).stat().st_mode) == expected & ~mask
        assert all(not stat.S_IMODE(path.stat().st_mode) & ~source for path in folder.iterdir())


# ------------------------------------------------------------------------------------------ environment, clock

NOWHERE = "/nonexistent/folder"
ENVIRONMENTS: dict[str, dict[str, str]] = {
    "C": {"LC_ALL": "C", "LANG": "C"},
    "Turkish": {"LC_ALL": "tr_TR.UTF-8"},
    "German": {"LC_ALL": "de_DE.UTF-8"},
    "no temporary folder": {"TMPDIR": NOWHERE, "SQLITE_TMPDIR": NOWHERE},
    "no home": {"HOME": "", "XDG_CACHE_HOME": "", "USER": "", "LOGNAME": ""},
    "home nowhere, no terminal": {"HOME": NOWHERE, "TERM": "", "COLUMNS": "0"},
    "strict Python": {"PYTHONWARNINGS": "error::UserWarning", "PYTHONOPTIMIZE": "2"},
}
"""A locale that is not installed behaves as C; the test holds in both cases."""
OFTEN = ("C", "no home")


def in_environment(operation: Operation, name: str, clean: CleanOf, folder: Path, promise: Promise) -> None:
    one = clean(operation.name)
    one.scene(folder)
    with promise("F18").trial(f"{operation}, {name}"):
        said = orient_process(*one.words(folder), env=ENVIRONMENTS[name])
        assert (said.code, said.err) == (0, ""), said
        assert recovered(folder / operation.writes) == one.new
        assert {path.name for path in folder.iterdir()} == one.names


@pytest.mark.parametrize("name", OFTEN)
def test_run_in_other_surroundings(name: str, clean: CleanOf, tmp_path: Path, promise: Promise) -> None:
    in_environment(BY_NAME["run"], name, clean, tmp_path / "scene", promise)


@pytest.mark.slow
@pytest.mark.parametrize("name", ENVIRONMENTS)
@pytest.mark.parametrize("operation", each())
def test_other_surroundings(operation: Operation, name: str, clean: CleanOf, tmp_path: Path, promise: Promise) -> None:
    in_environment(operation, name, clean, tmp_path / "scene", promise)


DAY_S = 86_400
CLOCKS_S = {"a day back": -DAY_S, "1970": -56 * 365 * DAY_S, "2100": 74 * 365 * DAY_S}


@pytest.mark.usefixtures("preloaded")
@pytest.mark.parametrize("clock", CLOCKS_S)
@pytest.mark.parametrize("operation", each(quick=frozenset({"select"})))
def test_a_wrong_clock(
    operation: Operation, clock: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """Order is that of the numbers, never of the times; what was computed is the same."""
    one = clean(operation.name)
    folder = one.scene(tmp_path / "scene")
    with promise("F18").trial(f"{operation}, {clock}"):
        said = victims.run(*one.words(folder), fault=Fault(clock_s=CLOCKS_S[clock]))
        assert (said.code, said.err) == (0, "")
        assert recovered(folder / operation.writes) == one.new
        judge(one, folder, said, victims)


def test_commands_ask_the_preloaded_clock(victims: Victims, clean: CleanOf, tmp_path: Path, preloaded: None) -> None:
    folder = clean("select").scene(tmp_path / "scene")
    fault = Fault(clock_s=CLOCKS_S["2100"])
    victims.run(*clean("select").words(folder), fault=fault)
    assert re.search(r"^ *2(099|100)-", victims.run("log", folder / PROJECT).out, re.MULTILINE)
