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
def space_tables(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Tables]:
    """All stages of the simulated space photo, with all pairs."""
    path = tmp_path_factory.mktemp("space") / "photo.sqlite"
    create(path, read_project(SPACE, ReadOptions()), "test")
    run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    run_stage(path, "covariance", {"pairs": True}, "test")
    with open_project(path) as project:
        return {stage: project.read_tables(run.run_id) for stage, run in project.heads().items()}
