"""A small project folder that is in order; each test spoils one thing."""

from collections.abc import Callable
from pathlib import Path

import pytest

PHOTO = """\
[photo]
name = "AS15-M-0585"
date = 1971-07-31
image = "as15-m-0585.tif"
platform = "space"

[camera]
f_mm = 76.054
x0_mm = -0.006
y0_mm = -0.002
frame_mm = [114.3, 114.3]
sigma_image_mm = 0.007

[ground]
a_m = 1737400
inverse_flattening = 0
"""
READINGS = "point,kind,cycle,x_mm,y_mm\nP1,point,1,1.5,2.5\nP1,point,2,1.501,2.499\nP2,point,1,-10.25,7\n"
CONTROL = "point,role,B_deg,L_deg,H_m\nP1,control,27.5,2.5,-1900\nP2,check,27 30 15.5,2.75,\n"

Write = Callable[[str, str | bytes], Path]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (("photo.toml", PHOTO), ("readings.csv", READINGS), ("control.csv", CONTROL)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Writes a file, bytes as they are, and returns its path."""

    def write_file(name: str, content: str | bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        return path

    return write_file
