"""Stage `bl`: coordinates and covariances of all kinds on the ground's ellipsoid."""

import numpy as np
import pytest
from pyproj import Proj, Transformer

from orient.errors import OrientError
from orient.geodesy.ellipsoid import meridian_radius, prime_vertical_radius
from orient.pipeline import bl
from orient.pipeline.ground import ground_of
from orient.values import Outcome, Row, Scalar, Tables
from tests.jacobian import central_difference
from tests.pipeline.made import Array, covariance_of, local, matrix_of, photo, random, row, settings

WGS84 = {"ground_kind": "crs", "ground_crs": "EPSG:4326"}


def control(*rows: Row, crs: str | None = None) -> Tables:
    return {"control_system": [row("control_system", crs=crs)], "control_point": rows}


def point(name: str, kind: str, covariance: Array | None = None, role: str = "control", **given: Scalar) -> Row:
    return row("control_point", point=name, role=role, kind=kind, **given, **covariance_of(covariance))


def placed(facts: Tables, given: Tables, digitized: Tables | None = None, allow: bool = False) -> Outcome:
    inputs = {"photo": facts, "control": given}
    if digitized is not None:
        inputs["digitize"] = digitized
    return bl.compute(inputs, settings("bl", allow_ballpark=allow))


def any_covariance(name: str) -> Array:
    A = random(name).normal(size=(3, 3))
    return np.asarray(A @ A.T)


def test_geocentric_covariance_turns_into_the_horizon() -> None:
    xyz, covariance = np.array([4387000.0, 1733000.0, 4280000.0]), any_covariance("geocentric")
    facts = photo()
    given = point("P", "geocentric", covariance, **dict(zip(("X_m", "Y_m", "Z_m"), xyz.tolist(), strict=True)))
    outcome = placed(facts, control(given))
    (found,) = outcome.tables["geographic_point"]
    ground = ground_of(facts["photo"][0])
    L, B, H = ground.geographic_from_geocentric(xyz[None])[0]
    assert (found["B_deg"], found["L_deg"], found["H_m"]) == pytest.approx((B, L, H))

    def north_east_up(place: Array) -> Array:
        longitude, latitude, height = ground.geographic_from_geocentric(place[None])[0]
        dB, dL = np.radians([latitude - B, longitude - L])
        M = float(meridian_radius(ground.figure, np.radians(B)))
        N = float(prime_vertical_radius(ground.figure, np.radians(B)))
        return np.array([(M + H) * dB, (N + H) * np.cos(np.radians(B)) * dL, height - H])

    J = central_difference(north_east_up, xyz, 1.0)
    assert matrix_of(found) == pytest.approx(J @ covariance @ J.T, rel=1e-5, abs=1e-5)
    assert found["weighting"] == "weighted"


def test_projected_control_and_its_covariance_from_grid_north() -> None:
    covariance = np.diag([9.0, 1.0, 4.0])  # along grid north, grid east, up
    given = point("P", "projected", covariance, E_m=700_000.0, N_m=4_650_000.0, H_m=321.0)
    outcome = placed(photo(**WGS84), control(given, crs="EPSG:32634"))
    (found,) = outcome.tables["geographic_point"]
    L, B = Transformer.from_crs("EPSG:32634", "EPSG:4326", always_xy=True).transform(700_000.0, 4_650_000.0)
    assert (found["B_deg"], found["L_deg"], found["H_m"]) == pytest.approx((B, L, 321.0))
    gamma = np.radians(Proj("EPSG:32634").get_factors(L, B).meridian_convergence)
    assert gamma > 0.02  # east of the central meridian grid north points east of north
    turn = np.array([[np.cos(gamma), -np.sin(gamma), 0.0], [np.sin(gamma), np.cos(gamma), 0.0], [0.0, 0.0, 1.0]])
    assert matrix_of(found) == pytest.approx(turn @ covariance @ turn.T, abs=1e-4)


def test_geographic_control_without_errors_is_fixed() -> None:
    outcome = placed(photo(), control(point("P", "geographic", B_deg=42.0, L_deg=22.0, H_m=5.0)))
    (found,) = outcome.tables["geographic_point"]
    assert (found["weighting"], found["cov_XX_m2"]) == ("fixed", None)
    assert (found["B_deg"], found["L_deg"], found["H_m"]) == (42.0, 22.0, 5.0)


@pytest.mark.parametrize("crs", [None, "EPSG:4326"])
def test_partly_given_points_stay_partly_given(crs: str | None) -> None:
    given = [point("plan", "geographic", B_deg=42.0, L_deg=22.0), point("height", "geographic", H_m=77.0)]
    outcome = placed(photo(**WGS84), control(*given, crs=crs))
    plan, height = outcome.tables["geographic_point"]
    assert (plan["B_deg"], plan["L_deg"], plan["H_m"]) == (pytest.approx(42.0), pytest.approx(22.0), None)
    assert (height["B_deg"], height["L_deg"], height["H_m"]) == (None, None, 77.0)


def test_a_datum_change_is_recorded() -> None:
    outcome = placed(
        photo(**WGS84), control(point("P", "geographic", B_deg=42.0, L_deg=12.5, H_m=5.0), crs="EPSG:4230")
    )
    (operation,) = outcome.tables["crs_operation"]
    assert "ED50 to WGS 84" in str(operation["name"])
    assert (operation["source_crs"], operation["is_ballpark"]) == ("EPSG:4230", 0)
    assert 0 < float(operation["accuracy_m"]) < 50  # type: ignore[arg-type]
    assert "helmert" in str(operation["definition"])
    (found,) = outcome.tables["geographic_point"]
    again = Transformer.from_pipeline(str(operation["definition"]))
    assert abs(float(found["B_deg"]) - 42.0) > 1e-4  # type: ignore[arg-type]
    assert again.definition


def test_a_ballpark_is_refused_unless_allowed() -> None:
    given = control(
        point("P", "geographic", B_deg=42.0, L_deg=22.0, H_m=5.0), crs="+proj=longlat +ellps=krass +type=crs"
    )
    with pytest.raises(OrientError) as caught:
        placed(photo(**WGS84), given)
    assert "ballpark" in caught.value.message
    assert "--allow-ballpark" in caught.value.hint
    (operation,) = placed(photo(**WGS84), given, allow=True).tables["crs_operation"]
    assert operation["is_ballpark"] == 1


def digitized(name: str, B: float) -> Tables:
    return {
        "sheet_transform": [row("sheet_transform", sheet="S", target="geographic")],
        "digitized_point": [
            row("digitized_point", sheet="S", point=name, B_deg=B, L_deg=22.0, H_m=10.0, sigma_H_m=2.0, cov_NN_m2=9.0,
                cov_NE_m2=1.0, cov_EE_m2=4.0)
        ],
    }  # fmt: skip


def test_control_comes_before_a_sheet_and_it_is_said() -> None:
    outcome = placed(
        photo(), control(point("P", "geographic", B_deg=42.0, L_deg=22.0, H_m=5.0)), digitized("P", 42.001)
    )
    (found,) = outcome.tables["geographic_point"]
    assert (found["source"], found["B_deg"]) == ("control", 42.0)
    assert [(event.code, event.subject) for event in outcome.events] == [("given_twice", "P")]


def test_points_of_a_sheet_take_their_role_from_the_control_list() -> None:
    outcome = placed(photo(), control(point("P", "listed", role="check"), point("Q", "listed")), digitized("P", 42.0))
    (found,) = outcome.tables["geographic_point"]
    assert (found["source"], found["role"], found["weighting"]) == ("S", "check", "weighted")
    assert matrix_of(found).tolist() == [[9.0, 1.0, 0.0], [1.0, 4.0, 0.0], [0.0, 0.0, 4.0]]
    assert [(event.code, event.subject) for event in outcome.events] == [("no_coordinates", "Q")]


def test_local_points_pass_through_and_it_is_said() -> None:
    outcome = placed(local("right"), control(point("P", "local", np.eye(3), X_m=1.0, Y_m=2.0, Z_m=3.0)))
    (found,) = outcome.tables["geographic_point"]
    assert (found["X_m"], found["Y_m"], found["Z_m"], found["B_deg"]) == (1.0, 2.0, 3.0, None)
    assert [event.code for event in outcome.events] == ["passed_through"]


@pytest.mark.parametrize("facts", [local("right"), photo()], ids=["local ground", "ellipsoid"])
def test_local_and_geodetic_do_not_mix(facts: Tables) -> None:
    on_the_earth = point("P", "geographic", B_deg=42.0, L_deg=22.0, H_m=5.0)
    other = (
        on_the_earth if facts["photo"][0]["ground_kind"] == "local" else point("P", "local", X_m=1.0, Y_m=2.0, Z_m=3.0)
    )
    with pytest.raises(OrientError, match="but the photo's ground is"):
        placed(facts, control(other))
