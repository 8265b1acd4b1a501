"""What a verification found, run by run, and its rows as evidence."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass

from orient.pipeline.agreement import Agreement
from orient.pipeline.verify_compare import LARGEST, Comparison, Difference
from orient.solvers.resection_simulation import Spread
from orient.store.project import RunInfo
from orient.values import Outcome, Row
from orient.words import counted

KEPT = 100
"""Differences of one run that are kept by name, the largest; `verified_run` counts all."""


@dataclass(frozen=True, slots=True)
class RunVerdict:
    """What was found about one run.

    `because`: why bits were not compared; `left_out`: why no second engine; `reads`: inputs that differ themselves;
    `remarks`: what other programs could not check.
    """

    run: RunInfo
    method: str
    because: str
    found: Comparison
    agreements: Sequence[Agreement] = ()
    left_out: str = ""
    spread: Spread | None = None
    reads: str = ""
    remarks: Sequence[str] = ()

    @property
    def title(self) -> str:
        return f"{self.run.stage} version {self.run.version}"

    @property
    def verdict(self) -> str:
        if self.found.refused:
            return "differs"
        return "identical" if self.found.n_identical == self.found.n_values else "agrees"

    @property
    def disagreements(self) -> list[str]:
        """What the second engine or the simulation found otherwise, in words."""
        engine = [
            f"{part.engine}{f', sheet {part.subject}' if part.subject else ''}: {part.quantity} differs by "
            f"{part.difference:.1e} {part.relative_to}"
            for part in self.agreements
            if not part.agrees
        ]
        return engine + ([] if self.spread is None else self.spread.surprises)

    @property
    def holds(self) -> bool:
        return self.verdict != "differs" and not self.disagreements

    @property
    def worst(self) -> list[Difference]:
        """The differences that are kept, the largest first."""
        return heapq.nlargest(KEPT, self.found.refused, key=lambda difference: difference.rank)


@dataclass(frozen=True, slots=True)
class Verification:
    """A verdict for every run, what is wrong with the ledger itself, and the run that keeps the evidence."""

    verdicts: Sequence[RunVerdict]
    ledger: Sequence[str]
    kept: RunInfo | None = None

    @property
    def holds(self) -> bool:
        return not self.ledger and all(verdict.holds for verdict in self.verdicts)

    @property
    def faults(self) -> int:
        """Differences, disagreements and problems of the ledger together."""
        own = sum(len(verdict.found.refused) + len(verdict.disagreements) for verdict in self.verdicts)
        return own + len(self.ledger)

    @property
    def words(self) -> str:
        """The verdict in one line."""
        computed = [verdict for verdict in self.verdicts if verdict.method == "recomputed"]
        n, identical = (sum(getattr(v.found, name) for v in computed) for name in ("n_values", "n_identical"))
        head = f"{counted(len(computed), 'result')} recomputed, {counted(n, 'value')}"
        if not self.holds:
            return f"{self._first_fault()} ({self.faults} in all)"
        if not computed:
            return "nothing is computed yet, the lists are as sealed"
        if n == identical:
            return f"{head}, all bits equal"
        worst = max((v for v in computed if v.found.largest), key=lambda v: v.found.largest.rank)  # type: ignore[union-attr]
        largest = worst.found.largest
        assert largest is not None
        return f"{head}, {identical} equal in all bits, largest difference {largest.rank:.1e} in {worst.title}, " + (
            largest.place
        )

    def _first_fault(self) -> str:
        for verdict in self.verdicts:
            if verdict.found.refused:
                return f"{verdict.title} differs: {in_words(verdict.worst[0])}"
        for verdict in self.verdicts:
            if verdict.disagreements:
                return f"{verdict.title}: {verdict.disagreements[0]}"
        return self.ledger[0]


def in_words(difference: Difference) -> str:
    """One difference as a sentence."""
    if not difference.recomputed:
        return f"{difference.place}: {difference.stored}"
    size = "" if difference.size is None else f" (relative {difference.size:.1e})"
    return f"{difference.place} stored {difference.stored}, recomputed {difference.recomputed}{size}"


def evidence(done: Verification) -> Outcome:
    """Rows of the stage `verify`; a verification that does not hold is a failed run, which says so in every list."""
    tables: dict[str, list[Row]] = {
        "verified_run": [_run_row(verdict) for verdict in done.verdicts],
        "verified_difference": _difference_rows(done),
        "independent_solution": [row for verdict in done.verdicts for row in _solution_rows(verdict)],
        "simulated_spread": [row for verdict in done.verdicts for row in _spread_rows(verdict)],
    }
    if done.holds:
        return Outcome(tables, summary=done.words)
    return Outcome(tables, error=done.words)


def _run_row(verdict: RunVerdict) -> Row:
    found, largest = verdict.found, verdict.found.largest
    return {
        "verified_run_id": verdict.run.run_id,
        "output_digest": verdict.run.output_digest,
        "method": verdict.method,
        "compared": "1e-9" if verdict.because else "bits",
        "because": verdict.because,
        "verdict": verdict.verdict,
        "n_values": found.n_values,
        "n_identical": found.n_identical,
        "n_different": len(found.refused),
        "largest_difference": _size(largest) if largest else (0.0 if found.n_values else None),
        "largest_at": largest.place if largest else "",
        "stored": largest.stored if largest else "",
        "recomputed": largest.recomputed if largest else "",
        "second_engine": _second_engine(verdict),
    }


def _second_engine(verdict: RunVerdict) -> str:
    if not verdict.agreements:
        return f"left out: {verdict.left_out}" if verdict.left_out else ""
    return "agrees" if all(part.agrees for part in verdict.agreements) else "differs"


def _size(difference: Difference) -> float | None:
    return None if difference.size is None else min(difference.size, LARGEST)


def _difference_rows(done: Verification) -> list[Row]:
    pairs = [(verdict.run.run_id, difference) for verdict in done.verdicts for difference in verdict.worst]
    everything = [*pairs, *((None, Difference("ledger", text, "")) for text in done.ledger)]
    return [
        {
            "seq": seq,
            "verified_run_id": run_id,
            "place": difference.place,
            "stored": difference.stored,
            "recomputed": difference.recomputed,
            "difference": _size(difference),
        }
        for seq, (run_id, difference) in enumerate(everything, 1)
    ]


def _solution_rows(verdict: RunVerdict) -> list[Row]:
    return [
        {
            "verified_run_id": verdict.run.run_id,
            "engine": part.engine,
            "subject": part.subject,
            "quantity": part.quantity,
            "difference": min(part.difference, LARGEST),
            "relative_to": part.relative_to,
            "allowed": part.allowed,
            "agrees": int(part.agrees),
        }
        for part in verdict.agreements
    ]


def _spread_rows(verdict: RunVerdict) -> list[Row]:
    spread = verdict.spread
    if spread is None:
        return []
    return [
        {
            "verified_run_id": verdict.run.run_id,
            "unknown": unknown,
            "n": spread.n,
            "n_failed": spread.n_failed,
            "predicted": float(predicted),
            "simulated": float(simulated),
            "ratio": float(simulated / predicted),
            "allowed": spread.allowed,
            "agrees": int(abs(simulated / predicted - 1) <= spread.allowed),
        }
        for unknown, predicted, simulated in zip(spread.unknowns, spread.predicted, spread.simulated, strict=True)
    ]
