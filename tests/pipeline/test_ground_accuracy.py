"""The map over the frame and the scale of the image, against the points and against the geometry."""

from collections.abc import Mapping

import numpy as np
import pytest

from orient.geometry.rotation import matrix_from_aok
from orient.pipeline import covariance
from orient.pipeline.camera import measured_of
from orient.pipeline.frames import SWAP, Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.ground_accuracy import frame_places, map_rows
from orient.pipeline.ground_budget import RayUnknowns, SeenImage
from orient.pipeline.oriented import Oriented, oriented_by
from orient.values import Row, Tables
from tests.pipeline.made import Array, local, photo, settings

INPUTS = ("photo", "refine", "topocentric", "resection")


def values(rows: list[Row], *names: str) -> Array:
    return np.array([[row[name] for name in names] for row in rows], dtype=np.float64)


def frame(tables: Mapping[str, Tables]) -> Frame:
    return frame_of(tables["topocentric"]["topocentric_frame"][0], ground_of(tables["photo"]["photo"][0]))


def on_photo(oriented: Oriented, measured: Row) -> tuple[Array, SeenImage]:
    """The point's image coordinates by the adjusted interior orientation, and what they depend on."""
    comparator = values([measured], "x_comparator_mm", "y_comparator_mm")
    seen = oriented.rays.seen(values([measured], "x_mm", "y_mm"), comparator, measured_of([measured]))
    return seen.image, seen


def test_the_map_at_a_point_is_the_covariance_of_the_point(space_tables: Mapping[str, Tables]) -> None:
    """A place of the map put on a measured point, at its height and with its reading: the point's own row."""
    earth = frame(space_tables)
    oriented = oriented_by(space_tables["photo"], space_tables["refine"], space_tables["resection"], earth)
    points = {row["point"]: row for row in space_tables["covariance"]["ground_covariance"]}
    images = {row["point"]: row for row in space_tables["covariance"]["ground_covariance_image"]}
    for measured in space_tables["refine"]["image_point"][:5]:
        row = points[measured["point"]]
        height = float(earth.geographic(values([row], "X_m", "Y_m", "Z_m"))[0, 2])
        xx, xy, yy = values([measured], "cov_xx_mm2", "cov_xy_mm2", "cov_yy_mm2")[0]
        reading = oriented.scale * np.array([[xx, xy], [xy, yy]])
        (found,) = map_rows(*on_photo(oriented, measured), oriented, earth, height, reading, 0.0)
        for name in ("X_m", "Y_m", "Z_m", "K_XX_m2", "K_XY_m2", "K_YY_m2", "reading_XX_m2"):
            assert found[name] == pytest.approx(row[name], rel=1e-6, abs=1e-2), name
        for name in ("K_xx_mm2", "K_xy_mm2", "K_yy_mm2"):
            assert found[name] == pytest.approx(images[measured["point"]][name], rel=1e-5), name


def test_the_map_spans_the_frame_at_one_height(space_tables: Mapping[str, Tables]) -> None:
    rows = space_tables["covariance"]["ground_accuracy"]
    facts = space_tables["photo"]["photo"][0]
    assert len(rows) == 11 * 11
    x0, y0 = float(facts["x0_mm"] or 0), float(facts["y0_mm"] or 0)
    width, height = (float(facts[name] or 0) for name in ("frame_width_mm", "frame_height_mm"))
    first, last = rows[0], rows[-1]
    assert (first["line"], first["place"], last["line"], last["place"]) == (1, 1, 11, 11)
    assert (first["x_mm"], first["y_mm"]) == pytest.approx((-width / 2 - x0, height / 2 - y0))
    assert (last["x_mm"], last["y_mm"]) == pytest.approx((width / 2 - x0, -height / 2 - y0))
    heights = frame(space_tables).geographic(values(list(rows), "X_m", "Y_m", "Z_m"))[:, 2]
    points = values(list(space_tables["covariance"]["ground_covariance"]), "X_m", "Y_m", "Z_m")
    np.testing.assert_allclose(heights, frame(space_tables).geographic(points)[:, 2].mean(), atol=1e-3)


def test_the_scale_of_the_image_is_that_of_the_projection(space_tables: Mapping[str, Tables]) -> None:
    """sigma in the image is sigma on the ground by B; a reading alone gives its own covariance back."""
    plans = {row["point"]: row for row in space_tables["covariance"]["ground_covariance"]}
    scale = oriented_by(
        space_tables["photo"], space_tables["refine"], space_tables["resection"], frame(space_tables)
    ).scale
    measured = {row["point"]: row for row in space_tables["refine"]["image_point"]}
    for row in space_tables["covariance"]["ground_covariance_image"]:
        B = values([row], "dx_dX_mm_m", "dx_dY_mm_m", "dy_dX_mm_m", "dy_dY_mm_m").reshape(2, 2)
        parts = []
        for part in ("K", "reading", "height"):
            XX, XY, YY = values([plans[row["point"]]], *(f"{part}_{axes}_m2" for axes in ("XX", "XY", "YY")))[0]
            parts.append(B @ np.array([[XX, XY], [XY, YY]]) @ B.T)
        K, reading, height = parts
        assert K[0, 1] == pytest.approx(row["K_xy_mm2"], rel=1e-9, abs=1e-15)
        assert reading[0, 0] == pytest.approx(scale * float(measured[row["point"]]["cov_xx_mm2"]), rel=1e-9)  # type: ignore[arg-type]
        assert (K + reading + height)[1, 1] == pytest.approx(float(row["sigma_y_mm"]) ** 2, rel=1e-9)  # type: ignore[arg-type]


def test_settings_of_the_map(space_tables: Mapping[str, Tables]) -> None:
    inputs = {name: space_tables[name] for name in INPUTS}
    plain = covariance.compute(inputs, settings("covariance", map_side=3)).tables["ground_accuracy"]
    rough = covariance.compute(inputs, settings("covariance", map_side=3, map_height_sigma_m=100.0)).tables
    assert len(plain) == 9
    corner = rough["ground_accuracy"][0]
    added = values([corner], "sigma_X_m", "sigma_Y_m") ** 2 - values([plain[0]], "sigma_X_m", "sigma_Y_m") ** 2
    np.testing.assert_allclose(added, values([corner], "height_XX_m2", "height_YY_m2"), rtol=1e-6)
    # the ray leans by the angle of the corner: 90 mm and f = 152 mm make tan = 0.6 in each axis, 0.8 together
    assert float(np.sum(added)) == pytest.approx(100.0**2 * 0.7, rel=0.5)


def test_the_sky_has_no_accuracy() -> None:
    """A level camera over local ground: the upper half of the frame sees nothing, the middle row only the horizon."""
    rotation = matrix_from_aok(0.0, np.pi / 2, 0.0)
    level = Oriented(
        np.array([0.0, 0.0, 100.0]),
        rotation,
        150.0,
        np.eye(6) * 1e-8,
        1.0,
        1.0,
        RayUnknowns(np.eye(6) * 1e-8, {}, None, ()),
    )
    places = frame_places(photo(frame_width_mm=200.0, frame_height_mm=200.0)["photo"][0], 3)
    rows = map_rows(
        places,
        level.rays.at_places(places, places, np.zeros(2)),
        level,
        Frame("local_left", SWAP),
        0.0,
        np.eye(2) * 1e-4,
        0.0,
    )
    seen = [row["line"] for row in rows if row["sigma_X_m"] is not None]
    assert seen == [3, 3, 3]
    assert all(row["X_m"] is None and row["sigma_x_mm"] is None for row in rows if row["line"] != 3)


def test_the_frame_lies_about_the_principal_point() -> None:
    facts = local("right", x0_mm=1.5, y0_mm=-2.0, frame_width_mm=100.0, frame_height_mm=60.0)["photo"][0]
    np.testing.assert_allclose(frame_places(facts, 2), [[-51.5, 32], [48.5, 32], [-51.5, -28], [48.5, -28]])
