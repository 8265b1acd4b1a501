"""An aerial photo of a curved datum, with control as map coordinates and heights: [curvature] of photo.toml."""

import math
from pathlib import Path

import numpy as np
import pytest

from orient.errors import InputError
from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_opk
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create, run_stale
from orient.store.project import open_project
from orient.values import Row, Tables

R = 6_371_000.0
F_MM, HEIGHT_M, GROUND_M = 88.0, 9000.0, 500.0
PHOTO = f"""
[photo]
name = "made"
platform = "aerial"
[camera]
f_mm = {F_MM}
frame_mm = [260, 260]
sigma_image_mm = 0.006
[ground]
local = "right"
height_m = {GROUND_M}
[refraction]
camera_height_m = {HEIGHT_M}
"""


def scene() -> tuple[list[str], list[str]]:
    """Lines of readings.csv and control.csv: Cartesian truth on a sphere, control as arcs on its map."""
    chance = np.random.default_rng(5)
    azimuth = 2.4 * np.arange(16)
    arc = 10_500.0 * np.sqrt((np.arange(16) + 0.5) / 16)
    h = GROUND_M + chance.uniform(-20.0, 20.0, 16)
    angle = arc / (R + GROUND_M)
    across = (R + h) * np.sin(angle)
    sphere = np.column_stack([across * np.cos(azimuth), across * np.sin(azimuth), (R + h) * np.cos(angle) - R])
    plane = np.column_stack([arc * np.cos(azimuth), arc * np.sin(azimuth), h])
    image, _ = project(sphere, np.array([0.0, 0.0, HEIGHT_M]), matrix_from_opk(0.004, -0.006, 0.7).T, F_MM)
    readings = ["point,x_mm,y_mm", *(f"P{i},{x:.7f},{y:.7f}" for i, (x, y) in enumerate(image))]
    control = ["point,X_m,Y_m,Z_m", *(f"P{i},{x:.5f},{y:.5f},{z:.5f}" for i, (x, y, z) in enumerate(plane))]
    return readings, control


def write_folder(folder: Path, photo: str) -> Path:
    readings, control = scene()
    (folder / "photo.toml").write_text(photo, "utf-8")
    (folder / "readings.csv").write_text("\n".join(readings), "utf-8")
    (folder / "control.csv").write_text("\n".join(control), "utf-8")
    return folder


def computed(folder: Path, photo: str) -> tuple[dict[str, Tables], list[str]]:
    """All tables of all stages, and the codes of the events of refine."""
    path = folder / "photo.sqlite"
    create(path, read_project(write_folder(folder, photo), ReadOptions()), "test")
    results = run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    assert [result.run.error for result in results if result.failed and result.run] == []
    with open_project(path) as opened:
        heads = opened.heads()
        codes = [event.code for event in opened.events(heads["refine"].run_id)]
        return {stage: opened.read_tables(run.run_id) for stage, run in heads.items()}, codes


def number(row: Row, name: str) -> float:
    value = row[name]
    assert isinstance(value, float)
    return value


def sigma0_um(tables: dict[str, Tables]) -> float:
    residuals = tables["resection"]["image_residual"]
    vv = sum(number(row, "vx_mm") ** 2 + number(row, "vy_mm") ** 2 for row in residuals)
    return 1000.0 * math.sqrt(vv / (2 * len(residuals) - 6))


def test_sigma0_before_and_after(tmp_path: Path) -> None:
    """sigma0 14.2 -> 0.24 um, Z_S 5.73 m too high -> 3 mm; left are the second order, the tilt and the plumb lines."""
    (tmp_path / "before").mkdir()
    (tmp_path / "after").mkdir()
    before, no_codes = computed(tmp_path / "before", PHOTO)
    after, codes = computed(tmp_path / "after", PHOTO + "[curvature]\n")
    assert (no_codes, codes) == ([], ["curvature"])
    assert sigma0_um(before) == pytest.approx(14.2, abs=0.1)
    assert sigma0_um(after) < 0.3
    heights = [number(tables["resection"]["orientation"][0], "Z_S_m") for tables in (before, after)]
    assert heights == pytest.approx([HEIGHT_M + 5.73, HEIGHT_M], abs=0.01)


def test_the_correction_has_its_columns_and_is_in_the_sum(tmp_path: Path) -> None:
    tables, _ = computed(tmp_path, PHOTO + "[curvature]\nradius_m = 6380000\n")
    assert tables["photo"]["photo"][0]["curvature_radius_m"] == 6_380_000.0
    for row in tables["refine"]["image_point"]:
        for axis in "xy":
            frame, after = number(row, f"{axis}_frame_mm"), number(row, f"{axis}_mm")
            part = number(row, f"d{axis}_curvature_mm")
            r2 = number(row, "x_frame_mm") ** 2 + number(row, "y_frame_mm") ** 2
            assert part == pytest.approx(frame * (HEIGHT_M - GROUND_M) * r2 / (2 * 6.38e6 * F_MM**2), rel=1e-12)
            assert after == pytest.approx(frame + part, rel=1e-15)
    with open_project(tmp_path / "photo.sqlite") as project:
        columns, rows = project.query("SELECT dx_mm, x_mm - x_frame_mm, curvature_mm, dy_mm FROM v_correction")
    assert len(columns) == 4
    for dx, difference, length, dy in rows:
        assert dx == pytest.approx(difference, abs=1e-12)
        assert length == pytest.approx(math.hypot(dx, dy), rel=1e-9)


def test_without_the_table_nothing_is_corrected(tmp_path: Path) -> None:
    tables, _ = computed(tmp_path, PHOTO)
    assert tables["photo"]["photo"][0]["curvature_radius_m"] is None
    assert {row["dx_curvature_mm"] for row in tables["refine"]["image_point"]} == {0.0}


GEOGRAPHIC = PHOTO.replace('local = "right"', 'ellipsoid = "krasovsky"')


@pytest.mark.parametrize(
    ("photo", "message"),
    [
        (GEOGRAPHIC + "[curvature]\n", "topocentric coordinates already contain the curvature of the Earth"),
        (PHOTO.replace('local = "right"', 'crs = "EPSG:4326"') + "[curvature]\n", "already contain the curvature"),
        (PHOTO.replace("camera_height_m = 9000.0", "") + "[curvature]\n", "needs the heights of the camera and of"),
        (
            PHOTO.replace("camera_height_m = 9000.0", "camera_height_m = 400") + "[curvature]\n",
            "is not above the ground",
        ),
        (PHOTO + "[curvature]\nradius = 6371000\n", 'unknown key "radius". Did you mean "radius_m"'),
        (PHOTO + "[curvature]\nradius_m = 6371\nx = 1\n", 'unknown key "x"'),
        (PHOTO + "[curvature]\nradius_m = -5\n", "radius_m: -5 m is not in 1,000"),
        (
            PHOTO.replace("[refraction]", '[refraction]\nmodel = "schut"'),
            "schut is not offered; it holds to 10 km only",
        ),
        (
            PHOTO.replace("[refraction]", '[refraction]\nmodel = "schut"').replace("= 9000.0", "= 250000"),
            "schut is a formula for aerial photos; it is negative above 25 km and absurd from space",
        ),
        (
            PHOTO.replace("[refraction]", '[refraction]\nmodel = "space"'),
            "model: space holds for cameras above 80,000 m, not at 9,000 m",
        ),
    ],
)
def test_what_is_refused_says_why(tmp_path: Path, photo: str, message: str) -> None:
    with pytest.raises(InputError) as refused:
        read_project(write_folder(tmp_path, photo), ReadOptions())
    assert message in f"{refused.value.message}\n{refused.value.hint}"


def test_refraction_for_space_is_accepted_above_the_air(tmp_path: Path) -> None:
    photo = GEOGRAPHIC.replace("[refraction]", '[refraction]\nmodel = "space"').replace("= 9000.0", "= 250000")
    (tmp_path / "control.csv").write_text("", "utf-8")
    write_folder(tmp_path, photo)
    (tmp_path / "control.csv").unlink()
    path = tmp_path / "photo.sqlite"
    create(path, read_project(tmp_path, ReadOptions()), "test")
    run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    with open_project(path) as opened:
        rows = opened.read_tables(opened.heads()["refine"].run_id)["image_point"]
    for row in rows:
        x, y = number(row, "x_frame_mm"), number(row, "y_frame_mm")
        K = -number(row, "dx_refraction_mm") / (x * (1 + (x * x + y * y) / F_MM**2))
        # p(500 m)/p(0) = 0.9421
        assert pytest.approx(2.35 * 0.9421 / 249_500.0, rel=1e-4) == K


def test_a_terrestrial_photo_has_no_such_formula(tmp_path: Path) -> None:
    path = tmp_path / "photo.sqlite"
    photo = PHOTO.replace("aerial", "terrestrial") + "[curvature]\n"
    create(path, read_project(write_folder(tmp_path, photo), ReadOptions()), "test")
    results = run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    errors = [result.run.error for result in results if result.failed and result.run]
    assert errors == ["the formulas of earth curvature hold for a view from above, not for a terrestrial photo"]
