"""A call to the disk fails, once or from then on: a named error, an unchanged file, the truth (F3)."""

import errno
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.faults.operations import Operation, each
from tests.faults.oracle import Clean, judge
from tests.faults.victims import Fault, Victims
from tests.promises import Promise

pytestmark = pytest.mark.usefixtures("preloaded")

CleanOf = Callable[[str], Clean]
ERRORS = {"EIO": errno.EIO, "ENOSPC": errno.ENOSPC}
LASTING = {"once": False, "from then on": True}
EVERY = {("EIO", "once"): 1, ("EIO", "from then on"): 2, ("ENOSPC", "once"): 4, ("ENOSPC", "from then on"): 4}
"""Of the calls: SQLite treats both errors the same way until it names them."""


def fail_at_calls(
    clean: Clean, moments: list[int], error: str, lasting: str, folder: Path, victims: Victims, promise: Promise
) -> None:
    kept = promise("F3" if error == "EIO" else "F5")
    for at in moments:
        clean.scene(folder)
        fault = Fault(str(folder), at, ERRORS[error], LASTING[lasting])
        ended = victims.run(*clean.words(folder), fault=fault)
        with kept.trial(f"{clean.operation}: {error} {lasting} at its call {at} ({clean.calls[at - 1]})"):
            assert ended.code in (0, 3), ended
            judge(clean, folder, ended, victims)


@pytest.mark.parametrize("lasting", LASTING)
@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("name", ["select", "backup"])
def test_some_calls_fail(
    name: str, error: str, lasting: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    moments = clean(name).moments(every=4)
    fail_at_calls(clean(name), moments, error, lasting, tmp_path / "scene", victims, promise)


@pytest.mark.slow
@pytest.mark.parametrize("lasting", LASTING)
@pytest.mark.parametrize("error", ERRORS)
@pytest.mark.parametrize("operation", each("check"))
def test_each_call_fails(
    operation: Operation, error: str, lasting: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    one = clean(operation.name)
    moments = one.moments(every=EVERY[error, lasting])
    fail_at_calls(one, moments, error, lasting, tmp_path / "scene", victims, promise)
