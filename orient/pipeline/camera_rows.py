"""What a resection found out about the camera: rows of the project file, and the sentences about them."""

from collections.abc import Callable, Mapping, Sequence
from math import hypot

import numpy as np

from orient.geometry.distortion import fold_radius
from orient.pipeline.camera import unit_of
from orient.pipeline.known_elements import contradiction
from orient.pipeline.tables import number, or_none, required
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.resection import Resection
from orient.values import Event, Row

CONTRADICTION = 3.29
"""Normalised residual of a value a priori, chance 0.1 %, above which photo and camera file contradict each other."""
SMALLEST_SHARE = 1e-6
HARDLY_SEPARABLE = 0.999


def camera_tables(
    found: Resection, interior: CameraUnknowns | None, sigma0: float, use_posteriori: bool
) -> Mapping[str, Sequence[Row]]:
    """`adjusted_camera` and `camera_element`; nothing when no element was estimated."""
    if interior is None:
        return {}
    camera = interior.at(found.camera)
    whole: Row = {
        "f_mm": camera.f_mm,
        "x0_mm": camera.x0_mm,
        "y0_mm": camera.y0_mm,
        "b1": camera.b1,
        "b2": camera.b2,
        "distortion_model": camera.distortion.model,
        "distortion_direction": camera.distortion.direction,
    }
    return {"adjusted_camera": [whole], "camera_element": _elements(found, interior, sigma0, use_posteriori)}


def _elements(found: Resection, interior: CameraUnknowns, sigma0: float, use_posteriori: bool) -> list[Row]:
    from orient.pipeline.calibration import significance

    tested = significance(found, interior, sigma0, use_posteriori)
    shares = dict(zip(interior.observed.tolist(), found.known_redundancy, strict=False))
    return [
        {
            "unknown": name,
            "unit": unit_of(name, interior.camera),
            "value_apriori": float(interior.apriori[k]),
            "sigma_apriori": or_none(float(np.sqrt(interior.cofactors[k]) * sigma0)),
            "value": float(found.camera[k]),
            "correction": float(found.camera[k] - interior.apriori[k]),
            "sigma": or_none(float(tested.sigma[k])),
            "t": or_none(float(tested.t[k])),
            "t_limit": tested.limit,
            "is_significant": int(abs(tested.t[k]) > tested.limit),
            "redundancy_number": or_none(float(shares[k])) if k in shares else None,
        }
        for k, name in enumerate(interior.names)
    ]


def camera_events(
    found: Resection,
    interior: CameraUnknowns | None,
    photo: Row,
    sigma0: float,
    use_posteriori: bool,
    rename: Callable[[str], str],
) -> list[Event]:
    """A value a priori that the photo contradicts, a lens that folds, elements that are weak or could be left out.

    `rename`: the solver's unknowns in the words of the stored frame.
    """
    if interior is None:
        return []
    rows = _elements(found, interior, sigma0, use_posteriori)
    weak = _hardly_separable(found, interior, rename)
    return [*_contradictions(rows), *_fold(found, interior, photo), *weak, *_not_significant(rows)]


def _contradictions(rows: Sequence[Row]) -> list[Event]:
    events = []
    for row in rows:
        sigma = number(row, "sigma_apriori")
        normalised = contradiction(required(row, "correction"), sigma, number(row, "redundancy_number"))
        if normalised is not None:
            message = (
                f"{row['unknown']} of photo.toml, {row['value_apriori']:.6g} +- {sigma:.2g} {row['unit']}, contradicts "
                f"the photo ({abs(normalised):.1f} sigmas): check it, or free it with --free-camera"
            )
            events.append(Event("warning", "camera_contradicted", str(row["unknown"]), message, normalised))
    return events


def _hardly_separable(found: Resection, interior: CameraUnknowns, rename: Callable[[str], str]) -> list[Event]:
    """A free element that nearly is a combination of the others: a result, but of little worth for its own."""
    from orient.pipeline.calibration import strongest_correlation

    events = []
    for place, name in enumerate(interior.names):
        correlation, partner = strongest_correlation(found, len(found.Q) - len(interior.names) + place)
        if np.isinf(interior.cofactors[place]) and abs(correlation) > HARDLY_SEPARABLE:
            message = (
                f"{name} is hardly separable from {rename(partner)} (correlation {correlation:+.5f}): give it a "
                "standard deviation in photo.toml, or judge ground points only"
            )
            events.append(Event("warning", "camera_weak", name, message, correlation))
    return events


def _fold(found: Resection, interior: CameraUnknowns, photo: Row) -> list[Event]:
    """A polynomial fitted inside the points may turn back towards the corners of the frame."""
    size = (number(photo, "frame_width_mm"), number(photo, "frame_height_mm"))
    if None in size:
        return []
    camera = interior.at(found.camera)
    corner = hypot(*(0.5 * value for value in size if value is not None))
    radius = fold_radius(camera.distortion, corner) if camera.distortion.model != "radial_table" else None
    if radius is None:
        return []
    message = f"the estimated lens has no inverse from {radius:.1f} mm to the corner of the frame: estimate fewer k"
    return [Event("warning", "lens_folds", "", message, radius)]


def _not_significant(rows: Sequence[Row]) -> list[Event]:
    weak = [row for row in rows if not row["is_significant"] and row["sigma_apriori"] is None]
    if not weak:
        return []
    told = ", ".join(f"{row['unknown']} (t {abs(number(row, 't') or 0.0):.1f})" for row in weak)
    message = f"not significant at 1 %: {told}; they could be left out"
    return [Event("info", "camera_not_significant", ", ".join(str(row["unknown"]) for row in weak), message)]
