"""One zone of the model: its points, which of them are control, and the weights of both sides."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from orient.errors import OrientError
from orient.pipeline.frames import Frame
from orient.pipeline.tables import COVARIANCE_PARTS, UPPER_3, Array, columns, covariances, group, names
from orient.values import Row, Settings, Tables

COUNTED = {"XYZ": "full", "plan": "plan-only", "height": "height-only"}


@dataclass(frozen=True, slots=True)
class Zone:
    """Points of a zone in the order of model.csv; `rows` are their topocentric rows, None where there is none.

    `control` are the positions of the control points; `control_ground` and `control_up` (n, 3) are theirs, in the
    stored frame. `excluded`: positions of control points that were left out. `model_covariance` (N, 3, 3) in model
    units, None when nothing is said of it.
    """

    name: str
    points: Sequence[str]
    model: Array
    model_covariance: Array | None
    rows: Sequence[Row | None]
    control: Sequence[int]
    control_ground: Array
    control_up: Array
    excluded: Sequence[int] = ()

    @property
    def control_points(self) -> list[str]:
        return [self.points[index] for index in self.control]

    @property
    def control_model(self) -> Array:
        return np.asarray(self.model[list(self.control)])

    @property
    def control_rows(self) -> list[Row]:
        return [row for index in self.control if (row := self.rows[index]) is not None]

    @property
    def known_words(self) -> list[str]:
        return [str(row["known"]) for row in self.control_rows]

    @property
    def control_known(self) -> Array:
        """Projectors (n, 3, 3) onto the known directions, in the stored frame."""
        return known_directions(self.known_words, self.control_up)

    @property
    def control_axes(self) -> Array:
        """Directions (n, 3, 3), in columns, along which the ground coordinates of the control are tested, stored frame.

        The axes of a full point; of one given in part its vertical, and across it those nearest to X and Y.
        """
        e_X, e_Y, _ = np.eye(3)
        up = self.control_up
        first = e_X - up * (up @ e_X)[:, None]
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
        second = e_Y - up * (up @ e_Y)[:, None] - first * (first @ e_Y)[:, None]
        second = second / np.linalg.norm(second, axis=1, keepdims=True)
        is_full = np.array(self.known_words, dtype=np.str_) == "XYZ"
        return np.where(is_full[:, None, None], np.eye(3), np.stack([first, second, up], axis=2))

    @property
    def has_height_only(self) -> bool:
        return "height" in self.known_words

    @property
    def counts(self) -> str:
        words = self.known_words
        return ", ".join(f"{words.count(known)} {word}" for known, word in COUNTED.items() if known in words)

    def role(self, index: int) -> str:
        row = self.rows[index]
        if row is None:
            return "free"
        return "excluded" if index in self.excluded else str(row["role"])

    def of_control(self, keep: Sequence[int]) -> "Zone":
        """The zone with some of its control (places in `control`); the rest is excluded."""
        kept = list(keep)
        left_out = [index for place, index in enumerate(self.control) if place not in set(kept)]
        return replace(
            self,
            control=[self.control[place] for place in kept],
            control_ground=self.control_ground[kept],
            control_up=self.control_up[kept],
            excluded=[*self.excluded, *left_out],
        )

    def on_their_height(self, computed: Array, frame: Frame) -> tuple["Zone", float]:
        """Height-only points set on the given height over their computed plan position; and what that changed there.

        The surface of a height is curved: the plane across the vertical serves for it near one place only.
        """
        index = np.flatnonzero(np.array(self.known_words) == "height")
        given = frame.geographic(self.control_ground[index])[:, 2]
        at = frame.geographic(computed[index])
        ground, up = self.control_ground.copy(), self.control_up.copy()
        ground[index] = frame.from_geographic(at[:, 0], at[:, 1], given)
        up[index] = frame.from_geographic(at[:, 0], at[:, 1], given + 1.0) - ground[index]
        before = np.sum(self.control_up[index] * (computed[index] - self.control_ground[index]), axis=1)
        after = np.sum(up[index] * (computed[index] - ground[index]), axis=1)
        return replace(self, control_ground=ground, control_up=up), float(np.max(np.abs(after - before)))


def known_directions(known: Sequence[str], up: Array) -> Array:
    """I of a full point, I - up up' of a plan-only, up up' of a height-only one: (n, 3, 3)."""
    vertical = up[:, :, None] * up[:, None, :]
    words = np.array(known, dtype=np.str_)[:, None, None]
    return np.where(words == "height", vertical, np.eye(3) - np.where(words == "plan", vertical, 0.0))


@dataclass(frozen=True, slots=True)
class Errors:
    """Covariances of the control on the ground (n, 3, 3), stored frame, and in the model; the unit of sigma0."""

    ground: Array
    model: Array | None
    unit: str

    def at(self, keep: Sequence[int]) -> "Errors":
        """Those of some of the control."""
        return Errors(self.ground[list(keep)], None if self.model is None else self.model[list(keep)], self.unit)

    @property
    def unit_text(self) -> str:
        return " m" if self.unit == "m" else ""


def control_errors(zone: Zone, settings: Settings) -> Errors:
    """Weights of a zone: unit weights on the ground if no standard deviation is known anywhere, else what is given.

    `control` is auto (each point as it was given), fixed (no errors on the ground) or weighted (all must have some).
    """
    covariance = covariances(zone.control_rows)
    has_one = np.asarray(np.isfinite(covariance).all(axis=(1, 2)))
    if settings["control"] == "weighted" and not has_one.all():
        point = zone.control_points[int(np.argmin(has_one))]
        raise OrientError(
            f'control point "{point}" has no standard deviation, but --control weighted was asked',
            "Give sigmas in control.csv, or use --control auto.",
        )
    if settings["control"] == "fixed":
        has_one[:] = False
    n = len(zone.control)
    if zone.model_covariance is None and not has_one.any():
        return Errors(np.tile(np.eye(3), (n, 1, 1)), None, "m")
    model = None if zone.model_covariance is None else zone.model_covariance[list(zone.control)]
    return Errors(np.where(has_one[:, None, None], covariance, 0.0), model, "1")


def zones_of(model: Tables, topocentric: Tables, frame: Frame, settings: Settings) -> list[Zone]:
    """The zones in order of appearance."""
    placed = {str(row["point"]): row for row in topocentric["topocentric_point"]}
    sigma = settings["sigma_model"]
    sigma_model = None if sigma is None else float(sigma)
    return [_zone(name, rows, placed, sigma_model) for name, rows in group(model["model_point"], "zone").items()]


def _zone(name: str, rows: Sequence[Row], placed: dict[str, Row], sigma_model: float | None) -> Zone:
    points = names(rows)
    found = [placed.get(point) for point in points]
    control = [index for index, row in enumerate(found) if row is not None and row["role"] == "control"]
    control_rows = [row for row in found if row is not None and row["role"] == "control"]
    return Zone(
        name=name,
        points=points,
        model=columns(rows, "x", "y", "z"),
        model_covariance=_model_covariance(name, rows, sigma_model),
        rows=found,
        control=control,
        control_ground=columns(control_rows, "X_m", "Y_m", "Z_m"),
        control_up=columns(control_rows, "up_X", "up_Y", "up_Z"),
    )


def _model_covariance(name: str, rows: Sequence[Row], sigma_model: float | None) -> Array | None:
    """Covariances (N, 3, 3) of model.csv, with `sigma_model` for the points that have none."""
    packed = np.array([[row.get(f"cov_{part.lower()}") for part in COVARIANCE_PARTS] for row in rows], dtype=np.float64)
    given = np.isfinite(packed).all(axis=1)
    if sigma_model is None and not given.any():
        return None
    if sigma_model is None and not given.all():
        point = rows[int(np.argmin(given))]["point"]
        raise OrientError(
            f'model point "{point}" of zone "{name}" has no standard deviation, but others have',
            "Give it in model.csv, or --sigma-model for the points without one.",
        )
    full = np.tile((sigma_model or 0.0) ** 2 * np.eye(3), (len(rows), 1, 1))
    full[np.ix_(given)] = 0.0
    for column, (i, j) in enumerate(zip(*UPPER_3, strict=True)):
        full[given, i, j] = packed[given, column]
        full[given, j, i] = packed[given, column]
    return full
