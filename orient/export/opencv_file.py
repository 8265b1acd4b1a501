"""rvec, tvec, K, dist for OpenCV: YAML or JSON that `cv2.FileStorage` reads, with the 6 x 6 covariance and the control.

image = K distort((D R'(P - S)) / z):  cv2.projectPoints(object_points, rvec, tvec, K, dist)
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orient.export import Format, Made, Options
from orient.export.opencv_camera import opencv_camera
from orient.export.pixels import pixel_grid
from orient.export.solved import Solved, ground_frame, provenance, read_solved, right_handed_axes, solved_points
from orient.geometry.opencv_exterior import opencv_exterior
from orient.geometry.opencv_lens import NAMES
from orient.pipeline.tables import Array

PARAMETERS = ("rvec_x", "rvec_y", "rvec_z", "tvec_x", "tvec_y", "tvec_z")
UNITS = ("rad", "rad", "rad", "m", "m", "m")
CONVENTION = (
    "x_cv = Rodrigues(rvec) P + tvec; x_cv along the columns, y_cv along the rows, z_cv away from the camera; "
    "pixel = K distort(x_cv/z_cv, y_cv/z_cv). Project with cv2.projectPoints(object_points, rvec, tvec, "
    "camera_matrix, distortion_coefficients)."
)
LONGEST_STRING = 1000
"""OpenCV reads strings up to 4096 bytes; an escaped letter takes up to four."""
LINE = 6


@dataclass(frozen=True, slots=True)
class Matrix:
    """Numbers (rows, columns) as OpenCV's own matrix type."""

    values: Array


def make(path: Path, form: Format, ending: str, name: str, options: Options) -> Made:
    """The export as pieces of text; `ending` tells YAML from JSON."""
    entries = _entries(read_solved(path, form), options)
    lines = json_pieces(entries) if ending == ".json" else yaml_pieces(entries)
    return Made((line.encode("utf-8") for line in lines), {})


def _entries(solved: Solved, options: Options) -> dict[str, object]:
    points = solved_points(solved)
    grid = pixel_grid(solved.photo, options.pixel_mm)
    camera = opencv_camera(solved, points, grid)
    exterior = opencv_exterior(solved.rotation, solved.station, np.append(grid.axes, -1.0))
    covariance = exterior.jacobian @ solved.covariance @ exterior.jacobian.T
    return {
        "format": "orient opencv 1",
        "convention": CONVENTION,
        "camera_matrix": Matrix(camera.K),
        "distortion_coefficients": Matrix(camera.coefficients[:, None]),
        "distortion_names": list(NAMES),
        "distortion_method": camera.method,
        "distortion_note": camera.told,
        **({} if camera.misfit_px is None else {"distortion_misfit_px": camera.misfit_px}),
        "rvec": Matrix(exterior.rvec[:, None]),
        "tvec": Matrix(exterior.tvec[:, None]),
        "covariance_parameters": list(PARAMETERS),
        "covariance_units": list(UNITS),
        "covariance": Matrix(covariance),
        "image_width": grid.width,
        "image_height": grid.height,
        "pixel": grid.in_words,
        "pixel_size_mm": grid.size_mm,
        "pixel_is_of_the_image": int(grid.is_real),
        "ground_frame": _plain(ground_frame(solved)),
        "point_names": [_short(name) for name in points.names],
        "point_roles": list(points.roles),
        "object_points": Matrix(points.ground),
        "image_points": Matrix(camera.image_points),
        "source": _plain(provenance(solved, right_handed_axes(solved))),
    }


def _plain(value: object) -> object:
    """Texts cut to what OpenCV reads, nothing left out that it cannot: it knows no null."""
    if isinstance(value, str):
        return _short(value)
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items() if inner is not None}
    return [_plain(inner) for inner in value] if isinstance(value, Sequence) else value


def _short(text: str) -> str:
    return text if len(text) <= LONGEST_STRING else f"{text[: LONGEST_STRING - 3]}..."


def _text(value: object) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def json_pieces(entries: Mapping[str, object]) -> Iterator[str]:
    """JSON with OpenCV's matrices, entry by entry."""
    opening = "{\n"
    for key, value in entries.items():
        yield f"{opening}  {_text(key)}: "
        opening = ",\n"
        if isinstance(value, Matrix):
            rows, columns = value.values.shape
            yield f'{{"type_id": "opencv-matrix", "rows": {rows}, "cols": {columns}, "dt": "d", "data": ['
            yield from _numbers(value.values)
            yield "]}"
        else:
            yield _text(value)
    yield "\n}\n"


def yaml_pieces(entries: Mapping[str, object]) -> Iterator[str]:
    """OpenCV's YAML 1.0; a flow collection of YAML is written like one of JSON."""
    yield "%YAML:1.0\n---\n"
    for key, value in entries.items():
        yield f"{key}: "
        if isinstance(value, Matrix):
            rows, columns = value.values.shape
            yield f"!!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: ["
            yield from _numbers(value.values)
            yield "]\n"
        else:
            yield from _flow(value, "   ")
            yield "\n"


def _flow(value: object, indent: str) -> Iterator[str]:
    """One entry to a line, so that no line grows with the number of points."""
    if isinstance(value, Mapping) and value:
        opening = "{"
        for key, inner in value.items():
            yield f"{opening}\n{indent}{key}: "
            yield from _flow(inner, indent + "   ")
            opening = ","
        yield " }"
    elif isinstance(value, list) and value:
        opening = "["
        for inner in value:
            yield f"{opening}\n{indent}"
            yield from _flow(inner, indent + "   ")
            opening = ","
        yield " ]"
    else:
        yield "[ ]" if value == [] else "{ }" if value == {} else _text(value)


def _numbers(values: Array) -> Iterator[str]:
    """Row by row, the shortest form that reads back to the same number; NaN and infinity are refused."""
    flat = values.ravel()
    for start in range(0, len(flat), LINE):
        part = flat[start : start + LINE].tolist()
        separator = ",\n      " if start else ("\n      " if len(flat) > LINE else " ")
        yield separator + ", ".join(_text(number) for number in part)
    yield " "
