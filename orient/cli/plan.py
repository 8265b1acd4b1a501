"""The command `plan`: how sure the orientation and the ground will be, before anything is measured."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orient.cli.inputs import Decimal, Encoding, IgnoreColumns, MaxRows
from orient.cli.options import AsJson
from orient.intake.options import MAX_ROWS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from orient.intake.layout import Frame
    from orient.intake.options import ReadOptions
    from orient.solvers.planned_photo import Sigmas

GRID = re.compile(r"grid:([1-9][0-9]{0,2})x([1-9][0-9]{0,2})", re.ASCII)
MOST_PER_SIDE = 100
MAP_SIDE = 5
LAYOUTS = "Give grid:3x3, corners, gruber, or a CSV file with the columns point,x_mm,y_mm and, if you like, dZ_m."


def register(app: typer.Typer) -> None:
    app.command()(plan)


@dataclass(frozen=True, slots=True)
class Camera:
    """f, the frame and sigma of a reading, all in mm."""

    f: float
    frame: "Frame"
    sigma: float


@dataclass(frozen=True, slots=True)
class Layout:
    """The control to be: names, (n, 2) [mm] from the principal point, heights (n,) [m] above the mean ground."""

    text: str
    names: tuple[str, ...]
    image: "NDArray[np.float64]"
    relief: "NDArray[np.float64]"


def plan(
    height_m: Annotated[float, typer.Option("--height-m", help="Height of the camera above the mean ground.")],
    layout: Annotated[
        str, typer.Option("--layout", metavar="grid:NxM|corners|gruber|FILE.csv", help="Where the control will lie.")
    ] = "grid:3x3",
    photo: Annotated[
        Path | None, typer.Option("--photo", metavar="photo.toml", help="Take the camera from this file.")
    ] = None,
    f_mm: Annotated[float | None, typer.Option("--f-mm", help="Focal length; goes before the file's.")] = None,
    frame_mm: Annotated[
        tuple[float, float] | None, typer.Option("--frame-mm", metavar="W H", help="Width and height of the frame.")
    ] = None,
    sigma_um: Annotated[float | None, typer.Option("--sigma-um", help="Sigma of an image coordinate.")] = None,
    control_sigma_m: Annotated[float, typer.Option("--control-sigma-m", help="Sigma of the control in plan.")] = 0.0,
    height_sigma_m: Annotated[float, typer.Option("--height-sigma-m", help="Sigma of the control in height.")] = 0.0,
    ground_height_sigma_m: Annotated[
        float, typer.Option("--ground-height-sigma-m", help="Sigma of the heights of new points.")
    ] = 0.0,
    tilt_deg: Annotated[
        float, typer.Option("--tilt-deg", help="How far the camera looks away from straight down, towards its top.")
    ] = 0.0,
    margin_mm: Annotated[float, typer.Option("--margin-mm", help="Grid and corners stay so far from the edge.")] = 0.0,
    decimal: Decimal = "point",
    encoding: Encoding = "utf-8",
    ignore_columns: IgnoreColumns = False,
    max_rows: MaxRows = MAX_ROWS,
    as_json: AsJson = False,
) -> None:
    """Predict the orientation and the accuracy of the ground from a layout of control, before measuring."""
    from math import radians

    from orient.intake.text_file import read_options
    from orient.report.plan import show_plan
    from orient.solvers import planning
    from orient.solvers.planned_photo import planned_photo

    camera = _camera(photo, f_mm, frame_mm, sigma_um)
    height = _checked("--height-m", height_m, 1e-3, 1e8, "m")
    tilt = _checked("--tilt-deg", tilt_deg, -90, 90, "degrees")
    options = read_options(decimal, encoding, ignore_columns, max_rows)
    chosen = _layout(layout, camera.frame, _checked("--margin-mm", margin_mm, 0, 1e4, "mm"), options)
    new_heights = _checked("--ground-height-sigma-m", ground_height_sigma_m, 0, 1e8, "m")
    sigmas = _sigmas(camera, control_sigma_m, height_sigma_m)
    planned = planned_photo(
        chosen.image, chosen.names, camera.f, height, sigmas, relief=chosen.relief, tilt=radians(tilt)
    )
    made = planning.plan(planned, _spanned(camera.frame, MAP_SIDE, MAP_SIDE, 0.0), new_heights)
    show_plan(made, f"{chosen.text}, frame {camera.frame.width:g} x {camera.frame.height:g} mm", tilt, as_json)


def _checked(option: str, value: float, low: float, high: float, unit: str) -> float:
    from orient.errors import UsageError
    from orient.intake.findings import BadValue
    from orient.intake.numbers import check_range

    try:
        return check_range(value, low, high, unit)
    except BadValue as bad:
        raise UsageError(f"{option}: {bad.message}", bad.hint) from None


def _sigmas(camera: Camera, control_m: float, height_m: float) -> "Sigmas":
    from orient.solvers.planned_photo import Sigmas

    return Sigmas(
        camera.sigma,
        _checked("--control-sigma-m", control_m, 0, 1e8, "m"),
        _checked("--height-sigma-m", height_m, 0, 1e8, "m"),
    )


def _camera(
    photo: Path | None, f_mm: float | None, frame_mm: tuple[float, float] | None, sigma_um: float | None
) -> Camera:
    """The file's camera, what the options say before what it says."""
    from orient.intake.layout import Frame

    known = _camera_of_file(photo) if photo else {}
    given = {
        "f_mm": f_mm,
        "frame_width_mm": frame_mm and frame_mm[0],
        "frame_height_mm": frame_mm and frame_mm[1],
        "sigma_image_mm": None if sigma_um is None else sigma_um / 1000,
    }
    known |= {name: value for name, value in given.items() if value is not None}
    _check_complete(known)
    frame = Frame(
        width=_checked("--frame-mm", known["frame_width_mm"], 0.5, 1e4, "mm"),
        height=_checked("--frame-mm", known["frame_height_mm"], 0.5, 1e4, "mm"),
        centre=(known.get("centre_x", 0.0), known.get("centre_y", 0.0)) if frame_mm is None else (0.0, 0.0),
    )
    return Camera(
        f=_checked("--f-mm", known["f_mm"], 0.1, 1e5, "mm"),
        frame=frame,
        sigma=_checked("--sigma-um", 1000 * known["sigma_image_mm"], 1e-6, 1e6, "um") / 1000,
    )


def _check_complete(known: dict[str, float]) -> None:
    from orient.errors import UsageError

    options = {"f_mm": "--f-mm", "frame_width_mm": "--frame-mm", "sigma_image_mm": "--sigma-um"}
    missing = [option for name, option in options.items() if name not in known]
    if missing:
        hint = "Give --photo photo.toml, or --f-mm, --frame-mm W H and --sigma-um."
        raise UsageError(f"the camera is not known: {', '.join(missing)} missing", hint)


def _camera_of_file(path: Path) -> dict[str, float]:
    from orient.geometry.frame_centre import frame_centre
    from orient.intake.options import ReadOptions
    from orient.intake.project_folder import read_input

    row = read_input("photo", [path], ReadOptions()).tables["photo"][0]
    keys = ("f_mm", "frame_width_mm", "frame_height_mm", "sigma_image_mm", "x0_mm", "y0_mm")
    known = {key: float(value) for key in keys if isinstance(value := row[key], int | float)}
    x, y = frame_centre(row)
    return known | {"centre_x": x - known["x0_mm"], "centre_y": y - known["y0_mm"]}


def _layout(text: str, frame: "Frame", margin: float, options: "ReadOptions") -> Layout:
    import numpy as np

    from orient.errors import UsageError
    from orient.geometry.vertical_photo import gruber_layout

    if 2 * margin >= min(frame.width, frame.height):
        raise UsageError(f"--margin-mm: {margin:g} mm leave nothing of the frame", "Give a smaller margin.")
    if text == "gruber":
        image = gruber_layout(frame.width, frame.height) + np.array(frame.centre)
    elif sides := (2, 2) if text == "corners" else _grid_sides(text):
        image = _spanned(frame, *sides, margin)
    else:
        return _layout_of_file(text, frame, options)
    return Layout(text, tuple(str(i) for i in range(1, len(image) + 1)), image, np.zeros(len(image)))


def _grid_sides(text: str) -> tuple[int, int] | None:
    from orient.errors import UsageError

    sides = GRID.fullmatch(text)
    if sides is None:
        return None
    columns, rows = int(sides[1]), int(sides[2])
    if max(columns, rows) > MOST_PER_SIDE:
        raise UsageError(f"--layout: {text} has more than {MOST_PER_SIDE} points in a row", LAYOUTS)
    return columns, rows


def _spanned(frame: "Frame", columns: int, rows: int, margin: float) -> "NDArray[np.float64]":
    import numpy as np

    from orient.geometry.vertical_photo import grid_layout

    grid = grid_layout(frame.width - 2 * margin, frame.height - 2 * margin, columns, rows)
    return np.asarray(grid + np.array(frame.centre), dtype=np.float64)


def _layout_of_file(text: str, frame: "Frame", options: "ReadOptions") -> Layout:
    import numpy as np

    from orient.errors import UsageError
    from orient.intake.findings import shown
    from orient.intake.layout import read_layout

    path = Path(text)
    if path.suffix.lower() != ".csv":
        raise UsageError(f'there is no layout "{shown(text)}"', LAYOUTS)
    points = read_layout(path, frame, options)
    image = np.array([(point.x, point.y) for point in points]).reshape(-1, 2)
    return Layout(
        shown(path.name), tuple(point.name for point in points), image, np.array([point.dZ for point in points])
    )
