from pathlib import Path

import pytest

from tests.faults.conftest import victims
from tests.store.made import make_full

__all__ = ["victims"]


@pytest.fixture(scope="session")
def full_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_full(tmp_path_factory.mktemp("full") / "full.sqlite")
