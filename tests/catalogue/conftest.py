from pathlib import Path

import pytest

from tests.catalogue.case import Place
from tests.store.made import make_full


@pytest.fixture(scope="session")
def full_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_full(tmp_path_factory.mktemp("full") / "full.sqlite")


@pytest.fixture
def place(tmp_path: Path, full_once: Path) -> Place:
    return Place(tmp_path, full_once)
