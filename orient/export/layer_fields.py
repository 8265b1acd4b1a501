"""The fields of the map layers and of the table of covariances: names, types, meanings."""

from dataclasses import dataclass
from typing import Literal

from orient.export.elements import PARAMETERS


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a layer: name, type, meaning with the unit."""

    name: str
    type: Literal["text", "real", "integer", "boolean", "datetime"]
    meaning: str


def _fields(text: str) -> list[Field]:
    """Lines `name type meaning`."""
    rows = [line.split(maxsplit=2) for line in text.strip().splitlines()]
    return [Field(name, kind, meaning) for name, kind, meaning in rows]  # type: ignore[arg-type]


POINT_FIELDS = _fields("""
point text name of the point
role text control, check or excluded
weighting text fixed: without error; weighted: with its covariance
B_deg real latitude on the ground's ellipsoid, deg; empty for local ground
L_deg real longitude on the ground's ellipsoid, deg; empty for local ground
H_m real height above the ellipsoid, m; empty for local ground
X_m real X of the project's frame, m
Y_m real Y of the project's frame, m
Z_m real Z of the project's frame, m
vx_um real image residual x, computed minus measured, um
vy_um real image residual y, computed minus measured, um
dX_m real image ray at the height of the point minus given, X (grid north; local: X), m
dY_m real image ray minus given, Y (grid east; local: Y), m
sigma_X_m real standard deviation of a new reading of the point on the ground, X, m
sigma_Y_m real standard deviation, Y, m
""")
VECTOR_FIELDS = _fields("""
point text name of the point
role text control, check or excluded
dX_m real image ray at the height of the point minus given, X (grid north; local: X), m
dY_m real image ray minus given, Y (grid east; local: Y), m
length_m real true length, m
magnified real how many times the line is longer than that
""")
ELLIPSE_FIELDS = _fields("""
point text name of the point
role text control, check or excluded
a_m real true semi-major axis of the standard error ellipse (39 %) of a new reading, m
b_m real true semi-minor axis, m
azimuth_deg real direction of the semi-major axis from X towards Y, deg
magnified real how many times the ellipse is larger
""")
FOOTPRINT_FIELDS = _fields("""
photo text name of the photo
height_m real mean height of the points on which the frame is laid, m
is_whole integer 1 if every edge of the frame meets the ground; 0 if a part shows the sky
""")
STATION_FIELDS = _fields("""
photo text name of the photo
B_S_deg real latitude of the projection centre, deg; empty for local ground
L_S_deg real longitude, deg; empty for local ground
H_S_m real height above the ellipsoid, m; empty for local ground
X_S_m real X of the project's frame, m
Y_S_m real Y of the project's frame, m
Z_S_m real Z of the project's frame, m
sigma_X_m real standard deviation, m
sigma_Y_m real standard deviation, m
sigma_Z_m real standard deviation, m
omega_deg real opk: omega about grid east, deg
phi_deg real opk: phi, deg
kappa_deg real opk: kappa, deg
q_w real unit quaternion image -> right-handed ground
q_x real unit quaternion
q_y real unit quaternion
q_z real unit quaternion
f_mm real focal length, mm
sigma0_um real standard deviation of unit weight a posteriori, um; empty without redundancy
redundancy integer n - u
""")


COVARIANCE_FIELDS = [
    Field("parameter", "text", "X_S, Y_S, Z_S; rotation_1, 2, 3: small rotation about the right-handed ground axes"),
    Field("unit", "text", "unit of value and sigma; a covariance has the product of two units"),
    Field("value", "real", "value"),
    Field("sigma", "real", "standard deviation"),
    *(Field(f"cov_{name}", "real", f"covariance with {name}") for name in PARAMETERS),
]
STYLE_FIELDS = _fields("""
f_table_catalog text empty
f_table_schema text empty
f_table_name text layer
f_geometry_column text its geometry
styleName text name of the style
styleQML text style of QGIS
styleSLD text empty
useAsDefault boolean QGIS takes it when it opens the layer
description text what is drawn
owner text empty
ui text empty
update_time datetime when the orientation was computed, UTC
""")
