"""The answer to a question as columns: arrays by name, a data frame on request."""

import html
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orient.errors import NotInstalled, UsageError

if TYPE_CHECKING:
    import pandas

SHOWN = 20
DIGITS = ".7g"


class Table(Mapping[str, NDArray[Any]]):
    """Columns by name, all of one length: `table["vx_mm"]`.

    Numbers are float64, NULL is NaN; whole numbers without NULL are int64; text is of dtype object, NULL is None.
    """

    def __init__(self, names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
        self._columns = {name: _column([row[i] for row in rows]) for i, name in enumerate(names)}
        self._length = len(rows)

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._columns:
            raise UsageError(f'there is no column "{name}"', f"Columns are {', '.join(self._columns)}.")
        return self._columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        """Number of columns, as of any mapping; `rows` is the number of rows."""
        return len(self._columns)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self._length

    def array(self, *names: str) -> NDArray[np.float64]:
        """(rows, k) float64 of the named columns of numbers, side by side."""
        columns = [self[name] for name in names]
        for name, column in zip(names, columns, strict=True):
            if column.dtype == object:
                raise UsageError(f'the column "{name}" holds text')
        return np.column_stack(columns).astype(np.float64) if columns else np.empty((self._length, 0))

    def where(self, **values: object) -> "Table":
        """The rows in which each named column has the given value: `table.where(role="check")`."""
        keep = np.ones(self._length, dtype=bool)
        for name, value in values.items():
            keep &= self[name] == value
        chosen = [self._columns[name][keep].tolist() for name in self]
        return Table(list(self), list(zip(*chosen, strict=True)))

    def frame(self) -> "pandas.DataFrame":
        """As a data frame of pandas, which must be installed: pip install 'orient[frames]'."""
        try:
            import pandas
        except ImportError:
            raise NotInstalled("a data frame needs", ["pandas"], "frames") from None
        return pandas.DataFrame(self._columns)

    def __repr__(self) -> str:
        return f"Table({self._length} rows: {', '.join(self)})"

    def _repr_html_(self) -> str:
        """For notebooks: the first rows."""
        shown = min(self._length, SHOWN)
        head = "".join(f"<th>{html.escape(name)}</th>" for name in self)
        body = "".join(
            f"<tr>{''.join(f'<td>{_cell(self._columns[name][i])}</td>' for name in self)}</tr>" for i in range(shown)
        )
        more = f"<p>{self._length} rows, the first {shown}</p>" if shown < self._length else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def _column(values: list[Any]) -> NDArray[Any]:
    """One column; a column of nothing but NULL is NaN."""
    kinds = {type(value) for value in values if value is not None}
    if kinds == {int} and None not in values:
        return np.array(values, dtype=np.int64)
    if kinds <= {int, float}:
        return np.array([math.nan if value is None else value for value in values], dtype=np.float64)
    column = np.empty(len(values), dtype=object)
    column[:] = values
    return column


def _cell(value: Any) -> str:
    text = format(value, DIGITS) if isinstance(value, float) else str(value)
    return html.escape(text)
