"""Control and geometry that must not be "solved": one row, one id of the catalogue, through the commands.

C1 ... C20 and the scenes of weak geometry; each ends in the result that is promised or in a refusal with its message.
C4 is in tests/catalogue/control.py, C18 and C19 in test_blunders.py.
"""

import re
from csv import DictReader
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from tests.cli.commands import Said, orient
from tests.cli.made_photo import GROUND, NAMES, Array, MadePhoto


def ring(*degrees: float) -> Array:
    """Points on a circle of 40 m."""
    angles = np.radians(degrees)
    return np.column_stack([40 * np.cos(angles), 40 * np.sin(angles), np.zeros(len(angles))])


def line(off_m: float) -> Array:
    """Six points of 80 m, the third off the line."""
    points = np.column_stack([np.linspace(-40, 40, 6), np.zeros(6), np.zeros(6)])
    points[2, 1] = off_m
    return points


def below(points: Array, x: float, y: float = 0.0, **given: object) -> MadePhoto:
    """Camera 100 m up, looking straight down; readings without error."""
    photo = MadePhoto(seen=points, station=np.array([x, y, 100.0]), angles=(0.0, 0.0, 0.0), noise=0.0)
    return replace(photo, approximate=photo.station.tolist(), **given)  # type: ignore[arg-type]


def changed(row: int, column: int, by: float) -> Array:
    ground = GROUND.copy()
    ground[row, column] += by
    return ground


def csv(name: str, text: str, **more: str) -> MadePhoto:
    return replace(GOOD, files={name: text, **more})


GOOD = MadePhoto()
FLAT = GROUND * [1, 1, 0] + [0, 0, 150]
LOW = FLAT + (GROUND - FLAT) * [0, 0, 0.05]
XYZ = [f"{name},{x},{y},{z}" for name, (x, y, z) in zip(NAMES, GROUND.tolist(), strict=False)]
UTM = '[control]\ncrs = "EPSG:25832"\n'
SWAP = [1, 0, 2]
COVARIANCE = "cov_XX_m2,cov_XY_m2,cov_XZ_m2,cov_YY_m2,cov_YZ_m2,cov_ZZ_m2"


def listed(header: str, *rows: str) -> str:
    return "\n".join([header, *rows, ""])


def localised(*rows: str) -> MadePhoto:
    return csv("control.csv", listed("point,X_m,Y_m,Z_m", *rows))


NEW = {
    "C1-empty": (csv("control.csv", ""), "control.csv: the file is empty. Expected a header line:"),
    "C1-nan": (localised("A,nan,2,3", *XYZ[1:]), 'control.csv:2: column "X_m": "nan" is not a number orient accepts'),
    "C8": (
        csv(
            "control.csv",
            listed("point,E_m,N_m,H_m", "A,12.5,48.1,100", "B,12.6,48.2,100"),
            **{"control.toml": UTM},
        ),
        "control.csv: values look like degrees, crs EPSG:25832 is in metres",
    ),
    "C9": (
        csv("control.toml", '[control]\ncrs = "EPSG:999999"\n'),
        'control.toml:2: crs: unknown coordinate system "EPSG:999999"',
    ),
    "C11": (localised("A,1e12,2,3", *XYZ[1:]), 'control.csv:2: column "X_m": 1,000,000,000,000 is not in -100,000,000'),
    "C11-huge": (localised("A,-1e300,2,3", *XYZ[1:]), 'control.csv:2: column "X_m": -1e+300 is not in -100,000,000'),
    "C12": (
        csv("control.csv", listed("point,E_m,N_m,H_m", "A,500000,5300000,-20000"), **{"control.toml": UTM}),
        'control.csv:2: column "H_m": -20,000 is not in -12,000 … 1,000,000',
    ),
    "C13": (
        csv("control.csv", listed("point,role,X_m,Y_m,Z_m", "A,tie,1,2,3")),
        'control.csv:2: column "role": "tie" is not one of control, check',
    ),
    "C14": (
        csv("control.csv", listed("point,role,X_m,Y_m,Z_m", "A,check,1,2,3", "B,check,4,5,6")),
        "control.csv: no control points. All points have the role check",
    ),
    "C15": (
        csv("control.csv", listed("point,X_m,Y_m,Z_m,sigma_X_m,sigma_Y_m,sigma_Z_m", "A,1,2,3,1,1,0")),
        'control.csv:2: column "sigma_Z_m": must be > 0. Leave the sigmas empty for a point that is taken as known',
    ),
    "C16": (localised(*XYZ, "A,1,2,3"), 'control.csv:10: point "A" was already given in line 2'),
    "C20": (
        csv("control.csv", listed(f"point,X_m,Y_m,Z_m,{COVARIANCE}", "A,1,2,3,1,1.0003,0,1,0,1")),
        "control.csv:2: covariance matrix is not valid (eigenvalue -0.0003)",
    ),
}
"""What `new` refuses: nothing is made."""


@pytest.mark.parametrize("case", NEW)
def test_a_list_that_cannot_be_is_refused_at_the_door(case: str, tmp_path: Path) -> None:
    photo, message = NEW[case]
    said = orient("new", tmp_path / "p.sqlite", "--from", photo.write(tmp_path / "in"))
    assert said.code == 1
    assert message in said.err
    assert not (tmp_path / "p.sqlite").exists()


def ran(photo: MadePhoto, folder: Path) -> tuple[Said, Path]:
    """`new`, then `run`."""
    path = folder / "p.sqlite"
    assert orient("new", path, "--from", photo.write(folder / "in")).code == 0
    return orient("run", path), path


def test_one_point_is_told_as_one(tmp_path: Path) -> None:
    said, _ = ran(GOOD.with_points(GROUND[:1]), tmp_path)
    assert "1 control point with all three coordinates in the photo (A); at least 3 are needed" in said.err
    assert "1 point, 0 of them check points" in said.out
    assert not re.search(r"\b1 (control |check |fiducial |local Cartesian )?(points|marks|fiducials|crosses)", said.out)


SINGULAR = "SINGULAR: The control does not determine the orientation."
REFUSED = {
    "C2": (
        GOOD.with_points(GROUND[:2]),
        "2 control points with all three coordinates in the photo (A, B); at least 3 are needed "
        "(2 values each, 6 unknowns)",
    ),
    "C3": (
        below(line(0.0), 3.0, 20.0),
        "control points lie on a line (off by 0 mm in 80 m): the orientation is not determined",
    ),
    "C3-1mm": (
        below(line(0.00122), 3.0, 20.0),
        "control points lie on a line (off by 1 mm in 80 m): the orientation is not determined",
    ),
    "C3-photo": (
        replace(GOOD, image=np.outer(np.arange(8.0), [10.0, 5.0])),
        "The control points lie on a line in the photo (off by ",
    ),
    "C5": (below(ring(0, 120, 240), -40.0), SINGULAR),
    "C5-names": (below(ring(0, 120, 240), -40.0), "The camera lies on the cylinder through A, B, C (off by "),
    "C6": (replace(GOOD, given=np.vstack([GROUND[:7], GROUND[:1]])), "Points A and H coincide on the ground."),
    "C7": (replace(GOOD, given=GROUND[:, SWAP]), "exchange of X and Y lowers sigma0 from 1,883 um to 3.62 um"),
    "C7-side": (replace(GOOD, given=GROUND[:, SWAP]), "BELOW_GROUND: The orientation that fits has the camera"),
    "C7-flat": (
        replace(GOOD, seen=FLAT, given=FLAT[:, SWAP]),
        "with X and Y exchanged the control fits and the camera is on the right side",
    ),
    "C7-terrestrial": (
        replace(GOOD, given=GROUND[:, SWAP], platform="terrestrial"),
        "BEHIND_CAMERA: The orientation that fits has control points behind the camera; are axes exchanged?",
    ),
    "C7-terrestrial-low": (
        replace(GOOD, seen=LOW, given=LOW[:, SWAP], platform="terrestrial"),
        "WRONG_AXES: exchange of X and Y lowers sigma0 from ",
    ),
    "C7-wrong-side": (
        replace(GOOD, seen=FLAT, given=FLAT[:, SWAP], platform="terrestrial", approximate=(300.0, 400.0, 1200.0)),
        "WRONG_SIDE: the approximate station lies on the other side of the control's plane",
    ),
    "mirrored-x": (replace(GOOD, image=GOOD.readings() * [-1, 1]), "exchange of X and Y lowers sigma0 from 1,883 um"),
    "mirrored-y": (replace(GOOD, image=GOOD.readings() * [1, -1]), "exchange of X and Y lowers sigma0 from 1,883 um"),
    "handedness": (replace(GOOD, local="left"), "exchange of X and Y lowers sigma0 from 1,883 um to 3.62 um"),
    "degrees-for-metres": (
        replace(GOOD, given=GROUND[:, SWAP] / [111e3, 82e3, 1] + [42.5, 22.1, 0]),
        "MAX_ITERATIONS: The resection did not converge within the allowed iterations.",
    ),
    "feet-for-heights": (
        replace(GOOD, given=GROUND * [1, 1, 3.28]),
        "NO_FIT: no orientation fits: the best leaves residuals of 3.2 mm rms on image points spread over 55.8 mm",
    ),
    "three-points": (
        GOOD.with_points(GROUND[:3]),
        "AMBIGUOUS: 3 control points leave 4 orientations that fit equally well, X_S, Y_S, Z_S: 400.1267, 299.9692, "
        "1200.04; 960.8448, -298.6331, 782.2691; 704.4924, 857.433, 683.6087; -199.3555, 5.023539, 377.5923",
    ),
    "three-points-far-station": (
        replace(GOOD.with_points(GROUND[:3]), approximate=(700.0, 0.0, 1000.0)),
        "AMBIGUOUS: 3 control points and the approximate station leave 4 orientations",
    ),
    "8.3 line": (below(line(0.0), 3.0, 20.0), "control points lie on a line"),
    "8.3 cylinder": (below(ring(0, 120, 240), -40.0), SINGULAR),
}
"""What `run` refuses: exit code 1, no orientation in the file, and the reason in it."""


@pytest.mark.parametrize("case", REFUSED)
def test_geometry_that_cannot_be_solved_is_refused_by_name(case: str, tmp_path: Path) -> None:
    photo, message = REFUSED[case]
    said, path = ran(photo, tmp_path)
    assert said.code == 1
    assert message in said.out + said.err
    assert orient("sql", path, "orientation").out == "no rows\n"
    assert "FAILED, this is not a result" in orient("show", path, "resection").out


@dataclass(frozen=True)
class Weak:
    """A scene that is solved, with the range of its condition ratio and what must be said."""

    photo: MadePhoto
    lowest: float
    highest: float
    words: str = ""


SPREAD = np.vstack([ring(0, 130, 250), ring(60, 190, 310) * 0.5 + [0, 0, 20]])
SOLVED = {
    "8.3 spread, 20 m relief": Weak(below(SPREAD, 5.0, 3.0), 1e-2, 1),
    "8.3 line, 1 cm": Weak(below(line(0.01), 3.0, 20.0), 1e-6, 3e-5, "weak geometry (singular values "),
    "8.3 line, 10 cm": Weak(below(line(0.1), 3.0, 20.0), 1e-5, 1e-4, "weak geometry (singular values "),
    "8.3 line, 1 m": Weak(below(line(1.0), 3.0, 20.0), 1e-4, 3e-3),
    "8.3 line, 10 m": Weak(below(line(10.0), 3.0, 20.0), 1e-3, 3e-2),
    "8.3 cylinder, 5 cm off": Weak(
        below(ring(0, 120, 240), -40.05), 1e-5, 1e-4, "hardly determined: Y_S 1.00, the rotation about X -0.99"
    ),
    "8.3 cylinder, 10 m off": Weak(below(ring(0, 120, 240), -50.0), 1e-3, 1),
    "8.3 four on the cylinder": Weak(below(ring(0, 70, 130, 240), -40.0), 1e-3, 1),
    "correlation": Weak(GOOD, 1e-3, 1, "the rotation about X and Y_S -0.9957, the rotation about Y and X_S +0.9946"),
    "C17": Weak(
        replace(GOOD, given=changed(3, 0, 5e6)),
        1e-3,
        1,
        "warning: D lies 4,999 km from the middle of the control, beyond 20 times the median distance of 361.4 m: "
        "not used",
    ),
    "C10 height missing": Weak(localised(*XYZ[:7], "H,560,480,"), 1e-3, 1),
    "mirror of a plane": Weak(
        replace(GOOD, seen=FLAT, given=FLAT[:, SWAP], platform="terrestrial"),
        1e-3,
        1,
        "the control lies on a plane and fits as well with X and Y exchanged: make sure that the camera stood on this "
        "side of it, 1050 m below the mean of the points",
    ),
    "upside down": Weak(replace(GOOD, image=-GOOD.readings()), 1e-3, 1),
    "long lens over flat ground": Weak(
        MadePhoto(seen=FLAT, f_mm=3000.0, station=np.array([400, 300, 40000.0])), 1e-6, 1e-4, "weak geometry"
    ),
    "three points and a station": Weak(
        replace(GOOD.with_points(GROUND[:3]), approximate=(420.0, 310.0, 1180.0)),
        1e-3,
        1,
        "3 other orientations fit as well",
    ),
}


@pytest.mark.parametrize("case", SOLVED)
def test_weak_geometry_is_solved_rightly_and_named(case: str, tmp_path: Path) -> None:
    weak = SOLVED[case]
    said, path = ran(weak.photo, tmp_path)
    assert said.code == 0
    assert weak.words in said.out
    ratio, distance = _stored(path, weak.photo)
    assert weak.lowest < ratio < weak.highest
    assert ("weak geometry" in said.out) == (ratio < 1e-4)
    if case != "mirror of a plane":  # the data are those of another camera
        assert distance < 0.02


def _stored(path: Path, photo: MadePhoto) -> tuple[float, float]:
    """Condition ratio, and the error of the station in distances to the ground."""
    sql = "SELECT condition_ratio, X_S_m, Y_S_m, Z_S_m FROM orientation"
    ratio, *station = (float(v) for v in orient("sql", path, sql, "--csv").out.splitlines()[1].split(","))
    truth = photo.station
    return ratio, float(np.linalg.norm(np.array(station) - truth) / np.linalg.norm(truth - photo.seen.mean(axis=0)))


def test_C6_two_names_of_one_place_are_a_warning_when_read(tmp_path: Path) -> None:
    photo = replace(GOOD, given=np.vstack([GROUND[:7], GROUND[:1]]))
    said = orient("new", tmp_path / "p.sqlite", "--from", photo.write(tmp_path / "in"))
    assert said.code == 0
    assert 'points "A" (line 2) and "H" (line 9) coincide' in said.out + said.err


def test_every_start_and_every_end_is_a_row(tmp_path: Path) -> None:
    """Also of a refusal: the four orientations that see three points, and what led to them."""
    said, path = ran(GOOD.with_points(GROUND[:3]), tmp_path)
    assert said.code == 1
    solutions = _rows(orient("sql", path, "solutions", "--csv").out)
    assert [row["termination"] for row in solutions] == ["CONVERGED"] * 4
    assert all(row["is_as_good"] == "1" and row["n_in_front"] == "3" for row in solutions)
    starts = _rows(orient("sql", path, "starts", "--csv").out)
    assert {row["method"] for row in starts} == {"three points"}
    assert {row["solution"] for row in starts} >= {"1", "2", "3", "4"}
    shown = orient("show", path, "resection").out
    assert "Where they led: 1 is the best, only CONVERGED is a result" in shown


def test_all_closed_forms_are_tried(tmp_path: Path) -> None:
    near = replace(GOOD, approximate=(0.0, 0.0, 1000.0))
    for photo, methods in (
        (near, {"three points", "direct linear", "approximate station"}),
        (GOOD.with_points(FLAT), {"three points", "plane"}),
    ):
        folder = tmp_path / str(len(methods))
        folder.mkdir()
        starts = _rows(orient("sql", ran(photo, folder)[1], "starts", "--csv").out)
        assert {row["method"] for row in starts} == methods


def _rows(text: str) -> list[dict[str, str]]:
    return list(DictReader(text.splitlines()))
