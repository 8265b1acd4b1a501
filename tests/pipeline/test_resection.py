"""Stage `resection`: weights, partly given points, frames, check points."""

from dataclasses import replace

import numpy as np
import pytest

from orient.errors import OrientError
from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline import resection
from orient.values import Outcome, Row, Tables
from tests.pipeline.made import (
    Array,
    Place,
    covariance_of,
    frame_in,
    inputs_of,
    local,
    oriented,
    photo,
    places,
    quaternion_of,
    random,
    settings,
    station_of,
    true_camera,
)

SWAP = np.array([1, 0, 2])
HEIGHT_MM = 1e-3


def true_station() -> Array:
    """In the stored frame T': north, east, up."""
    return true_camera()[0][SWAP]


def with_role(place: Place, role: str) -> Place:
    return replace(place, role=role)


def sigmas(outcome: Outcome) -> Array:
    (found,) = outcome.tables["orientation"]
    diagonal = [
        row["value"] for row in outcome.tables["cofactor"] if row["unknowns"] == "rotation" and row["i"] == row["j"]
    ]
    return np.sqrt(float(found["variance_scale"]) * np.array(diagonal, dtype=float))  # type: ignore[arg-type]


def test_an_adjustment_begun_nearby_that_does_not_fit_starts_as_if_nothing_were_near() -> None:
    inputs, told = inputs_of(photo(), places(8, "begun")), settings("resection")
    work, _, _ = resection._assignment(inputs, told)
    chain = resection.chain_of(work.control, inputs, work.frame, work.ground, work.sigma0, told)
    adjust = resection._task(work, chain).adjust
    first, some = adjust(range(8), None), [0, 1, 2, 3, 5, 6, 7]
    assert len(first.found.ends) == 1
    below = replace(first, found=replace(first.found, station=first.found.station * [1.0, 1.0, -1.0]))
    fresh, begun, led_astray = adjust(some, None), adjust(some, first), adjust(some, below)
    assert len(begun.found.starts) == 1 < len(fresh.found.starts)
    assert len(led_astray.found.starts) == len(fresh.found.starts)
    assert np.array_equal(led_astray.found.station, fresh.found.station)
    assert begun.found.station == pytest.approx(fresh.found.station, abs=1e-5)


def test_the_true_station_is_found() -> None:
    outcome = oriented(inputs_of(photo(), places(8, "true")))
    assert station_of(outcome) == pytest.approx(true_station(), abs=1e-4)
    assert matrix_from_quaternion(quaternion_of(outcome)) == pytest.approx(true_camera()[1], abs=1e-9)
    (found,) = outcome.tables["orientation"]
    assert (found["n_equations"], found["n_unknowns"], found["redundancy"]) == (16, 6, 10)
    assert len(outcome.tables["equation"]) == 16
    assert {row["unknown"] for row in outcome.tables["iteration_parameter"]} == {
        "alpha", "omega", "kappa", "X_S", "Y_S", "Z_S"
    }  # fmt: skip


def test_weighted_control_of_a_sheet() -> None:
    sigma_m = 40.0
    chance = random("weighted")
    chosen = []
    for place in places(15, "weighted"):
        B, L, H = place.seen
        north, east, up = chance.normal(scale=[sigma_m, sigma_m, 10.0])
        moved = (B + north / 111_100.0, L + east / (111_300.0 * np.cos(np.radians(B))), H + up)
        chosen.append(replace(place, given=moved, covariance=np.diag([sigma_m**2, sigma_m**2, 100.0])))
    inputs = inputs_of(photo(), chosen, noise_mm=0.004, seed="weighted image")
    weighted, fixed = oriented(inputs, variance="priori"), oriented(inputs, control="fixed", variance="priori")
    (found,) = weighted.tables["orientation"]
    assert (found["n_unknowns"], found["redundancy"]) == (6 + 45, 2 * 15 - 6)
    assert 0.5 < float(found["sigma0_mm"]) / 0.004 < 1.5  # type: ignore[arg-type]
    assert np.all(sigmas(weighted) > 3 * sigmas(fixed))
    assert np.all(np.abs(station_of(weighted) - true_station()) < 3.5 * sigmas(weighted)[3:])
    moved_by = np.array(
        [[row[f"d{axis}_m"] for axis in "XYZ"] for row in weighted.tables["adjusted_point"]], dtype=float
    )
    assert 0.1 * sigma_m < np.std(moved_by[:, :2]) < 2 * sigma_m


def test_weighted_needs_a_covariance_at_every_point() -> None:
    with pytest.raises(OrientError, match="has no standard deviation"):
        resection.compute(inputs_of(photo(), places(5, "none")), settings("resection", control="weighted"))


def partly(chosen: list[Place]) -> list[Place]:
    """The last six are given by half: three plan positions, three heights."""
    whole, plan, height = chosen[:-6], chosen[-6:-3], chosen[-3:]
    return [
        *whole,
        *(replace(place, given=(place.seen[0], place.seen[1], None)) for place in plan),
        *(replace(place, given=(None, None, place.seen[2])) for place in height),
    ]


@pytest.mark.parametrize("extent_deg", [0.2, 0.9])
def test_partly_given_points_on_the_curved_earth(extent_deg: float) -> None:
    chosen = partly(places(12, "partly", extent_deg))
    inputs = inputs_of(photo(), chosen)
    outcome = oriented(inputs)
    assert station_of(outcome) == pytest.approx(true_station(), abs=0.01)
    frame = frame_in(photo(), inputs["topocentric"])
    adjusted = {row["point"]: [row["X_m"], row["Y_m"], row["Z_m"]] for row in outcome.tables["adjusted_point"]}
    for place in chosen[-6:]:
        B, L, H = frame.geographic(np.array([adjusted[place.name]], dtype=float))[0]
        if place.given[2] is None:
            assert (np.degrees(B), np.degrees(L)) == pytest.approx(place.seen[:2], abs=1e-9)
            assert pytest.approx(place.seen[2], abs=0.1) == H
        else:
            assert abs(H - place.seen[2]) < HEIGHT_MM
            assert (np.degrees(B), np.degrees(L)) == pytest.approx(place.seen[:2], abs=1e-6)


def test_a_plan_only_point_costs_one_unknown_and_a_height_only_point_two() -> None:
    (found,) = oriented(inputs_of(photo(), partly(places(12, "partly")))).tables["orientation"]
    assert found["redundancy"] == 24 - 6 - 3 * 1 - 3 * 2


def on_local_ground(inputs: dict[str, Tables], role: str = "control") -> list[Place]:
    """The points of T' as local Cartesian places."""
    return [
        Place(str(row["point"]), xyz, xyz, role)
        for row in inputs["topocentric"]["topocentric_point"]
        for xyz in [(float(row["X_m"]), float(row["Y_m"]), float(row["Z_m"]))]  # type: ignore[arg-type]
    ]


def test_left_handed_ground_is_right_handed_ground_with_its_axes_exchanged() -> None:
    left = on_local_ground(inputs_of(photo(), places(8, "handed")))
    right = []
    for place in left:
        X, Y, Z = place.seen
        right.append(Place(place.name, (Y, X, Z), (Y, X, Z)))
    in_left = oriented(inputs_of(local("left"), left, noise_mm=0.004, seed="handed"))
    in_right = oriented(inputs_of(local("right"), right, noise_mm=0.004, seed="handed"))
    assert station_of(in_left)[SWAP] == pytest.approx(station_of(in_right), abs=1e-6)
    assert quaternion_of(in_left) == pytest.approx(quaternion_of(in_right), abs=1e-12)
    assert sigmas(in_left)[[0, 1, 2, 4, 3, 5]] == pytest.approx(sigmas(in_right), rel=1e-6)


def test_the_frame_of_the_ground_does_not_matter() -> None:
    geodetic = inputs_of(photo(), places(8, "frames"), noise_mm=0.004, seed="frames")
    points = on_local_ground(geodetic)
    as_local = {**inputs_of(local("left"), points), "refine": geodetic["refine"]}
    one, other = oriented(geodetic), oriented(as_local)
    assert station_of(one) == pytest.approx(station_of(other), abs=1e-5)
    assert quaternion_of(one) == pytest.approx(quaternion_of(other), abs=1e-11)
    assert one.tables["orientation"][0]["vPv"] == pytest.approx(other.tables["orientation"][0]["vPv"], rel=1e-6)


def test_another_origin_and_convergence_give_the_same_place_on_the_earth() -> None:
    chosen = places(10, "origin")
    first = inputs_of(photo(), chosen, noise_mm=0.004, seed="origin")
    elsewhere = photo(station_B_deg=42.9, station_L_deg=21.2, central_meridian_deg=21.0)
    second = {**inputs_of(elsewhere, chosen), "refine": first["refine"]}
    here, there = (oriented(inputs).tables["orientation"][0] for inputs in (first, second))
    for name in ("X_G_m", "Y_G_m", "Z_G_m"):
        assert float(here[name]) == pytest.approx(float(there[name]), abs=1e-4)  # type: ignore[arg-type]


def without_check(tables: Tables, name: str) -> list[Row]:
    return [row for row in tables[name] if row.get("role") != "check"]


def test_check_points_do_not_touch_the_adjustment() -> None:
    chosen = places(12, "check")
    points = [with_role(place, "check" if i >= 8 else "control") for i, place in enumerate(chosen)]
    inputs = inputs_of(photo(), points, noise_mm=0.004, seed="check")
    moved_rows = [
        {**row, "X_m": float(row["X_m"]) + 500.0} if row["role"] == "check" else row  # type: ignore[arg-type]
        for row in inputs["topocentric"]["topocentric_point"]
    ]
    moved = {**inputs, "topocentric": {**inputs["topocentric"], "topocentric_point": moved_rows}}
    one, other = oriented(inputs), oriented(moved)
    for name in ("orientation", "orientation_angle", "cofactor", "iteration", "iteration_parameter", "equation"):
        assert one.tables[name] == other.tables[name]
    assert without_check(one.tables, "image_residual") == without_check(other.tables, "image_residual")
    shift = [abs(row["vx_mm"]) + abs(row["vy_mm"]) for row in other.tables["image_residual"] if row["role"] == "check"]  # type: ignore[arg-type]
    assert len(shift) == 4
    assert min(shift) > 0.3  # 500 m on the ground


def test_the_order_of_the_points_does_not_matter() -> None:
    inputs = inputs_of(photo(), places(12, "order"), noise_mm=0.004, seed="order")
    shuffled = random("shuffle").permutation(12)
    image = [inputs["refine"]["image_point"][i] for i in shuffled]
    ground = list(reversed(inputs["topocentric"]["topocentric_point"]))
    other = {
        **inputs,
        "refine": {"image_point": image},
        "topocentric": {**inputs["topocentric"], "topocentric_point": ground},
    }
    one, two = oriented(inputs), oriented(other)
    assert station_of(one) == pytest.approx(station_of(two), abs=1e-5)
    residuals = [
        {str(row["point"]): row["vx_mm"] for row in outcome.tables["image_residual"]} for outcome in (one, two)
    ]
    assert residuals[0] == pytest.approx(residuals[1], abs=1e-9)


def test_partners_are_found_by_name_and_the_lonely_are_named() -> None:
    inputs = inputs_of(photo(), places(8, "names"))
    image = [row for row in inputs["refine"]["image_point"] if row["point"] != "P03"]
    ground = [row for row in inputs["topocentric"]["topocentric_point"] if row["point"] != "P05"]
    less = {
        **inputs,
        "refine": {"image_point": image},
        "topocentric": {**inputs["topocentric"], "topocentric_point": ground},
    }
    outcome = oriented(less)
    assert outcome.tables["orientation"][0]["n_control"] == 6
    assert {(event.code, event.subject) for event in outcome.events} >= {("no_control", "P05"), ("not_measured", "P03")}


def test_a_covariance_without_height_keeps_the_height() -> None:
    plan = np.diag([900.0, 900.0, 0.0])
    chosen = [replace(place, covariance=plan) for place in places(8, "plan")]
    inputs = inputs_of(photo(), chosen)
    assert inputs["topocentric"]["topocentric_point"][0]["cov_XX_m2"] != covariance_of(plan)["cov_ZZ_m2"]
    (found,) = oriented(inputs).tables["orientation"]
    assert found["redundancy"] == 2 * 8 - 6
    assert found["n_unknowns"] == 6 + 2 * 8
