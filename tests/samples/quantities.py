"""Finds a quantity of an expected.json in the tables of a run, by the name that the file gives it."""

import math

import numpy as np

from orient.pipeline.frames import frame_of
from orient.pipeline.ground import ground_of
from orient.solvers.packed import unpack_upper
from orient.store.project import Project
from orient.values import Tables

KEYS = {
    "image_point": ("point",),
    "image_residual": ("point",),
    "geographic_point": ("point",),
    "ground_covariance": ("point",),
    "cross_residual": ("cross",),
    "sheet_transform": ("sheet",),
    "absolute_orientation": ("zone",),
    "absolute_element": ("zone", "view", "unknown"),
    "model_ground_point": ("zone", "point"),
    "camera_element": ("unknown",),
}


class Lookup:
    """Quantities of the current versions of a project."""

    def __init__(self, project: Project) -> None:
        self.heads = project.heads()
        self.tables: dict[str, Tables] = {name: project.read_tables(run.run_id) for name, run in self.heads.items()}
        self.events = {name: project.events(run.run_id) for name, run in self.heads.items()}

    def __call__(self, stage: str, quantity: str) -> float:
        words = quantity.split(".")
        if words[0] == "sigma":
            return self._sigma(words[1:])
        if words[0] in ("ground", "geocentric"):
            return self._angle(words, "value_deg")
        if words[0] == "event":
            return float(any((event.code, event.subject) == tuple(words[1:]) for event in self.events[stage]))
        if "coefficient" in words:
            return self._coefficient(words)
        return self._cell(stage, words)

    def _cell(self, stage: str, words: list[str]) -> float:
        if len(words) == 1:
            return float(self.tables[stage]["orientation"][0][words[0]])  # type: ignore[arg-type]
        table, column = words[0], words[-1]
        rows = self.tables[stage][table]
        if keys := words[1:-1]:
            rows = [row for row in rows if [row[name] for name in KEYS[table]] == keys]
        (row,) = rows
        return float(row[column])  # type: ignore[arg-type]

    def _angle(self, words: list[str], column: str) -> float:
        frame, triple, angle = words
        (row,) = (
            row
            for row in self.tables["resection"]["orientation_angle"]
            if (row["frame"], row["triple"], row["angle"]) == (frame, triple, angle)
        )
        return float(row[column])  # type: ignore[arg-type]

    def _coefficient(self, words: list[str]) -> float:
        sheet, _, coordinate, power_u, power_v = words
        (row,) = (
            row
            for row in self.tables["digitize"]["sheet_coefficient"]
            if (row["sheet"], row["coordinate"]) == (sheet, coordinate)
            and (row["power_u"], row["power_v"]) == (int(power_u), int(power_v))
        )
        return float(row["value"])  # type: ignore[arg-type]

    def _sigma(self, words: list[str]) -> float:
        if len(words) == 3:
            return self._angle(words, "sigma_deg")
        covariance = self.station_covariance(in_geocentric_axes=words[0] == "geocentric")
        axis = "XYZ".index(words[-1][0])
        return math.sqrt(covariance[axis, axis])

    def station_covariance(self, in_geocentric_axes: bool) -> np.ndarray:
        resection = self.tables["resection"]
        packed = [row["value"] for row in resection["cofactor"] if row["unknowns"] == "rotation"]
        stored = float(resection["orientation"][0]["variance_scale"]) * unpack_upper(np.array(packed))[3:6, 3:6]  # type: ignore[arg-type]
        if not in_geocentric_axes:
            return stored
        ground = ground_of(self.tables["photo"]["photo"][0])
        frame = frame_of(self.tables["topocentric"]["topocentric_frame"][0], ground)
        turn = frame.geocentric_from_right_handed() @ frame.partner
        return turn @ stored @ turn.T
