"""`import orient`: light, typed, documented, and never another error than ours."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import orient
from orient.geometry.rotation import matrix_from_aok, matrix_from_opk
from tests.cli.commands import AERIAL, ROOT
from tests.cli.commands import orient as command

HEAVY = ("numpy", "scipy", "sqlalchemy", "alembic", "pyproj", "typer", "rich", "matplotlib", "pandas")


def test_import_alone_loads_nothing_heavy() -> None:
    code = f"import sys, orient; print(orient.__version__, [n for n in {HEAVY!r} if n in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert said.stdout.split(maxsplit=1)[1].strip() == "[]"


def test_every_public_name_is_there_and_documented() -> None:
    page = (ROOT / "docs" / "python.md").read_text("utf-8")
    for name in orient.__all__:
        assert name in dir(orient)
        thing = getattr(orient, name)
        assert name == "__version__" or thing.__doc__, name
        assert f"`orient.{name}" in page, name
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        orient.nothing  # noqa: B018


@pytest.mark.parametrize("name", ["Photo", "Orientation", "GroundPlaces", "ImagePlaces", "Table", "Picture", "Status"])
def test_every_public_member_is_documented(name: str) -> None:
    page = (ROOT / "docs" / "python.md").read_text("utf-8")
    public = [member for member in vars(getattr(orient, name)) if not member.startswith("_")]
    assert [member for member in public if not re.search(rf"`[^`]*\b{member}\b[^`]*`", page)] == []


def test_names_for_type_checkers_are_the_names_handed_out() -> None:
    tree = ast.parse((ROOT / "orient" / "__init__.py").read_text("utf-8"))
    typed = {alias.asname for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert typed - {None} == set(orient.__all__) - {"__version__"}
    assert (ROOT / "orient" / "py.typed").exists()


def test_new_run_and_what_stands(tmp_path: Path) -> None:
    photo = orient.new(tmp_path / "p.sqlite", AERIAL, reason="first")
    assert photo.status.verdict == "incomplete"
    done = photo.run(reason="first run")
    assert [one.stage for one in done if one.computed] == ["refine", "bl", "topocentric", "resection", "covariance"]
    assert photo.status.verdict == "doubtful"
    assert not photo.status.is_good
    assert photo.status.stages["resection"].version == 1
    assert {"suspect", "global_test"} & {finding.code for finding in photo.findings}
    assert photo.run("resection")[0].computed is False
    again = photo.run("resection", exclude="200", exclude_reason="misidentified", reason="without 200")[0]
    assert (again.version, again.settings["exclude"]) == (2, "200")
    assert photo.status.stages["covariance"].state == "stale"
    photo.select("resection", 1, reason="the first one after all")
    assert photo.orientation.version == 1
    assert photo.orientation_of(2).version == 2
    assert command("log", photo.path).out.count("without 200") == 1
    assert "misidentified" in photo.ask("who-excluded", point="200")["reason"].tolist()


def test_orientation_is_what_show_tells(sample: orient.Photo) -> None:
    o = sample.orientation
    stored = {row: (value, sigma) for row, value, sigma in zip(*_orientation_columns(sample), strict=True)}
    for convention, names in {"aok": ("alpha", "omega", "kappa"), "opk": ("omega", "phi", "kappa")}.items():
        try:
            elements = o.elements(convention)
        except orient.GeometryError:
            assert np.isnan(stored[f"{convention}_{names[0]}"][1])
            continue
        for name in names:
            value, sigma = stored[f"{convention}_{name}"]
            assert np.degrees(elements[name].value) == pytest.approx(value, abs=1e-12)
            assert np.degrees(elements[name].sigma) == pytest.approx(sigma, rel=1e-9)
        for name in ("X_S", "Y_S", "Z_S"):
            assert (elements[name].value, elements[name].sigma) == pytest.approx(stored[name], rel=1e-12)
    np.testing.assert_allclose(o.rotation @ o.rotation.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(o.rotation) == pytest.approx(1.0)
    aok, opk = (list(o.elements(one).values())[:3] for one in ("aok", "opk"))
    np.testing.assert_allclose(matrix_from_aok(*(e.value for e in aok)), o.rotation, atol=1e-12)
    np.testing.assert_allclose(matrix_from_opk(*(e.value for e in opk)), o.rotation, atol=1e-12)
    with pytest.raises(orient.UsageError) as error:
        o.elements("ypr")
    assert error.value.hint == "Conventions are aok, opk." == error.value.__notes__[0]


def _orientation_columns(photo: orient.Photo) -> tuple[list[str], list[float], list[float]]:
    table = photo.ask("SELECT element, value, sigma FROM v_orientation WHERE is_current AND frame <> 'geocentric'")
    return table["element"].tolist(), table["value"].tolist(), table["sigma"].tolist()


def test_tables_are_arrays_and_frames(calgary: orient.Photo) -> None:
    pandas = pytest.importorskip("pandas")
    residuals = calgary.residuals()
    assert residuals.rows == 8
    assert residuals.array("vx_mm", "vy_mm").shape == (8, 2)
    assert residuals["vx_mm"].dtype == np.float64
    sizes = np.linalg.norm(residuals.array("vx_mm", "vy_mm"), axis=1)
    assert np.all(np.diff(sizes) <= 0)
    frame = residuals.frame()
    assert isinstance(frame, pandas.DataFrame)
    assert frame.shape == (8, len(residuals))
    assert residuals.where(point="200").rows == 1
    assert "point" in residuals
    with pytest.raises(orient.UsageError, match='no column "v"'):
        residuals["v"]
    with pytest.raises(orient.UsageError, match="holds text"):
        residuals.array("point")


def test_a_name_cannot_bring_markup_into_a_notebook(calgary: orient.Photo) -> None:
    table = calgary.ask("SELECT '<script>x</script>' AS a, NULL AS b, 0.1 AS c")
    assert "<script>" not in table._repr_html_()
    assert np.isnan(table["b"]).all()


def test_rows_of_an_older_version(calgary: orient.Photo) -> None:
    calgary.run("resection", exclude="200", exclude_reason="wrong")
    assert calgary.table("exclusion", "resection")["point"].tolist() == ["200"]
    assert set(calgary.table("image_residual", "resection", 1)["role"]) == {"control"}
    with pytest.raises(orient.UsageError, match="has no rows in nowhere"):
        calgary.table("nowhere", "resection")


def test_pictures(calgary: orient.Photo, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    picture = calgary.plot("residuals")
    assert picture._repr_png_().startswith(b"\x89PNG")
    assert picture.svg.startswith("<?xml") or "<svg" in picture.svg
    saved = picture.save(tmp_path / "r.svg")
    assert saved.read_text("utf-8") == picture.svg
    with pytest.raises(orient.UsageError, match="exists"):
        picture.save(tmp_path / "r.svg")
    with pytest.raises(orient.UsageError, match=r"ends in \.svg or \.png"):
        picture.save(tmp_path / "r.pdf")


REFUSED = {
    "missing": (lambda p: orient.open(p.path.with_name("missing.sqlite")), orient.UsageError),
    "no project": (lambda p: orient.open(ROOT / "README.md"), orient.ProjectError),
    "no folder": (lambda p: orient.new(p.path.with_name("n.sqlite"), p.path.with_name("nowhere")), orient.OrientError),
    "exists": (lambda p: orient.new(p.path, AERIAL), orient.OrientError),
    "decimal": (lambda p: orient.new(p.path.with_name("n.sqlite"), AERIAL, decimal="dot"), orient.UsageError),
    "stage": (lambda p: p.run("resect"), orient.UsageError),
    "setting": (lambda p: p.run("resection", motor="qr"), orient.UsageError),
    "word": (lambda p: p.run("resection", engine="lm"), orient.UsageError),
    "flag": (lambda p: p.run("resection", reject="yes"), orient.UsageError),
    "number": (lambda p: p.run("resection", tolerance=0.1), orient.UsageError),
    "bool is no number": (lambda p: p.run("covariance", map_side=True), orient.UsageError),
    "order of elements": (lambda p: p.run("resection", estimate="k1,f"), orient.UsageError),
    "without a reason": (lambda p: p.run("resection", exclude="200"), orient.UsageError),
    "settings for all": (lambda p: p.run(robust=True), orient.UsageError),
    "list": (lambda p: p.add("points", "a.csv", reason="x"), orient.UsageError),
    "no reason": (lambda p: p.select("resection", 1, reason=" "), orient.UsageError),
    "version": (lambda p: p.orientation_of(9), orient.UsageError),
    "question": (lambda p: p.ask("everything"), orient.UsageError),
    "parameter": (lambda p: p.ask("who-excluded", points="7"), orient.UsageError),
    "sql": (lambda p: p.ask("DELETE FROM stage_run"), orient.UsageError),
    "plot": (lambda p: p.plot("pie"), orient.UsageError),
    "huge number": (lambda p: p.run("resection", tolerance=10**400), orient.UsageError),
    "words": (lambda p: p.run("resection", engine=np.array(["qr", "qr"])), orient.UsageError),
    "no file": (lambda p: p.add("readings", None, reason="x"), orient.UsageError),
    "no picture": (lambda p: p.plot("residuals").save(None), orient.UsageError),
    "fails": (lambda p: p.run("resection", exclude="100,102,105,200,201,202", exclude_reason="x"), orient.OrientError),
}


@pytest.mark.parametrize("case", REFUSED)
def test_every_error_is_ours(calgary: orient.Photo, case: str) -> None:
    ask, kind = REFUSED[case]
    with pytest.raises(kind) as error:
        ask(calgary)
    assert error.value.message


NAMES = {
    "nothing": (None, "is no text"),
    "number": (3, "is no text"),
    "bytes": (b"x", "is no text"),
    "list": (["a"], "is no text"),
    "surrogate": ("\ud800.sqlite", "has letters that no file can have"),
    "empty": ("", "is empty"),
    "zero byte": ("a\0b", "contains a zero byte"),
}


@pytest.mark.parametrize("case", NAMES)
def test_what_is_no_name_of_a_file_is_one_sentence(tmp_path: Path, case: str) -> None:
    name, said = NAMES[case]
    for ask, what in (
        (lambda: orient.new(name, AERIAL), "project"),
        (lambda: orient.new(tmp_path / "n.sqlite", name), "folder"),
        (lambda: orient.open(name), "project"),
    ):
        with pytest.raises(orient.UsageError, match=f"the name of the {what} .*{said}"):
            ask()


def test_a_current_folder_that_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    for ask in (lambda: orient.new("n.sqlite", AERIAL), lambda: orient.open("n.sqlite")):
        with pytest.raises(orient.UsageError, match="the current folder is gone"):
            ask()


def test_settings_may_be_numbers_of_numpy(calgary: orient.Photo) -> None:
    settings = {
        "max_iterations": np.int64(21),
        "tolerance": np.float64(1e-9),
        "reject": np.False_,
        "engine": np.str_("qr"),
    }
    done = calgary.run("resection", **settings)[0]
    assert [done.settings[name] for name in settings] == [21, 1e-9, False, "qr"]
    assert type(done.settings["max_iterations"]) is int


def test_a_replaced_file_is_read_anew(calgary: orient.Photo, space: orient.Photo) -> None:
    before = calgary.orientation
    calgary.path.write_bytes(space.path.read_bytes())
    assert calgary.orientation.frame == "topocentric" != before.frame
