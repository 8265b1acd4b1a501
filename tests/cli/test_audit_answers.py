"""The reviewer's answers against independent computation."""

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

import orient
from orient.geometry.collinearity import project
from orient.geometry.rotation import rotation_exp
from tests.cli.commands import AERIAL, SAMPLES
from tests.cli.commands import orient as command
from tests.cli.story import PAGE, make_story, outputs

Array = np.ndarray
ELEMENTS = ("rotation_1", "rotation_2", "rotation_3", "X_S", "Y_S", "Z_S")


@pytest.fixture(scope="session")
def story_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_story(tmp_path_factory.mktemp("story"))


@pytest.fixture
def story(story_once: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(story_once, tmp_path / "calgary.sqlite"))


def ask(path: Path, question: str, **given: object) -> list[dict[str, Any]]:
    sets = [word for name, value in given.items() for word in ("--set", f"{name}={value}")]
    said = command("sql", path, question, *sets, "--json")
    assert (said.code, said.err) == (0, "")
    rows: list[dict[str, Any]] = json.loads(said.out)
    return rows


def test_the_outputs_of_the_page_are_those_of_the_program(tmp_path: Path) -> None:
    text = PAGE.read_text("utf-8")
    assert outputs.comparable(outputs.refreshed(text, tmp_path)) == outputs.comparable(text), (
        "run: python docs/outputs.py docs/audit.md"
    )


# ------------------------------------------------------------------------------- 1. which reading moved X_S most


def adjusted(photo: orient.Photo, without: int | None) -> Array:
    """(6,) r [rad], S [m] by scipy, from stored image and ground coordinates; one of the 2n coordinates left out."""
    image = dict(zip(*_columns(photo, "image_point", "refine", "x_mm", "y_mm"), strict=True))
    names, ground = _columns(photo, "topocentric_point", "topocentric", "X_m", "Y_m", "Z_m")
    measured = np.array([image[name] for name in names])
    o = photo.orientation
    keep = np.arange(2 * len(names)) != (-1 if without is None else without)

    def misfit(x: Array) -> Array:
        computed, _ = project(ground, o.station + x[3:], rotation_exp(x[:3]) @ o.rotation, o.f_mm)
        return ((computed - measured).ravel() / 0.006)[keep]

    found = least_squares(misfit, np.zeros(6), x_scale=[1e-3] * 3 + [1.0] * 3, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    return found.x


def _columns(photo: orient.Photo, table: str, stage: str, *names: str) -> tuple[list[str], Array]:
    rows = photo.table(table, stage)
    return rows["point"].tolist(), rows.array(*names)


def test_influence_is_what_an_adjustment_without_the_reading_gives(tmp_path: Path) -> None:
    """Every coordinate of every point left out in turn, by another program."""
    photo = orient.new(tmp_path / "p.sqlite", AERIAL)
    for stage in ("refine", "bl", "topocentric"):
        photo.run(stage)
    photo.run("resection", interior="fixed")
    names, _ = _columns(photo, "topocentric_point", "topocentric", "X_m")
    table = photo.ask("SELECT element, point, axis, moved, moved_sigmas FROM v_influence WHERE is_current")
    moved = {(e, p, a): (m, s) for e, p, a, m, s in zip(*(table[name].tolist() for name in table), strict=True)}
    assert len(moved) == 6 * 2 * 8
    whole = adjusted(photo, None)
    sigmas = np.sqrt(np.diag(photo.orientation.covariance))
    for i in range(2 * len(names)):
        change = (whole - adjusted(photo, i)) / sigmas
        told = np.array([moved[element, names[i // 2], "xy"[i % 2]][1] for element in ELEMENTS])
        # first order: the curvature of collinearity over moves of some sigmas (0.2 mrad) is below 1 % of them
        np.testing.assert_allclose(told, change, atol=0.01 * np.abs(change).max() + 1e-6)
        metres = [moved[element, names[i // 2], "xy"[i % 2]][0] for element in ELEMENTS[3:]]
        np.testing.assert_allclose(metres, told[3:] * sigmas[3:], rtol=1e-9)


def test_the_change_by_one_unit_is_the_central_difference(tmp_path: Path) -> None:
    """Reading 105 shifted by +-0.05 px in the list, everything computed anew, with fiducials as unknowns too."""
    text, step = (AERIAL / "readings.csv").read_text(), 0.05
    line = next(line for line in text.splitlines() if line.startswith("105,point"))
    start, col, row = line.rsplit(",", 2)
    stations = []
    for sign in (1, -1):
        folder = Path(shutil.copytree(AERIAL, tmp_path / f"folder{sign}"))
        shifted = f"{start},{float(col) + sign * step},{row}"
        (folder / "readings.csv").write_text(text.replace(line, shifted))
        photo = orient.new(tmp_path / f"{sign}.sqlite", folder)
        photo.run()
        stations.append(photo.orientation.station)
    photo = orient.new(tmp_path / "p.sqlite", AERIAL)
    photo.run()
    names, comparator = _columns(photo, "image_point", "refine", "x_comparator_mm", "y_comparator_mm")
    assert "105" in names and len(comparator) == len(names)
    image = []
    for sign in (1, -1):
        other = orient.open(tmp_path / f"{sign}.sqlite").table("image_point", "refine")
        at = other["point"].tolist().index("105")
        image.append(other.array("x_mm", "y_mm")[at])
    by_x, by_y = (
        [row["per_unit"] for row in ask(photo.path, INFLUENCE, point="105", axis=axis)] for axis in ("x", "y")
    )
    d = image[0] - image[1]  # mm of the corrected image that the shift of the reading makes
    predicted = np.array(by_x) * d[0] + np.array(by_y) * d[1]
    np.testing.assert_allclose(predicted, stations[0] - stations[1], rtol=2e-3)


INFLUENCE = (
    "SELECT per_unit FROM v_influence WHERE is_current AND point = :point AND axis = :axis "
    "AND element IN ('X_S', 'Y_S', 'Z_S') ORDER BY element"
)


@pytest.mark.parametrize("sample", ["calgary-28", "simulated-space-krasovsky", "apollo15-metric-0585"])
def test_the_shares_of_the_readings_make_their_part_of_the_variance(tmp_path: Path, sample: str) -> None:
    """Against `source_cofactor`, which the stage finds from the covariance of each source as a whole."""
    photo = orient.new(tmp_path / "p.sqlite", SAMPLES / sample)
    photo.run()
    shares = photo.ask(
        "SELECT element, sum(share_percent) AS total, min(share_percent) AS least FROM v_influence "
        "WHERE is_current AND kind = 'image' GROUP BY element ORDER BY element"
    )
    parts = photo.ask(
        "SELECT s.unknown_i AS element, 100 * s.value / sum(a.value) AS share FROM source_cofactor AS s "
        "JOIN source_cofactor AS a USING (run_id, IJ) WHERE s.source = 'image readings' AND s.unknown_i = s.unknown_j "
        "AND s.unknown_i IN ('rotation_1', 'rotation_2', 'rotation_3', 'X_S', 'Y_S', 'Z_S') "
        "GROUP BY s.run_id, s.IJ ORDER BY s.unknown_i"
    )
    assert shares["element"].tolist() == parts["element"].tolist()
    assert np.all(shares["least"] >= 0)
    # x and y of one point correlate a little through the affine transformation of the fiducials
    np.testing.assert_allclose(shares["total"], parts["share"], rtol=1e-3)


def test_the_first_answer_is_the_largest(story: Path) -> None:
    for element in ("X_S", "rotation_2"):
        sizes = [abs(row["moved"]) for row in ask(story, "moved-most", element=element)]
        assert sizes == sorted(sizes, reverse=True)
    assert ask(story, "moved-most") == ask(story, "moved-most", element="X_S")


# ------------------------------------------------------------------------------- 2 - 10


def test_who_excluded(story: Path) -> None:
    rows = ask(story, "who-excluded", point=200)
    assert [(row["version"], row["action"], row["decided_by"]) for row in rows] == [
        (1, "proposed", "snooping"), (2, "excluded", "hand"), (3, "excluded", "hand"),
    ]  # fmt: skip
    assert rows[1]["reason"] == "its corner was hidden by a tree"
    assert (rows[1]["message"], rows[1]["actor"]) == ("200 looks wrong", "anna")
    assert ask(story, "who-excluded", point=105) == []


def test_what_changed_is_what_diff_tells(story: Path) -> None:
    rows = ask(story, "version-change", stage="resection", first=1, second=2)
    changed = {(row["what"], row["name"]): row for row in rows}
    photo = orient.open(story)
    one, two = photo.orientation_of(1), photo.orientation_of(2)
    for i, name in enumerate(("X_S", "Y_S", "Z_S")):
        row = changed["element", f"local_right {name} m"]
        assert (row["before"], row["after"]) == (one.station[i], two.station[i])
        assert row["difference"] == pytest.approx(two.station[i] - one.station[i], rel=1e-12)
        row = changed["sigma", f"local_right {name} m"]
        assert row["after"] == pytest.approx(np.sqrt(two.covariance[3 + i, 3 + i]), rel=1e-12)
    assert changed["setting", "exclude"]["after"] == "200"
    assert changed["excluded", "200"]["before"] is None
    assert not [row for row in rows if row["what"] in ("input", "software", "computation")]
    assert ("input", "topocentric") in {
        (row["what"], row["name"]) for row in ask(story, "version-change", first=2, second=3)
    }
    # without versions: the last result and the one before; version 4 failed
    assert ask(story, "version-change") == ask(story, "version-change", stage="resection", first=2, second=3)


def test_a_changed_list_is_told_number_by_number(story: Path, tmp_path: Path) -> None:
    moved = tmp_path / "control.csv"
    moved.write_text((AERIAL / "control.csv").read_text().replace("102,control,109.70", "102,control,109.75"))
    said = command("add", story, "control", moved, AERIAL / "control.toml", "-m", "102 surveyed again")
    assert said.code == 0, said.err
    assert ask(story, "version-change", stage="control", first=1, second=3) == [
        {"what": "list", "name": "point 102 X_m", "before": 109.7, "after": 109.75, "difference": 109.75 - 109.7}
    ]
    assert any(row["stage"] == "bl" and row["reason"] == "stale" for row in ask(story, "doubtful-current"))


def test_a_single_point_that_carries_an_element_is_named(tmp_path: Path) -> None:
    """Four control points: without the only one off the line of the others an element loses its hold."""
    photo = orient.new(tmp_path / "p.sqlite", AERIAL)
    for stage in ("refine", "bl", "topocentric"):
        photo.run(stage)
    photo.run("resection", exclude="100,102,104,201", exclude_reason="weak on purpose")
    rows = ask(photo.path, "single-point")
    carried = {(row["subject"], row["rests_on"]): row["value"] for row in rows if row["what"] == "element"}
    table = photo.ask(
        "SELECT element, point, sum(share_percent) AS share FROM v_influence WHERE is_current AND point <> '' "
        "GROUP BY element, point"
    )
    expected = {(e, p): s for e, p, s in zip(table["element"], table["point"], table["share"], strict=True) if s > 50}
    assert carried == pytest.approx(expected)
    assert carried


def test_lists_know_their_results(story: Path) -> None:
    rows = {(row["stage"], row["version"]): row for row in ask(story, "after-change")}
    assert rows["control", 2]["results"] == "bl 2, topocentric 2, resection 3, covariance 2"
    assert (rows["control", 2]["current_results"], rows["control", 2]["is_current"]) == ("", 0)
    assert rows["control", 1]["current_results"] == "bl 1, topocentric 1, resection 2, covariance 3"
    assert command("verify", story).code == 0  # evidence is no list
    assert {stage for stage, _ in rows} == {row["stage"] for row in ask(story, "after-change")}


def test_sigmas_given_and_used(space: Path) -> None:
    rows = {row["what"]: row for row in ask(space, "sigmas")}
    photo = orient.open(space)
    one = rows["one reading of an image coordinate"]
    assert one["given"] == one["used"] == photo.table("photo", "photo")["sigma_image_mm"][0]
    unit = rows["unit weight of every stored standard deviation"]
    assert unit["used"] == pytest.approx(photo.orientation.sigma0_mm, rel=1e-12)
    image = photo.table("image_point", "refine")
    control = set(photo.table("image_residual", "resection").where(role="control")["point"])
    sigma = np.sqrt([c for p, c in zip(image["point"], image["cov_xx_mm2"], strict=True) if p in control])
    row = rows["image coordinates of the control"]
    assert (row["n"], row["used"]) == (len(control), pytest.approx(float(np.median(sigma)), rel=1e-12))
    ground = rows["X of control with a standard deviation"]
    assert ground["given"] == ground["used"] > 0
    photo.run("resection", control="fixed", reason="as if the map were without error")
    fixed = {row["what"]: row for row in ask(space, "sigmas")}["X of control with a standard deviation"]
    assert (fixed["given"], fixed["used"]) == (ground["given"], None)
    assert "taken as known" in fixed["how"]


def test_doubts_about_what_is_current(story: Path) -> None:
    doubts = {(row["stage"], row["reason"]): row["told"] for row in ask(story, "doubtful-current")}
    assert "need" in doubts["resection", "failed later"]
    assert "version 3 by anna" in doubts["resection", "newer version"]
    assert ("covariance", "newer version") not in doubts
    assert ("resection", "not verified") in doubts
    assert command("verify", story).code == 0
    after = {(row["stage"], row["reason"]) for row in ask(story, "doubtful-current")}
    assert not any(reason in ("not verified", "differs") for _, reason in after)


def test_who_went_back(story: Path) -> None:
    rows = ask(story, "went-back")
    first = rows[0]
    assert (first["stage"], first["version"], first["instead_of"]) == ("control", 1, 2)
    assert first["reason"] == "105 is needed at the edge"
    assert {row["stage"] for row in rows} == {"control", "bl", "topocentric", "resection"}


def test_warnings_that_stand(aerial: Path, story: Path) -> None:
    assert {"suspect"} <= {row["code"] for row in ask(aerial, "not-acted-on")}
    assert {row["code"] for row in ask(story, "not-acted-on")} == {"no_control"}


def test_check_points_in_sigmas(space: Path) -> None:
    rows = ask(space, "check-points")
    photo = orient.open(space)
    check = photo.table("ground_covariance", "covariance").where(role="check")
    assert [row["point"] for row in rows] == check["point"].tolist() != []
    np.testing.assert_allclose([row["dX_sigmas"] for row in rows], check["dX_m"] / check["sigma_X_m"], rtol=1e-12)


# ------------------------------------------------------------------------------- parameters


SETS = {
    "no value": (("moved-most", "--set", "element"), '--set "element" is not NAME=VALUE'),
    "no name": (("moved-most", "--set", "=X_S"), '--set "=X_S" is not NAME=VALUE'),
    "unknown": (("moved-most", "--set", "point=7"), 'has no parameter "point"'),
    "none at all": (("current", "--set", "point=7"), "It has none."),
    "twice": (("moved-most", "--set", "element=X_S", "--set", "element=Y_S"), "--set element is given twice"),
    "free SQL asks": (("SELECT :a",), "the SQL asks for :a"),
    "free SQL has no place": (("SELECT ':a'", "--set", "a=1"), "the SQL has no place :a"),
}


@pytest.mark.parametrize("case", SETS)
def test_what_is_filled_in_wrongly(aerial: Path, case: str) -> None:
    words, sentence = SETS[case]
    said = command("sql", aerial, *words)
    assert (said.code, said.out) == (2, "")
    assert sentence in said.err


def test_values_are_bound_never_pasted(aerial: Path) -> None:
    hostile = "200' OR 1=1 --"
    assert ask(aerial, "who-excluded", point=hostile) == []
    assert ask(aerial, "SELECT :a AS a, ':b' AS b, typeof(:a) AS t -- :c", a=hostile) == [
        {"a": hostile, "b": ":b", "t": "text"}
    ]
    assert ask(aerial, "SELECT CAST(:a AS REAL) * 2 AS a", a="=1") == [{"a": 0.0}]


def test_the_list_tells_what_can_be_filled_in(aerial: Path) -> None:
    assert "[--set stage=resection --set first=... --set second=...]" in command("sql", aerial, "--list").out
