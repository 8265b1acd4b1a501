"""What a simulation of gross errors counts, and the rates that are promised of it."""

from dataclasses import dataclass

import numpy as np
import pytest

BOUND = 3.5
"""Standard deviations of a binomial share that a small run allows."""


@dataclass
class Counts:
    """What happened in `scenes` scenes."""

    scenes: int = 0
    tests: int = 0
    false_w: int = 0
    false_tau: int = 0
    rejected_globally: int = 0
    found: int = 0
    found_by_tau: int = 0
    large_named_first: int = 0


def within(share: float, promised: float, trials: int) -> bool:
    return abs(share - promised) <= BOUND * np.sqrt(promised * (1 - promised) / trials)


def small_run_keeps(counts: Counts, independent_tests: int) -> None:
    """The rates of a run of few scenes, within what chance explains."""
    n = counts.scenes
    assert within(counts.found / n, 0.80, n), counts
    assert within(counts.found_by_tau / n, 0.80, n), counts
    assert within(counts.false_w / counts.tests, 0.001, independent_tests), counts
    assert within(counts.false_tau / counts.tests, 0.001, independent_tests), counts
    assert within(counts.rejected_globally / n, 0.05, n), counts


def large_run_keeps(counts: Counts, found: float, false_w: float, globally: float) -> None:
    """The rates of ten thousand scenes, each within its bound; 10 MDB named first in 99.9 %."""
    n = counts.scenes
    assert counts.found / n == pytest.approx(0.80, abs=found), counts
    assert counts.found_by_tau / n == pytest.approx(0.80, abs=0.02), counts
    assert counts.false_w / counts.tests == pytest.approx(0.001, abs=false_w), counts
    assert counts.false_tau / counts.tests == pytest.approx(0.001, abs=2e-4), counts
    assert counts.rejected_globally / n == pytest.approx(0.05, abs=globally), counts
    assert counts.large_named_first >= 0.999 * n, counts
