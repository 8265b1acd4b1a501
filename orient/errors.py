"""The error tree. Every error a user can meet is an `OrientError`: one sentence, a remedy, an exit code."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec


class OrientError(Exception):
    """The data or the geometry says no (exit code 1)."""

    exit_code = 1

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint
        if hint:
            self.add_note(hint)  # shown below the message in a notebook


class UsageError(OrientError):
    """The command was asked in a way that cannot be carried out (exit code 2)."""

    exit_code = 2


class NotInstalled(UsageError):
    """`what` ("plots need") goes before the names of optional packages; the extra has them all."""

    def __init__(self, what: str, packages: Sequence[str], extra: str, otherwise: str = "") -> None:
        are, them = ("is", "it") if len(packages) == 1 else ("are", "them")
        super().__init__(
            f"{what} {', '.join(packages)}, which {are} not installed",
            f"Install {them}: pip install 'orient[{extra}]'{otherwise}",
        )


def require_numba(compiled: bool | None) -> None:
    """One clear sentence where compiled loops are asked for and their package is not installed."""
    if compiled and find_spec("numba") is None:
        raise NotInstalled("compiled loops need", ["numba"], "fast", " or leave out compiled")


class ProjectError(OrientError):
    """The project file is missing, foreign, damaged, locked, read-only or of another version (exit code 3)."""

    exit_code = 3


class GeometryError(OrientError):
    """The points do not determine what was asked for: singular, weak, behind the camera, below the ground."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing wrong in one input file; `line` is 0 when the whole file is meant."""

    file: str
    line: int
    message: str
    hint: str = ""

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}" if self.line else self.file
        return f"{place}: {self.message}" + (f" {self.hint}" if self.hint else "")


class InputError(OrientError):
    """Input files are refused as a whole; `problems` names everything that is wrong with them.

    So many files were `unread` from some line on, which one of the problems says: there may be more than these.
    """

    SHOWN = 20

    def __init__(self, problems: Sequence[Problem], exit_code: int = 1, unread: int = 0) -> None:
        shown = [str(problem) for problem in problems[: self.SHOWN]]
        if len(problems) > self.SHOWN:
            at_least = "at least " if unread else ""
            shown.append(f"... and {at_least}{len(problems) - self.SHOWN - unread} more problems")
        super().__init__("\n".join(shown))
        self.problems = tuple(problems)
        self.exit_code = exit_code
