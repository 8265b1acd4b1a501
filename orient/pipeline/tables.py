"""Rows of the project file to arrays and back; the one place where None becomes NaN and NumPy scalars become floats."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orient.errors import OrientError
from orient.solvers.packed import pack_upper, packed_pairs
from orient.values import Columns, Row, Scalar, Tables, as_list

Array = NDArray[np.float64]
COVARIANCE_PARTS = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
UPPER_3 = np.triu_indices(3)


def columns(rows: Sequence[Row], *names: str) -> Array:
    """The named columns as an (n, k) array; NULL becomes NaN."""
    if isinstance(rows, Columns):
        values = np.empty((len(rows), len(names)))
        for place, name in enumerate(names):
            values[:, place] = _floats(rows.by_name[name])
        return values
    cells = [[np.nan if row[name] is None else row[name] for name in names] for row in rows]
    return np.array(cells, dtype=np.float64).reshape(len(rows), len(names))


def _floats(values: Any) -> Array:
    """A column as floats; what is not known becomes NaN."""
    if isinstance(values, np.ma.MaskedArray):
        return np.asarray(values.filled(np.nan))
    return np.array(values, dtype=np.float64)


def nullable(values: Array) -> Any:
    """A column of floats in which what is not finite is not known; by column as `or_none` by value."""
    return values if np.isfinite(values).all() else np.ma.masked_invalid(values)


def by_names(names: Sequence[str], values: Array) -> dict[str, Array]:
    """Columns of the parts (n, k) of a vector, one for each of the k names."""
    return dict(zip(names, values.T, strict=True))


def named(keys: Sequence[str], values: Array) -> dict[str, float]:
    """Columns with the values of an array."""
    return dict(zip(keys, (float(value) for value in values), strict=True))


def joined(parts: Sequence[Mapping[str, Any]]) -> Columns:
    """One table from parts of it by column, all with the same names."""
    return Columns({name: _end_to_end([part[name] for part in parts]) for name in parts[0]})


def _end_to_end(parts: Sequence[Any]) -> Any:
    if len(parts) == 1:
        return parts[0]
    if all(isinstance(part, np.ndarray) for part in parts):
        return np.ma.concatenate(parts)  # type: ignore[no-untyped-call]
    return [value for part in parts for value in as_list(part)]


def rows_at(rows: Sequence[Row], places: Sequence[int]) -> Sequence[Row]:
    """The rows at these places, by column if they are kept so."""
    return rows.at(places) if isinstance(rows, Columns) else [rows[place] for place in places]


def names(rows: Sequence[Row], column: str = "point") -> list[str]:
    if isinstance(rows, Columns):
        return [str(value) for value in as_list(rows.by_name[column])]
    return [str(row[column]) for row in rows]


def single(tables: Tables, table: str) -> Row:
    """The only row of a table that has one row per run."""
    rows = tables.get(table, ())
    if len(rows) != 1:
        raise OrientError(f"{table} holds {len(rows)} rows where one was expected")
    return rows[0]


def number(row: Row, name: str) -> float | None:
    value = row[name]
    return None if value is None else float(value)


def required(row: Row, name: str) -> float:
    value = number(row, name)
    if value is None:
        raise OrientError(f"{name} is missing")
    return value


def or_none(value: float | None) -> float | None:
    """A finite float, or None for what is not known."""
    return None if value is None or not np.isfinite(value) else float(value)


def covariances(rows: Sequence[Row], prefix: str = "cov_", suffix: str = "_m2") -> Array:
    """(n, 3, 3) covariances from their six columns; rows without one are NaN."""
    packed = columns(rows, *(f"{prefix}{part}{suffix}" for part in COVARIANCE_PARTS))
    full = np.empty((len(rows), 3, 3))
    full[:, UPPER_3[0], UPPER_3[1]] = packed
    full[:, UPPER_3[1], UPPER_3[0]] = packed
    return full


def covariance_columns(matrix: Array | None, prefix: str = "cov_", suffix: str = "_m2") -> dict[str, float | None]:
    """The six columns of a 3 x 3 covariance; None stands for a point taken as known."""
    packed: Iterable[float | None] = [None] * 6 if matrix is None else matrix[UPPER_3]
    return {f"{prefix}{part}{suffix}": or_none(value) for part, value in zip(COVARIANCE_PARTS, packed, strict=True)}


def group(rows: Sequence[Row], column: str) -> dict[str, list[Row]]:
    """Rows by the value of a column, in order of appearance."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(str(row[column]), []).append(row)
    return groups


def packed_rows(matrix: Array) -> list[dict[str, Scalar]]:
    """The upper triangle as rows with IJ, i, j from 1 (seed 000, equation (10)) and the value."""
    pairs, values = packed_pairs(len(matrix)), pack_upper(matrix).tolist()
    return [
        {"IJ": IJ, "i": i, "j": j, "value": value}
        for IJ, ((i, j), value) in enumerate(zip(pairs, values, strict=True), 1)
    ]


def named_packed_rows(matrix: Array, unknowns: Sequence[str]) -> list[dict[str, Scalar]]:
    """`packed_rows` with the names of the unknowns of row and column."""
    rows, pairs = packed_rows(matrix), combinations_with_replacement(unknowns, 2)
    return [{**row, "unknown_i": i, "unknown_j": j} for row, (i, j) in zip(rows, pairs, strict=True)]
