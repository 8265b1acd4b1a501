"""The bad inputs A1 ... A40: each gives its one clear message. Most rows spoil a readings.csv."""

import errno
import os
import tracemalloc
from pathlib import Path

import pytest

from orient.errors import InputError
from orient.intake import text_file
from orient.intake.project_folder import ReadOptions, read_input, read_project
from tests.intake.conftest import CONTROL, Write

POINT = ReadOptions()
HEADER = "point,x_mm,y_mm\n"
PHOTO_ROW = {
    "ground_kind": "ellipsoid",
    "interior_transformation": "none",
    "frame_width_mm": 180.0,
    "frame_height_mm": 180.0,
    "x0_mm": 0.0,
    "y0_mm": 0.0,
    "pixel_size_mm": 0.01,
    "image_width_px": 8000,
    "image_height_px": 6000,
    "fiducials": ["1", "2"],
}


def complaint(path: Path, options: ReadOptions = POINT, stage: str = "readings", photo: object = None) -> str:
    with pytest.raises(InputError) as caught:
        read_input(stage, [path], options, photo if isinstance(photo, dict) else None)
    assert caught.value.exit_code == 1
    return str(caught.value)


def cell(value: str, column: str = "x_mm") -> str:
    return f"point,{column},y_mm\nP1,{value},5\n"


def test_A29_a_file_too_long_is_refused_in_little_memory(write: Write) -> None:
    path = write("readings.csv", HEADER + "P1,1,2\n" * 2_000_000)
    tracemalloc.start()
    assert complaint(path) == "readings.csv: more than 1,000,000 data lines. Raise with --max-rows"
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10_000_000
    path = write("readings.csv", HEADER + "P1,1,2\nP2,3,4\n")
    assert complaint(path, ReadOptions(max_rows=1)) == "readings.csv: more than 1 data lines. Raise with --max-rows"
    read_input("readings", [path], ReadOptions(max_rows=2))


def test_readings_fit_the_photo(write: Write) -> None:
    path = write("readings.csv", "point,kind,x_mm,y_mm\n1,fiducial,1,2\n9,fiducial,2,2\n")
    expected = 'readings.csv:3: fiducial "9" is not a mark of photo.toml (known: 1, 2)'
    assert complaint(path, photo=PHOTO_ROW) == expected
    path = write("readings.csv", "point,col_px,row_px\nP1,1,2\n")
    expected = "readings.csv:1: readings in pixels need the size of a pixel. Give size_mm in [pixels] of photo.toml"
    assert complaint(path, photo={**PHOTO_ROW, "pixel_size_mm": None}) == expected
    path = write("readings.csv", "point,col_px,row_px,sigma_mm\nP1,1,2,3\n")
    expected = 'readings.csv:1: column "sigma_mm" does not go with col_px, row_px. Write sigma_px'
    assert complaint(path) == expected


def refusal(path: Path) -> tuple[str, int]:
    with pytest.raises(InputError) as caught:
        read_input("readings", [path], POINT)
    return str(caught.value), caught.value.exit_code


def test_A39_what_is_no_readable_file_is_a_usage_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert refusal(tmp_path) == (f"{tmp_path.name}: is a folder", 2)
    assert refusal(tmp_path / "r.csv") == ("r.csv: no such file", 2)
    assert refusal(tmp_path / "r\0.csv") == ("r\\x00.csv: no such file", 2)
    os.mkfifo(tmp_path / "pipe.csv")
    assert refusal(tmp_path / "pipe.csv") == ("pipe.csv: is a pipe, not a file", 2)
    assert refusal(Path("/dev/null")) == ("null: is a device, not a file", 2)
    (tmp_path / "loop.csv").symlink_to("loop.csv")
    assert refusal(tmp_path / "loop.csv") == ("loop.csv: too many links", 2)

    def forbid(*_: object, **__: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    (tmp_path / "mine.csv").write_text(HEADER)
    monkeypatch.setattr(Path, "open", forbid)
    assert refusal(tmp_path / "mine.csv") == ("mine.csv: permission denied", 2)


def test_A40_a_file_that_changes_while_read(write: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write("readings.csv", HEADER + "P1,1,2\n")
    original = text_file._too_many_lines

    def meanwhile(*arguments: object) -> str:
        with path.open("a") as file:
            file.write("P2,3,4\n")
        return original(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(text_file, "_too_many_lines", meanwhile)
    assert complaint(path) == "readings.csv: changed while reading, try again"


def test_all_problems_of_all_files_come_together(folder: Path, write: Write) -> None:
    write("readings.csv", HEADER + "P1,nan,2\nP1,3,4,5\n")
    write("control.csv", CONTROL + "P2,judge,1,2,3\n")
    write("model.csv", "zone,point,x,y,z\n" + "A,P1,x,y,z\n" * 10)
    with pytest.raises(InputError) as caught:
        read_project(folder, POINT)
    assert len(caught.value.problems) == 33
    lines = str(caught.value).split("\n")
    assert lines[:4] == [
        'readings.csv:2: column "x_mm": "nan" is not a number orient accepts',
        "readings.csv:3: 4 values, expected 3",
        'control.csv:4: column "role": "judge" is not one of control, check',
        'model.csv:2: column "x": "x" is not a number',
    ]
    assert lines[20:] == ["... and 13 more problems"]


def test_a_file_wrong_in_every_line_is_not_read_to_its_end(write: Write) -> None:
    path = write("readings.csv", HEADER + "P1,x,2\n" * 50_000)
    with pytest.raises(InputError) as caught:
        read_input("readings", [path], POINT)
    assert len(caught.value.problems) == 1001
    assert str(caught.value.problems[-1]) == ("readings.csv:1002: too many problems; the rest of the file was not read")
    assert str(caught.value).split("\n")[20:] == ["... and at least 980 more problems"]


def test_a_description_wrong_in_every_line_tells_no_number_of_problems(write: Write) -> None:
    path = write("photo.toml", "".join(f"word{n} = 1\n" for n in range(5000)))
    with pytest.raises(InputError) as caught:
        read_input("photo", [path], POINT)
    assert str(caught.value.problems[-1]).endswith("too many problems; the rest of the file was not read")
    assert str(caught.value).split("\n")[20:] == ["... and at least 980 more problems"]


MODEL = "zone,point,x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz\n"
MODEL_COVARIANCES = {
    "C20 not definite": ("A,P1,1,2,3,1,0,2,1,0,1", "2: covariance matrix is not valid (eigenvalue -1)"),
    "C20 zero": ("A,P1,1,2,3,0,0,0,0,0,0", "2: covariance matrix is not valid (eigenvalue 0)"),
    "one missing": (
        "A,P1,1,2,3,1,0,0,1,,1",
        '2: column "cov_yz": value is missing. Leave all of them empty for a point without covariances',
    ),
    "no number": ("A,P1,1,2,3,1,0,0,one,0,1", '2: column "cov_yy": "one" is not a number'),
    "huge": ("A,P1,1,2,3,1,0,0,1,0,1e16", '2: column "cov_zz": 1e+16 is not in -1e+15 … 1e+15'),
}


@pytest.mark.parametrize("case", MODEL_COVARIANCES)
def test_covariances_of_model_points(write: Write, case: str) -> None:
    line, message = MODEL_COVARIANCES[case]
    said = complaint(write("model.csv", MODEL + line + "\nA,P2,4,5,6,,,,,,\n"), stage="model")
    assert said.startswith(f"model.csv:{message}")
    assert len(said.splitlines()) == 1


def test_model_points_with_and_without_covariances(write: Write) -> None:
    path = write("model.csv", MODEL + "A,P1,1,2,3,4,1,0.5,5,-1,6\nA,P2,4,5,6,,,,,,\n")
    rows = read_input("model", [path], POINT).tables["model_point"]
    names = MODEL.strip().split(",")[5:]
    assert [[row[name] for name in names] for row in rows] == [[4.0, 1.0, 0.5, 5.0, -1.0, 6.0], [None] * 6]
    plain = read_input("model", [write("plain.csv", "zone,point,x,y,z\nA,P1,1,2,3\nB,P1,4,5,6\n")], POINT)
    assert {row["cov_zz"] for row in plain.tables["model_point"]} == {None}
