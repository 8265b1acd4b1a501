"""Resections of arrays, without a project."""

import re
from typing import Any

import numpy as np
import pytest

import orient
from tests.solvers.resection_scenes import generator, scene

S = scene(generator("test_resections"), n=12)
IMAGE = S.noisy(0.005, generator("test_resections noise"))
TURN = np.array([[1.0, -0.03, 0.0], [0.03, 1.0, 0.0], [0.0, 0.0, 1.0]])


def test_one_photo_and_the_same_among_many() -> None:
    one = orient.resection(IMAGE, S.ground, S.f_mm, S.rotation, S.station + 1.0)
    many = orient.resections([IMAGE] * 3, [S.ground] * 3, S.f_mm, [S.rotation] * 3, [S.station + 1.0] * 3)
    assert one.converged
    assert many.converged.all()
    sigma_m = np.sqrt(one.vPv / 18 * np.diag(one.Q)[3:])
    assert np.all(np.abs(many.station - one.station) < 1e-8 * sigma_m)
    assert np.all(np.abs(one.station - S.station) < 6 * sigma_m)


def test_a_rounded_rotation_is_made_one() -> None:
    exact = orient.resection(IMAGE, S.ground, S.f_mm, S.rotation, S.station + 1.0)
    rounded = np.round(S.rotation, 2)
    one = orient.resection(IMAGE, S.ground, S.f_mm, rounded, S.station + 1.0)
    many = orient.resections([IMAGE] * 2, [S.ground] * 2, S.f_mm, [rounded] * 2, [S.station + 1.0] * 2)
    for R in (one.rotation, *many.rotation):
        assert np.abs(R - exact.rotation).max() < 1e-10
        assert np.abs(R @ R.T - np.eye(3)).max() < 1e-14


def test_photos_whose_points_are_all_in_one_place_do_not_stop_the_others() -> None:
    image, ground = np.stack([IMAGE] * 4), np.stack([S.ground] * 4)
    ground[1] = ground[1, 0]
    image[2] = image[2, 0]
    assert orient.resections(image, ground, S.f_mm).converged.tolist() == [True, False, False, True]


def test_no_photos_have_no_orientations() -> None:
    none = orient.resections(np.empty((0, 5, 2)), np.empty((0, 5, 3)), 150.0, np.empty((0, 3, 3)), np.empty((0, 3)))
    assert len(none.station) == 0


IMPOSSIBLE = np.tile(np.eye(3), (12, 1, 1))
IMPOSSIBLE[7] = [[1.0, 0.9, -0.9], [0.9, 1.0, 0.9], [-0.9, 0.9, 1.0]]

BAD: dict[str, tuple[dict[str, Any], str]] = {
    "shapes": ({"image": IMAGE[:5]}, "image has the shape"),
    "too few": ({"image": IMAGE[:2], "ground": S.ground[:2]}, "2 points do not determine"),
    "not finite": ({"image": IMAGE * np.nan}, "not finite"),
    "rotation": ({"rotation": TURN[:2]}, "rotation has the shape"),
    "a mirror": ({"rotation": np.diag([1.0, 1.0, -1.0])}, "no rotation matrix"),
    "not orthogonal": ({"rotation": 1.2 * np.eye(3)}, "no rotation matrix"),
    "focal length": ({"f_mm": -1.0}, "f_mm is not positive\nGive one focal length \\[mm\\]\\.$"),
    "focal lengths": ({"f_mm": [152.0, 152.0]}, "f_mm has the shape \\(2,\\)\nGive one focal length \\[mm\\]\\.$"),
    "a masked station": ({"station": np.ma.masked_less([1.0, 2.0, 3.0], 2.0)}, "station has masked elements"),
    "a huge station": ({"station": [10**400, 0, 0]}, "station has numbers that are not finite or beyond 1e\\+60$"),
    "too large": ({"ground": S.ground * 1e60}, "beyond 1e\\+60"),
    "a triangle of cofactors": (
        {"ground_cofactor": np.tri(3) + np.zeros((12, 1, 1))},
        "ground_cofactor\\[0\\] is no covariance",
    ),
    "negative cofactors": (
        {"ground_cofactor": -np.eye(3) + np.zeros((12, 1, 1))},
        "ground_cofactor\\[0\\] is no covariance",
    ),
    "one impossible cofactor": ({"ground_cofactor": IMPOSSIBLE}, "ground_cofactor\\[7\\] is no covariance"),
    "cofactors": ({"ground_cofactor": np.eye(3)}, "ground_cofactor has the shape"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_arrays_get_one_sentence(name: str) -> None:
    changed, said = BAD[name]
    given = {"image": IMAGE, "ground": S.ground, "f_mm": S.f_mm, "rotation": S.rotation, "station": S.station}
    with pytest.raises(orient.UsageError) as error:
        orient.resection(**{**given, **changed})
    assert re.search(said, f"{error.value.message}\n{error.value.hint}".strip())


def test_the_focal_lengths_of_many_photos_are_one_or_as_many() -> None:
    with pytest.raises(orient.UsageError) as error:
        orient.resections([IMAGE] * 3, [S.ground] * 3, [152.0, 152.0])
    assert error.value.hint == "Give one focal length [mm], or one for each of 3 photos."


@pytest.mark.parametrize("given", [{"rotation": [S.rotation]}, {"station": [S.station]}], ids=["rotation", "station"])
def test_half_a_start_is_refused(given: dict[str, Any]) -> None:
    with pytest.raises(orient.UsageError, match="only of use together"):
        orient.resections([IMAGE], [S.ground], S.f_mm, **given)
