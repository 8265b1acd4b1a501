"""`check` and `upgrade`: what they found, line by line."""

from pathlib import Path

from orient.errors import ProjectError
from orient.report.text import console, printable
from orient.store.check import check_project
from orient.store.upgrade import upgrade_project


def show_check(path: Path) -> None:
    """Every line of the examination; a fault ends the command with exit code 3."""
    report = check_project(path)
    out = console()
    for line in report.lines:
        mark = "ok   " if line.ok else "FAULT"
        out.print(f"{mark}  {line.name:<22} {printable(line.detail)}", soft_wrap=True)
    faults = [line for line in report.lines if not line.ok]
    if faults:
        worst = f"{path}: {faults[0].name}: {faults[0].detail}"
        raise ProjectError(worst, "Restore a backup, or make the project anew.")
    out.print(f"{printable(str(path))} is sound.")


def show_upgrade(path: Path) -> None:
    """What was done, and where the old file is."""
    done = upgrade_project(path)
    out = console()
    if done.backup is None:
        out.print(f"{printable(str(path))} already has format {done.after}; nothing to do.")
        return
    out.print(f"{printable(str(path))} is format {done.after} now (was {done.before}).")
    out.print(f"The old file is kept as {printable(str(done.backup))}.")
