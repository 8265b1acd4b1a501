"""`orient absolute`: its options, what it shows, and one clear sentence for each kind of bad control."""

import csv
import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from orient.store.project import open_project
from tests.cli.commands import MODEL, orient

WIDTH = 80
LOCAL_PHOTO = """
[photo]
name = "model"
platform = "aerial"
[camera]
f_mm = 150.0
frame_mm = [230.0, 230.0]
sigma_image_mm = 0.005
[ground]
local = "HAND"
"""
GEOGRAPHIC_PHOTO = LOCAL_PHOTO.replace('local = "HAND"', 'ellipsoid = "wgs84"')
Xyz = tuple[float, float, float]
BLOCK: dict[str, Xyz] = {
    "P1": (1000.0, 2000.0, 150.0), "P2": (1900.0, 2100.0, 320.0), "P3": (1800.0, 2900.0, 210.0),
    "P4": (1050.0, 2800.0, 410.0), "P5": (1450.0, 2500.0, 90.0), "P6": (1200.0, 2450.0, 260.0),
}  # fmt: skip
"""Ground of a small right-handed block [m]; its model is a tenth of it, turned by a right angle."""


def in_model(place: Xyz) -> Xyz:
    x, y, z = place
    return (y / 10, -x / 10, z / 10)


def made(
    folder: Path,
    ground: dict[str, Sequence[object]],
    model: dict[str, Sequence[object]],
    photo: str = LOCAL_PHOTO,
    hand: str = "right",
    columns: str = "point,X_m,Y_m,Z_m",
) -> Path:
    """A project of a model in zone A and its control, before the first run."""
    source = folder / "source"
    source.mkdir()
    (source / "photo.toml").write_text(photo.replace("HAND", hand))
    _write(source / "control.csv", columns, [(name, *place) for name, place in ground.items()])
    if photo == LOCAL_PHOTO:
        (source / "control.toml").write_text(f'[control]\nlocal = "{hand}"\n')
    if model:
        _write(source / "model.csv", "zone,point,x,y,z", [("A", name, *place) for name, place in model.items()])
    path = folder / "p.sqlite"
    said = orient("new", path, "--from", source)
    assert (said.code, said.err) == (0, "")
    return path


def _write(path: Path, header: str, rows: Sequence[Sequence[object]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([header.split(","), *rows])


def modelled(ground: dict[str, Xyz]) -> dict[str, Xyz]:
    return {name: in_model(place) for name, place in ground.items()}


def given(kinds: str) -> dict[str, Sequence[object]]:
    """The block's points as full (f), plan-only (p) or height-only (h) control."""
    cells: dict[str, Callable[[Xyz], Sequence[object]]] = {
        "f": lambda xyz: xyz,
        "p": lambda xyz: (xyz[0], xyz[1], ""),
        "h": lambda xyz: ("", "", xyz[2]),
    }
    return {name: cells[kind](place) for kind, (name, place) in zip(kinds, BLOCK.items(), strict=False)}


def settings_of(path: Path) -> dict[str, object]:
    with open_project(path) as project:
        return dict(project.heads()["absolute"].settings)


def test_a_small_block_is_oriented(tmp_path: Path) -> None:
    path = made(tmp_path, BLOCK, modelled(BLOCK))
    said = orient("run", path)
    assert said.code == 0, said.err
    assert re.search(r"absolute +version 1 +zone A: 6 full, t = 10, sigma0 \S+ m, r = 11", said.out)
    rows = json.loads(orient("sql", path, "absolute-elements", "--json").out)
    values = {(row["view"], row["element"]): row["value"] for row in rows}
    assert values["homothety", "H"] == pytest.approx(0.1, rel=1e-12)
    assert values["scale", "theta"] == pytest.approx(90.0, abs=1e-9)


def test_settings_stay_until_they_are_taken_back(model: Path) -> None:
    assert orient("absolute", model, "--control", "fixed", "--variance", "priori", "--engine", "qr").code == 0
    assert orient("absolute", model, "--sigma-model", "0.01").code == 0
    assert settings_of(model) | {"sigma_model": 0.01, "control": "fixed", "engine": "qr"} == settings_of(model)
    assert orient("absolute", model, "--sigma-model", "none", "--control", "auto").code == 0
    assert settings_of(model) | {"sigma_model": None, "control": "auto", "engine": "qr"} == settings_of(model)


def test_both_engines_give_the_same_numbers(model: Path) -> None:
    assert orient("absolute", model, "--engine", "qr").code == 0
    found = {}
    for version in (1, 2):
        shown = json.loads(orient("show", model, "absolute", "--version", version, "--json").out)
        found[version] = [(row["value"], row["sigma"]) for row in shown["tables"]["absolute_element"]]
    for one, other in zip(found[1], found[2], strict=True):
        assert one == pytest.approx(other, rel=1e-9)


def test_show_answers_a_person_in_80_columns(model: Path) -> None:
    assert orient("absolute", model, "--small-angles").code == 0
    lines = orient("show", model, "absolute").out.splitlines()
    text = "\n".join(lines)
    for words in (
        "Zone west: 5 full, 2 plan-only, 3 height-only", "redundancy r = 15", "X_G = R x/H + X0 (2')",
        "X_G = (R x + T)/H (4')", "X_G = X0 + t R x (108)", "Residuals: computed minus given", "Iterations",
        "Small-angle formulas (111) beside the rigorous", "Model points on the ground",
    ):  # fmt: skip
        assert words in text
    tables = [line for line in lines[4:] if not line.strip().startswith(("note", "warning"))]
    assert max(map(len, tables)) <= WIDTH


def test_two_solutions_are_shown(tmp_path: Path) -> None:
    path = made(tmp_path, given("ffh"), modelled(BLOCK))
    said = orient("run", path)
    assert said.code == 0, said.err
    assert "a second orientation, tilted by" in said.out and "no redundancy" in said.out
    shown = orient("show", path, "absolute").out
    assert "Other orientations in which the adjustment converged" in shown
    assert "no redundancy: unknown" in shown


def test_a_failed_zone_keeps_its_iterations(tmp_path: Path) -> None:
    path = made(tmp_path, given("ffffff"), {name: (x, y, 2 * z) for name, (x, y, z) in modelled(BLOCK).items()})
    orient("run", path)
    said = orient("absolute", path, "--max-iterations", "1")
    assert said.code == 1
    assert said.err.startswith("orient: absolute: zone A: MAX_ITERATIONS: ")
    shown = orient("show", path, "absolute", "--version", 2).out
    assert "FAILED, this is not a result" in shown and "Iterations" in shown


def test_log_diff_and_check_know_the_stage(model: Path) -> None:
    assert orient("absolute", model, "--control", "fixed", "-m", "without its errors").code == 0
    assert "without its errors" in orient("log", model).out
    found = orient("diff", model, "absolute", 1, 2).out
    assert "absolute_orientation" in found and "control" in found and "Also" in found
    assert "is sound" in orient("check", model).out


def test_a_project_without_a_model_waits_for_nothing(aerial: Path) -> None:
    assert "absolute" not in orient("run", aerial).out
    assert "absolute" not in orient("status", aerial).out
    said = orient("absolute", aerial)
    assert said.code == 1
    assert (
        said.err
        == "orient: absolute waits for model\n        Add the list model: orient add PROJECT model FILE -m why\n"
    )


def test_a_model_without_control_says_what_it_waits_for(tmp_path: Path) -> None:
    path = made(tmp_path, BLOCK, {})
    (tmp_path / "only").mkdir()
    for name in ("photo.toml", "model.csv"):
        (tmp_path / "only" / name).write_text((MODEL / name).read_text("utf-8"))
    alone = tmp_path / "alone.sqlite"
    orient("new", alone, "--from", tmp_path / "only")
    assert "absolute" in orient("status", alone).out
    assert "absolute" not in orient("status", path).out
    assert orient("absolute", alone).err.startswith("orient: absolute waits for topocentric\n")
    for words, project in ((("absolute",), "PROJECT"), (("show", "absolute"), alone), (("export", "opk"), alone)):
        said = orient(words[0], alone, *words[1:], *(["-o", "-"] if words[0] == "export" else []))
        wanted = "readings" if words[0] == "export" else "control"
        assert f"Add the list {wanted}: orient add {project} {wanted} FILE -m why" in said.err


LINE: dict[str, Xyz] = {f"L{k}": (1000.0 + 200 * k, 2000.0 + 100 * k, 50.0 + 5 * k) for k in range(5)}
PLANE_LINE: dict[str, Xyz] = {"A": (0.0, 0.0, 10.0), "B": (1000.0, 0.0, 60.0), "C": (400.0, 0.0, 90.0)}
FLAT: dict[str, Xyz] = {name: (x, y, 100.0) for name, (x, y, _) in BLOCK.items()}
BAD: dict[str, tuple[dict[str, Sequence[object]], dict[str, Xyz], str, str]] = {
    "no control in the zone": (
        BLOCK, {"Q1": (1.0, 2.0, 3.0), "Q2": (4.0, 2.0, 1.0), "Q3": (0.0, 5.0, 9.0)}, "right",
        "zone A: 0 full, 0 plan-only and 0 height-only control points give 0 equations",
    ),
    "two points": (
        given("ff"), modelled(BLOCK), "right",
        "give 6 equations; the absolute orientation has 7 unknowns\n",
    ),
    "heights only": (given("hhhhhh"), modelled(BLOCK), "right", "0 full, 0 plan-only and 6 height-only"),
    "plan only": (given("pppppp"), modelled(BLOCK), "right", "without any height Z_0 is not determined"),
    "on one line": (LINE, modelled(LINE), "right", "lie on one line: the model can turn about it"),
    "in a vertical plane": (
        {"A": PLANE_LINE["A"], "B": PLANE_LINE["B"], "C": ("", "", 90.0)}, modelled(PLANE_LINE), "right",
        "in the vertical plane through A, B lies every other height (C): the model can turn about that line",
    ),
    "two heights on a flat model": (
        {**{name: (x, y, "") for name, (x, y, _) in FLAT.items()}, "P1": FLAT["P1"], "P2": FLAT["P2"]},
        modelled(FLAT), "right", "three heights are needed where there are 2",
    ),
    "mirrored": (BLOCK, modelled(BLOCK), "left", "MIRRORED: The control fits the mirrored model"),
    "exchanged on flat ground": (
        {name: (y, x, z) for name, (x, y, z) in FLAT.items()}, modelled(FLAT), "right",
        "MIRRORED: On this flat control the best fit turns the model upside down",
    ),
    "far too small": (
        {name: (x / 1e6, y / 1e6, z / 1e6) for name, (x, y, z) in BLOCK.items()}, modelled(BLOCK), "right",
        "numbers up to 7e+15 cannot be kept",
    ),
    "names exchanged": (
        {**BLOCK, "P1": BLOCK["P2"], "P2": BLOCK["P1"]}, modelled(BLOCK), "right", "MIRRORED: On this flat control",
    ),
    "huge": (
        {name: (9e7 + x, -9e7 + y, z) for name, (x, y, z) in LINE.items()}, modelled(LINE), "right", "lie on one line",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_control_is_one_clear_sentence(tmp_path: Path, case: str) -> None:
    ground, model, hand, words = BAD[case]
    path = made(tmp_path, ground, model, hand=hand)
    said = orient("run", path)
    assert said.code == 1
    assert said.err.startswith("orient: absolute: zone A: ")
    assert words.lower() in said.err.lower()
    assert len(said.err.splitlines()) == 2
    assert "absolute" in orient("status", path).out and "failed" in orient("status", path).out


def test_an_upside_down_model_is_allowed_when_asked(tmp_path: Path) -> None:
    ground = {name: (x, y, 100.0 + 0.01 * z) for name, (x, y, z) in BLOCK.items()}
    under = {name: (x / 10, -y / 10, -z / 10) for name, (x, y, z) in ground.items()}
    path = made(tmp_path, ground, under)
    said = orient("run", path)
    assert said.code == 0, said.err
    assert "warning: zone A: the model's Z axis points down on the ground" in said.out
    flat = {name: (x / 10, -y / 10, -10.0) for name, (x, y, _) in FLAT.items()}
    (tmp_path / "flat").mkdir()
    other = made(tmp_path / "flat", FLAT, flat)
    assert "--upside-down" in orient("run", other).err
    assert orient("absolute", other, "--upside-down").code == 0


def test_one_place_for_all_points_is_refused(tmp_path: Path) -> None:
    ground = {**BLOCK, "P7": BLOCK["P1"]}
    twice = made(tmp_path, ground, modelled(ground))
    assert orient("run", twice).code == 0
    (tmp_path / "one").mkdir()
    far = {f"Q{k}": (1.0 + k, 2.0 * k, 3.0) for k in range(4)}
    same = made(tmp_path / "one", {**BLOCK, **far}, {**dict.fromkeys(BLOCK, (1.0, 2.0, 3.0)), "Z": (9.0, 9.0, 9.0)})
    said = orient("run", same)
    assert said.code == 1
    assert "absolute: zone A: All control points lie in one place in the model" in said.err


def test_degrees_for_metres_do_not_pass_silently(tmp_path: Path) -> None:
    """Local control in degrees: a hundred thousand times too small in plan, so that nothing fits."""
    ground = {name: (42.0 + x / 111e3, 24.0 + y / 83e3, z) for name, (x, y, z) in BLOCK.items()}
    path = made(tmp_path, ground, modelled(BLOCK))
    said = orient("run", path)
    assert said.code == 1
    assert re.search(r"absolute: zone A: NO_FIT: .*\(rms\).*degrees for metres", said.err, re.DOTALL)


@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf", "1e400", "x", ""])
def test_a_sigma_that_is_none_is_wrong_use(model: Path, value: str) -> None:
    said = orient("absolute", model, f"--sigma-model={value}")
    assert said.code == 2
    assert "is not none or a number between" in said.err


def test_a_model_with_half_its_covariances_asks_for_the_rest(tmp_path: Path) -> None:
    source = tmp_path / "half"
    source.mkdir()
    for file in MODEL.glob("*.toml"):
        (source / file.name).write_text(file.read_text("utf-8"))
    (source / "control.csv").write_text((MODEL / "control.csv").read_text("utf-8"))
    lines = (MODEL / "model.csv").read_text("utf-8").splitlines()
    lines[1] = ",".join(lines[1].split(",")[:5]) + ",,,,,,"
    (source / "model.csv").write_text("\n".join(lines) + "\n")
    path = tmp_path / "p.sqlite"
    assert orient("new", path, "--from", source).code == 0
    said = orient("run", path)
    assert said.code == 1
    assert 'model point "W01" of zone "west" has no standard deviation, but others have' in said.err
    assert "--sigma-model" in said.err
    assert orient("absolute", path, "--sigma-model", "0.005").code == 0
