"""Stage `digitize`: the covariance of a point is what a thousand maps show."""

import numpy as np
import pytest

from orient.pipeline import digitize
from orient.values import Row, Scalar, Tables
from tests.pipeline.made import Array, photo, random, row, settings

TRIALS = 2000
TOLERANCE = 4 * np.sqrt(2 / TRIALS)
"""Four standard deviations of a variance that is estimated from so many trials."""
CROSS_MM, READING_MM = 0.05, 0.07
METRES_PER_MM = 500.0
TURN = np.array([[np.cos(0.2), -np.sin(0.2)], [np.sin(0.2), np.cos(0.2)]])
CROSSES = np.array([(x, y) for x in np.linspace(50.0, 350.0, 5) for y in np.linspace(60.0, 300.0, 4)])
POINT = np.array([120.0, 340.0])


def ground(XY: Array) -> Array:
    """(n, 2) N, E of places on the table."""
    return np.asarray(METRES_PER_MM * XY @ TURN.T)


def sheet(crosses: Array, readings: Array, **given: Scalar) -> Tables:
    NE = ground(CROSSES)
    return {
        "map_sheet": [row("map_sheet", sheet="S", crs="EPSG:32634", **given)],
        "graticule_cross": [
            row("graticule_cross", seq=i + 1, sheet="S", cross=f"{i}", role="fit", X_mm=float(X), Y_mm=float(Y),
                N_m=float(NE[i, 0]), E_m=float(NE[i, 1]))
            for i, (X, Y) in enumerate(crosses)
        ],
        "digitizer_reading": [
            row("digitizer_reading", seq=cycle, sheet="S", point="P", cycle=cycle, X_mm=float(X), Y_mm=float(Y),
                H_m=12.0, sigma_H_m=3.0)
            for cycle, (X, Y) in enumerate(readings, 1)
        ],
    }  # fmt: skip


def point_of(tables: Tables, **given: Scalar) -> Row:
    outcome = digitize.compute({"photo": photo(), "sheet": tables}, settings("digitize", **given))
    (found,) = outcome.tables["digitized_point"]
    return found


def test_covariance_is_coefficients_plus_reading() -> None:
    chance = random("digitize")
    places, stated = np.empty((TRIALS, 2)), np.empty((TRIALS, 2, 2))
    for trial in range(TRIALS):
        crosses = CROSSES + chance.normal(scale=CROSS_MM, size=CROSSES.shape)
        readings = POINT + chance.normal(scale=READING_MM, size=(3, 2))
        found = point_of(sheet(crosses, readings, sigma_mm=READING_MM, degree=2))
        places[trial] = found["N_m"], found["E_m"]
        NN, NE, EE = (found[f"cov_{part}_m2"] for part in ("NN", "NE", "EE"))
        stated[trial] = [[NN, NE], [NE, EE]]
    spread = np.cov((places - ground(POINT[None])).T)
    mean = stated.mean(axis=0)
    assert np.diag(mean) == pytest.approx(np.diag(spread), rel=TOLERANCE)
    assert abs(spread[0, 1] - mean[0, 1]) < TOLERANCE * spread[0, 0]
    reading_only = (METRES_PER_MM * READING_MM) ** 2 / 3
    assert spread[0, 0] > 1.2 * reading_only, "the coefficients must matter, or they are not tested"


def test_parts_of_the_covariance() -> None:
    found = point_of(sheet(CROSSES, np.array([POINT, POINT]), sigma_mm=READING_MM, degree=1))
    reading = (METRES_PER_MM * READING_MM) ** 2 / 2
    assert found["cov_reading_NN_m2"] == pytest.approx(reading)
    assert found["cov_NN_m2"] == pytest.approx(reading)  # perfect crosses: nothing from the coefficients
    assert (found["H_m"], found["sigma_H_m"], found["n_cycles"]) == (12.0, 3.0, 2)
    assert (found["N_m"], found["E_m"]) == pytest.approx(tuple(ground(POINT)))


def test_degree_of_the_command_comes_before_that_of_the_sheet() -> None:
    tables = sheet(CROSSES, POINT[None], degree=1)
    for asked, degree in ((None, 1), (3, 3)):
        outcome = digitize.compute({"photo": photo(), "sheet": tables}, settings("digitize", degree=asked))
        assert outcome.tables["sheet_transform"][0]["degree"] == degree


@pytest.mark.parametrize("reject", [False, True], ids=["kept", "rejected"])
def test_a_bad_cross_is_named(reject: bool) -> None:
    crosses = CROSSES + random("bad cross").normal(scale=CROSS_MM, size=CROSSES.shape)
    crosses[7, 0] += 2.0
    outcome = digitize.compute(
        {"photo": photo(), "sheet": sheet(crosses, POINT[None], degree=1)}, settings("digitize", reject=reject)
    )
    (event,) = (event for event in outcome.events if event.code == "bad_cross")
    assert event.subject == "S 7"
    roles = {row["cross"]: row["role"] for row in outcome.tables["cross_residual"]}
    assert roles["7"] == ("rejected" if reject else "fit")
