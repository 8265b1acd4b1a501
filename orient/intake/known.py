"""[known] of photo.toml: station, height or angles that are known beforehand, with their standard deviations."""

import math

from orient.intake.cells import COORDINATE_LIMIT_M, HIGHEST_M, LOWEST_M
from orient.intake.toml_file import Section
from orient.values import Row

TRIPLES = {"aok": ("alpha", "omega", "kappa"), "opk": ("omega", "phi", "kappa")}
AXES = {"local": ("X_m", "Y_m", "Z_m"), "geographic": ("B_deg", "L_deg", "H_m")}
LARGEST_SIGMA_M, LARGEST_SIGMA_DEG = 1e6, 180.0


def read_known(document: Section, ground_kind: object) -> list[Row]:
    """Rows of the table `known_element`: quantity, unit, value and sigma (NULL: without error)."""
    if not document.has("known"):
        return []
    known = document.section("known")
    kind = "local" if ground_kind == "local" else "geographic"
    rows = [*_station(known.section("station"), kind), *_height(known.section("height"), kind)]
    rows += _angles(known.section("angles"))
    known.finish()
    if len({row["quantity"] for row in rows}) < len(rows):
        known.problem("height", "known: the height is given twice, in station and in height")
    return rows


def _station(station: Section, kind: str) -> list[Row]:
    if not station.data:
        return []
    limits = {"B_deg": 90.0, "L_deg": 360.0}
    values: list[float | None] = []
    for key in AXES[kind]:
        if not station.has(key):
            station.missing(key, f"Give {', '.join(AXES[kind])}")
        values.append(_place(station, key, limits.get(key)))
    is_fixed = station.value("fixed")
    if is_fixed is not None and not isinstance(is_fixed, bool):
        station.problem("fixed", "fixed: expected true or false")
    sigmas = None if is_fixed is True else _station_sigmas(station)
    station.finish()
    if None in values or (sigmas is None and is_fixed is not True):
        return []
    return [
        _row(_quantity(key), value, None if sigmas is None else sigmas[place])
        for place, (key, value) in enumerate(zip(AXES[kind], values, strict=True))
        if value is not None
    ]


def _place(section: Section, key: str, degrees: float | None) -> float | None:
    if degrees is not None:
        return section.angle(key, degrees)
    is_height = key == "H_m"
    low, high = (LOWEST_M, HIGHEST_M) if is_height else (-COORDINATE_LIMIT_M, COORDINATE_LIMIT_M)
    return section.number(key, low, high, "m")


def _station_sigmas(station: Section) -> tuple[float, ...] | None:
    if not station.has("sigma_m"):
        station.missing("sigma_m", "Give three numbers (to north, east, up; local: X, Y, Z), or fixed = true")
        return None
    sigmas = station.number_list("sigma_m", 3, 0, LARGEST_SIGMA_M, "m")
    if sigmas is not None and min(sigmas) <= 0:
        station.problem("sigma_m", "sigma_m: must be > 0", "For a station without error use fixed = true")
        return None
    return sigmas


def _height(height: Section, kind: str) -> list[Row]:
    """A value with its sigma, or a range, in which every height is as likely: sigma = width / sqrt(12)."""
    if not height.data:
        return []
    key = AXES[kind][2]
    value, sigma = _place(height, key, None), height.sigma("sigma_m")
    limits = height.number_list("range_m", 2, -COORDINATE_LIMIT_M, COORDINATE_LIMIT_M, "m")
    if height.has("range_m") == height.has(key) or height.has("sigma_m") != height.has(key):
        height.problem("", f"height: give {key} and sigma_m, or range_m = [lowest, highest]")
        value = None
    elif limits is not None:
        value, sigma = (limits[0] + limits[1]) / 2, (limits[1] - limits[0]) / math.sqrt(12)
        if sigma <= 0:
            height.problem("range_m", "range_m: the second height must be above the first")
    height.finish()
    return [] if value is None or not sigma else [_row(_quantity(key), value, sigma)]


def _angles(angles: Section) -> list[Row]:
    """One angle or more of a named triple, all with the same sigma."""
    if not angles.data:
        return []
    triple = angles.word("triple", tuple(TRIPLES))
    if triple is None:
        if not angles.has("triple"):
            angles.missing("triple", 'Write triple = "aok" or "opk"')
        return []
    sigma = angles.number("sigma_deg", 0, LARGEST_SIGMA_DEG, "deg")
    if not angles.has("sigma_deg"):
        angles.missing("sigma_deg")
    elif sigma is not None and sigma <= 0:
        angles.problem("sigma_deg", "sigma_deg: must be > 0")
    rows: list[Row] = [
        {"quantity": f"{triple}_{name}", "unit": "deg", "value": value, "sigma": sigma}
        for name in TRIPLES[triple]
        if (value := angles.angle(f"{name}_deg", 360)) is not None
    ]
    if not rows:
        angles.problem("", f"angles: give one of {', '.join(f'{name}_deg' for name in TRIPLES[triple])}")
    angles.finish()
    return rows


def _quantity(key: str) -> str:
    return f"{key.split('_')[0]}_S"


def _row(quantity: str, value: float, sigma: float | None) -> Row:
    unit = "deg" if quantity in ("B_S", "L_S") else "m"
    return {"quantity": quantity, "unit": unit, "value": value, "sigma": sigma}
