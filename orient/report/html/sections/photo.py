"""The photo, its camera and the frame with everything that was measured in it."""

from orient.report.html import kinds
from orient.report.html.blocks import Block, Facts, Paragraph, Section, Table
from orient.report.html.cells import digits, fixed, in_full, joined, name, scientific
from orient.report.html.evidence import Evidence
from orient.report.language import mark, tr
from orient.values import Row

KNOWN_TO = {
    "f_mm": mark("focal length f, mm"),
    "x0_mm": mark("principal point x0, mm"),
    "y0_mm": mark("principal point y0, mm"),
    "frame_width_mm": mark("width of the frame, mm"),
    "frame_height_mm": mark("height of the frame, mm"),
    "sigma_image_mm": mark("standard deviation of a reading a priori, mm"),
    "pixel_size_mm": mark("size of a pixel, mm"),
    "image_width_px": mark("columns of the image"),
    "image_height_px": mark("rows of the image"),
    "interior_transformation": mark("interior orientation by"),
    "distortion_model": mark("distortion model"),
    "distortion_direction": mark("distortion is applied as"),
    "refraction": mark("refraction"),
    "ground_crs": mark("coordinate system of the ground"),
    "ellipsoid": mark("ellipsoid"),
    "a_m": mark("semi-major axis a, m"),
    "inverse_flattening": mark("inverse flattening 1/f"),
    "central_meridian_deg": mark("central meridian, deg"),
    "handedness": mark("handedness of the local ground"),
    "ground_height_m": mark("mean height of the ground, m"),
    "camera_height_m": mark("approximate height of the camera, m"),
    "curvature_radius_m": mark("radius for the earth curvature, m"),
}
SIGMAS = {"f_mm": "sigma_f_mm", "x0_mm": "sigma_x0_mm", "y0_mm": "sigma_y0_mm"}
CAMERA_WORDS = frozenset({0, 1, 7})


def section(evidence: Evidence) -> Section | None:
    photo = evidence.photo
    if photo is None:
        return None
    blocks: list[Block] = []
    if evidence.one("resection", "orientation") is not None:
        note = tr(
            "Vectors show where the orientation puts each point, seen from where it was measured. Ellipses show how "
            "sure "
            "the ground point is, in the scale of the image; both are magnified as the bar says."
        )
        blocks.append(evidence.figure("residuals", tr("The frame with points, residuals and error ellipses"), note))
    blocks += [Facts(tr("Photo and camera, as given"), _facts(photo)), *_distortion(evidence), *_estimated(evidence)]
    return Section("photo", tr("Photo and camera"), blocks)


def _facts(photo: Row) -> list[tuple[str, str]]:
    pairs = [(tr("photo"), name(photo["name"]))]
    for column, told in (("taken_on", tr("taken on")), ("image_file", tr("image file"))):
        if photo[column]:
            pairs.append((told, name(photo[column])))
    pairs.append((tr("platform"), kinds.word(photo["platform"])))
    for column, told in KNOWN_TO.items():
        if photo[column] is not None and photo[column] != "none":
            sigma = photo[SIGMAS[column]] if column in SIGMAS else None
            pairs.append((tr(told), joined([_given(photo[column]), "" if sigma is None else f"± {_given(sigma)}"])))
    return pairs


def _given(value: object) -> str:
    """What the user wrote; a number that was computed from it without its rounding."""
    return f"{value:.10g}" if isinstance(value, float) else name(value)


def _distortion(evidence: Evidence) -> list[Block]:
    rows = evidence.rows("photo", "distortion_coefficient")
    if not rows:
        return []
    cells = [[name(row["name"]), in_full(row["value"])] for row in rows]
    return [Table(tr("Distortion, as given"), [tr("coefficient"), tr("value")], cells)]


def _estimated(evidence: Evidence) -> list[Block]:
    """The camera's elements that were unknowns; their correlations stand with those of the orientation."""
    rows = evidence.rows("resection", "camera_element")
    if not rows:
        return []
    cells = [
        [
            name(row["unknown"]),
            name(row["unit"]),
            digits(row["value_apriori"], 8),
            tr("free") if row["sigma_apriori"] is None else digits(row["sigma_apriori"], 3),
            digits(row["value"], 10),
            "" if row["sigma"] is None else scientific(float(row["sigma"])),
            fixed(row["t"], 1),
            tr("yes") if row["is_significant"] else tr("no"),
        ]
        for row in rows
    ]
    headers = [
        tr("element"), tr("unit"), tr("a priori"), tr("σ a priori"), tr("adjusted"), "σ", "t", tr("significant")
    ]  # fmt: skip
    limit = fixed(rows[0]["t_limit"], 2)
    note = tr("t = change / σ; significant above {limit} (1 %). Correlations: see the orientation.", limit=limit)
    return [
        Table(tr("Estimated camera with standard deviations"), headers, cells, CAMERA_WORDS, note),
        *_steps(evidence),
    ]


def _steps(evidence: Evidence) -> list[Block]:
    rows = evidence.rows("resection", "calibration_step")
    if not rows:
        return []
    cells = [
        [
            str(row["step"]),
            name(row["unknown"]),
            kinds.word(row["decision"]),
            fixed(row["t"], 1),
            fixed(row["correlation"], 3),
            name(row["correlated_with"]),
        ]
        for row in rows
    ]
    headers = [tr("step"), tr("element"), tr("decision"), "t", tr("strongest correlation"), tr("with")]
    return [
        Paragraph(tr("The elements of the camera were tried one by one; each step takes the most significant one.")),
        Table(tr("Calibration by steps"), headers, cells, frozenset({1, 2, 5})),
    ]
