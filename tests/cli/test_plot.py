"""`orient plot` and `orient show covariance`: pictures that are the same at every run, and files that are not lost."""

import os
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.cli.commands import in_process, orient, orient_process, without

PLOTS = ("accuracy", "budget", "ellipses", "iterations", "residuals", "sheet")
STARTS = {"svg": b"<?xml", "png": b"\x89PNG"}
SVG = "{http://www.w3.org/2000/svg}"


@pytest.mark.parametrize("format_name", STARTS)
@pytest.mark.parametrize("plot", PLOTS)
def test_each_plot_is_the_same_at_every_run(space: Path, plot: str, format_name: str) -> None:
    first, second = (space.parent / f"{name}.{format_name}" for name in "ab")
    for path in (first, second):
        assert (orient("plot", space, plot, "-o", path).code, path.stat().st_mode & 0o777) == (0, 0o600)
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(STARTS[format_name])
    assert sorted(file.name for file in space.parent.iterdir()) == sorted([space.name, first.name, second.name])


def test_a_process_of_its_own_draws_the_same(aerial: Path) -> None:
    """No identifier depends on the process; the SVG holds no script, no image and no outside address."""
    said = [orient_process("plot", aerial, "accuracy", "-o", "-", env={"MPLBACKEND": "TkAgg"}) for _ in range(2)]
    assert (said[0].code, said[0].err) == (0, "")
    assert said[0].out == said[1].out
    tree = ElementTree.fromstring(said[0].out)
    assert not {element.tag for element in tree.iter()} & {f"{SVG}script", f"{SVG}image", f"{SVG}foreignObject"}
    links = [value for element in tree.iter() for key, value in element.attrib.items() if key.endswith("href")]
    assert [link for link in links if not link.startswith("#")] == []


def test_every_point_is_drawn(aerial: Path) -> None:
    """The eight points of the sample are named, and the best and worst place told."""
    svg = orient("plot", aerial, "accuracy", "-o", "-").out
    for text in ("100", "203", "8 control points", "best", "worst", "sigma, m", "x, mm"):
        assert text in svg, text
    residuals = orient("plot", aerial, "residuals", "-o", "-").out
    assert "computed minus measured" in residuals
    assert "times)" in residuals
    assert "semi-axis" in orient("plot", aerial, "ellipses", "-o", "-").out


def test_the_budget_names_its_sources_and_every_point(space: Path) -> None:
    svg = orient("plot", space, "budget", "-o", "-").out
    for text in ("digitiser", "image readings", "heights", "interior orientation", "P01", "P36", "median", "95 %"):
        assert text in svg, text
    assert "map graticule" not in svg


REFUSED = {
    "exists": ("there.svg", "there.svg exists", "Use --force, or give another name."),
    "a link": ("link.svg", "link.svg exists", "Use --force, or give another name."),
    "a folder": ("folder.svg", "folder.svg is not a file", "Give the name of a file."),
    "missing folder": ("no/x.svg", "does not exist", "Create it first."),
    "other format": ("x.jpg", "the name of a picture ends in .svg or .png", ""),
    "no name": ("", "the name of a picture ends in .svg or .png", ""),
}


@pytest.mark.parametrize(("name", "message", "hint"), REFUSED.values(), ids=REFUSED)
def test_outputs_that_are_refused(aerial: Path, name: str, message: str, hint: str) -> None:
    folder = aerial.parent
    (folder / "there.svg").write_text("mine")
    (folder / "link.svg").symlink_to(folder / "there.svg")
    (folder / "folder.svg").mkdir()
    before = sorted(file.name for file in folder.iterdir())
    said = orient("plot", aerial, "residuals", "-o", folder / name if name else "")
    assert said.code == 2
    assert message in said.err
    assert hint in said.err
    assert sorted(file.name for file in folder.iterdir()) == before
    assert (folder / "there.svg").read_text() == "mine"


def test_force_replaces_the_link_and_not_what_it_points_at(aerial: Path) -> None:
    target, link = aerial.parent / "letter.txt", aerial.parent / "plot.svg"
    target.write_text("mine")
    link.symlink_to(target)
    assert orient("plot", aerial, "residuals", "-o", link, "--force").code == 0
    assert target.read_text() == "mine"
    assert not link.is_symlink()
    assert link.read_bytes().startswith(STARTS["svg"])


@pytest.mark.parametrize("way", ["itself", "a link to it", "a hard link to it", "its journal"])
def test_the_project_is_never_overwritten(aerial: Path, way: str, tmp_path: Path) -> None:
    project = tmp_path / "photo.svg"
    aerial.rename(project)
    before, output = project.read_bytes(), tmp_path / "other.svg"
    if way == "a link to it":
        output.symlink_to(project)
    elif way == "a hard link to it":
        os.link(project, output)
    else:
        output = project
    if way == "its journal":
        project, output = tmp_path / "photo", tmp_path / "photo-journal"
        (tmp_path / "photo.svg").rename(project)
        assert "ends in .svg" in orient("plot", project, "residuals", "-o", output, "--force").err
    else:
        said = orient("plot", project, "residuals", "-o", output, "--force")
        assert (said.code, "would overwrite its own input" in said.err) == (2, True)
    assert project.read_bytes() == before


def test_a_folder_without_room_is_named(aerial: Path) -> None:
    """A file that may grow to 4 kB only: nothing half-written stays."""
    code = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096));"
        "from orient.cli.main import run; run()"
    )
    output = aerial.parent / "plot.svg"
    said = in_process(code, "plot", aerial, "residuals", "-o", output)
    assert said.returncode == 1
    assert "plot.svg cannot be written: File too large" in said.stderr
    assert [file.name for file in aerial.parent.iterdir()] == [aerial.name]


def test_without_matplotlib_it_is_said_what_to_install(aerial: Path) -> None:
    said = without("matplotlib", "plot", aerial, "residuals", "-o", aerial.parent / "x.svg")
    assert said.returncode == 2
    assert said.stderr.splitlines() == [
        "orient: plots need matplotlib, which is not installed",
        "        Install it: pip install 'orient[plot]'",
    ]
    assert without("matplotlib", "show", aerial, "covariance").returncode == 0


def test_a_plot_before_its_stage_says_what_to_run(fresh: Path) -> None:
    said = orient("plot", fresh, "accuracy", "-o", fresh.parent / "x.svg")
    assert (said.code, "needs resection, covariance" in said.err) == (2, True)
    for stage in ("refine", "bl", "topocentric"):
        assert orient(stage, fresh).code == 0
    assert orient("resection", fresh, "--max-iterations", "1").code == 1
    said = orient("plot", fresh, "residuals", "-o", fresh.parent / "x.svg")
    assert f"It failed: orient show {fresh} resection" in said.err
    said = orient("plot", fresh, "portrait", "-o", fresh.parent / "x.svg")
    assert 'there is no plot "portrait"' in said.err
    assert "Plots are accuracy, budget, ellipses, iterations, residuals, sheet." in said.err


def test_a_part_is_named_where_there_are_several(model: Path, space: Path) -> None:
    """Zones of a model, sheets of a map; a name that is not there is refused with those that are."""
    west = orient("plot", model, "iterations", "-o", "-", "--part", "west")
    assert (west.code, "zone west" in west.out) == (0, True)
    assert "zone east" in orient("plot", model, "iterations", "-o", "-").out
    said = orient("plot", model, "iterations", "-o", "-", "--part", "south")
    assert (said.code, said.err.splitlines()[1].strip()) == (2, "Zones are east, west.")
    said = orient("plot", space, "sheet", "-o", "-", "--part", "K-35")
    assert (said.code, said.err.splitlines()[1].strip()) == (2, "Sheets are K-34.")
    assert "40-18" in orient("plot", space, "sheet", "-o", "-", "--part", "K-34").out


def test_the_vectors_of_a_sheet_are_drawn_in_the_direction_of_the_ground(space: Path) -> None:
    """On a sheet that lies almost north up, a residual to the east points to the right: signs of the drawn arrows."""
    from orient.report.plots import BY_NAME, plot_data
    from orient.report.plots.sheet import _metres_per_mm, _reading
    from orient.store.project import open_project

    with open_project(space) as project:
        data = plot_data(project, project.heads(), BY_NAME["sheet"].tables)
    rows = [{**_reading(row, data), **row} for row in data.tables["digitize"]["cross_residual"]]
    scale = _metres_per_mm(rows, data.tables["photo"]["photo"][0])
    # the map is 1:1 000 000: one millimetre is one kilometre; 2 % for the projection
    assert scale[0, 0] == pytest.approx(1000.0, rel=0.02)
    assert scale[1, 1] == pytest.approx(1000.0, rel=0.02)


def test_show_says_what_the_seed_says_of_a_vertical_photo(aerial: Path) -> None:
    said = orient("show", aerial, "covariance").out
    for words in (
        "the formulas of seed 003 apply",
        "within 1.9 %",
        "In the scale of the image the focal length is not in them, for any layout",
        "The layout is not symmetric, so there is no closed form (8)-(10): per point sum xi = -0.594",
        "standard deviations only 0.2488 m (x 5.816)",
        "Use all six elements together with the full 6 x 6 matrix",
        "New ground points over the frame",
        "K by its elements",
    ):
        assert words in said, words


def test_show_names_the_condition_that_fails(space: Path) -> None:
    said = orient("show", space, "covariance").out
    assert "The formulas of seed 003 do not apply to this photo: control without errors: points that have" in said
    assert "them 25, at most 0." in said
    assert "Q^(f,c)" not in said
    assert "Pairs of points with the strongest correlation, 25 of 630" in said
    assert orient("sql", space, "ground-map", "--csv").out.count("\n") == 1 + 121
    assert orient("sql", space, "pairs", "--csv").out.count("\n") == 1 + 630


def test_a_plot_never_mixes_versions(space: Path) -> None:
    assert orient("resection", space, "--control", "fixed").code == 0
    said = orient("plot", space, "accuracy", "-o", space.with_name("stale.svg"))
    assert said.code == 1
    assert said.err.startswith("orient: the results are out of date (covariance); a picture would mix versions")
    assert not space.with_name("stale.svg").exists()
