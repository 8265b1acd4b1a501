"""What the other program must see: computed image coordinates of the stored adjustment, from its own tables alone."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import matrix_from_quaternion
from tests.cli.commands import orient

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stored:
    """Rows of the current resection and refine as `orient sql --json` gives them."""

    residuals: dict[str, dict[str, float]]
    orientation: dict[str, float]
    photo: dict[str, float]


def stored(path: Path) -> Stored:
    residuals = rows(path, "SELECT * FROM image_residual WHERE run_id = {resection}")
    return Stored(
        {str(row["point"]): row for row in residuals},
        rows(path, "SELECT * FROM orientation WHERE run_id = {resection}")[0],
        rows(path, "SELECT * FROM photo WHERE run_id = {photo}")[0],
    )


def rows(path: Path, sql: str) -> list[dict[str, float]]:
    heads = {row["stage"]: row["run_id"] for row in json.loads(orient("sql", path, "current", "--json").out)}
    answer: list[dict[str, float]] = json.loads(orient("sql", path, sql.format(**heads), "--json").out)
    return answer


def by_collinearity(quaternion: Array, station: Array, f_mm: float, ground: Array) -> Array:
    """x = -f xs/zs, y = -f ys/zs (n, 2) [mm], written out once more."""
    seen = (ground - station) @ matrix_from_quaternion(quaternion)
    return np.asarray(-f_mm * seen[:, :2] / seen[:, 2:])
