import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from tests.cli.commands import SAMPLES, orient

Project = Callable[[str], Path]


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """Oriented projects of the samples by name, read only; `pulkovo`: the space photo on a datum that EPSG knows."""

    @cache
    def made(name: str) -> Path:
        folder, home = SAMPLES / name, tmp_path_factory.mktemp(name)
        if name in ("pulkovo", "wgs84"):
            folder = home / "list"
            shutil.copytree(SAMPLES / "simulated-space-krasovsky", folder)
            text = (folder / "photo.toml").read_text("utf-8")
            ground = {"pulkovo": 'crs = "EPSG:4284"', "wgs84": 'ellipsoid = "wgs84"'}[name]
            (folder / "photo.toml").write_text(text.replace('ellipsoid = "krasovsky"', ground), "utf-8")
        path = home / "photo.sqlite"
        assert orient("new", path, "--from", folder).code == 0
        assert orient("run", path).code == 0
        if name == "engabreen":
            assert orient("resection", path, "--calibrate", "auto").code == 0
            assert orient("run", path).code == 0
        return path

    return made
