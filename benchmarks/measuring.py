"""Candidates of one task, timed in shuffled rounds, so that a busy machine slows all of them alike."""

import random
import statistics
import time
import tracemalloc
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

SHORTEST_S = 0.004
"""A candidate is called as often in a row as fills this time."""
OWN, NUMBA = "orient", "orient, numba"
WALL = time.perf_counter


@dataclass(frozen=True)
class Task:
    """One piece of work. `candidates`: names to calls without arguments that give comparable numbers.

    The first candidate that is not orient's is the anchor. `target`: the largest allowed ratio of orient to it, None
    for a row that only informs; `numba_target`: that of the compiled candidate. `tolerance`: how far results may be
    from the anchor's, relative to the largest number of each column; None where they cannot be compared. `growth`: the
    row's place in the growth plot, (line, size). `clock`: processor time, which other processes on the machine disturb
    little; `WALL` where files are synced or processes started. `compared`: the arrays of a result that are compared.
    """

    name: str
    candidates: Mapping[str, Callable[[], Any]]
    target: float | None = None
    tolerance: float | None = 1e-6
    growth: tuple[str, int] | None = None
    note: str = ""
    clock: Callable[[], float] = time.process_time
    numba_target: float | None = None
    compared: Callable[[Any], Sequence[NDArray[np.float64]]] = lambda result: [np.asarray(result)]

    def target_of(self, name: str) -> float | None:
        return {OWN: self.target, NUMBA: self.numba_target}.get(name)


def compiled(call: Callable[[], Any]) -> dict[str, Callable[[], Any]]:
    """The candidate that needs numba, where that is installed."""
    return {NUMBA: call} if find_spec("numba") else {}


@dataclass
class Timed:
    """Seconds of each candidate in each round, how far their results are from the anchor's, and orient's memory."""

    task: Task
    seconds: dict[str, list[float]]
    apart: dict[str, float] = field(default_factory=dict)
    peak_bytes: int = 0

    @property
    def anchor(self) -> str:
        return next(name for name in self.seconds if not name.startswith(OWN))

    def median(self, name: str) -> float:
        return statistics.median(self.seconds[name])

    def ratios(self, name: str) -> tuple[float, float, float]:
        """Quartiles of the ratio to the anchor, round by round."""
        values = [mine / other for mine, other in zip(self.seconds[name], self.seconds[self.anchor], strict=True)]
        if len(values) < 2:
            return values[0], values[0], values[0]
        low, middle, high = statistics.quantiles(values, n=4, method="inclusive")
        return low, middle, high


def measure(task: Task, rounds: int = 9, budget_s: float = 12.0) -> Timed:
    """Results compared once, then `rounds` rounds, fewer (at least three) when the budget is spent."""
    results, loops = {}, {}
    begin = time.perf_counter()
    for name, call in task.candidates.items():
        call()  # imports, caches, compiled code
        start = time.perf_counter()
        results[name] = call()
        loops[name] = max(1, int(SHORTEST_S / max(time.perf_counter() - start, 1e-9)))
    timed = Timed(task, {name: [] for name in task.candidates})
    timed.apart = _apart(results, task, timed.anchor)
    if task.growth is not None:
        timed.peak_bytes = _peak_bytes(task.candidates[OWN])
    order, shuffle = list(task.candidates), random.Random(1)
    for number in range(rounds):
        shuffle.shuffle(order)
        for name in order:
            timed.seconds[name].append(_seconds(task, name, loops[name]))
        if number >= 2 and time.perf_counter() - begin > budget_s:
            break
    return timed


def _peak_bytes(call: Callable[[], Any]) -> int:
    """The most that one call holds beyond its inputs."""
    tracemalloc.start()
    call()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def _seconds(task: Task, name: str, loops: int) -> float:
    call, begin = task.candidates[name], task.clock()
    for _ in range(loops):
        call()
    return (task.clock() - begin) / loops


def _apart(results: Mapping[str, Any], task: Task, anchor: str) -> dict[str, float]:
    """Largest difference from the anchor, each kind of number and each column in units of its largest."""
    if results[anchor] is None or task.tolerance is None:
        return {}
    kinds = {name: task.compared(found) for name, found in results.items()}
    return {name: max(map(_difference, found, kinds[anchor])) for name, found in kinds.items()}


def _difference(found: NDArray[np.float64], base: NDArray[np.float64]) -> float:
    return float(np.max(np.abs(found - base) / np.maximum(np.abs(base).max(axis=0), 1e-300)))


def exponent(sizes: Sequence[int], seconds: Sequence[float]) -> float:
    """Slope of log(time) against log(size) over the larger half of the sizes, where calls no longer count."""
    half = len(sizes) // 2
    slope, _ = np.polyfit(np.log(sizes[half:]), np.log(seconds[half:]), 1)
    return float(slope)
