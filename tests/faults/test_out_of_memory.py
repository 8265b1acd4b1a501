"""Too little memory, at any moment of a command: one sentence with a size, exit code 1, nothing half-written (F17).

The limit (RLIMIT_AS) lies a few megabytes above what the process has when the command begins, so that it is met while
the project is loaded, while a stage computes, or while its rows are written.
"""

import re
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_opk
from tests.cli.commands import orient
from tests.cli.made_photo import SIGMA_MM, STATION, MadePhoto
from tests.faults.operations import COPY, PROJECT, Operation
from tests.faults.oracle import Clean, judge, undisturbed
from tests.faults.victims import Ended, Fault, Victims
from tests.promises import Promise

POINTS = 600
SIZE = re.compile(r"\d MB\b")
OPERATIONS = {
    operation.name: operation
    for operation in (
        Operation("new", "folder", lambda folder: ("new", folder / COPY, "--from", folder / "in"), COPY),
        Operation("run", "fresh", lambda folder: ("run", folder / PROJECT)),
        Operation("resection", "done", lambda folder: ("resection", folder / PROJECT, "--again")),
        Operation("covariance", "done", lambda folder: ("covariance", folder / PROJECT, "--again")),
        Operation("verify", "done", lambda folder: ("verify", folder / PROJECT)),
        Operation("check", "done", lambda folder: ("check", folder / PROJECT)),
        Operation("backup", "done", lambda folder: ("backup", folder / PROJECT, folder / COPY), COPY),
    )
}


def many_points(folder: Path) -> Path:
    """A made photo with so many control points that even checking it needs memory."""
    chance = np.random.default_rng(POINTS)
    ground = chance.uniform((0.0, 0.0, 90.0), (800.0, 600.0, 240.0), (POINTS, 3))
    photo = MadePhoto()
    image, _ = project(ground, STATION, matrix_from_opk(*photo.angles).T, photo.f_mm)
    image = image + SIGMA_MM * chance.normal(size=image.shape)
    lists = {"readings.csv": ("point,x_mm,y_mm", image), "control.csv": ("point,X_m,Y_m,Z_m", ground)}
    files = {name: _csv(head, rows) for name, (head, rows) in lists.items()}
    return replace(photo, files=files).write(folder)


def _csv(head: str, rows: "np.ndarray[tuple[int, int], np.dtype[np.float64]]") -> str:
    return "\n".join([head, *(f"P{n}," + ",".join(repr(float(v)) for v in row) for n, row in enumerate(rows)), ""])


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Templates like those of operations.py, with so many points."""
    folder = tmp_path_factory.mktemp("large")
    for name in ("folder", "fresh", "done"):
        (folder / name).mkdir()
    many_points(folder / "folder" / "in")
    assert orient("new", folder / "fresh" / PROJECT, "--from", folder / "folder" / "in").code == 0
    (folder / "done" / PROJECT).write_bytes((folder / "fresh" / PROJECT).read_bytes())
    assert orient("run", folder / "done" / PROJECT).code == 0
    return folder


def starve(clean: Clean, limits_mb: list[float], folder: Path, victims: Victims, promise: Promise) -> int:
    """The command under each limit; how often there was too little."""
    kept, starved = promise("F17"), 0
    for limit_mb in limits_mb:
        clean.scene(folder)
        ended = victims.run(*clean.words(folder), fault=Fault(more_memory=int(limit_mb * 2**20)))
        starved += ended.code != 0
        if ended.code == -signal.SIGSEGV:  # a library died of an allocation that it did not look at: as good as a kill
            kept.largest("1: a library crashed", 1.0)
            ended = Ended(-signal.SIGKILL, "", "", ended.seconds)
        with kept.trial(f"{clean.operation} with {limit_mb} MB"):
            assert ended.code in (0, 1, -signal.SIGKILL), ended
            said = ended.err[ended.err.find("orient: ") :]  # a library may have said something before
            if ended.code == 1:
                assert said.startswith("orient: not enough memory for") and SIZE.search(said), ended.err
                assert len(said.splitlines()) == 2, said
            judge(clean, folder, replace(ended, err=said if ended.code == 1 else ""), victims)
    return starved


def test_run_with_little_memory(large: Path, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    run = undisturbed(OPERATIONS["run"], large, tmp_path / "clean", victims, tmp_path / "log")
    assert starve(run, [0.0, 2.0, 5.0, 7.0], tmp_path / "scene", victims, promise) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("name", OPERATIONS)
def test_little_memory(name: str, large: Path, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    one = undisturbed(OPERATIONS[name], large, tmp_path / "clean", victims, tmp_path / "log")
    limits_mb = [step / 4 for step in range(4 * 12)] if name == "run" else [step / 2 for step in range(2 * 8)]
    assert starve(one, limits_mb, tmp_path / "scene", victims, promise) > 0
