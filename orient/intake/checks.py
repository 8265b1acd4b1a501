"""Checks over the rows of a list: given twice, all in one place, weights that span too much."""

from collections.abc import Hashable, Sequence

from orient import units
from orient.intake.cells import CellReader
from orient.intake.findings import Findings, shown
from orient.values import Row

WIDEST_SIGMA_RATIO = 1e9
LISTED_NAMES = 10


class Places:
    """Where each key of a list was first given, so that a second time names both lines."""

    def __init__(self) -> None:
        self._first: dict[Hashable, tuple[str, int]] = {}

    def is_new(self, cells: CellReader, key: Hashable, called: str) -> bool:
        file, line = self._first.setdefault(key, (cells.file, cells.line))
        if (file, line) == (cells.file, cells.line):
            return True
        place = f"line {line}" if file == cells.file else f"{file}:{line}"
        cells.problem(f"{called} was already given in {place}")
        return False


def check_apart(file: str, rows: Sequence[Row], name: str, columns: Sequence[str], findings: Findings) -> None:
    """Two or more points of a list that all lie in one place are a slip of the file, not a measurement."""
    if len({row[name] for row in rows}) < 2:
        return
    first = [rows[0][column] for column in columns]
    if all([row[column] for column in columns] == first for row in rows):
        findings.problem(file, 0, "all points coincide")


def check_weights(file: str, rows: Sequence[Row], columns: Sequence[str], findings: Findings, power: int = 1) -> None:
    """Standard deviations (power 1) or variances (2) that differ by 1e9 in the standard deviation: a warning."""
    values = [value for row in rows for column in columns if isinstance(value := row[column], float) and value > 0]
    if not values:
        return
    ratio = float((max(values) / min(values)) ** (1 / power))
    if ratio >= WIDEST_SIGMA_RATIO:
        orders = len(f"{ratio * ratio:.0f}") - 1
        message = f"{file}: the largest sigma is {ratio:.1e} times the smallest: the weights span {orders} orders"
        findings.warn("weights_span", "", message, ratio)


def listed(names: Sequence[str]) -> str:
    """`A, B, C and 7 more`."""
    return units.listed([shown(name) for name in names], LISTED_NAMES)
