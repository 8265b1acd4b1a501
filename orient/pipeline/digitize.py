"""Stage `digitize`: the polynomial of every map sheet, and its points with their covariance (seed 004, (1))."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry.polynomial import exponents
from orient.pipeline.digitize_tests import cross_tests, left_out, suspect_rows
from orient.pipeline.exclusions import by_hand_in_parts, numbered
from orient.pipeline.ground import Ground, ground_of, metres_per_unit
from orient.pipeline.tables import Array, columns, group, names, number, or_none, packed_rows, single
from orient.solvers.cycle_means import CycleMeans, cycle_means
from orient.solvers.engines import Engine
from orient.solvers.polynomial_degree import F_TEST, LEAVE_ONE_OUT, Crosses, Rule, degree_choices
from orient.solvers.polynomial_fit import SheetFit, Suspect, fit_sheet, predict, suspects
from orient.values import Event, Outcome, Row, Settings, Tables
from orient.words import counted


@dataclass(frozen=True, slots=True)
class Sheet:
    """One sheet on its way: what was read, on what ground, and how it is to be treated."""

    row: Row
    crosses: Sequence[Row]
    readings: Sequence[Row]
    ground: Ground
    rule: Rule
    settings: Settings
    by_hand: Sequence[int] = ()

    @property
    def reject(self) -> bool:
        return bool(self.settings["reject"])

    @property
    def name(self) -> str:
        return str(self.row["sheet"])

    @property
    def is_geographic(self) -> bool:
        return self.crosses[0]["B_deg"] is not None


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with transformation, coefficients, residuals and points of all sheets."""
    ground = ground_of(single(inputs["photo"], "photo"))
    crosses = group(inputs["sheet"]["graticule_cross"], "sheet")
    readings = group(inputs["sheet"].get("digitizer_reading", ()), "sheet")
    tables: dict[str, list[Row]] = {}
    events: list[Event] = []
    parts = []
    labels = {name: names(rows, "cross") for name, rows in crosses.items()}
    excluded = by_hand_in_parts(settings, labels, "cross")
    for row in inputs["sheet"]["map_sheet"]:
        name = str(row["sheet"])
        degree = settings["degree"] if settings["degree"] is not None else row["degree"]
        asked = None if degree is None else int(degree)
        rule = Rule(asked, str(settings["choice"]), Engine(str(settings["engine"])))
        sheet = Sheet(row, crosses[name], readings.get(name, []), ground, rule, settings, excluded[name])
        fit, fit_tables, remarks = _fitted(sheet)
        points, cycle_remarks = _points(sheet, fit)
        for table, rows in {**fit_tables, "digitized_point": points}.items():
            tables.setdefault(table, []).extend(rows)
        events += [*remarks, *cycle_remarks]
        parts.append(f"{name}: degree {fit.degree}, {_accuracy(fit)}")
    tables["exclusion"] = numbered(tables["exclusion"])
    return Outcome(tables, events, "; ".join(parts))


def _fitted(sheet: Sheet) -> tuple[SheetFit, dict[str, list[Row]], list[Event]]:
    """The polynomial of a sheet, its rows, and its bad crosses."""
    XY = columns(sheet.crosses, "X_mm", "Y_mm")
    target = columns(sheet.crosses, *(("B_deg", "L_deg") if sheet.is_geographic else ("N_m", "E_m")))
    factors = metres_per_unit(target, sheet.is_geographic, sheet.ground)
    carries = np.array([row["role"] == "fit" for row in sheet.crosses])
    labels = names(sheet.crosses, "cross")
    crosses = Crosses(XY, target, factors, sheet.name, tuple(labels))
    left = left_out(sheet, crosses, carries)
    carries = carries & ~left.crosses
    bad, cleaned = suspects(crosses, sheet.rule, carries)
    rejected = {suspect.index for suspect in bad} if sheet.reject else set()
    fit = cleaned if rejected else fit_sheet(crosses, sheet.rule, carries)
    tables = {
        "sheet_transform": [_transform_row(sheet, fit)],
        "sheet_coefficient": _coefficient_rows(sheet, fit),
        "sheet_cofactor": _cofactor_rows(sheet, fit),
        "cross_residual": _residual_rows(sheet, fit, bad, rejected | set(np.flatnonzero(left.crosses).tolist())),
        **cross_tests(sheet, fit, factors),
        "exclusion": left.rows + suspect_rows(sheet.name, labels, bad, bool(rejected)),
    }
    remarks = _two_choices(sheet, fit, crosses) + left.events
    return fit, tables, remarks + _bad_crosses(crosses, bad, cleaned, bool(rejected))


def _two_choices(sheet: Sheet, fit: SheetFit, crosses: Crosses) -> list[Event]:
    """A remark when the two rules want different degrees, with what each of them promises for a new point."""
    if sheet.rule.degree is not None:
        return []
    choices = degree_choices(crosses.only(fit.is_fit), sheet.rule.engine)
    if choices.f_test == choices.leave_one_out:
        return []
    words = (
        f"{name} degree {degree}{_predicted(choices.prediction_m.get(degree))}"
        for name, degree in ((F_TEST, choices.f_test), (LEAVE_ONE_OUT, choices.leave_one_out))
    )
    message = f"sheet {sheet.name}: {' and '.join(words)} differ; degree {fit.degree} is used ({sheet.rule.choice})"
    return [Event("info", "degree_choices", sheet.name, message, float(fit.degree))]


def _predicted(error_m: float | None) -> str:
    return "" if error_m is None else f" (predicts a cross to {error_m:.1f} m)"


def _bad_crosses(crosses: Crosses, bad: Sequence[Suspect], cleaned: SheetFit, is_rejected: bool) -> list[Event]:
    events = []
    for suspect in bad:
        north, east = cleaned.residuals_m[suspect.index]
        what = "left out" if is_rejected else "kept; leave it out with: orient digitize PROJECT --reject"
        sheet, cross = crosses.sheet, crosses.names[suspect.index]
        message = (
            f"sheet {sheet}, cross {cross}: the other crosses put it {-north:+.1f} m north, "
            f"{-east:+.1f} m east of the polynomial (chance {suspect.corrected_probability:.1e}); {what}"
        )
        events.append(Event("warning", "bad_cross", f"{sheet} {cross}", message, suspect.statistic))
    return events


def _transform_row(sheet: Sheet, fit: SheetFit) -> Row:
    north, east = (None, None) if fit.sigma0_m is None else (float(value) for value in fit.sigma0_m)
    return {
        "sheet": sheet.name,
        "degree": fit.degree,
        "degree_chosen_by": fit.degree_chosen_by,
        "target": "geographic" if sheet.is_geographic else "grid",
        "crs": sheet.row["crs"],
        "X0_mm": float(fit.centre_mm[0]),
        "Y0_mm": float(fit.centre_mm[1]),
        "scale_mm": fit.scale_mm,
        "n_crosses": fit.redundancy + len(fit.coefficients),
        "redundancy": fit.redundancy,
        "sigma0_N_m": north,
        "sigma0_E_m": east,
    }


def _coefficient_rows(sheet: Sheet, fit: SheetFit) -> list[Row]:
    diagonal = np.sqrt(np.diag(fit.cofactor))
    return [
        {
            "sheet": sheet.name,
            "coordinate": coordinate,
            "power_u": j,
            "power_v": k,
            "value": float(fit.coefficients[row, column]),
            "sigma": None if fit.sigma0 is None else float(fit.sigma0[column] * diagonal[row]),
        }
        for column, coordinate in enumerate("BL" if sheet.is_geographic else "NE")
        for row, (j, k) in enumerate(exponents(fit.degree))
    ]


def _cofactor_rows(sheet: Sheet, fit: SheetFit) -> list[Row]:
    return [{"sheet": sheet.name, **row} for row in packed_rows(fit.cofactor)]


def _residual_rows(sheet: Sheet, fit: SheetFit, bad: Sequence[Suspect], rejected: set[int]) -> list[Row]:
    suspected = {suspect.index for suspect in bad}
    return [
        {
            "sheet": sheet.name,
            "cross": row["cross"],
            "role": "rejected" if i in rejected else row["role"],
            "v_N_m": float(fit.residuals_m[i, 0]),
            "v_E_m": float(fit.residuals_m[i, 1]),
            "redundancy_number": or_none(float(fit.redundancy_numbers[i])),
            "statistic": fit.shift.statistic[i],
            "probability": fit.shift.probability[i],
            "is_suspect": int(i in suspected),
        }
        for i, row in enumerate(sheet.crosses)
    ]


def _points(sheet: Sheet, fit: SheetFit) -> tuple[list[Row], list[Event]]:
    """Mean of the cycles through the polynomial; covariance = coefficients + reading, in metres north and east."""
    if not sheet.readings:
        return [], []
    cycles = cycle_means(names(sheet.readings), columns(sheet.readings, "X_mm", "Y_mm"), reject=sheet.reject)
    predicted = predict(fit, cycles.means)
    factors = metres_per_unit(predicted.values, sheet.is_geographic, sheet.ground)
    by_reading = predicted.gradient * factors[:, :, None]
    one_reading = _reading_covariance(_reading_sigma(sheet, cycles), fit, by_reading)
    reading = one_reading / cycles.n_used[:, None, None]
    total = _coefficient_covariance(fit, predicted.cofactor, factors) + reading
    heights = _heights(sheet.readings, cycles)
    place = ("B_deg", "L_deg") if sheet.is_geographic else ("N_m", "E_m")
    rows: list[Row] = [
        {
            "sheet": sheet.name,
            "point": point,
            "n_cycles": int(cycles.n_used[i]),
            "X_mm": float(cycles.means[i, 0]),
            "Y_mm": float(cycles.means[i, 1]),
            "sigma_cycles_mm": or_none(float(cycles.sigma_point[i])),
            **dict.fromkeys(("B_deg", "L_deg", "E_m", "N_m")),
            **dict(zip(place, predicted.values[i].tolist(), strict=True)),
            **heights[point],
            **_plan_covariance("cov_", total[i]),
            **_plan_covariance("cov_reading_", reading[i]),
        }
        for i, point in enumerate(cycles.points)
    ]
    return rows, _cycle_events(sheet, cycles)


def _plan_covariance(prefix: str, matrix: Array) -> dict[str, float]:
    parts = {"NN": matrix[0, 0], "NE": matrix[0, 1], "EE": matrix[1, 1]}
    return {f"{prefix}{part}_m2": float(value) for part, value in parts.items()}


def _coefficient_covariance(fit: SheetFit, cofactor: Array, factors: Array) -> Array:
    """(k, 2, 2) m^2: f'Qf sigma0^2 of each coordinate; they are fitted apart and do not correlate."""
    covariance = np.zeros((len(cofactor), 2, 2))
    if fit.sigma0 is not None:
        variances = cofactor[:, None] * (fit.sigma0 * factors) ** 2
        covariance[:, 0, 0], covariance[:, 1, 1] = variances.T
    return covariance


def _reading_sigma(sheet: Sheet, cycles: CycleMeans) -> float | None:
    """sigma_mm of sheet.toml; else the spread of the cycles; None: a point is as uncertain as a cross."""
    stated = number(sheet.row, "sigma_mm")
    return cycles.sigma if stated is None else stated


def _reading_covariance(sigma: float | None, fit: SheetFit, by_reading: Array) -> Array:
    """(k, 2, 2) m^2 of one reading; without any sigma a reading is as uncertain as a cross."""
    if sigma is None:
        of_cross = np.zeros(2) if fit.sigma0_m is None else fit.sigma0_m
        return np.broadcast_to(np.diag(of_cross**2), by_reading.shape)
    return sigma**2 * (by_reading @ by_reading.transpose(0, 2, 1))


def _heights(readings: Sequence[Row], cycles: CycleMeans) -> dict[str, dict[str, float | None]]:
    """Height and its sigma of every point, from the first reading that gives one."""
    heights: dict[str, dict[str, float | None]] = {point: {"H_m": None, "sigma_H_m": None} for point in cycles.points}
    for row in readings:
        place = heights[str(row["point"])]
        if place["H_m"] is None and row["H_m"] is not None:
            place.update(H_m=number(row, "H_m"), sigma_H_m=number(row, "sigma_H_m"))
    return heights


def _cycle_events(sheet: Sheet, cycles: CycleMeans) -> list[Event]:
    events = []
    for i in np.flatnonzero(cycles.is_outlier):
        row, size = sheet.readings[int(i)], float(np.hypot(*cycles.deviations[i]))
        what = "kept" if cycles.is_used[i] else "left out of the mean"
        where = f"sheet {sheet.name}, point {row['point']}, cycle {row['cycle']}"
        message = f"{where}: {size:.2f} mm from the mean of its cycles, {what}"
        events.append(Event("warning", "cycle_outlier", str(row["point"]), message, size))
    return events


def _accuracy(fit: SheetFit) -> str:
    if fit.sigma0_m is None:
        return "no redundancy"
    north, east = fit.sigma0_m
    crosses = counted(fit.redundancy + len(fit.coefficients), "cross", "crosses")
    return f"{crosses}, sigma0 {north:.1f} m north, {east:.1f} m east"
