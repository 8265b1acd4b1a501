import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

import orient
from tests.cli.commands import SAMPLES

ESTIMATED = {"estimate": "f,k1"}
SETTINGS = {
    "calgary-28": {},
    "simulated-space-krasovsky": {},
    "apollo15-metric-0585": {},
    "engabreen": ESTIMATED,
    "strasbourg-sxb-8937": {},
}


def made(folder: Path, sample: str) -> Path:
    """An oriented sample, by the door alone."""
    path = folder / f"{sample}.sqlite"
    photo = orient.new(path, SAMPLES / sample, reason="first")
    if SETTINGS[sample]:
        for stage in ("refine", "bl", "topocentric"):
            photo.run(stage)
        photo.run("resection", **SETTINGS[sample])
    photo.run(reason="first run")
    return path


@pytest.fixture(scope="session", params=SETTINGS)
def sample(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator["orient.Photo"]:
    """Each sample, oriented; only read it."""
    yield orient.open(made(tmp_path_factory.mktemp("door"), request.param))


@pytest.fixture(scope="session")
def calgary_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("calgary"), "calgary-28")


@pytest.fixture
def calgary(calgary_once: Path, tmp_path: Path) -> "orient.Photo":
    """Aerial photo on local ground, with fiducials and pixels; free to change."""
    return orient.open(shutil.copy(calgary_once, tmp_path / "calgary.sqlite"))


@pytest.fixture(scope="session")
def space_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made(tmp_path_factory.mktemp("space"), "simulated-space-krasovsky")


@pytest.fixture
def space(space_once: Path, tmp_path: Path) -> "orient.Photo":
    """Space photo on the Krasovsky ellipsoid, read in mm in cycles; free to change."""
    return orient.open(shutil.copy(space_once, tmp_path / "space.sqlite"))
