"""How large a number is by nature: what 1e-9 refers to when a difference of two large numbers is compared.

A residual near zero is a difference of image coordinates, X_S near zero one of three axes, a covariance belongs to two
variances. Values of one table that differ only by their axis or are differences of each other share one scale.
"""

import re
from collections.abc import Sequence

from orient.units import DEGREES_PER_RADIAN
from orient.values import Row

GROUPS = ("sheet", "unit", "unknowns", "name", "source", "zone")
"""Columns that keep values of different units apart within a table."""
DIFFERENCE = re.compile(r"^[vd]_?(?=[xyXYZNEl])")
AXIS = re.compile(r"(?<![a-z])[xyXYZNE](?![a-z])|(?<=[XYZNE])[XYZNE]|(?<=[xy])[xy]")
UNKNOWN = {"approximation", "correction", "value"}
SPREAD = ("sigma", "ellipse", "cov", "K_", "reading_", "height_", "q_")
FLOORS = {"vPv": 1e-6, "variance_scale": 1e-6, "sigma0_mm": 1e-3}
"""Perfect data leave rounding: a squared micrometre, a micrometre."""
PLAIN = {"focal_sum", "statistic", "probability", "redundancy_number", "redundancy_x", "redundancy_y",
         "max_scaled_step", "damping", "q_w", "q_x", "q_y", "q_z", "up_X", "up_Y", "up_Z"}  # fmt: skip
"""Numbers of the order of one."""
UNIT_FLOORS = {"_mm": 1.0, "_m": 1.0, "_deg": DEGREES_PER_RADIAN}


class Scales:
    """Scales of the numbers of one table."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self._largest: dict[tuple[object, ...], float] = {}
        self._diagonal: dict[tuple[object, ...], float] = {}
        for row in rows:
            group = _group(row)
            if "i" in row and "value" in row and row["i"] == row["j"]:
                self._diagonal[(*group, row["i"])] = abs(float(row["value"] or 0.0))
            for column, value in row.items():
                if isinstance(value, float):
                    family = (*group, _family(column))
                    self._largest[family] = max(self._largest.get(family, 0.0), abs(value))

    def of(self, row: Row, column: str) -> float:
        """Scale of a number; 0 if nothing larger than zero is near it."""
        group = _group(row)
        if "i" in row and column == "value":
            q_i, q_j = (self._diagonal.get((*group, row[index]), 0.0) for index in ("i", "j"))
            return float((q_i * q_j) ** 0.5)
        return max(self._largest.get((*group, _family(column)), 0.0), _floor(column))


def _group(row: Row) -> tuple[object, ...]:
    return tuple(row.get(column) for column in GROUPS)


def _family(column: str) -> str:
    """x_mm and vx_mm are of one family, so are X_S_m, Y_S_m and Z_S_m."""
    return "unknown" if column in UNKNOWN else AXIS.sub("*", DIFFERENCE.sub("", column))


def _floor(column: str) -> float:
    if column in FLOORS or column in PLAIN:
        return FLOORS.get(column, 1.0)
    if column.startswith(SPREAD):
        return 0.0
    return next((floor for unit, floor in UNIT_FLOORS.items() if column.endswith(unit)), 0.0)
