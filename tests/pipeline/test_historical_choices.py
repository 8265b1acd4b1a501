"""Settings that show what the paper did: the N polynomial, and the two ways to choose the degree of a sheet."""

from pathlib import Path

import numpy as np
import pytest

from orient.errors import OrientError
from orient.geodesy.ellipsoid import KRASOVSKY, WGS84, Ellipsoid
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline import digitize, topocentric
from orient.pipeline.registry import BY_NAME
from orient.pipeline.runner import create, run_stage, run_stale
from orient.store.format import current_format
from orient.store.project import open_project
from orient.values import Outcome, Row, Scalar

SPACE = Path(__file__).parents[2] / "sample_projects" / "simulated-space-krasovsky"
METRES_PER_MM = 500.0


def row(table: str, **given: Scalar) -> Row:
    """A row with every column of the table; what is not given is NULL."""
    columns = [name for name in current_format().tables[table].names if name != "run_id"]
    return {column: given.get(column) for column in columns}


def photo(figure: Ellipsoid) -> Row:
    return row(
        "photo", ground_kind="ellipsoid", ellipsoid=figure.name, a_m=figure.a_m,
        inverse_flattening=figure.inverse_flattening, station_B_deg=42.7, station_L_deg=23.0, ground_height_m=500.0,
    )  # fmt: skip


def framed(facts: Row, radius: str) -> Outcome:
    names = ("X_m", "Y_m", "Z_m") if facts["ground_kind"] == "local" else ("B_deg", "L_deg", "H_m")
    places = [(42.7 + i, 23.0 - 0.5 * i, 100.0 * i) for i in range(3)]
    points = [
        row(
            "geographic_point", point=f"P{i}", role="control", weighting="fixed", **dict(zip(names, place, strict=True))
        )
        for i, place in enumerate(places)
    ]
    inputs = {"photo": {"photo": [facts]}, "bl": {"geographic_point": points}}
    return topocentric.compute(inputs, {**BY_NAME["topocentric"].settings, "radius": radius})


class TestRadius:
    def test_the_difference_is_told_in_metres(self) -> None:
        exact, polynomial = (framed(photo(KRASOVSKY), radius) for radius in ("exact", "polynomial"))
        T = [
            np.array(
                [[point[name] for name in ("X_T_m", "Y_T_m", "Z_T_m")] for point in outcome.tables["topocentric_point"]]
            )
            for outcome in (exact, polynomial)
        ]
        lengths = np.linalg.norm(T[1] - T[0], axis=1)
        assert 1e-7 < np.max(lengths) < 1e-5
        assert [event.code for event in exact.events] == []
        (event,) = polynomial.events
        assert (event.code, event.severity, event.subject) == ("radius_polynomial", "info", f"P{np.argmax(lengths)}")
        assert event.value == pytest.approx(np.max(lengths), rel=1e-2)
        assert f"{event.value:.1e} m" in event.message

    def test_another_ellipsoid_is_refused_by_name(self) -> None:
        with pytest.raises(OrientError, match="Krasovsky ellipsoid only, not for WGS 84"):
            framed(photo(WGS84), "polynomial")

    def test_local_ground_has_no_radius(self) -> None:
        with pytest.raises(OrientError, match="local Cartesian ground has no radius N"):
            framed(row("photo", ground_kind="local", handedness="right"), "polynomial")

    def test_the_orientation_does_not_notice(self, tmp_path: Path) -> None:
        """A whole run of the simulated space photo: the station moves by less than the reading of the polynomial."""
        path = tmp_path / "photo.sqlite"
        create(path, read_project(SPACE, ReadOptions()), "test")
        stations = []
        for radius in ("exact", "polynomial"):
            run_stale(path, {}, "test", lambda stage: None, lambda result: None)
            run_stage(path, "topocentric", {"radius": radius}, "the paper's N")
            run_stage(path, "resection", {}, "again")
            with open_project(path) as opened:
                (found,) = opened.read_tables(opened.heads()["resection"].run_id)["orientation"]
                stations.append([found["X_S_m"], found["Y_S_m"], found["Z_S_m"]])
        assert stations[0] != stations[1]
        assert stations[1] == pytest.approx(stations[0], abs=1e-3)


def digitized(NE_of: np.ndarray, crosses: np.ndarray, **given: Scalar) -> Outcome:  # type: ignore[type-arg]
    tables = {
        "map_sheet": [row("map_sheet", sheet="S", crs="EPSG:32634")],
        "graticule_cross": [
            row("graticule_cross", seq=i + 1, sheet="S", cross=f"{i}", role="fit", X_mm=float(X), Y_mm=float(Y),
                N_m=float(NE_of[i, 0]), E_m=float(NE_of[i, 1]))
            for i, (X, Y) in enumerate(crosses)
        ],
    }  # fmt: skip
    return digitize.compute(
        {"photo": {"photo": [photo(KRASOVSKY)]}, "sheet": tables}, {**BY_NAME["digitize"].settings, **given}
    )


class TestDegree:
    """A sheet whose quadratic is so small that the F test takes it and the prediction of the crosses does not."""

    PLACES = np.array([(x, y) for x in np.linspace(0.0, 400.0, 5) for y in np.linspace(0.0, 400.0, 5)])

    def crosses(self) -> np.ndarray:  # type: ignore[type-arg]
        for seed in range(1000):
            read = self.PLACES + np.random.default_rng(seed).normal(0.0, 0.1, self.PLACES.shape)
            codes = [event.code for event in digitized(METRES_PER_MM * self.PLACES, read).events]
            if "degree_choices" in codes:
                return read
        raise AssertionError("no sheet on which the two differ")

    def test_both_are_told_when_they_differ_and_the_setting_decides(self) -> None:
        read, NE = self.crosses(), METRES_PER_MM * self.PLACES
        by = {choice: digitized(NE, read, choice=choice) for choice in ("f-test", "leave-one-out")}
        degrees = {choice: outcome.tables["sheet_transform"][0]["degree"] for choice, outcome in by.items()}
        assert degrees["f-test"] != degrees["leave-one-out"]
        for choice, outcome in by.items():
            assert outcome.tables["sheet_transform"][0]["degree_chosen_by"] == choice
            (event,) = [event for event in outcome.events if event.code == "degree_choices"]
            assert (event.severity, event.subject, event.value) == ("info", "S", degrees[choice])
            assert f"f-test degree {degrees['f-test']} (predicts a cross to" in event.message
            assert f"leave-one-out degree {degrees['leave-one-out']} (predicts a cross to" in event.message
            assert event.message.endswith(f"degree {degrees[choice]} is used ({choice})")

    def test_a_given_degree_is_not_discussed(self) -> None:
        outcome = digitized(METRES_PER_MM * self.PLACES, self.crosses(), degree=1, choice="leave-one-out")
        assert outcome.tables["sheet_transform"][0]["degree_chosen_by"] == "given"
        assert list(outcome.events) == []
