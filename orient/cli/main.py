"""The command `orient`: the list of commands, and the one place where an error becomes a sentence and an exit code."""

import errno
import os
import re
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

import typer
from typer.models import CommandInfo

from orient.cli import (
    audit,
    batch,
    explain,
    export,
    inputs,
    ledger,
    plan,
    plot,
    questions,
    report,
    seal,
    stages,
    verify,
)
from orient.errors import OrientError

OUR_FAULT = 70
COMPLETING, ONE_LINE = "_ORIENT_COMPLETE", "10000"
APP_HELP = """Orient one frame photograph from measured image points and a map, and keep the whole proof in one file.

A project is one SQLite file per photo. Start with:

\b
    orient new photo.sqlite --from FOLDER
    orient run photo.sqlite
    orient show photo.sqlite resection

Exit codes: 0 done, 1 the data or the geometry says no, 2 wrong use, 3 the project file, 70 our own fault.
"""

app = typer.Typer(
    name="orient",
    help=APP_HELP,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _show_version(value: bool) -> None:
    if value:
        from orient import __version__

        typer.echo(f"orient {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(False, "--version", callback=_show_version, is_eager=True, help="Print the version."),
) -> None:
    """Options of orient itself."""


for group in (inputs, stages, batch, ledger, verify, seal, questions, audit, plan, plot, report, export, explain):
    group.register(app)


class _Stopped(BaseException):
    """A signal asked the command to end."""


STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_stopped_by: list[int] = []


def _stop(number: int, frame: FrameType | None) -> None:
    _no_more_signals()  # a second Ctrl-C must not disturb the tidying
    _stopped_by.append(number)
    if "logging" in sys.modules:  # SQLAlchemy would log that its connection closes by an exception
        sys.modules["logging"].disable(sys.modules["logging"].CRITICAL)
    if watch := sys.modules.get("orient.store.watch"):
        watch.STOP.set()
    raise _Stopped


def _no_more_signals() -> None:
    """Not SIG_IGN: Python would complain about a second signal that has arrived and is not yet handled."""
    for number in STOP_SIGNALS:
        signal.signal(number, lambda number, frame: None)


def run() -> None:
    """Entry point: run the command, end with the exit code of what happened."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `orient show ... | head` ends quietly, as other programs do
    for number in STOP_SIGNALS:
        signal.signal(number, _stop)
    if sys.stdout is None:  # closed by the caller: `orient run P >&-`
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  (for the life of the process)
    if COMPLETING in os.environ:
        os.environ["TERMINAL_WIDTH"] = ONE_LINE  # a name offered to the shell and what it means are one line
    everything = app.registered_commands
    app.registered_commands = _named(everything, sys.argv[1:]) or everything
    code = _exit_code(app)
    app.registered_commands = everything
    _no_more_signals()
    sys.exit(code)


def _named(commands: list[CommandInfo], words: list[str]) -> list[CommandInfo]:
    """The command that the first word names: typer would build all of them, with all their options."""
    return [command for command in commands if command.callback and [command.callback.__name__] == words[:1]]


def _exit_code(command: Callable[[], object]) -> int:
    try:
        command()
    except _Stopped:
        return _say_stopped()
    except OrientError as error:
        if _stopped_by:
            return _say_stopped()
        _say(error.message, error.hint)
        return error.exit_code
    except BrokenPipeError:
        # the reader of our output went away; that is no error
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EIO):
            return _our_fault(error)
        _say(f"the output cannot be written: {error.strerror}", "Give it another place.")
        return 1
    except MemoryError as error:
        return _say_no_memory(error)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except Exception as error:
        # a library may have turned the stop into an error of its own
        return _say_stopped() if _stopped_by else _our_fault(error)
    return 0


def _say_no_memory(error: MemoryError) -> int:
    """With sizes: what was in use, and what more was asked for, which numpy says."""
    sizes = []
    with suppress(ImportError):  # Windows
        import resource

        sizes = [f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB in use"]
    if found := re.search(r"allocate ([\d.]+) (\w+)", str(error)):
        sizes.append(f"{float(found[1]):g} {found[2]} more asked for")
    told = f" ({', '.join(sizes)})" if sizes else ""
    _say(f"not enough memory for this project{told}", "Give fewer points, or a machine with more memory.")
    return 1


def _say_stopped() -> int:
    _say("stopped; nothing was stored by the interrupted step")
    return 128 + _stopped_by[0]


def _our_fault(error: Exception) -> int:
    if os.environ.get("ORIENT_TRACEBACK"):
        raise error
    _say(
        f"this is a fault of orient itself: {type(error).__name__}: {error}",
        "Nothing was stored. Please report it with the output of: ORIENT_TRACEBACK=1 orient ...",
    )
    return OUR_FAULT


def _say(message: str, hint: str = "") -> None:
    from orient.report.text import printable

    print(printable(f"orient: {message}"), file=sys.stderr)
    if hint:
        print(printable(f"        {hint}"), file=sys.stderr)
