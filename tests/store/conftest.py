import shutil
from pathlib import Path

import pytest

from tests.store.made import make_full


@pytest.fixture(scope="session")
def full_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_full(tmp_path_factory.mktemp("full") / "full.sqlite")


@pytest.fixture
def full(full_once: Path, tmp_path: Path) -> Path:
    """A project with one version of every stage; each test has its own copy."""
    return Path(shutil.copy(full_once, tmp_path / "house.orient"))
