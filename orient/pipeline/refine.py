"""Stage `refine`: from comparator or pixel readings to image coordinates, every correction in its own column.

Order: mean of the cycles -> interior orientation -> principal point -> lens distortion -> refraction -> earth curvature
(only for control on a map plane).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orient.errors import OrientError
from orient.geometry import plane
from orient.pipeline.image_corrections import image_corrections
from orient.pipeline.tables import Array, columns, named_packed_rows, number, or_none, required, single
from orient.solvers.cycle_means import CycleMeans, cycle_means
from orient.solvers.engines import Engine
from orient.solvers.interior_orientation import InteriorFit, fit_interior
from orient.values import Event, Outcome, Row, Settings, Tables
from orient.words import counted

STEP_MM = 1e-3
MICROMETRES = 1000.0
FIDUCIAL = "fiducial"
MARK_LIMIT = 10.0
"""Residual of a fiducial mark, in sigmas of a reading, that is said to be wrong."""


@dataclass(frozen=True, slots=True)
class Means:
    """Mean readings of the points or marks of one kind, in mm of the comparator."""

    points: Sequence[str]
    xy: Array
    n_cycles: Array
    sigma_cycles: Array
    covariance: Array


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with `image_point`, cycle residuals and the interior orientation."""
    photo_tables = inputs["photo"]
    photo = single(photo_tables, "photo")
    readings = inputs["readings"]["comparator_reading"]
    xy, sigma = readings_in_mm(readings, photo)
    by_kind = [f"{row['kind']} {row['point']}" for row in readings]
    cycles = cycle_means(by_kind, xy, reject=bool(settings["reject"]))
    events = _cycle_events(readings, cycles, xy, required(photo, "sigma_image_mm"))
    marks, points = (_means_of(kind, readings, cycles, sigma) for kind in (FIDUCIAL, "point"))
    if not points.points:
        raise OrientError("the readings contain no point", 'Add rows with kind = "point" to readings.csv.')
    engine = Engine(str(settings["engine"]))
    interior, chosen = _interior(photo, photo_tables.get("fiducial_mark", ()), marks, engine, events)
    rows = _image_points(points, interior, photo, photo_tables)
    events += _curvature_event(rows, photo)
    residuals = _cycle_rows(readings, cycles)
    of_marks = _mark_variance(marks, chosen)
    tables = {"image_point": rows, "cycle_residual": residuals, **_interior_tables(interior, chosen, of_marks)}
    return Outcome(tables, events, _summary(rows, cycles, interior))


def readings_in_mm(readings: Sequence[Row], photo: Row) -> tuple[Array, Array]:
    """(n, 2) readings and (n,) standard deviations in mm; pixels become mm of the frame."""
    apriori = required(photo, "sigma_image_mm")
    xy = columns(readings, "x_mm", "y_mm")
    sigma = columns(readings, "sigma")[:, 0]
    in_pixels = np.isnan(xy[:, 0])
    if in_pixels.any():
        pixels, size = columns(readings, "col_px", "row_px"), required(photo, "pixel_size_mm")
        xy = np.where(in_pixels[:, None], mm_from_pixels(pixels, photo), xy)
        sigma = np.where(in_pixels, sigma * size, sigma)
    return xy, np.where(np.isnan(sigma), apriori, sigma)


def mm_from_pixels(pixels: Array, photo: Row) -> Array:
    """(n, 2) mm of the frame from columns and rows (n, 2)."""
    origin, step = pixel_grid(photo)
    return np.asarray((pixels - origin) * step)


def pixel_grid(photo: Row) -> tuple[Array, Array]:
    """Column and row of the frame origin (2,), and the step of one pixel along x and y (2,) [mm], with its sign."""
    size = required(photo, "pixel_size_mm")
    origin = np.array([required(photo, "origin_col_px"), required(photo, "origin_row_px")])
    direction = np.array([1.0 if photo["x_axis"] == "right" else -1.0, -1.0 if photo["y_axis"] == "up" else 1.0])
    return origin, direction * size


def _means_of(kind: str, readings: Sequence[Row], cycles: CycleMeans, sigma: Array) -> Means:
    """Means of one kind; their variance is sum(sigma^2)/n^2 over the readings that are used."""
    used = cycles.is_used
    variance = np.bincount(cycles.point_index[used], weights=sigma[used] ** 2) / cycles.n_used**2
    prefix = f"{kind} "
    index = [i for i, point in enumerate(cycles.points) if point.startswith(prefix)]
    return Means(
        points=[cycles.points[i].removeprefix(prefix) for i in index],
        xy=cycles.means[index],
        n_cycles=cycles.n_used[index].astype(np.float64),
        sigma_cycles=cycles.sigma_point[index],
        covariance=variance[index, None, None] * np.eye(2),
    )


def _cycle_events(readings: Sequence[Row], cycles: CycleMeans, xy: Array, apriori: float) -> list[Event]:
    events = []
    for row, deviation, is_outlier, is_used in zip(
        readings, cycles.deviations, cycles.is_outlier, cycles.is_used, strict=True
    ):
        if is_outlier:
            size = MICROMETRES * float(np.hypot(*deviation))
            what = "kept" if is_used else "left out of the mean"
            where = f"{row['kind']} {row['point']}, cycle {row['cycle']}"
            message = f"{where}: {size:.1f} um from the mean of its cycles, {what}"
            events.append(Event("warning", "cycle_outlier", str(row["point"]), message, size))
    if cycles.sigma is not None:
        message = (
            f"one reading has a standard deviation of {MICROMETRES * cycles.sigma:.2f} um from the cycles "
            f"(a priori {MICROMETRES * apriori:.2f} um)"
        )
        events.append(Event("info", "cycle_sigma", "", message, cycles.sigma))
    return events


def _interior(
    photo: Row, marks: Sequence[Row], measured: Means, engine: Engine, events: list[Event]
) -> tuple[InteriorFit | None, list[str]]:
    """The fit and the names of the marks that carry it; None where no interior orientation is asked for."""
    transformation = str(photo["interior_transformation"])
    if transformation == "none":
        if measured.points:
            events.append(Event("warning", "fiducials_unused", "", "fiducials are read but photo.toml has no marks"))
        return None, []
    calibrated = {str(row["mark"]): row for row in marks}
    both = [index for index, mark in enumerate(measured.points) if mark in calibrated]
    chosen = [measured.points[index] for index in both]
    events += [_mark_event(mark, "is read but not calibrated") for mark in measured.points if mark not in calibrated]
    events += [_mark_event(mark, "is calibrated but not read") for mark in calibrated if mark not in chosen]
    target = columns([calibrated[mark] for mark in chosen], "x_mm", "y_mm")
    fit = fit_interior(measured.xy[both], target, transformation, marks=chosen, engine=engine)
    if fit.is_mirrored:
        message = "the readings are mirrored against the fiducial marks; is the photo measured from its back?"
        events.append(Event("warning", "mirrored", "", message))
    events += _bad_mark(fit, chosen, required(photo, "sigma_image_mm"))
    return fit, chosen


def _bad_mark(fit: InteriorFit, marks: Sequence[str], sigma: float) -> list[Event]:
    """Film shrinks by some micrometres; residuals of many sigmas are a slip or exchanged marks."""
    sizes = np.linalg.norm(fit.residuals, axis=1)
    worst = int(np.argmax(sizes))
    if sizes[worst] < MARK_LIMIT * sigma:
        return []
    size = MICROMETRES * float(sizes[worst])
    message = f"fiducial mark {marks[worst]} misses its place by {size:.1f} um: a slip, or marks exchanged?"
    return [Event("warning", "bad_mark", marks[worst], message, size)]


def _mark_event(mark: str, what: str) -> Event:
    return Event("warning", "fiducial_unmatched", mark, f"fiducial mark {mark} {what}: not used")


def _image_points(points: Means, interior: InteriorFit | None, photo: Row, tables: Tables) -> list[Row]:
    frame, by_reading = frame_coordinates(points.xy, _transformation(interior))
    covariance = by_reading @ points.covariance @ by_reading.transpose(0, 2, 1)
    principal = np.tile([-required(photo, "x0_mm"), -required(photo, "y0_mm")], (len(frame), 1))
    reduced = frame + principal
    lens, air, curvature = image_corrections(photo, tables, reduced, points.points)
    image = reduced + lens + air + curvature
    return [
        {
            "point": point,
            "n_cycles": int(points.n_cycles[i]),
            **_pair("x_comparator_mm", points.xy[i]),
            "sigma_cycles_mm": or_none(float(points.sigma_cycles[i])),
            **_pair("x_frame_mm", frame[i]),
            **_pair("dx_principal_mm", principal[i]),
            **_pair("dx_distortion_mm", lens[i]),
            **_pair("dx_refraction_mm", air[i]),
            **_pair("dx_curvature_mm", curvature[i]),
            **_pair("x_mm", image[i]),
            "cov_xx_mm2": float(covariance[i, 0, 0]),
            "cov_xy_mm2": float(covariance[i, 0, 1]),
            "cov_yy_mm2": float(covariance[i, 1, 1]),
        }
        for i, point in enumerate(points.points)
    ]


def _pair(x_name: str, values: Array) -> dict[str, float]:
    return {x_name: float(values[0]), x_name.replace("x", "y", 1): float(values[1])}


def _transformation(interior: InteriorFit | None) -> tuple[str, Array] | None:
    return None if interior is None else (interior.transformation, interior.parameters)


def frame_coordinates(xy: Array, interior: tuple[str, Array] | None) -> tuple[Array, Array]:
    """(n, 2) fiducial coordinates and (n, 2, 2) their derivative by the reading (differences: exact for affine).

    `interior`: name and parameters of the transformation; None where the readings are those of the frame.
    """
    if interior is None:
        return xy, np.tile(np.eye(2), (len(xy), 1, 1))
    name, parameters = interior

    def apply(shift: Array) -> Array:
        return np.asarray(plane.apply(name, parameters, xy + shift))

    steps = np.array([[STEP_MM, 0.0], [0.0, STEP_MM]])
    by_reading = np.stack([(apply(step) - apply(-step)) / (2 * STEP_MM) for step in steps], axis=-1)
    return apply(np.zeros(2)), by_reading


def _curvature_event(rows: Sequence[Row], photo: Row) -> list[Event]:
    """Says what was taken for granted, since the correction is wrong for any other ground."""
    radius = number(photo, "curvature_radius_m")
    if radius is None:
        return []
    largest = MICROMETRES * max(math.hypot(*columns([row], "dx_curvature_mm", "dy_curvature_mm")[0]) for row in rows)
    message = (
        f"corrected for the curvature of the Earth (radius {radius:.0f} m) by up to {largest:.1f} um: the ground is "
        "taken for a map plane with heights"
    )
    return [Event("info", "curvature", "", message, largest)]


def _cycle_rows(readings: Sequence[Row], cycles: CycleMeans) -> list[Row]:
    return [
        {
            "seq": row["seq"],
            "point": row["point"],
            "kind": row["kind"],
            "cycle": row["cycle"],
            "vx_mm": float(cycles.deviations[i, 0]),
            "vy_mm": float(cycles.deviations[i, 1]),
            "statistic": cycles.statistic[i],
            "is_outlier": int(cycles.is_outlier[i]),
            "is_used": int(cycles.is_used[i]),
        }
        for i, row in enumerate(readings)
    ]


def _mark_variance(measured: Means, chosen: Sequence[str]) -> float:
    """Mean variance of the coordinates of the marks that carry the fit, from their readings alone; 0 without marks."""
    carries = [i for i, mark in enumerate(measured.points) if mark in chosen]
    return float(np.mean(measured.covariance[carries, 0, 0])) if carries else 0.0


def _interior_tables(interior: InteriorFit | None, marks: Sequence[str], of_marks: float) -> Tables:
    """`of_marks`: variance of a mark by its readings; the residuals of few marks can be smaller than that by chance."""
    if interior is None:
        return {}
    sigmas = [None] * len(interior.names) if interior.sigmas is None else interior.sigmas.tolist()
    fit = {
        "transformation": interior.transformation,
        "n_marks": len(interior.residuals),
        "redundancy": interior.redundancy,
        "sigma0_mm": interior.sigma0,
    }
    parameters = [
        {"name": name, "value": float(value), "sigma": sigma}
        for name, value, sigma in zip(interior.names, interior.parameters, sigmas, strict=True)
    ]
    residuals = [
        {
            "mark": mark,
            **_pair("x_mm", interior.transformed[i]),
            **_pair("vx_mm", interior.residuals[i]),
        }
        for i, mark in enumerate(marks)
    ]
    variance = max(of_marks, 0.0 if interior.sigma0 is None else interior.sigma0**2)
    return {
        "interior_orientation": [fit],
        "interior_parameter": parameters,
        "interior_covariance": named_packed_rows(variance * interior.cofactor, interior.names),
        "fiducial_residual": residuals,
    }


def _summary(rows: Sequence[Row], cycles: CycleMeans, interior: InteriorFit | None) -> str:
    parts = [counted(len(rows), "point")]
    if cycles.sigma is not None:
        parts.append(f"one reading {MICROMETRES * cycles.sigma:.1f} um")
    if interior is not None:
        fit = "" if interior.sigma0 is None else f" {MICROMETRES * interior.sigma0:.1f} um"
        parts.append(f"{counted(len(interior.residuals), 'fiducial')} {interior.transformation}{fit}")
    return ", ".join(parts)
