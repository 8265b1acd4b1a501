"""Templates, the server of victims and what each operation does undisturbed; made once per worker."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.faults.operations import BY_NAME, make_templates
from tests.faults.oracle import Clean, undisturbed
from tests.faults.victims import Victims, fault_library


@pytest.fixture(scope="session")
def victims() -> Iterator[Victims]:
    server = Victims()
    yield server
    server.close()


@pytest.fixture(scope="session")
def preloaded() -> None:
    if fault_library() is None:
        pytest.skip("no C compiler (cc) for the library that lets calls fail")


@pytest.fixture(scope="session")
def templates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_templates(tmp_path_factory.mktemp("templates"))


@pytest.fixture(scope="session")
def clean(templates: Path, victims: Victims, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Clean]:
    """`clean("run")`: the operation by name, as it goes without a fault."""
    known: dict[str, Clean] = {}
    folder = tmp_path_factory.mktemp("clean")

    def of(name: str) -> Clean:
        if name not in known:
            known[name] = undisturbed(BY_NAME[name], templates, folder / name, victims, folder / f"{name}.log")
        return known[name]

    return of
