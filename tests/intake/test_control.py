"""control.csv and control.toml: kinds, partial coordinates, covariances, and C1 ... C20 as far as a list shows them."""

from pathlib import Path

import pytest

from orient.errors import InputError
from orient.intake.project_folder import ReadOptions, read_input, read_project
from orient.values import InputTables, Row
from tests.intake.conftest import CONTROL, Write

UTM = '[control]\ncrs = "EPSG:25832"\n'
LOCAL = '[control]\nlocal = "right"\n'
GEOCENTRIC = '[control]\nkind = "geocentric"\n'
XYZ = "point,X_m,Y_m,Z_m\nA,1,2,3\nB,4,5,6\n"
COVARIANCE = "cov_XX_m2,cov_XY_m2,cov_XZ_m2,cov_YY_m2,cov_YZ_m2,cov_ZZ_m2"
COV = ("cov_XX_m2", "cov_XY_m2", "cov_XZ_m2", "cov_YY_m2", "cov_YZ_m2", "cov_ZZ_m2")


def read(write: Write, csv: str, toml: str = "", photo: dict[str, object] | None = None) -> InputTables:
    files: list[Path] = [write("control.csv", csv)]
    if toml:
        files.append(write("control.toml", toml))
    return read_input("control", files, ReadOptions(), photo)


def points(write: Write, csv: str, toml: str = "", photo: dict[str, object] | None = None) -> list[Row]:
    return list(read(write, csv, toml, photo).tables["control_point"])


BAD = {
    "C8": (
        "point,E_m,N_m,H_m\nA,12.5,48.1,100\nB,12.6,48.2,100\n",
        UTM,
        "control.csv: values look like degrees, crs EPSG:25832 is in metres",
    ),
    "C9": (
        CONTROL,
        '[control]\ncrs = "EPSG:999999"\n',
        'control.toml:2: crs: unknown coordinate system "EPSG:999999". Write an authority code such as "EPSG:4284"',
    ),
    "C9-feet": (
        "point,E_m,N_m\nA,1000,2000\n",
        '[control]\ncrs = "EPSG:2263"\n',
        None,
    ),
    "C10-half": (
        "point,B_deg,L_deg,H_m\nA,1,,3\n",
        "",
        "control.csv:2: half a plan position: give both plan coordinates, or none",
    ),
    "C10-geocentric": (
        "point,X_m,Y_m,Z_m\nA,1,2,\n",
        GEOCENTRIC,
        "control.csv:2: a geocentric point needs X_m, Y_m and Z_m",
    ),
    "C11": (
        "point,E_m,N_m\nA,1e12,2\n",
        UTM,
        'control.csv:2: column "E_m": 1,000,000,000,000 is not in -100,000,000 … 100,000,000',
    ),
    "C12-deep": (
        "point,B_deg,L_deg,H_m\nA,1,2,-20000\n",
        "",
        'control.csv:2: column "H_m": -20,000 is not in -12,000 … 1,000,000',
    ),
    "C12-high": (
        "point,B_deg,L_deg,H_m\nA,1,2,2e6\n",
        "",
        'control.csv:2: column "H_m": 2,000,000 is not in -12,000 … 1,000,000',
    ),
    "C13": (
        "point,role,B_deg,L_deg\nA,tie,1,2\n",
        "",
        'control.csv:2: column "role": "tie" is not one of control, check',
    ),
    "C15": (
        "point,B_deg,L_deg,H_m,sigma_N_m,sigma_E_m,sigma_H_m\nA,1,2,3,1,1,0\n",
        "",
        'control.csv:2: column "sigma_H_m": must be > 0. Leave the sigmas empty for a point that is taken as known',
    ),
    "C15-some": (
        "point,B_deg,L_deg,H_m,sigma_N_m,sigma_E_m,sigma_H_m\nA,1,2,3,1,,1\n",
        "",
        'control.csv:2: column "sigma_E_m": value is missing. '
        "Leave all of them empty for a point that is taken as known",
    ),
    "C15-too-many": (
        "point,B_deg,L_deg,H_m,sigma_N_m,sigma_E_m,sigma_H_m\nA,1,2,,1,1,1\n",
        "",
        'control.csv:2: column "sigma_H_m": given for a coordinate that is missing',
    ),
    "C16": (
        "point,B_deg,L_deg\n12,1,2\n12,3,4\n",
        "",
        'control.csv:3: point "12" was already given in line 2',
    ),
    "C20": (
        f"point,X_m,Y_m,Z_m,{COVARIANCE}\nA,1,2,3,1,1.0003,0,1,0,1\n",
        LOCAL,
        "control.csv:2: covariance matrix is not valid (eigenvalue -0.0003)",
    ),
    "C20-both": (
        f"point,X_m,Y_m,Z_m,sigma_X_m,{COVARIANCE}\nA,1,2,3,1,1,0,0,1,0,1\n",
        LOCAL,
        "control.csv:2: give standard deviations or covariances of a point, not both",
    ),
    "A35": ("point,B_deg,L_deg,H_m\nA,1,2,3\nB,1,2,3\n", "", "control.csv: all points coincide"),
    "say-which": (
        XYZ,
        "",
        "control.csv:1: say whether X_m, Y_m, Z_m are geocentric or local: control.toml. "
        'Write crs = "EPSG:...", kind = "geocentric" or local = "right"',
    ),
    "projected-needs-crs": (
        "point,E_m,N_m\nA,1000,2000\n",
        "",
        'control.csv:1: E_m, N_m need a crs. Write [control] crs = "EPSG:..." in control.toml',
    ),
    "wrong-columns": (CONTROL, UTM, "control.csv:1: B_deg, L_deg, but crs EPSG:25832 is in metres E, N"),
    "wrong-crs": (
        "point,E_m,N_m\nA,1000,2000\n",
        '[control]\ncrs = "EPSG:4284"\n',
        "control.csv:1: E_m, N_m, but crs EPSG:4284 is in degrees",
    ),
    "two-statements": (
        XYZ,
        '[control]\nlocal = "left"\nkind = "geocentric"\n',
        'control.toml:1: control: give one of crs, kind, local. Write crs = "EPSG:...", kind = "geocentric" '
        'or local = "right"',
    ),
    "wrong-sigma": (
        "point,X_m,Y_m,Z_m,sigma_N_m\nA,1,2,3,4\n",
        LOCAL,
        'control.csv:1: column "sigma_N_m" does not go with the coordinates of this file',
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_control_is_named(write: Write, case: str) -> None:
    csv, toml, message = BAD[case]
    with pytest.raises(InputError) as caught:
        read(write, csv, toml)
    if message is None:
        assert str(caught.value).startswith('control.toml:2: crs: the coordinate system "NAD83 / New York Long Island')
    else:
        assert str(caught.value) == message


@pytest.mark.parametrize(
    ("ground", "toml", "message"),
    [
        (
            "crs",
            LOCAL,
            "control.csv:1: control is local, but the ground of the photo is not. Write [ground] local in photo.toml, "
            "or the system of the coordinates in control.toml",
        ),
        (
            "local",
            GEOCENTRIC,
            "control.csv:1: control is geocentric, but the ground of the photo is local. "
            "Give X_m, Y_m, Z_m in that system",
        ),
    ],
)
def test_control_fits_the_ground_of_the_photo(write: Write, ground: str, toml: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read(write, XYZ, toml, {"ground_kind": ground, "handedness": "right"})
    assert str(caught.value) == message


def test_local_control_follows_the_ground_of_the_photo(write: Write) -> None:
    tables = read(write, XYZ, "", {"ground_kind": "local", "handedness": "left"}).tables
    assert tables["control_system"] == [{"crs": None, "handedness": "left"}]
    assert [(row["kind"], row["X_m"], row["Z_m"]) for row in tables["control_point"]] == [
        ("local", 1.0, 3.0),
        ("local", 4.0, 6.0),
    ]


def test_plan_only_height_only_and_no_coordinates(write: Write) -> None:
    rows = points(write, "point,role,B_deg,L_deg,H_m\nA,,42 30 15.5,-75.5,\nB,check,,,120\nC,control,,,\n")
    columns = ("point", "role", "kind", "B_deg", "L_deg", "H_m")
    assert [tuple(row[column] for column in columns) for row in rows] == [
        ("A", "control", "geographic", 42 + 30 / 60 + 15.5 / 3600, -75.5, None),
        ("B", "check", "geographic", None, None, 120.0),
        ("C", "control", "none", None, None, None),
    ]


def test_only_roles(write: Write) -> None:
    tables = read(write, "point,role\nA,check\nB,control\n").tables
    assert [(row["kind"], row["role"]) for row in tables["control_point"]] == [("none", "check"), ("none", "control")]
    assert tables["control_system"] == [{"crs": None, "handedness": None}]


def test_sigmas_become_a_covariance_north_east_up(write: Write) -> None:
    header = "point,E_m,N_m,H_m,sigma_E_m,sigma_N_m,sigma_H_m\n"
    rows = points(write, header + "A,500000,5300000,100,2,3,4\nB,500000,5300001,,2,3,\nC,500000,5300002,7,,,\n", UTM)
    assert [tuple(row[column] for column in COV) for row in rows] == [
        (9.0, 0.0, 0.0, 4.0, 0.0, 16.0),
        (9.0, 0.0, None, 4.0, None, None),
        (None,) * 6,
    ]
    assert {row["kind"] for row in rows} == {"projected"}


def test_a_covariance_as_given(write: Write) -> None:
    rows = points(write, f"point,X_m,Y_m,Z_m,{COVARIANCE}\nA,1,2,3,4,0.5,-0.25,3,0,2\nB,,,9,,,,,,2\n", LOCAL)
    assert tuple(rows[0][column] for column in COV) == (4.0, 0.5, -0.25, 3.0, 0.0, 2.0)
    assert tuple(rows[1][column] for column in COV) == (None, None, None, None, None, 2.0)


def test_a_stated_crs_is_kept(write: Write) -> None:
    tables = read(write, XYZ.replace("A,1", "A,6378137"), '[control]\ncrs = "EPSG:4978"\n').tables
    assert tables["control_system"] == [{"crs": "EPSG:4978", "handedness": None}]
    assert tables["control_point"][0]["kind"] == "geocentric"


def test_C6_two_points_in_one_place_are_a_warning(write: Write) -> None:
    (event,) = read(write, "point,B_deg,L_deg,H_m\nA,1,2,3\nB,2,2,3\nC,1,2,3\n").events
    assert event.message == 'control.csv: points "A" (line 2) and "C" (line 4) coincide'
    assert (event.severity, event.code, event.subject) == ("warning", "same_place", "C")


def test_C14_a_project_needs_a_control_point(folder: Path, write: Write) -> None:
    write("control.csv", CONTROL.replace("control", "check"))
    with pytest.raises(InputError) as caught:
        read_project(folder, ReadOptions())
    assert str(caught.value) == "control.csv: no control points. All points have the role check"
