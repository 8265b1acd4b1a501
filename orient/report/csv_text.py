"""CSV by RFC 4180: numbers in the shortest form that reads back, no cell that a spreadsheet takes for a formula."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence

from orient.values import Scalar

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
AT_ONCE = 1000


def csv_pieces(columns: Sequence[str], rows: Iterable[Sequence[Scalar]], raw: bool = False) -> Iterator[str]:
    """The table in pieces of many lines; `raw` leaves texts that begin like a formula as they are."""
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\r\n")
    writer.writerow(columns)
    for count, row in enumerate(rows, 1):
        writer.writerow([value if raw else guarded(value) for value in row])
        if count % AT_ONCE == 0:
            yield stream.getvalue()
            stream.seek(0)
            stream.truncate()
    yield stream.getvalue()


def guarded(value: Scalar) -> Scalar:
    """A spreadsheet must not take a name for a formula."""
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA_STARTS) else value
