"""[known] and the sigmas of the lens in photo.toml: what is read, and what each slip is answered."""

import math
from pathlib import Path

import pytest

from orient.errors import OrientError
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_input
from orient.values import Row

PHOTO = """
[photo]
name = "made"
platform = "aerial"
[camera]
f_mm = 150.0
frame_mm = [230, 230]
sigma_image_mm = 0.005
"""
LOCAL = PHOTO + '[ground]\nlocal = "right"\n'
EARTH = PHOTO + '[ground]\nellipsoid = "WGS 84"\n'


def rows_of(text: str, folder: Path, table: str = "known_element") -> dict[str, Row]:
    path = folder / "photo.toml"
    path.write_text(text, "utf-8")
    tables = read_input("photo", [path], ReadOptions(), None).tables
    return {str(row["quantity" if table == "known_element" else "name"]): row for row in tables.get(table, ())}


def test_station_with_sigmas_height_range_and_angle(tmp_path: Path) -> None:
    text = (
        EARTH
        + """
[known.station]
B_deg = "42 30"
L_deg = 22.0
H_m = 3000.0
sigma_m = [0.1, 0.2, 0.3]
[known.angles]
triple = "opk"
kappa_deg = 92.5
sigma_deg = 0.5
"""
    )
    found = rows_of(text, tmp_path)
    assert [(row["unit"], row["value"], row["sigma"]) for row in found.values()] == [
        ("deg", 42.5, 0.1), ("deg", 22.0, 0.2), ("m", 3000.0, 0.3), ("deg", 92.5, 0.5)
    ]  # fmt: skip
    assert list(found) == ["B_S", "L_S", "H_S", "opk_kappa"]
    ranged = rows_of(LOCAL + "[known.height]\nrange_m = [100.0, 160.0]\n", tmp_path)
    assert (ranged["Z_S"]["value"], ranged["Z_S"]["sigma"]) == (130.0, pytest.approx(60.0 / math.sqrt(12)))


def test_a_fixed_station_has_no_sigma(tmp_path: Path) -> None:
    found = rows_of(LOCAL + "[known.station]\nX_m = 1.0\nY_m = 2.0\nZ_m = 3.0\nfixed = true\n", tmp_path)
    assert {name: (row["value"], row["sigma"]) for name, row in found.items()} == {
        "X_S": (1.0, None), "Y_S": (2.0, None), "Z_S": (3.0, None)
    }  # fmt: skip


def test_sigmas_of_coefficients(tmp_path: Path) -> None:
    text = LOCAL + '[camera.distortion]\nmodel = "brown"\ndirection = "correction"\nk1 = 1e-7\nsigma_k1 = 1e-8\n'
    assert rows_of(text, tmp_path, "camera_sigma")["k1"]["sigma"] == 1e-8


STATION = "[known.station]\nX_m = 1.0\nY_m = 2.0\nZ_m = 3.0\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (LOCAL + STATION, ":11: sigma_m is missing in [known.station]"),
        (LOCAL + STATION + "sigma_m = [0.1, 0.0, 0.1]\n", "sigma_m: must be > 0"),
        (LOCAL + "[known.station]\nX_m = 1.0\nfixed = true\n", "Y_m is missing in [known.station]"),
        (EARTH + STATION + "fixed = true\n", "B_deg is missing in [known.station]"),
        (LOCAL + STATION + 'fixed = "yes"\n', "fixed: expected true or false"),
        (LOCAL + "[known.height]\nZ_m = 5.0\n", "height: give Z_m and sigma_m, or range_m"),
        (LOCAL + "[known.height]\nrange_m = [5.0, 4.0]\n", "the second height must be above the first"),
        (LOCAL + STATION + "fixed = true\n[known.height]\nrange_m = [5.0, 9.0]\n", "the height is given twice"),
        (LOCAL + '[known.angles]\ntriple = "opk"\nsigma_deg = 1.0\n', "angles: give one of omega_deg, phi_deg"),
        (LOCAL + "[known.angles]\nkappa_deg = 1.0\nsigma_deg = 1.0\n", "triple is missing in [known.angles]"),
        (LOCAL + '[known.angles]\ntriple = "opk"\nkappa_deg = 1.0\n', "sigma_deg is missing in [known.angles]"),
        (LOCAL + '[known.angles]\ntriple = "opk"\nkappa_deg = 1.0\nsigma_deg = 0\n', "sigma_deg: must be > 0"),
        (LOCAL + '[known.angles]\ntriple = "opk"\nalpha_deg = 1.0\nsigma_deg = 1\n', 'unknown key "alpha_deg"'),
    ],
)  # fmt: skip
def test_slips_are_named(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(OrientError) as refused:
        rows_of(text, tmp_path)
    assert message in str(refused.value)
