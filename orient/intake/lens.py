"""[camera.distortion] of photo.toml: a named model, a named direction, and coefficients or a radial table."""

import math
from dataclasses import dataclass, field
from itertools import pairwise

from orient.geometry.frame_centre import frame_centre
from orient.intake.camera import Columns
from orient.intake.findings import BadValue
from orient.intake.numbers import check_range
from orient.intake.toml_file import Section, as_number

MODELS = ("none", "brown", "opencv", "radial_table")
DIRECTIONS = ("correction", "displacement", "ideal_to_distorted")
IMPLIED_DIRECTION = {"opencv": "ideal_to_distorted", "radial_table": "displacement"}
COEFFICIENTS = {
    "none": (),
    "brown": ("k0", "k1", "k2", "k3", "p1", "p2", "s1", "s2", "s3", "s4"),
    "opencv": ("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "s1", "s2", "s3", "s4"),
    "radial_table": (),
}
LARGEST_COEFFICIENT = 1e6
WITH_SIGMA = ("k1", "k2", "k3", "p1", "p2")


@dataclass(frozen=True, slots=True)
class Lens:
    """The distortion as it is stored; direction `none` goes with model `none`."""

    model: str
    direction: str
    coefficients: dict[str, float]
    table: tuple[tuple[float, float], ...] = ()
    sigmas: dict[str, float] = field(default_factory=dict)


NO_DISTORTION = Lens("none", "none", {})


def read_lens(camera: Section) -> Lens:
    if not camera.has("distortion"):
        return NO_DISTORTION
    if isinstance(camera.value("distortion"), list):
        camera.problem("distortion", "which distortion model?", f"Write [camera.distortion] model = {_one_of(MODELS)}")
        return NO_DISTORTION
    section = camera.section("distortion")
    model = section.word("model", MODELS)
    if not section.has("model"):
        section.problem("", "which distortion model?", f"Write model = {_one_of(MODELS)}")
    if model is None:
        return NO_DISTORTION
    direction = _direction(section, model)
    coefficients = {name: value for name in COEFFICIENTS[model] if (value := _coefficient(section, name)) is not None}
    table = _radial_table(section) if model == "radial_table" else ()
    can_have_sigma = [name for name in WITH_SIGMA if name in COEFFICIENTS[model]]
    sigmas = {name: sigma for name in can_have_sigma if (sigma := section.sigma(f"sigma_{name}")) is not None}
    section.finish()
    if COEFFICIENTS[model] and not any(name in section.data for name in COEFFICIENTS[model]):
        section.problem("", f"the model {model} has no coefficients", f"Give {_one_of(COEFFICIENTS[model])}")
    return Lens(model, direction, coefficients, table, sigmas)


def _one_of(words: tuple[str, ...]) -> str:
    return f"{', '.join(words[:-1])} or {words[-1]}"


def _direction(section: Section, model: str) -> str:
    given = section.word("direction", DIRECTIONS)
    if model == "none":
        return "none"
    implied = IMPLIED_DIRECTION.get(model)
    if implied and given and given != implied:
        section.problem("direction", f"the model {model} means direction = {implied}", "Leave the direction out")
    if not implied and not section.has("direction"):
        section.problem("", f"direction is required for the model {model}: {_one_of(DIRECTIONS)}")
    return implied or given or "none"


def _coefficient(section: Section, name: str) -> float | None:
    return section.number(name, -LARGEST_COEFFICIENT, LARGEST_COEFFICIENT)


def _radial_table(section: Section) -> tuple[tuple[float, float], ...]:
    """Rows (radius, distortion) in mm; the radii grow."""
    value = section.value("table")
    hint = "Write table = [[r_mm, d_mm], ...], radii growing"
    rows = value if isinstance(value, list) else []
    if len(rows) < 2 or not all(isinstance(row, list) and len(row) == 2 for row in rows):
        section.problem("table", "table: expected at least 2 rows of radius and distortion", hint)
        return ()
    try:
        radii = [check_range(as_number(row[0]), 0, 1e4, "mm") for row in rows]
        distortions = [check_range(as_number(row[1]), -1e3, 1e3, "mm") for row in rows]
    except BadValue as bad:
        section.problem("table", f"table: {bad.message}", hint)
        return ()
    if any(after <= before for before, after in pairwise(radii)):
        section.problem("table", "table: the radii do not grow", hint)
    return tuple(zip(radii, distortions, strict=True))


def check_fold(camera: Section, lens: Lens, row: Columns) -> None:
    """Within the frame every measured position must have one ideal position and the other way round."""
    if lens.model == "none" or not isinstance(row["f_mm"], float):
        return
    import numpy as np

    from orient.geometry.distortion import Distortion, fold_radius

    table = np.array(lens.table) if lens.table else None
    distortion = Distortion(lens.model, lens.direction, lens.coefficients, table, row["f_mm"])
    radius = fold_radius(distortion, _furthest_corner(row))
    if radius is not None:
        hint = "Check the unit and the direction of the coefficients"
        camera.problem("distortion", f"distortion: radius {radius:.1f} mm and beyond is not invertible", hint)


def _furthest_corner(row: Columns) -> float:
    """Distance [mm] of the frame's furthest corner from the principal point."""
    middle_x, middle_y = frame_centre(row)
    x0, y0, width, height = (float(row[k] or 0) for k in ("x0_mm", "y0_mm", "frame_width_mm", "frame_height_mm"))
    return math.hypot(abs(x0 - middle_x) + width / 2, abs(y0 - middle_y) + height / 2)
