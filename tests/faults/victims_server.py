"""Starts commands by forking a process that has everything imported: a fault then hits the work, not the imports.

Reads one JSON object per line: {"start": words, ...Fault} answers the process number, {"wait": number} the exit code.
`python -m tests.faults.victims_server FOLDER`, with the library of fault_library.c preloaded where it could be built.
"""

import ctypes
import gc
import importlib
import json
import os
import pkgutil
import resource
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.faults.privilege import without_privilege

DEPTH = 10_000


def serve() -> None:
    import_everything()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a stop before the command listens ends it as it ends any process
    gc.collect()
    gc.freeze()
    print("ready", flush=True)
    for line in sys.stdin:
        asked = json.loads(line)
        if number := asked.get("wait"):
            _, status = os.waitpid(number, 0)
            print(os.waitstatus_to_exitcode(status), flush=True)
        elif child := os.fork():
            print(child, flush=True)
        else:
            become(asked)


def import_everything() -> None:
    """All modules of orient, and by one run of the commands what they import while they work."""
    import orient

    for module in pkgutil.walk_packages(orient.__path__, "orient."):
        if "_migrations" not in module.name:
            _import(module.name)
    from tests.cli.commands import SPACE
    from tests.cli.commands import orient as command

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "warm.sqlite"
        for words in (("new", path, "--from", SPACE), ("run", path), ("check", path), ("verify", path)):
            assert command(*words).code == 0, words


def _import(name: str) -> None:
    """A module that needs an optional package which is not installed is passed over."""
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if str(error.name).startswith("orient"):
            raise


def become(asked: dict[str, Any]) -> None:
    """This process is now the command, with its fault."""
    os.setpgid(0, 0)
    for number, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(asked[name], os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o600), number)
    sys.argv = ["orient", *asked["start"]]
    for name, value in asked.items():
        if value is not None and name in SETTINGS:
            SETTINGS[name](value)
    if asked.get("folder"):
        log = (asked["log"] or "").encode()
        arm = ctypes.CDLL(None).fault_arm
        arm(asked["folder"].encode(), ctypes.c_long(asked["at"]), asked["error"], asked["forever"], log)
    end_with()


def end_with() -> None:
    """The command, and the end of the process without taking down the modules of the server."""
    from orient.cli.main import run

    code = 0
    try:
        run()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def set_synchronous(value: str) -> None:
    from orient.store import connection

    connection.PRAGMAS = tuple(
        f"synchronous={value}" if pragma.startswith("synchronous=") else pragma for pragma in connection.PRAGMAS
    )


def limit_pages(count: int) -> None:
    from orient.store import connection

    connection.PRAGMAS = (*connection.PRAGMAS, f"max_page_count={count}")


def set_patience(seconds: list[float]) -> None:
    """SQLite's busy timeout, and how long a commit is repeated."""
    from orient.store import connection, project

    connection.BUSY_TIMEOUT_S, project.COMMIT_PATIENCE_S = seconds


def grow_stack() -> None:
    """Nested calls in C, some megabytes of them; what a stack has once been given stays."""
    usual = sys.getrecursionlimit()
    sys.setrecursionlimit(DEPTH + usual)
    json.loads("[" * DEPTH + "]" * DEPTH)
    sys.setrecursionlimit(usual)


def limit_memory(more_bytes: int) -> None:
    """What the server has freed is given back first: the command could live on it. The stack is as large as it becomes:
    no program survives a stack that cannot grow."""
    grow_stack()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    size = pages * resource.getpagesize() + more_bytes
    resource.setrlimit(resource.RLIMIT_AS, (size, size))


def limit_file_size(size: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def before_computing(what: list[str]) -> None:
    """["fail"]: computing is a mistake; ["replace", other, path]; ["delete", path]; ["copy", path, other]."""
    from orient.pipeline import runner

    compute = runner.outcome_of

    def instead(*arguments: Any) -> Any:
        kind, *paths = what
        if kind == "fail":
            raise AssertionError("computed")
        if kind == "replace":
            os.replace(*paths)  # noqa: PTH105
        if kind == "copy":
            shutil.copy(*paths)
        if kind == "delete" and os.path.lexists(paths[0]):
            os.unlink(paths[0])  # noqa: PTH108
        return compute(*arguments)

    runner.outcome_of = instead


def watch_own_opens(path: str) -> None:
    """Every open() of the project from Python while SQLite has it open goes to standard error."""

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open" and isinstance(arguments[0], str | bytes | os.PathLike) and _is(arguments[0], path):
            held = [name for name in os.listdir("/proc/self/fd") if _is(f"/proc/self/fd/{name}", path)]  # noqa: PTH208
            if held:
                os.write(2, b"OPENED WHILE CONNECTED\n")

    sys.addaudithook(hook)


def _is(name: Any, path: str) -> bool:
    try:
        return os.path.samefile(name, path)  # noqa: PTH121
    except OSError:
        return False


SETTINGS: dict[str, Callable[[Any], None]] = {
    "synchronous": set_synchronous,
    "patience_s": set_patience,
    "before_computing": before_computing,
    "watched": watch_own_opens,
    "umask": os.umask,
    "clock_s": lambda seconds: ctypes.CDLL(None).fault_clock(ctypes.c_long(seconds)),
    "unprivileged": lambda _: without_privilege(),
    "file_size": limit_file_size,
    "max_pages": limit_pages,
    "more_memory": limit_memory,
}

if __name__ == "__main__":
    serve()
