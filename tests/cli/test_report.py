"""`orient report`: all its parts, nothing active, the same bytes everywhere, and numbers that agree with the file."""

import base64
import hashlib
import json
import math
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.commands import AERIAL, ENTRY, ROOT, SAMPLES, orient, orient_process, without
from tests.cli.report_page import HOSTILE, Page, hostile_project, report

ADJUSTED = ["findings", "meaning", "photo", "orientation", "residuals", "reliability", "accuracy", "budget"]
PDF_DEADLINE_S = 300
FINAL = ["iterations", "formulas", "provenance"]
PARTS = {
    "aerial": [*ADJUSTED, "image", *FINAL],
    "space": [*ADJUSTED, "sheets", "image", *FINAL],
    "model": ["findings", "photo", "reliability", "absolute", "formulas", "provenance"],
    "fresh": ["findings", "photo", "provenance"],
    "failed": ["findings", "photo", "image", "iterations", "formulas", "provenance"],
}


@pytest.fixture
def failed(fresh: Path) -> Path:
    """An adjustment that was not allowed to converge: no result, but its iterations."""
    for stage in ("refine", "bl", "topocentric"):
        assert orient(stage, fresh).code == 0
    assert orient("resection", fresh, "--max-iterations", "2").code == 1
    return fresh


@pytest.fixture
def page(request: pytest.FixtureRequest) -> Page:
    return report(request.getfixturevalue(request.param))


def sql(path: Path, question: str) -> list[dict[str, float]]:
    return json.loads(orient("sql", path, question, "--json").out)


@pytest.mark.parametrize(("page", "parts"), PARTS.items(), ids=PARTS, indirect=["page"])
def test_the_page_has_all_its_parts_and_nothing_active(page: Page, parts: list[str]) -> None:
    sections = [attributes["id"] for tag, attributes in page.tags if tag == "section"]
    assert sections == parts
    assert page.problems == []
    assert page.active == []
    identifiers = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(identifiers) == len(set(identifiers))
    links = [attributes["href"] for _, attributes in page.tags if attributes.get("href")]
    assert [link for link in links if link[1:] not in identifiers] == []
    assert [title for title, rows in page.tables.items() if len({len(row) for row in rows}) != 1] == []


def test_the_policy_allows_nothing_but_the_style_of_the_page(aerial: Path) -> None:
    page = report(aerial)
    (policy,) = [
        a["content"] for tag, a in page.tags if tag == "meta" and a.get("http-equiv") == "Content-Security-Policy"
    ]
    digest = base64.b64encode(hashlib.sha256(page.style.encode()).digest()).decode()
    assert policy == f"default-src 'none'; style-src 'sha256-{digest}'; base-uri 'none'; form-action 'none'"
    assert re.findall(r"https?:|//|@import|url\(", page.style) == []


def test_findings_come_before_any_number(aerial: Path) -> None:
    text = report(aerial).text
    assert text.index("A gross error is suspected") < text.index("What is good?") < text.index("10.899")
    assert "Look at the point first" in text


def test_names_that_are_markup_stay_names(tmp_path: Path) -> None:
    path = hostile_project(tmp_path)
    page = report(path)
    assert page.active == []
    assert page.problems == []
    for name in HOSTILE[:7]:
        assert name in page.text, name
    assert "a\\u202eb\\u200bc" in page.text
    assert page.text.count(HOSTILE[3]) >= 1, "the reason of the exclusion"
    svg = orient("plot", path, "residuals", "-o", "-").out
    assert not re.findall(r"<(script|img|image|foreignObject)", re.sub(r"<!--.*?-->", "", svg, flags=re.DOTALL))


@pytest.mark.parametrize("language", ["en", "uk"])
def test_the_same_project_gives_the_same_bytes_in_every_process(space: Path, tmp_path: Path, language: str) -> None:
    surroundings = (
        {"PYTHONHASHSEED": "1", "TZ": "America/New_York", "LC_ALL": "C", "LANG": "C"},
        {"PYTHONHASHSEED": "77", "TZ": "Asia/Tokyo", "LC_ALL": "C.UTF-8", "COLUMNS": "40", "MPLBACKEND": "TkAgg"},
    )
    copy = Path(shutil.copy(space, tmp_path / "another name.sqlite"))
    first, second = (tmp_path / f"{name}.html" for name in "ab")
    for source, target, env in zip((space, copy), (first, second), surroundings, strict=True):
        said = orient_process("report", source, "-o", target, "--language", language, env=env)
        assert (said.code, said.err) == (0, "")
    assert first.read_bytes() == second.read_bytes()
    assert str(tmp_path) not in first.read_text("utf-8")


def test_pdf(failed: Path, tmp_path: Path) -> None:
    """Two processes make the same file; it has pages, text in it, and no date."""
    pytest.importorskip("weasyprint", reason="orient[pdf] is not installed", exc_type=ImportError)
    first, second = (tmp_path / f"{name}.pdf" for name in "ab")
    for target, seed in ((first, "1"), (second, "2")):
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": seed, "TZ": f"UTC{seed}"}
        command = [sys.executable, "-c", ENTRY, "report", failed, "-o", target, "--language", "bg"]
        subprocess.run(command, env=environment, check=True, timeout=PDF_DEADLINE_S)
    content = first.read_bytes()
    assert content == second.read_bytes()
    assert content.startswith(b"%PDF-")
    assert b"CreationDate" not in content
    if shutil.which("pdftotext"):
        read = subprocess.run(["pdftotext", "-layout", first, "-"], capture_output=True, text=True, check=True).stdout
        for words in ("Отчет за ориентирането", "Итерации", "Произход", "MAX_ITERATIONS"):
            assert words in read


# ---------------------------------------------------------------------------------------------- numbers


def test_the_orientation_with_its_covariance_is_that_of_the_file(space: Path) -> None:
    """Covariance = variance_scale x Q, in every convention with the sigmas that the file holds for its angles."""
    page = report(space)
    stored = sql(
        space,
        "SELECT c.IJ, c.i, c.j, c.value * o.variance_scale AS k FROM cofactor AS c JOIN orientation AS o USING "
        "(run_id) "
        "WHERE unknowns = 'aok' ORDER BY IJ",
    )
    shown = page.table("Covariance matrix: aok, ground")
    for row in stored:
        assert float(shown[int(row["i"])][int(row["j"])]) == pytest.approx(row["k"], rel=6e-5, abs=1e-16)
        assert shown[int(row["i"])][int(row["j"])] == shown[int(row["j"])][int(row["i"])]
    sigmas = sql(space, "SELECT triple, frame, angle, sigma_deg FROM orientation_angle")
    letters = {"alpha": "α", "omega": "ω", "phi": "φ", "kappa": "κ"}
    for row in sigmas:
        lines = page.table(f"Standard deviations and correlations: {row['triple']}, {row['frame']}")
        (line,) = [line for line in lines if line[0] == letters[str(row["angle"])]]
        # five digits are shown
        assert math.degrees(float(line[1])) == pytest.approx(row["sigma_deg"], rel=2e-5)


def test_a_turn_of_the_axes_keeps_the_uncertainty_of_the_station(space: Path) -> None:
    """The trace of the station's covariance is the same in T' and in geocentric axes."""
    page = report(space)
    traces = []
    for axes, first in (("ground", "X_S"), ("geocentric", "X_G")):
        rows = page.table(f"Standard deviations and correlations: opk, {axes}")
        start = [row[0] for row in rows].index(first)
        traces.append(sum(float(row[1]) ** 2 for row in rows[start : start + 3]))
    assert traces[0] == pytest.approx(traces[1], rel=1e-4)


def test_correlations_of_an_estimated_camera(tmp_path: Path) -> None:
    """What a regulator asks for: standard deviations and the correlation matrix of the camera's elements."""
    path = tmp_path / "p.sqlite"
    for words in (
        ("new", path, "--from", SAMPLES / "engabreen"),
        ("run", path),
        ("resection", path, "--calibrate", "auto"),
    ):
        assert orient(*words).code == 0
    page = report(path)
    rows = page.table("Estimated camera with standard deviations")
    assert [row[0] for row in rows] == ["element", "f", "k1"]
    correlations = page.table("Standard deviations and correlations: small rotation")
    assert correlations[0] == ["", "σ", "r_E", "r_N", "r_U", "X_S", "Y_S", "Z_S", "f", "k1"]
    scaled = "c.value / sqrt(a.value * b.value)"
    question = (
        f"SELECT {scaled} AS r FROM cofactor AS c JOIN cofactor AS a ON a.run_id = c.run_id AND a.unknowns = "
        f"c.unknowns "
        "AND a.i = c.i AND a.j = c.i JOIN cofactor AS b ON b.run_id = c.run_id AND b.unknowns = c.unknowns AND b.i = "
        "c.j "
        "AND b.j = c.j WHERE c.unknowns = 'rotation' AND c.unknown_i = 'f' AND c.unknown_j = 'k1' "
        "AND c.run_id = (SELECT max(run_id) FROM orientation)"
    )
    assert float(correlations[7][9]) == pytest.approx(sql(path, question)[0]["r"], abs=5e-5)
    assert float(correlations[7][1]) == pytest.approx(0.0234, abs=5e-5)


def test_each_rms_and_sigma0_states_its_divisor(aerial: Path) -> None:
    rows = {row[0]: row for row in report(aerial).table("RMS and σ0 of this report")}
    (found,) = sql(aerial, "SELECT sqrt(avg(vx_mm * vx_mm)) AS rms, count(*) AS n FROM v_residual WHERE is_current")
    assert rows["RMS v_x, control"][1:3] == ["√(Σv²/n)", f"n = {found['n']}"]
    assert float(rows["RMS v_x, control"][4].removesuffix(" µm")) == pytest.approx(1000 * found["rms"], rel=1e-4)
    (whole,) = sql(aerial, "SELECT n_equations AS n, n_unknowns AS u, redundancy AS r, vPv FROM orientation")
    sigma0 = rows["σ0 of the orientation"]
    assert sigma0[2] == f"r = {whole['n']} − {whole['u']} = {whole['r']}"
    assert float(sigma0[4].removesuffix(" µm")) == pytest.approx(1000 * math.sqrt(whole["vPv"] / whole["r"]), rel=1e-5)


def test_a_residual_is_told_in_the_image_in_pixels_and_on_the_ground(aerial: Path) -> None:
    head, *rows = report(aerial).table("Control points: residuals")
    (stored,) = sql(
        aerial,
        "SELECT point, vx_mm, vy_mm, depth_m, pixel_size_mm, f_mm FROM image_residual JOIN photo "
        "ORDER BY vx_mm * vx_mm + vy_mm * vy_mm DESC LIMIT 1",
    )
    shown = dict(zip(head, rows[0], strict=True))
    length = math.hypot(stored["vx_mm"], stored["vy_mm"])
    assert shown["point"] == stored["point"]
    assert float(shown["|v|, µm"]) == pytest.approx(1000 * length, abs=0.006)
    assert float(shown["|v|, px"]) == pytest.approx(length / stored["pixel_size_mm"], rel=5e-3)
    assert float(shown["|v| across the ray, m"]) == pytest.approx(length * stored["depth_m"] / stored["f_mm"], rel=5e-3)


def test_the_parameters_and_digests_of_every_version_are_listed(space: Path) -> None:
    page = report(space)
    parameters = page.table("Parameters of every version")
    question = (
        "SELECT stage, version, settings, input_digest, output_digest FROM v_current "
        "JOIN stage_run USING (run_id, stage, version) JOIN run_seal USING (run_id)"
    )
    for run in sql(space, question):
        assert str(run["input_digest"]) in page.text
        assert str(run["output_digest"]) in page.text
        shown = {row[1] for row in parameters if row[0] == f"{run['stage']} {run['version']}"}
        assert shown == set(json.loads(str(run["settings"])))


def test_a_stale_result_is_shown_with_its_own_inputs_and_says_so(aerial: Path) -> None:
    """A new photo changes nothing in the report of the orientation that was computed from the old one."""
    folder = aerial.parent / "changed"
    shutil.copytree(AERIAL, folder)
    toml = (folder / "photo.toml").read_text("utf-8").replace("153.358", "153.9")
    (folder / "photo.toml").write_text(toml, "utf-8")
    assert orient("add", aerial, "photo", folder / "photo.toml", "-m", "another camera").code == 0
    page = report(aerial)
    assert "The result is out of date" in page.text
    assert "153.358" in page.text
    assert "153.9" not in page.text


def test_a_large_list_is_cut_with_the_worst_on_top(tmp_path: Path) -> None:
    path = tmp_path / "p.sqlite"
    assert orient("new", path, "--from", SAMPLES / "apollo15-metric-0585").code == 0
    assert orient("run", path).code == 0
    page = report(path)
    head, *rows = page.table("Control points: residuals")
    assert len(rows) == 50
    assert "The 50 largest of 219 are shown." in page.text
    column = head.index("|v|, µm")
    sizes = [float(row[column]) for row in rows]
    assert sizes == sorted(sizes, reverse=True)


# ---------------------------------------------------------------------------------------------- the command


REFUSED = {
    "exists": ("there.html", (), "there.html exists"),
    "ending": ("x.txt", (), "the name of a report ends in .html or .pdf"),
    "folder": ("no/x.html", (), "does not exist"),
    "itself": ("photo.sqlite", ("--force",), "the name of a report ends in .html or .pdf"),
    "language": ("x.html", ("--language", "xx"), 'there is no language "xx"'),
}


@pytest.mark.parametrize(("name", "options", "message"), REFUSED.values(), ids=REFUSED)
def test_outputs_that_are_refused(aerial: Path, name: str, options: tuple[str, ...], message: str) -> None:
    (aerial.parent / "there.html").write_text("mine")
    before = sorted(file.name for file in aerial.parent.iterdir())
    said = orient("report", aerial, "-o", aerial.parent / name, *options)
    assert said.code == 2
    assert message in said.err
    assert sorted(file.name for file in aerial.parent.iterdir()) == before
    assert (aerial.parent / "there.html").read_text() == "mine"


MISSING = {
    "jinja2": ("x.html", ("report",), "the report needs jinja2, which is not installed", "report"),
    "babel": ("x.html", ("report",), "the report needs babel, which is not installed", "report"),
    "matplotlib": ("x.html", ("report",), "the report needs matplotlib, which is not installed", "report"),
    "weasyprint": ("x.pdf", ("report",), "the report needs weasyprint, which is not installed", "pdf"),
}


@pytest.mark.parametrize(("library", "case"), MISSING.items(), ids=MISSING)
def test_without_a_library_it_is_said_what_to_install(
    aerial: Path, library: str, case: tuple[str, tuple[str, ...], str, str]
) -> None:
    name, command, message, extra = case
    said = without(library, *command, aerial, "-o", aerial.parent / name)
    assert said.returncode == 2
    assert said.stderr.splitlines() == [f"orient: {message}", f"        Install it: pip install 'orient[{extra}]'"]


def test_the_command_loads_nothing_before_it_is_needed() -> None:
    code = (
        "import sys, orient.cli.report, orient.cli.command_line;"
        "print(sorted({'numpy', 'jinja2', 'babel', 'matplotlib', 'weasyprint', 'sqlalchemy'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
