"""Project folders of a photo of known truth, to be spoiled: local ground, eight points, 1 km below the camera."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_opk

Array = NDArray[np.float64]
F_MM, SIGMA_MM = 152.0, 0.005
STATION = np.array([400.0, 300.0, 1200.0])
PLAN = np.array([[0, 0], [800, 20], [790, 610], [15, 590], [400, 310], [620, 150], [180, 420], [560, 480]], dtype=float)
RELIEF = np.array([120.0, 160.0, 210.0, 180.0, 240.0, 130.0, 90.0, 200.0])
GROUND = np.column_stack([PLAN, RELIEF])
NOISE = np.random.default_rng(7).normal(scale=SIGMA_MM, size=(40, 2))
NAMES = "ABCDEFGHIJKLMNOP"


@dataclass(frozen=True)
class MadePhoto:
    """What goes into the files. `ground`: what is given; `seen`: where the points really are."""

    seen: Array = field(default_factory=lambda: GROUND)
    given: Array | None = None
    f_mm: float = F_MM
    station: Array = field(default_factory=lambda: STATION)
    angles: tuple[float, float, float] = (0.03, -0.02, 0.4)
    platform: str = "aerial"
    approximate: Sequence[float] | None = None
    image: Array | None = None
    noise: float = 1.0
    local: str = "right"
    files: Mapping[str, str] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        return [*NAMES[: len(self.seen)]]

    def readings(self) -> Array:
        if self.image is not None:
            return self.image
        seen, zs = project(self.seen, self.station, matrix_from_opk(*self.angles).T, self.f_mm)
        assert np.all(zs < 0)
        return seen + self.noise * NOISE[: len(seen)]

    def with_points(self, seen: Array) -> "MadePhoto":
        return replace(self, seen=seen)

    def write(self, folder: Path) -> Path:
        """The folder with photo.toml, readings.csv, control.csv, control.toml; `files` replace them by name."""
        folder.mkdir(exist_ok=True)
        ground = self.seen if self.given is None else self.given
        near = "" if self.approximate is None else "[station]\n" + _toml(("X_m", "Y_m", "Z_m"), self.approximate)
        photo = (
            f'[photo]\nname = "made"\nplatform = "{self.platform}"\n[camera]\nf_mm = {self.f_mm}\n'
            f'frame_mm = [400.0, 400.0]\nsigma_image_mm = {SIGMA_MM}\n[ground]\nlocal = "{self.local}"\n{near}'
        )
        content = {
            "photo.toml": photo,
            "readings.csv": _csv("point,x_mm,y_mm", self.names, self.readings()),
            "control.csv": _csv("point,X_m,Y_m,Z_m", self.names, ground),
            "control.toml": f'[control]\nlocal = "{self.local}"\n',
            **self.files,
        }
        for name, text in content.items():
            (folder / name).write_text(text, encoding="utf-8")
        return folder


def _csv(header: str, names: Sequence[str], values: Array) -> str:
    rows = [f"{name}," + ",".join(repr(float(v)) for v in row) for name, row in zip(names, values, strict=True)]
    return "\n".join([header, *rows, ""])


def _toml(keys: Sequence[str], values: Sequence[float]) -> str:
    return "".join(f"{key} = {value}\n" for key, value in zip(keys, values, strict=True))
