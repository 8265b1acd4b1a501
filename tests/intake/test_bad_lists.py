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


HEADERS = {
    "A1": ("", "the file is empty. Expected a header line: point,x_mm,y_mm"),
    "A1-blank": ("\n  \n", "the file is empty. Expected a header line: point,x_mm,y_mm"),
    "A2": (HEADER, "no data lines"),
    "A3": ("point,x_mm\nP1,1\n", '1: column "y_mm" is missing; found point, x_mm'),
    "A3-none": ("point\nP1\n", "1: columns x_mm, y_mm or col_px, row_px are missing; found point"),
    "A3-both": (
        "point,x_mm,y_mm,col_px,row_px\nP1,1,2,3,4\n",
        "1: give x_mm, y_mm or col_px, row_px: one of them, not 2",
    ),
    "A4": ("point,x_mm,x_mm,y_mm\nP1,1,2,3\n", '1: column "x_mm" appears twice'),
    "A5": (
        "point,x_mm,y_mm,remark\nP1,1,2,good\n",
        '1: column "remark" is not known. Leave it out, or --ignore-columns',
    ),
    "A5-near": ("point,x_mm,y_mm,sigma_nm\nP1,1,2,1\n", '1: column "sigma_nm" is not known. Did you mean "sigma_mm"?'),
    "A6-short": (HEADER + "P1,1\n", "2: 2 values, expected 3"),
    "A6-long": (HEADER + "P1,1,2,3\n", "2: 4 values, expected 3"),
    "A18": (
        "point,cycle,x_mm,y_mm\nP7,1,1,2\nP7,2,1,2\nP7,1,1,2\n",
        '4: point "P7", cycle 1, was already given in line 2',
    ),
    "A23": (HEADER.encode() + b"M\xfcnster,1,2\n", "2: not UTF-8 (byte 0xfc). Save as UTF-8, or --encoding latin-1"),
    "A23-surrogate": (
        HEADER.encode() + b"P\xed\xa0\x80,1,2\n",
        "2: not UTF-8 (byte 0xed). Save as UTF-8, or --encoding latin-1",
    ),
    "A24": ((HEADER + "P1,1,2\n").encode("utf-16"), "looks like UTF-16. Save as UTF-8"),
    "A24-no-bom": ((HEADER + "P1,1,2\n").encode("utf-16-le"), "looks like UTF-16. Save as UTF-8"),
    "A26": (HEADER + "P1,1,2\nP\0,1,2\n", "3: contains a NUL byte"),
    "A27": (HEADER + '"P1,1,2\nP2,1,2\n', "2: quote opened here is never closed. A cell ends in its own line"),
    "A27-order": (HEADER + '"P1"x,1,2\n', '2: quotes are not in order. Write "" for a quote inside quotes'),
    "A28-line": (HEADER + "P" * 10_000_000 + ",1,2\n", "2: line is longer than 10,000 characters"),
    "A28-field": (HEADER + '"' + "P" * 200_000 + '",1,2\n', "2: line is longer than 10,000 characters"),
    "A31": ("point x_mm y_mm\nP1 1 2\n", None),
    "A35": (HEADER + "P1,0,0\nP2,0,0\n", "all points coincide"),
    "A38-zip": (b"PK\x03\x04\x14\0\x06\0", "this is a ZIP file (Excel?). Export it as CSV"),
    "A38-gzip": (b"\x1f\x8b\x08\0", "this is a gzip file. Export it as CSV"),
    "A38-png": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "this is a PNG image. Export it as CSV"),
}

CELLS = {
    "A7-nan": ("nan", '"nan" is not a number orient accepts'),
    "A7-NaN": ("NaN", '"NaN" is not a number orient accepts'),
    "A7-inf": ("inf", '"inf" is not a number orient accepts'),
    "A7-Infinity": ("-Infinity", '"-Infinity" is not a number orient accepts'),
    "A8": ("1e400", '"1e400" is too large'),
    "A9": ("1e-400", '"1e-400" is too small to be a measurement'),
    "A9-denormal": ("5e-324", '"5e-324" is too small to be a measurement'),
    "A10": ("1_000", '"1_000" is not a number (underscore)'),
    "A11-wide": ("１２.５", '"１２.５" is not a number: digits must be 0-9'),
    "A11-arabic": ("٣", '"٣" is not a number: digits must be 0-9'),
    "A13-space": ("1 000", '"1 000" is not a number (thousands separator)'),
    "A13-quote": ("1'000.0", '"1\'000.0" is not a number (thousands separator)'),
    "A14": ("−5", 'the minus sign of "−5" is not "-" (U+2212)'),
    "A15-hex": ("0x1F", '"0x1F" is not a number'),
    "A15-exponent": ("1e", '"1e" is not a number'),
    "A15-signs": ("--5", '"--5" is not a number'),
    "A15-empty": ("", "value is missing"),
    "A15-blank": ("   ", "value is missing"),
    "A15-escape": ("\x1b[31m", '"\\x1b[31m" is not a number'),
    "A15-no-break-space": ("\u00a05", '"\\xa05" is not a number'),
    "A17": ("1" * 400, "number longer than 40 characters"),
    "C11": ("1e12", "1,000,000,000,000 is not in -100,000 … 100,000"),
    "C11-huge": ("-1e300", "-1e+300 is not in -100,000 … 100,000"),
}

NAMES = {
    "A21-bidi": ("P\u202e1", "contains U+202E; allowed are letters, digits, space and . _ - +"),
    "A21-zero-width": ("P\u200b1", "contains U+200B; allowed are letters, digits, space and . _ - +"),
    "A21-escape": ("P\x1b[1m", "contains U+001B; allowed are letters, digits, space and . _ - +"),
    "A21-slash": ("../P1", 'contains "/"; allowed are letters, digits, space and . _ - +'),
    "A22-empty": ("", "name is missing"),
    "A22-long": ("P" * 65, f'name "{"P" * 59}…" is longer than 64 characters'),
    "A22-space": ("P1 ", 'name "P1 " begins or ends with a space'),
}

SIGMAS = {
    "A32-zero": ("0", "must be > 0"),
    "A32-negative": ("-0.01", "must be > 0"),
    "A32-tiny": ("1e-300", "must be > 0"),
    "A32-text": ("?", '"?" is not a number'),
}

ANGLES = {
    "A36": ("400", "400 is not in -90 … 90. Grads? Write degrees"),
    "A36-minutes": ("42 60 0", "60 minutes are not less than 60"),
    "A36-seconds": ("42 30 60.5", "60.5 seconds are not less than 60"),
    "A36-pole": ("90 0 0.1", "90.000028 is not in -90 … 90. Grads? Write degrees"),
    "A36-text": ("42 N", '"42 N" is not a number'),
}


@pytest.mark.parametrize(("content", "message"), HEADERS.values(), ids=HEADERS)
def test_a_file_that_is_not_a_list_is_named(write: Write, content: str | bytes, message: str | None) -> None:
    place = "readings.csv" + (":" if message and message[0].isdigit() else ": ")
    if message is None:
        path = write("readings.csv", content)
        assert 'readings.csv:1: column "point" is missing; found point x_mm y_mm' in complaint(path)
    else:
        assert complaint(write("readings.csv", content)) == place + message


@pytest.mark.parametrize(("value", "message"), CELLS.values(), ids=CELLS)
def test_a_cell_that_is_no_number_is_named(write: Write, value: str, message: str) -> None:
    assert complaint(write("readings.csv", cell(value))) == f'readings.csv:2: column "x_mm": {message}'


@pytest.mark.parametrize(("name", "message"), NAMES.values(), ids=NAMES)
def test_a_name_that_cannot_be_taken_is_named(write: Write, name: str, message: str) -> None:
    path = write("readings.csv", HEADER + f"{name},1,2\n")
    assert complaint(path) == f'readings.csv:2: column "point": {message}'


@pytest.mark.parametrize(("sigma", "message"), SIGMAS.values(), ids=SIGMAS)
def test_a_sigma_is_positive(write: Write, sigma: str, message: str) -> None:
    path = write("readings.csv", f"point,x_mm,y_mm,sigma_mm\nP1,1,2,{sigma}\n")
    assert complaint(path) == f'readings.csv:2: column "sigma_mm": {message}'


@pytest.mark.parametrize(("angle", "message"), ANGLES.values(), ids=ANGLES)
def test_an_angle_has_its_range(write: Write, angle: str, message: str) -> None:
    path = write("control.csv", f"point,B_deg,L_deg,H_m\nP1,{angle},2,3\n")
    assert complaint(path, stage="control") == f'control.csv:2: column "B_deg": {message}'


def test_A5_unknown_columns_can_be_ignored(write: Write) -> None:
    path = write("readings.csv", "point,x_mm,y_mm,remark\nP1,1,2,good\n")
    rows = read_input("readings", [path], ReadOptions(ignore_columns=True)).tables["comparator_reading"]
    assert [(row["point"], row["x_mm"], row["y_mm"]) for row in rows] == [("P1", 1.0, 2.0)]


def test_A12_a_decimal_comma_must_be_said(write: Write) -> None:
    path = write("readings.csv", "point;x_mm;y_mm\nP1;1,5;2\n")
    expected = 'readings.csv:2: column "x_mm": "1,5": decimal comma found. Use a point, or --decimal comma'
    assert complaint(path) == expected
    comma = ReadOptions(decimal="comma")
    assert read_input("readings", [path], comma).tables["comparator_reading"][0]["x_mm"] == 1.5
    path = write("readings.csv", "point;x_mm;y_mm\nP1;1.5;2\n")
    expected = 'readings.csv:2: column "x_mm": "1.5": decimal point found, but --decimal comma was given'
    assert complaint(path, comma) == expected


def test_A16_minus_zero_is_zero(write: Write) -> None:
    row = read_input("readings", [write("readings.csv", cell("-0.0"))], POINT).tables["comparator_reading"][0]
    assert str(row["x_mm"]) == "0.0"


def test_A19_one_name_in_two_unicode_forms(write: Write) -> None:
    path = write("readings.csv", HEADER + "P0,1,2\n\u00c51,1,3\nA\u030a1,2,3\n")
    expected = 'readings.csv:4: column "point": point "Å1" is the same name as in line 3 in another Unicode form'
    assert complaint(path) == expected


@pytest.mark.parametrize(
    ("first", "second", "codes"), [("P1", "Р1", "U+0050 and U+0420"), ("p1", "P1", "U+0070 and U+0050")]
)
def test_A20_look_alikes_are_a_warning(write: Write, first: str, second: str, codes: str) -> None:
    tables = read_input("readings", [write("readings.csv", HEADER + f"{first},1,2\n{second},3,4\n")], POINT)
    (event,) = tables.events
    assert (event.severity, event.code, event.subject) == ("warning", "look_alike", second)
    assert event.message == (
        f'readings.csv: point "{first}" (line 2) and "{second}" (line 3) look alike but are different names ({codes})'
    )


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + HEADER.encode() + b"P1,1,2\nP2,3,4\nP3,5,6\n",
        b"point,x_mm,y_mm\r\nP1,1,2\nP2,3,4\rP3,5,6",
        b"# a remark\npoint;y_mm;x_mm\n\nP1;2;1\n# another\nP2;4;3\nP3;6;5\n",
        b'"point"\t"x_mm"\t"y_mm"\nP1\t1\t2\n"P2"\t"3"\t4\n\'P3\t5\t6\n'.replace(b"'P3", b"P3"),
    ],
    ids=["A25-bom", "A30-line-ends", "A31-semicolon", "A31-tab"],
)
def test_forms_that_are_accepted(write: Write, content: bytes) -> None:
    rows = read_input("readings", [write("readings.csv", content)], POINT).tables["comparator_reading"]
    expected = [(1, "P1", 1.0, 2.0), (2, "P2", 3.0, 4.0), (3, "P3", 5.0, 6.0)]
    assert [(row["seq"], row["point"], row["x_mm"], row["y_mm"]) for row in rows] == expected


def test_A23_another_encoding_can_be_told(write: Write) -> None:
    path = write("readings.csv", HEADER.encode() + b"M\xfcnster,1,2\n")
    rows = read_input("readings", [path], ReadOptions(encoding="latin-1")).tables["comparator_reading"]
    assert rows[0]["point"] == "Münster"


def test_F1_the_guard_against_formulas_is_taken_back(write: Write) -> None:
    rows = read_input("readings", [write("readings.csv", HEADER + "'-2,1,2\n'+3,1,3\n")], POINT).tables
    assert [row["point"] for row in rows["comparator_reading"]] == ["-2", "+3"]


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


def test_A33_weights_that_span_too_much_are_a_warning(write: Write) -> None:
    path = write("readings.csv", "point,x_mm,y_mm,sigma_mm\nP1,1,2,1e-6\nP2,3,4,1000\n")
    (event,) = read_input("readings", [path], POINT).events
    expected = "readings.csv: the largest sigma is 1.0e+09 times the smallest: the weights span 18 orders"
    assert (event.code, event.message) == ("weights_span", expected)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "point,col_px,row_px\nP3,91234.5,20\n",
            'point "P3": col_px = 91,234.5 lies outside the photo (0 … 8,000 px, 10 % margin)',
        ),
        (HEADER + "P3,5,-109\n", 'point "P3": y_mm = -109 lies outside the photo (-90 … 90 mm, 10 % margin)'),
    ],
    ids=["px", "mm"],
)
def test_A34_a_reading_outside_the_photo(write: Write, content: str, message: str) -> None:
    assert complaint(write("readings.csv", content), photo=PHOTO_ROW) == f"readings.csv:2: {message}"


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


def test_A37_readings_without_control_are_listed(folder: Path, write: Write) -> None:
    write("readings.csv", HEADER + "P1,1,2\nP2,3,4\nQ1,5,6\nQ2,7,8\n")
    readings = next(tables for tables in read_project(folder, POINT) if tables.stage == "readings")
    (event,) = readings.events
    assert event.message == "readings.csv: 2 points are not used: no control (Q1, Q2)"
    assert (event.code, event.severity, event.value) == ("no_control", "warning", 2.0)


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
