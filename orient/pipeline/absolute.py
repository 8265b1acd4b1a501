"""Stage `absolute`: seven parameters per zone of the model, and all model points on the ground.

Without any standard deviation, of the model (`sigma_model` or covariances in model.csv) or of the control, every
ground equation weighs the same and sigma0 comes out in metres, as in the papers. Otherwise the given covariances of
both sides are the weights and sigma0 is a number that should be near 1.
"""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from orient.errors import GeometryError
from orient.pipeline.absolute_rows import result_tables, small_angle_rows, trace_tables
from orient.pipeline.absolute_zone import Errors, Zone, control_errors, zones_of
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.tables import Array, columns, names, single
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.absolute_small_angles import orient_by_small_angles
from orient.solvers.engines import Engine
from orient.units import DEGREES_PER_RADIAN
from orient.values import Event, Outcome, Row, Settings, Tables

HEIGHT_TOLERANCE_M = 1e-3
MAX_HEIGHT_ROUNDS = 10
STRONG_CORRELATION = 0.95
NAMED = 10
SOLVER_NAME = re.compile(r"\b(r_[XYZ]|[XYZ]_0)\b")
Rows = dict[str, list[Row]]


def compute(inputs: Mapping[str, Tables], settings: Settings) -> Outcome:
    """Outcome with the orientation of every zone; if one zone has none, the whole run failed and says which."""
    ground = ground_of(single(inputs["photo"], "photo"))
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground)
    zones = zones_of(inputs["model"], inputs["topocentric"], frame, settings)
    tables: Rows = {}
    events = _unused(inputs["topocentric"], zones)
    summaries: list[str] = []
    failures: list[tuple[str, str]] = []
    for zone in zones:
        try:
            errors = control_errors(zone, settings)
            found, control = _solve(zone, errors, frame, settings)
        except GeometryError as error:
            failures.append((f"zone {zone.name}: {error.message}", error.hint))
            continue
        events += _findings(zone, found, frame)
        _add(tables, trace_tables(zone, found, frame))
        if not found.is_result:
            failures.append((f"zone {zone.name}: {_failure(found, frame)}", _hint(found)))
            continue
        use_posteriori = settings["variance"] == "posteriori" and found.redundancy > 0
        _add(tables, result_tables(zone, control, found, frame, errors, use_posteriori))
        if settings["small_angles"]:
            events.append(_small_angles(zone, control, found, errors, frame, tables, Engine(str(settings["engine"]))))
        summaries.append(_summary(zone, found, errors))
    if failures:
        return Outcome(_traces_only(tables), events, error="; ".join(text for text, _ in failures), hint=failures[0][1])
    events += _disagreements(tables.get("model_ground_point", []))
    return Outcome(tables, events, "; ".join(summaries))


def _add(tables: Rows, more: Mapping[str, Sequence[Row]]) -> None:
    for table, rows in more.items():
        tables.setdefault(table, []).extend(rows)


def _traces_only(tables: Rows) -> Rows:
    """Iterations are stored for a failure too; results of the other zones are not."""
    return {name: rows for name, rows in tables.items() if name.startswith("absolute_iteration")}


def _solve(zone: Zone, errors: Errors, frame: Frame, settings: Settings) -> tuple[AbsoluteOrientation, Zone]:
    """The orientation, and the zone with its height-only points set on the curved surface of their height."""
    for _ in range(MAX_HEIGHT_ROUNDS):
        found = orient_model(
            zone.control_model,
            frame.right_handed(zone.control_ground),
            known=frame.right_handed_matrix(zone.control_known),
            ground_cofactor=frame.right_handed_matrix(errors.ground),
            model_cofactor=errors.model,
            names=zone.control_points,
            allow_upside_down=bool(settings["upside_down"]),
            engine=Engine(str(settings["engine"])),
            tolerance=float(settings["tolerance"] or 0.0),
            max_iterations=int(settings["max_iterations"] or 0),
        )
        if frame.origin is None or not found.is_result or not zone.has_height_only:
            return found, zone
        computed = frame.right_handed(zone.control_model @ found.rotation.T / found.H + found.X0)
        zone, lift = zone.on_their_height(computed, frame)
        if lift < HEIGHT_TOLERANCE_M:
            return found, zone
    return found, zone


def _small_angles(
    zone: Zone,
    control: Zone,
    found: AbsoluteOrientation,
    errors: Errors,
    frame: Frame,
    tables: Rows,
    engine: Engine,
) -> Event:
    """(111) beside the rigorous elements: rows, and how far it is off."""
    small = orient_by_small_angles(
        found,
        control.control_model,
        frame.right_handed(control.control_ground),
        known=frame.right_handed_matrix(control.control_known),
        ground_cofactor=frame.right_handed_matrix(errors.ground),
        model_cofactor=errors.model,
        engine=engine,
    )
    _add(tables, {"absolute_small_angle": small_angle_rows(zone, small, frame)})
    message = (
        f"zone {zone.name}: the small-angle formulas are off by {small.largest_gap_m:.3g} m at a control point "
        f"(second-order terms {small.second_order:.2g} of the model's size)"
    )
    return Event("info", "small_angles", zone.name, message, small.largest_gap_m)


def _unused(topocentric: Tables, zones: Sequence[Zone]) -> list[Event]:
    """Control points that no zone of the model holds."""
    in_model = {point for zone in zones for point in zone.points}
    alone = [point for point in names(topocentric["topocentric_point"]) if point not in in_model]
    if not alone:
        return []
    listed = ", ".join(alone[:NAMED]) + (f" and {len(alone) - NAMED} more" if len(alone) > NAMED else "")
    message = f"{len(alone)} points have ground coordinates but are not in the model, not used: {listed}"
    return [Event("warning", "not_in_model", listed, message, float(len(alone)))]


def _findings(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> list[Event]:
    """What a reader must know before the numbers."""
    events = []
    if found.undetermined:
        word = "hardly" if found.is_result else "not"
        why = f"; {found.cause}" if found.cause else ""
        message = f"zone {zone.name}: {word} determined: {_in_stored_names(found.undetermined, frame)}{why}"
        severity, code = ("warning", "weak_geometry") if found.is_result else ("error", "singular")
        events.append(Event(severity, code, zone.name, message, found.condition_ratio))  # type: ignore[arg-type]
    if found.is_mirrored:
        events.append(Event("error", "mirrored", zone.name, f"zone {zone.name}: {found.message}", found.vPv_mirrored))
    return events + (_of_a_result(zone, found, frame) if found.is_result else [])


def _of_a_result(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> list[Event]:
    events = []
    head = f"zone {zone.name}:"
    if found.is_upside_down:
        message = f"{head} the model's Z axis points down on the ground"
        events.append(Event("warning", "upside_down", zone.name, message, float(found.rotation[2, 2])))
    if any(other.is_as_good for other in found.alternatives):
        tilt = float(np.arccos(np.clip(found.alternatives[0].rotation[2, 2], -1, 1))) * DEGREES_PER_RADIAN
        message = f"{head} a second orientation, tilted by {tilt:.1f} deg, fits as well; the smaller tilt was taken"
        kind, code = ("warning", "ambiguous") if found.is_ambiguous else ("info", "two_solutions")
        events.append(Event(kind, code, zone.name, message, tilt))  # type: ignore[arg-type]
    if found.redundancy == 0:
        message = f"{head} no redundancy: the solution cannot be checked"
        events.append(Event("warning", "no_redundancy", zone.name, message))
    for first, second, correlation in found.weak:
        if abs(correlation) > STRONG_CORRELATION:
            subject = _in_stored_names(f"{first} and {second}", frame)
            message = f"{head} {subject} are correlated by {correlation:+.4f}"
            events.append(Event("info", "correlation", zone.name, message, correlation))
    return events


def _in_stored_names(text: str, frame: Frame) -> str:
    """The solver's unknowns (X east, Y north) in the words of the stored frame."""
    if frame.origin is None:
        words = {"r_X": "the rotation about X", "r_Y": "the rotation about Y", "r_Z": "the rotation about Z"}
    else:
        words = {"r_X": "the tilt about grid east", "r_Y": "the tilt about grid north", "r_Z": "the turn about up"}
    if frame.partner[0, 1]:
        words |= {"X_0": "Y_0", "Y_0": "X_0"}
    return SOLVER_NAME.sub(lambda match: words.get(match.group(), match.group()), text)


def _failure(found: AbsoluteOrientation, frame: Frame) -> str:
    code = "MIRRORED" if found.is_mirrored else found.termination.value
    return f"{code}: {_in_stored_names(found.message, frame)}"


def _hint(found: AbsoluteOrientation) -> str:
    if found.is_mirrored:
        return (
            "Check the order of X and Y and the handedness in photo.toml; the model must be right-handed. "
            "If its Z axis does point down, use --upside-down."
        )
    if found.termination == "SINGULAR":
        return (
            "Add control off the line or plane of the rest: three heights that are not on one line, two plan positions."
        )
    return "Look at the iterations: orient sql PROJECT absolute-iterations"


def _disagreements(rows: Sequence[Row]) -> list[Event]:
    """The largest distance between two zones' positions of a common point."""
    by_point: dict[str, list[Row]] = {}
    for row in rows:
        by_point.setdefault(str(row["point"]), []).append(row)
    common = {point: _spread(columns(same, "X_m", "Y_m", "Z_m")) for point, same in by_point.items() if len(same) > 1}
    if not common:
        return []
    worst = max(common, key=lambda point: common[point])
    message = f"{len(common)} points lie in more than one zone; they differ by up to {common[worst]:.3g} m ({worst})"
    return [Event("info", "zones_differ", worst, message, common[worst])]


def _spread(places: Array) -> float:
    return float(np.max(np.linalg.norm(places[:, None] - places[None], axis=2)))


def _summary(zone: Zone, found: AbsoluteOrientation, errors: Errors) -> str:
    head = f"zone {zone.name}: {zone.counts}, t = {found.t:.6g}"
    if found.sigma0 is None:
        return f"{head}, no redundancy"
    return f"{head}, sigma0 {found.sigma0:.3g}{errors.unit_text}, r = {found.redundancy}"
