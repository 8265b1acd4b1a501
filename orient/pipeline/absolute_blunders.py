"""Which control points carry the orientation of a zone: by hand, by robust estimation, by data snooping."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from orient.errors import GeometryError, OrientError
from orient.pipeline.absolute_zone import Errors, Zone
from orient.pipeline.choice import Choice, Mask, choose_points, point_verdicts
from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array
from orient.solvers.absolute_checks import known_rank
from orient.solvers.absolute_problem import UNKNOWNS, Similarity
from orient.solvers.absolute_reliability import ModelControl, control_blocks, other_blocks, view_misfits
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.consensus import Trimmed, all_agreeing, least_trimmed
from orient.solvers.critical_values import Limits, tau_limits, w_limits
from orient.solvers.reliability import Blocks, Reliability, observation_tests, prediction_statistic
from orient.solvers.robust_absolute import sample_misfits
from orient.solvers.snooping import Verdicts, fit_probability
from orient.values import Settings

AGREEING = 4
"""Points that a robust orientation needs: three full ones determine the model, one checks it."""
NOISE_M, NOISE = 1e-9, 1e-6
"""sigma0 below which residuals are rounding: in metres, and in standard deviations of the covariances given."""


@dataclass(frozen=True, slots=True)
class Solved:
    """One orientation with the zone and the errors of its control, heights where the adjustment saw them."""

    found: AbsoluteOrientation
    zone: Zone
    errors: Errors


@dataclass(frozen=True, slots=True)
class Task:
    """A zone with all its control, and how it is adjusted: `adjust` (places of the control that takes part)."""

    zone: Zone
    errors: Errors
    frame: Frame
    settings: Settings
    adjust: Callable[[Sequence[int]], Solved]

    def limits(self, found: AbsoluteOrientation) -> Limits:
        """tau with sigma0 a posteriori, or w where covariances make sigma0 1 beforehand; `auto` follows `variance`."""
        test, is_known = str(self.settings["test"]), self.errors.unit == "1"
        if test == "w" and not is_known:
            raise OrientError(
                f"zone {self.zone.name}: --test w needs standard deviations; with equal weights sigma0 is not known",
                "Give sigmas in control.csv or model.csv, or --sigma-model; or use --test tau.",
            )
        if test == "auto":
            test = "w" if is_known and self.settings["variance"] == "priori" else "tau"
        if test == "w" or found.redundancy == 0:
            return w_limits(1.0)
        noise = NOISE if is_known else NOISE_M
        return tau_limits(max(found.vPv, noise**2 * found.redundancy), found.redundancy)


@dataclass(frozen=True, slots=True)
class Tested:
    """An orientation with the tests of its observations."""

    solved: Solved
    limits: Limits
    blocks: Blocks
    reliability: Reliability


def choose_control(task: Task, by_hand: Sequence[int]) -> tuple[Choice[Tested], Solved]:
    """The control points that count, and their adjustment, which need not be a result."""
    start = ~np.isin(np.arange(len(task.zone.control)), by_hand)
    choice = choose_points(
        start,
        task.settings,
        lambda kept, first: _verdicts(task, kept, task.limits),
        lambda candidates: _agreeing(task, candidates),
    )
    if choice.tested is not None:
        return choice, choice.tested.solved
    return choice, task.adjust(np.flatnonzero(choice.kept).tolist())


def model_control(zone: Zone, errors: Errors, frame: Frame) -> ModelControl:
    """The control of a zone as the solver takes it."""
    return ModelControl(
        zone.control_model,
        frame.right_handed(zone.control_ground),
        frame.right_handed_matrix(zone.control_known),
        frame.right_handed_matrix(errors.ground),
        errors.model,
        frame.partner @ zone.control_axes,
    )


def _verdicts(task: Task, kept: Mask, limits_of: Callable[[AbsoluteOrientation], Limits]) -> Verdicts[Tested] | None:
    inside, outside = np.flatnonzero(kept).tolist(), np.flatnonzero(~kept).tolist()
    try:
        solved = task.adjust(inside)
    except GeometryError:
        if kept.all():
            raise
        return None
    found = solved.found
    if not found.is_result:
        return None
    limits = limits_of(found)
    blocks = control_blocks(found, model_control(solved.zone, solved.errors, task.frame))
    reliability = observation_tests([blocks], limits, UNKNOWNS)
    tested = Tested(solved, limits, blocks, reliability)
    probability = _fit(task, tested, outside, len(kept))
    return point_verdicts(tested, found.redundancy, blocks, reliability, limits, inside, probability)


def _fit(task: Task, tested: Tested, at: list[int], n: int) -> Array:
    """(n,) chance of so large a misfit of the points that take no part; NaN elsewhere."""
    probability = np.full(n, np.nan)
    if at:
        others = model_control(task.zone.of_control(at), task.errors.at(at), task.frame)
        blocks = other_blocks(tested.solved.found, others)
        T, freedom = prediction_statistic(blocks, tested.reliability, tested.limits)
        probability[at] = fit_probability(T, freedom, tested.solved.found.redundancy, tested.limits)
    return probability


def _agreeing(task: Task, start: Mask) -> Mask:
    """Least trimmed squares from small samples; then all others that fit."""
    if task.errors.unit != "1":
        raise OrientError(
            f"zone {task.zone.name}: --robust needs standard deviations: with equal weights nothing says how well "
            "points agree that are right",
            "Give sigmas in control.csv or model.csv, or --sigma-model.",
        )
    at = np.flatnonzero(start)
    everyone = model_control(task.zone, task.errors, task.frame).at(at)

    def misfits(chosen: Mask) -> Array | None:
        try:
            found = task.adjust(at[chosen].tolist()).found
        except GeometryError:
            return None
        return view_misfits(Similarity(found.rotation, found.H, found.X0), everyone) if found.is_result else None

    freedom = known_rank(everyone.known)
    needed = max(AGREEING, int(np.ceil((UNKNOWNS + 1) / np.mean(freedom)))) if len(freedom) else AGREEING
    starts = sample_misfits(everyone, bool(task.settings["upside_down"]))
    trimmed = least_trimmed(starts, freedom, UNKNOWNS, needed, misfits)
    whole = np.zeros_like(start)
    whole[at] = trimmed.agreeing
    limits = w_limits(trimmed.scale)
    return all_agreeing(lambda kept: _verdicts(task, kept, lambda found: limits), Trimmed(whole, trimmed.scale), start)
