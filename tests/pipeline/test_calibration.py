"""Stage `resection` with an unknown camera, what is known of its place, and what `covariance` makes of both."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from orient.errors import OrientError
from orient.geometry.camera import Camera, Measured, corrected
from orient.geometry.collinearity import project
from orient.geometry.distortion import Distortion
from orient.geometry.rotation import matrix_from_opk, matrix_from_quaternion, opk_from_matrix, rotation_exp
from orient.pipeline import covariance, refine, resection
from orient.pipeline.camera import adjusted_camera, given_camera
from orient.pipeline.second_engine import solve_again
from orient.pipeline.verify_observations import knows_all_unknowns
from orient.solvers.ground_covariance import ray_at_height
from orient.solvers.packed import unpack_upper
from orient.values import Outcome, Scalar, Tables
from tests.jacobian import central_difference
from tests.pipeline.made import (
    Array,
    Place,
    frame_in,
    framed,
    geographic_rows,
    inputs_of,
    local,
    oriented,
    photo,
    places,
    random,
    row,
    settings,
    station_of,
    true_camera,
)

S, R = np.array([800.0, -500.0, 3000.0]), matrix_from_opk(0.25, -0.2, 0.7).T
TRUTH = Camera(152.0, 0.1, -0.05, Distortion("brown", "correction", {"k1": 3e-7}))
CAMERA = {"f_mm": 150.0, "frame_width_mm": 230.0, "frame_height_mm": 230.0, "platform": "aerial"}


def hills(name: str, count: int = 30, relief: float = 600.0) -> list[Place]:
    chance = random(name)
    under = S - S[2] / R[2, 2] * R[:, 2]
    ground = np.column_stack(
        [under[:2] + chance.uniform(-1500, 1500, (count, 2)), relief * chance.uniform(-0.5, 0.5, count)]
    )
    whole = [(float(x), float(y), float(z)) for x, y, z in ground]
    return [Place(f"P{number:02}", place, place) for number, place in enumerate(whole, 1)]


def seen_by(camera: Camera, facts: Tables, chosen: list[Place], noise_mm: float = 0.0) -> dict[str, Tables]:
    """Readings that the true camera makes, refined with the camera of the photo."""
    image, _ = project(np.array([place.seen for place in chosen]), S, R, camera.f_mm)
    q = image.copy()
    for _ in range(50):
        q = q - (corrected(replace(camera, x0_mm=0.0, y0_mm=0.0), Measured(q, np.zeros_like(q))) - image)
    frame = q + camera.principal_point + noise_mm * random("noise").normal(size=q.shape)
    readings = [
        row("comparator_reading", seq=i, point=place.name, kind="point", cycle=1, x_mm=float(x), y_mm=float(y))
        for i, (place, (x, y)) in enumerate(zip(chosen, frame, strict=True))
    ]
    tables = {"photo": facts, "readings": {"comparator_reading": readings}}
    refined = refine.compute(tables, settings("refine")).tables
    return {"photo": facts, "refine": refined, "topocentric": framed(facts, geographic_rows(chosen, is_local=True))}


def elements(outcome: Outcome) -> dict[str, Mapping[str, Scalar]]:
    return {str(one["unknown"]): one for one in outcome.tables["camera_element"]}


def number(value: Scalar) -> float:
    assert isinstance(value, int | float)
    return float(value)


def test_the_estimated_camera_is_the_true_one() -> None:
    inputs = seen_by(TRUTH, local("right", **CAMERA), hills("estimate"))
    outcome = oriented(inputs, estimate="f,x0,y0,k1")
    found = elements(outcome)
    assert [found[name]["unit"] for name in ("f", "x0", "y0", "k1")] == ["mm", "mm", "mm", "mm^-2"]
    values = [number(found[name]["value"]) for name in ("f", "x0", "y0", "k1")]
    assert values == pytest.approx([152.0, 0.1, -0.05, 3e-7], rel=1e-6)
    assert number(found["f"]["correction"]) == pytest.approx(2.0, abs=1e-6)
    (orientation,) = outcome.tables["orientation"]
    assert orientation["f_mm"] == found["f"]["value"]
    assert station_of(outcome) == pytest.approx(S, abs=1e-3)
    names = [
        one["unknown_i"] for one in outcome.tables["cofactor"] if one["unknowns"] == "rotation" and one["i"] == one["j"]
    ]
    assert names[6:] == ["f", "x0", "y0", "k1"]
    assert {one["unknown"] for one in outcome.tables["camera_equation"]} == {"f", "x0", "y0", "k1"}
    steps = [one for one in outcome.tables["iteration_parameter"] if one["unknown"] == "f"]
    assert steps[0]["approximation"] == 150.0
    assert number(steps[-1]["approximation"]) + number(steps[-1]["correction"]) == pytest.approx(152.0, abs=1e-6)


def test_a_coefficient_of_photo_toml_is_estimated_as_its_total_value() -> None:
    """k1 of the file is wrong by a third; what is found replaces it and is not added to it."""
    facts = local("right", **CAMERA, distortion_model="brown", distortion_direction="correction")
    facts = {**facts, "distortion_coefficient": [row("distortion_coefficient", name="k1", value=2e-7)]}
    outcome = oriented(seen_by(TRUTH, facts, hills("total")), estimate="f,x0,y0,k1")
    assert number(elements(outcome)["k1"]["value"]) == pytest.approx(3e-7, rel=1e-6)
    assert number(elements(outcome)["k1"]["value_apriori"]) == 2e-7


def test_uncertain_camera_enters_the_covariance() -> None:
    """f known to 0.1 mm of 150: the height is uncertain by 0.1/150 of itself where f and height are one."""
    facts = photo(sigma_f_mm=0.1, frame_width_mm=180.0, frame_height_mm=180.0)
    chosen = places(12, "weighted camera", extent_deg=0.4)
    inputs = with_frame(facts, chosen)
    known, weighted = oriented(inputs, variance="priori"), oriented(inputs, variance="priori", camera="weighted")
    assert sigma_of(known, "Z_S") < 0.3 * sigma_of(weighted, "Z_S")
    assert sigma_of(weighted, "Z_S") == pytest.approx(250_000.0 * 0.1 / 200.0, rel=0.15)
    assert sigma_of(weighted, "f") <= 0.1
    (before,), (after,) = known.tables["orientation"], weighted.tables["orientation"]
    assert (after["redundancy"], after["n_unknowns"]) == (before["redundancy"], 7)
    ground = [ground_sigmas(inputs, outcome) for outcome in (known, weighted)]
    # f and height go together, so that the ground points hardly notice: the full matrix says so, its diagonal not
    assert ground[1] == pytest.approx(ground[0], rel=1e-3)


def with_frame(facts: Tables, chosen: list[Place]) -> dict[str, Tables]:
    """What the made space camera sees, with the columns that an estimated camera needs."""
    inputs = inputs_of(facts, chosen, noise_mm=0.004, seed="with frame")
    zero = dict.fromkeys(("dx_refraction_mm", "dy_refraction_mm", "dx_curvature_mm", "dy_curvature_mm"), 0.0)
    rows = [
        {**one, **zero, "x_frame_mm": one["x_mm"], "y_frame_mm": one["y_mm"]} for one in inputs["refine"]["image_point"]
    ]
    return {**inputs, "refine": {"image_point": rows}}


def sigma_of(outcome: Outcome, unknown: str) -> float:
    (found,) = outcome.tables["orientation"]
    (q,) = (
        one["value"]
        for one in outcome.tables["cofactor"]
        if (one["unknowns"], one["unknown_i"], one["unknown_j"]) == ("rotation", unknown, unknown)
    )
    return float(np.sqrt(number(found["variance_scale"]) * number(q)))


def ground_sigmas(inputs: Mapping[str, Tables], outcome: Outcome) -> Array:
    after = covariance.compute({**inputs, "resection": outcome.tables}, settings("covariance"))
    return np.array([[one["sigma_X_m"], one["sigma_Y_m"]] for one in after.tables["ground_covariance"]], dtype=float)


@pytest.mark.parametrize("direction", ["correction", "ideal_to_distorted"])
def test_ground_covariance_is_that_of_all_unknowns(direction: str) -> None:
    """K = D Q D' with D by central differences through the estimated camera, and the point where its ray meets."""
    facts = local("right", **CAMERA)
    chosen = hills("propagated", 12)
    inputs = seen_by(TRUTH, facts, chosen, noise_mm=0.004)
    outcome = oriented(inputs, estimate="f,x0,k1", distortion=direction)
    after = covariance.compute({**inputs, "resection": outcome.tables}, settings("covariance"))
    (found,) = outcome.tables["orientation"]
    packed = [number(one["value"]) for one in outcome.tables["cofactor"] if one["unknowns"] == "rotation"]
    Q = number(found["variance_scale"]) * unpack_upper(np.array(packed))
    names = tuple(elements(outcome))
    base = replace(given_camera(facts["photo"][0], facts), distortion=Distortion("brown", direction, {}, None, 150.0))
    values = np.array([number(one["value"]) for one in elements(outcome).values()])
    rows = inputs["refine"]["image_point"]
    frame = np.array([[one["x_frame_mm"], one["y_frame_mm"]] for one in rows], dtype=float)
    rotation = np.array([found[f"q_{letter}"] for letter in "wxyz"], dtype=float)
    turn = matrix_from_quaternion(rotation)
    given = np.array([place.given for place in chosen], dtype=float)
    up = np.tile([0.0, 0.0, 1.0], (len(chosen), 1))

    def ground(step: Array) -> Array:
        camera = base.with_values(names, values + step[6:])
        image = corrected(camera, Measured(frame, np.zeros_like(frame)))
        moved = rotation_exp(step[:3]) @ turn
        return ray_at_height(image, station_of(outcome) + step[3:6], moved, camera.f_mm, given, up)

    D = central_difference(ground, np.zeros(9), np.array([1e-6] * 3 + [1e-2] * 3 + [1e-3, 1e-3, 1e-10]))
    expected = (D @ Q @ D.transpose(0, 2, 1))[:, :2, :2]
    stored = after.tables["ground_covariance"]
    assert [one["point"] for one in stored] == [place.name for place in chosen]
    found_K = np.array([[one["K_XX_m2"], one["K_XY_m2"], one["K_YY_m2"]] for one in stored], dtype=float)
    assert found_K == pytest.approx(expected[:, [0, 0, 1], [0, 1, 1]], rel=1e-4, abs=1e-6)
    places_found = np.array([[one["X_m"], one["Y_m"]] for one in stored], dtype=float)
    assert places_found == pytest.approx(ground(np.zeros(9))[:, :2], abs=1e-6)


def test_calibration_by_steps_takes_what_is_there_and_says_why_not() -> None:
    inputs = seen_by(TRUTH, local("right", **CAMERA), hills("auto", 60, relief=2500.0), noise_mm=0.004)
    outcome = oriented(inputs, calibrate="auto")
    assert {"f", "k1"} <= set(elements(outcome))
    assert not {"k2", "k3", "b1", "b2"} & set(elements(outcome))
    steps = outcome.tables["calibration_step"]
    taken = [one["unknown"] for one in steps if one["decision"] == "taken"]
    assert sorted(map(str, taken)) == sorted(elements(outcome))
    assert len({one["step"] for one in steps}) == len(taken) + 1
    assert all(one["reason"] for one in steps)
    last = [one for one in steps if one["step"] == len(taken) + 1]
    assert {one["decision"] for one in last} <= {"not significant", "not separable"}
    (said,) = (event for event in outcome.events if event.code == "calibration")
    assert said.message.startswith("calibration took ")


def test_calibration_leaves_a_perfect_camera_alone() -> None:
    facts = local("right", **{**CAMERA, "f_mm": 152.0})
    truth = replace(TRUTH, x0_mm=0.0, y0_mm=0.0, distortion=Distortion())
    outcome = oriented(seen_by(truth, facts, hills("perfect", 40), noise_mm=0.004), calibrate="auto")
    assert elements(outcome) == {}
    assert {one["decision"] for one in outcome.tables["calibration_step"]} <= {"not significant", "not separable"}


def test_f_over_flat_ground_is_refused_with_the_reason() -> None:
    chosen = [
        Place(f"F{i}", (x, y, 0.0), (x, y, 0.0))
        for i, (x, y) in enumerate([(0.0, 0.0), (900.0, 0.0), (0.0, 900.0), (900.0, 900.0), (400.0, 700.0)])
    ]
    facts = local("right", **CAMERA)
    given = framed(facts, geographic_rows(chosen, is_local=True))
    image, _ = project(np.array([place.seen for place in chosen]), [450.0, 450.0, 1500.0], np.eye(3), 150.0)
    readings = [
        row("comparator_reading", seq=i, point=place.name, kind="point", cycle=1, x_mm=float(x), y_mm=float(y))
        for i, (place, (x, y)) in enumerate(zip(chosen, image, strict=True))
    ]
    refined = refine.compute({"photo": facts, "readings": {"comparator_reading": readings}}, settings("refine")).tables
    inputs = {"photo": facts, "refine": refined, "topocentric": given}
    outcome = resection.compute(inputs, settings("resection", estimate="f"))
    assert outcome.error.startswith("SINGULAR: f and Z_S cannot be separated (correlation 1.000). Undetermined: f 1.00")
    assert outcome.hint.startswith("Leave f out of --estimate, give its standard deviation in photo.toml")
    assert "orientation" not in outcome.tables
    auto = oriented(inputs, calibrate="auto")
    (step,) = (one for one in auto.tables["calibration_step"] if one["unknown"] == "f")
    assert (step["decision"], step["value"]) == ("not separable", None)


def test_an_element_that_is_hardly_separable_is_said() -> None:
    """50 m of relief below 3 km in a nearly vertical view: f goes with the height, and its own sigma is large."""
    chosen = hills("weak f", 20, relief=50.0)
    image, _ = project(np.array([place.seen for place in chosen]), S, np.eye(3), 150.0)
    readings = [
        row("comparator_reading", seq=i, point=place.name, kind="point", cycle=1, x_mm=float(x), y_mm=float(y))
        for i, (place, (x, y)) in enumerate(zip(chosen, image, strict=True))
    ]
    facts = local("right", **CAMERA)
    refined = refine.compute({"photo": facts, "readings": {"comparator_reading": readings}}, settings("refine")).tables
    given = framed(facts, geographic_rows(chosen, is_local=True))
    outcome = oriented({"photo": facts, "refine": refined, "topocentric": given}, estimate="f")
    (said,) = (event for event in outcome.events if event.code == "camera_weak")
    assert said.subject == "f"
    assert said.message.startswith("f is hardly separable from Z_S (correlation +0.999")


def test_a_prior_that_the_photo_contradicts_is_said() -> None:
    facts = local("right", **CAMERA, sigma_f_mm=0.05)
    inputs = seen_by(TRUTH, facts, hills("contradicted"), noise_mm=0.004)
    outcome = oriented(inputs, estimate="f,x0,y0,k1")
    assert "camera_contradicted" in {event.code for event in outcome.events}
    free = oriented(inputs, estimate="f,x0,y0,k1", free_camera=True)
    assert "camera_contradicted" not in {event.code for event in free.events}
    assert elements(free)["f"]["sigma_apriori"] is None
    assert number(elements(free)["f"]["value"]) == pytest.approx(152.0, abs=4 * number(elements(free)["f"]["sigma"]))


@pytest.mark.parametrize(
    ("columns", "given", "message"),
    [
        ({}, {"camera": "weighted"}, "gives no standard deviation of the camera"),
        ({"distortion_model": "radial_table"}, {"estimate": "k1"}, "a radial table"),
        ({"distortion_model": "brown"}, {"estimate": "k1", "distortion": "displacement"}, "is given as correction"),
    ],
    ids=["no-sigma", "table", "direction"],
)  # fmt: skip
def test_what_cannot_be_estimated_is_refused(columns: dict[str, str], given: dict[str, str], message: str) -> None:
    inputs = seen_by(TRUTH, local("right", **CAMERA), hills("refused", 6))
    facts = {**local("right", **CAMERA, **columns)}
    facts["distortion_radial"] = [row("distortion_radial", radius_mm=r, distortion_mm=0.0) for r in (0.0, 200.0)]
    with pytest.raises(OrientError, match=message):
        resection.compute({**inputs, "photo": facts}, settings("resection", **given))


def known(quantity: str, value: float, sigma: float | None, unit: str = "m") -> Mapping[str, Scalar]:
    return {"quantity": quantity, "unit": unit, "value": value, "sigma": sigma}


def test_known_station_and_angle_of_local_ground() -> None:
    facts = local("right", **{**CAMERA, "f_mm": 152.0})
    truth = replace(TRUTH, x0_mm=0.0, y0_mm=0.0, distortion=Distortion())
    inputs = seen_by(truth, facts, hills("known local", 8), noise_mm=0.004)
    rows = [known("X_S", S[0] + 0.01, 0.02), known("Y_S", S[1], 0.02), known("Z_S", S[2], 0.02)]
    rows.append(known("opk_omega", np.degrees(opk_from_matrix(R)[0]), 1e-4, "deg"))
    outcome = oriented({**inputs, "photo": {**facts, "known_element": rows}})
    residuals = {one["quantity"]: one for one in outcome.tables["known_residual"]}
    assert station_of(outcome) == pytest.approx(S, abs=0.06)
    assert number(residuals["X_S"]["v"]) == pytest.approx(station_of(outcome)[0] - S[0] - 0.01, abs=1e-9)
    assert abs(number(residuals["opk_omega"]["v"])) < 4e-4
    (found,) = outcome.tables["orientation"]
    assert (found["n_equations"], found["redundancy"]) == (16 + 4, 14)
    wrong = [known("Z_S", S[2] + 5.0, 0.02)]
    said = oriented({**inputs, "photo": {**facts, "known_element": wrong}}).events
    assert [event.subject for event in said if event.code == "known_contradicted"] == ["Z_S"]


def test_known_height_on_the_earth_is_the_ellipsoidal_height() -> None:
    """The camera is 13 km away from the origin of T', where the Earth has fallen by 13 m."""
    facts = photo()
    inputs = with_frame(facts, places(12, "known height"))
    frame = frame_in(facts, inputs["topocentric"])
    truth = frame.geographic(frame.right_handed(true_camera()[0])[None])[0]
    assert truth[2] - true_camera()[0][2] > 10.0
    rows = [known("H_S", truth[2], 0.01)]
    outcome = oriented({**inputs, "photo": {**facts, "known_element": rows}})
    (found,) = outcome.tables["orientation"]
    assert number(found["H_S_m"]) == pytest.approx(truth[2], abs=0.05)
    degrees = np.degrees(truth[:2])
    fixed = [known("B_S", degrees[0], None, "deg"), known("L_S", degrees[1], None, "deg"), known("H_S", truth[2], None)]
    (held,) = oriented({**inputs, "photo": {**facts, "known_element": fixed}}).tables["orientation"]
    stayed = [number(held[name]) for name in ("B_S_deg", "L_S_deg", "H_S_m")]
    assert stayed == pytest.approx([*degrees, truth[2]], abs=1e-6)
    assert held["n_unknowns"] == 3
    weighted = [
        known("B_S", degrees[0], 0.01, "deg"),
        known("L_S", degrees[1], 0.01, "deg"),
        known("H_S", truth[2], 0.01),
    ]
    near = oriented({**inputs, "photo": {**facts, "known_element": weighted}})
    (moved,) = near.tables["orientation"]
    assert station_of(near) == pytest.approx(true_camera()[0][[1, 0, 2]], abs=0.05)
    assert number(moved["redundancy"]) == 24 + 3 - 6


def known_and_estimated() -> tuple[dict[str, Tables], Outcome]:
    """f with a prior, k1 free, the station known to metres: every kind of equation about the elements."""
    facts = local("right", **CAMERA, sigma_f_mm=0.2)
    known = [row("known_element", quantity=name, value=value, sigma=2.0) for name, value in
             zip(("X_S", "Y_S", "Z_S"), S.tolist(), strict=True)]  # fmt: skip
    inputs = seen_by(TRUTH, {**facts, "known_element": known}, hills("all kinds"), noise_mm=0.01)
    return inputs, oriented(inputs, estimate="f,k1,x0")


def test_tests_of_all_observations_sum_to_the_redundancy() -> None:
    _, outcome = known_and_estimated()
    tests = outcome.tables["observation_test"]
    (found,) = outcome.tables["orientation"]
    assert sum(number(one["redundancy_number"]) for one in tests) == pytest.approx(number(found["redundancy"]))
    of_image = {(one["point"], one["axis"]): one["redundancy_number"] for one in tests if one["kind"] == "image"}
    for one in outcome.tables["image_residual"]:
        assert of_image[one["point"], "x"] == pytest.approx(one["redundancy_x"], rel=1e-6)
        assert of_image[one["point"], "y"] == pytest.approx(one["redundancy_y"], rel=1e-6)
    of_known = {one["axis"]: one for one in tests if one["kind"] == "known"}
    assert list(of_known) == ["f", "X_S", "Y_S", "Z_S"]
    for one in outcome.tables["known_residual"]:
        assert of_known[one["quantity"]]["redundancy_number"] == pytest.approx(one["redundancy_number"], rel=1e-6)
        assert of_known[one["quantity"]]["v"] == pytest.approx(one["v"], rel=1e-9)
    f = elements(outcome)["f"]
    assert of_known["f"]["redundancy_number"] == pytest.approx(f["redundancy_number"], rel=1e-6)
    assert of_known["f"]["v"] == pytest.approx(f["correction"], rel=1e-9)


def test_an_error_of_a_reading_moves_the_elements_as_its_effect_says() -> None:
    """The smallest findable error added to a reading: f, k1, x0 and the station change by `effect`."""
    inputs, before = known_and_estimated()
    effects = {one["unknown"]: number(one["effect"]) for one in before.tables["external_reliability"]
               if (one["kind"], one["point"], one["axis"]) == ("image", "P07", "x")}  # fmt: skip
    (size,) = (number(one["smallest_error"]) for one in before.tables["observation_test"]
               if (one["kind"], one["point"], one["axis"]) == ("image", "P07", "x"))  # fmt: skip
    step = 0.01 * size
    image = [{**one, "x_mm": number(one["x_mm"]) + step, "x_frame_mm": number(one["x_frame_mm"]) + step}
             if one["point"] == "P07" else one for one in inputs["refine"]["image_point"]]  # fmt: skip
    after = oriented({**inputs, "refine": {**inputs["refine"], "image_point": image}}, estimate="f,k1,x0")
    for name in ("f", "k1", "x0"):
        change = number(elements(after)[name]["value"]) - number(elements(before)[name]["value"])
        # v is that of the corrected coordinate: the reading enters it with the gradient of the distortion, 2 % here
        assert abs(change) == pytest.approx(0.01 * abs(effects[name]), rel=0.05), name
    moved = station_of(after) - station_of(before)
    expected = 0.01 * np.array([effects[name] for name in ("X_S", "Y_S", "Z_S")])
    assert np.linalg.norm(np.abs(moved) - np.abs(expected)) < 0.05 * np.linalg.norm(expected)


def test_the_sources_sum_to_the_cofactors_of_all_elements() -> None:
    _, outcome = known_and_estimated()
    parts = outcome.tables["source_cofactor"]
    assert {one["source"] for one in parts} == {"image readings", "camera"}
    for whole in outcome.tables["cofactor"]:
        if whole["unknowns"] == "rotation":
            summed = sum(number(one["value"]) for one in parts if one["IJ"] == whole["IJ"])
            assert summed == pytest.approx(number(whole["value"]), rel=1e-6, abs=1e-15)


def test_budget_of_ground_points_is_their_covariance() -> None:
    inputs, outcome = known_and_estimated()
    tables = covariance.compute({**inputs, "resection": outcome.tables}, settings("covariance")).tables
    assert tables["element_use"] == []
    for point in tables["ground_covariance"]:
        own = [one for one in tables["error_budget"] if one["point"] == point["point"] and one["part"] == "photo"]
        assert sum(number(one["cov_XX_m2"]) for one in own) == pytest.approx(number(point["K_XX_m2"]), rel=1e-6)


SECOND_ENGINE = {
    "priors, free elements and a known station": (lambda: known_and_estimated(), {"estimate": "f,k1,x0"}),
    "f free": (lambda: free_focal_length(), {"estimate": "f"}),
    "the station fixed": (lambda: known_place(fixed=True), {"estimate": "f,k1"}),
    "angles known": (lambda: known_angles(), {}),
}


@pytest.mark.parametrize("case", SECOND_ENGINE)
def test_the_second_engine_finds_the_same_elements_and_cofactors(case: str) -> None:
    make, asked = SECOND_ENGINE[case]
    inputs, outcome = make()
    solved = solve_again("resection", inputs, settings("resection", **asked), outcome.tables)
    assert solved.left_out == ""
    wanted = {"station", "rotation", "cofactor", "sigma0"} | ({"camera"} if asked else set())
    assert {part.quantity for part in solved.agreements} == wanted
    assert max(part.difference for part in solved.agreements) < 1e-6
    # it can say no: another f than the adjusted one is not confirmed
    altered = [{**row, "X_S_m": number(row["X_S_m"]) + 1.0} for row in outcome.tables["orientation"]]
    again = solve_again("resection", inputs, settings("resection", **asked), {**outcome.tables, "orientation": altered})
    assert not all(part.agrees for part in again.agreements)


def free_focal_length() -> tuple[dict[str, Tables], Outcome]:
    inputs = seen_by(TRUTH, local("right", **CAMERA), hills("free f"), noise_mm=0.01)
    return inputs, oriented(inputs, estimate="f")


def known_place(fixed: bool) -> tuple[dict[str, Tables], Outcome]:
    known = [row("known_element", quantity=name, value=value, sigma=None if fixed else 1.0) for name, value in
             zip(("X_S", "Y_S", "Z_S"), S.tolist(), strict=True)]  # fmt: skip
    inputs = seen_by(TRUTH, {**local("right", **CAMERA), "known_element": known}, hills("place"), noise_mm=0.01)
    return inputs, oriented(inputs, estimate="f,k1")


def known_angles() -> tuple[dict[str, Tables], Outcome]:
    """The kappa that the photo itself gives, 0.05 degrees off."""
    inputs = seen_by(TRUTH, local("right", **CAMERA), hills("angles"), noise_mm=0.01)
    (kappa,) = (number(one["value_deg"]) for one in oriented(inputs).tables["orientation_angle"]
                if (one["triple"], one["frame"], one["angle"]) == ("opk", "ground", "kappa"))  # fmt: skip
    known = [row("known_element", quantity="opk_kappa", value=kappa + 0.05, sigma=0.02)]
    inputs = seen_by(TRUTH, {**local("right", **CAMERA), "known_element": known}, hills("angles"), noise_mm=0.01)
    return inputs, oriented(inputs)


def test_what_the_simulation_does_not_draw_is_known() -> None:
    inputs, _ = known_and_estimated()
    assert not knows_all_unknowns(settings("resection"), inputs["photo"])


def test_the_camera_has_the_order_of_the_cofactors() -> None:
    """The project file hands the elements back by name: k1 before x0, which stands after it in Q."""
    inputs, outcome = known_and_estimated()
    by_name = sorted(outcome.tables["camera_element"], key=lambda one: str(one["unknown"]))
    stored = {**outcome.tables, "camera_element": by_name}
    (facts,) = inputs["photo"]["photo"]
    found = adjusted_camera(facts, inputs["photo"], stored)
    assert found is not None
    assert found[1] == ("f", "x0", "k1")
    plain, again = (
        covariance.compute({**inputs, "resection": tables}, settings("covariance")).tables["ground_covariance"]
        for tables in (outcome.tables, stored)
    )
    assert [one["K_XX_m2"] for one in plain] == [one["K_XX_m2"] for one in again]
