"""What each command may load from other packages, in its own process: start-up is the largest part of a command."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from orient.cli.command_line import GROUPS, command_line

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "sample_projects" / "calgary-28"
CODE = """
import atexit, json, sys
atexit.register(lambda: print(json.dumps(sorted(sys.modules)), file=sys.stderr))
sys.argv = {words!r}
from orient.cli.main import run
run()
"""
HELP = {"orient", "typer", "annotated_doc", "shellingham", "click", "typing_extensions"}
READ = HELP | {"sqlalchemy", "rich", "pygments", "greenlet"}
STORE = READ | {"numpy"}
COMPUTE = STORE | {"scipy"}  # the sample has local ground: no datum, no PROJ
NAMES = " ".join(GROUPS.values()).split()

NAMED_SHELL = "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION"
"""The shell is named, not looked for among the parents: `make` starts its commands by sh."""

ALLOWED = {
    "status P": READ,
    "log P": READ,
    "check P": READ,
    "sql P --list": HELP | {"rich"},
    "sql P suspects": READ,
    "show P photo": READ,
    "show P resection": READ,
    "diff P resection 1 1": READ,
    "backup P K": READ,
    "receive P K": READ,
    "new K --from S": STORE,
    "select P control 1 -m again": STORE,
    "run P": STORE,  # nothing is stale: nothing is computed
    "refine P --again": COMPUTE,
    "bl P --again": STORE,
    "topocentric P --again": STORE,
    "covariance P --again": COMPUTE,
    "resection P --again": COMPUTE,
}


def loaded(*words: str) -> set[str]:
    """Packages of others that the command has loaded."""
    done = subprocess.run(
        [sys.executable, "-c", CODE.format(words=["orient", *words])],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, NAMED_SHELL: "1"},
    )
    assert done.returncode == 0, done.stderr[:2000]
    tops = {name.split(".")[0] for name in json.loads(done.stderr.splitlines()[-1])}
    return {top for top in tops - set(sys.stdlib_module_names) if not top.startswith("_") and "cython" not in top}


OWN = {
    "status P": ("orient.cli.plan", "orient.pipeline.runner", "orient.intake"),
    "resection P --again": ("orient.cli.plan", "orient.intake", "orient.pipeline.digitize", "orient.pipeline.absolute"),
}


@pytest.mark.parametrize("line", OWN)
def test_a_command_leaves_its_neighbours_alone(line: str, project: Path) -> None:
    code = CODE.format(words=["orient", *line.replace("P", str(project), 1).split()])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr[:2000]
    assert not {*OWN[line], "scipy.linalg"} & set(json.loads(done.stderr.splitlines()[-1]))


@pytest.mark.parametrize("group", GROUPS)
def test_each_module_registers_the_commands_that_are_looked_for_in_it(group: str) -> None:
    commands = command_line([group]).registered_commands
    assert [command.callback.__name__ for command in commands if command.callback] == GROUPS[group].split()


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("imports") / "p.sqlite"
    entry = [sys.executable, "-c", "from orient.cli.main import run; run()"]
    for words in (["new", str(path), "--from", str(SAMPLE)], ["run", str(path)]):
        subprocess.run([*entry, *words], check=True, capture_output=True, cwd=ROOT)
    return path


@pytest.mark.parametrize(
    "words", [["--help"], ["--version"], ["--show-completion", "bash"], *([name, "--help"] for name in NAMES)]
)
def test_help_loads_typer_and_nothing_else(words: list[str]) -> None:
    assert loaded(*words) <= HELP


@pytest.mark.parametrize("line", ALLOWED)
def test_a_command_loads_only_what_it_uses(line: str, project: Path, tmp_path: Path) -> None:
    places = {"P": str(project), "K": str(tmp_path / "k.sqlite"), "S": str(SAMPLE)}
    assert loaded(*(places.get(word, word) for word in line.split())) <= ALLOWED[line]
