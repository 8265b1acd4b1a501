"""The adjustments of a run solved again by other programs from the same observations, and how far they agree."""

from collections.abc import Mapping, Sequence

import numpy as np

from orient.geometry.polynomial import exponents
from orient.pipeline.agreement import (
    BOTH_SIGMAS,
    SIGMAS,
    TINY,
    VALUE,
    Agreement,
    Solved,
    cofactor_gap,
    largest,
    relative,
    relative_all,
)
from orient.pipeline.refine import FIDUCIAL, readings_in_mm
from orient.pipeline.second_absolute import absolute_again
from orient.pipeline.second_resection import resection_again
from orient.pipeline.tables import Array, columns, names, required, single
from orient.solvers import independent_plane, independent_polynomial
from orient.solvers.independent_algebra import MINPACK
from orient.solvers.packed import unpack_upper
from orient.values import Row, Settings, Tables


def solve_again(stage: str, inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> Solved:
    """Second solutions of the adjustments of a stage that has some; `stored` are the rows of the run."""
    if stage == "refine":
        return _interior(inputs, stored)
    if stage == "digitize":
        return _sheets(inputs, stored)
    if stage == "resection":
        return resection_again(inputs, settings, stored)
    if stage == "absolute":
        return absolute_again(inputs, settings, stored)
    return Solved()


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
    gap = cofactor_gap(unpack_upper(np.array(packed)), found.cofactor)
    agreements = [Agreement(independent_polynomial.ENGINE, sheet, "cofactor", gap, BOTH_SIGMAS)]
    unit, relative_to = np.max(np.abs(value), axis=0), VALUE
    if found.sigma0 is not None:
        spread = np.sqrt(np.diag(found.cofactor))[:, None] * found.sigma0
        sigma = np.array([[required(row, "sigma") for row in pair] for pair in ordered])
        agreements.append(Agreement(independent_polynomial.ENGINE, sheet, "sigma0", relative_all(sigma, spread), VALUE))
        unit, relative_to = spread, SIGMAS
    gap = largest((value - found.coefficients) / np.maximum(unit, TINY))
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
        pairs = (("sigma0", relative(stated, sigma0, TINY)), ("sigmas", relative_all(sigma, spread)))
        agreements = [Agreement(MINPACK, "", name, value, VALUE) for name, value in pairs]
        unit, relative_to = spread, SIGMAS
    gaps = largest(gap / np.maximum(unit, TINY))
    return Solved([Agreement(MINPACK, "", "parameters", gaps, relative_to), *agreements])


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
