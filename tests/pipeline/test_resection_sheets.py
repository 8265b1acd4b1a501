"""Stage `resection` with points of map sheets: the polynomial's coefficients are unknowns that the points share."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from pyproj import Proj, Transformer

from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline import bl, digitize, resection, topocentric
from orient.pipeline.common_coefficients import CommonCoefficients, common_coefficients
from orient.pipeline.ground import ground_of
from orient.pipeline.tables import covariances
from orient.solvers.packed import unpack_upper
from orient.values import Outcome, Row, Tables
from tests.pipeline.made import Array, frame_in, image_rows, photo, random, row, settings, station_of, true_camera

FACTS = photo(station_B_deg=42.0, station_L_deg=22.0, central_meridian_deg=21.0, sigma_image_mm=0.002)
"""Photo of made.py over 42 N, 22 E: T' is turned by 0.67 degrees, grid north of the zone of 27 E by 3.4."""

CONIC = Proj("+proj=lcc +lat_1=41 +lat_2=43 +lat_0=42 +lon_0=22 +ellps=WGS84")
ZONE = "EPSG:32635"
TO_ZONE = Transformer.from_crs("EPSG:4326", ZONE, always_xy=True)
READING_MM, CROSS_MM, HEIGHT_M = 0.02, 0.12, 5.0
PLACES = random("sheet places")
LATITUDES, LONGITUDES = 42.0 + PLACES.uniform(-0.75, 0.75, 30), 22.0 + PLACES.uniform(-0.9, 0.9, 30)
HEIGHTS = PLACES.uniform(0.0, 1800.0, 30)


@dataclass(frozen=True)
class Sheet:
    """A sheet 1:500 000 with graticule or grid, its crosses and its points (places in the list of all points)."""

    name: str
    points: tuple[int, ...]
    is_grid: bool = False
    crosses: int = 6

    def on_paper(self, latitude: Array, longitude: Array) -> Array:
        """X, Y [mm], the sheet turned on the digitiser."""
        drawn = np.column_stack(CONIC(longitude, latitude)) * 2e-3
        if self.is_grid:
            drawn = (np.column_stack(TO_ZONE.transform(longitude, latitude)) - [86_000.0, 4_660_000.0]) * 2e-3
        return np.asarray(drawn @ [[0.999, 0.03], [-0.03, 1.001]] + [400.0, 300.0])

    def rows(self, chance: np.random.Generator | None) -> dict[str, list[Row]]:
        """map_sheet, graticule_cross and digitizer_reading, without errors when there is no chance."""
        B, L = (side.ravel() for side in np.meshgrid(*self._lines(), indexing="ij"))
        noise = np.zeros((2, max(len(B), 30), 2)) if chance is None else chance.normal(size=(2, max(len(B), 30), 2))
        target = [{"B_deg": float(b), "L_deg": float(l)} for b, l in zip(B, L, strict=True)]
        if self.is_grid:
            east_north = zip(*TO_ZONE.transform(L, B), strict=True)
            target = [{"E_m": float(E), "N_m": float(N)} for E, N in east_north]
        XY = self.on_paper(B, L) + CROSS_MM * noise[0, : len(B)]
        crosses = [
            row("graticule_cross", seq=i, sheet=self.name, cross=f"{i}", role="fit", X_mm=float(X), Y_mm=float(Y), **at)
            for i, ((X, Y), at) in enumerate(zip(XY, target, strict=True))
        ]
        at = list(self.points)
        XY = self.on_paper(LATITUDES[at], LONGITUDES[at]) + READING_MM * noise[1, : len(at)]
        heights = HEIGHTS[at] + (0.0 if chance is None else HEIGHT_M * chance.normal(size=len(at)))
        readings = [
            row("digitizer_reading", seq=i, sheet=self.name, point=f"P{i:02}", cycle=1, X_mm=float(X), Y_mm=float(Y),
                H_m=float(H), sigma_H_m=HEIGHT_M)
            for i, (X, Y), H in zip(at, XY, heights, strict=True)
        ]  # fmt: skip
        sheet = row("map_sheet", sheet=self.name, title="", degree=3, sigma_mm=READING_MM, crs=self._crs())
        return {"map_sheet": [sheet], "graticule_cross": crosses, "digitizer_reading": readings}

    def _lines(self) -> tuple[Array, Array]:
        return np.linspace(41.1, 42.9, self.crosses), np.linspace(20.9, 23.1, self.crosses)

    def _crs(self) -> str | None:
        return ZONE if self.is_grid else None


GRATICULE, GRID = Sheet("K-34", tuple(range(16))), Sheet("zone 35", tuple(range(16, 28)), is_grid=True)


def inputs(
    sheets: Sequence[Sheet], seed: str | None = None, checks: Sequence[str] = (), given: Sequence[int] = ()
) -> dict[str, Tables]:
    """What the resection reads, through digitize, bl and topocentric; `given`: points that control.csv gives too."""
    chance = None if seed is None else random(seed)
    tables: dict[str, list[Row]] = {}
    for sheet in sheets:
        for name, rows in sheet.rows(chance).items():
            tables.setdefault(name, []).extend(rows)
    control = control_rows(checks, given)
    digitized = digitize.compute({"photo": FACTS, "sheet": tables}, settings("digitize")).tables
    placed = {"photo": FACTS, "digitize": digitized, "control": control}
    geographic = bl.compute(placed, settings("bl")).tables
    ground = topocentric.compute({"photo": FACTS, "bl": geographic}, {}).tables
    image = true_image() if chance is None else true_image() + chance.normal(scale=0.002, size=(30, 2))
    names = [f"P{i:02}" for i in range(30)]
    refined = {"image_point": image_rows(names, image, 0.002)}
    return {"photo": FACTS, "refine": refined, "topocentric": ground, "digitize": digitized, "bl": geographic}


def control_rows(checks: Sequence[str], given: Sequence[int]) -> Tables:
    rows = [row("control_point", point=name, role="check", kind="none") for name in checks]
    rows += [
        row("control_point", point=f"P{i:02}", role="control", kind="geographic", B_deg=float(LATITUDES[i]),
            L_deg=float(LONGITUDES[i]), H_m=float(HEIGHTS[i]))
        for i in given
    ]  # fmt: skip
    return {"control_point": rows, "control_system": [row("control_system")]}


@cache
def true_image() -> Array:
    """(30, 2): the points seen by the camera of made.py."""
    frame = frame_in(FACTS, inputs_without_image().tables)
    xyz = frame.right_handed(frame.from_geographic(np.radians(LATITUDES), np.radians(LONGITUDES), HEIGHTS))
    station, rotation = true_camera()
    return project(xyz, station, rotation, 200.0)[0]


def inputs_without_image() -> Outcome:
    one = row("geographic_point", point="A", role="control", source="control", weighting="fixed", B_deg=42.0,
              L_deg=22.0, H_m=0.0)  # fmt: skip
    return topocentric.compute({"photo": FACTS, "bl": {"geographic_point": [one]}}, {})


def oriented(read: dict[str, Tables], **given: str) -> Outcome:
    outcome = resection.compute(read, settings("resection", **{"variance": "priori", **given}))
    assert outcome.error == ""
    return outcome


def common_of(read: dict[str, Tables]) -> CommonCoefficients:
    points = read["topocentric"]["topocentric_point"]
    found = common_coefficients(
        points, read["digitize"], frame_in(FACTS, read["topocentric"]), ground_of(FACTS["photo"][0])
    )
    assert found is not None
    return found


def places_of(read: dict[str, Tables]) -> Array:
    return np.array(
        [[point[axis] for axis in ("X_m", "Y_m", "Z_m")] for point in read["topocentric"]["topocentric_point"]]
    )


# ------------------------------------------------------------------------------------------- what the points share


@pytest.mark.parametrize("sheet", [GRATICULE, GRID], ids=lambda sheet: sheet.name)
def test_partials_are_what_a_changed_coefficient_does_to_t_prime(sheet: Sheet) -> None:
    """Each coefficient moved by about 10 m at the sheet's edge, through bl (with grid convergence) and topocentric."""
    read = inputs([sheet], "partials")
    common = common_of(read)
    (transform,) = read["digitize"]["sheet_transform"]
    for k, one in enumerate(common.coefficients):
        step = 10.0 if sheet.is_grid else 1e-4
        moved = []
        for point in read["digitize"]["digitized_point"]:
            u, v = ((point[axis] - transform[f"{axis[0]}0_mm"]) / transform["scale_mm"] for axis in ("X_mm", "Y_mm"))
            column = f"{one.coordinate}_{one.unit}"
            moved.append({**point, column: point[column] + step * u**one.power_u * v**one.power_v})
        placed = {"photo": FACTS, "digitize": {**read["digitize"], "digitized_point": moved}}
        geographic = bl.compute(placed, settings("bl")).tables
        after = places_of({"topocentric": topocentric.compute({"photo": FACTS, "bl": geographic}, {}).tables})
        expected = (after - places_of(read)) / step
        largest = np.abs(expected).max()
        # metres per degree at the ellipsoid instead of the point's height (2 km): 3e-4; the grid's scale: 4e-4 ... 3e-3
        np.testing.assert_allclose(common.partials[:, :, k], expected, atol=4e-3 * largest, rtol=0)
        cosine = np.sum(common.partials[:, :2, k] * expected[:, :2]) / np.linalg.norm(expected[:, :2])
        assert cosine / np.linalg.norm(common.partials[:, :2, k]) == pytest.approx(1.0, abs=1e-6)


def test_the_parts_of_a_point_s_covariance_sum_to_what_topocentric_stores() -> None:
    read = inputs([GRATICULE, GRID], "covariance")
    common = common_of(read)
    whole = common.own + common.partials @ common.covariance @ common.partials.transpose(0, 2, 1)
    stored = covariances(read["topocentric"]["topocentric_point"])
    np.testing.assert_allclose(whole, stored, rtol=0, atol=1e-9 * np.abs(stored).max())
    shared = np.trace(whole - common.own, axis1=1, axis2=2) / np.trace(whole, axis1=1, axis2=2)
    assert shared.min() > 0.2


def test_points_of_two_sheets_share_nothing() -> None:
    common = common_of(inputs([GRATICULE, GRID], "two"))
    assert [one.sheet for one in common.coefficients] == ["K-34"] * 20 + ["zone 35"] * 20
    assert np.all(common.partials[:16, :, 20:] == 0)
    assert np.all(common.partials[16:, :, :20] == 0)
    assert np.all(common.covariance[:20, 20:] == 0)
    assert [one.name for one in common.coefficients[:3]] == ["B_0_0", "B_1_0", "B_0_1"]
    assert [one.unit for one in common.coefficients[::10]] == ["deg", "deg", "m", "m"]


def test_stored_order_of_the_coefficients_does_not_matter() -> None:
    """The project file hands them back by name, B before L but E before N."""
    read = inputs([GRID], "order")
    shuffled = sorted(read["digitize"]["sheet_coefficient"], key=lambda row: (row["coordinate"], row["power_u"]))
    again = common_of({**read, "digitize": {**read["digitize"], "sheet_coefficient": shuffled}})
    np.testing.assert_array_equal(again.partials, common_of(read).partials)


def test_a_point_that_control_gives_does_not_share_the_sheet() -> None:
    """Even on a sheet that somebody named "control"."""
    read = inputs([replace(GRATICULE, name="control")], "control wins", given=[3])
    points = read["topocentric"]["topocentric_point"]
    common = common_of(read)
    at = [point["point"] for point in points].index("P03")
    assert points[at]["sheet"] is None
    assert np.all(common.partials[at] == 0)
    assert np.isnan(common.own[at]).all()
    assert np.abs(common.partials).sum(axis=(1, 2)).min(initial=np.inf, where=np.arange(len(points)) != at) > 0


def test_a_sheet_without_redundancy_shares_nothing() -> None:
    """As many crosses as coefficients leave no sigma: the errors of the polynomial are not known."""
    read = inputs([GRATICULE], "none")
    without = [{**entry, "sigma": None} for entry in read["digitize"]["sheet_coefficient"]]
    points = read["topocentric"]["topocentric_point"]
    frame, ground = frame_in(FACTS, read["topocentric"]), ground_of(FACTS["photo"][0])
    assert common_coefficients(points, {**read["digitize"], "sheet_coefficient": without}, frame, ground) is None
    assert common_coefficients(points, {}, frame, ground) is None


# --------------------------------------------------------------------------------------------------- the stage


def test_equations_unknowns_and_stored_coefficients() -> None:
    read = inputs([GRATICULE, GRID], "stored")
    outcome = oriented(read)
    (found,) = outcome.tables["orientation"]
    assert (found["n_equations"], found["n_unknowns"], found["redundancy"]) == (56 + 84 + 40, 6 + 84 + 40, 50)
    adjusted = outcome.tables["adjusted_coefficient"]
    fitted = {
        (one["sheet"], one["coordinate"], one["power_u"], one["power_v"]): one
        for one in read["digitize"]["sheet_coefficient"]
    }
    assert len(adjusted) == 40
    for one in adjusted:
        before = fitted[one["sheet"], one["coordinate"], one["power_u"], one["power_v"]]
        assert one["value"] - before["value"] == pytest.approx(one["correction"], abs=1e-9 * abs(before["value"]))
        assert abs(one["correction"]) < 5 * before["sigma"]
        assert 0 < one["variance_ratio"] <= 1 + 1e-12
        sigma = found["sigma0_apriori_mm"] * np.sqrt(one["q"])
        assert sigma == pytest.approx(before["sigma"] * np.sqrt(one["variance_ratio"]))
    assert min(one["variance_ratio"] for one in adjusted) < 0.98


def test_iterations_hold_the_coefficients_as_unknowns_of_their_sheet() -> None:
    outcome = oriented(inputs([GRATICULE, GRID], "stored"))
    of_sheet = [one for one in outcome.tables["iteration_parameter"] if one["point"] == "zone 35"]
    last = max(one["iteration"] for one in of_sheet)
    assert {(one["unknown"], one["unit"]) for one in of_sheet} >= {("N_0_0", "m"), ("E_2_1", "m")}
    end = {one["unknown"]: one["approximation"] + one["correction"] for one in of_sheet if one["iteration"] == last}
    for one in outcome.tables["adjusted_coefficient"]:
        if one["sheet"] == "zone 35":
            assert end[f"{one['coordinate']}_{one['power_u']}_{one['power_v']}"] == pytest.approx(
                one["value"], rel=1e-12
            )


def test_errorless_sheets_give_the_truth() -> None:
    """All of it rounding and the polynomial's own model error of a few decimetres."""
    outcome = oriented(inputs([GRATICULE, GRID]))
    frame = frame_in(FACTS, inputs([GRATICULE])["topocentric"])
    assert frame.right_handed(station_of(outcome)) == pytest.approx(true_camera()[0], abs=3.0)


def test_each_point_apart_and_without_errors() -> None:
    """--correlation point and --control fixed: no common unknowns."""
    read = inputs([GRATICULE], "apart")
    apart, fixed = oriented(read, correlation="point"), oriented(read, control="fixed")
    without = oriented({name: read[name] for name in ("photo", "refine", "topocentric")})
    assert apart.tables["orientation"] == without.tables["orientation"]
    assert apart.tables["adjusted_coefficient"] == fixed.tables["adjusted_coefficient"] == []
    assert apart.tables["orientation"][0]["n_unknowns"] == 6 + 48
    assert fixed.tables["orientation"][0]["n_unknowns"] == 6


def test_check_points_of_a_sheet_leave_it_alone() -> None:
    """A sheet with check points only is no unknown; those of the other are not moved."""
    names = [f"P{i:02}" for i in GRID.points] + ["P05"]
    outcome = oriented(inputs([GRATICULE, GRID], "checks", checks=names))
    assert {one["sheet"] for one in outcome.tables["adjusted_coefficient"]} == {"K-34"}
    assert outcome.tables["orientation"][0]["n_control"] == 15


# ---------------------------------------------------------------------------------------------------- Monte Carlo


def error_of(outcome: Outcome, read: dict[str, Tables]) -> tuple[float, Array]:
    """e'Q^-1 e / 6 and e / sigma of the elements, all errors from readings on paper and photo."""
    (found,) = outcome.tables["orientation"]
    frame = frame_in(FACTS, read["topocentric"])
    station, rotation = true_camera()
    turned = matrix_from_quaternion(np.array([found[name] for name in ("q_w", "q_x", "q_y", "q_z")])) @ rotation.T
    moved = station_of(outcome) - frame.right_handed(station)
    e = np.array([turned[2, 1], turned[0, 2], turned[1, 0], *moved])
    packed = [one["value"] for one in outcome.tables["cofactor"] if one["unknowns"] == "rotation"]
    covariance = float(found["variance_scale"]) * unpack_upper(np.array(packed))  # type: ignore[arg-type]
    return float(e @ np.linalg.solve(covariance, e)) / 6, e / np.sqrt(np.diag(covariance))


def simulated(trials: int, correlation: str) -> tuple[float, Array]:
    """Mean e'Q^-1 e / 6, and rms of e / sigma, of one sheet with 25 points digitised `trials` times."""
    sheet = replace(GRATICULE, points=tuple(range(25)), crosses=9)
    wholes, parts = [], []
    for trial in range(trials):
        read = inputs([sheet], f"trial {trial}")
        whole, part = error_of(oriented(read, correlation=correlation), read)
        wholes.append(whole)
        parts.append(part)
    return float(np.mean(wholes)), np.sqrt(np.mean(np.square(parts), axis=0))


def test_sigmas_tell_the_truth_only_with_common_unknowns() -> None:
    """e'Q^-1 e / 6 is 1.09 in these 40 trials (1 +- 0.09 expected) with common unknowns, and 4.5 with each point apart.

    Each point apart, the sigmas of Z_S and of the turn about up are half of what they should be (rms of e / sigma 2.0
    and 2.3): the scale and the turn of the sheet are the same for all points and do not average out.
    """
    whole, parts = simulated(40, "sheet")
    assert whole == pytest.approx(1.0, abs=0.35)
    np.testing.assert_allclose(parts, 1.0, atol=0.35)
    whole, parts = simulated(40, "point")
    assert whole > 3.0
    assert parts[2] > 1.6
    assert parts[5] > 1.6


@pytest.mark.slow
def test_400_trials_agree_with_Q() -> None:
    """sigma0 of the sheet's fit is estimated from its 81 crosses: e'Q^-1 e / 6 should be about 1.03."""
    whole, parts = simulated(400, "sheet")
    assert whole == pytest.approx(1.03, abs=0.1)
    np.testing.assert_allclose(parts, 1.0, atol=0.12)
