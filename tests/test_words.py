"""Numbers with their nouns, and names as a shell takes them."""

import shlex
import subprocess
from pathlib import Path

import pytest

from orient.words import counted, typed


def test_one_and_many() -> None:
    assert [counted(n, "point") for n in (0, 1, 2)] == ["0 points", "1 point", "2 points"]
    assert [counted(n, "cross", "crosses") for n in (1, 2)] == ["1 cross", "2 crosses"]


@pytest.mark.parametrize("name", ["photo.sqlite", "my photo.sqlite", "it's.sqlite", "$HOME.sqlite", "/a b/-c.sqlite"])
def test_a_shell_reads_the_name_back(name: str) -> None:
    said = subprocess.run(["sh", "-c", f"printf %s {typed(Path(name))}"], capture_output=True, text=True, check=True)
    assert said.stdout == name


def test_a_leading_dash_is_no_option() -> None:
    assert shlex.split(typed("-dash one.sqlite")) == ["./-dash one.sqlite"]
