"""What a command says after it stored or computed something."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from orient.errors import OrientError
from orient.pipeline.registry import is_optional
from orient.report.findings import findings, print_findings
from orient.report.text import console, printable
from orient.values import InputTables
from orient.words import typed

if TYPE_CHECKING:
    from rich.progress import TaskID

    from orient.pipeline.registry import Stage
    from orient.pipeline.runner import Result
    from orient.store.project import RunInfo


INDENT = " " * 4


def show_inputs(project: Path, inputs: Sequence[InputTables]) -> None:
    """After `new`: what was read."""
    from orient.pipeline.runner import describe

    out = console()
    out.print(f"{printable(str(project))} made.")
    for given in inputs:
        out.print(f"  {given.stage:<12} version 1   {describe(given)}")
        print_findings(findings(given.stage, given.events), INDENT)
    out.print(f"Next: orient run {printable(typed(project))}")


def show_added(result: "Result") -> None:
    if result.run is None:
        return
    if not result.computed:
        console().print(f"{result.stage}: the same as version {result.run.version}; nothing stored (--again stores it)")
        return
    console().print(f"{result.stage} version {result.run.version}: {printable(result.run.summary)}")
    print_findings(findings(result.stage, result.events), INDENT)


def show_selected(run: "RunInfo") -> None:
    console().print(f"{run.stage}: version {run.version} is current now; what read another version is stale.")


def show_withdrawn(gone: Sequence["RunInfo"]) -> None:
    """What is left without a current version, and how to have it back."""
    asked, *others = gone
    rest = f", nor have {', '.join(run.stage for run in others)}, which need it" if others else ""
    back = f"orient select PROJECT {asked.stage} {asked.version}"
    console().print(f"{asked.stage} has no current version now{rest}. All versions are kept: {back}", soft_wrap=True)


def show_result(result: "Result", project: Path) -> None:
    """After one stage: its line, its findings; a failure ends the command with exit code 1."""
    run = result.run
    if run is None:
        raise OrientError(f"{result.stage} waits for {result.waits_for}")
    if result.failed:
        print_findings(findings(result.stage, result.events), INDENT)
        raise OrientError(f"{result.stage}: {run.error} (kept as version {run.version})", result.hint)
    console().print(line(result))
    print_findings(findings(result.stage, result.events), INDENT)
    console().print(f"See: orient show {printable(typed(project))} {result.stage}")


def line(result: "Result") -> str:
    """One line for one stage."""
    if result.run is None:
        return f"{result.stage:<12} waits for {result.waits_for}"
    how = "  (known, current again)" if result.selected_again else "" if result.computed else "  (unchanged)"
    told = result.run.error if result.failed else result.run.summary
    return f"{result.stage:<12} version {result.run.version:<3} {printable(told)}{how}"


class Progress:
    """The display of `run`: a moving line on a terminal, one finished line per stage everywhere."""

    def __init__(self) -> None:
        from orient.report.terminal import moving_line, spinner

        self._out = console()
        self._bar = moving_line(self._out, spinner(self._out))
        self._task: TaskID | None = None

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: Any) -> None:
        self._bar.stop()

    def begin(self, stage: "Stage") -> None:
        if self._task is not None:
            self._bar.remove_task(self._task)
        self._task = self._bar.add_task(f"{stage.name}: {stage.title.partition(':')[0]}")

    def end(self, result: "Result") -> None:
        if result.waits_for and is_optional(result.stage, result.waits_for):
            return
        self._out.print(line(result))
        if result.computed:
            print_findings(findings(result.stage, result.events), INDENT, out=self._out)

    def close_with(self, results: "Sequence[Result]", project: Path) -> None:
        """The last words, and exit code 1 if a stage failed."""
        failures = [result for result in results if result.failed]
        if failures:
            first = failures[0]
            error = first.run.error if first.run else ""
            raise OrientError(f"{first.stage}: {error}", first.hint)
        if all(result.run is None for result in results):
            raise OrientError("nothing can be computed yet", f"See what is missing: orient status {typed(project)}")
        waiting = [one for one in results if one.waits_for and not is_optional(one.stage, one.waits_for)]
        if waiting:
            self._out.print(f"Not oriented yet: {waiting[0].stage} waits for {waiting[0].waits_for}.")
        elif not any(result.computed or result.selected_again for result in results):
            self._out.print("Everything is up to date.")
