"""Similarities of small samples of control: the misfits of all points to each, as starts for `consensus`."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.solvers.absolute_checks import known_rank
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_problem import UNKNOWNS, Similarity
from orient.solvers.absolute_reliability import ModelControl, view_misfits
from orient.solvers.absolute_start import closed_form, full_points, spans_triangle
from orient.solvers.consensus import samples

FloatArray = NDArray[np.float64]

MIXED_SAMPLES = 40
"""Mixed samples: of four points with 40 % wrong one is right with 13 %, so that none of 40 is with 0.4 %."""
PLANS, HEIGHTS = 2, 3
"""Plan positions and heights that determine a similarity."""


def sample_misfits(control: ModelControl, allow_upside_down: bool) -> list[FloatArray]:
    """T (n,) of all points to the similarity of every triple of full points, and of samples with partial points.

    Triples by the closed form: all of up to 10 full points, else 120 random ones. Where some control is plan-only or
    height-only, 40 random smallest sets that determine the similarity too, by the adjustment itself, which gives both
    solutions of two full points and a height. Weighted squared misfits in units of sigma0^2.
    """
    starts = list(_triples(control))
    if not full_points(control.known).all():
        starts += _mixed(control, allow_upside_down)
    return [view_misfits(view, control) for view in starts]


def _triples(control: ModelControl) -> Iterator[Similarity]:
    full = np.flatnonzero(full_points(control.known))
    for triple in samples(full.tolist(), 3) if len(full) >= 3 else ():
        at = list(triple)
        if spans_triangle(control.model[at]) and spans_triangle(control.ground[at]):
            yield closed_form(control.model[at], control.ground[at], np.ones(3))


def _mixed(control: ModelControl, allow_upside_down: bool) -> Iterator[Similarity]:
    random = np.random.default_rng(len(control.model))
    rank = known_rank(control.known)
    tried = set()
    for _ in range(MIXED_SAMPLES):
        chosen = _smallest_set(random.permutation(len(rank)), rank)
        if chosen is None or chosen in tried:
            continue
        tried.add(chosen)
        part = control.at(np.array(chosen, dtype=np.intp))
        try:
            found = orient_model(
                part.model, part.ground, known=part.known, ground_cofactor=part.ground_cofactor,
                model_cofactor=part.model_cofactor, allow_upside_down=allow_upside_down,
            )  # fmt: skip
        except GeometryError:
            continue
        if found.is_result:
            yield Similarity(found.rotation, found.H, found.X0)
            yield from (Similarity(other.rotation, other.H, other.X0) for other in found.alternatives)


def _smallest_set(order: NDArray[np.int64], rank: NDArray[np.int64]) -> tuple[int, ...] | None:
    """The first points in this order that have the plan positions, heights and equations of a similarity."""
    chosen: list[int] = []
    plans = heights = equations = 0
    for point in order.tolist():
        has_plan, has_height = rank[point] >= 2, rank[point] != 2
        if (has_plan and plans < PLANS) or (has_height and heights < HEIGHTS) or equations < UNKNOWNS:
            chosen.append(point)
            plans, heights = plans + has_plan, heights + has_height
            equations += int(rank[point])
        if plans >= PLANS and heights >= HEIGHTS and equations >= UNKNOWNS:
            return tuple(sorted(chosen))
    return None
