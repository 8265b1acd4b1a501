"""What is wrong, and what is odd, in the files of one import: problems refuse it, events travel with it."""

import difflib
import unicodedata
from collections import Counter
from collections.abc import Iterable

from orient.errors import InputError, Problem
from orient.values import Event

SHOWN_CHARACTERS = 60
PROBLEMS_PER_FILE = 1000


class BadValue(ValueError):
    """A cell or a key that cannot be taken: one sentence without the place, and what to do."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint


class Findings:
    """Collects all problems and events of one import, file by file."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self.events: list[Event] = []
        self._per_file: Counter[str] = Counter()
        self._unread: set[str] = set()
        self._all_about_paths = True

    def problem(self, file: str, line: int, message: str, hint: str = "") -> None:
        self._all_about_paths = False
        self._add(file, line, message, hint)

    def path_problem(self, file: str, message: str, hint: str = "") -> None:
        """The file itself cannot be read: a mistake in the command (exit code 2)."""
        self._add(file, 0, message, hint)

    def warn(self, code: str, subject: str, message: str, value: float | None = None) -> None:
        self.events.append(Event("warning", code, subject, message, value))

    def count(self, file: str) -> int:
        return self._per_file[file]

    def too_many(self, file: str) -> bool:
        """A file that is wrong in every line is not read to its end: the list of problems stays bounded."""
        return self._per_file[file] >= PROBLEMS_PER_FILE

    def stop(self, file: str, line: int) -> None:
        """From this line on the file is not looked at."""
        if file not in self._unread:
            self._unread.add(file)
            self.problem(file, line, "too many problems; the rest of the file was not read")

    def raise_problems(self) -> None:
        if self.problems:
            raise InputError(self.problems, 2 if self._all_about_paths else 1, len(self._unread))

    def _add(self, file: str, line: int, message: str, hint: str) -> None:
        if self._per_file[file] >= 2 * PROBLEMS_PER_FILE:
            self._unread.add(file)
            return
        stop = "." if hint and message[-1:] not in ".?!" else ""
        self.problems.append(Problem(file, line, message + stop, hint))
        self._per_file[file] += 1


def shown(text: str) -> str:
    """Text of a file as it may be printed: at most 60 characters, controls and hidden characters as `\\x1b`."""
    pieces = [_printable(character) for character in text[:SHOWN_CHARACTERS]]
    line = "".join(pieces)
    if len(line) > SHOWN_CHARACTERS or len(text) > SHOWN_CHARACTERS:
        line = line[: SHOWN_CHARACTERS - 1] + "…"
    return line


def _printable(character: str) -> str:
    if character == " " or unicodedata.category(character)[0] not in "CZ":
        return character
    code = ord(character)
    if code <= 0xFF:
        return f"\\x{code:02x}"
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"


def nearest(word: str, known: Iterable[str]) -> str:
    """`Did you mean "f_mm"?`, or nothing when no known word is near."""
    names = sorted(known)
    same = [name for name in names if name.casefold() == word.casefold()]
    close = same or difflib.get_close_matches(word[:SHOWN_CHARACTERS], names, n=1)
    return f'Did you mean "{close[0]}"?' if close else ""
