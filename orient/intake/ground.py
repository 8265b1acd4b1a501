"""The ground of photo.toml: [ground], [station], [refraction] and [curvature] as columns of the table `photo`."""

from orient.intake.camera import Columns
from orient.intake.cells import COORDINATE_LIMIT_M, HIGHEST_M, LOWEST_M
from orient.intake.crs import crs_figure, crs_kind, named_figure
from orient.intake.findings import BadValue, shown
from orient.intake.names import parse_name
from orient.intake.numbers import east_of_half_turn, plain
from orient.intake.toml_file import Section

EXAMPLE = 'Write crs = "EPSG:4284", ellipsoid = "krasovsky", a_m and inverse_flattening, or local = "right"'
REFRACTION_MODELS = ("none", "integral", "ardc", "space")
SPACE_FROM_M = 80_000.0
EARTH_RADIUS_M = 6_371_000.0
ANGLE_CONVENTIONS = ("opk", "aok", "azk")


def read_ground(ground: Section) -> Columns:
    """Exactly one of a CRS, an ellipsoid without datum, or local Cartesian metres."""
    columns: Columns = {
        "ground_kind": None,
        "ground_crs": None,
        "ellipsoid": None,
        "a_m": None,
        "inverse_flattening": None,
        "handedness": None,
        "ground_height_m": ground.number("height_m", LOWEST_M, HIGHEST_M, "m"),
        "central_meridian_deg": ground.angle("central_meridian_deg", 360),
    }
    has_figure = ground.has("ellipsoid") or ground.has("a_m") or ground.has("inverse_flattening")
    kinds = [kind for kind, there in _kinds(ground, has_figure).items() if there]
    if len(kinds) != 1:
        message = "ground: give one of crs, ellipsoid, local" + (", not several" if kinds else "")
        ground.problem("", message, EXAMPLE)
    elif kinds == ["crs"]:
        columns |= _from_crs(ground)
    elif kinds == ["ellipsoid"]:
        columns |= _from_figure(ground)
    else:
        columns |= _local(ground)
    for key in ("ellipsoid", "a_m", "inverse_flattening", "crs", "local"):
        ground.has(key)
    ground.finish()
    return columns


def _kinds(ground: Section, has_figure: bool) -> dict[str, bool]:
    return {"crs": ground.has("crs"), "ellipsoid": has_figure, "local": ground.has("local")}


def _from_crs(ground: Section) -> Columns:
    text = ground.text("crs")
    if text is None:
        return {"ground_kind": "crs"}
    try:
        kind = crs_kind(text)
        if kind != "geographic":
            raise BadValue(f"{shown(text)} is {kind}", "The ground needs a geographic system of B, L (and H)")
        name, a, inverse_flattening = crs_figure(text)
    except BadValue as bad:
        ground.problem("crs", f"crs: {bad.message}", bad.hint)
        return {"ground_kind": "crs"}
    return {
        "ground_kind": "crs",
        "ground_crs": text,
        "ellipsoid": name,
        "a_m": a,
        "inverse_flattening": inverse_flattening,
    }


def _from_figure(ground: Section) -> Columns:
    """A named ellipsoid, or a_m with inverse_flattening (0 for a sphere) under any name."""
    columns: Columns = {"ground_kind": "ellipsoid"}
    name = ground.text("ellipsoid")
    if not ground.has("a_m") and not ground.has("inverse_flattening"):
        if name is None:
            return columns
        try:
            figure = named_figure(name)
        except BadValue as bad:
            ground.problem("ellipsoid", f"ellipsoid: {bad.message}", bad.hint or EXAMPLE)
            return columns
        return columns | {"ellipsoid": figure[0], "a_m": figure[1], "inverse_flattening": figure[2]}
    for key in ("a_m", "inverse_flattening"):
        if not ground.has(key):
            ground.missing(key, "Give both; inverse_flattening = 0 for a sphere")
    flattening = ground.number("inverse_flattening", 0, 1e12)
    if flattening is not None and 0 < flattening < 2:
        message = f"inverse_flattening: {plain(flattening)} is neither 0 (a sphere) nor 2 or more"
        ground.problem("inverse_flattening", message, "Krasovsky has 298.3")
    return columns | {
        "ellipsoid": name or "given",
        "a_m": ground.number("a_m", 100, 1e9, "m"),
        "inverse_flattening": flattening,
    }


def _local(ground: Section) -> Columns:
    if ground.has("central_meridian_deg"):
        ground.problem("central_meridian_deg", "local ground has no central meridian")
    return {"ground_kind": "local", "handedness": ground.word("local", ("right", "left"))}


def read_station(station: Section, ground_kind: object) -> Columns:
    """The approximate station; its angles are checked but not needed, the orientation starts without them."""
    columns: Columns = {
        "station_B_deg": station.angle("B_deg", 90),
        "station_L_deg": None,
        "station_H_m": station.number("H_m", LOWEST_M, HIGHEST_M, "m"),
        "station_X_m": station.number("X_m", -COORDINATE_LIMIT_M, COORDINATE_LIMIT_M, "m"),
        "station_Y_m": station.number("Y_m", -COORDINATE_LIMIT_M, COORDINATE_LIMIT_M, "m"),
        "station_Z_m": station.number("Z_m", -COORDINATE_LIMIT_M, COORDINATE_LIMIT_M, "m"),
    }
    longitude = station.angle("L_deg", 360)
    columns["station_L_deg"] = None if longitude is None else east_of_half_turn(longitude)
    given = {key for key in ("B_deg", "L_deg", "H_m", "X_m", "Y_m", "Z_m") if key in station.data}
    if given not in (set(), {"B_deg", "L_deg"}, {"H_m"}, {"B_deg", "L_deg", "H_m"}, {"X_m", "Y_m", "Z_m"}):
        station.problem("", "station: give B_deg, L_deg, H_m or X_m, Y_m, Z_m")
    elif ground_kind == "local" and given & {"B_deg", "H_m"}:
        station.problem("", "station: the ground is local, give X_m, Y_m, Z_m")
    _check_angles(station)
    station.finish()
    return columns


def _check_angles(station: Section) -> None:
    convention = station.word("angle_convention", ANGLE_CONVENTIONS)
    if not station.has("angles_deg"):
        return
    station.number_list("angles_deg", 3, -360, 360)
    if convention is None and not station.has("angle_convention"):
        station.problem("angles_deg", "angle_convention is required: opk, aok or azk")
    else:
        message = f"{station.file}: the angles of the station are not used: the orientation starts without them"
        station.warn("angles_not_used", "", message)


def read_refraction(refraction: Section, columns: Columns) -> Columns:
    """The model, and the height of the camera: its own key, or the height of the station."""
    is_schut = refraction.value("model") == "schut"
    model = "none" if is_schut else refraction.word("model", REFRACTION_MODELS) or "none"
    height = refraction.number("camera_height_m", LOWEST_M, HIGHEST_M, "m")
    if height is None:
        station = columns["station_Z_m" if columns["ground_kind"] == "local" else "station_H_m"]
        height = station if isinstance(station, float) else None
    ground_height = columns["ground_height_m"]
    refraction.finish()
    if is_schut:
        _refuse_schut(refraction, height)
    if model != "none" and (height is None or not isinstance(ground_height, float)):
        hint = "Give camera_height_m (or the station) and height_m in [ground]"
        refraction.problem("model", "refraction needs the heights of the camera and of the ground", hint)
    elif model != "none" and isinstance(ground_height, float) and height is not None and height <= ground_height:
        message = f"the camera ({plain(height)} m) is not above the ground ({plain(ground_height)} m)"
        refraction.problem("model", f"refraction: {message}")
    elif model == "space" and height is not None and height <= SPACE_FROM_M:
        message = f"model: space holds for cameras above 80,000 m, not at {plain(height)} m"
        refraction.problem("model", message, 'Write "integral", which serves every height')
    return {"refraction": model, "camera_height_m": height}


def _refuse_schut(refraction: Section, height: float | None) -> None:
    """Schut's formula is known by name, so that the reason can be told."""
    if height is not None and height > SPACE_FROM_M:
        message = "model: schut is a formula for aerial photos; it is negative above 25 km and absurd from space"
        refraction.problem("model", message, 'Write "integral" or "space"')
    else:
        message = "model: schut is not offered; it holds to 10 km only and agrees there with the integral"
        refraction.problem("model", message, 'Write "integral"')


def read_curvature(document: Section, columns: Columns) -> Columns:
    """[curvature] declares that local ground is a map plane with heights: the radius of the datum below it."""
    if not document.has("curvature"):
        return {"curvature_radius_m": None}
    curvature = document.section("curvature")
    radius = curvature.number("radius_m", 1e3, 1e9, "m")
    has_radius = curvature.has("radius_m")
    curvature.finish()
    if columns["ground_kind"] in ("crs", "ellipsoid"):
        message = "curvature: topocentric coordinates already contain the curvature of the Earth"
        curvature.problem("", message, "Leave [curvature] out; it is for local ground that is a map plane with heights")
    elif not isinstance(columns["camera_height_m"], float) or not isinstance(columns["ground_height_m"], float):
        hint = "Give camera_height_m in [refraction] (or the station) and height_m in [ground]"
        curvature.problem("", "curvature needs the heights of the camera and of the ground", hint)
    elif columns["camera_height_m"] <= columns["ground_height_m"]:
        heights = (
            f"({plain(columns['camera_height_m'])} m) is not above the ground ({plain(columns['ground_height_m'])} m)"
        )
        curvature.problem("", f"curvature: the camera {heights}")
    return {"curvature_radius_m": radius if has_radius else EARTH_RADIUS_M}


def check_name(section: Section, key: str) -> str | None:
    """The name of a photo follows the rule of all names."""
    text = section.text(key)
    if text is None:
        return None
    try:
        return parse_name(text)
    except BadValue as bad:
        section.problem(key, f"{key}: {bad.message}", bad.hint)
        return None
