"""The tests of a zone's orientation as rows: each coordinate of both sides, each point, the whole; and the findings."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry.similarity import near_blind_fixed_axes
from orient.pipeline.absolute_blunders import Task, Tested, model_control
from orient.pipeline.choice import Choice, surprise
from orient.pipeline.exclusions import Decided, decision_rows, masking_events, robust_events, snooping_events
from orient.pipeline.tables import Array
from orient.pipeline.test_rows import (
    MOST_CORRELATED,
    MOST_EFFECTS,
    Shift,
    adjustment_row,
    largest_places,
    observation_row,
    point_rows,
)
from orient.solvers.absolute_reliability import GROUND, MODEL, largest_model_shift
from orient.solvers.absolute_views import VIEWS, view_changes
from orient.solvers.reliability import HARDLY, UNTESTED, BlockTests, IntArray, block_statistic, most_correlated
from orient.solvers.resection_reliability import far_apart
from orient.units import DEGREES_PER_RADIAN, listed
from orient.values import Event, Row, Tables

AXES = (("ground", "X", "m"), ("ground", "Y", "m"), ("ground", "Z", "m"),
        ("model", "x", "model"), ("model", "y", "model"), ("model", "z", "model"))  # fmt: skip
OBSERVATIONS = [f"{kind} {axis}" for kind, axis, _ in AXES]
NAMED = 10


@dataclass(frozen=True, slots=True)
class _Shifts:
    """Largest shift of a point of the zone by the smallest findable error of each observation, and of which point."""

    metres: Array
    point: Array


def test_tables(task: Task, choice: Choice[Tested], by_hand: Sequence[int]) -> tuple[Tables, list[Event]]:
    """adjustment_test, observation_test, point_test, external_reliability, exclusion of a zone; and the findings."""
    zone, tested = task.zone, choice.tested
    test = "tau" if tested is not None and tested.limits.name == "tau" else "w"
    decided = Decided(by_hand, choice.by_robust, choice.decisions)
    exclusions = decision_rows(zone.name, zone.control_points, decided, task.settings, test, OBSERVATIONS)
    wrong = [zone.control_points[i] for i in choice.by_robust]
    told = robust_events(f"zone {zone.name}: ", wrong, len(zone.control), "control points")
    if tested is None:
        return {"exclusion": exclusions}, [*snooping_events(exclusions, 1.0), *told]
    found = tested.solved.found
    known = 1.0 if task.errors.unit == "1" else None
    whole = adjustment_row(zone.name, "", found.vPv, found.redundancy, known, tested.limits)
    T, freedom = _of_points(tested)
    tables: Tables = {
        "exclusion": exclusions,
        "adjustment_test": [whole],
        "observation_test": _observation_rows(task, tested),
        "point_test": point_rows(
            zone.name, tested.solved.zone.control_points, T, freedom, found.redundancy, tested.limits
        ),
        "external_reliability": _effect_rows(task, tested),
    }
    chance = surprise(tested.reliability, tested.limits, found.redundancy)
    masked = masking_events(f"zone {zone.name}: ", whole, exclusions)
    return tables, [*snooping_events(exclusions, chance), *told, *masked, *_unchecked(zone.name, tested)]


def _of_points(tested: Tested) -> tuple[Array, IntArray]:
    """T and its freedom: by the ground coordinates; by the model's where the ground has no errors."""
    (test,) = tested.reliability.tests
    by_ground, by_model = (block_statistic(test, side, tested.limits) for side in (GROUND, MODEL))
    use_model = np.isnan(by_ground[0])
    return np.where(use_model, by_model[0], by_ground[0]), np.where(use_model, by_model[1], by_ground[1])


def _observation_rows(task: Task, tested: Tested) -> list[Row]:
    (test,) = tested.reliability.tests
    zone, v, shifts = tested.solved.zone, _residuals(task, tested), _shifts(tested)
    near = _correlations(tested)
    rows: list[Row] = []
    for block, k in np.argwhere(np.isfinite(test.share)).tolist():
        where = int(shifts.point[block, k])
        shift = Shift(shifts.metres[block, k], None if where < 0 else zone.points[where])
        head = {**_name(zone.name, zone.control_points[block], k), "unit": AXES[k][2]}
        told = near.get(block * len(AXES) + k, (None, None))
        rows.append(observation_row(head, test, (block, k), float(v[block, k]), shift, told, tested.limits))
    return rows


def _name(zone: str, point: str, k: int) -> dict[str, str]:
    kind, axis, _ = AXES[k]
    return {"kind": kind, "part": zone, "point": point, "axis": axis}


def _residuals(task: Task, tested: Tested) -> Array:
    """(n, 6) adjusted minus observed: of the ground along the tested axes, of the model."""
    found, solved = tested.solved.found, tested.solved
    axes = model_control(solved.zone, solved.errors, task.frame).axes
    return np.hstack([np.einsum("nji,nj->ni", axes, found.ground_residuals), found.model_residuals])


def _shifts(tested: Tested) -> _Shifts:
    """Over up to 60 points that cover the zone."""
    probes = far_apart(tested.solved.zone.model)
    model = tested.solved.zone.model[probes]
    metres, place = largest_model_shift(tested.solved.found, model, tested.reliability.tests[0].effect)
    return _Shifts(metres, np.where(place < 0, -1, probes[place]))


def _correlations(tested: Tested) -> dict[int, tuple[float | None, str | None]]:
    """|rho_w| and the other point, for the observations with the largest |w|."""
    tests = tested.reliability.tests
    found = most_correlated(tests, largest_places([np.abs(test.w) for test in tests], MOST_CORRELATED))
    names = tested.solved.zone.control_points
    return {block * len(AXES) + k: (near.rho, names[near.partner[1]]) for (_, block, k), near in found.items()}


def _effect_rows(task: Task, tested: Tested) -> list[Row]:
    """The effect on the seven elements of (2'), or near their blind view on the rotations about the ground axes."""
    (test,) = tested.reliability.tests
    zone = tested.solved.zone
    names, units, effects = _effects(task, tested, test)
    return [
        {
            **_name(zone.name, zone.control_points[block], k),
            "unknown": unknown,
            "unit": unit,
            "effect": float(effects[block, k, i]),
        }
        for _, block, k in sorted(largest_places([test.bias_to_noise], MOST_EFFECTS))
        for i, (unknown, unit) in enumerate(zip(names, units, strict=True))
    ]


def _effects(task: Task, tested: Tested, test: BlockTests) -> tuple[Sequence[str], Sequence[str], Array]:
    """Names, units and changes (n, 6, 7) in the stored frame, angles in degrees."""
    found = tested.solved.found
    view = "rotation" if near_blind_fixed_axes(found.rotation) else "homothety"
    changes = view_changes(found, view, test.effect)
    changes[..., :3] *= DEGREES_PER_RADIAN
    changes[..., 4:] = task.frame.right_handed(changes[..., 4:])
    return VIEWS[view](found)[0], ["deg"] * 3 + ["model/m"] + ["m"] * 3, changes


def _unchecked(zone: str, tested: Tested) -> list[Event]:
    """One remark on the points of which nothing, or hardly anything, is checked by the others.

    A coordinate that is far weaker on one side than on the other is hardly checked alone: the better of the two counts.
    """
    (test,) = tested.reliability.tests
    sides = np.stack([np.nan_to_num(test.share[:, side], nan=0.0).max(axis=1) for side in (GROUND, MODEL)])
    best = sides.max(axis=0)
    names = tested.solved.zone.control_points
    events = []
    for code, is_so, what in (
        ("not_checked", best <= UNTESTED, "not checked by the other points (a gross error in them does not show)"),
        ("hardly_checked", (best > UNTESTED) & (best < HARDLY), "hardly checked by the other points (r < 0.1)"),
    ):
        points = [name for name, so in zip(names, is_so, strict=True) if so]
        if points:
            message = f"zone {zone}: {what}: {listed(points, NAMED)}"
            events.append(Event("info", code, ", ".join(points[:NAMED]), message, float(len(points))))
    return events
