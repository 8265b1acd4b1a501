"""What is disturbed: one row per operation. Adding an operation to all fault loops is adding a row."""

import gzip
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from _pytest.mark import ParameterSet

from tests.cli.commands import AERIAL, MODEL, ROOT, orient

Words = Callable[[Path], tuple[object, ...]]

PROJECT, COPY, OLD = "photo.sqlite", "copy.sqlite", ROOT / "tests" / "data" / "format-2" / "calgary-28.sqlite.gz"
LISTS = (AERIAL / "control.csv", AERIAL / "control.toml")


@dataclass(frozen=True)
class Operation:
    """A command in a folder that is copied from `template`; `writes` is the file that it changes or makes."""

    name: str
    template: str
    words: Words
    writes: str = PROJECT

    @property
    def makes_a_file(self) -> bool:
        """True if the file must not exist before: asked a second time, the command says that it exists."""
        return self.writes == COPY

    def __str__(self) -> str:
        return self.name


def _again(stage: str, template: str = "done") -> Operation:
    return Operation(stage, template, lambda folder: (stage, folder / PROJECT, "--again"))


OPERATIONS = (
    Operation("new", "empty", lambda folder: ("new", folder / COPY, "--from", AERIAL), COPY),
    Operation("add", "done", lambda folder: ("add", folder / PROJECT, "control", *LISTS, "-m", "again", "--again")),
    Operation("run", "fresh", lambda folder: ("run", folder / PROJECT)),
    _again("refine"),
    _again("bl"),
    _again("topocentric"),
    _again("resection"),
    _again("covariance"),
    _again("absolute", "model"),
    Operation("select", "done", lambda folder: ("select", folder / PROJECT, "photo", 1, "-m", "the same")),
    Operation("verify", "done", lambda folder: ("verify", folder / PROJECT)),
    Operation("check", "done", lambda folder: ("check", folder / PROJECT)),
    Operation("upgrade", "old", lambda folder: ("upgrade", folder / PROJECT)),
    Operation("backup", "done", lambda folder: ("backup", folder / PROJECT, folder / COPY), COPY),
    Operation("receive", "done", lambda folder: ("receive", folder / PROJECT, folder / COPY), COPY),
    Operation("seal", "done", lambda folder: ("seal", folder / PROJECT, "-o", folder / COPY), COPY),
)
QUICK = frozenset({"run", "select", "backup"})
"""Those that the quick tests try; the others are tried by the slow ones too."""
BY_NAME = {operation.name: operation for operation in OPERATIONS}


def each(*but: str, quick: frozenset[str] = QUICK) -> list[ParameterSet]:
    """All operations `but` some as parameters of a test; those that are not quick carry the mark `slow`."""
    return [
        pytest.param(operation, id=operation.name, marks=[] if operation.name in quick else pytest.mark.slow)
        for operation in OPERATIONS
        if operation.name not in but
    ]


def make_templates(folder: Path) -> Path:
    """The folders in which operations start: empty, fresh, done, model, old."""
    for name in ("empty", "fresh", "done", "model", "old"):
        (folder / name).mkdir()
    said = [orient("new", folder / "fresh" / PROJECT, "--from", AERIAL)]
    shutil.copy(folder / "fresh" / PROJECT, folder / "done" / PROJECT)
    said += [orient("run", folder / "done" / PROJECT)]
    said += [orient("new", folder / "model" / PROJECT, "--from", MODEL), orient("run", folder / "model" / PROJECT)]
    assert [done.code for done in said] == [0, 0, 0, 0]
    (folder / "old" / PROJECT).write_bytes(gzip.decompress(OLD.read_bytes()))
    return folder
