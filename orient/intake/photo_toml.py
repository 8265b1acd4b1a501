"""photo.toml: the photo, its camera, the ground it shows, and what is known before the orientation."""

import datetime
import re
from pathlib import Path

from orient.intake.camera import Columns, Mark, check_principal_point, read_camera, read_marks, read_pixels
from orient.intake.findings import Findings
from orient.intake.ground import check_name, read_curvature, read_ground, read_refraction, read_station
from orient.intake.known import read_known
from orient.intake.lens import Lens, check_fold, read_lens
from orient.intake.options import ReadOptions
from orient.intake.toml_file import Section, read_toml
from orient.values import InputTables, Row

PLATFORMS = ("space", "aerial", "terrestrial")
YEAR_OR_MONTH = re.compile(r"[0-9]{4}(-[0-9]{2})?", re.ASCII)


def read_photo(path: Path, file: str, options: ReadOptions, findings: Findings) -> InputTables | None:
    """The tables of the stage `photo`, or None when there are problems."""
    before = findings.count(file)
    document = read_toml(path, file, options, findings)
    if document is None:
        return None
    row, lens, marks = _sections(document)
    known = read_known(document, row["ground_kind"])
    document.finish()
    if findings.count(file) > before:
        return None
    check_principal_point(document.section("camera"), row)
    check_fold(document.section("camera"), lens, row)
    if findings.count(file) > before:
        return None
    return InputTables("photo", _tables(row, lens, marks, known), (), (file,))


def _sections(document: Section) -> tuple[Columns, Lens, list[Mark]]:
    camera = document.section("camera")
    transformation, marks = read_marks(document.section("fiducials"))
    row: Columns = {"interior_transformation": transformation}
    row |= _read_identity(document)
    row |= read_pixels(document.section("pixels"), bool(marks))
    row |= read_camera(camera, row)
    lens = read_lens(camera)
    camera.finish()
    row |= {"distortion_model": lens.model, "distortion_direction": lens.direction}
    row |= read_ground(document.section("ground"))
    row |= read_station(document.section("station"), row["ground_kind"])
    row |= read_refraction(document.section("refraction"), row)
    row |= read_curvature(document, row)
    return row, lens, marks


def _read_identity(document: Section) -> Columns:
    photo = document.section("photo")
    for key in ("name", "platform"):
        if not photo.has(key):
            photo.missing(key, f"Give one of {', '.join(PLATFORMS)}" if key == "platform" else "")
    columns: Columns = {
        "name": check_name(photo, "name"),
        "taken_on": _read_date(photo, "date"),
        "image_file": photo.text("image"),
        "platform": photo.word("platform", PLATFORMS),
    }
    photo.finish()
    return columns


def _read_date(photo: Section, key: str) -> str | None:
    """ISO 8601: a TOML date or time, or text; a year or a month is enough."""
    value = photo.value(key)
    if value is None:
        return None
    if isinstance(value, datetime.date):
        return value.isoformat()
    text = photo.text(key)
    if text is None:
        return None
    complete = f"{text}-01-01"[:10] if YEAR_OR_MONTH.fullmatch(text) else text
    try:
        datetime.datetime.fromisoformat(complete)
    except ValueError:
        photo.problem(key, f"{key}: not a date", "Write 1971-07-31, 1971-07 or 1971")
        return None
    return text


def _tables(row: Columns, lens: Lens, marks: list[Mark], known: list[Row]) -> dict[str, list[Row]]:
    tables: dict[str, list[Row]] = {
        "photo": [row],
        "distortion_coefficient": [{"name": name, "value": value} for name, value in lens.coefficients.items()],
        "camera_sigma": [{"name": name, "sigma": sigma} for name, sigma in lens.sigmas.items()],
        "distortion_radial": [{"radius_mm": r, "distortion_mm": d} for r, d in lens.table],
        "fiducial_mark": [{"mark": name, "x_mm": x, "y_mm": y} for name, x, y in marks],
        "known_element": known,
    }
    return {name: rows for name, rows in tables.items() if rows}
