"""The shell is asked as a shell asks: bash for real, zsh and fish by their protocol."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from orient.export import FORMATS
from orient.pipeline.registry import ALL_STAGES, INPUT_STAGES
from orient.report.plots import PLOTS
from orient.report.questions import QUESTIONS
from tests.cli.commands import ENTRY, ROOT

ASKED = {
    "commands": ("orient ex", ["export", "explain"]),
    "options": ("orient resection p.sqlite --eng", ["--engine"]),
    "words of an option": ("orient resection p.sqlite --engine ", ["zlatanov", "qr"]),
    "stages": ("orient show p.sqlite ", [*ALL_STAGES, "verify"]),
    "stages of diff": ("orient diff p.sqlite re", ["readings", "refine", "resection"]),
    "lists": ("orient add p.sqlite ", list(INPUT_STAGES)),
    "questions": ("orient sql p.sqlite ", [question.name for question in QUESTIONS]),
    "plots": ("orient plot p.sqlite ", [plot.name for plot in PLOTS]),
    "formats": ("orient export p.sqlite ", [form.name for form in FORMATS]),
    "one format": ("orient export p.sqlite op", ["opencv", "opk"]),
    "explain": ("orient explain p.sqlite ", ["resection"]),
    "files are left to the shell": ("orient show ", []),
}


def ask(shell: str, **variables: str) -> "subprocess.CompletedProcess[str]":
    env = {**os.environ, "PYTHONPATH": str(ROOT), "_ORIENT_COMPLETE": f"complete_{shell}", **variables}
    command = [sys.executable, "-c", f"import sys; sys.argv[0] = 'orient'; {ENTRY}"]
    return subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize(("line", "wanted"), ASKED.values(), ids=ASKED)
def test_bash(line: str, wanted: list[str]) -> None:
    place = len(line.split()) - (0 if line.endswith(" ") else 1)
    said = ask("bash", COMP_WORDS=line, COMP_CWORD=str(place))
    assert (said.returncode, said.stderr) == (0, "")
    assert said.stdout.split() == wanted


@pytest.mark.parametrize(("line", "wanted"), ASKED.values(), ids=ASKED)
def test_zsh(line: str, wanted: list[str]) -> None:
    """Names with what they are; without any the shell offers files."""
    said = ask("zsh", _TYPER_COMPLETE_ARGS=line)
    assert said.returncode == 0
    if not wanted:
        assert said.stdout.strip() == "_files"
        return
    for name in wanted:
        assert f'"{name}"' in said.stdout


@pytest.mark.parametrize(("line", "wanted"), ASKED.values(), ids=ASKED)
def test_fish(line: str, wanted: list[str]) -> None:
    asked = ask("fish", _TYPER_COMPLETE_ARGS=line, _TYPER_COMPLETE_FISH_ACTION="is-args")
    assert asked.returncode == (0 if wanted else 1)
    said = ask("fish", _TYPER_COMPLETE_ARGS=line, _TYPER_COMPLETE_FISH_ACTION="get-args")
    assert [row.split("\t")[0] for row in said.stdout.splitlines() if row] == wanted


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_a_real_bash_after_tab(tmp_path: Path) -> None:
    """The script of `--show-completion`, loaded by bash, fills COMPREPLY as after a press of Tab."""
    program = tmp_path / "orient"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -c "import sys; sys.argv[0] = \'orient\'; {ENTRY}" "$@"\n')
    program.chmod(0o755)
    script = (
        'eval "$(_ORIENT_COMPLETE=source_bash orient)"; complete -p orient;'
        'COMP_WORDS=(orient export p.sqlite g); COMP_CWORD=3; _orient_completion orient; echo "${COMPREPLY[@]}"'
    )
    env = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    said = subprocess.run(
        ["bash", "--norc", "-c", script], env=env, capture_output=True, text=True, timeout=60, check=False
    )
    assert said.stdout.splitlines() == ["complete -o default -F _orient_completion orient", "geojson gpkg"]


def test_completion_loads_neither_numpy_nor_the_database() -> None:
    """It must come at once: a Tab is pressed more often than a command is given."""
    heavy = "{'numpy', 'scipy', 'sqlalchemy', 'pyproj', 'matplotlib'}"
    told = f"atexit.register(lambda: print(*sorted({heavy} & set(sys.modules)), file=sys.stderr))"
    code = f"import sys, atexit; sys.argv[0] = 'orient'; {told}; {ENTRY}"
    for line in (
        "orient sql p.sqlite a",
        "orient plot p.sqlite a",
        "orient export p.sqlite g",
        "orient show p.sqlite r",
    ):
        env = {
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "_ORIENT_COMPLETE": "complete_bash",
            "COMP_WORDS": line,
            "COMP_CWORD": "3",
        }
        said = subprocess.run(
            [sys.executable, "-c", code], env=env, capture_output=True, text=True, timeout=60, check=False
        )
        assert said.stdout.strip()
        assert said.stderr.strip() == ""
