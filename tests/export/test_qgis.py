"""The GeoPackage in QGIS itself, where the system's Python has it: styles are taken, labels name a field."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.cli.commands import orient
from tests.export.conftest import Project

PYTHON = "/usr/bin/python3"
LOOK = """
import json, os, sys
from qgis.core import QgsApplication, QgsRenderContext, QgsVectorLayer
app = QgsApplication([], False)
app.initQgis()
found = {}
for name in sys.argv[2:]:
    layer = QgsVectorLayer(f"{sys.argv[1]}|layername={name}", name, "ogr")
    symbol = layer.renderer().symbols(QgsRenderContext())[0].symbolLayer(0)
    label = layer.labeling().settings().fieldName if layer.labelsEnabled() else ""
    found[name] = [layer.isValid(), layer.featureCount(), layer.crs().authid(), symbol.layerType(), label]
print(json.dumps(found), flush=True)
os._exit(0)  # exitQgis of some versions ends in a segmentation fault
"""
HAS_QGIS = (
    shutil.which(PYTHON) is not None
    and not subprocess.run([PYTHON, "-c", "import qgis.core"], capture_output=True, check=False).returncode
)


@pytest.mark.skipif(not HAS_QGIS, reason="the system's Python has no QGIS (Debian: python3-qgis)")
def test_qgis_opens_every_layer_with_its_style(project: Project, tmp_path: Path) -> None:
    file = tmp_path / "layers.gpkg"
    assert orient("export", project("pulkovo"), "gpkg", "-o", file).code == 0
    layers = ("control", "check", "residuals", "ellipses", "footprint", "station")
    env = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "XDG_RUNTIME_DIR": str(tmp_path), "HOME": str(tmp_path)}
    said = subprocess.run(
        [PYTHON, "-c", LOOK, str(file), *layers], env=env, capture_output=True, text=True, check=False
    )
    assert said.returncode == 0, said.stderr
    assert json.loads(said.stdout) == {
        "control": [True, 25, "EPSG:4284", "SimpleMarker", "point"],
        "check": [True, 11, "EPSG:4284", "SimpleMarker", "point"],
        "residuals": [True, 36, "EPSG:4284", "ArrowLine", ""],
        "ellipses": [True, 36, "EPSG:4284", "SimpleFill", ""],
        "footprint": [True, 1, "EPSG:4284", "SimpleFill", ""],
        "station": [True, 1, "EPSG:4284", "SimpleMarker", "photo"],
    }
    assert "Warning" not in said.stderr
