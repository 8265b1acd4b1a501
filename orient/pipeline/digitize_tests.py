"""Reliability of the crosses of a sheet, and those that are left out beforehand: by hand, by robust estimation."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orient.geometry.polynomial import design
from orient.pipeline.exclusions import hand_row, robust_events, robust_row, suspect_row
from orient.pipeline.tables import Array, columns, names, number, or_none
from orient.pipeline.test_rows import adjustment_row, verdict
from orient.solvers.critical_values import ALPHA0, Limits, tau_limits, w_limits
from orient.solvers.outlier_test import LEVEL
from orient.solvers.polynomial_degree import Crosses
from orient.solvers.polynomial_fit import SheetFit, Suspect
from orient.solvers.reliability import Blocks, Reliability, most_correlated, observation_tests
from orient.solvers.robust_sheet import agreeing_crosses
from orient.values import Event, Row

if TYPE_CHECKING:
    from orient.pipeline.digitize import Sheet

MOST_CORRELATED = 200


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Crosses (n,) that do not carry the fit by decision of the user or of robust estimation."""

    crosses: NDArray[np.bool_]
    rows: list[Row]
    events: list[Event]


def left_out(sheet: "Sheet", known: Crosses, carries: NDArray[np.bool_]) -> LeftOut:
    """Crosses named by --exclude, and with --robust those that contradict the others."""
    labels = names(sheet.crosses, "cross")
    crosses = np.isin(np.arange(len(labels)), sheet.by_hand)
    rows = [hand_row(sheet.name, labels[i], sheet.settings) for i in sheet.by_hand]
    if not sheet.settings["robust"]:
        return LeftOut(crosses, rows, [])
    asked_for = carries & ~crosses
    at = np.flatnonzero(asked_for)
    wrong = at[~agreeing_crosses(known.only(asked_for), sheet.rule, number(sheet.row, "sigma_mm"))]
    crosses[wrong] = True
    rows += [robust_row(sheet.name, labels[i], None, ALPHA0) for i in wrong]
    told = robust_events(f"sheet {sheet.name}: ", [labels[i] for i in wrong], len(at), "crosses")
    return LeftOut(crosses, rows, told)


def suspect_rows(sheet: str, labels: Sequence[str], bad: Sequence[Suspect], is_rejected: bool) -> list[Row]:
    """The crosses that the test of the single crosses names."""
    return [suspect_row(sheet, labels[s.index], s.corrected_probability, LEVEL, is_rejected) for s in bad]


def cross_tests(sheet: "Sheet", fit: SheetFit, factors: Array) -> dict[str, list[Row]]:
    """adjustment_test, observation_test and point_test of the crosses that carry the fit, N and E apart."""
    used = np.flatnonzero(fit.is_fit)
    labels = [names(sheet.crosses, "cross")[i] for i in used]
    tests, observations = [], []
    for column, component in enumerate("NE"):
        limits, reliability = _component(sheet, fit, factors, column)
        vPv = 0.0 if fit.sigma0_m is None else float(fit.sigma0_m[column]) ** 2 * fit.redundancy
        tests.append(adjustment_row(sheet.name, component, vPv, fit.redundancy, None, limits))
        observations += _rows(sheet, fit, component, column, labels, reliability, limits)
    points: list[Row] = [
        {
            "part": sheet.name,
            "point": label,
            "statistic": fit.shift.statistic[i],
            "freedom": 2 if fit.shift.statistic[i] is not None else 0,
            "probability": fit.shift.probability[i],
        }
        for i, label in zip(used, labels, strict=True)
    ]
    return {"adjustment_test": tests, "observation_test": observations, "point_test": points}


def _component(sheet: "Sheet", fit: SheetFit, factors: Array, column: int) -> tuple[Limits, Reliability]:
    """Tests of one coordinate, in metres: every cross with the weight that it had in the fit."""
    XY = columns(sheet.crosses, "X_mm", "Y_mm")[fit.is_fit]
    u, v = ((XY - fit.centre_mm) / fit.scale_mm).T
    rows = design(u, v, fit.degree)[:, None, :]
    n = len(XY)
    unit = np.ones((n, 1, 1))
    # one mean factor: residuals in metres stay a projection of the errors
    factor = float(np.mean(factors[fit.is_fit, column]))
    residuals = fit.residuals_m[fit.is_fit, column] / factors[fit.is_fit, column] * factor
    limits = w_limits(1.0)
    if fit.redundancy > 0:
        limits = tau_limits(float(np.sum(residuals**2)) or 1e-300, fit.redundancy)
    reliability = observation_tests([Blocks(unit, unit, rows, residuals[:, None])], limits, rows.shape[2])
    return limits, reliability


def _rows(
    sheet: "Sheet",
    fit: SheetFit,
    component: str,
    column: int,
    labels: Sequence[str],
    reliability: Reliability,
    limits: Limits,
) -> list[Row]:
    (test,) = reliability.tests
    shift, where = _point_shifts(sheet, fit, test.effect[:, 0])
    order = np.argsort(-np.nan_to_num(np.abs(test.w[:, 0])), kind="stable")[:MOST_CORRELATED]
    near = most_correlated([test], [(0, int(i), 0) for i in order])
    v = fit.residuals_m[fit.is_fit, column]
    rows: list[Row] = []
    for i, label in enumerate(labels):
        twin = near.get((0, i, 0))
        rows.append(
            {
                "kind": "cross",
                "part": sheet.name,
                "point": label,
                "axis": component,
                "unit": "m",
                "v": float(v[i]),
                "redundancy_number": float(test.redundancy[i, 0]),
                "share": float(test.share[i, 0]),
                "w": or_none(test.w[i, 0]),
                "smallest_error": or_none(test.mdb[i, 0]),
                "bias_to_noise": or_none(test.bias_to_noise[i, 0]),
                "ground_shift_m": or_none(shift[i]),
                "ground_shift_point": where[i],
                "rho": None if twin is None else twin.rho,
                "rho_with": None if twin is None else labels[twin.partner[1]],
                "verdict": verdict(float(test.w[i, 0]), float(test.share[i, 0]), limits),
            }
        )
    return rows


def _point_shifts(sheet: "Sheet", fit: SheetFit, effect: Array) -> tuple[Array, list[str | None]]:
    """Largest shift [m] of a digitised point of the sheet by the coefficients' changes `effect` (n, m)."""
    if not sheet.readings:
        return np.full(len(effect), np.nan), [None] * len(effect)
    by_name = {str(row["point"]): row for row in sheet.readings}
    u, v = ((columns(list(by_name.values()), "X_mm", "Y_mm") - fit.centre_mm) / fit.scale_mm).T
    shifts = np.abs(effect @ design(u, v, fit.degree).T)
    largest = np.argmax(np.nan_to_num(shifts), axis=1)
    return np.take_along_axis(shifts, largest[:, None], axis=1)[:, 0], [list(by_name)[j] for j in largest]
