"""The camera of photo.toml: [camera], [pixels] and [fiducials] as columns of the table `photo`."""

import math

from orient.geometry.frame_centre import frame_centre
from orient.intake.findings import BadValue, shown
from orient.intake.names import parse_name
from orient.intake.numbers import check_range, plain
from orient.intake.toml_file import Section, as_number
from orient.values import Row, Scalar

LONGEST_FRAME_MM = 10_000.0
MOST_MARKS = 100
MARKS_NEEDED = {"similarity": 2, "affine": 3, "projective": 4}
MARKS_HINTS = {
    "similarity": "need 2 at different places",
    "affine": "need 3 that do not lie on a line",
    "projective": "need 4, no 3 of them on a line",
}
FLAT = 1e-6
"""Height of a triangle over its longest side, as a part of that side, below which it is taken for a line."""

Columns = dict[str, Scalar]
Mark = tuple[str, float, float]


def read_pixels(pixels: Section, has_marks: bool) -> Columns:
    """Pixel size, image size and the frame origin; the centre of the first pixel is column 0, row 0."""
    size = pixels.number("size_mm", 1e-5, 10, "mm")
    if pixels.data and not pixels.has("size_mm"):
        pixels.missing("size_mm")
    width, height = _image_size(pixels)
    origin = (pixels.number("origin_col", -1e6, 1e6), pixels.number("origin_row", -1e6, 1e6))
    if (origin[0] is None) != (origin[1] is None):
        pixels.problem("", "give both origin_col and origin_row, or none for the centre of the image")
    if origin == (None, None) and width is not None and height is not None:
        origin = ((width - 1) / 2, (height - 1) / 2)
    elif origin == (None, None) and has_marks and size is not None:
        origin = (0.0, 0.0)
    elif origin == (None, None) and pixels.data:
        pixels.problem("", "image is missing: without it give origin_col and origin_row")
    columns: Columns = {
        "pixel_size_mm": size,
        "origin_col_px": origin[0],
        "origin_row_px": origin[1],
        "x_axis": pixels.word("x_axis", ("right", "left")) or "right",
        "y_axis": pixels.word("y_axis", ("up", "down")) or "up",
        "image_width_px": width,
        "image_height_px": height,
    }
    pixels.finish()
    return columns


def _image_size(pixels: Section) -> tuple[int | None, int | None]:
    value = pixels.value("image")
    if value is None:
        return None, None
    if not isinstance(value, list) or len(value) != 2:
        pixels.problem("image", "image: expected a list of 2 whole numbers, columns and rows")
        return None, None
    try:
        for each in value:
            if isinstance(each, bool) or not isinstance(each, int):
                raise BadValue("expected 2 whole numbers, columns and rows")
            check_range(each, 1, 1_000_000, "px")
    except BadValue as bad:
        pixels.problem("image", f"image: {bad.message}")
        return None, None
    return int(value[0]), int(value[1])


def read_camera(camera: Section, pixels: Columns) -> Columns:
    """Focal length, principal point, frame and standard deviations, all in mm."""
    size = pixels["pixel_size_mm"]
    pixel_size = size if isinstance(size, float) else None
    columns: Columns = {
        "f_mm": _mm_or_px(camera, "f", (0.1, 100_000.0), pixel_size),
        "x0_mm": camera.number("x0_mm", -LONGEST_FRAME_MM, LONGEST_FRAME_MM, "mm") or 0.0,
        "y0_mm": camera.number("y0_mm", -LONGEST_FRAME_MM, LONGEST_FRAME_MM, "mm") or 0.0,
        "sigma_f_mm": camera.sigma("sigma_f_mm"),
        "sigma_x0_mm": camera.sigma("sigma_x0_mm"),
        "sigma_y0_mm": camera.sigma("sigma_y0_mm"),
        "sigma_image_mm": _mm_or_px(camera, "sigma_image", None, pixel_size),
    }
    columns["frame_width_mm"], columns["frame_height_mm"] = _frame(camera, pixels, pixel_size)
    return columns


def _mm_or_px(
    camera: Section, name: str, limits_mm: tuple[float, float] | None, pixel_size: float | None
) -> float | None:
    """A length given as NAME_mm or NAME_px. Without limits it is a standard deviation."""
    in_mm, in_px = f"{name}_mm", f"{name}_px"
    if camera.has(in_mm) and camera.has(in_px):
        camera.problem(in_mm, f"give {in_mm} or {in_px}, not both")
        return None
    if camera.has(in_mm):
        return camera.number(in_mm, *limits_mm, "mm") if limits_mm else _image_sigma(camera, in_mm)
    if not camera.has(in_px):
        camera.missing(in_mm, f"Give {in_mm} or {in_px}")
        return None
    pixels = camera.number(in_px, 1, 1e8, "px") if limits_mm else _image_sigma(camera, in_px)
    if pixel_size is None:
        camera.problem(in_px, f"{in_px} needs the size of a pixel", "Give size_mm in [pixels]")
        return None
    if pixels is None:
        return None
    length = pixels * pixel_size
    if limits_mm and not limits_mm[0] <= length <= limits_mm[1]:
        camera.problem(in_px, f"{in_px}: {plain(length)} mm is not in {plain(limits_mm[0])} … {plain(limits_mm[1])} mm")
    return length


def _image_sigma(camera: Section, key: str) -> float | None:
    value = camera.number(key, -1e300, 1000)
    if value is not None and value < 1e-9:
        camera.problem(key, f"{key}: must be > 0")
        return None
    return value


def _frame(camera: Section, pixels: Columns, pixel_size: float | None) -> tuple[float | None, float | None]:
    if camera.has("frame_mm"):
        frame = camera.number_list("frame_mm", 2, 0.5, LONGEST_FRAME_MM, "mm")
        return (frame[0], frame[1]) if frame else (None, None)
    width, height = pixels["image_width_px"], pixels["image_height_px"]
    if isinstance(width, int) and isinstance(height, int) and pixel_size is not None:
        return width * pixel_size, height * pixel_size
    camera.missing("frame_mm", "Give frame_mm = [width, height], or size_mm and image in [pixels]")
    return None, None


def check_principal_point(camera: Section, row: Row) -> None:
    """Outside the frame: a warning; further than two frame widths from its centre: refused."""
    x0, y0, width, height = (row[key] for key in ("x0_mm", "y0_mm", "frame_width_mm", "frame_height_mm"))
    if not (isinstance(x0, float) and isinstance(y0, float)):
        return
    if not (isinstance(width, float) and isinstance(height, float)):
        return
    middle_x, middle_y = frame_centre(row)
    place = f"principal point ({plain(x0)}, {plain(y0)}) mm"
    if max(abs(x0 - middle_x), abs(y0 - middle_y)) > 2 * max(width, height):
        camera.problem("x0_mm", f"{place} lies more than two frame widths outside the frame")
    elif abs(x0 - middle_x) > width / 2 or abs(y0 - middle_y) > height / 2:
        camera.warn("principal_point_outside", "", f"{camera.file}: {place} lies outside the frame")


def read_marks(fiducials: Section) -> tuple[str, list[Mark]]:
    """The transformation (none without marks) and the calibrated marks."""
    transformation = fiducials.word("transformation", tuple(MARKS_NEEDED)) or "affine"
    section = fiducials.section("marks")
    if len(section.data) > MOST_MARKS:
        fiducials.problem("marks", f"fiducial marks: {len(section.data)} are more than {MOST_MARKS}")
        return "none", []
    without_marks = bool(fiducials.data) and not section.data
    marks = [mark for key in section.data if (mark := _mark(section, key)) is not None]
    fiducials.finish()
    all_read = bool(marks) and len(marks) == len(section.data)
    if without_marks or (all_read and not _marks_suffice(transformation, marks)):
        fiducials.problem("marks", f"fiducial marks: {MARKS_HINTS[transformation]}")
    return (transformation if marks else "none"), marks


def _mark(section: Section, key: str) -> Mark | None:
    value = section.value(key)
    try:
        name = parse_name(key)
        if not isinstance(value, list) or len(value) != 2:
            raise BadValue("expected [x, y] in mm")
        x, y = (check_range(as_number(each), -LONGEST_FRAME_MM, LONGEST_FRAME_MM, "mm") for each in value)
    except BadValue as bad:
        section.problem(key, f'mark "{shown(key)}": {bad.message}', bad.hint)
        return None
    return name, x, y


def _marks_suffice(transformation: str, marks: list[Mark]) -> bool:
    needed = MARKS_NEEDED[transformation]
    places = [(x, y) for _, x, y in marks]
    if len(places) < needed or len(set(places)) < len(places):
        return False
    if transformation == "similarity":
        return True
    return _spread(places) > FLAT and (transformation == "affine" or _four_in_general_place(places))


def _spread(places: list[tuple[float, float]]) -> float:
    """Largest distance from the line through the two places furthest apart from the first, as a part of it."""
    (x0, y0) = places[0]
    (x1, y1) = max(places, key=lambda place: math.hypot(place[0] - x0, place[1] - y0))
    length = math.hypot(x1 - x0, y1 - y0)
    return max(abs((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)) for x, y in places) / length**2


def _four_in_general_place(places: list[tuple[float, float]]) -> bool:
    """A projective transformation is singular when all marks but one lie on a line."""
    return all(_spread(places[:i] + places[i + 1 :]) > FLAT for i in range(len(places)))
