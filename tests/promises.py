"""Promises and how often they were tried: a small pytest plugin (loaded by tests/conftest.py).

    def test_killed(promise: Promise) -> None:
        kept = promise("F1")                      # a name of PROMISES
        for moment in moments:
            with kept.trial(f"killed after {moment:.3f} s"):
                assert check_project(path).ok
        kept.largest("s to stop", seconds)        # optional: the largest value of all trials is shown

A trial that fails is counted and the loop goes on; at its end the test fails with all that was said. The counts of
all tests and all workers are added up into one table at the end of the run (`--promises FILE` also writes it as
Markdown). A test that uses the fixture carries the mark `promise`, so that `make test-slow` runs it too. Call
`promise` before a `pytest.skip`: a promise that was not tried is then listed as such.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

PROMISES = {
    "F1": "a killed command leaves the project before or after, never between",
    "F2": "the same at every single write",
    "F3": "an I/O error at any write is named and leaves the file unchanged",
    "F4": "what was reported as stored survives a power cut",
    "F5": "a full disk is named, the file unchanged and usable after freeing space",
    "F6": "commands at once: all finish, none is half-written",
    "F7": "a long read or write stops the others no longer than a commit",
    "F8": "one file: nothing lies beside it",
    "F9": "Ctrl-C and SIGTERM stop within 1 s and roll back",
    "F10": "results are never changed",
    "F11": "changed content is found by orient check",
    "F12": "what is sealed was read back before the commit",
    "F13": "NaN, infinity and wrong types are never stored",
    "F14": "new files, backups and exports have the rights of the source",
    "F15": "a read-only project can be read; a write is refused before computing",
    "F16": "no project is created by a typing error",
    "F17": "out of memory is said in one sentence and leaves the file unchanged",
    "F18": "locale, rights mask, missing folders and clock change no result",
    "V1": "newer, older, foreign, empty and damaged files each have their own error",
    "V2": "an upgrade that fails leaves the original as it was",
    "V3": "after an upgrade all rows, digests and guards are there",
    "V4": "no half upgrade is ever visible",
    "V5": "a verified backup exists before the first change",
    "V6": "there is no downgrade; the message names the backup",
    "V7": "who has the file open during an upgrade cannot damage it",
    "S1": "opening a stranger's file runs, deletes, writes or reads nothing else",
    "S2": "opening any file ends within 3 s and 200 MB",
    "S3": "no crash, no traceback, no hang on damaged files",
    "S4": "nothing a stranger's schema defines is executed",
    "S5": "files beside the project are examined first",
    "S6": "nothing is allocated from a declared size",
    "S7": "exports and reports cannot attack",
    "S8": "stored names never become paths",
    "S9": "no pickle, no eval, no SQL text from files",
    "B": "every bad input of the catalogue is answered as it says",
    "L1": "status and log do not grow with the rows of the project",
    "L2": "check of a 500 MB file ends within 60 s",
    "L3": "memory is bounded; exports and reports stream",
}
MOST_TOLD = 10


@dataclass
class Trials:
    """How often one promise was tried by one test, what failed, the largest values seen."""

    name: str
    count: int = 0
    failed: list[str] = field(default_factory=list)
    figures: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def trial(self, what: str = "") -> Iterator[None]:
        """One trial; whatever is raised inside is a failure and is told when the test has ended."""
        self.count += 1
        try:
            yield
        except Exception as error:
            self.failed.append(f"{what}: {type(error).__name__}: {error}")

    def largest(self, what: str, value: float) -> None:
        self.figures[what] = max(value, self.figures.get(what, value))


Promise = Callable[[str], Trials]
KEPT: pytest.StashKey[dict[str, Trials]] = pytest.StashKey()


@pytest.fixture
def promise(request: pytest.FixtureRequest) -> Promise:
    """`promise("F1")` counts the trials of that promise in this test; see the head of tests/promises.py."""
    kept = request.node.stash.setdefault(KEPT, {})

    def of(name: str) -> Trials:
        assert name in PROMISES, f"tests/promises.py knows no promise {name}"
        return kept.setdefault(name, Trials(name))

    return of


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Iterator[None]:
    result = yield
    told = [f"{kept.name}: {text}" for kept in pyfuncitem.stash.get(KEPT, {}).values() for text in kept.failed]
    if told:
        more = [f"... and {len(told) - MOST_TOLD} more"] if len(told) > MOST_TOLD else []
        pytest.fail("\n".join(told[:MOST_TOLD] + more), pytrace=False)
    return result  # type: ignore[return-value]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """The counts travel with the report of the teardown, which xdist's workers send to the main process."""
    if call.when == "teardown":
        for kept in item.stash.get(KEPT, {}).values():
            item.user_properties.append(("promise", [kept.name, kept.count, len(kept.failed), kept.figures]))
    return (yield)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if "promise" in getattr(item, "fixturenames", ()):
            item.add_marker("promise")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--promises", metavar="FILE", help="write the table of promises, trials and failures here")


def pytest_configure(config: pytest.Config) -> None:
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Table(config.getoption("--promises")), "promise-table")


class Table:
    """Adds up what the tests report and shows it once, in the main process."""

    def __init__(self, path: str | None) -> None:
        self.path = path
        self.sums: dict[str, list[int]] = defaultdict(lambda: [0, 0])
        self.figures: dict[str, dict[str, float]] = defaultdict(dict)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.when != "teardown":
            return
        for name, count, failed, figures in (value for key, value in report.user_properties if key == "promise"):
            self._add(name, count, failed, figures)

    def _add(self, name: str, count: int, failed: int, figures: dict[str, float]) -> None:
        self.sums[name][0] += count
        self.sums[name][1] += failed
        for what, value in figures.items():
            self.figures[name][what] = max(value, self.figures[name].get(what, value))

    def rows(self) -> list[tuple[str, str, str, str, str]]:
        """Promise, its sentence, trials, failures, figures; in the order of PROMISES."""
        return [
            (name, PROMISES[name], str(self.sums[name][0]), str(self.sums[name][1]), self._told(name))
            for name in PROMISES
            if name in self.sums
        ]

    def _told(self, name: str) -> str:
        if not self.sums[name][0]:
            return "NOT TRIED"
        return ", ".join(f"largest {what} {value:.3g}" for what, value in sorted(self.figures[name].items()))

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        if not self.sums:
            return
        terminalreporter.section("promises")
        for name, sentence, trials, failures, told in self.rows():
            terminalreporter.write_line(f"{name:4}{trials:>8}{failures:>6}  {sentence}{told and f' ({told})'}")
        if self.path:
            Path(self.path).parent.mkdir(parents=True, exist_ok=True)
            Path(self.path).write_text(self._markdown(), encoding="utf-8")

    def _markdown(self) -> str:
        lines = ["| promise | | trials | failures | measured |", "|---|---|---|---|---|"]
        return "\n".join(lines + [f"| {' | '.join(row)} |" for row in self.rows()]) + "\n"
