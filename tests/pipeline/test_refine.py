"""Stage `refine` on readings made by hand."""

import numpy as np
import pytest

from orient.errors import OrientError
from orient.geometry import plane
from orient.pipeline import refine
from orient.values import Outcome, Row, Scalar, Tables
from tests.pipeline.made import photo, random, row, settings

MARKS = {"1": (-86.0, 86.0), "2": (86.0, 86.0), "3": (86.0, -86.0), "4": (-86.0, -86.0), "5": (0.0, 86.5)}
POINTS = {"A": (10.0, 20.0), "B": (-40.0, 70.0), "C": (75.0, -60.0)}
PARTS = ("principal", "distortion", "refraction")


def reading(point: str, xy: tuple[float, float], cycle: int = 1, kind: str = "point", **given: Scalar) -> Row:
    return row("comparator_reading", seq=1, point=point, kind=kind, cycle=cycle, x_mm=xy[0], y_mm=xy[1], **given)


def refined(facts: Tables, readings: list[Row], reject: bool = False) -> Outcome:
    numbered = [{**reading, "seq": number} for number, reading in enumerate(readings, 1)]
    return refine.compute(
        {"photo": facts, "readings": {"comparator_reading": numbered}}, settings("refine", reject=reject)
    )


def image(outcome: Outcome) -> dict[str, Row]:
    return {str(row["point"]): row for row in outcome.tables["image_point"]}


@pytest.mark.parametrize(("x_axis", "x_sign"), [("right", 1.0), ("left", -1.0)])
@pytest.mark.parametrize(("y_axis", "y_sign"), [("up", -1.0), ("down", 1.0)])
def test_pixels_become_mm(x_axis: str, x_sign: float, y_axis: str, y_sign: float) -> None:
    facts = photo(pixel_size_mm=0.01, origin_col_px=100.0, origin_row_px=200.0, x_axis=x_axis, y_axis=y_axis)
    pixels = row("comparator_reading", point="A", kind="point", cycle=1, col_px=350.0, row_px=-50.0, sigma=0.5)
    found = image(refined(facts, [pixels]))["A"]
    assert (found["x_mm"], found["y_mm"]) == pytest.approx((2.5 * x_sign, -2.5 * y_sign))
    assert found["cov_xx_mm2"] == pytest.approx((0.5 * 0.01) ** 2)


def test_every_correction_has_its_column_and_they_add_up() -> None:
    facts = {
        **photo(x0_mm=0.021, y0_mm=-0.014, distortion_model="brown", refraction="integral", camera_height_m=250e3),
        "distortion_coefficient": [
            row("distortion_coefficient", name=name, value=value) for name, value in (("k1", 6e-8), ("p1", 1e-7))
        ],
    }
    found = image(refined(facts, [reading(name, xy) for name, xy in POINTS.items()]))
    for name, (x, y) in POINTS.items():
        stored = found[name]
        parts = np.array([[stored[f"d{axis}_{part}_mm"] for part in PARTS] for axis in "xy"], dtype=float)
        assert np.all(parts != 0.0)
        assert parts[:, 0] == pytest.approx([-0.021, 0.014])
        total = np.array([x, y]) + parts.sum(axis=1)
        assert np.array([stored["x_mm"], stored["y_mm"]], dtype=float) == pytest.approx(total, rel=1e-15)


@pytest.mark.parametrize("transformation", ["similarity", "affine", "projective"])
def test_interior_orientation_takes_the_comparator_away(transformation: str) -> None:
    facts = {
        **photo(interior_transformation=transformation),
        "fiducial_mark": [row("fiducial_mark", mark=name, x_mm=x, y_mm=y) for name, (x, y) in MARKS.items()],
    }
    angle = np.radians(12.0)
    turn = 1.001 * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def comparator(xy: tuple[float, float]) -> tuple[float, float]:
        x, y = turn @ xy + [215.0, 187.0]
        return float(x), float(y)

    readings = [reading(mark, comparator(xy), kind="fiducial") for mark, xy in MARKS.items()]
    readings += [reading(name, comparator(xy)) for name, xy in POINTS.items()]
    outcome = refined(facts, readings)
    for name, xy in POINTS.items():
        stored = image(outcome)[name]
        assert (stored["x_mm"], stored["y_mm"]) == pytest.approx(xy, abs=1e-9)
        assert stored["cov_xx_mm2"] == pytest.approx((0.004 / 1.001) ** 2, rel=1e-6)
    (fit,) = outcome.tables["interior_orientation"]
    parameters = [row["name"] for row in outcome.tables["interior_parameter"]]
    assert fit["redundancy"] == 2 * len(MARKS) - len(parameters)
    assert tuple(parameters) == plane.parameter_names(transformation)


def test_a_mirrored_reading_of_the_marks_is_named() -> None:
    facts = {
        **photo(interior_transformation="affine"),
        "fiducial_mark": [row("fiducial_mark", mark=name, x_mm=x, y_mm=y) for name, (x, y) in MARKS.items()],
    }
    readings = [reading(mark, (-x, y), kind="fiducial") for mark, (x, y) in MARKS.items()]
    outcome = refined(facts, [*readings, reading("A", POINTS["A"])])
    assert "mirrored" in {event.code for event in outcome.events}


def test_points_may_have_different_numbers_of_cycles() -> None:
    readings = [reading("A", (1.0, 2.0), 1), reading("A", (1.002, 2.004), 2), reading("A", (1.004, 2.002), 3),
                reading("B", (5.0, 6.0), 1), reading("B", (5.002, 6.0), 2), reading("C", (9.0, 9.0), 2)]  # fmt: skip
    outcome = refined(photo(), readings)
    found = image(outcome)
    assert [found[name]["n_cycles"] for name in "ABC"] == [3, 2, 1]
    assert (found["A"]["x_mm"], found["A"]["y_mm"]) == pytest.approx((1.002, 2.002))
    assert [found[name]["cov_xx_mm2"] for name in "ABC"] == pytest.approx([0.004**2 / n for n in (3, 2, 1)])
    assert found["C"]["sigma_cycles_mm"] is None
    deviations = {(row["point"], row["cycle"]): row["vx_mm"] for row in outcome.tables["cycle_residual"]}
    assert deviations["B", 1] == pytest.approx(0.001)


@pytest.mark.parametrize("reject", [False, True], ids=["kept", "rejected"])
def test_an_outlier_is_named_and_left_out_when_asked(reject: bool) -> None:
    chance = random("outlier")
    readings = []
    for point in range(12):
        for cycle in (1, 2, 3):
            x, y = (float(value) for value in 5.0 * point + chance.normal(scale=0.003, size=2))
            slip = 0.060 if (point, cycle) == (4, 2) else 0.0
            readings.append(reading(f"P{point}", (x + slip, y), cycle))
    outcome = refined(photo(), readings, reject)
    (event,) = (event for event in outcome.events if event.code == "cycle_outlier")
    assert event.subject == "P4"
    assert "cycle 2" in event.message
    assert ("left out" in event.message) == reject
    found = image(outcome)["P4"]
    assert found["n_cycles"] == (2 if reject else 3)
    assert abs(float(found["x_mm"]) - 20.0) < (0.010 if reject else 0.030)  # type: ignore[arg-type]
    flagged = [row for row in outcome.tables["cycle_residual"] if row["is_outlier"]]
    assert [(row["point"], row["cycle"], row["is_used"]) for row in flagged] == [("P4", 2, int(not reject))]


def test_refused() -> None:
    with pytest.raises(OrientError, match="contain no point"):
        refined(photo(), [reading("1", (0.0, 0.0), kind="fiducial")])
    with pytest.raises(OrientError, match="heights of the camera and of the ground"):
        refined(photo(refraction="integral"), [reading("A", (1.0, 1.0))])
