"""Where a project stands, and what a run did."""

from collections.abc import Mapping
from dataclasses import dataclass

from orient.report.findings import Finding as Finding
from orient.values import Scalar

GOOD = "good"


@dataclass(frozen=True, slots=True)
class Stage:
    """One stage: its current version (None: there is none), its state, and the result or the reason in one line.

    `state`: current | stale | to compute | waiting | failed.
    """

    version: int | None
    state: str
    told: str


@dataclass(frozen=True, slots=True)
class Status:
    """The verdict in one word and in one sentence; each stage by name.

    `verdict`: good | doubtful | stale | incomplete | failed.
    """

    verdict: str
    sentence: str
    stages: Mapping[str, Stage]

    @property
    def is_good(self) -> bool:
        """A result of today's inputs in which no problem was found."""
        return self.verdict == GOOD


@dataclass(frozen=True, slots=True)
class Done:
    """What came of asking for a stage.

    `version` is None where the stage still `waits_for` something; `computed` is False where nothing had changed.
    `settings`: all that the version was made with.
    """

    stage: str
    version: int | None
    computed: bool
    summary: str
    findings: tuple[Finding, ...]
    settings: Mapping[str, Scalar]
    waits_for: str = ""
