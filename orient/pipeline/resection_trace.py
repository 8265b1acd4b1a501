"""How a resection went: iterations, equations and the coefficients of the sheets, as rows of the project file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry.rotation import aok_from_matrix, quaternion_from_matrix, rotation_exp
from orient.pipeline.camera import unit_of
from orient.pipeline.common_coefficients import CommonCoefficients
from orient.pipeline.frames import Frame
from orient.pipeline.resection_rows import ANGLES_AOK, QUATERNION, STATION, Rows
from orient.pipeline.tables import Array, named
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.resection import IterationRecord, Resection
from orient.units import wrap_half_turn
from orient.values import Columns, Row

NOTHING = np.zeros(0)


@dataclass(frozen=True, slots=True)
class NamedUnknown:
    """A common unknown as `iteration_parameter` tells it: the sheet or the interior orientation, and its value."""

    subject: str
    name: str
    unit: str
    value: float


def trace_tables(
    found: Resection,
    frame: Frame,
    points: Sequence[str],
    interior: CameraUnknowns | None = None,
    common: Sequence[NamedUnknown] = (),
) -> Mapping[str, Sequence[Row]]:
    """Iterations and equations: stored for a failure too."""
    return {
        "iteration": [_iteration_row(number, record) for number, record in enumerate(found.iterations, 1)],
        "iteration_parameter": _parameter_rows(found, frame, points, interior, common),
        "equation": _equation_rows(found, frame, points),
        "camera_equation": _camera_equation_rows(found, points),
    }


def adjusted_coefficient_rows(
    corrections: Array, cofactors: Array, shared: CommonCoefficients | None, sigma0: float
) -> Rows:
    """The polynomials of the sheets after the adjustment, with what the photo has added to them; (k,) of each."""
    if shared is None:
        return []
    before = np.diagonal(shared.covariance) / sigma0**2
    ratios = np.where(before > 0, cofactors / np.where(before > 0, before, 1.0), 1.0)
    return [
        {
            "sheet": one.sheet,
            "coordinate": one.coordinate,
            "power_u": one.power_u,
            "power_v": one.power_v,
            "value": one.value + float(corrections[index]),
            "correction": float(corrections[index]),
            "q": float(cofactors[index]),
            "variance_ratio": float(ratios[index]),
        }
        for index, one in enumerate(shared.coefficients)
    ]


def _iteration_row(number: int, record: IterationRecord) -> Row:
    return {
        "iteration": number,
        "vPv": float(record.vPv),
        "max_scaled_step": float(record.max_scaled_step),
        "damping": float(record.damping),
        **named(QUATERNION, quaternion_from_matrix(record.rotation)),
    }


def _parameter_rows(
    found: Resection,
    frame: Frame,
    points: Sequence[str],
    interior: CameraUnknowns | None,
    common: Sequence[NamedUnknown],
) -> Sequence[Row]:
    parts: list[_Unknowns] = []
    camera = found.unknowns[6:]
    units = [] if interior is None else [unit_of(name, interior.camera) for name in camera]
    for number, record in enumerate(found.iterations, 1):
        before = aok_from_matrix(record.rotation)
        after = aok_from_matrix(rotation_exp(record.correction_rotation) @ record.rotation)
        steps = [wrap_half_turn(float(new - old)) for old, new in zip(before, after, strict=True)]
        parts.append(_Unknowns(number, [""], ANGLES_AOK, "rad", np.array(before), np.array(steps)))
        station, step = frame.right_handed(record.station), frame.right_handed(record.correction_station)
        parts.append(_Unknowns(number, [""], STATION, "m", station, step))
        for k, (name, unit) in enumerate(zip(camera, units, strict=True)):
            parts.append(_Unknowns(number, [""], (name,), unit, record.camera[k], record.correction_camera[k]))
        if record.ground is not None and record.correction_ground is not None:
            places, moves = frame.right_handed(record.ground), frame.right_handed(record.correction_ground)
            parts.append(_Unknowns(number, points, ("X", "Y", "Z"), "m", places, moves))
        for one, before_step, step_of_c in zip(common, record.common, record.correction_common, strict=True):
            parts.append(_Unknowns(number, [one.subject], (one.name,), one.unit, one.value + before_step, step_of_c))
    return _parameter_columns(parts)


@dataclass(frozen=True, slots=True)
class _Unknowns:
    """Unknowns of one iteration: those named of each subject, with their approximations and corrections (s, u)."""

    iteration: int
    subjects: Sequence[str]
    names: Sequence[str]
    unit: str
    approximations: Array | float
    corrections: Array | float

    def __len__(self) -> int:
        return len(self.subjects) * len(self.names)


def _parameter_columns(parts: Sequence[_Unknowns]) -> Columns:
    return Columns(
        {
            "iteration": [part.iteration for part in parts for _ in range(len(part))],
            "point": [subject for part in parts for subject in part.subjects for _ in part.names],
            "unknown": [name for part in parts for _ in part.subjects for name in part.names],
            "unit": [part.unit for part in parts for _ in range(len(part))],
            "approximation": np.concatenate([NOTHING, *(np.ravel(part.approximations) for part in parts)]),
            "correction": np.concatenate([NOTHING, *(np.ravel(part.corrections) for part in parts)]),
        }
    )


def _equation_rows(found: Resection, frame: Frame, points: Sequence[str]) -> Columns:
    coefficients = np.array(found.equations, copy=True)
    coefficients[:, :, 3:6] = frame.right_handed(found.equations[:, :, 3:6])
    coefficients[:, :, 6:9] = frame.right_handed(found.equations[:, :, 6:9])
    return Columns(
        {
            "point": [point for point in points for _ in "xy"],
            "axis": ["x", "y"] * len(points),
            **{f"a{k + 1}": np.ravel(coefficients[:, :, k]) for k in range(9)},
            "l_mm": np.ravel(found.free_terms),
        }
    )


def _camera_equation_rows(found: Resection, points: Sequence[str]) -> Rows:
    return [
        {"point": point, "axis": axis, "unknown": name, "coefficient": float(found.camera_equations[i, j, k])}
        for i, point in enumerate(points)
        for j, axis in enumerate("xy")
        for k, name in enumerate(found.unknowns[6:])
    ]
