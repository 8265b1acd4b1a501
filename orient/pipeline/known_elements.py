"""[known] of photo.toml as observations of the resection: station, height and angles with their standard deviations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry.rotation import aok_by_rotation, aok_from_matrix, opk_by_rotation, opk_from_matrix
from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array, number, required
from orient.solvers.element_observations import ElementObservation, Misclosure, along
from orient.units import DEGREES_PER_RADIAN, RADIANS_PER_DEGREE, wrap_half_turn
from orient.values import Event, Row

LOCAL, GEOGRAPHIC = ("X_S", "Y_S", "Z_S"), ("B_S", "L_S", "H_S")
CONTRADICTION = 3.29
"""|w| that a right value exceeds with a chance of 0.1 %."""
SMALLEST_SHARE = 1e-6
ANGLES = {"aok": ("alpha", "omega", "kappa"), "opk": ("omega", "phi", "kappa")}


@dataclass(frozen=True, slots=True)
class KnownElements:
    """Observations of the solver's frame with their sigmas [m, rad], and a station (3,) that is without error."""

    observations: Sequence[ElementObservation]
    sigmas: Sequence[float]
    fixed_station: Array | None


def known_elements(rows: Sequence[Row], frame: Frame, sigma0: float) -> KnownElements:
    """From the rows of `known_element`."""
    by_name = {str(row["quantity"]): row for row in rows}
    fixed = _fixed_station(by_name, frame)
    chosen = [row for row in rows if row["sigma"] is not None]
    sigmas = [
        required(row, "sigma") * (1.0 if str(row["quantity"]).endswith("_S") else RADIANS_PER_DEGREE) for row in chosen
    ]
    observations = [
        ElementObservation(str(row["quantity"]), (sigma / sigma0) ** 2, _misclosure(row, by_name, frame))
        for row, sigma in zip(chosen, sigmas, strict=True)
    ]
    return KnownElements(observations, sigmas, fixed)


def known_residual_rows(
    known: KnownElements, rotation: Array, station: Array, redundancy: Array
) -> list[dict[str, str | int | float | None]]:
    """v = adjusted minus known; angles in degrees."""
    rows: list[dict[str, str | int | float | None]] = []
    for one, sigma, share in zip(known.observations, known.sigmas, redundancy, strict=True):
        is_length = one.name.endswith("_S")
        unit = 1.0 if is_length else DEGREES_PER_RADIAN
        rows.append(
            {
                "quantity": one.name,
                "unit": "m" if is_length else "deg",
                "sigma": sigma * unit,
                "v": one.misclosure(rotation, station)[0] * unit,
                "redundancy_number": float(share),
            }
        )
    return rows


def known_events(rows: Sequence[Row]) -> list[Event]:
    """What was known and does not fit the photo: v / (sigma sqrt(r)) beyond 3.29, chance 0.1 %."""
    events = []
    for row in rows:
        normalised = contradiction(required(row, "v"), number(row, "sigma"), number(row, "redundancy_number"))
        if normalised is not None:
            message = (
                f"{row['quantity']} of [known] misses the photo by {abs(required(row, 'v')):.3g} {row['unit']} "
                f"({abs(normalised):.1f} sigmas): check it and its axes"
            )
            events.append(Event("warning", "known_contradicted", str(row["quantity"]), message, normalised))
    return events


def contradiction(v: float, sigma: float | None, share: float | None) -> float | None:
    """v / (sigma sqrt(r)) where that is beyond 3.29; None where it fits, or where nothing checks it."""
    if sigma is None or share is None or share < SMALLEST_SHARE:
        return None
    normalised = v / (sigma * share**0.5)
    return normalised if abs(normalised) > CONTRADICTION else None


def _fixed_station(by_name: dict[str, Row], frame: Frame) -> Array | None:
    axes = LOCAL if frame.origin is None else GEOGRAPHIC
    if not all(name in by_name and by_name[name]["sigma"] is None for name in axes):
        return None
    return frame.right_handed(_place(by_name, frame))


def _place(by_name: dict[str, Row], frame: Frame) -> Array:
    """(3,) the known station in the stored frame."""
    if frame.origin is None:
        return np.array([required(by_name[name], "value") for name in LOCAL])
    latitude, longitude, height = (required(by_name[name], "value") for name in GEOGRAPHIC)
    B, L = np.array([latitude, longitude]) * RADIANS_PER_DEGREE
    place: Array = frame.from_geographic(np.array([B]), np.array([L]), np.array([height]))[0]
    return place


def _misclosure(row: Row, by_name: dict[str, Row], frame: Frame) -> Misclosure:
    quantity = str(row["quantity"])
    if not quantity.endswith("_S"):
        return _angle(quantity, required(row, "value") * RADIANS_PER_DEGREE)
    if frame.origin is None:
        axis = frame.right_handed(np.eye(3)[LOCAL.index(quantity)])
        return along(axis, required(row, "value"))
    if quantity == "H_S":
        return _height(frame, required(row, "value"))
    place = _place(by_name, frame)
    B, L = (required(by_name[name], "value") * RADIANS_PER_DEGREE for name in ("B_S", "L_S"))
    horizon = frame.from_horizon(np.array([B]), np.array([L]))[0]
    axis = frame.right_handed(horizon[:, GEOGRAPHIC.index(quantity)])
    return along(axis, float(axis @ frame.right_handed(place)))


def _height(frame: Frame, given: float) -> Misclosure:
    """H(S) - given: the ellipsoidal height of the station, wherever the adjustment moves it."""

    def misclosure(rotation: Array, station: Array) -> tuple[float, Array]:
        B, L, H = frame.geographic(frame.right_handed(station)[None, :])[0]
        up = frame.right_handed(frame.from_horizon(np.array([B]), np.array([L]))[0][:, 2])
        return float(H) - given, np.concatenate([np.zeros(3), up])

    return misclosure


def _angle(quantity: str, given: float) -> Misclosure:
    triple, angle = quantity.split("_")
    place = ANGLES[triple].index(angle)
    angles_of, by_rotation = {"aok": (aok_from_matrix, aok_by_rotation), "opk": (opk_from_matrix, opk_by_rotation)}[
        triple
    ]

    def misclosure(rotation: Array, station: Array) -> tuple[float, Array]:
        value = float(angles_of(rotation)[place])
        return wrap_half_turn(value - given), np.concatenate([by_rotation(rotation)[place], np.zeros(3)])

    return misclosure
