"""Every sample project, run as a user runs it, against its published, reproduced or true values."""

import json
import math
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_input, read_project
from orient.pipeline.runner import add_input, create, photo_facts, run_stage, run_stale
from orient.solvers.packed import unpack_upper
from orient.store.project import open_project
from tests.samples.quantities import Lookup

SAMPLES = Path(__file__).parents[2] / "sample_projects"
OPTIONS = ReadOptions()


@dataclass(frozen=True)
class Case:
    """A sample folder, the list of its expectations, and what is done after the first run."""

    name: str
    expected: str = "expected.json"
    then: Callable[[Path], None] = field(default=lambda path: None)

    @property
    def id(self) -> str:
        return f"{self.name}-{self.expected.removesuffix('.json')}"


def add_list(stage: str, *names: str) -> Callable[[Path], None]:
    def add(path: Path) -> None:
        files = [SAMPLES / name for name in names]
        add_input(path, read_input(stage, files, OPTIONS, photo_facts(path)), "the second list of the sample")
        run_all(path)

    return add


def run_all(path: Path) -> None:
    results = run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    assert [result.run.error for result in results if result.failed and result.run] == []


def with_known_interior(path: Path) -> None:
    """The independent computation takes the interior orientation as known."""
    run_stage(path, "resection", {"interior": "fixed"}, "as the independent computation")
    run_all(path)


def orient_engabreen(estimate: str, *, photo: str = "", readings: str = "") -> Callable[[Path], None]:
    """Another photo.toml or list of readings first, where one is named; then the camera is estimated."""

    def compute(path: Path) -> None:
        for stage, name in (("photo", photo), ("readings", readings)):
            if name:
                tables = read_input(stage, [SAMPLES / "engabreen" / name], OPTIONS, photo_facts(path))
                add_input(path, tables, "the other file of the sample")
        run_all(path)
        assert run_stage(path, "resection", {"estimate": estimate}, "test").failed is False

    return compute


ENGABREEN_CASES = (
    Case("engabreen", "expected.json", orient_engabreen("f,k1")),
    Case("engabreen", "expected_no_distortion.json", orient_engabreen("f")),
    Case("engabreen", "expected_station_fixed.json", orient_engabreen("f,k1", photo="photo_station_fixed.toml")),
    Case("engabreen", "expected_affinity.json", orient_engabreen("f,k1,b1", photo="photo_station_fixed.toml")),
    Case(
        "engabreen",
        "expected_as_published.json",
        orient_engabreen("f,k1,b1", photo="photo_station_fixed.toml", readings="readings_as_published.csv"),
    ),
)
CASES = (
    *ENGABREEN_CASES,
    Case("apollo15-metric-0585"),
    Case(
        "apollo15-metric-0585",
        "expected_apriori.json",
        add_list("control", "apollo15-metric-0585/control_apriori.csv", "apollo15-metric-0585/control.toml"),
    ),
    Case("strasbourg-sxb-8937"),
    Case("calgary-27", then=with_known_interior),
    Case("calgary-28", then=with_known_interior),
    Case("n37-map-graticule"),
    Case(
        "n37-map-graticule",
        "expected_all.json",
        add_list(
            "sheet", *(f"n37-map-graticule/{name}" for name in ("crosses_all.csv", "digitizer.csv", "sheet.toml"))
        ),
    ),
    Case("simulated-space-krasovsky"),
    Case("simulated-model-two-zones"),
)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_sample_meets_its_expected_values(case: Case, tmp_path: Path) -> None:
    path = tmp_path / "photo.sqlite"
    create(path, read_project(SAMPLES / case.name, OPTIONS), "test")
    run_all(path)
    case.then(path)
    with open_project(path, "read") as project:
        lookup = Lookup(project)
    misses = []
    for entry in json.loads((SAMPLES / case.name / case.expected).read_text("utf-8")):
        found = lookup(entry["stage"], entry["quantity"])
        if not math.isclose(found, entry["value"], rel_tol=1e-15, abs_tol=entry["tolerance"]):
            misses.append(f"{entry['quantity']}: {found!r}, expected {entry['value']} +- {entry['tolerance']}")
    assert misses == []


def test_engabreen_finds_the_gnss_station_within_its_sigmas(tmp_path: Path) -> None:
    """Each coordinate within two standard deviations; the sample's README says what the three together tell."""
    path = tmp_path / "photo.sqlite"
    create(path, read_project(SAMPLES / "engabreen", OPTIONS), "test")
    orient_engabreen("f,k1")(path)
    with open_project(path, "read") as project:
        lookup = Lookup(project)
    station = np.array([lookup("resection", f"{axis}_S_m") for axis in "XYZ"])
    apart = station - [446722.0, 7396671.0, 770.0]
    sigmas = [lookup("resection", f"sigma.{axis}_S_m") for axis in "XYZ"]
    assert np.all(np.abs(apart) < 2 * np.array(sigmas))


CHI2_95_3 = 7.81
"""chi^2 with three degrees of freedom that a right station exceeds with a chance of 5 %."""


def test_engabreen_finds_the_gnss_station_with_all_its_covariances(tmp_path: Path) -> None:
    """d'C^-1 d of the three coordinates together, with the sigmas of natural control (README of the sample)."""
    path = tmp_path / "photo.sqlite"
    create(path, read_project(SAMPLES / "engabreen", OPTIONS), "test")
    files = [SAMPLES / "engabreen" / name for name in ("control_weighted.csv", "control.toml")]
    add_input(path, read_input("control", files, OPTIONS, photo_facts(path)), "with sigmas")
    run_all(path)
    assert run_stage(path, "resection", {"estimate": "f,k1"}, "test").failed is False
    with open_project(path, "read") as project:
        tables = project.read_tables(project.heads()["resection"].run_id)
    (found,) = tables["orientation"]
    packed = sorted((row["IJ"], row["value"]) for row in tables["cofactor"] if row["unknowns"] == "rotation")
    C = found["variance_scale"] * unpack_upper(np.array([value for _, value in packed]))[3:6, 3:6]
    apart = np.array([found[f"{axis}_S_m"] for axis in "XYZ"]) - [446722.0, 7396671.0, 770.0]
    assert apart @ np.linalg.solve(C, apart) < CHI2_95_3
    assert np.all(np.abs(apart) < 2 * np.sqrt(np.diag(C)))


@pytest.mark.parametrize("asked", [{"test": "w", "reject": True}, {"robust": True}], ids=["w, one by one", "robust"])
def test_engabreen_shows_the_five_planted_errors(tmp_path: Path, asked: dict[str, str | bool]) -> None:
    path = tmp_path / "photo.sqlite"
    create(path, read_project(SAMPLES / "engabreen", OPTIONS), "test")
    planted = [SAMPLES / "engabreen" / "readings_as_published.csv"]
    add_input(path, read_input("readings", planted, OPTIONS, photo_facts(path)), "planted errors")
    run_all(path)
    assert run_stage(path, "resection", {"estimate": "f,k1", **asked}, "test").failed is False
    with open_project(path, "read") as project:
        rows = project.read_tables(project.heads()["resection"].run_id)["exclusion"]
    assert sorted(row["point"] for row in rows if row["action"] == "excluded") == ["1", "2", "3", "4", "5"]


def test_every_sample_is_run() -> None:
    folders = {path.parent.name for path in SAMPLES.glob("*/photo.toml")}
    assert folders == {case.name for case in CASES}


@pytest.mark.parametrize("folder", sorted(SAMPLES.glob("*/photo.toml")), ids=lambda path: path.parent.name)
def test_sample_tells_its_source_and_licence(folder: Path) -> None:
    text = (folder.parent / "README.md").read_text("utf-8").lower()
    assert "source" in text
    assert "licen" in text


def test_samples_work_from_a_copy_elsewhere(tmp_path: Path) -> None:
    shutil.copytree(SAMPLES / "strasbourg-sxb-8937", tmp_path / "copy")
    path = tmp_path / "photo.sqlite"
    create(path, read_project(tmp_path / "copy", OPTIONS), "test")
    run_all(path)
    assert run_stage(path, "resection", {}, "again").computed is False


MADE_BY_SCRIPT = {
    "simulated-space-krasovsky": {"readings.csv", "crosses.csv", "digitizer.csv", "control.csv", "truth.json"},
    "simulated-model-two-zones": {"model.csv", "control.csv", "truth.json"},
}


@pytest.mark.parametrize("sample", MADE_BY_SCRIPT)
def test_simulated_sample_is_what_its_script_makes(tmp_path: Path, sample: str) -> None:
    folder = SAMPLES / sample
    subprocess.run([sys.executable, str(folder / "simulate.py"), str(tmp_path)], check=True, capture_output=True)
    made = {path.name: path.read_text("utf-8") for path in tmp_path.iterdir()}
    assert MADE_BY_SCRIPT[sample] == set(made)
    assert made == {name: (folder / name).read_text("utf-8") for name in made}
