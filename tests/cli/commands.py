"""The commands as a user gives them: in this process (fast), or in a process of their own (signals, exit codes)."""

import io
import os
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orient.cli.command_line import command_line
from orient.cli.ending import exit_code

ROOT = Path(__file__).parents[2]
SAMPLES = ROOT / "sample_projects"
SPACE = SAMPLES / "simulated-space-krasovsky"
MODEL = SAMPLES / "simulated-model-two-zones"
AERIAL = SAMPLES / "calgary-28"
ENTRY = "from orient.cli.main import run; run()"


@dataclass(frozen=True)
class Said:
    """What a command left behind: exit code and text."""

    code: int
    out: str
    err: str


def orient(*words: object) -> Said:
    """The command through the same door as the program's, without a new process."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", newline="") for _ in range(2))
    with redirect_stdout(out), redirect_stderr(err):
        code = exit_code(lambda: command_line()([str(word) for word in words], prog_name="orient"))
    return Said(code, _text(out), _text(err))


def _text(stream: io.TextIOWrapper) -> str:
    stream.flush()
    return stream.buffer.getvalue().decode("utf-8")  # type: ignore[attr-defined]


def start(*words: object, env: dict[str, str] | None = None, **options: Any) -> "subprocess.Popen[bytes]":
    """The command as a process, from the checkout."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **(env or {})}
    command = [sys.executable, "-c", ENTRY, *(os.fsencode(str(word)) for word in words)]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, **options
    )


def orient_process(*words: object, env: dict[str, str] | None = None, **options: Any) -> Said:
    child = start(*words, env=env, **options)
    out, err = child.communicate(timeout=60)
    return Said(child.returncode, out.decode("utf-8", "replace"), err.decode("utf-8", "replace"))


def in_process(code: str, *words: object) -> "subprocess.CompletedProcess[str]":
    """Python code of its own, with the words of a command."""
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, words)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def without(package: str, *words: object) -> "subprocess.CompletedProcess[str]":
    """The command where an optional package is not installed."""
    return in_process(f"import sys; sys.modules[{package!r}] = None; {ENTRY}", *words)
