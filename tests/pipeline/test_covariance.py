"""Stage `covariance` on the simulated space photo: against the truth, and against differences."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from orient.geometry import plane
from orient.geometry.plane import PARAMETER_NAMES
from orient.geometry.rotation import matrix_from_quaternion, rotation_exp
from orient.pipeline import covariance
from orient.pipeline.frames import frame_of
from orient.pipeline.ground import ground_of
from orient.solvers.ground_covariance import ray_at_height
from orient.solvers.packed import unpack_upper
from orient.store.project import open_project
from orient.values import Row, Tables
from tests.jacobian import central_difference
from tests.pipeline.made import Array, matrix_of, settings

SIGMAS = 3.5
STEPS = np.array([1e-6, 1e-6, 1e-6, 0.1, 0.1, 0.1, 1e-3, 1e-5, 1e-5, 1e-3, 1e-5, 1e-5])
"""Of the six elements, then of a0 a1 a2 b0 b1 b2."""


def by_point(rows: Mapping[str, Tables], stage: str, table: str) -> dict[str, Row]:
    return {str(row["point"]): row for row in rows[stage][table]}


def by_name(rows: Mapping[str, Tables], stage: str, table: str) -> dict[str, float]:
    return {str(row["name"]): float(row["value"]) for row in rows[stage][table]}  # type: ignore[arg-type]


def test_check_points_lie_within_their_errors(space_tables: Mapping[str, Tables]) -> None:
    given = by_point(space_tables, "topocentric", "topocentric_point")
    check = [row for row in space_tables["covariance"]["ground_covariance"] if row["role"] == "check"]
    assert len(check) == 11
    ratios = []
    for row in check:
        of_map = matrix_of(given[str(row["point"])])
        for axis, place in (("X", 0), ("Y", 1)):
            variance = float(row[f"sigma_{axis}_m"]) ** 2 + of_map[place, place]  # type: ignore[arg-type]
            ratios.append(float(row[f"d{axis}_m"]) / np.sqrt(variance))  # type: ignore[arg-type]
    assert np.abs(ratios).max() < SIGMAS
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 1.5


def test_k_is_c_q_c_of_the_ray_by_differences(space_tables: Mapping[str, Tables]) -> None:
    frame = frame_of(space_tables["topocentric"]["topocentric_frame"][0], ground_of(space_tables["photo"]["photo"][0]))
    (found,) = space_tables["resection"]["orientation"]
    packed = [row["value"] for row in space_tables["resection"]["cofactor"] if row["unknowns"] == "ray"]
    Q = float(found["variance_scale"]) * unpack_upper(np.array(packed, dtype=float))  # type: ignore[arg-type]
    fitted, adjusted = (
        np.array([by_name(space_tables, *table)[name] for name in PARAMETER_NAMES["affine"]], dtype=float)
        for table in (("refine", "interior_parameter"), ("resection", "adjusted_interior"))
    )
    rotation = matrix_from_quaternion(np.array([found[name] for name in ("q_w", "q_x", "q_y", "q_z")], dtype=float))
    station = np.array([found[name] for name in ("X_S_m", "Y_S_m", "Z_S_m")], dtype=float)
    image, given = (
        by_point(space_tables, *names) for names in (("refine", "image_point"), ("topocentric", "topocentric_point"))
    )
    for row in space_tables["covariance"]["ground_covariance"]:
        name = str(row["point"])
        xy = np.array([[image[name]["x_mm"], image[name]["y_mm"]]], dtype=float)
        read = np.array([[image[name]["x_comparator_mm"], image[name]["y_comparator_mm"]]], dtype=float)
        up = np.array([[given[name][f"up_{axis}"] for axis in "XYZ"]], dtype=float)
        place = np.array([[row[f"{axis}_m"] for axis in "XYZ"]], dtype=float)
        level = np.array([1.0, 0.0, 0.0]) - up[0, 0] * up[0]
        first = level / np.linalg.norm(level)
        axes = np.array([first, np.cross(up[0], first)])  # (1, 0, 0) and (0, 1, 0) at the origin

        def ray(
            step: Array, xy: Array = xy, read: Array = read, up: Array = up, place: Array = place, axes: Array = axes
        ) -> Array:
            moved = frame.right_handed(station + step[3:6])
            turned = rotation_exp(step[:3]) @ rotation
            level_of = frame.right_handed(place)
            seen = xy + plane.apply("affine", adjusted + step[6:], read) - plane.apply("affine", fitted, read)
            point = ray_at_height(seen, moved, turned, float(found["f_mm"]), level_of, frame.right_handed(up))  # type: ignore[arg-type]
            return np.asarray(axes @ frame.right_handed(point)[0])

        C = central_difference(ray, np.zeros(12), STEPS)
        K = C @ Q @ C.T
        stored = [row[f"K_{part}_m2"] for part in ("XX", "XY", "YY")]
        assert stored == pytest.approx([K[0, 0], K[0, 1], K[1, 1]], rel=1e-4, abs=1e-4 * K.max()), name


def test_pairs_are_symmetric_and_agree_with_the_points(space_tables: Mapping[str, Tables]) -> None:
    turned = dict(space_tables)
    turned["refine"] = {**space_tables["refine"], "image_point": list(reversed(space_tables["refine"]["image_point"]))}
    inputs = {name: turned[name] for name in ("photo", "refine", "topocentric", "resection")}
    other = covariance.compute(inputs, settings("covariance", pairs=True)).tables["ground_covariance_pair"]
    pairs = {
        (row["point_i"], row["point_j"]): [row[f"K_{part}_m2"] for part in ("XX", "XY", "YX", "YY")]
        for row in space_tables["covariance"]["ground_covariance_pair"]
    }
    assert len(pairs) == 36 * 35 // 2
    for row in other:
        there = [row[f"K_{part}_m2"] for part in ("XX", "YX", "XY", "YY")]
        assert there == pytest.approx(pairs[row["point_j"], row["point_i"]], rel=1e-9, abs=1e-9)
    assert_joint_covariance_is_possible(space_tables, pairs)


def test_pairs_in_the_scale_of_the_image(space_file: Path) -> None:
    """The view gives B_i K_ij B_j'."""
    with open_project(space_file) as project:
        _, pairs = project.query(
            """SELECT point_i, point_j, K_XX_m2, K_XY_m2, K_YX_m2, K_YY_m2, K_xx_mm2, K_xy_mm2, K_yx_mm2, K_yy_mm2
               FROM v_ground_pair WHERE is_current"""
        )
        _, scales = project.query(
            "SELECT point, dx_dX_mm_m, dx_dY_mm_m, dy_dX_mm_m, dy_dY_mm_m FROM ground_covariance_image "
            "WHERE run_id = (SELECT run_id FROM v_current WHERE stage = 'covariance')"
        )
    B = {row[0]: np.array(row[1:], dtype=float).reshape(2, 2) for row in scales}
    assert len(pairs) == 36 * 35 // 2
    for row in pairs:
        on_ground, in_image = (np.array(row[k : k + 4], dtype=float).reshape(2, 2) for k in (2, 6))
        np.testing.assert_allclose(B[row[0]] @ on_ground @ B[row[1]].T, in_image, rtol=1e-9, atol=1e-18)


def assert_joint_covariance_is_possible(
    space_tables: Mapping[str, Tables], pairs: Mapping[tuple[object, object], list[object]]
) -> None:
    """The matrix of all points together has no negative eigenvalue, and rank 11.

    Six elements and six parameters of the interior orientation, where a turn of the film does what kappa does.
    """
    rows = space_tables["covariance"]["ground_covariance"]
    place = {row["point"]: 2 * i for i, row in enumerate(rows)}
    whole = np.zeros((2 * len(rows), 2 * len(rows)))
    for row in rows:
        i = place[row["point"]]
        XX, XY, YY = (row[f"K_{part}_m2"] for part in ("XX", "XY", "YY"))
        whole[i : i + 2, i : i + 2] = [[XX, XY], [XY, YY]]
    for (first, second), K in pairs.items():
        i, j = place[first], place[second]  # type: ignore[index]
        block = np.array(K, dtype=float).reshape(2, 2)
        whole[i : i + 2, j : j + 2], whole[j : j + 2, i : i + 2] = block, block.T
    eigenvalues = np.linalg.eigvalsh(whole)
    assert eigenvalues[0] > -1e-9 * eigenvalues[-1]
    assert np.sum(eigenvalues > 1e-9 * eigenvalues[-1]) == 11


def test_the_ellipse_holds_the_sigmas(space_tables: Mapping[str, Tables]) -> None:
    for row in space_tables["covariance"]["ground_covariance"]:
        a, b, azimuth = (float(row[f"ellipse_{name}"]) for name in ("a_m", "b_m", "azimuth_deg"))  # type: ignore[arg-type]
        c, s = np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth))
        assert np.hypot(a * c, b * s) == pytest.approx(row["sigma_X_m"], rel=1e-9)
        assert np.hypot(a * s, b * c) == pytest.approx(row["sigma_Y_m"], rel=1e-9)
        parts = sum(float(row[f"{part}_XX_m2"]) for part in ("K", "reading", "height"))  # type: ignore[arg-type]
        assert parts == pytest.approx(float(row["sigma_X_m"]) ** 2, rel=1e-9)  # type: ignore[arg-type]


def test_without_pairs_there_is_no_table_of_pairs(space_tables: Mapping[str, Tables]) -> None:
    inputs = {name: space_tables[name] for name in ("photo", "refine", "topocentric", "resection")}
    outcome = covariance.compute(inputs, settings("covariance"))
    assert set(space_tables["covariance"]) - set(outcome.tables) == {"ground_covariance_pair"}
    assert outcome.tables["ground_covariance"] == space_tables["covariance"]["ground_covariance"]
