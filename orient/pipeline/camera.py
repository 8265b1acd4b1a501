"""The camera of the photo as values, as unknowns of the resection, and as it is after the adjustment."""

from collections.abc import Sequence

import numpy as np

from orient.errors import OrientError
from orient.geometry.camera import INTERIOR, LENS, Camera, Measured, camera_equations, corrected
from orient.geometry.distortion import Distortion
from orient.pipeline.tables import Array, columns, number, required
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.values import Row, Settings, Tables

OWN_SIGMAS = {"f": "sigma_f_mm", "x0": "sigma_x0_mm", "y0": "sigma_y0_mm"}
AS_GIVEN = "camera"
POWERS = {"k1": 2, "k2": 4, "k3": 6, "p1": 1, "p2": 1}


def given_camera(photo: Row, tables: Tables) -> Camera:
    """The camera of photo.toml."""
    coefficients = {str(row["name"]): required(row, "value") for row in tables.get("distortion_coefficient", ())}
    radial = tables.get("distortion_radial", ())
    lens = Distortion(
        model=str(photo["distortion_model"]),
        direction=str(photo["distortion_direction"]),
        coefficients=coefficients,
        table=columns(radial, "radius_mm", "distortion_mm") if radial else None,
        f_mm=required(photo, "f_mm"),
    )
    return Camera(required(photo, "f_mm"), required(photo, "x0_mm"), required(photo, "y0_mm"), lens)


def measured_of(rows: Sequence[Row]) -> Measured:
    """Coordinates of the frame before the camera's corrections, and those of refraction and curvature."""
    air = columns(rows, "dx_refraction_mm", "dy_refraction_mm") + columns(rows, "dx_curvature_mm", "dy_curvature_mm")
    return Measured(columns(rows, "x_frame_mm", "y_frame_mm"), air)


def is_estimated(settings: Settings) -> bool:
    """Is any part of the camera unknown?"""
    return settings["estimate"] != "none" or settings["calibrate"] != "none" or settings["camera"] == "weighted"


def camera_unknowns(
    photo: Row, tables: Tables, rows: Sequence[Row], settings: Settings, sigma0: float
) -> CameraUnknowns | None:
    """What is to be estimated, with the standard deviations of photo.toml; None when the camera is known.

    `rows` of image_point. --estimate names elements, --camera weighted adds those with a standard deviation,
    --free-camera lets the named ones free.
    """
    if not is_estimated(settings):
        return None
    sigmas = _sigmas(photo, tables)
    named = [] if settings["estimate"] == "none" else str(settings["estimate"]).split(",")
    weighted = list(sigmas) if settings["camera"] == "weighted" else []
    if settings["camera"] == "weighted" and not weighted:
        raise OrientError(
            "photo.toml gives no standard deviation of the camera, but --camera weighted was asked",
            "Give sigma_f_mm, sigma_x0_mm, sigma_y0_mm in [camera], or leave --camera weighted out.",
        )
    names = tuple(name for name in INTERIOR if name in {*named, *weighted})
    is_free = bool(settings["free_camera"])
    given = [np.inf if is_free and name in named else sigmas.get(name, np.inf) for name in names]
    camera = _with_lens(given_camera(photo, tables), names, str(settings["distortion"]))
    return CameraUnknowns(names, camera, measured_of(rows), (np.array(given, dtype=np.float64) / sigma0) ** 2)


def with_element(unknowns: CameraUnknowns, name: str, photo: Row, tables: Tables, sigma0: float) -> CameraUnknowns:
    """One element more, with its standard deviation if photo.toml has one."""
    names = tuple(each for each in INTERIOR if each in {*unknowns.names, name})
    sigma = _sigmas(photo, tables).get(name, np.inf)
    known = dict(zip(unknowns.names, unknowns.cofactors.tolist(), strict=True)) | {name: (sigma / sigma0) ** 2}
    camera = _with_lens(unknowns.camera, names, AS_GIVEN)
    return CameraUnknowns(names, camera, unknowns.measured, np.array([known[each] for each in names]))


def _sigmas(photo: Row, tables: Tables) -> dict[str, float]:
    own = {name: number(photo, column) for name, column in OWN_SIGMAS.items()}
    lens = {str(row["name"]): required(row, "sigma") for row in tables.get("camera_sigma", ())}
    return {name: sigma for name, sigma in own.items() if sigma is not None} | lens


def _with_lens(camera: Camera, names: Sequence[str], asked: str) -> Camera:
    """The camera with a model that can take the coefficients: Brown, as a correction unless another way was asked."""
    model, direction = camera.distortion.model, camera.distortion.direction
    if asked != AS_GIVEN and model != "none" and asked != direction:
        raise OrientError(
            f"--distortion {asked} was asked, but the lens of photo.toml is given as {direction}",
            "Leave --distortion out: the coefficients keep the definition of photo.toml.",
        )
    lens = [name for name in names if name in LENS]
    if model == "radial_table" and lens:
        raise OrientError(
            f"{lens[0]} cannot be estimated: the distortion of photo.toml is a radial table",
            'Give the lens as model = "brown" in [camera.distortion], or estimate f, x0, y0 only.',
        )
    if model != "none" or (asked == AS_GIVEN and not lens):
        return camera
    brown = Distortion("brown", "correction" if asked == AS_GIVEN else asked, {}, None, camera.f_mm)
    return Camera(camera.f_mm, camera.x0_mm, camera.y0_mm, brown)


def unit_of(name: str, camera: Camera) -> str:
    """Unit of an element: mm for lengths, powers of mm for Brown's coefficients, 1 for OpenCV's and the affinity."""
    if name in OWN_SIGMAS:
        return "mm"
    return "1" if name not in POWERS or camera.distortion.model == "opencv" else f"mm^-{POWERS[name]}"


def adjusted_camera(photo: Row, photo_tables: Tables, resection: Tables) -> tuple[Camera, tuple[str, ...]] | None:
    """The camera after a resection that estimated the named elements; None when the camera was known."""
    rows = resection.get("adjusted_camera", ())
    if not rows:
        return None
    row, camera = rows[0], given_camera(photo, photo_tables)
    # the file hands rows back by name; cofactors are in the order of INTERIOR
    elements = sorted(resection.get("camera_element", ()), key=lambda one: INTERIOR.index(str(one["unknown"])))
    names = tuple(str(element["unknown"]) for element in elements)
    lens = Distortion(
        str(row["distortion_model"]),
        str(row["distortion_direction"]),
        camera.distortion.coefficients,
        camera.distortion.table,
        required(row, "f_mm"),
    )
    camera = Camera(camera.f_mm, camera.x0_mm, camera.y0_mm, lens)
    return camera.with_values(names, np.array([required(element, "value") for element in elements])), names


def camera_effect(camera: Camera, names: Sequence[str], measured: Measured, shift: Array) -> tuple[Array, Array, Array]:
    """Corrected coordinates (n, 2) of readings, their partials by the reading and by the elements.

    (n, 2, 2) and (n, 2, m): d(x, y) = H^-1 dq - H^-1 A dc at a fixed ground point, from v = h(F; c) - G(c),
    H = dv/dF, A = dv/dc; where v is that of a corrected coordinate, the reading goes in as it is (conventions 4).
    `shift` (n, 2) [mm] is added to G: what the adjusted interior orientation moves.
    """
    if camera.is_from_ideal:
        image = corrected(camera, Measured(measured.frame + shift, measured.air))
    else:
        image = corrected(camera, measured) + shift
    equations = camera_equations(camera, names, image, measured)
    by_reading = np.asarray(np.linalg.inv(equations.by_computed), dtype=np.float64)
    return image, by_reading, -by_reading @ equations.by_elements
