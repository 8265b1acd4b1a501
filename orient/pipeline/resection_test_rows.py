"""The tests of a resection as rows: each observation, each point, the whole; and what a reader must know of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.pipeline.camera import unit_of
from orient.pipeline.choice import surprise
from orient.pipeline.exclusions import Decided, decision_rows, masking_events, numbered, robust_events, snooping_events
from orient.pipeline.resection_blunders import Chosen, Task, Tested
from orient.pipeline.resection_rows import ROTATIONS, STATION
from orient.pipeline.tables import Array, joined, nullable
from orient.pipeline.test_rows import (
    MOST_CORRELATED,
    MOST_EFFECTS,
    Observation,
    adjustment_row,
    largest_places,
    point_rows,
    verdicts,
)
from orient.solvers.reliability import BlockTests, block_statistic, most_correlated
from orient.solvers.resection_reliability import IMAGE, far_apart, largest_ground_shift
from orient.units import DEGREES_PER_RADIAN, listed
from orient.values import Columns, Event, Row, Scalar, Tables

AXES = (("image", "x", "mm"), ("image", "y", "mm"), ("ground", "X", "m"), ("ground", "Y", "m"), ("ground", "Z", "m"))
OBSERVATIONS = [f"{kind} {axis}" for kind, axis, _ in AXES]
NAMED = 10
NAMES = ("kind", "part", "point", "axis", "unit")


@dataclass(frozen=True, slots=True)
class _Shifts:
    """Largest shift on the ground by the smallest findable error of each observation, and the point it happens at."""

    metres: Array
    point: NDArray[np.intp]


def test_tables(task: Task, chosen: Chosen) -> tuple[Tables, list[Event]]:
    """adjustment_test, observation_test, point_test, external_reliability, exclusion; and the findings."""
    exclusions = _exclusions(task, chosen)
    tested = chosen.tested
    points = task.control.points
    seen = robust_events("", [points[i] for i in chosen.by_robust], len(points), "control points")
    tables: dict[str, Sequence[Row]] = {"exclusion": numbered(exclusions)}
    if tested is None:
        return tables, [*snooping_events(exclusions, 1.0), *seen]
    found = tested.solved.found
    chance = surprise(tested.reliability, tested.limits, found.redundancy)
    whole = adjustment_row("", "", found.vPv, found.redundancy, task.sigma0, tested.limits)
    events = [*snooping_events(exclusions, chance), *seen, *masking_events("", whole, exclusions)]
    names = tested.solved.control.points
    tables["adjustment_test"] = [whole]
    observed = _observation_rows(task, tested)
    tables["observation_test"] = observed
    T, freedom = block_statistic(tested.reliability.tests[0], IMAGE, tested.limits)
    tables["point_test"] = point_rows("", names, T, freedom, found.redundancy, tested.limits)
    tables["external_reliability"] = _effect_rows(task, tested)
    return tables, [*events, *_unchecked(observed)]


def _exclusions(task: Task, chosen: Chosen) -> list[Row]:
    test = "tau" if chosen.tested is not None and chosen.tested.limits.name == "tau" else "w"
    decided = Decided(chosen.by_hand, chosen.by_robust, chosen.decisions)
    return decision_rows("", task.control.points, decided, task.settings, test, OBSERVATIONS)


def _observation_rows(task: Task, tested: Tested) -> Columns:
    tests, shifts = tested.reliability.tests, _shifts(task, tested)
    correlated = _correlations(tested)
    parts = []
    for group, (test, shift) in enumerate(zip(tests, shifts, strict=True)):
        place = np.nonzero(np.isfinite(test.share))
        at = list(zip(*(index.tolist() for index in place), strict=True))
        near = [correlated.get((group, block, k), (None, None)) for block, k in at]
        points = [tested.solved.control.points[i] if i >= 0 else None for i in shift.point[place].tolist()]
        parts.append(
            {
                **_names(task, tested, group, at),
                "v": _residuals(task, tested, group)[place],
                "redundancy_number": test.redundancy[place],
                "share": test.share[place],
                "w": nullable(test.w[place]),
                "smallest_error": nullable(test.mdb[place]),
                "bias_to_noise": nullable(test.bias_to_noise[place]),
                "ground_shift_m": nullable(shift.metres[place]),
                "ground_shift_point": points,
                "rho": [rho for rho, _ in near],
                "rho_with": [other for _, other in near],
                "verdict": verdicts(test.w[place], test.share[place], tested.limits),
            }
        )
    return joined(parts)


def _names(task: Task, tested: Tested, group: int, at: Sequence[tuple[int, int]]) -> dict[str, list[Scalar]]:
    """`_name` of the observations of a group, by column."""
    if group == 0:
        of_points = tested.solved.control.points
        kinds, axes, units = zip(*(AXES[k] for _, k in at), strict=True)
        points = [of_points[block] for block, _ in at]
        return {
            "kind": list(kinds), "part": [""] * len(at), "point": points, "axis": list(axes), "unit": list(units)
        }  # fmt: skip
    rows = [_name(task, tested, group, block, k) for block, k in at]
    return {name: [row[name] for row in rows] for name in NAMES}


def _name(task: Task, tested: Tested, group: int, block: int, k: int) -> dict[str, Scalar]:
    if group == 0:
        kind, axis, unit = AXES[k]
        return {"kind": kind, "part": "", "point": tested.solved.control.points[block], "axis": axis, "unit": unit}
    if not _is_coefficient(tested, group):
        name, unit = _known_names(tested)[block]
        return {"kind": "known", "part": "", "point": "", "axis": name, "unit": unit}
    unknown = task.chain.unknowns[k]
    return {"kind": "coefficient", "part": unknown.subject, "point": "", "axis": unknown.name, "unit": unknown.unit}


def _is_coefficient(tested: Tested, group: int) -> bool:
    """Groups after the points: the common unknowns if there are any, then what is known of the elements."""
    return group == 1 and tested.solved.found.problem.common.rank > 0


def _known_names(tested: Tested) -> list[tuple[str, str]]:
    """Name and unit of what is known of the camera, then of station and angles."""
    problem, interior = tested.solved.found.problem, tested.solved.chain.camera
    names = [] if interior is None else [interior.names[place] for place in interior.observed]
    of_camera = [(name, unit_of(name, interior.camera)) for name in names if interior is not None]
    return of_camera + [(one.name, "m" if one.name.endswith("_S") else "rad") for one in problem.observed]


def _residuals(task: Task, tested: Tested, group: int) -> Array:
    """v of the image coordinates, of a point's own ground coordinates in T', of coefficients, of what is known."""
    solved, frame = tested.solved, task.frame
    found, shared = solved.found, solved.chain.shared
    if group > 0 and not _is_coefficient(tested, group):
        return (found.problem.known_equations(found.state)[1] * np.sqrt(found.problem.known_cofactors))[:, None]
    if group == 1:
        return found.common[None]
    place = frame.right_handed(found.ground) - solved.place
    if shared is not None:
        place = place - shared.partials @ found.common[solved.chain.interior_unknowns :]
    return np.hstack([found.residuals, place])


def _shifts(task: Task, tested: Tested) -> list[_Shifts]:
    solved = tested.solved
    probes = far_apart(solved.found.computed)
    up = task.frame.right_handed(solved.up[probes])
    return [_Shifts(*largest_ground_shift(solved.found, up, probes, test.effect)) for test in tested.reliability.tests]


def _correlations(tested: Tested) -> dict[Observation, tuple[float | None, str | None]]:
    """|rho_w| and the other point, for the observations with the largest |w|."""
    tests = tested.reliability.tests
    chosen = largest_places([np.abs(test.w) for test in tests], MOST_CORRELATED)
    found = most_correlated(tests, chosen)
    told: dict[Observation, tuple[float | None, str | None]] = {}
    for place, near in found.items():
        group, block, k = near.partner
        other = tested.solved.control.points[block] if group == 0 else _other(tested, group, block, k)
        told[place] = near.rho, other
    return told


def _other(tested: Tested, group: int, block: int, k: int) -> str:
    if not _is_coefficient(tested, group):
        return f"known {_known_names(tested)[block][0]}"
    chain = tested.solved.chain
    subject = chain.unknowns[k].subject
    return subject if k < chain.interior_unknowns else f"sheet {subject}"


def _effect_rows(task: Task, tested: Tested) -> list[Row]:
    """The effect on each element, rotations in degrees, the station in T'."""
    tests = tested.reliability.tests
    rows: list[Row] = []
    for group, block, k in sorted(largest_places([test.bias_to_noise for test in tests], MOST_EFFECTS)):
        effect = _stored(task, tests[group], block, k)
        name = _name(task, tested, group, block, k)
        del name["unit"]
        rows += [
            {**name, "unknown": unknown, "unit": unit, "effect": float(effect[i])}
            for i, (unknown, unit) in enumerate(_unknowns(tested))
        ]
    return rows


def _stored(task: Task, test: BlockTests, block: int, k: int) -> Array:
    effect: Array = test.effect[block, k].copy()
    effect[:3] *= DEGREES_PER_RADIAN
    effect[3:6] = task.frame.right_handed(effect[3:6])
    return effect


def _unknowns(tested: Tested) -> list[tuple[str, str]]:
    interior = tested.solved.chain.camera
    of_camera = [] if interior is None else [(name, unit_of(name, interior.camera)) for name in interior.names]
    return [(name, "deg") for name in ROTATIONS] + [(name, "m") for name in STATION] + of_camera


def _unchecked(tests: Columns) -> list[Event]:
    """One remark on the readings that the others hardly check or do not check at all."""
    events = []
    told = [tests.by_name[name] for name in ("kind", "verdict", "point")]
    for word, code in (("not checked", "not_checked"), ("hardly checked", "hardly_checked")):
        points = list(
            dict.fromkeys(
                point for kind, verdict, point in zip(*told, strict=True) if (kind, verdict) == ("image", word)
            )
        )
        if points:
            what = "a gross error in them does not show" if code == "not_checked" else "r < 0.1"
            message = f"{word} by the other points ({what}): {listed(points, NAMED)}"
            events.append(Event("info", code, ", ".join(points[:NAMED]), message, float(len(points))))
    return events
