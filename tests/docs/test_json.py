"""docs/json.md and what the commands say: no key without a line there, no line without a key."""

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from orient.cli.command_line import command_line
from tests.cli.commands import ROOT, SAMPLES, orient

PAGE = (ROOT / "docs" / "json.md").read_text("utf-8")
CAMERA = ["--f-mm", "200", "--frame-mm", "180", "180", "--sigma-um", "5"]
PLAN = ["plan", *CAMERA, "--height-m", "250000", "--layout", "grid:3x3", "--json"]
COMMANDS = {
    "status": [["status", "P", "--json"]],
    "log": [["log", "P", "--json"]],
    "show": [["show", "P", "resection", "--json"], ["show", "P", "control", "--json"]],
    "diff": [["diff", "P", "resection", "1", "2", "--json"]],
    "sql": [["sql", "P", "residuals", "--json"], ["sql", "P", "--list", "--json"]],
    "explain": [["explain", "P", "--json"]],
    "verify": [["verify", "P", "--json"]],
    "plan": [PLAN],
    "seal": [["seal", "P", "-o", "SEALED", "--json"]],
    "batch": [["batch", "FOLDER", "--workers", "1", "--json"], ["batch", "FOLDER", "--dry-run", "--json"]],
}


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two versions, a verification, findings."""
    path = tmp_path_factory.mktemp("json") / "p.sqlite"
    assert orient("new", path, "--from", SAMPLES / "calgary-28").code == 0
    assert orient("run", path).code == 0
    assert orient("resection", path, "--reject").code == 0
    assert orient("verify", path).code == 0
    assert orient("new", path.with_name("map.sqlite"), "--from", SAMPLES / "n37-map-graticule").code == 0
    return path


def documented() -> dict[str, list[str]]:
    """Keys of each command, as its table lists them."""
    sections = re.split(r"^## orient ", PAGE, flags=re.MULTILINE)[1:]
    return {part.split()[0]: re.findall(r"^\| `([^`]+)` \|", part, re.MULTILINE) for part in sections}


def paths(value: object, at: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from paths(inner, f"{at}.{key}" if at else key)
        if not value:
            yield at
    elif isinstance(value, list):
        for inner in value:
            yield from paths(inner, f"{at}[]")
        if not value:
            yield f"{at}[]"
    else:
        yield at


def covers(key: str, path: str) -> bool:
    """A path ends in [] where a list is empty."""
    return path == key or path.startswith((f"{key}.", f"{key}[")) or (path.endswith("[]") and key.startswith(path))


def said(words: list[str], project: Path) -> set[str]:
    places = {"P": project, "SEALED": project.with_name("sealed.orient"), "FOLDER": project.parent}
    answer = orient(*(places.get(word, word) for word in words))
    return set(paths(json.loads(answer.out, parse_constant=pytest.fail)))


@pytest.mark.parametrize("command", COMMANDS)
def test_every_key_is_documented_and_there(command: str, project: Path) -> None:
    keys = documented()[command]
    assert len(keys) == len(set(keys))
    found = set().union(*(said(words, project) for words in COMMANDS[command]))
    assert [path for path in sorted(found) if not any(covers(key, path) for key in keys)] == []
    assert [key for key in keys if not any(covers(key, path) for path in found)] == []


def test_every_command_with_json_has_a_section() -> None:
    from typer.main import get_command

    group = get_command(command_line())
    named = {
        name
        for name, command in group.commands.items()  # type: ignore[attr-defined]
        if any("--json" in parameter.opts for parameter in command.params)
    }
    assert named == set(documented()) == set(COMMANDS)


def test_all_digits(project: Path) -> None:
    """A number of the document is the number of the file, to the last bit."""
    shown = json.loads(orient("show", project, "resection", "--version", "1", "--json").out)
    asked = json.loads(orient("sql", project, "SELECT * FROM orientation ORDER BY run_id", "--json").out)[0]
    row = shown["tables"]["orientation"][0]
    assert {key: asked[key] for key in row} == row
