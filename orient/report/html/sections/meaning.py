"""What the residuals mean in the real world, and what is good: in the image, in pixels, on the ground."""

import math
from collections.abc import Mapping, Sequence
from statistics import median

from orient.report.covariance import plan_sigma
from orient.report.html import kinds
from orient.report.html.blocks import Block, Paragraph, Section, Table
from orient.report.html.cells import MICROMETRES, MISSING, digits, fixed, joined, rms
from orient.report.html.evidence import Evidence
from orient.report.language import mark, tr, trn
from orient.values import Row

RESIDUAL = ("point", "role", "vx_mm", "vy_mm", "depth_m")
AS_CONTROL = 1.5
"""Check points may fit so many times worse than control: that has been fitted, they have not."""
WORDS = frozenset({0, 3})
ADJUSTED = mark(
    "The ground points have errors of their own and were adjusted as well: their residuals in the image are small "
    "because "
    "the points moved. Judge them on the ground."
)
ROLES = {"control": mark("Control points"), "check": mark("Check points")}


def section(evidence: Evidence) -> Section | None:
    found, photo = evidence.one("resection", "orientation"), evidence.photo
    if found is None or photo is None:
        return None
    rows = evidence.rows("resection", "image_residual", RESIDUAL)
    by_role = {role: [row for row in rows if row["role"] == role] for role in ROLES}
    moved = _ground_differences(evidence)
    blocks: list[Block] = [
        _sentence(role, chosen, photo, found, moved[role]) for role, chosen in by_role.items() if chosen
    ]
    if evidence.count("resection", "adjusted_point"):
        blocks.append(Paragraph(tr(ADJUSTED)))
    if not by_role["check"]:
        blocks.append(Paragraph(tr("There are no check points: no independent point confirms the orientation.")))
    blocks += [*_new_point(evidence), Paragraph(_verdict(found, evidence)), _table(by_role, moved, found, evidence)]
    return Section("meaning", tr("What the residuals mean"), blocks)


def length_mm(row: Row) -> float:
    """|v| of a point in the image."""
    return math.hypot(float(row["vx_mm"] or 0.0), float(row["vy_mm"] or 0.0))


def across_m(row: Row, f_mm: float) -> float:
    """|v| at the distance of the point, across the ray: |v| depth / f."""
    return length_mm(row) * abs(float(row["depth_m"] or 0.0)) / f_mm


def _sentence(role: str, rows: Sequence[Row], photo: Row, found: Row, moved: float | None) -> Paragraph:
    """Root mean square length of the residual vector, in all three units."""
    image = rms(map(length_mm, rows)) or 0.0
    ground = rms(across_m(row, float(found["f_mm"] or 1.0)) for row in rows)
    pixel = photo["pixel_size_mm"]
    in_pixels = "" if pixel is None else f" ({digits(image / float(pixel), 3)} px)"
    counted = trn("{role}: {n} point.", "{role}: {n} points.", len(rows), role=tr(ROLES[role]))
    told = tr(
        "The place that the orientation predicts misses the measured one by {image}, root mean square of the "
        "length. At the distance of the points that is {ground} m across the line of sight.",
        image=f"{digits(MICROMETRES * image, 3)} µm{in_pixels}",
        ground=digits(ground, 3),
    )
    place = "" if moved is None else tr(
        "On the ground the ray of the point passes its given place at {moved} m (root mean square of the plan "
        "distance, "
        "with the error of the given place in it).",
        moved=digits(moved, 3),
    )  # fmt: skip
    return Paragraph(joined([counted, told, place]))


def _ground_differences(evidence: Evidence) -> dict[str, float | None]:
    """RMS of the plan distance between the ray at its height and the given place [m], by role."""
    rows = evidence.rows("covariance", "ground_covariance", ("role", "dX_m", "dY_m"))
    return {
        role: rms(
            math.hypot(float(row["dX_m"] or 0.0), float(row["dY_m"] or 0.0))
            for row in rows
            if row["role"] == role and row["dX_m"] is not None
        )
        for role in ROLES
    }


def _new_point(evidence: Evidence) -> list[Block]:
    places = evidence.rows("covariance", "ground_accuracy", ("sigma_X_m", "sigma_Y_m"))
    seen = [sigma for sigma in map(plan_sigma, places) if sigma is not None]
    if not seen:
        return []
    told = tr(
        "A new point read once on the photo would be known to {best} m where the frame is best, to {median} m in the "
        "middle (median) and to {worst} m where it is worst (one standard deviation of a plan coordinate, height "
        "without "
        "error).",
        best=digits(min(seen), 3),
        median=digits(median(seen), 3),
        worst=digits(max(seen), 3),
    )
    return [Paragraph(told)]


def _verdict(found: Row, evidence: Evidence) -> str:
    """In plain words: do the residuals fit what was expected of the readings?"""
    test = evidence.one("resection", "adjustment_test")
    if found["sigma0_mm"] is None:
        return tr("There are as many unknowns as measurements: the residuals are zero whatever the errors are.")
    judged = None if test is None else test["verdict"]
    if judged == "too large":
        return tr(
            "That is more than the stated precision of the readings and of the control explains: something is wrong "
            "with "
            "a point, with the camera, or the stated standard deviations are too small."
        )
    if judged == "too small":
        return tr("That is less than the stated precision lets expect: the stated standard deviations are too large.")
    if judged == "accepted":
        return tr("That is what the stated precision of the readings and of the control lets expect.")
    return tr("No stated precision tells what to expect of it.")


def _table(
    by_role: Mapping[str, list[Row]], moved: Mapping[str, float | None], found: Row, evidence: Evidence
) -> Table:
    """Found, expected and what follows, measure by measure."""
    rows = [*_sigma0(found, evidence), *_check(by_role, moved), *_tests(evidence)]
    headers = [tr("measure"), tr("found"), tr("good is"), tr("this one is")]
    return Table(tr("What is good?"), headers, rows, WORDS)


def _sigma0(found: Row, evidence: Evidence) -> list[list[str]]:
    test = evidence.one("resection", "adjustment_test")
    if test is None or test["statistic"] is None or not test["redundancy"]:
        return []
    r = float(test["redundancy"])
    ratio, low, high = (math.sqrt(float(test[key] or 0.0) / r) for key in ("statistic", "lower", "upper"))
    expected = tr("{low} to {high}", low=fixed(low, 2), high=fixed(high, 2))
    return [[tr("sigma0 to its value a priori"), fixed(ratio, 2), expected, kinds.word(test["verdict"])]]


def _check(by_role: Mapping[str, list[Row]], moved: Mapping[str, float | None]) -> list[list[str]]:
    """On the ground where both are known there: adjusted control points have moved in the image."""
    on_ground = moved["control"] and moved["check"] is not None
    control, check = (moved[role] if on_ground else rms(map(length_mm, by_role[role])) for role in ROLES)
    if not control or check is None:
        return []
    ratio = check / control
    judged = tr("good") if ratio <= AS_CONTROL else tr("too large")
    return [
        [
            tr("differences at check points to those at control"),
            fixed(ratio, 2),
            tr("up to {high}", high=AS_CONTROL),
            judged,
        ]
    ]


def _tests(evidence: Evidence) -> list[list[str]]:
    """The largest test value of a reading, and the smallest share of an error that shows."""
    test = evidence.one("resection", "adjustment_test")
    columns = ("point", "axis", "w", "share")
    image = "AND kind = 'image'"
    most = evidence.rows(
        "resection", "observation_test", columns, f"{image} AND w IS NOT NULL ORDER BY abs(w) DESC, point, axis LIMIT 1"
    )
    least = evidence.rows("resection", "observation_test", columns, f"{image} ORDER BY share, point, axis LIMIT 1")
    rows = []
    if most and test is not None and test["critical"] is not None:
        size, limit = abs(float(most[0]["w"] or 0.0)), float(test["critical"])
        told = tr("largest test value |{test}| of a reading", test=test["test"])
        rows.append(
            [
                told,
                fixed(size, 2),
                tr("up to {high}", high=fixed(limit, 2)),
                tr("good") if size <= limit else tr("suspect"),
            ]
        )
    if least:
        share = float(least[0]["share"] or 0.0)
        judged = MISSING if test is None else tr("good") if share >= 0.1 else tr("hardly checked")
        told = tr("smallest share of an error in a reading that shows in its residual")
        rows.append([told, fixed(share, 2), tr("from {low}", low="0.10"), judged])
    return rows
