"""`orient explain`: a student follows the page by hand to the printed digits, and it leads to the stored numbers."""

import json
import math
import re
import shutil
import sys
from pathlib import Path

import pytest

from tests.cli.commands import SAMPLES, orient

Matrix = dict[tuple[str, str], float]
NUMBER = re.compile(r"-?\d+(\.\d+)?(e[-+]\d+)?")
DIGITS = 8


def made(sample: str, folder: Path, *words: str) -> Path:
    path = folder / "p.sqlite"
    assert orient("new", path, "--from", SAMPLES / sample).code == 0
    assert orient("run", path).code == 0
    if words:
        assert orient("resection", path, *words).code == 0
    return path


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six unknowns, sixteen equations."""
    return made("calgary-28", tmp_path_factory.mktemp("plain"), "--interior", "fixed")


@pytest.fixture(scope="module")
def projects(tmp_path_factory: pytest.TempPathFactory, plain: Path) -> dict[str, Path]:
    home = tmp_path_factory.mktemp
    return {
        "fixed": plain,
        "interior": made("calgary-28", home("interior")),
        "sheets": made("simulated-space-krasovsky", home("sheets")),
        "camera": made("engabreen", home("camera"), "--estimate", "f,k1"),
        "moon": made("apollo15-metric-0585", home("moon")),
    }


def sections(text: str) -> dict[str, str]:
    """The numbered parts of a page, and each step of the reduction, by their first words."""
    parts = re.split(r"\n(?=\d\. |step \d+:)", text)
    return {re.match(r"(step \d+|\d)", part)[0]: part for part in parts[1:]}  # type: ignore[index]


def matrix(part: str, label_words: int = 1) -> Matrix:
    """Blocks of columns under their names; in a triangle the cells fill the row from the right."""
    found: Matrix = {}
    columns: list[str] = []
    for line in part.splitlines():
        words = line.split()
        if not words:
            columns = []
        elif not columns:
            columns = words if line.startswith(" ") else []
        elif len(words) > label_words:
            values = words[label_words:]
            if not all(NUMBER.fullmatch(value) for value in values):
                continue
            label = " ".join(words[:label_words])
            for column, value in zip(columns[len(columns) - len(values) :], values, strict=True):
                found[label, column] = float(value)
    return found


def names_of(found: Matrix) -> list[str]:
    return list(dict.fromkeys(column for _, column in found))


def same(printed: float, computed: float, digits: int = DIGITS, rounding: float = 0.0) -> bool:
    """Within one unit of the last printed digit, and the rounding of sums that cancel."""
    if computed == 0.0:
        return abs(printed) < 1e-30
    unit = 10.0 ** (math.floor(math.log10(abs(computed))) - digits + 1)
    return abs(printed - computed) <= unit + rounding


def assert_same(printed: Matrix, computed: Matrix) -> None:
    assert printed.keys() <= computed.keys()
    wrong = {key: (value, computed[key]) for key, value in printed.items() if not same(value, computed[key])}
    assert not wrong


@pytest.mark.parametrize("iteration", [1, 2, 3])
def test_a_student_follows_it_by_hand(plain: Path, iteration: int) -> None:
    """Products and sums of the printed numbers only: each next line within one unit of its last digit."""
    said = orient("explain", plain, "--iteration", iteration)
    assert said.code == 0, said.err
    parts = sections(said.out)
    equations, P = matrix(parts["2"].split("Weights P")[0], label_words=2), matrix(parts["2"].split("of a point:")[1])
    names = names_of(equations)
    assert names == ["r_E", "r_N", "r_U", "X_S", "Y_S", "Z_S", "l"]
    rows = list(dict.fromkeys(row for row, _ in equations))
    assert len(rows) == 16
    products = {
        (a, b): [
            weight(P, row, other) * equations[row, a] * equations[other, b]
            for row in rows
            for other in rows
            if row.split()[0] == other.split()[0]
        ]
        for i, a in enumerate(names)
        for b in names[i:]
    }
    printed = matrix(parts["4"])
    assert printed.keys() == products.keys()
    for key, terms in products.items():
        rounding = 4 * sys.float_info.epsilon * sum(map(abs, terms))
        assert same(printed[key], math.fsum(terms), rounding=rounding), key
    for k, name in enumerate(names[:-1]):
        after = matrix(parts[f"step {k + 1}"])
        pivot = math.sqrt(printed[name, name])
        wanted = {(name, name): pivot}
        wanted |= {(name, other): printed[name, other] / after[name, name] for other in names[k + 1 :]}
        below = names[k + 1 :]
        wanted |= {
            (a, b): printed[a, b] - after[name, a] * after[name, b] for i, a in enumerate(below) for b in below[i:]
        }
        assert after.keys() == wanted.keys()
        assert_same(after, wanted)
        printed = after
    assert_solution(parts, names, said.out)


def weight(P: Matrix, row: str, other: str) -> float:
    """p_xx, p_xy or p_yy of the point of both rows."""
    point, axes = row.split()[0], "".join(sorted(row.split()[1] + other.split()[1]))
    return P[point, f"p_{axes}"]


def assert_solution(parts: dict[str, str], names: list[str], text: str) -> None:
    R = {}
    for k, name in enumerate(names[:-1]):
        step = matrix(parts[f"step {k + 1}"])
        R |= {key: value for key, value in step.items() if key[0] == name}
    x = {
        words[0]: float(words[2])
        for words in map(str.split, parts["6"].splitlines())
        if len(words) == 3 and words[0] in names
    }
    for k in range(len(names) - 2, -1, -1):
        name, later = names[k], names[k + 1 : -1]
        assert same(x[name], -(R[name, "l"] + sum(R[name, other] * x[other] for other in later)) / R[name, name])
    before = {
        line.split()[0]: float(line.split()[-1])
        for line in parts["1"].splitlines()
        if line[:3] in ("X_S", "Y_S", "Z_S")
    }
    after = {
        line.split()[0]: float(line.split()[2])
        for line in text.split("7. Unknowns")[1].splitlines()
        if line[:3] in before
    }
    for name, value in before.items():
        assert same(after[name], value + x[name], digits=12)
    assert_rotation(parts, x)


def assert_rotation(parts: dict[str, str], x: dict[str, float]) -> None:
    """Rodrigues by hand: R + sin t/t [r]x R + (1 - cos t)/t^2 [r]x^2 R."""
    before, after = matrix(parts["1"]), matrix(parts["7"])
    e, n, u = x["r_E"], x["r_N"], x["r_U"]
    t = math.sqrt(e * e + n * n + u * u)
    S = [[0.0, -u, n], [u, 0.0, -e], [-n, e, 0.0]]
    S2 = [[sum(S[i][k] * S[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    for i, row in enumerate("ENU"):
        for column in "xyz":
            turned = sum(
                (float(i == j) + math.sin(t) / t * S[i][j] + (1 - math.cos(t)) / t**2 * S2[i][j])
                * before["ENU"[j], column]
                for j in range(3)
            )
            assert after[row, column] == pytest.approx(turned, abs=1e-11)  # cosines below 1, 12 digits printed


KINDS = ("fixed", "interior", "sheets", "camera", "moon")


@pytest.mark.parametrize("kind", KINDS)
def test_every_iteration_leads_to_the_stored_numbers(projects: dict[str, Path], kind: str) -> None:
    """x with all digits is what the program added: 1e-4 of the largest correction, as normal equations can."""
    path = projects[kind]
    current = json.loads(orient("sql", path, "current", "--json").out)
    (run,) = (row["run_id"] for row in current if row["stage"] == "resection")
    rows = json.loads(orient("sql", path, f"SELECT * FROM iteration_parameter WHERE run_id = {run}", "--json").out)
    count = max(row["iteration"] for row in rows)
    for k in range(1, count + 1):
        said = orient("explain", path, "-k", k, "--json")
        assert said.code == 0, said.err
        found = json.loads(said.out)
        own = {row["unknown"]: row for row in rows if row["iteration"] == k and row["point"] == ""}
        for name, before, after in zip(
            found["unknowns"][3:6], found["values"][:3], found["values_after"][:3], strict=True
        ):
            assert before == pytest.approx(own[name]["approximation"], abs=1e-9 * max(1, abs(before)))
            assert after == pytest.approx(
                own[name]["approximation"] + own[name]["correction"], abs=1e-9 * max(1, abs(after))
            )
        added = [after - before for before, after in zip(found["values"], found["values_after"], strict=True)]
        scale = max(abs(value) for value in added[:3]) + 1e-6
        assert found["x"][3:6] == pytest.approx(added[:3], abs=1e-4 * scale + 2e-9)  # 7e6 m end at 1e-9
        assert found["damping"] == 0
    assert found["iterations"] == count


def test_the_sum_of_squares_is_that_of_the_iteration(projects: dict[str, Path]) -> None:
    """l'Pl of image, film and camera together is the stored v'Pv, where no ground point was taken out: 1e-10."""
    for kind in ("fixed", "interior", "camera", "moon"):
        found = json.loads(orient("explain", projects[kind], "--json").out)
        assert found["has_unknown_ground"] is False
        assert found["normal"][-1][-1] == pytest.approx(found["vPv"], rel=1e-10)


def test_common_unknowns_and_ground_are_explained(projects: dict[str, Path]) -> None:
    interior = orient("explain", projects["interior"]).out
    assert "v = dc + c of the unknowns that all points share" in interior
    assert "step 12: the row of b2 is finished" in interior
    sheets = orient("explain", projects["sheets"]).out
    assert "The unknown ground coordinates dP are taken out point by point" in sheets
    assert "p_xx" in sheets
    assert "L_0_3 deg" in sheets
    moon = orient("explain", projects["moon"]).out
    assert "... and 209 more points (--json has all)" in moon
    assert "f mm" in orient("explain", projects["camera"], "-k", "9").out


@pytest.mark.parametrize("digits", [5, 12])
def test_digits_are_those_that_were_asked(plain: Path, digits: int) -> None:
    parts = sections(orient("explain", plain, "--digits", digits).out)
    found = matrix(parts["2"], label_words=2)
    longest = max(len(f"{abs(value):.17g}".replace(".", "").split("e")[0].lstrip("0")) for value in found.values())
    assert longest >= digits
    shown = re.findall(r"(?<=\s)-?\d[\d.]*(?:e[-+]\d+)?", parts["4"])
    significant = [len(re.sub(r"^-?0*\.?0*|e.*|\.", "", word)) for word in shown]
    assert max(significant) == digits


def test_lines_fit_eighty_columns(projects: dict[str, Path]) -> None:
    for kind, path in projects.items():
        longest = max(orient("explain", path).out.splitlines(), key=len)
        assert len(longest) <= 80, (kind, longest)


REFUSED = {
    "no such iteration": (("--iteration", "99"), 2, "there is no iteration 99"),
    "zero": (("--iteration", "0"), 2, "0"),
    "digits": (("--digits", "2"), 2, "2"),
    "absolute": (("absolute",), 2, "orient sql PROJECT absolute-equations"),
    "digitize": (("digitize",), 2, "orient sql PROJECT crosses"),
    "a list": (("control",), 2, "It has no iterations."),
    "no stage": (("bundle",), 2, 'there is no stage "bundle"'),
    "no version": (("--version", "9"), 2, "resection has no version 9"),
}


@pytest.mark.parametrize(("words", "code", "message"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused(plain: Path, words: tuple[str, ...], code: int, message: str) -> None:
    said = orient("explain", plain, *words)
    assert (said.code, message in said.err, said.out) == (code, True, ""), said.err


def test_before_the_first_run(fresh: Path) -> None:
    said = orient("explain", fresh)
    assert (said.code, "resection has no current version" in said.err) == (2, True)
    assert "Run: orient run" in said.err


def test_an_old_version_is_explained_by_its_own_inputs(aerial: Path) -> None:
    """Version 1 read the first list of control; a new list changes nothing on its page."""
    page = orient("explain", aerial, "--version", "1").out
    control = aerial.parent / "control.csv"
    lines = (SAMPLES / "calgary-28" / "control.csv").read_text().splitlines()
    control.write_text("\n".join(lines[:-1]) + "\n")
    shutil.copy(SAMPLES / "calgary-28" / "control.toml", aerial.parent / "control.toml")
    assert orient("add", aerial, "control", control, aerial.parent / "control.toml", "-m", "one less").code == 0
    assert orient("run", aerial).code == 0
    assert orient("explain", aerial, "--version", "1").out == page
    assert "7 control points" in orient("explain", aerial).out


def test_the_page_of_the_documentation_is_the_real_one(plain: Path) -> None:
    page = (SAMPLES.parent / "docs" / "explain.md").read_text("utf-8").split("```\n")[-2]
    assert orient("explain", plain, "--iteration", "2", "--digits", "7").out == page
