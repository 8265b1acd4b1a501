"""Exports as files: the same bytes, CSV with its metadata, what is refused, and nothing half-written."""

import csv
import hashlib
import io
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from orient.export import FORMATS
from orient.geometry.rotation import matrix_from_opk, rotation_exp
from tests.cli.commands import AERIAL, in_process, orient, without
from tests.export.conftest import Project
from tests.export.reprojection import by_collinearity, rows, stored
from tests.jacobian import central_difference

NAMES = {form.name: form.endings[0] for form in FORMATS}
TABLES = ("opk", "elements", "residuals", "points")


@pytest.fixture
def aerial(project: Project, tmp_path: Path) -> Path:
    return Path(shutil.copy(project("calgary-28"), tmp_path / "photo.sqlite"))


@pytest.mark.parametrize("name", NAMES)
def test_the_same_project_gives_the_same_bytes(name: str, project: Project, tmp_path: Path) -> None:
    """Also under another name, at another time, and in a process of another locale."""
    if name == "gpkg":
        pytest.importorskip("pyogrio")
    path = project("pulkovo")
    copy = shutil.copy(path, tmp_path / "other.sqlite")
    contents = []
    for i, project_file in enumerate((path, copy)):
        folder = tmp_path / str(i)
        folder.mkdir()
        assert orient("export", project_file, name, "-o", folder / f"out{NAMES[name]}").code == 0
        contents.append({file.name: file.read_bytes() for file in folder.iterdir()})
    assert contents[0] == contents[1]
    assert len(contents[0]) == (2 if name in TABLES else 1)
    assert b"NaN" not in b"".join(contents[0].values())


def read_csv(file: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(file.read_bytes().decode("utf-8"), newline=""), strict=True))


@pytest.mark.parametrize("name", TABLES)
def test_a_table_and_what_stands_beside_it(name: str, project: Project, tmp_path: Path) -> None:
    path, output = project("simulated-space-krasovsky"), tmp_path / "out.csv"
    assert orient("export", path, name, "-o", output).code == 0
    beside = json.loads((tmp_path / "out.csv-metadata.json").read_text("utf-8"))
    assert beside["@context"] == "http://www.w3.org/ns/csvw"
    assert beside["url"] == "out.csv"
    assert beside["orient:sha256"] == hashlib.sha256(output.read_bytes()).hexdigest()
    header = output.read_bytes().split(b"\r\n")[0].decode().split(",")
    assert [column["name"] for column in beside["tableSchema"]["columns"]] == header
    assert all(column["dc:description"] for column in beside["tableSchema"]["columns"])
    matrix = np.array(beside["orient:covariance"]["matrix"])
    assert matrix.shape == (6, 6)
    assert np.linalg.eigvalsh(matrix / np.sqrt(np.outer(np.diag(matrix), np.diag(matrix))))[0] > 0
    assert beside["orient:covariance"]["units"] == ["m"] * 3 + ["rad"] * 3
    assert beside["orient:source"]["versions"]["resection"] == 1
    assert {finding["code"] for finding in beside["orient:source"]["findings"]} >= {"hardly_checked"}


def test_residuals_and_points_are_those_of_the_project(project: Project, tmp_path: Path) -> None:
    path = project("simulated-space-krasovsky")
    for name, sql in (
        ("residuals", "SELECT * FROM image_residual WHERE run_id = {resection}"),
        ("points", "SELECT * FROM geographic_point WHERE run_id = {bl}"),
    ):
        output = tmp_path / f"{name}.csv"
        assert orient("export", path, name, "-o", output).code == 0
        found = {row["point"]: row for row in read_csv(output)}
        wanted = {str(row["point"]): row for row in rows(path, sql)}
        assert found.keys() == wanted.keys()
        for point, row in wanted.items():
            for key in ("vx_mm", "vy_mm", "depth_m") if name == "residuals" else ("B_deg", "L_deg", "H_m"):
                assert float(found[point][key]) == row[key]


def test_the_opk_list_projects_the_control(project: Project, tmp_path: Path) -> None:
    """M = M_kappa M_phi M_omega written out in the test; 0.01 px of 6 um."""
    path = project("strasbourg-sxb-8937")
    assert orient("export", path, "opk", "-o", tmp_path / "o.csv").code == 0
    assert orient("export", path, "points", "-o", tmp_path / "p.csv").code == 0
    (row,), proof = read_csv(tmp_path / "o.csv"), stored(path)
    R = matrix_from_opk(*(np.radians(float(row[f"{name}_deg"])) for name in ("omega", "phi", "kappa")))
    points = [one for one in read_csv(tmp_path / "p.csv") if one["point"] in proof.residuals]
    ground = np.array([[float(one[f"{axis}_m"]) for axis in "XYZ"] for one in points])
    S = np.array([float(row[f"{axis}0_m"]) for axis in "XYZ"])
    q = [proof.orientation[f"q_{part}"] for part in "wxyz"]
    assert (ground - S) @ R == pytest.approx((ground - S) @ by_rotation(q), abs=1e-6)
    computed = by_collinearity(np.array(q), S, float(row["f_mm"]), ground)
    residuals = [proof.residuals[one["point"]] for one in points]
    wanted = np.array([[one["x_mm"] + one["vx_mm"], one["y_mm"] + one["vy_mm"]] for one in residuals])
    assert np.abs(computed - wanted).max() / 0.006 < 0.01
    assert "M = M_kappa M_phi M_omega" in row["convention"]


def by_rotation(q: list[float]) -> np.ndarray:
    from orient.geometry.rotation import matrix_from_quaternion

    return matrix_from_quaternion(q)


def test_the_opk_covariance_is_that_of_the_angles(project: Project, tmp_path: Path) -> None:
    """J by central differences; 1e-6 of the sigmas' product. The covariance beside the list is the list's own."""
    from orient.geometry.rotation import opk_from_matrix

    path = project("calgary-28")
    assert orient("export", path, "opk", "-o", tmp_path / "o.csv").code == 0
    (row,), proof = read_csv(tmp_path / "o.csv"), stored(path)
    beside = json.loads((tmp_path / "o.csv-metadata.json").read_text("utf-8"))["orient:covariance"]
    C = np.zeros((6, 6))
    sql = "SELECT i, j, value FROM cofactor WHERE run_id = {resection} AND unknowns = 'rotation' AND j <= 6 AND i <= 6"
    for one in rows(path, sql):
        i, j = int(one["i"]) - 1, int(one["j"]) - 1
        C[i, j] = C[j, i] = one["value"] * proof.orientation["variance_scale"]
    R = by_rotation([proof.orientation[f"q_{part}"] for part in "wxyz"])

    def vector(x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[3:], opk_from_matrix(rotation_exp(x[:3]) @ R)])

    J = central_difference(vector, np.zeros(6), np.array([1e-6] * 3 + [1.0] * 3))
    wanted = J @ C @ J.T
    scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    assert np.abs((np.array(beside["matrix"]) - wanted) / scale).max() < 1e-6
    names = beside["parameters"]
    for i, first in enumerate(names):
        for j, second in enumerate(names[i:], i):
            assert float(row[f"cov_{first}_{second}"]) == beside["matrix"][i][j]
    assert float(row["sigma_omega_deg"]) == pytest.approx(np.degrees(np.sqrt(beside["matrix"][3][3])))


def test_a_horizontal_view_has_no_covariance_of_its_angles(project: Project, tmp_path: Path) -> None:
    """Near the blind view the cells are empty and the matrix null, never NaN."""
    path = project("engabreen")
    assert orient("export", path, "elements", "-o", tmp_path / "e.csv").code == 0
    found = {row["element"]: row for row in read_csv(tmp_path / "e.csv")}
    blind = rows(path, "SELECT * FROM orientation_angle WHERE run_id = {resection} AND near_blind = 1")
    for row in blind:
        assert found[f"{row['triple']}_{row['angle']}"]["sigma"] == ""
    assert float(found["camera_k1"]["sigma"]) > 0


def test_names_are_no_formulas(tmp_path: Path) -> None:
    """`+1` and `-2+3` get an apostrophe in CSV; the numbers stay plain; orient reads its own table back."""
    folder, path = tmp_path / "list", tmp_path / "p.sqlite"
    shutil.copytree(AERIAL, folder)
    for file in ("control.csv", "readings.csv"):
        text = (folder / file).read_text("utf-8")
        (folder / file).write_text(text.replace("\n100,", "\n+1+1,").replace("\n102,", "\n-2+3,"), "utf-8")
    assert orient("new", path, "--from", folder).code == 0
    assert orient("run", path).code == 0
    assert orient("export", path, "points", "-o", tmp_path / "p.csv").code == 0
    found = read_csv(tmp_path / "p.csv")
    assert {"'+1+1", "'-2+3"} < {row["point"] for row in found}
    assert all(float(row["X_m"]) for row in found)
    assert not any(row["X_m"].startswith("'") for row in found)


REFUSED = {
    "no such format": (("shapefile", "-o", "x.shp"), 2, 'there is no format "shapefile"'),
    "another ending": (("opencv", "-o", "x.txt"), 2, "the name of a file for opencv ends in .yml or .yaml or .json"),
    "exists": (("opk", "-o", "there.csv"), 2, "there.csv exists"),
    "no folder": (("opk", "-o", "no/x.csv"), 2, "does not exist"),
    "a package to print": (("gpkg", "-o", "-"), 2, "gpkg cannot be printed"),
    "a pixel of nothing": (("opencv", "-o", "x.yml", "--pixel-mm", "-1"), 2, "is not a number above 0"),
}


@pytest.mark.parametrize(("words", "code", "message"), REFUSED.values(), ids=REFUSED)
def test_what_is_refused(words: tuple[str, ...], code: int, message: str, aerial: Path) -> None:
    folder = aerial.parent
    (folder / "there.csv").write_text("mine")
    places = [folder / word if "." in word else word for word in words]
    before = sorted(file.name for file in folder.iterdir())
    said = orient("export", aerial, *places)
    assert (said.code, message in said.err) == (code, True), said.err
    assert sorted(file.name for file in folder.iterdir()) == before
    assert (folder / "there.csv").read_text() == "mine"


def test_the_metadata_of_another_file_are_not_replaced(aerial: Path) -> None:
    (aerial.parent / "o.csv-metadata.json").write_text("mine")
    said = orient("export", aerial, "opk", "-o", aerial.parent / "o.csv")
    assert (said.code, "o.csv-metadata.json exists" in said.err) == (2, True)
    assert not (aerial.parent / "o.csv").exists()
    assert orient("export", aerial, "opk", "-o", aerial.parent / "o.csv", "--force").code == 0


def test_what_is_out_of_date_or_failed_is_not_exported(aerial: Path) -> None:
    samples = AERIAL
    few = aerial.parent / "control.csv"
    few.write_text("".join(f"{line}\n" for line in (samples / "control.csv").read_text().splitlines()[:3]))
    assert orient("add", aerial, "control", few, samples / "control.toml", "-m", "two only").code == 0
    said = orient("export", aerial, "opk", "-o", aerial.parent / "o.csv")
    assert said.code == 1
    assert "the results are out of date" in said.err
    assert "an export would mix versions" in said.err
    assert orient("run", aerial).code == 1
    said = orient("export", aerial, "opk", "-o", aerial.parent / "o.csv")
    assert (said.code, "out of date" in said.err) == (1, True)
    assert not (aerial.parent / "o.csv").exists()


def test_before_the_first_run(tmp_path: Path) -> None:
    path = tmp_path / "p.sqlite"
    assert orient("new", path, "--from", AERIAL).code == 0
    said = orient("export", path, "opencv", "-o", tmp_path / "x.yml")
    assert (said.code, "the export opencv needs refine, topocentric, resection" in said.err) == (2, True)


def test_a_disk_without_room_leaves_nothing(aerial: Path) -> None:
    """A file that may grow to 4 kB only: neither the table nor what stands beside it stays half-written."""
    code = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096));"
        "from orient.cli.main import run; run()"
    )
    words = ["export", aerial, "opencv", "-o", aerial.parent / "x.yml"]
    said = in_process(code, *words)
    assert (said.returncode, "x.yml cannot be written: File too large" in said.stderr) == (1, True)
    assert [file.name for file in aerial.parent.iterdir()] == [aerial.name]


def test_without_pyogrio_it_is_said_what_to_install(aerial: Path) -> None:
    said = without("pyogrio", "export", aerial, "gpkg", "-o", aerial.parent / "x.gpkg")
    assert said.returncode == 2
    assert said.stderr.splitlines() == [
        "orient: a GeoPackage needs pyogrio, which is not installed",
        "        Install it: pip install 'orient[gis]'",
    ]
    assert without("pyogrio", "export", aerial, "opk", "-o", aerial.parent / "x.csv").returncode == 0
