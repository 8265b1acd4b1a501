"""`verify`: what was found about each run, line by line, then the verdict; and what other commands say of it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from orient.errors import OrientError
from orient.report.text import console, print_json, printable
from orient.values import Scalar
from orient.words import counted

if TYPE_CHECKING:
    from rich.progress import TaskID

    from orient.pipeline.verify import Request
    from orient.pipeline.verify_verdict import RunVerdict, Verification
    from orient.store.project import Project, RunInfo

SHOWN, SHOWN_OF_CONSEQUENCES = 20, 3
MINUTE = len("2026-01-01T00:00")
VERIFICATION = """
SELECT stage, version, is_current, verified_at, actor, software, evidence, verdict, is_same_run, method,
       largest_difference, largest_at, second_engine
FROM v_verification
"""


def show_verify(path: Path, request: "Request", as_json: bool) -> None:
    """Verify a project; differences end the command with exit code 1."""
    from orient.pipeline.verify import verify_project

    with Lines(quiet=as_json) as lines:
        done = verify_project(path, request, lines.watch)
    if as_json:
        _print_json(done)
    else:
        _print_verdict(path, done)
    if not done.holds:
        raise OrientError(
            f"{path} is not verified: {done.words}",
            "See what was found: orient sql PROJECT verification" if done.kept else "",
        )


class Lines:
    """A moving line on a terminal, and one finished line for each run everywhere."""

    def __init__(self, quiet: bool) -> None:
        from rich.progress import BarColumn

        from orient.report.terminal import moving_line

        self._out, self._quiet = console(), quiet
        self._bar = moving_line(self._out, BarColumn(bar_width=20), is_quiet=quiet)
        self._task: TaskID = self._bar.add_task("verify")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: Any) -> None:
        self._bar.stop()

    @property
    def watch(self) -> Any:
        from orient.pipeline.verify import Watch

        return Watch(self._begin, self._end, self._simulated)

    def _begin(self, run: "RunInfo", place: int, total: int) -> None:
        self._bar.update(self._task, description=f"{run.stage} version {run.version}", completed=place - 1, total=total)

    def _simulated(self, done: int, n: int) -> None:
        self._bar.update(self._task, description=f"simulation {done} of {n}", completed=done, total=n)

    def _end(self, verdict: "RunVerdict") -> None:
        if not self._quiet:
            for line in run_lines(verdict):
                self._out.print(printable(line), soft_wrap=True)


def run_lines(verdict: "RunVerdict") -> list[str]:
    """A run in one line; what is remarkable about it below."""
    run = verdict.run
    lines = [f"{run.stage:<12} version {run.version:<3} {_told(verdict)}"]
    if verdict.because and verdict.method == "recomputed":
        lines.append(f"    compared to 1e-9: {verdict.because}")
    if verdict.reads and verdict.found.refused:
        lines.append(f"    it reads {verdict.reads}, which differs")
    lines += [f"    {text}" for text in (*_engines(verdict), *verdict.remarks)]
    if verdict.left_out:
        lines.append(f"    no second engine: {verdict.left_out}")
    if verdict.spread is not None:
        ratios = verdict.spread.simulated / verdict.spread.predicted
        lines.append(
            f"    {verdict.spread.n} simulated adjustments: spread {ratios.min():.3f} to {ratios.max():.3f} of Q's "
            f"(allowed 1 +- {verdict.spread.allowed:.3f})"
        )
    return lines + [f"    DIFFERS {text}" for text in _faults(verdict)]


def _told(verdict: "RunVerdict") -> str:
    found = verdict.found
    if found.refused:
        return counted(len(found.refused), "difference")
    if verdict.method == "digest":
        return "as sealed (a list, nothing to compute)"
    if verdict.verdict == "identical":
        return f"{found.n_values} values, all bits equal"
    largest = f", largest difference {found.accepted.rank:.1e}" if found.accepted else ""
    return f"{found.n_values} values, {found.n_identical} equal in all bits{largest}"


def _engines(verdict: "RunVerdict") -> list[str]:
    """For each engine the largest difference of each quantity, with what it is measured in."""
    largest: dict[str, dict[str, tuple[float, str]]] = {}
    for part in verdict.agreements:
        of_engine = largest.setdefault(part.engine, {})
        before = of_engine.get(part.quantity, (0.0, ""))[0]
        unit = " sigma" if part.relative_to == "standard deviation" else ""
        of_engine[part.quantity] = (max(before, part.difference), unit)
    return [
        f"{engine}: " + ", ".join(f"{name} {size:.0e}{unit}" for name, (size, unit) in quantities.items())
        for engine, quantities in largest.items()
    ]


def _faults(verdict: "RunVerdict") -> list[str]:
    from orient.pipeline.verify_verdict import in_words

    many = SHOWN_OF_CONSEQUENCES if verdict.reads else SHOWN
    shown = [in_words(difference) for difference in verdict.worst[:many]]
    if len(verdict.found.refused) > many:
        shown.append(f"... and {len(verdict.found.refused) - many} more: table verified_difference")
    return shown + verdict.disagreements


def _print_verdict(path: Path, done: "Verification") -> None:
    out = console()
    for text in done.ledger:
        out.print(f"DIFFERS ledger: {printable(text)}", soft_wrap=True)
    if done.holds:
        out.print(f"{printable(str(path))} is verified: {printable(done.words)}.", soft_wrap=True)
    if done.kept is not None:
        out.print(f"Kept as evidence: verify version {done.kept.version}")
    else:
        out.print("Not kept (--no-record).")


def _print_json(done: "Verification") -> None:
    from orient.pipeline.verify_verdict import evidence

    content = {
        "verified": done.holds,
        "told": done.words,
        "evidence_version": done.kept.version if done.kept else None,
        "ledger": list(done.ledger),
        "runs": [
            {"stage": verdict.run.stage, "version": verdict.run.version, "run_id": verdict.run.run_id}
            for verdict in done.verdicts
        ],
        "tables": evidence(done).tables,
    }
    print_json(content)


# ---------------------------------------------------------------------------------------------- told by others


def known_verdicts(project: "Project") -> list[dict[str, Scalar]]:
    """What the last verification found about each run, from the file."""
    columns, rows = project.query(VERIFICATION)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def verified_line(row: dict[str, Scalar]) -> str:
    """verified 2026-11-22 07:50 UTC by anna with orient 0.1.0: all bits equal."""
    when = str(row["verified_at"])[:MINUTE].replace("T", " ")
    software = str(row["software"]).split(",")[0]
    return f"verified {when} UTC by {row['actor']} with {software}: {_verdict_words(row)}"


def _verdict_words(row: dict[str, Scalar]) -> str:
    if not row["is_same_run"]:
        return "what was verified is no longer what is stored"
    if row["verdict"] == "differs":
        return f"DIFFERS in {row['largest_at']}" if row["largest_at"] else "DIFFERS"
    if row["method"] == "digest":
        return "as sealed"
    engine = f", second engine {row['second_engine']}" if row["second_engine"] else ""
    if row["verdict"] == "identical":
        return f"all bits equal{engine}"
    return f"largest difference {row['largest_difference']:.0e} in {row['largest_at']}{engine}"


def status_line(rows: Sequence[dict[str, Scalar]], current: Mapping[str, object]) -> str:
    """One line about all current versions; empty if nothing was ever verified."""
    if not rows:
        return ""
    good = {row["stage"]: row for row in rows if row["is_current"] and _is_good(row)}
    missing = [f"{stage} {version}" for stage, version in current.items() if stage not in good]
    if missing:
        return f"not verified: {', '.join(missing)}"
    oldest = min(good.values(), key=lambda row: str(row["verified_at"]))
    worst = max(good.values(), key=lambda row: row["largest_difference"] or 0.0)
    head = verified_line(oldest).partition(": ")[0]
    if not worst["largest_difference"]:
        return f"{head}: all bits equal"
    return f"{head}: largest difference {worst['largest_difference']:.0e} in {worst['stage']}, {worst['largest_at']}"


def _is_good(row: dict[str, Scalar]) -> bool:
    engine_differs = row["second_engine"] == "differs"
    return bool(row["is_same_run"]) and row["verdict"] != "differs" and not engine_differs
