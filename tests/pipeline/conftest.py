from collections.abc import Mapping
from pathlib import Path

import pytest

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create, run_stage, run_stale
from orient.store.project import open_project
from orient.values import Tables

SPACE = Path(__file__).parents[2] / "sample_projects" / "simulated-space-krasovsky"


@pytest.fixture(scope="session")
def space_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The simulated space photo with all stages and all pairs; not to be changed."""
    path = tmp_path_factory.mktemp("space") / "photo.sqlite"
    create(path, read_project(SPACE, ReadOptions()), "test")
    run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    run_stage(path, "covariance", {"pairs": True}, "test")
    return path


@pytest.fixture(scope="session")
def space_tables(space_file: Path) -> Mapping[str, Tables]:
    """All stages of the simulated space photo, with all pairs."""
    with open_project(space_file) as project:
        return {stage: project.read_tables(run.run_id) for stage, run in project.heads().items()}
