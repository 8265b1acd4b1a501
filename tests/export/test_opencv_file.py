"""`orient export P opencv`, read back by OpenCV: control to 0.01 px, distortion included, covariance J C J'."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from orient.export import BY_NAME
from orient.export.opencv_camera import opencv_camera
from orient.export.opencv_file import Matrix, json_pieces, yaml_pieces
from orient.export.pixels import pixel_grid
from orient.export.solved import read_solved, solved_points
from orient.geometry.camera import Measured, corrected
from orient.geometry.rotation import matrix_from_quaternion, rotation_exp
from orient.pipeline.image_corrections import air_and_curvature
from tests.cli.commands import orient
from tests.export.conftest import Project
from tests.export.reprojection import rows, stored
from tests.jacobian import central_difference

cv2 = pytest.importorskip("cv2")
SAMPLES = {
    "calgary-28": "fitted",
    "apollo15-metric-0585": "fitted",
    "engabreen": "exact",
    "strasbourg-sxb-8937": "exact",
    "simulated-space-krasovsky": "fitted",
}
ENDINGS = (".yml", ".json")
ALLOWED_PX = 0.01


class Read:
    """The file as OpenCV sees it."""

    def __init__(self, path: Path) -> None:
        self.storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)

    def matrix(self, name: str) -> np.ndarray:
        found: np.ndarray = self.storage.getNode(name).mat()
        return found

    def text(self, name: str) -> str:
        return str(self.storage.getNode(name).string())

    def texts(self, name: str) -> list[str]:
        node = self.storage.getNode(name)
        return [node.at(i).string() for i in range(node.size())]

    def number(self, name: str) -> float:
        return float(self.storage.getNode(name).real())

    def projected(self) -> np.ndarray:
        names = ("object_points", "rvec", "tvec", "camera_matrix", "distortion_coefficients")
        pixels, _ = cv2.projectPoints(*(self.matrix(name) for name in names))
        return np.asarray(pixels[:, 0], dtype=np.float64)


def exported(path: Path, folder: Path, ending: str = ".yml", *words: object) -> Read:
    output = folder / f"camera{ending}"
    said = orient("export", path, "opencv", "-o", output, *words)
    assert (said.code, said.err) == (0, "")
    return Read(output)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("sample", SAMPLES)
def test_the_control_is_where_the_adjustment_computed_it(
    sample: str, ending: str, project: Project, tmp_path: Path
) -> None:
    """OpenCV's pixels, back through the photo's own lens, against x + v of the stored residuals."""
    path = project(sample)
    read, proof = exported(path, tmp_path, ending), stored(path)
    assert read.text("distortion_method") == SAMPLES[sample]
    solved = read_solved(path, BY_NAME["opencv"])
    points, grid = solved_points(solved), pixel_grid(solved.photo, None)
    frame_mm = (read.projected() - grid.origin) * grid.axes * grid.size_mm
    clear = corrected(solved.camera, Measured(frame_mm, np.zeros_like(frame_mm)))
    seen = corrected(solved.camera, Measured(frame_mm, sum(air_and_curvature(clear, solved.photo))))
    v = np.array([[proof.residuals[name][key] for key in ("vx_mm", "vy_mm")] for name in read.texts("point_names")])
    if sample == "engabreen":  # v of an estimated lens is that of the reading itself
        wanted, seen = points.frame_xy + v, frame_mm
    else:
        wanted = points.image + v
    assert np.abs(seen - wanted).max() / read.number("pixel_size_mm") < ALLOWED_PX


@pytest.mark.parametrize("sample", SAMPLES)
def test_the_pixels_are_those_that_were_read(sample: str, project: Project, tmp_path: Path) -> None:
    """Real pixels are the readings themselves; the rms against OpenCV's is that of the adjustment, to 1 %."""
    path = project(sample)
    read, proof = exported(path, tmp_path), stored(path)
    difference = (read.projected() - read.matrix("image_points")) * read.number("pixel_size_mm")
    v = np.array([[proof.residuals[name][key] for key in ("vx_mm", "vy_mm")] for name in read.texts("point_names")])
    assert np.sqrt(np.mean(difference**2)) == pytest.approx(np.sqrt(np.mean(v**2)), rel=0.01, abs=1e-6)
    if not read.number("pixel_is_of_the_image"):
        assert "virtual pixel of 0.01" in read.text("pixel")
        return
    sql = "SELECT point, avg(col_px) AS col, avg(row_px) AS row FROM comparator_reading WHERE run_id = {readings} "
    given = {row["point"]: (row["col"], row["row"]) for row in rows(path, sql + "GROUP BY point")}
    assert read.matrix("image_points") == pytest.approx(
        np.array([given[name] for name in read.texts("point_names")]), abs=1e-9
    )


@pytest.mark.parametrize("sample", ["calgary-28", "apollo15-metric-0585", "engabreen"])
def test_the_covariance_is_carried_into_rvec_and_tvec(sample: str, project: Project, tmp_path: Path) -> None:
    """J by central differences of OpenCV's own Rodrigues, C from the stored cofactors; 1e-6 of the largest element."""
    path = project(sample)
    read, proof = exported(path, tmp_path), stored(path)
    sql = "SELECT i, j, value FROM cofactor WHERE run_id = {resection} AND unknowns = 'rotation' AND j <= 6 AND i <= 6"
    C = np.zeros((6, 6))
    for row in rows(path, sql):
        i, j = int(row["i"]) - 1, int(row["j"]) - 1
        C[i, j] = C[j, i] = row["value"] * proof.orientation["variance_scale"]
    swap = np.eye(6)
    if proof.orientation["frame"] == "topocentric":  # T' is north, east, up
        swap[[3, 4]] = swap[[4, 3]]
    C = swap @ C @ swap
    R = matrix_from_quaternion([proof.orientation[f"q_{part}"] for part in "wxyz"])
    S = swap[3:, 3:] @ np.array([proof.orientation[f"{name}_m"] for name in ("X_S", "Y_S", "Z_S")])
    D = cv2.Rodrigues(read.matrix("rvec"))[0] @ R

    def vector(x: np.ndarray) -> np.ndarray:
        turn = D @ (rotation_exp(x[:3]) @ R).T
        return np.concatenate([cv2.Rodrigues(turn)[0][:, 0], -turn @ (S + x[3:])])

    J = central_difference(vector, np.zeros(6), np.array([1e-6] * 3 + [1.0] * 3))
    assert vector(np.zeros(6))[3:] == pytest.approx(read.matrix("tvec")[:, 0], rel=1e-9)
    wanted = J @ C @ J.T
    scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    assert np.abs((read.matrix("covariance") - wanted) / scale).max() < 1e-5
    assert read.texts("covariance_parameters")[0] == "rvec_x"
    assert read.texts("covariance_units") == ["rad"] * 3 + ["m"] * 3


def test_a_size_of_the_virtual_pixel(project: Project, tmp_path: Path) -> None:
    path = project("simulated-space-krasovsky")
    read = exported(path, tmp_path, ".yml", "--pixel-mm", "0.02")
    assert read.number("image_width") == 9000
    assert read.matrix("camera_matrix")[0, 0] == pytest.approx(10000, rel=1e-4)
    said = orient("export", project("engabreen"), "opencv", "-o", tmp_path / "x.yml", "--pixel-mm", "0.01")
    assert (said.code, "are 0.00512821 mm, not 0.01 mm" in said.err) == (2, True)


def test_a_lens_that_opencv_does_not_have(project: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Undistorted coordinates and the reason, in place of coefficients that miss."""
    monkeypatch.setattr("orient.export.opencv_camera.LARGEST_MISFIT_PX", 1e-9)
    path = project("calgary-28")
    read, proof = exported(path, tmp_path), stored(path)
    assert read.text("distortion_method") == "undistorted"
    assert read.text("distortion_note").startswith("OpenCV's lens misses the photo's by up to")
    assert not read.matrix("distortion_coefficients").any()
    v = np.array([[proof.residuals[name][key] for key in ("vx_mm", "vy_mm")] for name in read.texts("point_names")])
    v *= [1.0, -1.0]
    difference = read.projected() - read.matrix("image_points")
    assert difference == pytest.approx(v / read.number("pixel_size_mm"), abs=ALLOWED_PX)


HARD = (
    "=1+1",
    'a"b',
    "x: [y]",
    "{z}",
    "Ж-1",
    "%YAML",
    "<script>",
    "'q'",
    "back\\slash",
    "two\nlines",
    "# no",
    "- x",
    "~",
)


@pytest.mark.parametrize("write", [yaml_pieces, json_pieces], ids=["yaml", "json"])
def test_texts_that_are_hard_to_write(write: Callable[..., Iterator[str]], tmp_path: Path) -> None:
    """Quotes, colons, brackets, other scripts and formulas of a stranger's file come back as they were."""
    output = tmp_path / ("x.yml" if write is yaml_pieces else "x.json")
    entries = {"names": list(HARD), "inner": {"photo": HARD[1], "long": "я" * 1000}, "none": [], "number": 1e-300}
    output.write_text("".join(write(entries)), "utf-8")
    read = Read(output)
    assert read.texts("names") == list(HARD)
    assert read.storage.getNode("inner").getNode("photo").string() == HARD[1]
    assert read.number("number") == 1e-300


def test_a_number_that_is_none_is_never_written() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        "".join(yaml_pieces({"K": Matrix(np.array([[np.nan]]))}))


def test_the_source_is_told(project: Project, tmp_path: Path) -> None:
    read = exported(project("calgary-28"), tmp_path)
    source = read.storage.getNode("source")
    assert source.getNode("photo").string() == "calgary-28"
    assert source.getNode("versions").getNode("resection").real() == 1
    findings = source.getNode("findings")
    codes = [findings.at(i).getNode("code").string() for i in range(findings.size())]
    assert "suspect" in codes
    notes = source.getNode("notes")
    assert any("put it in doubt" in notes.at(i).string() for i in range(notes.size()))


def test_all_of_a_camera_is_used(project: Project) -> None:
    """The misfit that is written is that of points between the samples too."""
    solved = read_solved(project("apollo15-metric-0585"), BY_NAME["opencv"])
    camera = opencv_camera(solved, solved_points(solved), pixel_grid(solved.photo, None))
    assert camera.misfit_px is not None
    assert 0 < camera.misfit_px < 0.005
