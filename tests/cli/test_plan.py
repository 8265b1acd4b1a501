"""`orient plan`: its output as docs/planning.md shows it, JSON, and a sentence for every bad input."""

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner, Result

from orient.cli import plan
from orient.errors import OrientError

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "planning.md").read_text("utf-8")
CAMERA = ["--f-mm", "150", "--frame-mm", "230", "230", "--sigma-um", "6", "--height-m", "1500"]
SHOWN = re.compile(r"```\n\$ orient (?P<command>[^\n]*)\n(?P<output>.*?)```", re.DOTALL)
VILLAGE = re.compile(r"```\n# village\.csv\n(?P<content>.*?)```", re.DOTALL)

app = typer.Typer()
plan.register(app)


@app.callback()
def _commands() -> None:
    """More than one command, so that `plan` keeps its name."""


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["plan", *arguments])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the commands of the page work."""
    shutil.copy(ROOT / "sample_projects" / "calgary-27" / "photo.toml", tmp_path)
    village = VILLAGE.search(PAGE)
    assert village is not None
    (tmp_path / "village.csv").write_text(village["content"], "utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("example", range(2))
def test_the_page_shows_the_real_output(example: int, folder: Path) -> None:
    shown = list(SHOWN.finditer(PAGE))[example]
    result = run(*shlex.split(shown["command"])[1:])
    assert result.exception is None
    assert [line.rstrip() for line in result.output.splitlines()] == shown["output"].splitlines()


def test_json_holds_all_digits() -> None:
    result = run("--f-mm", "200", "--frame-mm", "180", "180", "--sigma-um", "7", "--height-m", "250000", "--json")
    content = json.loads(result.output)
    sigma = {entry["element"]: entry["sigma"] for entry in content["elements"]}
    assert sigma["Z_S"] == pytest.approx(5.613128, rel=1e-7)
    assert sigma["alpha"] == pytest.approx(7.056143e-5, rel=1e-7)
    assert content["closed_form"]["violated"] == []
    assert content["closed_form"]["sigma"] == pytest.approx(list(sigma.values()), rel=1e-9)
    assert len(content["ground"]) == 25
    assert {place["x_mm"] for place in content["ground"]} == {-90, -45, 0, 45, 90}
    assert sum(point["redundancy_number"] for point in content["points"]) == pytest.approx(12)
    assert all(effect["ground_mean_sigma_m"] > content["ground_mean_sigma_m"] for effect in content["without"])
    assert all(effect["ground_mean_sigma_m"] < content["ground_mean_sigma_m"] for effect in content["one_more"])


def test_json_of_three_points_has_no_numbers_without_them(folder: Path) -> None:
    three = "point,x_mm,y_mm\nA,-100,90\nB,95,100\nC,-90,-95\n"
    (folder / "three.csv").write_text(three)
    content = json.loads(run(*CAMERA, "--layout", "three.csv", "--json").output)
    text = run(*CAMERA, "--layout", "three.csv").output
    assert [effect["is_determined"] for effect in content["without"]] == [False] * 3
    assert [effect["sigma"] for effect in content["without"]] == [None] * 3
    assert "three points leave no redundancy" in content["notes"][0]
    assert "note: three points leave no redundancy" in text
    assert "not determined" in text


@pytest.mark.parametrize(
    ("layout", "points", "determinants"),
    [("grid:3x3", 9, 1), ("corners", 4, 1), ("grid:5x3", 15, 2), ("grid:2x3", 6, 2), ("gruber", 6, 0)],
)
def test_layouts(layout: str, points: int, determinants: int) -> None:
    content = json.loads(run(*CAMERA, "--layout", layout, "--json").output)
    assert len(content["points"]) == points
    assert content["closed_form"]["determinants"] == determinants
    assert content["closed_form"]["applies"]


def test_violated_conditions_are_named_with_their_values() -> None:
    output = run(*CAMERA, "--layout", "gruber").output
    assert "No closed form holds; violated conditions" in output
    assert "  sum xi = 3, should be 0" in output.splitlines()
    assert "would be wrong by up to" in output
    assert "The closed form holds with Dx and Dy" in run(*CAMERA, "--layout", "grid:5x3").output
    assert "not this plan" in run(*CAMERA, "--tilt-deg", "10").output


def test_margin_moves_the_grid_inwards() -> None:
    content = json.loads(run(*CAMERA, "--layout", "corners", "--margin-mm", "15", "--json").output)
    assert {abs(point["x_mm"]) for point in content["points"]} == {100.0}


def test_options_go_before_the_file(folder: Path) -> None:
    known = ["--photo", "photo.toml", "--height-m", "1200", "--json"]
    plain = json.loads(run(*known).output)
    better = json.loads(run(*known, "--sigma-um", "3").output)
    assert plain["f_mm"] == better["f_mm"] == 153.358
    assert plain["sigma_image_mm"] == 0.006
    for a, b in zip(plain["elements"], better["elements"], strict=True):
        assert b["sigma"] == pytest.approx(a["sigma"] / 2)


def test_sky_is_said_and_shown(folder: Path) -> None:
    (folder / "low.csv").write_text("point,x_mm,y_mm\nA,-100,-80\nB,100,-80\nC,90,-10\nD,-95,-5\n")
    output = run(*CAMERA, "--layout", "low.csv", "--tilt-deg", "90").output
    assert "15 of 25 places of the frame look above the horizon" in output
    assert "omega deg" in output
    assert "phi deg" in output


def test_a_point_that_cannot_be_spared_is_named(folder: Path) -> None:
    (folder / "circle.csv").write_text("point,x_mm,y_mm\nA,50,0\nB,25,25\nC,25,-25\nlast,-60,40\n")
    output = run(*CAMERA, "--layout", "circle.csv").output
    assert "note: the orientation is not determined without last" in output


BAD_OPTIONS = {
    "unknown layout": (["--layout", "gird:3x3"], 2, 'there is no layout "gird:3x3"'),
    "grid without columns": (["--layout", "grid:0x3"], 2, 'there is no layout "grid:0x3"'),
    "grid too fine": (["--layout", "grid:101x3"], 2, "grid:101x3 has more than 100 points in a row"),
    "grid on a line": (["--layout", "grid:5x1"], 1, "lie on a line"),
    "grid of two": (["--layout", "grid:2x1"], 1, "2 points, an orientation needs at least 3"),
    "no such file": (["--layout", "nothing.csv"], 2, "nothing.csv: no such file"),
    "no such photo": (["--photo", "nothing.toml"], 2, "nothing.toml: no such file"),
    "f not a number": (["--f-mm", "nan"], 2, "--f-mm: nan mm is not in"),
    "f infinite": (["--f-mm", "inf"], 2, "--f-mm: inf mm is not in"),
    "frame of nothing": (["--frame-mm", "0", "230"], 2, "--frame-mm: 0 mm is not in"),
    "sigma zero": (["--sigma-um", "0"], 2, "--sigma-um: 0 um is not in"),
    "height negative": (["--height-m", "-5"], 2, "--height-m: -5 m is not in"),
    "height not a number": (["--height-m", "nan"], 2, "--height-m: nan m is not in"),
    "control sigma negative": (["--control-sigma-m", "-1"], 2, "--control-sigma-m: -1 m is not in"),
    "height sigma not a number": (["--height-sigma-m", "nan"], 2, "--height-sigma-m: nan m is not in"),
    "new height sigma negative": (["--ground-height-sigma-m", "-1"], 2, "--ground-height-sigma-m: -1 m is not in"),
    "tilt beyond the horizon": (["--tilt-deg", "120"], 2, "--tilt-deg: 120 degrees is not in"),
    "tilt puts points into the sky": (["--tilt-deg", "80"], 1, "ray of point 1 does not meet the ground"),
    "decimal sign": (["--decimal", "dot"], 2, '--decimal is "dot"'),
    "encoding": (["--encoding", "utf-99"], 2, 'encoding "utf-99" is not known'),
    "margin too wide": (["--margin-mm", "115"], 2, "--margin-mm: 115 mm leave nothing of the frame"),
}


@pytest.mark.parametrize(("options", "exit_code", "message"), BAD_OPTIONS.values(), ids=BAD_OPTIONS)
def test_bad_options_end_in_a_sentence(options: list[str], exit_code: int, message: str, folder: Path) -> None:
    error = run(*CAMERA, *options).exception
    assert isinstance(error, OrientError)
    assert message in error.message
    assert error.exit_code == exit_code


BAD_FILES = {
    "outside the frame": (
        "A,-100,90\nB,950,100\nC,1,2\n",
        'bad.csv:3: point "B" at 950, 100 mm lies outside the frame',
    ),
    "not a number": ("A,-100,90\nB,nan,100\nC,1,2\n", 'bad.csv:3: column "x_mm": "nan" is not a number'),
    "missing": ("A,-100,90\nB,,100\nC,1,2\n", 'bad.csv:3: column "x_mm": value is missing'),
    "twice": ("A,-100,90\nB,1,100\nA,1,2\n", 'bad.csv:4: point "A" was already given in line 2'),
    "without a name": ("A,-100,90\n,1,100\nC,1,2\n", "bad.csv:3"),
    "two points": ("A,-100,90\nB,1,100\n", "has 2 points"),
    "no points": ("", "bad.csv: no data lines"),
    "a line": ("A,-100,-100\nB,1,1\nC,100,100\n", "lie on a line"),
    "one place": ("A,-100,90\nB,1,100\nC,1,100\nD,80,-90\n", "Points B and C coincide"),
    "on the circle with the nadir": ("A,0,0\nB,50,0\nC,0,50\n", "does not determine the orientation"),
}


@pytest.mark.parametrize(("lines", "message"), BAD_FILES.values(), ids=BAD_FILES)
def test_bad_files_are_refused_by_line(lines: str, message: str, folder: Path) -> None:
    (folder / "bad.csv").write_text("point,x_mm,y_mm\n" + lines)
    error = run(*CAMERA, "--layout", "bad.csv").exception
    assert isinstance(error, OrientError)
    assert message in error.message
    assert error.exit_code == 1


def test_a_file_with_decimal_commas(folder: Path) -> None:
    (folder / "comma.csv").write_text("point;x_mm;y_mm;dZ_m\nA;-100,5;90;1,5\nB;95;100;\nC;-90;-95;0\nD;80;-90;0\n")
    refused = run(*CAMERA, "--layout", "comma.csv").exception
    assert isinstance(refused, OrientError)
    assert "decimal comma found" in refused.message
    read = json.loads(run(*CAMERA, "--layout", "comma.csv", "--decimal", "comma", "--json").output)
    assert [read["points"][0][key] for key in ("x_mm", "Z_m")] == [-100.5, pytest.approx(1.5)]


def test_all_problems_of_a_file_are_named_at_once(folder: Path) -> None:
    (folder / "bad.csv").write_text("point,x_mm,y_mm\nA,-100,900\nB,x,100\nC,1,200\n")
    error = run(*CAMERA, "--layout", "bad.csv").exception
    assert isinstance(error, OrientError)
    assert len(error.message.splitlines()) == 3


def test_a_layout_higher_than_the_camera_is_refused(folder: Path) -> None:
    (folder / "high.csv").write_text("point,x_mm,y_mm,dZ_m\nA,-100,90,2000\nB,95,100,30\nC,-90,-95,10\n")
    error = run(*CAMERA, "--layout", "high.csv").exception
    assert isinstance(error, OrientError)
    assert "ray of point A does not meet the ground" in error.message


def test_an_unknown_camera_says_what_is_missing() -> None:
    error = run("--height-m", "100", "--f-mm", "50").exception
    assert isinstance(error, OrientError)
    assert error.message == "the camera is not known: --frame-mm, --sigma-um missing"
    assert error.exit_code == 2


def test_control_codes_of_a_name_never_reach_the_terminal(folder: Path) -> None:
    (folder / "bad.csv").write_text("point,x_mm,y_mm\n\x1b[31mA,-100,90\nB,1,100\nC,1,2\n")
    result = run(*CAMERA, "--layout", "bad.csv")
    assert isinstance(result.exception, OrientError)
    assert "\x1b" not in result.exception.message
