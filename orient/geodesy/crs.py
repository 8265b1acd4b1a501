"""Coordinate reference systems by pyproj: one named operation between two systems, or a refusal that says why.

Coordinates always travel as (L_deg, B_deg, H_m) for a geographic system, (E_m, N_m, H_m) for a projected one and
(X_m, Y_m, Z_m) for a geocentric one, whatever the axis order of the authority. A two-dimensional system is taken as
three-dimensional with ellipsoidal heights. Nothing is ever fetched from a network.
"""

import re
import warnings
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import pyproj.network
from numpy.typing import ArrayLike, NDArray
from pyproj import CRS, Transformer
from pyproj.aoi import AreaOfInterest
from pyproj.exceptions import CRSError, ProjError
from pyproj.transformer import TransformerGroup

from orient.errors import OrientError
from orient.geodesy.ellipsoid import Ellipsoid

pyproj.network.set_network_enabled(active=False)  # type: ignore[attr-defined]

Array = NDArray[np.float64]
Area = tuple[float, float, float, float]
"""West, south, east, north in degrees."""
CrsKind = Literal["geographic", "projected", "geocentric", "vertical", "other"]

LONGEST_TEXT = 1000
FILE_REFERENCE = re.compile(r"grids?\s*=|init\s*=|parameterfile|\bfile\s*=|catalog\s*=", re.IGNORECASE)
"""Parts of a CRS text that make PROJ open a file."""
BALLPARK = re.compile("ballpark", re.IGNORECASE)


@dataclass(frozen=True)
class Operation:
    """One coordinate operation: what was done, how good it is, and the doing.

    `definition` is PROJ's pipeline (or `noop`), `accuracy_m` None when unknown, `grids` the grid files it uses,
    `missing_grids` those of the better operation that is not to be had here (only with `allow_ballpark`).
    """

    name: str
    definition: str
    accuracy_m: float | None
    grids: tuple[str, ...]
    is_ballpark: bool
    proj_version: str
    missing_grids: tuple[str, ...] = ()
    transformer: Transformer | None = field(default=None, repr=False, compare=False)

    def transform(self, c1: ArrayLike, c2: ArrayLike, c3: ArrayLike) -> tuple[Array, Array, Array]:
        """(c1, c2, c3) of the source system (n,) -> of the target system (n,): deg, deg, m or m, m, m.

        A point that the operation cannot take raises OrientError with its number in the list and its coordinates.
        """
        source = np.broadcast_arrays(*(np.asarray(c, dtype=np.float64) for c in (c1, c2, c3)))
        x, y, z = (c.copy() for c in source)
        if self.transformer is None:
            return x, y, z
        try:
            target = self.transformer.transform(x, y, z)
        except ProjError as error:
            raise OrientError(f'coordinates cannot be transformed by "{self.name}": {error}') from error
        x, y, z = (np.asarray(c, dtype=np.float64) for c in target)
        bad = np.flatnonzero(~np.isfinite(x + y + z))
        if len(bad):
            first = ", ".join(f"{np.ravel(c)[bad[0]]:.10g}" for c in source)
            raise OrientError(
                f'point number {bad[0] + 1} ({first}) cannot be transformed by "{self.name}"',
                "Check the coordinates, their order and the coordinate system.",
            )
        return x, y, z


def crs_from_text(text: str) -> CRS:
    """The CRS of an authority code (EPSG:4284), a name, a PROJ string or WKT; otherwise OrientError.

    Refused are texts longer than 1000 characters and texts that make PROJ open a file (grids, init files).
    """
    shown = text if len(text) <= 60 else text[:57] + "..."
    hint = "Write an authority code such as EPSG:4284, or a PROJ string such as +proj=longlat +a=6378245 +rf=298.3."
    unknown = f'unknown coordinate system "{shown}"'
    if len(text) > LONGEST_TEXT:
        raise OrientError(f"{unknown}: longer than {LONGEST_TEXT} characters", hint)
    if not text.strip() or not all(c.isprintable() or c in "\r\n\t" for c in text):
        raise OrientError(unknown, hint)
    if FILE_REFERENCE.search(text):
        raise OrientError(f"{unknown}: it refers to a file, which is not read", hint)
    try:
        return CRS.from_user_input(text.strip())
    except (CRSError, ValueError) as error:
        raise OrientError(unknown, hint) from error


def crs_kind(crs: CRS) -> CrsKind:
    """geographic | projected | geocentric | vertical | other; of a compound system the kind of its horizontal part."""
    horizontal = horizontal_part(crs)
    if horizontal.is_geocentric:
        return "geocentric"
    if horizontal.is_geographic:
        return "geographic"
    if horizontal.is_projected:
        return "projected"
    return "vertical" if horizontal.is_vertical else "other"


def horizontal_part(crs: CRS) -> CRS:
    """The system without its vertical part and without bound parameters (+towgs84)."""
    if crs.is_bound and crs.source_crs is not None:
        return horizontal_part(crs.source_crs)
    return horizontal_part(crs.sub_crs_list[0]) if crs.is_compound and crs.sub_crs_list else crs


def ground_ellipsoid(crs: CRS) -> Ellipsoid:
    """The ellipsoid of the system's datum; 1/f = 0 for a sphere. OrientError if it has none (a local system)."""
    ellipsoid = crs.ellipsoid
    if ellipsoid is None:
        raise OrientError(
            f'the coordinate system "{crs.name}" has no ellipsoid', "Give a geographic, projected or geocentric system."
        )
    a, b = float(ellipsoid.semi_major_metre), float(ellipsoid.semi_minor_metre)
    return Ellipsoid(str(ellipsoid.name), a, float(ellipsoid.inverse_flattening) if a != b else 0.0)


def geographic_crs_of(ellipsoid: Ellipsoid) -> CRS:
    """The three-dimensional geographic system of a bare ellipsoid or sphere: a figure without datum."""
    return CRS.from_user_input(f"+proj=longlat {figure(ellipsoid)} +type=crs").to_3d()


def figure(ellipsoid: Ellipsoid) -> str:
    if not ellipsoid.inverse_flattening:
        return f"+R={ellipsoid.a_m!r}"
    return f"+a={ellipsoid.a_m!r} +rf={ellipsoid.inverse_flattening!r}"


def geographic_crs(crs: CRS) -> CRS:
    """The three-dimensional geographic system with the same datum: where B, L, H of a projected system belong.

    OrientError if the system has no geodetic datum.
    """
    geodetic = horizontal_part(crs).geodetic_crs
    if geodetic is None or geodetic.datum is None:
        raise OrientError(
            f'the coordinate system "{crs.name}" has no geodetic datum',
            "Give a geographic, projected or geocentric system.",
        )
    if not geodetic.is_geocentric:
        return geodetic.to_3d()
    from pyproj.crs import GeographicCRS
    from pyproj.crs.coordinate_system import Ellipsoidal3DCS

    return CRS(GeographicCRS(name=geodetic.name, datum=geodetic.datum, ellipsoidal_cs=Ellipsoidal3DCS()))


def find_operation(source: CRS, target: CRS, allow_ballpark: bool = False, area: Area | None = None) -> Operation:
    """The best operation source -> target that PROJ knows; of several, the first that covers `area` (degrees).

    Give the `area` of the points: one datum often has different parameters for different countries. OrientError, unless
    `allow_ballpark`: if the best operation needs a grid that is not installed (named), or if there is only a ballpark
    operation (no datum shift or no height shift known). OrientError in any case if there is none at all, or if a system
    is not in degrees or metres.
    """
    for crs in (source, target):
        require_degrees_or_metres(crs)
    source, target = with_heights(source), with_heights(target)
    if source.equals(target, ignore_axis_order=True):
        return Operation("same coordinate system", "noop", 0.0, (), False, pyproj.proj_version_str)
    group = operations_between(source, target, area)
    missing = missing_grids(group)
    names = f'"{source.name}" to "{target.name}"'
    if missing and not allow_ballpark:
        raise OrientError(
            f"the best operation from {names} needs the grid {', '.join(missing)}, which is not installed",
            "Install the grid for PROJ, give the points in the other system, or repeat with --allow-ballpark.",
        )
    if not group.transformers:
        raise OrientError(f"there is no operation from {names}")
    chosen = first_covering(group.transformers, area)
    if is_ballpark(chosen) and not allow_ballpark:
        raise OrientError(
            f"only a ballpark operation is known from {names}, without a shift of the datum or the height",
            "Name the datum of both systems, install the grid of the shift or the geoid, or use --allow-ballpark.",
        )
    return operation_of(chosen, missing)


def operation_of(chosen: Transformer, missing: tuple[str, ...]) -> Operation:
    """The record of PROJ's transformer; a negative accuracy is PROJ's word for unknown."""
    accuracy = float(chosen.accuracy) if chosen.accuracy is not None and chosen.accuracy >= 0 else None
    return Operation(
        name=chosen.description,
        definition=chosen.definition,
        accuracy_m=accuracy,
        grids=grids_of(chosen),
        is_ballpark=is_ballpark(chosen),
        proj_version=pyproj.proj_version_str,
        missing_grids=missing,
        transformer=chosen,
    )


def operations_between(source: CRS, target: CRS, area: Area | None) -> TransformerGroup:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # "best transformation is not available": we say it ourselves
        return TransformerGroup(
            source,
            target,
            always_xy=True,
            area_of_interest=AreaOfInterest(*area) if area is not None else None,  # type: ignore[arg-type]
            allow_ballpark=True,
        )


def missing_grids(group: TransformerGroup) -> tuple[str, ...]:
    """Names of the grids for want of which the best operation is not available; empty if it is."""
    if group.best_available or not group.unavailable_operations:
        return ()
    best = group.unavailable_operations[0]
    names = tuple(grid.short_name or grid.full_name for grid in best.grids if not grid.available)
    return names or (best.name,)


def first_covering(transformers: list[Transformer], area: Area | None) -> Transformer:
    """PROJ's first choice that is no ballpark, but rather one that covers the whole `area`."""
    known = [transformer for transformer in transformers if not is_ballpark(transformer)] or transformers
    if area is None:
        return known[0]
    return next((transformer for transformer in known if covers(transformer, area)), known[0])


def is_ballpark(transformer: Transformer) -> bool:
    return bool(BALLPARK.search(transformer.description))


def covers(transformer: Transformer, area: Area) -> bool:
    use = transformer.area_of_use
    if use is None:
        return True
    west, south, east, north = area
    inside = use.west <= west and east <= use.east if use.west <= use.east else west >= use.west or east <= use.east
    return inside and use.south <= south and north <= use.north


def grids_of(transformer: Transformer) -> tuple[str, ...]:
    """Grid files named in the operation's definition."""
    found = re.findall(r"\bgrids=(\S+)", transformer.definition)
    return tuple(dict.fromkeys(name.lstrip("@") for names in found for name in names.split(",")))


def with_heights(crs: CRS) -> CRS:
    """The system with an ellipsoidal height, unless it has a height (compound, 3-D, geocentric) already."""
    return crs if crs.is_compound or crs.is_geocentric else crs.to_3d()


def require_degrees_or_metres(crs: CRS) -> None:
    kind = crs_kind(crs)
    if kind not in ("geographic", "projected", "geocentric"):
        raise OrientError(
            f'the coordinate system "{crs.name}" is not geographic, projected or geocentric',
            "Control and ground need one of these three; local Cartesian metres are given without a coordinate system.",
        )
    wanted = "degree" if kind == "geographic" else "metre"
    axes = horizontal_part(crs).axis_info[:2]
    wrong = [axis.unit_name for axis in axes if not axis.unit_name.startswith(wanted)]
    if wrong:
        raise OrientError(
            f'the coordinate system "{crs.name}" is in {wrong[0]}, not in {wanted}s',
            f"Convert the coordinates to {wanted}s and name a system in {wanted}s.",
        )
