"""A whole project of n weighted points in a fresh process: seconds and largest memory of `orient run`."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_opk

ROOT = Path(__file__).parents[1]
F_MM, SIGMA_MM, SIGMA_M = 153.0, 0.005, 0.05
RUN = """
import json, re, sys, time
from pathlib import Path
from orient.pipeline.runner import run_stale
begin = time.perf_counter()
run_stale(Path(sys.argv[1]), {}, "bench", lambda stage: None, lambda result: None)
peak = re.search(r"VmHWM:\\s*(\\d+)", Path("/proc/self/status").read_text())  # ru_maxrss would be that of the parent
used = int(peak[1]) / 1024
print(json.dumps([time.perf_counter() - begin, used]))
"""


def measured(n: int) -> tuple[int, float, float]:
    """Points, seconds, megabytes."""
    with tempfile.TemporaryDirectory(prefix="orient-bench-") as folder:
        path = Path(folder) / "project.sqlite"
        _call(
            "from orient.cli.main import run; run()", "new", str(path), "--from", str(write(Path(folder) / "input", n))
        )
        seconds, megabytes = json.loads(_call(RUN, str(path)))
    return n, seconds, megabytes


def _call(code: str, *words: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", code, *words]
    return subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout


def write(folder: Path, n: int) -> Path:
    """photo.toml, readings.csv and control.csv of an aerial photo of n control points with their own sigmas."""
    rng = np.random.default_rng(7)
    ground = np.column_stack([rng.uniform(-1200, 1200, (n, 2)), rng.uniform(0, 200, n)])
    image, _ = project(ground, np.array([0.0, 0.0, 2000.0]), matrix_from_opk(0.03, -0.02, 0.4).T, F_MM)
    image += rng.normal(scale=SIGMA_MM, size=image.shape)
    control = np.column_stack([ground + rng.normal(scale=SIGMA_M, size=ground.shape), np.full((n, 3), SIGMA_M)])
    folder.mkdir()
    (folder / "photo.toml").write_text(
        f'[photo]\nname = "load"\nplatform = "aerial"\n[camera]\nf_mm = {F_MM}\nframe_mm = [400.0, 400.0]\n'
        f'sigma_image_mm = {SIGMA_MM}\n[ground]\nlocal = "right"\n'
    )
    (folder / "control.toml").write_text('[control]\nlocal = "right"\n')
    _write_csv(folder / "readings.csv", "point,x_mm,y_mm", image)
    _write_csv(folder / "control.csv", "point,X_m,Y_m,Z_m,sigma_X_m,sigma_Y_m,sigma_Z_m", control)
    return folder


def _write_csv(path: Path, header: str, values: np.ndarray) -> None:
    rows = [f"P{i}," + ",".join(map(repr, row)) for i, row in enumerate(values.tolist())]
    path.write_text("\n".join([header, *rows, ""]))
