"""`check`, `backup`, `receive` and `upgrade`: what they found and made."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

from orient.errors import ProjectError
from orient.report.text import console, printable
from orient.store.check import check_project
from orient.store.copies import Copied, backup_project, receive_project
from orient.store.upgrade import upgrade_project
from orient.words import counted


def show_check(path: Path) -> None:
    """Every line of the examination; a fault ends the command with exit code 3."""
    with moving_count("rows examined") as progress:
        report = check_project(path, progress)
    out = console()
    for line in report.lines:
        mark = "ok   " if line.ok else "FAULT"
        out.print(f"{mark}  {line.name:<22} {printable(line.detail)}", soft_wrap=True)
    faults = [line for line in report.lines if not line.ok]
    if faults:
        worst = f"{path}: {faults[0].name}: {faults[0].detail}"
        raise ProjectError(worst, faults[0].hint or "Restore a backup, or make the project anew.")
    out.print(f"{printable(str(path))} is sound.")


def show_backup(path: Path, target: Path | None) -> None:
    """Where the copy is and what was verified in it."""
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    with moving_count("rows examined") as progress:
        copied = backup_project(path, target or path.with_name(f"{path.stem}.backup-{stamp}{path.suffix}"), progress)
    _say_copied(copied, "backup")


def show_received(stranger: Path, target: Path) -> None:
    with moving_count("rows examined") as progress:
        copied = receive_project(stranger, target, progress)
    _say_copied(copied, "clean copy")


def _say_copied(copied: Copied, what: str) -> None:
    out = console()
    runs = counted(copied.runs, "run")
    out.print(f"{printable(str(copied.path))}: {what}, {runs}, every digest verified, {copied.size} bytes")
    out.print(f"sha256 {copied.sha256}")


@contextmanager
def moving_count(what: str) -> Iterator[Callable[[int, int], None]]:
    """A moving line on a terminal for long work, nothing elsewhere."""
    from rich.progress import BarColumn, MofNCompleteColumn

    from orient.report.terminal import moving_line

    with moving_line(console(), BarColumn(bar_width=20), MofNCompleteColumn()) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


def show_upgrade(path: Path) -> None:
    """What was done, and where the old file is."""
    done = upgrade_project(path)
    out = console()
    if done.backup is None:
        out.print(f"{printable(str(path))} already has format {done.after}; nothing to do.")
        return
    out.print(f"{printable(str(path))} is format {done.after} now (was {done.before}).")
    out.print(f"The old file is kept as {printable(str(done.backup))}.")
    for warning in done.warnings:
        out.print(f"note: {printable(warning)}")
