"""The wheel, installed away from the checkout, makes, runs, checks and upgrades a project: everything is in it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.commands import ROOT, SPACE

REPORT = ("report/locale/uk.po", "report/html/report.css", "report/html/report.html.j2")
SHIPPED = ("_migrations/env.py", "store/guards.sql", "store/views.sql", "store/schema.json", *REPORT)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the installed wheel."""
    pytest.importorskip("hatchling", reason="hatchling builds the wheel")
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = folder.glob("orient-*.whl")
    target = folder / "site"
    install = ["install", "--quiet", "--no-deps", "--no-index", "--target", str(target), str(wheel)]
    subprocess.run([sys.executable, "-m", "pip", *install], check=True, capture_output=True)
    return target


def test_files_that_are_no_modules_are_in_it(installed: Path) -> None:
    assert [name for name in SHIPPED if not (installed / "orient" / name).is_file()] == []
    assert sorted(file.name for file in installed.glob("*") if file.suffix != ".dist-info") == ["bin", "orient"]


def test_it_works_away_from_the_checkout(installed: Path, tmp_path: Path) -> None:
    shutil.copytree(SPACE, tmp_path / "in")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment["PYTHONPATH"] = str(installed)

    def said(*command: str) -> str:
        ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert (ended.returncode, ended.stderr) == (0, "")
        return ended.stdout

    program = str(installed / "bin" / "orient")
    assert said(sys.executable, "-c", "import orient; print(orient.__file__)").startswith(str(installed))
    assert "photo.sqlite made." in said(program, "new", "photo.sqlite", "--from", "in")
    assert "resection    version 1" in said(program, "run", "photo.sqlite")
    assert "photo.sqlite is sound." in said(program, "check", "photo.sqlite")
    assert "already has format" in said(program, "upgrade", "photo.sqlite")
