"""What stands beside a CSV file: its columns, where it comes from, and the 6 x 6 covariance (W3C tabular metadata)."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from orient.export.solved import Solved, ground_frame, provenance
from orient.pipeline.tables import Array
from orient.values import Scalar

BESIDE = "-metadata.json"
"""Added to the name of a CSV file: where readers of the W3C's metadata look."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a CSV file: name, meaning, unit."""

    name: str
    meaning: str
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns with their meaning, the rows, and the covariance (6, 6) of the parameters beside them.

    `rows` can be gone through more than once. `axes`: what X, Y, Z mean; `covariance` is None near the blind view of
    the angles.
    """

    columns: Sequence[Column]
    rows: Iterable[Sequence[Scalar]]
    axes: str
    parameters: Sequence[str]
    units: Sequence[str]
    covariance: Array | None


def metadata(solved: Solved, table: Table, name: str, digest: str) -> bytes:
    """The metadata as JSON; `name` and `digest` (sha256) of the CSV file that they belong to."""
    content = {
        "@context": "http://www.w3.org/ns/csvw",
        "url": name,
        "dialect": {"encoding": "utf-8", "lineTerminators": ["\r\n"], "header": True},
        "tableSchema": {"columns": [_described(column) for column in table.columns]},
        "orient:sha256": digest,
        "orient:formula_guard": "a text that begins like a formula has an apostrophe in front",
        "orient:covariance": covariance_block(table.parameters, table.units, table.covariance),
        "orient:ground_frame": ground_frame(solved),
        "orient:source": provenance(solved, table.axes),
    }
    return (json.dumps(content, ensure_ascii=False, allow_nan=False, indent=1) + "\n").encode("utf-8")


def covariance_block(parameters: Sequence[str], units: Sequence[str], covariance: Array | None) -> dict[str, object]:
    """Order and units of the parameters with the full matrix; None near the blind view of the angles."""
    return {
        "parameters": list(parameters),
        "units": list(units),
        "matrix": None if covariance is None else covariance.tolist(),
    }


def _described(column: Column) -> dict[str, str]:
    described = {"name": column.name, "titles": column.name, "dc:description": column.meaning}
    return described | ({"orient:unit": column.unit} if column.unit else {})
