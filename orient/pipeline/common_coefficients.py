"""Points of one sheet move together: dP = A (row . dc) metres, c = coefficients of the sheet's polynomial.

A turns north and east of the sheet to T'; row = 1, u, v, u^2 ...: the design row of the point. What is left to the
point alone is the error of its own reading and height. Source: seed 004, (1) and (4) together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from orient.geometry import polynomial
from orient.pipeline.frames import Frame
from orient.pipeline.ground import Ground, metres_per_unit
from orient.pipeline.tables import Array, columns, covariances, required
from orient.solvers.common_unknowns import CommonUnknowns
from orient.solvers.packed import unpack_upper
from orient.units import RADIANS_PER_DEGREE
from orient.values import Row, Tables


@dataclass(frozen=True, slots=True)
class Coefficient:
    """One coefficient as `sheet_coefficient` holds it."""

    sheet: str
    coordinate: str
    power_u: int
    power_v: int
    value: float

    @property
    def name(self) -> str:
        """B_1_0: coordinate and powers of u and v."""
        return f"{self.coordinate}_{self.power_u}_{self.power_v}"

    @property
    def unit(self) -> str:
        return "deg" if self.coordinate in "BL" else "m"


@dataclass(frozen=True, slots=True)
class CommonCoefficients:
    """All coefficients that the points share, in T'.

    `partials` (n, 3, k) [m per unit], zero for points of no sheet or another one; `covariance` (k, k) of the fit to the
    crosses; `own` (n, 3, 3) [m^2]: covariance of each point without the part of its sheet, NaN = taken as known;
    `digitiser_share` (k,): of the variance of each coefficient, as `SheetErrors` has it.
    """

    coefficients: Sequence[Coefficient]
    partials: Array
    covariance: Array
    own: Array
    digitiser_share: Array

    def at(self, keep: Sequence[int]) -> "CommonCoefficients":
        """The same for some of the points; the coefficients stay."""
        return replace(self, partials=self.partials[keep], own=self.own[keep])

    def in_solver(self, frame: Frame, sigma0: float) -> CommonUnknowns:
        """The same for the solver: right-handed, cofactors instead of covariances."""
        partials: Array = frame.partner @ self.partials
        names = [f"{c.name} of sheet {c.sheet}" for c in self.coefficients]
        return CommonUnknowns(partials, self.covariance / sigma0**2, names)


@dataclass(frozen=True, slots=True)
class SheetErrors:
    """Errors of the points of one sheet: `at` their places in the list, `axes` (m, 3, 3) of the sheet in T'.

    `reading`, `heights` (m, 3, 3) [m^2] in T'. `share` (2,), north and east: which part of sigma0^2 of the crosses the
    variance of one digitiser reading explains, at most 1.
    """

    at: Sequence[int]
    axes: Array
    reading: Array
    heights: Array
    share: Array

    def digitiser_share(self, covariance: Array) -> Array:
        """(m, 3, 3) in T': the digitiser's part of a covariance that the coefficients of the sheet cause."""
        turn = self.axes @ np.diag([*np.sqrt(self.share), 0.0]) @ self.axes.transpose(0, 2, 1)
        return np.asarray(turn @ covariance @ turn)


@dataclass(frozen=True, slots=True)
class _Sheet:
    """The polynomial of a sheet, and the control points that come from it: `at` their places in the list of points."""

    transform: Row
    coefficients: Sequence[Row]
    cofactor: Array
    at: Sequence[int]
    digitized: Sequence[Row]

    @property
    def has_covariance(self) -> bool:
        return self.coefficients[0]["sigma"] is not None


def common_coefficients(
    points: Sequence[Row], digitize: Tables, frame: Frame, ground: Ground
) -> CommonCoefficients | None:
    """What the points (rows of `topocentric_point`) share, None when no sheet has a covariance.

    A sheet without redundancy says nothing about the errors of its coefficients: they are taken as known.
    """
    sheets = [sheet for sheet in _sheets(points, digitize) if sheet.has_covariance]
    if not sheets:
        return None
    own = covariances(points)
    spans, blocks, listed = [], [], []
    shares: list[float] = []
    for sheet in sheets:
        axes = _axes(points, sheet, frame)
        own[sheet.at] = axes @ (_reading(sheet) + _heights(sheet)) @ axes.transpose(0, 2, 1)
        spans.append((sheet.at, axes[:, :, :2] @ _by_coefficient(sheet, ground)))
        listed += [_coefficient(row) for row in sheet.coefficients]
        blocks.append(_covariance(sheet))
        shares += np.repeat(_digitiser_share(sheet), len(sheet.cofactor)).tolist()
    partials, covariance = np.zeros((len(points), 3, len(listed))), np.zeros((len(listed), len(listed)))
    first = 0
    for (at, part), block in zip(spans, blocks, strict=True):
        span = slice(first, first + len(block))
        partials[at, :, span], covariance[span, span] = part, block
        first += len(block)
    return CommonCoefficients(listed, partials, covariance, own, np.array(shares))


def sheet_errors(points: Sequence[Row], digitize: Tables, frame: Frame) -> list[SheetErrors]:
    """Errors of the points (rows of `topocentric_point`) of each sheet but for those of its polynomial."""
    found = []
    for sheet in _sheets(points, digitize):
        axes = _axes(points, sheet, frame)
        reading, heights = (axes @ part @ axes.transpose(0, 2, 1) for part in (_reading(sheet), _heights(sheet)))
        found.append(SheetErrors(sheet.at, axes, reading, heights, _digitiser_share(sheet)))
    return found


def _digitiser_share(sheet: _Sheet) -> Array:
    """(2,) variance of one reading of a point in metres north and east to sigma0^2 of a cross; 1 without redundancy.

    A sheet whose digitiser has no sigma of its own takes sigma0 for it: the share is then 1.
    """
    sigma0 = columns([sheet.transform], "sigma0_N_m", "sigma0_E_m")[0]
    if not np.all(sigma0 > 0):
        return np.ones(2)
    mean = columns(sheet.digitized, "cov_reading_NN_m2", "cov_reading_EE_m2")
    one_reading = mean * columns(sheet.digitized, "n_cycles")
    return np.asarray(np.minimum(np.mean(one_reading, axis=0) / sigma0**2, 1.0))


def _sheets(points: Sequence[Row], digitize: Tables) -> list[_Sheet]:
    """Sheets with control points."""
    found = []
    digitized = {(row["sheet"], row["point"]): row for row in digitize.get("digitized_point", ())}
    for transform in digitize.get("sheet_transform", ()):
        name = transform["sheet"]
        at = [index for index, row in enumerate(points) if row["sheet"] == name]
        coefficients = _in_order(transform, digitize["sheet_coefficient"])
        if at:
            packed = [required(row, "value") for row in digitize["sheet_cofactor"] if row["sheet"] == name]
            own = [digitized[name, points[index]["point"]] for index in at]
            found.append(_Sheet(transform, coefficients, unpack_upper(np.array(packed)), at, own))
    return found


def _in_order(transform: Row, rows: Sequence[Row]) -> list[Row]:
    """The coefficients of a sheet: B or N, then L or E, each in the order of the design row."""
    by_power = {
        (row["coordinate"], row["power_u"], row["power_v"]): row for row in rows if row["sheet"] == transform["sheet"]
    }
    terms = polynomial.exponents(int(required(transform, "degree")))
    coordinates = "BL" if transform["target"] == "geographic" else "NE"
    return [by_power[coordinate, j, k] for coordinate in coordinates for j, k in terms]


def _axes(points: Sequence[Row], sheet: _Sheet, frame: Frame) -> Array:
    """(m, 3, 3) from north, east of the sheet and up at each point to T'."""
    rows = [points[index] for index in sheet.at]
    latitude, longitude, _ = frame.geographic(columns(rows, "X_m", "Y_m", "Z_m")).T
    north = columns(rows, "sheet_north_deg")[:, 0] * RADIANS_PER_DEGREE
    cosine, sine, zero = np.cos(north), np.sin(north), np.zeros_like(north)
    turn = np.stack([cosine, -sine, zero, sine, cosine, zero, zero, zero, zero + 1.0], axis=-1).reshape(-1, 3, 3)
    axes: Array = frame.from_horizon(latitude, longitude) @ turn
    return axes


def _reading(sheet: _Sheet) -> Array:
    """(m, 3, 3) covariance of the reading, axes of the sheet."""
    plan = columns(sheet.digitized, "cov_reading_NN_m2", "cov_reading_NE_m2", "cov_reading_NE_m2", "cov_reading_EE_m2")
    covariance = np.zeros((len(plan), 3, 3))
    covariance[:, :2, :2] = plan.reshape(-1, 2, 2)
    return covariance


def _heights(sheet: _Sheet) -> Array:
    """(m, 3, 3) covariance of the height, zero where it is taken as known."""
    covariance = np.zeros((len(sheet.digitized), 3, 3))
    covariance[:, 2, 2] = np.nan_to_num(columns(sheet.digitized, "sigma_H_m")[:, 0]) ** 2
    return covariance


def _by_coefficient(sheet: _Sheet, ground: Ground) -> Array:
    """(m, 2, 2t): metres northwards and eastwards by the t coefficients of the first, then of the second coordinate."""
    transform = sheet.transform
    XY, scale = columns(sheet.digitized, "X_mm", "Y_mm"), required(transform, "scale_mm")
    u, v = ((XY - columns([transform], "X0_mm", "Y0_mm")[0]) / scale).T
    rows = polynomial.design(u, v, int(required(transform, "degree")))
    is_geographic = transform["target"] == "geographic"
    target = columns(sheet.digitized, *(("B_deg", "L_deg") if is_geographic else ("N_m", "E_m")))
    factors = metres_per_unit(target, is_geographic, ground)
    metres: Array = np.einsum("mc,cd,mt->mcdt", factors, np.eye(2), rows).reshape(len(rows), 2, -1)
    return metres


def _covariance(sheet: _Sheet) -> Array:
    """(2t, 2t): sigma0^2 Q of each coordinate; they are fitted apart and do not correlate."""
    t = len(sheet.cofactor)
    sigma = columns(sheet.coefficients, "sigma")[:, 0].reshape(2, t)
    sigma0 = sigma[:, 0] / np.sqrt(sheet.cofactor[0, 0])
    return np.asarray(np.kron(np.diag(sigma0**2), sheet.cofactor), dtype=np.float64)


def _coefficient(row: Row) -> Coefficient:
    return Coefficient(
        str(row["sheet"]),
        str(row["coordinate"]),
        int(required(row, "power_u")),
        int(required(row, "power_v")),
        required(row, "value"),
    )
