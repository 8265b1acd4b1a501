"""TOML files: sections whose keys are checked one by one, each problem with the line of its key."""

import datetime
import math
import re
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from orient.intake import numbers
from orient.intake.findings import BadValue, Findings, nearest, shown
from orient.intake.options import ReadOptions
from orient.intake.text_file import toml_text

LONGEST_TEXT = 255
PLACE = re.compile(r"\s*\(at (?:line (\d+), column \d+|end of document)\)")
MANY_PARTS = re.compile(r"(?:[A-Za-z0-9_\"'\-]{1,64}[ \t]{0,4}\.[ \t]{0,4}){100}")
"""A key of so many parts: tomllib takes time with the square of their number."""
LONG_INTEGER = re.compile(r"[0-9_]{4301,}")
TABLE_HEADER = re.compile(r"\s*\[([^\[\]]{1,300})\]")
ASSIGNMENT = re.compile(r"\s*((?:[A-Za-z0-9_.\-]{1,300}|\"[^\"]{0,300}\"|'[^']{0,300}')(?:\.\"[^\"]{0,300}\")?)\s*=")
KEY_PART = re.compile(r"([A-Za-z0-9_\-]+)|\"([^\"]*)\"|'([^']*)'")
TYPE_WORDS: tuple[tuple[type, str], ...] = (
    (bool, "true or false"),
    (int, "a number"),
    (float, "a number"),
    (str, "text"),
    (list, "a list"),
    (dict, "a table"),
    (datetime.date, "a date"),
    (datetime.time, "a time"),
)

KeyPath = tuple[str, ...]
T = TypeVar("T")


class Section:
    """One table of a TOML file. What was never asked for is unknown: `finish` says so."""

    def __init__(
        self,
        file: str,
        lines: Mapping[KeyPath, int],
        data: Mapping[str, object],
        findings: Findings,
        path: KeyPath = (),
    ) -> None:
        self.file = file
        self.data = data
        self.path = path
        self._lines = lines
        self._findings = findings
        self._asked: set[str] = set()

    def has(self, key: str) -> bool:
        self._asked.add(key)
        return key in self.data

    def value(self, key: str) -> object:
        self._asked.add(key)
        return self.data.get(key)

    def problem(self, key: str, message: str, hint: str = "") -> None:
        """A problem at the line of the key, or of the section when the key is empty or not there."""
        self._findings.problem(self.file, self.line_of(key), message, hint)

    def warn(self, code: str, subject: str, message: str, value: float | None = None) -> None:
        self._findings.warn(code, subject, message, value)

    def missing(self, key: str, hint: str = "") -> None:
        place = f" in [{'.'.join(self.path)}]" if self.path else ""
        self.problem("", f"{key} is missing{place}", hint)

    def section(self, key: str) -> "Section":
        """The table below `key`; empty when it is not there or not a table."""
        value = self.value(key)
        if value is not None and not isinstance(value, dict):
            self.problem(key, f"{shown(key)}: expected a table, got {_type_word(value)}")
        data = value if isinstance(value, dict) else {}
        return Section(self.file, self._lines, data, self._findings, (*self.path, key))

    def number(self, key: str, low: float, high: float, unit: str = "") -> float | None:
        def parse(value: object) -> float:
            return numbers.check_range(as_number(value), low, high, unit)

        return self._parsed(key, parse)

    def sigma(self, key: str) -> float | None:
        def parse(value: object) -> float:
            return numbers.check_sigma(as_number(value), "Leave it out for a value that is taken as known")

        return self._parsed(key, parse)

    def whole(self, key: str, low: int, high: int) -> int | None:
        def parse(value: object) -> int:
            if isinstance(value, bool) or not isinstance(value, int):
                raise BadValue(f"expected a whole number, got {_type_word(value, whole=True)}")
            return int(numbers.check_range(value, low, high))

        return self._parsed(key, parse)

    def angle(self, key: str, limit: float) -> float | None:
        def parse(value: object) -> float:
            degrees = numbers.parse_angle(value, ReadOptions()) if isinstance(value, str) else as_number(value)
            return numbers.check_degrees(degrees, limit)

        return self._parsed(key, parse)

    def number_list(self, key: str, count: int, low: float, high: float, unit: str = "") -> tuple[float, ...] | None:
        """A list of so many numbers."""
        value = self.value(key)
        if value is None:
            return None
        if not isinstance(value, list) or len(value) != count:
            self.problem(key, f"{shown(key)}: expected a list of {count} numbers")
            return None
        try:
            return tuple(numbers.check_range(as_number(each), low, high, unit) for each in value)
        except BadValue as bad:
            self.problem(key, f"{shown(key)}: {bad.message}", bad.hint)
            return None

    def word(self, key: str, choices: tuple[str, ...]) -> str | None:
        value = self.text(key)
        if value is None or value in choices:
            return value
        self.problem(key, f'{key}: "{shown(value)}" is not one of {", ".join(choices)}')
        return None

    def text(self, key: str) -> str | None:
        """A line of text without control characters."""
        value = self.value(key)
        if value is None:
            return None
        if not isinstance(value, str):
            self.problem(key, f"{shown(key)}: expected text, got {_type_word(value)}")
        elif not value.strip() or len(value) > LONGEST_TEXT:
            self.problem(key, f"{shown(key)}: expected 1 to {LONGEST_TEXT} characters")
        elif shown(value[:1]) != value[:1] or any(shown(character) != character for character in value):
            self.problem(key, f'{shown(key)}: "{shown(value)}" contains a control or hidden character')
        else:
            return value
        return None

    def finish(self) -> None:
        """Names every key that nobody asked for."""
        for key in self.data:
            if self._findings.too_many(self.file):
                self._findings.stop(self.file, self.line_of(key))
                return
            if key not in self._asked:
                self.problem(key, f'unknown key "{shown(key)}"', nearest(key, self._asked))

    def line_of(self, key: str) -> int:
        """The line of the key, or else of the deepest table around it that is written out; 0 when none is."""
        path = (*self.path, key) if key else self.path
        return next((self._lines[path[:n]] for n in range(len(path), 0, -1) if path[:n] in self._lines), 0)

    def _parsed(self, key: str, parse: Callable[[object], T]) -> T | None:
        value = self.value(key)
        if value is None:
            return None
        try:
            return parse(value)
        except BadValue as bad:
            self.problem(key, f"{shown(key)}: {bad.message}", bad.hint)
            return None


def read_toml(path: Path, file: str, options: ReadOptions, findings: Findings) -> Section | None:
    """The file as one section, or None when it cannot be read."""
    text = toml_text(path, file, ReadOptions(encoding=options.encoding), findings)
    if text is None:
        return None
    if deep := MANY_PARTS.search(text):
        findings.problem(file, text.count("\n", 0, deep.start()) + 1, "nested too deeply")
        return None
    try:
        return Section(file, _lines_of_keys(text), tomllib.loads(text), findings)
    except tomllib.TOMLDecodeError as error:
        line, message = _decode_complaint(str(error), text)
    except RecursionError:
        line, message = 0, "nested too deeply"
    except ValueError as error:
        line, message = _value_complaint(error, text)
    findings.problem(file, line, message)
    return None


def as_number(value: object) -> float:
    """A finite float; TOML also knows nan and inf, and integers of any length."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadValue(f"expected a number, got {_type_word(value)}")
    try:
        number = float(value)
    except OverflowError:
        raise BadValue("number is too large") from None
    if not math.isfinite(number):
        raise BadValue("must be a finite number")
    return number + 0.0


def _type_word(value: object, whole: bool = False) -> str:
    if whole and isinstance(value, float):
        return "a number with a fraction" if math.isfinite(value) else "no finite number"
    return next(words for kind, words in TYPE_WORDS if isinstance(value, kind))


def _decode_complaint(message: str, text: str) -> tuple[int, str]:
    place = PLACE.search(message)
    line = int(place[1]) if place and place[1] else text.count("\n")
    what = PLACE.sub("", message)
    found = text.split("\n")[line - 1] if line else ""
    if what == "Cannot overwrite a value":
        return line, f'key "{shown(found.partition("=")[0].strip())}" given twice'
    if "Cannot declare" in what:
        return line, f"table {shown(found.strip())} given twice"
    if "Invalid date" in what:
        return line, "not a date"
    return line, f"not valid TOML: {shown(what)}"


def _value_complaint(error: ValueError, text: str) -> tuple[int, str]:
    """tomllib passes on what int() says of more than 4300 digits, and what date() says of 31 February."""
    if long := LONG_INTEGER.search(text):
        return text.count("\n", 0, long.start()) + 1, "not a number: more than 4,300 digits"
    return 0, f"not valid TOML: {shown(str(error))}"


def _lines_of_keys(text: str) -> dict[KeyPath, int]:
    """The line where each key and each table is first written; tomllib does not tell."""
    lines: dict[KeyPath, int] = {}
    table: KeyPath = ()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := TABLE_HEADER.match(line):
            table = _key_parts(header[1])
            lines.setdefault(table, number)
        elif assignment := ASSIGNMENT.match(line):
            lines.setdefault((*table, *_key_parts(assignment[1])), number)
    return lines


def _key_parts(text: str) -> KeyPath:
    return tuple(bare or double or single for bare, double, single in KEY_PART.findall(text))
