"""What a resection tried and where that led, as rows of the project file: stored for a failure too."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from orient.geometry.rotation import quaternion_from_matrix
from orient.pipeline.frames import Frame
from orient.pipeline.resection_rows import QUATERNION
from orient.pipeline.tables import Array, by_names, named
from orient.solvers.resection import Resection
from orient.solvers.resection_result import End
from orient.values import Columns, Row

STATION_M = ("X_S_m", "Y_S_m", "Z_S_m")
LARGEST = 1e15


def start_tables(
    found: Resection, frame: Frame, points: Sequence[str], full: Sequence[int], ground: Array
) -> Mapping[str, Sequence[Row]]:
    """`full`: indices of the points that starts come from; `ground` (n, 3): given, in the stored frame."""
    return {
        "start_candidate": _candidate_rows(found, frame, [points[i] for i in full], ground[full]),
        "resection_solution": [_solution_row(number, end, frame, ground) for number, end in enumerate(found.ends, 1)],
    }


def _candidate_rows(found: Resection, frame: Frame, points: Sequence[str], ground: Array) -> Columns:
    candidates = [start.candidate for start in found.starts]
    stations = frame.right_handed(np.array([one.station for one in candidates]).reshape(-1, 3))
    quaternions = np.array([quaternion_from_matrix(one.rotation) for one in candidates]).reshape(-1, 4)
    return Columns(
        {
            "candidate": list(range(1, len(candidates) + 1)),
            "method": [one.method.value for one in candidates],
            "is_reversed": [int(one.is_reversed) for one in candidates],
            "points": [", ".join(points[i] for i in one.triple) for one in candidates],
            **by_names(STATION_M, stations),
            **by_names(QUATERNION, quaternions),
            "rms_mm": [_storable(one.rms_mm) for one in candidates],
            "n_points": [len(points)] * len(candidates),
            "n_in_front": [one.n_in_front for one in candidates],
            "height_above_m": stations[:, 2] - float(ground[:, 2].mean()),
            "solution": [None if start.end is None else start.end + 1 for start in found.starts],
        }
    )


def _solution_row(number: int, end: End, frame: Frame, ground: Array) -> Row:
    station = frame.right_handed(end.station)
    is_place = bool(np.all(np.abs(station) < LARGEST)) and bool(np.isfinite(end.rotation).all())
    quaternion = quaternion_from_matrix(end.rotation) if is_place else np.full(4, np.nan)
    return {
        "solution": number,
        "termination": end.termination.value,
        "is_as_good": int(end.is_as_good),
        **(named(STATION_M, station) if is_place else dict.fromkeys(STATION_M)),
        **(named(QUATERNION, quaternion) if is_place else dict.fromkeys(QUATERNION)),
        "vPv": _storable(end.vPv),
        "n_points": len(ground),
        "n_in_front": end.n_in_front,
        "height_above_m": float(station[2] - ground[:, 2].mean()) if is_place else None,
        "iterations": end.iterations,
    }


def _storable(value: float) -> float | None:
    """NULL for what the file cannot hold: infinite, or overflown."""
    return float(value) if math.isfinite(value) and abs(value) < LARGEST else None
