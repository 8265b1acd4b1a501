"""A command in a real terminal (a pseudo-terminal of the system), or before a stream that says it is one."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

from orient.cli.command_line import command_line
from orient.cli.ending import exit_code
from tests.cli.commands import ENTRY, ROOT

ESCAPE = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]|\x1b\][^\x07]*\x07")
AGAIN = re.compile(r"\r(?!\n)|\x1b\[2K|\x1b\[1A")


def in_terminal(*words: object, columns: int, env: dict[str, str] | None = None) -> tuple[int, str]:
    """Exit code and raw output of the command in a pseudo-terminal of `columns`."""
    master, slave = pty.openpty()
    fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    environment = {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "LINES", "NO_COLOR")}
    environment |= {"PYTHONPATH": str(ROOT), "TERM": "xterm", **(env or {})}
    command = [sys.executable, "-c", ENTRY, *map(str, words)]
    child = subprocess.Popen(command, stdin=slave, stdout=slave, stderr=slave, env=environment, close_fds=True)
    os.close(slave)
    output = b""
    while True:
        try:
            piece = os.read(master, 65536)
        except OSError:  # the other end is closed
            break
        if not piece:
            break
        output += piece
    os.close(master)
    return child.wait(timeout=60), output.decode("utf-8", "replace")


def plain(raw: str) -> str:
    """What was written, line by line, without the codes of the terminal; a line that is written again is a new one."""
    return ESCAPE.sub("", AGAIN.sub("\n", raw)).replace("\r\n", "\n")


class Screen(io.TextIOWrapper):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def on_screen(*words: object) -> tuple[int, str]:
    """Exit code and output of the command in this process; the width is that of COLUMNS."""
    out = Screen(io.BytesIO(), "utf-8", newline="")
    err = io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = exit_code(lambda: command_line()([str(word) for word in words], prog_name="orient"))
    out.flush()
    return code, plain(out.buffer.getvalue().decode("utf-8"))  # type: ignore[attr-defined]


def too_wide(text: str, columns: int, path: Path) -> list[str]:
    """Lines beyond the terminal, but those of one word that cannot be broken (a path, a command)."""
    lines = plain(text).split("\n")
    return [line for line in lines if len(line) > columns and str(path) not in line and len(line.split()) > 1]
