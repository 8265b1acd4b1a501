"""Whole commands as processes, against the bare import of the libraries they load and against plainer programs."""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from itertools import count
from pathlib import Path

from benchmarks.measuring import WALL, Task

ROOT = Path(__file__).parents[1]
SAMPLE = ROOT / "sample_projects" / "calgary-28"
ENTRY = "from orient.cli.main import run; run()"
LOADED = """
import atexit, json, sys
atexit.register(lambda: print(json.dumps(list(sys.modules)), file=sys.stderr))
"""
CLICK = """
import click
@click.group()
def orient(): 'Orient one photo.'
@orient.command()
def run(): 'Compute.'
orient(['--help'])
"""

PLAIN = """
import argparse, sqlite3, numpy
parser = argparse.ArgumentParser()
parser.add_argument('project')
connection = sqlite3.connect(parser.parse_args().project)
print(numpy.array(connection.execute('SELECT x_mm, y_mm FROM comparator_reading').fetchall(), dtype=float))
"""
NOTE = "in processes of their own; against the bare import of the packages that the command loads, and beside it a \
command of argparse, sqlite3 and numpy that only reads and prints the readings"


def tasks() -> Iterator[Task]:
    folder = Path(tempfile.mkdtemp(prefix="orient-bench-"))
    project = folder / "status.sqlite"
    _orient("new", str(project), "--from", str(SAMPLE))()
    fresh = folder / "fresh.sqlite"
    fresh.write_bytes(project.read_bytes())
    numbers = count()

    def run_new() -> None:
        path = folder / f"run-{next(numbers)}.sqlite"
        path.write_bytes(fresh.read_bytes())
        _orient("run", str(path))()

    own = _orient("--help")
    yield Task("orient --help", {"orient": own, "click --help": _python(CLICK)}, 3.0, None, clock=WALL)
    yield Task(
        "orient --version", {"orient": _orient("--version"), "click --help": _python(CLICK)}, None, None, clock=WALL
    )
    plain = _python(f"import sys; sys.argv = ['plain', {str(project)!r}]\n{PLAIN}")
    status = _orient("status", str(project))
    libraries = _imports(["status", str(project)])
    bases = {"orient": status, "its packages, imported": libraries, "argparse + sqlite3 + numpy": plain}
    yield Task("orient status", bases, 1.3, None, note=NOTE, clock=WALL)
    warm = folder / "warm.sqlite"
    warm.write_bytes(fresh.read_bytes())
    libraries = _imports(["run", str(warm)])
    bases = {"orient": run_new, "its packages, imported": libraries, "argparse + sqlite3 + numpy": plain}
    yield Task("orient run", bases, 1.6, None, note=f"{NOTE}; a photo of 21 points, five stages", clock=WALL)


@cache
def environment() -> dict[str, str]:
    """Modules of this checkout and of all packages are compiled at the first call, as installing them does."""
    compiled = tempfile.mkdtemp(prefix="orient-bench-")
    given = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return {**given, "PYTHONPATH": str(ROOT), "PYTHONPYCACHEPREFIX": compiled}


def _python(code: str) -> Callable[[], None]:
    def run() -> None:
        subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL, env=environment())

    return run


def _orient(*words: str) -> Callable[[], None]:
    return _python(f"import sys; sys.argv = {['orient', *words]!r}; {ENTRY}")


def _imports(words: list[str]) -> Callable[[], None]:
    """A process that imports what the command imports from other packages, and does nothing."""
    code = LOADED + f"sys.argv = {['orient', *words]!r}\n{ENTRY}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment(), check=True)
    names = [name for name in json.loads(done.stderr.splitlines()[-1]) if _is_foreign(name)]
    return _python("import importlib\nfor name in " + repr(names) + ":\n    importlib.import_module(name)")


def _is_foreign(name: str) -> bool:
    top = name.split(".")[0]
    is_own = top in ("orient", "__main__") or top in sys.stdlib_module_names or top.startswith(("_", "__"))
    return not is_own and "cython" not in top and not name.endswith("__mp_main__")
