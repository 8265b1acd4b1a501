"""RELIABILITY.md 7 E: what a command line can bring, and the exit codes of the program itself."""

import os
import pty
import subprocess
import sys
import termios
from pathlib import Path

import pytest

from orient.cli.ending import exit_code
from orient.errors import GeometryError, InputError, OrientError, Problem, ProjectError, UsageError
from tests.cli.commands import AERIAL, ENTRY, ROOT, orient, orient_process

PROJECT = "PROJECT"
"""Stands for the path of a project in a table."""


@pytest.mark.parametrize("name", [":memory:", "file:x?mode=memory", "a b#c%d.sqlite", "-x", "\udcff.sqlite", "Köln"])
def test_any_file_name_works(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert orient("new", "--from", AERIAL, "--", name).code == 0
    assert [os.fsdecode(file) for file in os.listdir(tmp_path)] == [name]  # noqa: PTH208
    assert orient("status", "--", name).code == 0
    assert orient("status", "--json", "--", name).code == 0


@pytest.mark.parametrize("words", [["show", PROJECT, "resection"], ["--help"], ["sql", PROJECT, "residuals", "--csv"]])
def test_e15_reader_that_goes_away(words: list[str], aerial: Path) -> None:
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-c", ENTRY, *(str(aerial) if word == PROJECT else word for word in words)]
    ended = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=write, stderr=subprocess.PIPE, check=False
    )
    os.close(write)
    assert ended.returncode in (0, -13)
    assert ended.stderr == b""


BARE = {"PATH": os.environ.get("PATH", ""), "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def test_e16_no_home_no_term_c_locale(aerial: Path) -> None:
    command = [sys.executable, "-c", ENTRY, "show", str(aerial), "resection"]
    ended = subprocess.run(command, env={**BARE, "PYTHONPATH": str(ROOT)}, capture_output=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, b"")
    assert ended.stdout.isascii()
    assert b"Exterior orientation" in ended.stdout


def test_e16_terminal_of_width_zero(aerial: Path) -> None:
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (0, 0))
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "0", "TERM": "dumb"}
    child = subprocess.Popen(
        [sys.executable, "-c", ENTRY, "status", str(aerial)], env=environment, stdout=theirs, stderr=theirs
    )
    os.close(theirs)
    shown = b""
    try:
        while chunk := os.read(ours, 4096):
            shown += chunk
    except OSError:  # the terminal is closed
        pass
    os.close(ours)
    assert child.wait(30) == 0
    assert b"resection" in shown


@pytest.mark.parametrize("variables", [{"PYTHONWARNINGS": "error"}, {"PYTHONOPTIMIZE": "2"}], ids=str)
def test_e18_interpreter_options_change_nothing(variables: dict[str, str], aerial: Path) -> None:
    said = orient_process("resection", aerial, "--again", env=variables)
    assert (said.code, said.err) == (0, "")
    assert "hold the same numbers" in orient("diff", aerial, "resection", 1, 2).out


def test_e19_an_existing_name_is_not_touched(aerial: Path) -> None:
    before = aerial.read_bytes()
    said = orient("new", aerial, "--from", AERIAL)
    assert said.code == 2
    assert said.err.startswith(f"orient: {aerial} exists.")
    assert aerial.read_bytes() == before


ERRORS = {
    "data": (OrientError("no"), 1),
    "geometry": (GeometryError("no"), 1),
    "files": (InputError([Problem("a.csv", 3, "no")]), 1),
    "usage": (UsageError("no"), 2),
    "project": (ProjectError("no"), 3),
    "memory": (MemoryError(), 1),
    "our fault": (ZeroDivisionError("no"), 70),
    "exit": (SystemExit(5), 5),
}


@pytest.mark.parametrize("case", ERRORS)
def test_exit_codes(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    error, code = ERRORS[case]

    def command() -> None:
        raise error

    assert exit_code(command) == code
    shown = capsys.readouterr().err
    assert "Traceback" not in shown
    assert case == "exit" or shown.startswith("orient: ")


def test_our_fault_shows_its_traceback_when_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ORIENT_TRACEBACK", "1")
    with pytest.raises(ZeroDivisionError):
        exit_code(lambda: print(1 // 0))


PROCESSES = {
    "done": (("status", PROJECT), 0),
    "data": (("covariance", "FRESH"), 1),
    "usage": (("show", PROJECT, "resect"), 2),
    "project": (("status", AERIAL / "photo.toml"), 3),
}


@pytest.mark.parametrize("case", PROCESSES)
def test_exit_codes_of_the_process(case: str, aerial: Path, fresh_once: Path) -> None:
    words, code = PROCESSES[case]
    paths = {PROJECT: aerial, "FRESH": fresh_once}
    said = orient_process(*(paths.get(word, word) if isinstance(word, str) else word for word in words))
    assert said.code == code
    assert (said.err == "") == (code == 0)


IMPORTS = {
    "--help": ("--help", "numpy scipy pyproj sqlalchemy sqlite3 alembic rich orient.models"),
    "--version": ("--version", "numpy scipy pyproj sqlalchemy sqlite3 alembic rich orient.models"),
    "status": ("status PROJECT", "numpy scipy pyproj alembic orient.models"),
    "log": ("log PROJECT", "numpy scipy pyproj alembic orient.models"),
    "sql": ("sql PROJECT residuals", "numpy scipy pyproj alembic orient.models"),
    "show": ("show PROJECT resection", "numpy scipy pyproj alembic orient.models"),
    "batch, dry": ("batch PROJECT --dry-run", "numpy scipy pyproj alembic orient.models dask distributed"),
    "unchanged stage": ("resection PROJECT", "numpy scipy pyproj alembic orient.models"),
}


@pytest.mark.parametrize("case", IMPORTS)
def test_what_a_command_does_not_import(case: str, aerial: Path) -> None:
    line, modules = IMPORTS[case]
    words = [str(aerial) if word == PROJECT else word for word in line.split()]
    code = (
        "import sys\nfrom orient.cli.ending import exit_code\nfrom orient.cli.command_line import command_line\n"
        f"code = exit_code(lambda: command_line()({words!r}))\n"
        f"print('LOADED', *(name for name in {modules.split()!r} if name in sys.modules))\nsys.exit(code)"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, check=False
    )
    assert (ended.returncode, ended.stderr) == (0, b"")
    assert ended.stdout.splitlines()[-1] == b"LOADED"
