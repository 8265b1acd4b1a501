"""How a command ends: an error or a signal becomes one sentence and an exit code."""

import errno
import os
import re
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

from orient.errors import OrientError

OUR_FAULT = 70


class _Stopped(BaseException):
    """A signal asked the command to end."""


STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_stopped_by: list[int] = []


def listen() -> None:
    """From now on a signal ends the command in order."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `orient show ... | head` ends quietly, as other programs do
    for number in STOP_SIGNALS:
        signal.signal(number, _stop)
    sys.unraisablehook = _unraised


def _unraised(told: "sys.UnraisableHookArgs") -> None:
    """A stop that arrived where nothing can be raised (Python clears up): the command is stopped at its next step."""
    if not isinstance(told.exc_value, _Stopped):
        sys.__unraisablehook__(told)


def _stop(number: int, frame: FrameType | None) -> None:
    no_more_signals()  # a second Ctrl-C must not disturb the tidying
    _stopped_by.append(number)
    if "logging" in sys.modules:  # SQLAlchemy would log that its connection closes by an exception
        sys.modules["logging"].disable(sys.modules["logging"].CRITICAL)
    if watch := sys.modules.get("orient.store.watch"):
        watch.STOP.set()
    raise _Stopped


def no_more_signals() -> None:
    """Not SIG_IGN: Python would complain about a second signal that has arrived and is not yet handled."""
    for number in STOP_SIGNALS:
        signal.signal(number, lambda number, frame: None)


def exit_code(command: Callable[[], object]) -> int:
    """Run the command; 0, or what its error means, said on standard error. From its end on no signal is heard."""
    try:
        code = _code_of(command)
        no_more_signals()
    except _Stopped:
        code = _say_stopped()
    return code


def _code_of(command: Callable[[], object]) -> int:
    try:
        command()
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
    _say("stopped; no step is stored by half: orient log PROJECT tells what is stored")
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
