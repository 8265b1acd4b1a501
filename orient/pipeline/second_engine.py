"""The adjustments of a run solved again by other programs from the same observations, and how far they agree.

Two engines that minimise the same v'Pv stop at the same place but for rounding: a millionth of a standard deviation is
allowed, which no use of a result could see.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry.polynomial import exponents
from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline.refine import FIDUCIAL, readings_in_mm
from orient.pipeline.tables import Array, columns, names, required, single
from orient.pipeline.verify_observations import NOT_KNOWN, knows_all_unknowns, resection_observations
from orient.solvers import independent_plane, independent_polynomial, independent_resection
from orient.solvers.independent_resection import MAX_UNKNOWNS, ResectionObservations, solve_independently
from orient.solvers.packed import unpack_upper
from orient.values import Row, Settings, Tables

ALLOWED = 1e-6
SIGMAS, VALUE, BOTH_SIGMAS = "standard deviation", "value", "standard deviations of both unknowns"
TINY = 1e-300


@dataclass(frozen=True, slots=True)
class Agreement:
    """Largest difference of one kind of quantity between the stored result and the second engine."""

    engine: str
    subject: str
    quantity: str
    difference: float
    relative_to: str

    @property
    def agrees(self) -> bool:
        return self.difference <= ALLOWED


@dataclass(frozen=True, slots=True)
class Solved:
    """What a second engine found, or in `left_out` why it was not asked."""

    agreements: Sequence[Agreement] = ()
    left_out: str = ""


def solve_again(stage: str, inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> Solved:
    """Second solutions of the adjustments of a stage that has some; `stored` are the rows of the run."""
    if stage == "refine":
        return _interior(inputs, stored)
    if stage == "digitize":
        return _sheets(inputs, stored)
    if stage == "resection":
        return _resection(inputs, settings, stored)
    return Solved()


# ---------------------------------------------------------------------------------------------- resection


def _resection(inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> Solved:
    if not knows_all_unknowns(settings, inputs["photo"]):
        return Solved(left_out=NOT_KNOWN)
    row = single(stored, "orientation")
    case = resection_observations(inputs, settings, stored)
    given = case.given
    counts = (int(required(row, "n_equations")), int(required(row, "n_unknowns")))
    if counts != (given.n_equations, given.n_unknowns):
        stated = f"n = {given.n_equations}, u = {given.n_unknowns}, stored n = {counts[0]}, u = {counts[1]}"
        return Solved(left_out=f"the second engine counts otherwise: {stated}")
    if given.n_unknowns > MAX_UNKNOWNS:
        return Solved(left_out=f"{given.n_unknowns} unknowns are too many for a dense system ({MAX_UNKNOWNS})")
    found = solve_independently(given, case.station, case.rotation)
    if not found.converged:
        return Solved(left_out="the second engine did not converge")
    sigma = np.sqrt(required(row, "variance_scale") * np.diag(found.Q))
    turn = matrix_from_quaternion(columns(stored["orientation"], "q_w", "q_x", "q_y", "q_z")[0]) @ found.rotation.T
    rotated = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    largest = {
        "station": (_largest((case.station - found.station) / sigma[3:]), SIGMAS),
        "rotation": (_largest(rotated / sigma[:3]), SIGMAS),
        "cofactor": (_cofactor_gap(_stored_Q(stored, case.partner), found.Q), BOTH_SIGMAS),
    }
    if row["sigma0_mm"] is not None:
        sigma0 = (found.vPv / required(row, "redundancy")) ** 0.5
        largest["sigma0"] = (_relative(required(row, "sigma0_mm"), sigma0, _rounding(given)), VALUE)
    return Solved([Agreement(independent_resection.ENGINE, "", name, *value) for name, value in largest.items()])


def _stored_Q(stored: Tables, partner: Array) -> Array:
    """Stored cofactors of rotation and station, in the axes of the solver."""
    packed = [required(row, "value") for row in stored["cofactor"] if row["unknowns"] == "rotation"]
    turn = np.eye(6)
    turn[3:, 3:] = partner
    return np.asarray(turn @ unpack_upper(np.array(packed)) @ turn.T)


def _rounding(given: ResectionObservations) -> float:
    """sigma0 that rounding of the image coordinates alone makes: the scale below which it says nothing."""
    return float(np.max(np.abs(given.image))) * 1e-9


# ---------------------------------------------------------------------------------------------- digitize


def _sheets(inputs: Mapping[str, Tables], stored: Tables) -> Solved:
    return Solved([part for row in stored["sheet_transform"] for part in _sheet(row, inputs["sheet"], stored)])


def _sheet(transform: Row, lists: Tables, stored: Tables) -> list[Agreement]:
    """Coefficients, sigma0 and cofactors of one sheet, from the crosses that carry the fit."""
    sheet, degree = str(transform["sheet"]), int(required(transform, "degree"))
    carries = {row["cross"] for row in stored["cross_residual"] if row["sheet"] == sheet and row["role"] == "fit"}
    crosses = [row for row in lists["graticule_cross"] if row["sheet"] == sheet and row["cross"] in carries]
    uv = (columns(crosses, "X_mm", "Y_mm") - columns([transform], "X0_mm", "Y0_mm")) / required(transform, "scale_mm")
    is_geographic = transform["target"] == "geographic"
    target = columns(crosses, *(("B_deg", "L_deg") if is_geographic else ("N_m", "E_m")))
    found = independent_polynomial.fit_in_legendre(uv, target, degree)
    rows = {(row["coordinate"], row["power_u"], row["power_v"]): row for row in stored["sheet_coefficient"]
            if row["sheet"] == sheet}  # fmt: skip
    ordered = [[rows[letter, j, k] for letter in ("BL" if is_geographic else "NE")] for j, k in exponents(degree)]
    value = np.array([[required(row, "value") for row in pair] for pair in ordered])
    packed = [required(row, "value") for row in stored["sheet_cofactor"] if row["sheet"] == sheet]
    gap = _cofactor_gap(unpack_upper(np.array(packed)), found.cofactor)
    agreements = [Agreement(independent_polynomial.ENGINE, sheet, "cofactor", gap, BOTH_SIGMAS)]
    unit, relative_to = np.max(np.abs(value), axis=0), VALUE
    if found.sigma0 is not None:
        spread = np.sqrt(np.diag(found.cofactor))[:, None] * found.sigma0
        sigma = np.array([[required(row, "sigma") for row in pair] for pair in ordered])
        agreements.append(
            Agreement(independent_polynomial.ENGINE, sheet, "sigma0", _relative_all(sigma, spread), VALUE)
        )
        unit, relative_to = spread, SIGMAS
    gap = _largest((value - found.coefficients) / np.maximum(unit, TINY))
    return [Agreement(independent_polynomial.ENGINE, sheet, "coefficients", gap, relative_to), *agreements]


# ---------------------------------------------------------------------------------------------- refine


def _interior(inputs: Mapping[str, Tables], stored: Tables) -> Solved:
    """Parameters, sigma0 and sigmas of the interior orientation, from the readings that are used."""
    if not stored.get("interior_orientation"):
        return Solved()
    transformation = str(single(stored, "interior_orientation")["transformation"])
    marks = names(stored["fiducial_residual"], "mark")
    calibrated = {str(row["mark"]): row for row in inputs["photo"]["fiducial_mark"]}
    target = columns([calibrated[mark] for mark in marks], "x_mm", "y_mm")
    found = independent_plane.fit_plane(_mark_means(inputs, stored, marks), target, transformation)
    rows = {str(row["name"]): row for row in stored["interior_parameter"]}
    value = np.array([required(rows[name], "value") for name in found.parameters])
    gap, unit, relative_to = value - list(found.parameters.values()), np.maximum(np.abs(value), 1.0), VALUE
    agreements = []
    if found.redundancy > 0:
        sigma0 = (found.vv / found.redundancy) ** 0.5
        spread = sigma0 * np.sqrt(np.diag(found.cofactor))
        sigma = np.array([required(rows[name], "sigma") for name in found.parameters])
        stated = required(single(stored, "interior_orientation"), "sigma0_mm")
        pairs = (("sigma0", _relative(stated, sigma0, TINY)), ("sigmas", _relative_all(sigma, spread)))
        agreements = [Agreement(independent_plane.ENGINE, "", name, value, VALUE) for name, value in pairs]
        unit, relative_to = spread, SIGMAS
    largest = _largest(gap / np.maximum(unit, TINY))
    return Solved([Agreement(independent_plane.ENGINE, "", "parameters", largest, relative_to), *agreements])


def _mark_means(inputs: Mapping[str, Tables], stored: Tables, marks: Sequence[str]) -> Array:
    """(m, 2) mm: mean of the used readings of each mark."""
    readings = inputs["readings"]["comparator_reading"]
    xy, _ = readings_in_mm(readings, single(inputs["photo"], "photo"))
    used = {row["seq"] for row in stored["cycle_residual"] if row["is_used"] and row["kind"] == FIDUCIAL}
    means = []
    for mark in marks:
        own = [index for index, row in enumerate(readings) if row["point"] == mark and row["seq"] in used]
        means.append(xy[own].mean(axis=0))
    return np.array(means)


# ---------------------------------------------------------------------------------------------- sizes


def _largest(values: Array) -> float:
    return float(np.max(np.abs(values)))


def _relative(one: float, other: float, scale: float) -> float:
    return abs(one - other) / max(abs(one), abs(other), scale)


def _relative_all(one: Array, other: Array) -> float:
    return _largest((one - other) / np.maximum(np.maximum(np.abs(one), np.abs(other)), TINY))


def _cofactor_gap(one: Array, other: Array) -> float:
    """Largest |Q_ij - Q'_ij| / sqrt(Q'_ii Q'_jj)."""
    sigma = np.sqrt(np.diag(other))
    return _largest((one - other) / np.outer(sigma, sigma))
