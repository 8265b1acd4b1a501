"""Map sheets: crosses.csv, digitizer.csv, sheet.toml."""

from pathlib import Path

import pytest

from orient.errors import InputError
from orient.intake.project_folder import ReadOptions, read_input
from orient.values import InputTables
from tests.intake.conftest import Write

CROSSES = (
    "sheet,X_mm,Y_mm,B_deg,L_deg\n"
    "N-37,10,10,55 50,36\nN-37,200,11,55 50,36.25\nN-37,9,210,56,36\nN-37,199,211,56,36 15 0\n"
)
DIGITIZER = "sheet,point,cycle,X_mm,Y_mm,H_m,sigma_H_m\nN-37,P1,1,50,60,180,2\nN-37,P1,2,50.1,60,,\n"
GRID = "sheet,cross,role,X_mm,Y_mm,E_m,N_m\nA,a,fit,1,2,{},6190000\nA,b,check,3,4,{},6191000\n"


def read(write: Write, **files: str) -> InputTables:
    paths: list[Path] = [write(name.replace("_", "."), text) for name, text in files.items()]
    return read_input("sheet", paths, ReadOptions())


def test_crosses_and_readings_are_told_apart_by_their_columns(write: Write) -> None:
    tables = read(write, a_csv=DIGITIZER, b_csv=CROSSES).tables
    crosses = tables["graticule_cross"]
    assert [(row["seq"], row["cross"], row["role"], row["B_deg"], row["L_deg"]) for row in crosses] == [
        (1, "1", "fit", 55 + 50 / 60, 36.0),
        (2, "2", "fit", 55 + 50 / 60, 36.25),
        (3, "3", "fit", 56.0, 36.0),
        (4, "4", "fit", 56.0, 36.25),
    ]
    readings = tables["digitizer_reading"]
    assert [(row["point"], row["cycle"], row["X_mm"], row["H_m"], row["sigma_H_m"]) for row in readings] == [
        ("P1", 1, 50.0, 180.0, 2.0),
        ("P1", 2, 50.1, None, None),
    ]
    assert tables["map_sheet"] == [
        {"sheet": "N-37", "title": "N-37", "crs": None, "degree": None, "sigma_mm": None, "pixel_size_mm": None}
    ]


def test_a_scan_is_read_in_pixels(write: Write) -> None:
    toml = '[sheet.A]\ntitle = "a scan"\ncrs = "EPSG:28407"\ndegree = 2\npixel_size_mm = 0.1\nsigma_mm = 0.05\n'
    csv = GRID.replace("X_mm,Y_mm", "col_px,row_px").format(7312000, 7313000)
    tables = read(write, crosses_csv=csv, sheet_toml=toml).tables
    assert [(row["X_mm"], row["Y_mm"], row["role"]) for row in tables["graticule_cross"]] == [
        (pytest.approx(0.1), pytest.approx(-0.2), "fit"),
        (pytest.approx(0.3), pytest.approx(-0.4), "check"),
    ]
    sheet = tables["map_sheet"][0]
    assert (sheet["title"], sheet["crs"], sheet["degree"], sheet["sigma_mm"]) == ("a scan", "EPSG:28407", 2, 0.05)


BAD: dict[str, tuple[dict[str, str], str]] = {
    "no-size": (
        {"crosses_csv": CROSSES.replace("X_mm,Y_mm", "col_px,row_px")},
        'crosses.csv:2: sheet "N-37" is read in pixels, but the size of a pixel is not known. '
        "Give pixel_size_mm in [sheet.N-37] of sheet.toml",
    ),
    "no-crosses": (
        {"crosses_csv": CROSSES, "digitizer_csv": DIGITIZER.replace("N-37", "N-38")},
        'digitizer.csv:2: sheet "N-38" has no crosses',
    ),
    "unused": (
        {"crosses_csv": CROSSES, "sheet_toml": "[sheet.M-37]\n"},
        'sheet.toml:1: sheet "M-37" has no crosses. Check the name',
    ),
    "A3": (
        {"crosses_csv": "sheet,X_mm,Y_mm\nA,1,2\n"},
        "crosses.csv:1: give B_deg, L_deg or E_m, N_m: one of them; found X_mm, Y_mm, sheet",
    ),
    "A18": (
        {"crosses_csv": "sheet,cross,X_mm,Y_mm,B_deg,L_deg\nA,1,1,2,3,4\nA,1,2,2,4,4\n"},
        'crosses.csv:3: cross "1" of sheet "A" was already given in line 2',
    ),
    "A18-two-files": (
        {"digitizer_csv": DIGITIZER, "more_csv": DIGITIZER.replace("P1,2", "P1,3"), "crosses_csv": CROSSES},
        'more.csv:2: point "P1", cycle 1, of sheet "N-37" was already given in digitizer.csv:2',
    ),
    "A35": (
        {"crosses_csv": "sheet,X_mm,Y_mm,B_deg,L_deg\nA,1,1,2,3\nA,1,1,2,4\n"},
        'crosses.csv: sheet "A": all points coincide',
    ),
    "C8": (
        {
            "crosses_csv": GRID.replace("619", "5").format(36, 37).replace("50000", "55").replace("51000", "56"),
            "sheet_toml": '[sheet.A]\ncrs = "EPSG:28407"\n',
        },
        'crosses.csv: sheet "A": values look like degrees, crs EPSG:28407 is in metres',
    ),
    "grid-needs-crs": (
        {"crosses_csv": GRID.format(7312000, 7313000)},
        'crosses.csv:2: sheet "A": E_m, N_m need a crs. Give crs in [sheet.A] of sheet.toml',
    ),
    "graticule-in-metres": (
        {"crosses_csv": CROSSES, "sheet_toml": '[sheet."N-37"]\ncrs = "EPSG:28407"\n'},
        'crosses.csv:2: sheet "N-37": B_deg, L_deg, but crs EPSG:28407 is in metres. '
        "Give the geographic system of its graticule",
    ),
    "degree": (
        {"crosses_csv": CROSSES, "sheet_toml": '[sheet."N-37"]\ndegree = 6\n'},
        "sheet.toml:2: degree: 6 is not in 1 … 5",
    ),
    "two-heights": (
        {"crosses_csv": CROSSES, "digitizer_csv": DIGITIZER.replace("60,,", "60,190,")},
        'digitizer.csv:3: point "P1" has two heights: 190 m here, 180 m in line 2',
    ),
    "sigma-without-height": (
        {"crosses_csv": CROSSES, "digitizer_csv": DIGITIZER.replace("180,2", ",2")},
        "digitizer.csv:2: sigma_H_m is given, but H_m is missing",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_sheet_is_named(write: Write, case: str) -> None:
    files, message = BAD[case]
    with pytest.raises(InputError) as caught:
        read(write, **files)
    assert str(caught.value) == message
