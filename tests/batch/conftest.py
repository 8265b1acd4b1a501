import shutil
from pathlib import Path

import pytest

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create
from tests.cli.made_photo import MadePhoto

COUNT = 12


def made_folders(place: Path, count: int) -> Path:
    """Folders P000 ... with photo.toml and lists of photos that differ in their noise."""
    place.mkdir(exist_ok=True)
    for number in range(count):
        MadePhoto(noise=0.5 + 0.05 * number).write(place / f"P{number:03}")
    return place


@pytest.fixture(scope="session")
def folders_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_folders(tmp_path_factory.mktemp("batch") / "folders", COUNT)


@pytest.fixture(scope="session")
def projects_once(folders_once: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("batch-projects")
    for folder in sorted(folders_once.iterdir()):
        create(place / f"{folder.name}.sqlite", read_project(folder, ReadOptions()), "made")
    return place


@pytest.fixture
def projects(projects_once: Path, tmp_path: Path) -> Path:
    """A folder of projects that nobody has run yet."""
    return Path(shutil.copytree(projects_once, tmp_path / "projects"))


@pytest.fixture
def many_projects(projects: Path) -> Path:
    """Thrice as many, so that some are left when a batch is stopped after the first few on a busy machine too."""
    for path in sorted(projects.iterdir()):
        for again in "bc":
            shutil.copy(path, path.with_stem(f"{path.stem}-{again}"))
    return projects
