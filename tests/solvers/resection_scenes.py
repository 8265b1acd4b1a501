"""Scenes of known truth, seeded by the name of the test that uses them."""

import csv
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import project

FloatArray = NDArray[np.float64]
DATA = Path(__file__).parent.parent / "data"


@dataclass(frozen=True)
class Scene:
    """Points of a photo with their true orientation."""

    image: FloatArray
    ground: FloatArray
    rotation: FloatArray
    station: FloatArray
    f_mm: float

    @property
    def unit(self) -> FloatArray:
        """Image cofactors of unit weight."""
        return np.tile(np.eye(2), (len(self.image), 1, 1))

    def noisy(self, sigma_mm: float, generator: np.random.Generator) -> FloatArray:
        """Image coordinates with normal errors."""
        return np.asarray(self.image + generator.normal(size=self.image.shape) * sigma_mm)


def generator(name: str) -> np.random.Generator:
    """Random numbers that depend on the test's name only."""
    return np.random.default_rng(zlib.crc32(name.encode()))


def any_rotation(random: np.random.Generator) -> FloatArray:
    """A rotation, every attitude alike."""
    Q, R = np.linalg.qr(random.normal(size=(3, 3)))
    Q = Q * np.sign(np.diag(R))
    return np.asarray(Q * np.linalg.det(Q))


def looking(azimuth: float, nadir: float, kappa: float) -> FloatArray:
    """R of a camera that looks `nadir` rad away from straight down, towards the azimuth from X to Y."""
    toward = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    axis = -(np.sin(nadir) * toward - np.cos(nadir) * np.array([0.0, 0.0, 1.0]))
    side = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.cross(axis, side)
    c, s = np.cos(kappa), np.sin(kappa)
    return np.column_stack([c * side + s * up, -s * side + c * up, axis])


def scene(
    random: np.random.Generator,
    n: int = 8,
    f_mm: float = 152.0,
    half_mm: float = 100.0,
    rotation: FloatArray | None = None,
    distance: float = 2000.0,
    relief: float = 0.1,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Scene:
    """`n` points spread over the frame, at `distance` along the axis +- `relief` of it."""
    R = any_rotation(random) if rotation is None else rotation
    station = np.array(origin) + distance * random.normal(size=3)
    angle = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(n) * 0.618
    radius = half_mm * np.sqrt((np.arange(n) + 0.7) / n)
    xy = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    xy += random.uniform(-0.05, 0.05, (n, 2)) * half_mm
    depth = distance * (1 + relief * random.uniform(-1, 1, n))
    ground = station + (np.column_stack([xy, np.full(n, -f_mm)]) / f_mm * depth[:, None]) @ R.T
    return Scene(project(ground, station, R, f_mm)[0], ground, R, station, f_mm)


def numbers(name: str, *columns: str) -> FloatArray:
    """Columns of tests/data/NAME as (n, k)."""
    with (DATA / name).open(encoding="utf-8", newline="") as file:
        return np.array([[float(row[column]) for column in columns] for row in csv.DictReader(file)])


def expected(name: str, key: str = "quantity", **where: str) -> dict[str, dict[str, str]]:
    """Rows of tests/data/NAME that fit `where`, by their column `key`."""
    with (DATA / name).open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if all(row[k] == v for k, v in where.items())]
    return {row[key]: row for row in rows}


def nothing_shared(n: int) -> tuple[FloatArray, FloatArray]:
    """Shifts on the ground and in the image of points without common unknowns."""
    return np.zeros((n, 3, 0)), np.zeros((n, 2, 0))
