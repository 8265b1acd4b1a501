"""What the views say: stale and why, current and older versions, units, error budget."""

from pathlib import Path

import pytest

from orient.models import Base
from orient.store.project import Project, create_project, open_project
from orient.values import Outcome
from tests.store.made import INPUTS, fill, new_run, row_of

COMPUTED = [stage for stage, inputs in INPUTS.items() if inputs]


def stale(project: Project) -> dict[str, str]:
    _, rows = project.query("SELECT stage, why FROM v_stale WHERE is_stale")
    return dict(rows)


def test_nothing_is_stale_after_a_full_run(full: Path) -> None:
    with open_project(full) as project:
        assert stale(project) == {}
        _, rows = project.query("SELECT stage, version FROM v_stale")
    assert [row[0] for row in rows][-len(COMPUTED) :] == COMPUTED
    assert {row[1] for row in rows} == {1}


CHANGES = {
    "photo": ["refine", "digitize", "bl", "topocentric", "resection", "covariance", "absolute"],
    "readings": ["refine", "resection", "covariance"],
    "sheet": ["digitize", "bl", "topocentric", "resection", "covariance", "absolute"],
    "control": ["bl", "topocentric", "resection", "covariance", "absolute"],
    "model": ["absolute"],
}


@pytest.mark.parametrize("stage", CHANGES)
def test_a_new_input_makes_stale_what_depends_on_it(full: Path, stage: str) -> None:
    with open_project(full, "write") as project:
        project.append(new_run(project, stage, 0.25))
        assert list(stale(project)) == CHANGES[stage]
        project.select(stage, 1, "tester", "back")
        assert stale(project) == {}


def test_an_equal_input_makes_nothing_stale(full: Path) -> None:
    with open_project(full, "write") as project:
        project.append(new_run(project, "readings"))
        assert project.heads()["readings"].version == 2
        assert stale(project) == {}


def test_reasons_are_named(full: Path) -> None:
    with open_project(full, "write") as project:
        project.append(new_run(project, "readings", 0.25))
        assert stale(project) == {
            "refine": "readings is version 2, version 1 was read",
            "resection": "refine is stale",
            "covariance": "refine is stale; resection is stale",
        }


def test_an_optional_input_that_comes_later(tmp_path: Path) -> None:
    path = tmp_path / "p.sqlite"
    create_project(path, lambda project: fill(project, ["photo", "control", "bl", "topocentric"]))
    with open_project(path, "write") as project:
        assert stale(project) == {}
        fill(project, ["sheet"])
        later = {"bl": "digitize is stale", "topocentric": "bl is stale"}
        assert stale(project) == {"digitize": "not computed yet", **later}
        fill(project, ["digitize"])
        assert stale(project) == {"bl": "digitize is version 1, none was read", "topocentric": "bl is stale"}


def test_waiting_is_not_stale(tmp_path: Path) -> None:
    path = tmp_path / "p.sqlite"
    create_project(path, lambda project: fill(project, ["photo"]))
    with open_project(path) as project:
        assert stale(project) == {}
        waits = dict(project.query("SELECT stage, why FROM v_stale WHERE version IS NULL")[1])
    assert waits["refine"] == "waits for readings"
    assert waits["bl"] == "waits for control or digitize"
    assert waits["resection"] == "waits for refine, topocentric"


def test_iterations_are_in_degrees_and_in_order(full: Path) -> None:
    tables = {
        "iteration": [row_of(Base.metadata.tables["iteration"])],
        "iteration_parameter": [
            {"iteration": 1, "point": point, "unknown": unknown, "unit": unit, "approximation": 1.0, "correction": 0.5}
            for point, unknown, unit in [
                ("7", "Z", "m"), ("7", "X", "m"), ("", "Z_S", "m"), ("", "X_S", "m"), ("", "kappa", "rad"),
                ("", "alpha", "rad"),
            ]
        ],
    }  # fmt: skip
    with open_project(full, "write") as project:
        project.append(new_run(project, "resection", outcome=Outcome(tables)))
        query = "SELECT point, unknown, adjusted, unit FROM v_iteration WHERE is_current"
        _, rows = project.query(query)
        versions = project.query("SELECT DISTINCT version, is_current FROM v_iteration")[1]
    assert [row[:2] for row in rows] == [
        ("", "alpha"), ("", "kappa"), ("", "X_S"), ("", "Z_S"), ("7", "X"), ("7", "Z"),
    ]  # fmt: skip
    assert rows[0][2:] == (pytest.approx(85.94366926962348), "deg")
    assert rows[2][2:] == (1.5, "m")
    assert versions == [(1, 0), (2, 1)]


def test_orientation_has_sigmas(full: Path) -> None:
    cofactor = row_of(Base.metadata.tables["cofactor"])
    row = {**row_of(Base.metadata.tables["orientation"]), "variance_scale": 4.0}
    own = {**cofactor, "unknowns": "rotation", "unknown_i": "X_S", "unknown_j": "X_S", "value": 0.25}
    angle = {**row_of(Base.metadata.tables["orientation_angle"]), "triple": "aok", "angle": "alpha"}
    with open_project(full, "write") as project:
        outcome = Outcome({"orientation": [row], "cofactor": [own], "orientation_angle": [angle]})
        project.append(new_run(project, "resection", outcome=outcome))
        _, rows = project.query("SELECT element, value, sigma, unit FROM v_orientation WHERE is_current")
    assert rows[0] == ("X_S", 0.5, 1.0, "m")
    assert rows[1] == ("Y_S", 0.5, None, "m")
    assert ("aok_alpha", 0.5, 0.5, "deg") in rows
    assert len(rows) == 10


def test_error_budget_sums_to_the_whole(full: Path) -> None:
    """Two points: along X one has 4 + 1 + 3, the other 9 + 1; along the ellipse's axis at 90 deg only Y counts."""
    ground, budget = (row_of(Base.metadata.tables[name]) for name in ("ground_covariance", "error_budget"))
    points = [{**ground, "point": name, "ellipse_azimuth_deg": 90.0} for name in ("1", "2")]
    variances = [
        ("1", "image readings", "photo", 4.0), ("1", "image readings", "point", 1.0), ("1", "survey", "photo", 3.0),
        ("2", "image readings", "photo", 9.0), ("2", "survey", "photo", 1.0),
    ]  # fmt: skip
    parts = [
        {**budget, "point": point, "source": source, "part": part, "cov_XX_m2": value, "cov_YY_m2": 2 * value}
        for point, source, part, value in variances
    ]
    with open_project(full, "write") as project:
        project.append(
            new_run(project, "covariance", outcome=Outcome({"ground_covariance": points, "error_budget": parts}))
        )
        columns = "point, quantity, source, sigma_m, share_percent, photo_percent, total_sigma_m"
        _, rows = project.query(f"SELECT {columns} FROM v_error_budget WHERE is_current")
    by_key = {row[:3]: row[3:] for row in rows}
    assert len(rows) == 3 * (2 + 4)
    assert by_key["1", "X", "image readings"] == pytest.approx((5**0.5, 62.5, 50.0, 8**0.5))
    assert by_key["1", "X", "survey"] == pytest.approx((3**0.5, 37.5, 37.5, 8**0.5))
    assert by_key["1", "a", "survey"] == pytest.approx((6**0.5, 37.5, 37.5, 16**0.5))
    assert by_key["2", "Y", "image readings"] == pytest.approx((18**0.5, 90.0, 90.0, 20**0.5))
    assert by_key["", "X", "survey"] == pytest.approx(
        ((3**0.5 + 1) / 2, (37.5 + 10) / 2, 23.75, (8**0.5 + 10**0.5) / 2)
    )


def test_views_of_the_absolute_orientation_are_in_the_papers_order_and_in_degrees(full: Path) -> None:
    element, step = (row_of(Base.metadata.tables[f"absolute_{name}"]) for name in ("element", "iteration_parameter"))
    shuffled = ("Z_0", "H", "theta", "X_0", "eta", "Y_0", "xi")
    tables = {
        "absolute_element": [
            {**element, "view": view, "unknown": name} for view in ("scale", "homothety")
            for name in (shuffled if view == "homothety" else ("t", "xi", "X_0"))
        ],
        "absolute_iteration_parameter": [
            {**step, "unknown": name, "unit": "rad" if name == "xi" else "m"} for name in shuffled
        ],
        "absolute_residual": [{**row_of(Base.metadata.tables["absolute_residual"]), "vX_m": None, "vY_m": None}],
    }  # fmt: skip
    with open_project(full, "write") as project:
        project.append(new_run(project, "absolute", outcome=Outcome(tables)))
        elements = project.query("SELECT view, element FROM v_absolute_element WHERE is_current")[1]
        steps = project.query("SELECT unknown, adjusted, unit FROM v_absolute_iteration WHERE is_current")[1]
        residual = project.query("SELECT v_m FROM v_absolute_residual WHERE is_current")[1]
    papers = ["xi", "eta", "theta", "H", "X_0", "Y_0", "Z_0"]
    assert elements == [*(("homothety", name) for name in papers), ("scale", "X_0"), ("scale", "t"), ("scale", "xi")]
    assert [row[0] for row in steps] == papers
    assert steps[0][1:] == (pytest.approx(57.29577951308232), "deg") and steps[3][1:] == (1.0, "m")
    assert residual == [(0.5,)]


def test_tilt_of_a_zone_and_its_other_solutions(full: Path) -> None:
    half = 0.25**0.5
    tilted = {"q_w": half * 3**0.5, "q_x": half, "q_y": 0.0, "q_z": 0.0}
    row = {**row_of(Base.metadata.tables["absolute_orientation"]), **tilted}
    other = row_of(Base.metadata.tables["absolute_alternative"])
    outcome = Outcome({"absolute_orientation": [row], "absolute_alternative": [other, {**other, "number": 2}]})
    with open_project(full, "write") as project:
        project.append(new_run(project, "absolute", outcome=outcome))
        (found,) = project.query("SELECT tilt_deg, other_solutions FROM v_absolute_orientation WHERE is_current")[1]
    assert found == (pytest.approx(60.0), 2)
