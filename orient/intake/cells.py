"""The cells of one record as values."""

from collections.abc import Callable
from typing import TypeVar

from orient.intake import numbers
from orient.intake.csv_table import Record
from orient.intake.findings import BadValue, Findings, shown
from orient.intake.names import NameRegister
from orient.intake.options import ReadOptions

COORDINATE_LIMIT_M = 1e8
LOWEST_M, HIGHEST_M = -12_000.0, 1_000_000.0

T = TypeVar("T")


class CellReader:
    """Reads the cells of one line. A cell that cannot be taken becomes a problem, and `ok` turns False.

    A column that is not there and a cell that is empty both give None, unless `required`.
    """

    def __init__(self, file: str, record: Record, options: ReadOptions, findings: Findings) -> None:
        self.file = file
        self.line = record.line
        self.ok = True
        self._cells = record.cells
        self._options = options
        self._findings = findings

    def has(self, column: str) -> bool:
        return bool(self._cells.get(column, "").strip())

    def problem(self, message: str, hint: str = "") -> None:
        self.ok = False
        self._findings.problem(self.file, self.line, message, hint)

    def name(self, column: str, register: NameRegister) -> str:
        """The name, or an empty text when it is not one."""
        return self._value(column, lambda text: register.add(text, self.line), True) or ""

    def number(self, column: str, limit: float = COORDINATE_LIMIT_M, required: bool = False) -> float | None:
        return self.number_in(column, -limit, limit, required)

    def height(self, column: str, required: bool = False) -> float | None:
        return self.number_in(column, LOWEST_M, HIGHEST_M, required)

    def number_in(self, column: str, low: float, high: float, required: bool = False) -> float | None:
        def parse(text: str) -> float:
            return numbers.check_range(numbers.parse_number(text, self._options), low, high)

        return self._value(column, parse, required)

    def sigma(self, column: str, hint: str = "") -> float | None:
        def parse(text: str) -> float:
            return numbers.check_sigma(numbers.parse_number(text, self._options), hint)

        return self._value(column, parse, False)

    def latitude(self, column: str, required: bool = False) -> float | None:
        def parse(text: str) -> float:
            return numbers.check_degrees(numbers.parse_angle(text, self._options), 90)

        return self._value(column, parse, required)

    def longitude(self, column: str, required: bool = False) -> float | None:
        def parse(text: str) -> float:
            degrees = numbers.check_degrees(numbers.parse_angle(text, self._options), 360)
            return numbers.east_of_half_turn(degrees)

        return self._value(column, parse, required)

    def cycle(self, column: str = "cycle") -> int:
        """The number of the cycle; 1 when nothing is said."""
        return self._value(column, lambda text: numbers.parse_whole(text, 1, 1_000_000), False) or 1

    def word(self, column: str, choices: tuple[str, ...]) -> str:
        """One of the words; the first when nothing is said."""

        def parse(text: str) -> str:
            if text.strip() not in choices:
                raise BadValue(f'"{shown(text)}" is not one of {", ".join(choices)}')
            return text.strip()

        return self._value(column, parse, False) or choices[0]

    def _value(self, column: str, parse: Callable[[str], T], required: bool) -> T | None:
        text = self._cells.get(column, "")
        if not text.strip() and not required:
            return None
        try:
            return parse(text)
        except BadValue as bad:
            self.problem(f'column "{column}": {bad.message}', bad.hint)
            return None
