"""Any text at all is either read or refused with an InputError; what was written well comes back to the last bit."""

import math
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orient.errors import InputError, UsageError
from orient.intake.findings import BadValue, shown
from orient.intake.names import parse_name
from orient.intake.numbers import parse_angle, parse_number
from orient.intake.project_folder import FILES_OF_STAGE, ReadOptions, read_input, read_project
from orient.units import format_dms
from tests.intake.conftest import CONTROL, PHOTO, READINGS

POINT = ReadOptions()
HEADERS = ("point,x_mm,y_mm\n", "sheet,point,X_mm,Y_mm,H_m\n", "sheet,X_mm,Y_mm,B_deg,L_deg\n", "zone,point,x,y,z\n")
cells = st.one_of(st.floats().map(str), st.integers().map(str), st.text(max_size=8), st.sampled_from(["P1", "1e5", ""]))
lines = st.lists(st.lists(cells, min_size=1, max_size=6).map(",".join), max_size=6).map("\n".join)


def read_any(stage: str, name: str, content: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(content)
        try:
            read_input(stage, [path], POINT)
        except InputError as error:
            assert error.problems
            assert all(character.isprintable() or character == "\n" for character in str(error))


@given(st.sampled_from([name for name in FILES_OF_STAGE if name != "photo"]), st.sampled_from(HEADERS), lines)
def test_any_list_is_read_or_refused(stage: str, header: str, text: str) -> None:
    read_any(stage, "list.csv", (header + text).encode("utf-8", "surrogatepass"))


@given(st.sampled_from(sorted(FILES_OF_STAGE)), st.binary(max_size=300))
def test_any_bytes_are_read_or_refused(stage: str, content: bytes) -> None:
    read_any(stage, "photo.toml" if stage == "photo" else "list.csv", content)


@given(st.integers(0, len(PHOTO)), st.integers(0, 30), st.text(max_size=20))
def test_any_photo_is_read_or_refused(start: int, length: int, text: str) -> None:
    content = PHOTO[:start] + text + PHOTO[start + length :]
    read_any("photo", "photo.toml", content.encode("utf-8", "surrogatepass"))


@given(st.text())
def test_a_text_is_a_number_an_angle_and_a_name_or_refused(text: str) -> None:
    for parse in (lambda: parse_number(text, POINT), lambda: parse_angle(text, POINT), lambda: parse_name(text)):
        try:
            parse()
        except BadValue as bad:
            assert shown(bad.message).isprintable()


@given(st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=False))
def test_a_number_comes_back(value: float) -> None:
    assert parse_number(repr(value), POINT) == value
    assert parse_number(repr(value).replace(".", ","), ReadOptions(decimal="comma")) == value


@given(st.floats(-360, 360))
def test_an_angle_comes_back(degrees: float) -> None:
    for text in (format_dms(degrees, 4), format_dms(degrees, 4).replace(" ", "°", 1).replace(" ", "'", 1) + '"'):
        assert math.isclose(parse_angle(text, POINT), degrees, abs_tol=0.51e-4 / 3600)


@pytest.mark.parametrize(
    ("text", "degrees"),
    [
        ("42.504", 42.504),
        ("-42 30", -42.5),
        ("42 30.25", 42 + 30.25 / 60),
        ("-0 30 0", -0.5),
        ("42°", 42.0),
        ("42° 30' 15.5\"", 42 + 30 / 60 + 15.5 / 3600),
        ("42°30′15.5″", 42 + 30 / 60 + 15.5 / 3600),
        ("+7 05 06.", 7 + 5 / 60 + 6 / 3600),
    ],
)
def test_angles(text: str, degrees: float) -> None:
    assert parse_angle(text, POINT) == pytest.approx(degrees, abs=1e-14)


@given(st.text(min_size=80, max_size=200))
def test_no_more_than_60_characters_are_shown(text: str) -> None:
    assert len(shown(text)) <= 60
    assert shown(text).isprintable()


@pytest.mark.parametrize("encoding", ["utf-16", "cp037", "hex", "no-such", "rot13", "idna", "a\0b"])
def test_an_encoding_that_cannot_be_used(folder: Path, encoding: str) -> None:
    with pytest.raises(UsageError, match="is not known or not usable"):
        read_project(folder, ReadOptions(encoding=encoding))


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_project(tmp_path / "nothing", POINT)
    assert (str(caught.value), caught.value.exit_code) == ("nothing: no such folder", 2)


def test_a_folder_without_photo(tmp_path: Path) -> None:
    (tmp_path / "readings.csv").write_text(READINGS)
    (tmp_path / "control.csv").write_text(CONTROL)
    with pytest.raises(InputError) as caught:
        read_project(tmp_path, POINT)
    said = f"{tmp_path.name}: no photo.toml in this folder. Give a folder that holds one"
    assert (str(caught.value), caught.value.exit_code) == (said, 2)


def test_a_file_for_a_folder(folder: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_project(folder / "photo.toml", POINT)
    said = "photo.toml: is a file. Give the folder that holds photo.toml"
    assert (str(caught.value), caught.value.exit_code) == (said, 2)


def test_words_of_the_command(folder: Path) -> None:
    with pytest.raises(UsageError, match="is not an input"):
        read_input("pictures", [folder / "readings.csv"], POINT)
    with pytest.raises(UsageError, match="no files for readings"):
        read_input("readings", [], POINT)
    with pytest.raises(InputError, match=r"^control.toml: does not suffice for control. Give control.csv too$"):
        (folder / "control.toml").write_text('[control]\nkind = "geocentric"\n')
        read_input("control", [folder / "control.toml"], POINT)
