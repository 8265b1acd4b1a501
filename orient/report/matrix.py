"""Matrices as plain text: columns in blocks that fit the line, every number with so many significant digits."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

GAP = 2
SIGNS = 6
"""Sign, point and exponent of a number beside its digits."""


def matrix_lines(
    rows: Sequence[str],
    columns: Sequence[str],
    values: NDArray[np.float64],
    digits: int,
    width: int,
    *,
    is_triangle: bool = False,
) -> Iterator[str]:
    """`values` (rows, columns) in blocks of columns; of a triangle what lies below the diagonal stays empty.

    In a triangle the last row belongs to the last column, so that it may have fewer rows than columns.
    """
    cell = max(digits + SIGNS + 1, *(len(name) for name in columns)) + GAP
    label = max(len(name) for name in rows)
    at_once = max((width - label) // cell, 1)
    first = len(columns) - len(rows)
    for start in range(0, len(columns), at_once):
        part = range(start, min(start + at_once, len(columns)))
        if start:
            yield ""
        yield " " * label + "".join(f"{columns[j]:>{cell}}" for j in part)
        for i, name in enumerate(rows):
            shown = ["" if is_triangle and j < i + first else f"{values[i, j]:.{digits}g}" for j in part]
            if any(shown):
                yield f"{name:<{label}}" + "".join(f"{text:>{cell}}" for text in shown)
