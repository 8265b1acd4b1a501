"""A: point measurements. Most rows spoil readings.csv of a good folder; `orient new` must say this and no more."""

import os
from collections.abc import Callable
from pathlib import Path

from tests.catalogue.case import FOLDER, NEW, PROJECT, Case, Place, accepted, refused, rows_of
from tests.intake.conftest import PHOTO

HEADER = "point,x_mm,y_mm\n"
PIXELS = "[pixels]\nsize_mm = 0.014\norigin_col = 4000\norigin_row = 3000\nimage = [8000, 6000]\n"


def cell(value: str) -> str:
    return f"point,x_mm,y_mm\nP1,{value},5\n"


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


def _whole_files() -> dict[str, Case]:
    cases = {}
    for name, (content, message) in HEADERS.items():
        place = "readings.csv:" if message[0].isdigit() else "readings.csv: "
        cases[name] = refused(place + message, readings=content)
    return cases


READINGS_ROWS = "SELECT point, x_mm, y_mm FROM comparator_reading ORDER BY seq"
THREE = rows_of(READINGS_ROWS, "P1,1.0,2.0\nP2,3.0,4.0\nP3,5.0,6.0")


def with_options(*options: str) -> tuple[str, ...]:
    return (*NEW, *options)


FORMS = {
    "A25 BOM": b"\xef\xbb\xbf" + HEADER.encode() + b"P1,1,2\nP2,3,4\nP3,5,6\n",
    "A30 line ends": b"point,x_mm,y_mm\r\nP1,1,2\nP2,3,4\rP3,5,6",
    "A31 semicolon": b"# a remark\npoint;y_mm;x_mm\n\nP1;2;1\n# another\nP2;4;3\nP3;6;5\n",
    "A31 tab": b'"point"\t"x_mm"\t"y_mm"\nP1\t1\t2\n"P2"\t"3"\t4\nP3\t5\t6\n',
}


def look_alike(first: str, second: str, codes: str) -> Case:
    message = f'point "{first}" (line 2) and "{second}" (line 3) look alike but are different names ({codes})'
    return accepted(says=[f"warning: readings.csv: {message}"], readings=HEADER + f"{first},1,2\n{second},3,4\n")


def added(make: Callable[[Path], object], said: str) -> Case:
    """A path that is no readable file, given to `orient add`."""

    def before(place: Place) -> None:
        place.write({})
        assert place.say(NEW).code == 0
        make(place.folder / "r.csv")

    return Case(
        words=("add", PROJECT, "readings", FILE, "-m", "x"), code=2, err=f"orient: r.csv: {said}\n", before=before
    )


FILE = f"{FOLDER}/r.csv"

CASES: dict[str, Case] = {
    **_whole_files(),
    **{
        name: refused(f'readings.csv:2: column "x_mm": {message}', readings=cell(value))
        for name, (value, message) in CELLS.items()
    },
    **{
        name: refused(f'readings.csv:2: column "point": {message}', readings=HEADER + f"{text},1,2\n")
        for name, (text, message) in NAMES.items()
    },
    **{
        name: refused(
            f'readings.csv:2: column "sigma_mm": {message}', readings=f"point,x_mm,y_mm,sigma_mm\nP1,1,2,{sigma}\n"
        )
        for name, (sigma, message) in SIGMAS.items()
    },
    **{
        name: refused(f'control.csv:2: column "B_deg": {message}', control=f"point,B_deg,L_deg,H_m\nP1,{angle},2,3\n")
        for name, (angle, message) in ANGLES.items()
    },
    **{name: accepted(THREE, readings=content) for name, content in FORMS.items()},
    "A5 ignored": Case(
        words=with_options("--ignore-columns"),
        files={"readings.csv": "point,x_mm,y_mm,remark\nP1,1,2,good\n"},
        code=0,
        changes=True,
        then=rows_of(READINGS_ROWS, "P1,1.0,2.0"),
    ),
    "A12": refused(
        'readings.csv:2: column "x_mm": "1,5": decimal comma found. Use a point, or --decimal comma',
        readings="point;x_mm;y_mm\nP1;1,5;2\n",
    ),
    "A12 told": Case(
        words=with_options("--decimal", "comma"),
        files={
            "readings.csv": "point;x_mm;y_mm\nP1;1,5;2\n",
            "control.csv": "point;role;B_deg;L_deg;H_m\nP1;control;27,5;2,5;0\n",
        },
        code=0,
        changes=True,
        then=rows_of(READINGS_ROWS, "P1,1.5,2.0"),
    ),
    "A12 told wrongly": Case(
        words=with_options("--decimal", "comma"),
        files={"readings.csv": "point;x_mm;y_mm\nP1;1.5;2\n", "control.csv": None},
        err='orient: readings.csv:2: column "x_mm": "1.5": decimal point found, but --decimal comma was given\n',
    ),
    "A16": accepted(rows_of(READINGS_ROWS, "P1,0.0,5.0"), readings=cell("-0.0")),
    "A19": refused(
        'readings.csv:4: column "point": point "Å1" is the same name as in line 3 in another Unicode form',
        readings=HEADER + "P0,1,2\n\u00c51,1,3\nA\u030a1,2,3\n",
    ),
    "A20 Cyrillic": look_alike("P1", "Р1", "U+0050 and U+0420"),
    "A20 case": look_alike("p1", "P1", "U+0070 and U+0050"),
    "A23 told": Case(
        words=with_options("--encoding", "latin-1"),
        files={"readings.csv": HEADER.encode() + b"M\xfcnster,1,2\n"},
        code=0,
        changes=True,
        then=rows_of(READINGS_ROWS, "Münster,1.0,2.0"),
    ),
    "A29 told": Case(
        words=with_options("--max-rows", "1"),
        files={"readings.csv": HEADER + "P1,1,2\nP2,3,4\n", "control.csv": None},
        err="orient: readings.csv: more than 1 data lines. Raise with --max-rows\n",
    ),
    "A31 other": Case(
        files={"readings.csv": "point x_mm y_mm\nP1 1 2\n"},
        says=['readings.csv:1: column "point" is missing; found point x_mm y_mm'],
    ),
    "A33": accepted(
        says=["readings.csv: the largest sigma is 1.0e+09 times the smallest: the weights span 18 orders"],
        readings="point,x_mm,y_mm,sigma_mm\nP1,1,2,1e-6\nP2,3,4,1000\n",
    ),
    "A34 px": refused(
        'readings.csv:2: point "P3": col_px = 91,234.5 lies outside the photo (0 … 8,000 px, 10 % margin)',
        photo=PHOTO + PIXELS,
        readings="point,col_px,row_px\nP3,91234.5,20\n",
    ),
    "A34 mm": refused(
        'readings.csv:2: point "P3": y_mm = -109 lies outside the photo (-57.152 … 57.15 mm, 10 % margin)',
        readings=HEADER + "P3,5,-109\n",
    ),
    "A37": accepted(
        rows_of("SELECT count(*) FROM comparator_reading", "4"),
        says=["warning: readings.csv: 2 points are not used: no control (Q1, Q2)"],
        readings=HEADER + "P1,1,2\nP2,3,4\nQ1,5,6\nQ2,7,8\n",
    ),
    "A39 folder": added(lambda path: path.mkdir(), "is a folder"),
    "A39 pipe": added(os.mkfifo, "is a pipe, not a file"),
    "A39 device": added(lambda path: path.symlink_to("/dev/null"), "is a device, not a file"),
    "A39 missing": added(lambda path: None, "no such file"),
    "A39 loop": added(lambda path: path.symlink_to("r.csv"), "too many links"),
}
