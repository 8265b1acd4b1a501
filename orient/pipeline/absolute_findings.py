"""What a reader must know of an absolute orientation before its numbers, and why it is no result, in plain words."""

import re

import numpy as np

from orient.pipeline.absolute_zone import Errors, Zone
from orient.pipeline.findings import STRONG_CORRELATION, global_test_events, in_stored_names
from orient.pipeline.frames import Frame
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.absolute_small_angles import SmallAngleOrientation
from orient.solvers.critical_values import global_test
from orient.units import DEGREES_PER_RADIAN
from orient.values import Event

NO_FIT, POOR_FIT = 0.1, 0.01
"""Residuals as share of the control's extent: beyond the first the two sides are not similar at all."""
SOLVER_NAME = re.compile(r"\b(r_[XYZ]|[XYZ]_0)\b")


def absolute_findings(zone: Zone, found: AbsoluteOrientation, frame: Frame, errors: Errors) -> list[Event]:
    """What a reader must know before the numbers; `zone` as the adjustment saw it."""
    events = []
    if found.undetermined:
        word = "hardly" if found.is_result else "not"
        why = f"; {found.cause}" if found.cause else ""
        message = f"zone {zone.name}: {word} determined: {in_stored_names(found.undetermined, frame, SOLVER_NAME)}{why}"
        severity, code = ("warning", "weak_geometry") if found.is_result else ("error", "singular")
        events.append(Event(severity, code, zone.name, message, found.condition_ratio))  # type: ignore[arg-type]
    if found.is_mirrored:
        events.append(Event("error", "mirrored", zone.name, f"zone {zone.name}: {found.message}", found.vPv_mirrored))
    return events + (_of_a_result(zone, found, frame, errors) if found.is_result else [])


def failure(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> tuple[str, str] | None:
    """Why this is no result, and the remedy; None for a result."""
    if not found.is_result:
        code = "MIRRORED" if found.is_mirrored else found.termination.value
        return f"zone {zone.name}: {code}: {in_stored_names(found.message, frame, SOLVER_NAME)}", _hint(found)
    rms, extent = _misfit(zone, found, frame)
    if rms <= NO_FIT * extent:
        return None
    message = (
        f"zone {zone.name}: NO_FIT: control and model are not similar: the residuals are {rms:.3g} m (rms) where the "
        f"control extends over {extent:.3g} m; {_worst(zone, found)} fits worst"
    )
    return message, "Check names, units (degrees for metres?) and the order of X and Y in control.csv and model.csv."


def _misfit(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> tuple[float, float]:
    """rms length of the residuals and of the arms from the centre of the control, both in the known directions [m]."""
    arms = frame.right_handed(zone.control_ground) - found.ground_centre
    known = (frame.right_handed_matrix(zone.control_known) @ arms[:, :, None])[:, :, 0]
    rms, extent = (float(np.sqrt(np.mean(np.sum(part**2, axis=1)))) for part in (found.residuals, known))
    return rms, extent


def _worst(zone: Zone, found: AbsoluteOrientation) -> str:
    return zone.control_points[int(np.argmax(np.sum(found.residuals**2, axis=1)))]


def _fit(zone: Zone, found: AbsoluteOrientation, frame: Frame, errors: Errors) -> list[Event]:
    """Global test where sigma0 is 1 beforehand; without that, residuals that are large for the control's extent."""
    head = f"zone {zone.name}:"
    if found.redundancy == 0:
        return [Event("warning", "no_redundancy", zone.name, f"{head} no redundancy: the solution cannot be checked")]
    if errors.unit == "1":
        return _global_test(zone, found)
    rms, extent = _misfit(zone, found, frame)
    if rms <= POOR_FIT * extent:
        return []
    message = f"{head} the residuals are {100 * rms / extent:.2g} % of the control's extent; "
    return [Event("warning", "poor_fit", zone.name, f"{message}{_worst(zone, found)} fits worst", rms / extent)]


def _global_test(zone: Zone, found: AbsoluteOrientation) -> list[Event]:
    """v'Pv against chi^2 with r degrees of freedom: sigma0 is 1 beforehand."""
    ratio = float(np.sqrt(found.vPv / found.redundancy))
    head = f"zone {zone.name}: sigma0 is"
    words = f"{head} {ratio:.3g} where 1 is expected", f"{head} only {ratio:.3g} where 1 is expected"
    causes = f"a gross error or too small sigmas; {_worst(zone, found)} fits worst"
    return global_test_events(zone.name, global_test(found.vPv, found.redundancy, 1.0), ratio, words, causes)


def _of_a_result(zone: Zone, found: AbsoluteOrientation, frame: Frame, errors: Errors) -> list[Event]:
    events = _fit(zone, found, frame, errors)
    head = f"zone {zone.name}:"
    if found.is_upside_down:
        message = f"{head} the model's Z axis points down on the ground"
        events.append(Event("warning", "upside_down", zone.name, message, float(found.rotation[2, 2])))
    if any(other.is_as_good for other in found.alternatives):
        tilt = float(np.arccos(np.clip(found.alternatives[0].rotation[2, 2], -1, 1))) * DEGREES_PER_RADIAN
        message = f"{head} a second orientation, tilted by {tilt:.1f} deg, fits as well; the smaller tilt was taken"
        kind, code = ("warning", "ambiguous_model") if found.is_ambiguous else ("info", "two_solutions")
        events.append(Event(kind, code, zone.name, message, tilt))  # type: ignore[arg-type]
    for first, second, correlation in found.weak:
        if abs(correlation) > STRONG_CORRELATION:
            subject = in_stored_names(f"{first} and {second}", frame, SOLVER_NAME)
            message = f"{head} {subject} are correlated by {correlation:+.4f}"
            events.append(Event("info", "correlation", zone.name, message, correlation))
    return events


def _hint(found: AbsoluteOrientation) -> str:
    if found.is_mirrored:
        return (
            "Check the order of X and Y, the names of the points and the handedness in photo.toml; the model must be "
            "right-handed. "
            "If its Z axis does point down, use --upside-down."
        )
    if found.termination == "SINGULAR":
        return (
            "Add control off the line or plane of the rest: three heights that are not on one line, two plan positions."
        )
    return "Look at the iterations: orient sql PROJECT absolute-iterations"


def small_angle_finding(zone: Zone, small: SmallAngleOrientation) -> Event:
    """How far (111) is off the rigorous elements."""
    message = (
        f"zone {zone.name}: the small-angle formulas are off by {small.largest_gap_m:.3g} m at a control point "
        f"(second-order terms {small.second_order:.2g} of the model's size)"
    )
    return Event("info", "small_angles", zone.name, message, small.largest_gap_m)
