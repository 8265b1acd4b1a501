"""Coordinate systems by authority code. Only codes are taken: no PROJ text, no WKT, no grid files of strangers."""

import re
from typing import Literal

from orient.errors import OrientError
from orient.intake.findings import BadValue, shown

AUTHORITY_CODE = re.compile(
    r"[A-Za-z][A-Za-z0-9_]{1,19}:[A-Za-z0-9_]{1,20}(\+([A-Za-z][A-Za-z0-9_]{1,19}:)?[0-9]{1,10})?", re.ASCII
)
LONGEST_CRS = 60

HINT = 'Write an authority code such as "EPSG:4284"'

CrsKind = Literal["geographic", "projected", "geocentric", "vertical", "other"]


def check_code(text: str) -> str:
    """The text if it is written as an authority code. Raises `BadValue`."""
    if len(text) > LONGEST_CRS:
        raise BadValue(f"longer than {LONGEST_CRS} characters", HINT)
    if not AUTHORITY_CODE.fullmatch(text):
        raise BadValue(f'"{shown(text)}" is refused', HINT)
    return text


def crs_kind(text: str) -> CrsKind:
    """What coordinates the system has. Raises `BadValue` for an unknown one, and for one in feet or grads."""
    from orient.geodesy import crs as systems

    check_code(text)
    try:
        system = systems.crs_from_text(text)
    except OrientError as error:
        raise BadValue(f'unknown coordinate system "{text}"', HINT) from error
    try:
        systems.require_degrees_or_metres(system)
    except OrientError as error:
        raise BadValue(error.message, error.hint) from error
    return systems.crs_kind(system)


def crs_figure(text: str) -> tuple[str, float, float]:
    """Name, semi-major axis [m] and inverse flattening (0 = sphere) of the ellipsoid of a CRS."""
    from orient.geodesy.crs import crs_from_text, ground_ellipsoid

    figure = ground_ellipsoid(crs_from_text(text))
    return figure.name, figure.a_m, figure.inverse_flattening


def named_figure(text: str) -> tuple[str, float, float]:
    """Name, semi-major axis [m] and inverse flattening (0 = sphere) of a named ellipsoid. Raises `BadValue`."""
    from orient.geodesy.ellipsoid import named_ellipsoid

    try:
        figure = named_ellipsoid(text)
    except OrientError as error:
        raise BadValue(f'"{shown(text)}" is not a known ellipsoid', error.hint) from error
    return figure.name, figure.a_m, figure.inverse_flattening
