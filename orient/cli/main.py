"""The way in: signals are heard before the commands and what they need are loaded."""

import gc
import os
import sys

from orient.cli.ending import exit_code, listen

COMPLETING, ONE_LINE = "_ORIENT_COMPLETE", "10000"


def run() -> None:
    """Entry point: run the command, end with the exit code of what happened."""
    code = exit_code(_command)
    gc.freeze()  # or the interpreter looks through all that was loaded once more before it ends
    sys.exit(code)


def _command() -> None:
    listen()
    from orient.cli.command_line import called

    if sys.stdout is None:  # closed by the caller: `orient run P >&-`
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  (for the life of the process)
    if COMPLETING in os.environ:
        os.environ["TERMINAL_WIDTH"] = ONE_LINE  # a name offered to the shell and what it means are one line
    called(sys.argv[1:2])()
