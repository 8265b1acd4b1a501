import shutil
from pathlib import Path

import pytest

from tests.cli.commands import AERIAL, MODEL, SPACE, orient


def _made(folder: Path, path: Path) -> Path:
    assert orient("new", path, "--from", folder, "-m", "first").code == 0
    return path


@pytest.fixture(scope="session")
def space_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = _made(SPACE, tmp_path_factory.mktemp("space") / "photo.sqlite")
    assert orient("run", path, "-m", "first run").code == 0
    assert orient("covariance", path, "--pairs", "-m", "with pairs").code == 0
    return path


@pytest.fixture(scope="session")
def aerial_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = _made(AERIAL, tmp_path_factory.mktemp("aerial") / "photo.sqlite")
    assert orient("run", path).code == 0
    return path


@pytest.fixture(scope="session")
def fresh_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _made(AERIAL, tmp_path_factory.mktemp("fresh") / "photo.sqlite")


@pytest.fixture(scope="session")
def model_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = _made(MODEL, tmp_path_factory.mktemp("model") / "photo.sqlite")
    assert orient("run", path).code == 0
    return path


@pytest.fixture
def model(model_once: Path, tmp_path: Path) -> Path:
    """A model in two zones, oriented; without any photo reading."""
    return Path(shutil.copy(model_once, tmp_path / "model.sqlite"))


@pytest.fixture
def space(space_once: Path, tmp_path: Path) -> Path:
    """All stages of the simulated space photo: sheet, cycles, check points, pairs."""
    return Path(shutil.copy(space_once, tmp_path / "photo.sqlite"))


@pytest.fixture
def aerial(aerial_once: Path, tmp_path: Path) -> Path:
    """A small aerial photo with local control, oriented."""
    return Path(shutil.copy(aerial_once, tmp_path / "photo.sqlite"))


@pytest.fixture
def fresh(fresh_once: Path, tmp_path: Path) -> Path:
    """The small aerial photo before its first run."""
    return Path(shutil.copy(fresh_once, tmp_path / "photo.sqlite"))
