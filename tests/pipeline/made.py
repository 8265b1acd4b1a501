"""Hand-made rows for the stages, and a photo of known truth on the Earth or on local ground."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_opk
from orient.pipeline import resection, topocentric
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.registry import BY_NAME
from orient.store.format import current_format
from orient.values import Outcome, Row, Scalar, Tables

Array = NDArray[np.float64]
A_M, INVERSE_FLATTENING = 6378137.0, 298.257223563
COVARIANCE = ("cov_XX_m2", "cov_XY_m2", "cov_XZ_m2", "cov_YY_m2", "cov_YZ_m2", "cov_ZZ_m2")
UPPER = np.triu_indices(3)


def random(name: str) -> np.random.Generator:
    """Random numbers that depend on the test's name only."""
    return np.random.default_rng(zlib.crc32(name.encode()))


def row(table: str, **given: Scalar) -> Row:
    """A row with every column of the table; what is not given is NULL."""
    columns = [name for name in current_format().tables[table].names if name != "run_id"]
    assert set(given) <= set(columns), set(given) - set(columns)
    return {column: given.get(column) for column in columns}


def photo(**given: Scalar) -> Tables:
    """A frame photo on the WGS 84 ellipsoid; `given` replaces columns."""
    columns: dict[str, Scalar] = {
        "name": "made", "platform": "space", "f_mm": 200.0, "x0_mm": 0.0, "y0_mm": 0.0, "sigma_image_mm": 0.004,
        "interior_transformation": "none", "distortion_model": "none", "distortion_direction": "correction",
        "refraction": "none", "ground_kind": "ellipsoid", "ellipsoid": "WGS 84", "a_m": A_M,
        "inverse_flattening": INVERSE_FLATTENING, "ground_height_m": 500.0,
    }  # fmt: skip
    return {"photo": [row("photo", **{**columns, **given})]}


def local(handedness: str, **given: Scalar) -> Tables:
    none = {"ellipsoid": None, "a_m": None, "inverse_flattening": None, "ground_height_m": None}
    return photo(**{"ground_kind": "local", "handedness": handedness, **none, **given})


def settings(stage: str, **given: Scalar | bool) -> dict[str, str | int | float | bool | None]:
    return {**BY_NAME[stage].settings, **given}


def covariance_of(matrix: Array | None) -> dict[str, Scalar]:
    if matrix is None:
        return dict.fromkeys(COVARIANCE)
    return dict(zip(COVARIANCE, matrix[UPPER].tolist(), strict=True))


def matrix_of(stored: Row) -> Array:
    full = np.zeros((3, 3))
    full[UPPER] = [stored[name] for name in COVARIANCE]
    return full + np.triu(full, 1).T


@dataclass(frozen=True)
class Place:
    """A point of the ground: B, L [deg], H or X, Y, Z; None = not given. `seen` is where it really is."""

    name: str
    given: tuple[float | None, float | None, float | None]
    seen: tuple[float, float, float]
    role: str = "control"
    covariance: Array | None = None


def places(count: int, name: str, extent_deg: float = 0.8) -> list[Place]:
    """Points around B 42, L 22 with heights up to 2 km."""
    chance = random(name)
    plan = np.array([42.0, 22.0]) + chance.uniform(-extent_deg, extent_deg, (count, 2))
    heights = chance.uniform(0.0, 2000.0, count)
    whole = [(float(B), float(L), float(H)) for (B, L), H in zip(plan, heights, strict=True)]
    return [Place(f"P{number:02}", place, place) for number, place in enumerate(whole, 1)]


def geographic_rows(chosen: Sequence[Place], is_local: bool = False) -> list[Row]:
    keys = ("X_m", "Y_m", "Z_m") if is_local else ("B_deg", "L_deg", "H_m")
    return [
        row(
            "geographic_point", point=place.name, role=place.role, source="control",
            weighting="fixed" if place.covariance is None else "weighted",
            **dict(zip(keys, place.given, strict=True)), **covariance_of(place.covariance),
        )
        for place in chosen
    ]  # fmt: skip


def framed(facts: Tables, rows: Sequence[Row]) -> Tables:
    return topocentric.compute({"photo": facts, "bl": {"geographic_point": rows}}, {}).tables


def frame_in(facts: Tables, tables: Tables) -> Frame:
    return frame_of(tables["topocentric_frame"][0], ground_of(facts["photo"][0]))


def true_camera() -> tuple[Array, Array]:
    """Station and rotation in the right-handed frame: 250 km up, looking nearly down."""
    station = np.array([11_000.0, -7_000.0, 250_000.0])
    return station, matrix_from_opk(0.03, -0.04, 0.7).T


def image_rows(names: Sequence[str], image: Array, sigma_mm: float = 0.004) -> list[Row]:
    variance = sigma_mm**2
    return [
        row("image_point", point=name, x_mm=float(x), y_mm=float(y), cov_xx_mm2=variance, cov_xy_mm2=0.0,
            cov_yy_mm2=variance)
        for name, (x, y) in zip(names, image, strict=True)
    ]  # fmt: skip


def inputs_of(facts: Tables, chosen: Sequence[Place], noise_mm: float = 0.0, seed: str = "") -> dict[str, Tables]:
    """What the resection reads, for a photo that sees the places where they are."""
    is_local = facts["photo"][0]["ground_kind"] == "local"
    given = framed(facts, geographic_rows(chosen, is_local))
    frame = frame_in(facts, given)
    seen = np.array([place.seen for place in chosen])
    if not is_local:
        seen = frame.from_geographic(*np.radians(seen[:, :2]).T, seen[:, 2])
    station, rotation = true_camera()
    f_mm = facts["photo"][0]["f_mm"]
    image, zs = project(frame.right_handed(seen), station, rotation, float(f_mm))  # type: ignore[arg-type]
    assert np.all(zs < 0)
    if noise_mm:
        image = image + random(seed).normal(scale=noise_mm, size=image.shape)
    refined = {"image_point": image_rows([place.name for place in chosen], image)}
    return {"photo": facts, "refine": refined, "topocentric": given}


def oriented(inputs: Mapping[str, Tables], **given: Scalar) -> Outcome:
    outcome = resection.compute(inputs, settings("resection", **given))
    assert outcome.error == ""
    return outcome


def station_of(outcome: Outcome) -> Array:
    (found,) = outcome.tables["orientation"]
    return np.array([found[name] for name in ("X_S_m", "Y_S_m", "Z_S_m")])


def quaternion_of(outcome: Outcome) -> Array:
    (found,) = outcome.tables["orientation"]
    return np.array([found[name] for name in ("q_w", "q_x", "q_y", "q_z")])
