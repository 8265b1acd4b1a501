"""Stage `absolute`: zones of a model on a curved Earth and on local ground, full and partial control."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest

from orient.errors import OrientError
from orient.geometry.rotation import matrix_from_quaternion, rotation_exp
from orient.pipeline import absolute
from orient.pipeline.registry import BY_NAME
from orient.values import Outcome, Row, Scalar, Tables
from tests.pipeline.made import (
    Array,
    Place,
    frame_in,
    framed,
    geographic_rows,
    local,
    matrix_of,
    photo,
    places,
    random,
)

SETTINGS = BY_NAME["absolute"].settings
ROTATION = rotation_exp([0.05, -0.08, 0.0]) @ rotation_exp([0.0, 0.0, 2.4])
H, X0 = 0.002, np.array([3000.0, -2000.0, 900.0])
"""Truth of zone A: model units of 500 m, in the right-handed frame."""


def model_rows(zone: str, points: Sequence[str], model: Array) -> list[Row]:
    return [
        {"zone": zone, "point": point, **dict(zip("xyz", map(float, xyz), strict=True))}
        for point, xyz in zip(points, model, strict=True)
    ]


def inputs_of(facts: Tables, chosen: Sequence[Place], noise: float = 0.0, extra: Sequence[Place] = ()) -> Mapping:
    """A model of all places in which they lie where they are really seen, of the control given in `chosen`."""
    is_local = facts["photo"][0]["ground_kind"] == "local"
    given = framed(facts, geographic_rows(chosen, is_local))
    everyone = [*chosen, *extra]
    place = right_handed(facts, given, everyone)
    model = H * (place - X0) @ ROTATION + noise * random("model").normal(size=place.shape)
    rows = model_rows("A", [one.name for one in everyone], model)
    return {"photo": facts, "topocentric": given, "model": {"model_point": rows}}


def right_handed(facts: Tables, given: Tables, chosen: Sequence[Place]) -> Array:
    frame = frame_in(facts, given)
    seen = np.array([place.seen for place in chosen])
    if frame.origin is not None:
        seen = frame.from_geographic(*np.radians(seen[:, :2]).T, seen[:, 2])
    return frame.right_handed(seen)


def local_places(count: int, name: str) -> list[Place]:
    where = random(name).uniform(-1, 1, (count, 3)) * [4000.0, 3000.0, 600.0] + [5000.0, 7000.0, 300.0]
    return [Place(f"P{number:02}", tuple(xyz), tuple(xyz)) for number, xyz in enumerate(where.tolist(), 1)]


def computed(inputs: Mapping[str, Tables], **given: Scalar) -> Outcome:
    outcome = absolute.compute(inputs, {**SETTINGS, **given})
    assert outcome.error == ""
    return outcome


def failed(inputs: Mapping[str, Tables], **given: Scalar) -> Outcome:
    outcome = absolute.compute(inputs, {**SETTINGS, **given})
    assert outcome.error
    assert set(outcome.tables) <= {"absolute_iteration", "absolute_iteration_parameter"}
    return outcome


def xyz(rows: Sequence[Row], *names: str) -> Array:
    return np.array([[row[name] for name in names or ("X_m", "Y_m", "Z_m")] for row in rows], dtype=float)


def codes(outcome: Outcome) -> list[str]:
    return [event.code for event in outcome.events]


@pytest.mark.parametrize(
    ("facts", "chosen"),
    [
        pytest.param(photo(), places(8, "absolute", 0.05), id="earth"),
        pytest.param(local("right"), local_places(8, "right"), id="local right"),
        pytest.param(local("left"), local_places(8, "left"), id="local left"),
    ],
)
def test_every_frame_gives_the_truth_and_all_points(facts: Tables, chosen: list[Place]) -> None:
    extra = [replace(place, name=f"N{place.name}") for place in chosen[:3]]
    inputs = inputs_of(facts, chosen, extra=extra)
    outcome = computed(inputs)
    frame = frame_in(facts, inputs["topocentric"])
    (found,) = outcome.tables["absolute_orientation"]
    quaternion = [found[name] for name in ("q_w", "q_x", "q_y", "q_z")]
    np.testing.assert_allclose(matrix_from_quaternion(quaternion), ROTATION, atol=1e-9)
    np.testing.assert_allclose(frame.right_handed(xyz([found], "X_0_m", "Y_0_m", "Z_0_m")[0]), X0, atol=1e-5)
    np.testing.assert_allclose([found["H"], found["t"]], [H, 1 / H], rtol=1e-9)
    assert (found["n_full"], found["n_equations"], found["redundancy"]) == (8, 24, 17)
    points = outcome.tables["model_ground_point"]
    expected = frame.right_handed(right_handed(facts, inputs["topocentric"], [*chosen, *extra]))
    np.testing.assert_allclose(xyz(points), expected, atol=1e-5)
    assert [row["role"] for row in points] == ["control"] * 8 + ["free"] * 3
    if frame.origin is not None:
        seen = np.array([place.seen for place in [*chosen, *extra]])
        np.testing.assert_allclose(xyz(points, "B_deg", "L_deg"), seen[:, :2], atol=1e-9)
        np.testing.assert_allclose(xyz(points, "H_m")[:, 0], seen[:, 2], atol=1e-4)
    else:
        assert points[0]["B_deg"] is None
    np.testing.assert_allclose(xyz(outcome.tables["absolute_residual"], "vX_m", "vY_m", "vZ_m"), 0, atol=1e-5)


def without(place: Place, kind: str) -> Place:
    first, second, third = place.given
    given = {"f": place.given, "p": (first, second, None), "h": (None, None, third)}[kind]
    return replace(place, given=given)


@pytest.mark.parametrize("kinds", ["ffh", "ffphhp", "pphhh", "pppphhhh"])
@pytest.mark.parametrize("where", ["earth", "local"])
def test_partial_control_on_the_curved_earth(kinds: str, where: str) -> None:
    """Heights are curved surfaces: 40 km from the origin they are 125 m off the plane."""
    whole = places(len(kinds), f"partial {kinds}", 0.4) if where == "earth" else local_places(len(kinds), kinds)
    facts = photo() if where == "earth" else local("left")
    inputs = inputs_of(facts, [without(place, kind) for place, kind in zip(whole, kinds, strict=True)])
    outcome = computed(inputs)
    frame = frame_in(facts, inputs["topocentric"])
    found = frame.right_handed(xyz(outcome.tables["model_ground_point"]))
    np.testing.assert_allclose(found, right_handed(facts, inputs["topocentric"], whole), atol=0.02)
    (row,) = outcome.tables["absolute_orientation"]
    assert (row["n_full"], row["n_plan"], row["n_height"]) == tuple(kinds.count(kind) for kind in "fph")
    for residual, kind in zip(outcome.tables["absolute_residual"], kinds, strict=True):
        given = [residual[name] is not None for name in ("vX_m", "vY_m", "vZ_m")]
        assert given == {"f": [True] * 3, "p": [True, True, False], "h": [False, False, True]}[kind]
        assert [residual[f"redundancy_{axis}"] is not None for axis in "XYZ"] == given
    if row["redundancy"] == 0:
        assert "no_redundancy" in codes(outcome)
        assert row["sigma0"] is None and row["variance_scale"] is None
        assert outcome.tables["model_ground_point"][0]["cov_XX_m2"] is None
    if kinds == "ffh":
        assert {"two_solutions", "ambiguous_model"}.intersection(codes(outcome))
        assert len(outcome.tables["absolute_alternative"]) == 1


def test_redundancy_numbers_sum_to_the_redundancy() -> None:
    chosen = local_places(7, "redundancy")
    inputs = inputs_of(local("left"), [without(p, k) for p, k in zip(chosen, "fffpphh", strict=True)], noise=1e-4)
    outcome = computed(inputs)
    numbers = xyz(outcome.tables["absolute_residual"], "redundancy_X", "redundancy_Y", "redundancy_Z")
    np.testing.assert_allclose(np.nansum(numbers), 15 - 7, atol=1e-9)


def test_zones_have_their_own_parameters() -> None:
    facts, chosen = local("right"), local_places(10, "zones")
    inputs = inputs_of(facts, chosen)
    first = list(inputs["model"]["model_point"])
    turned = xyz(first[4:], "x", "y", "z") @ rotation_exp([0, 0, 1.0]).T * 3 + [5.0, 6.0, 7.0]
    names = [str(row["point"]) for row in first[4:]]
    model = {"model_point": [*first[:7], *model_rows("B", names, turned)]}
    outcome = computed({**inputs, "model": model})
    scales = {row["zone"]: row["H"] for row in outcome.tables["absolute_orientation"]}
    np.testing.assert_allclose([scales["A"], scales["B"]], [H, 3 * H], rtol=1e-9)
    assert "zones_differ" in codes(outcome)
    by_zone = {(row["zone"], row["point"]): row for row in outcome.tables["model_ground_point"]}
    np.testing.assert_allclose(xyz([by_zone["A", "P05"]]), xyz([by_zone["B", "P05"]]), atol=1e-6)
    assert "zone A: 7 full" in outcome.summary and "zone B: 6 full" in outcome.summary


def test_one_zone_without_control_fails_the_run_and_is_named() -> None:
    inputs = inputs_of(local("right"), local_places(6, "no control"))
    rows = [*inputs["model"]["model_point"], *model_rows("B", ["Q1", "Q2"], np.eye(3)[:2])]
    outcome = failed({**inputs, "model": {"model_point": rows}})
    assert "zone B: 0 full" in outcome.error
    assert "zone A" not in outcome.error
    assert {row["zone"] for row in outcome.tables["absolute_iteration"]} == {"A"}


def test_singular_control_is_named_in_the_words_of_the_frame() -> None:
    line = [
        Place(f"P{k}", xyz, xyz)
        for k, xyz in enumerate([(0.0, 0.0, 0.0), (100.0, 50.0, 3.0), (200.0, 100.0, 6.0), (300.0, 150.0, 9.0)])
    ]
    outcome = failed(inputs_of(local("left"), line))
    assert "SINGULAR" in outcome.error and "P0, P1, P2, P3 lie on one line" in outcome.error
    assert "the rotation about" in outcome.error and "r_X" not in outcome.error
    assert "singular" in codes(outcome)


def test_wrong_handedness_is_called_mirrored() -> None:
    chosen = local_places(7, "mirrored")
    inputs = inputs_of(local("left"), chosen)
    outcome = failed({**inputs, "topocentric": framed(local("right"), geographic_rows(chosen, is_local=True))})
    assert "MIRRORED" in outcome.error and "handedness" in outcome.hint
    assert "mirrored" in codes(outcome)


def test_weights_of_both_sides_scale_to_sigma0_one() -> None:
    """Ground 0.3 m, model 0.1 m on the ground: sigma0 near 1, v shared by variance, own errors in the points."""
    chance = random("weights")
    facts, sigma, sigma_model = local("left"), 0.3, 0.1 * H
    covariance = sigma**2 * np.eye(3)
    chosen = [
        replace(place, given=tuple(np.array(place.seen) + sigma * chance.normal(size=3)), covariance=covariance)
        for place in local_places(60, "weights")
    ]
    extra = [Place("N", chosen[0].seen, chosen[0].seen)]
    inputs = inputs_of(facts, chosen, noise=sigma_model, extra=extra)
    outcome = computed(inputs, sigma_model=sigma_model)
    (row,) = outcome.tables["absolute_orientation"]
    assert row["sigma0_unit"] == "1"
    assert 0.85 < float(row["sigma0"]) < 1.15
    residual = outcome.tables["absolute_residual"][0]
    gap = xyz([residual], "vX_m", "vY_m", "vZ_m")[0]
    on_ground = xyz([residual], "v_ground_X_m", "v_ground_Y_m", "v_ground_Z_m")[0]
    np.testing.assert_allclose(on_ground, gap * 0.9, rtol=1e-4)
    in_model = xyz([residual], "v_model_x", "v_model_y", "v_model_z")[0]
    np.testing.assert_allclose(np.linalg.norm(in_model) / H, 0.1 * np.linalg.norm(gap), rtol=1e-3)
    points = outcome.tables["model_ground_point"]
    own = 0.1**2 * float(row["variance_scale"])
    assert own < float(points[-1]["cov_XX_m2"]) < 2 * own
    assert np.linalg.eigvalsh(matrix_of(points[-1])).min() > 0
    a_priori = computed(inputs, sigma_model=sigma_model, variance="priori")
    assert a_priori.tables["absolute_orientation"][0]["variance_scale"] == 1.0


def test_own_covariances_of_model_points_are_used() -> None:
    inputs = inputs_of(local("right"), local_places(6, "own"), noise=1e-4)
    columns = ("cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz")
    equal = dict(zip(columns, (1e-8, 0.0, 0.0, 1e-8, 0.0, 1e-8), strict=True))
    rows = [{**row, **equal} for row in inputs["model"]["model_point"]]
    given = computed({**inputs, "model": {"model_point": rows}})
    stated = computed(inputs, sigma_model=1e-4)
    assert given.tables == stated.tables
    half = [*rows[:3], *inputs["model"]["model_point"][3:]]
    with pytest.raises(OrientError, match='model point "P04" of zone "A" has no standard deviation'):
        absolute.compute({**inputs, "model": {"model_point": half}}, SETTINGS)
    mixed = computed({**inputs, "model": {"model_point": half}}, sigma_model=1e-4)
    np.testing.assert_allclose(mixed.tables["absolute_orientation"][0]["H"], H, rtol=1e-3)


def test_errorless_control_beside_weighted_control_asks_for_the_model() -> None:
    chosen = local_places(6, "mixed")
    chosen[2] = replace(chosen[2], covariance=np.eye(3))
    inputs = inputs_of(local("right"), chosen)
    outcome = failed(inputs)
    assert "point P01 has no error on the ground and none in the model" in outcome.error
    assert computed(inputs, sigma_model=0.001).tables["absolute_orientation"][0]["sigma0_unit"] == "1"
    assert computed(inputs, control="fixed").tables["absolute_orientation"][0]["sigma0_unit"] == "m"
    with pytest.raises(OrientError, match='"P01" has no standard deviation'):
        absolute.compute(inputs, {**SETTINGS, "control": "weighted"})


def test_check_points_are_compared_and_not_adjusted() -> None:
    chosen = local_places(7, "check")
    off = tuple(np.add(chosen[6].seen, [0.0, 2.0, -1.0]))
    chosen[6] = replace(chosen[6], role="check", given=off)
    outcome = computed(inputs_of(local("left"), chosen))
    assert outcome.tables["absolute_orientation"][0]["n_full"] == 6
    residual = outcome.tables["absolute_residual"][-1]
    assert (residual["point"], residual["role"], residual["redundancy_X"]) == ("P07", "check", None)
    np.testing.assert_allclose(xyz([residual], "vX_m", "vY_m", "vZ_m")[0], [0.0, -2.0, 1.0], atol=1e-6)


def test_elements_cofactors_and_iterations_are_stored_in_the_frame() -> None:
    """Left-handed ground: X_0 and Y_0 change places, and so do their cofactors and corrections."""
    inputs = inputs_of(local("left"), local_places(6, "stored"), noise=1e-4)
    tables = computed(inputs).tables
    elements = {(row["view"], row["unknown"]): row for row in tables["absolute_element"]}
    assert len(elements) == 21
    (row,) = tables["absolute_orientation"]
    for view, unknown in [("homothety", "X_0"), ("scale", "X_0")]:
        assert elements[view, unknown]["value"] == row["X_0_m"]
    np.testing.assert_allclose(elements["joint", "T_Y"]["value"], row["H"] * row["Y_0_m"])
    cofactor = {(r["unknowns"], r["unknown_i"], r["unknown_j"]): r["value"] for r in tables["absolute_cofactor"]}
    assert len(cofactor) == 4 * 28
    for view, unknown in [("homothety", "Y_0"), ("scale", "t"), ("joint", "H")]:
        sigma = np.sqrt(row["variance_scale"] * cofactor[view, unknown, unknown])
        np.testing.assert_allclose(elements[view, unknown]["sigma"], sigma, rtol=1e-9)
    last = max(int(r["iteration"]) for r in tables["absolute_iteration"])
    steps = {r["unknown"]: r for r in tables["absolute_iteration_parameter"] if r["iteration"] == last}
    assert list(steps) == ["xi", "eta", "theta", "H", "X_0", "Y_0", "Z_0"]
    for unknown, column in [("X_0", "X_0_m"), ("H", "H")]:
        end = steps[unknown]["approximation"] + steps[unknown]["correction"]
        np.testing.assert_allclose(end, row[column], rtol=1e-12)
    theta = np.degrees(steps["theta"]["approximation"] + steps["theta"]["correction"])
    np.testing.assert_allclose(theta, elements["homothety", "theta"]["value"], rtol=1e-9)


def test_small_angles_stand_beside_the_rigorous_elements() -> None:
    facts, chosen = local("left"), local_places(6, "small")
    given = framed(facts, geographic_rows(chosen, is_local=True))
    model = right_handed(facts, given, chosen) @ rotation_exp([1e-4, -2e-4, 3e-4]) * 1.0002
    rows = model_rows("A", [place.name for place in chosen], model)
    inputs = {"photo": facts, "topocentric": given, "model": {"model_point": rows}}
    outcome = computed(inputs, small_angles=True)
    small = {row["unknown"]: row for row in outcome.tables["absolute_small_angle"]}
    for unknown in ("t", "xi", "eta", "theta"):
        np.testing.assert_allclose(small[unknown]["value"], small[unknown]["rigorous"], atol=1e-5)
    elements = {row["unknown"]: row["value"] for row in outcome.tables["absolute_element"] if row["view"] == "scale"}
    assert {name: row["rigorous"] for name, row in small.items()} == pytest.approx(elements)
    assert "small_angles" in codes(outcome)
    assert "absolute_small_angle" not in computed(inputs).tables


def test_control_outside_the_model_is_said() -> None:
    inputs = inputs_of(local("right"), local_places(7, "outside"))
    rows = inputs["model"]["model_point"][:6]
    outcome = computed({**inputs, "model": {"model_point": rows}})
    (event,) = [event for event in outcome.events if event.code == "not_in_model"]
    assert event.subject == "P07"


def test_rows_of_one_table_have_the_same_columns() -> None:
    chosen = local_places(8, "columns")
    chosen[7] = replace(chosen[7], role="check")
    chosen[6] = without(chosen[6], "h")
    outcome = computed(inputs_of(local("left"), chosen, noise=1e-4), small_angles=True)
    for table, rows in outcome.tables.items():
        assert len({tuple(row) for row in rows}) <= 1, table
        assert all(value is None or isinstance(value, str | int | float) for row in rows for value in row.values())
        assert not any(type(value).__module__ == "numpy" for row in rows for value in row.values()), table


def test_the_equations_of_the_papers_say_what_the_residuals_say() -> None:
    """l of all three forms is the residual of the adjustment, and their partials agree about the same small motion."""
    chosen = local_places(8, "columns")
    outcome = computed(inputs_of(local("right"), chosen, noise=1e-4))
    rows = outcome.tables["absolute_equation"]
    residuals = {row["point"]: row for row in outcome.tables["absolute_residual"]}
    assert {row["form"] for row in rows} == {"homothety", "joint", "scale"}
    assert len(rows) == 3 * 3 * 8
    for row in rows:
        assert row["l_m"] == pytest.approx(residuals[row["point"]][f"v{row['axis']}_m"], abs=1e-9)
    by_form = {
        form: np.array([[row[f"a{k}"] for k in range(1, 8)] for row in rows if row["form"] == form])
        for form in ("homothety", "joint", "scale")
    }
    # one and the same space of motions: each form's columns are combinations of those of another
    for other in ("joint", "scale"):
        combined = by_form["homothety"] @ np.linalg.lstsq(by_form["homothety"], by_form[other], rcond=None)[0]
        np.testing.assert_allclose(combined, by_form[other], atol=1e-6 * np.abs(by_form[other]).max())
