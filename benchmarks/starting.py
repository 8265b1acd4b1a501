"""Whole commands as processes, against the bare import of the libraries they load and against plainer programs."""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache, partial
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
PLAIN_RESECTION = """
import argparse, sqlite3
import numpy as np
parser = argparse.ArgumentParser()
parser.add_argument('project')
parser.add_argument('result')
names = parser.parse_args()
source, target = sqlite3.connect(names.project), sqlite3.connect(names.result)
query = 'SELECT x_mm / f_mm, y_mm / f_mm, X_m, Y_m, Z_m FROM photo, image_point JOIN topocentric_point USING (point)'
given = np.array(source.execute(query).fetchall())
image, ground = given[:, :2], given[:, 2:]
z, g = image @ [1, 1j], ground @ [1, 1j, 0]  # a vertical photo
a = np.vdot(g - g.mean(), z - z.mean()) / np.vdot(g - g.mean(), g - g.mean())
plan, turn = g.mean() - z.mean() / a, a / abs(a)
M = np.array([[turn.real, -turn.imag, 0], [turn.imag, turn.real, 0], [0, 0, 1]])
S = np.array([plan.real, plan.imag, ground[:, 2].mean() + 1 / abs(a)])
target.execute('CREATE TABLE iteration (number INTEGER PRIMARY KEY, X, Y, Z, vv, step)')
for number in range(1, 8):
    X, Y, Z = M @ (ground - S).T
    u, v, w, zero = X / Z, Y / Z, 1 / Z, 0 * Z
    rows = [[u * v, -1 - u * u, v, -w, zero, u * w], [1 + v * v, -u * v, -u, zero, -w, v * w]]
    A, l = np.concatenate([np.transpose(row) for row in rows]), np.concatenate([image[:, 0] + u, image[:, 1] + v])
    Q = np.linalg.inv(A.T @ A)
    step = Q @ A.T @ l
    c = np.cross(np.eye(3), step[:3] / 2)
    E = np.linalg.solve(np.eye(3) - c, np.eye(3) + c)
    S = S - (E @ M).T @ step[3:]
    M = E @ M
    target.execute('INSERT INTO iteration VALUES (?, ?, ?, ?, ?, ?)', (number, *S, l @ l, abs(step[:3]).max()))
target.commit()
print(M, S, np.sqrt(np.diag(Q) * (l @ l) / (l.size - 6)))
"""
TESTS = """
from scipy.special import chdtrc, chdtri, nctdtrinc, stdtr, stdtrit
r = l.size - 6
v = l - A @ step
share = 1 - np.einsum('ij,jk,ik->i', A, Q, A)
tau = abs(v) / np.sqrt(l @ l / r * share)
t = stdtrit(r - 1, 1 - 0.001 / 2)
print(share, tau, t * np.sqrt(r / (r - 1 + t * t)), nctdtrinc(r - 1, 0.2, t))
print(2 * stdtr(r - 1, -tau * np.sqrt((r - 1) / (r - tau**2))), chdtri(r, [0.025, 0.975]), chdtrc(r, l @ l))
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
    yield _resection(folder, fresh)


def _resection(folder: Path, fresh: Path) -> Task:
    """The points are read, the photo is resected, iterations and result are stored and printed."""
    refined = folder / "refined.sqlite"
    refined.write_bytes(fresh.read_bytes())
    for stage in ("refine", "bl", "topocentric"):
        _orient(stage, str(refined))()
    numbers = count()

    def own() -> None:
        path = folder / f"resection-{next(numbers)}.sqlite"
        path.write_bytes(refined.read_bytes())
        _orient("resection", str(path))()

    def plain(program: str) -> None:
        result = folder / f"plain-{next(numbers)}.sqlite"
        _python(f"import sys; sys.argv = ['plain', {str(refined)!r}, {str(result)!r}]\n{program}")()

    note = (
        "the plain program knows that the photo is nearly vertical; orient tests the observations too, as the last one"
    )
    candidates = {
        "orient": own,
        "argparse + sqlite3 + numpy": partial(plain, PLAIN_RESECTION),
        "the same with tests by scipy.special": partial(plain, PLAIN_RESECTION + TESTS),
    }
    return Task("orient resection", candidates, 4.0, None, note=note, clock=WALL)


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
