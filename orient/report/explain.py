"""`explain`: one iteration of the resection as a page of a textbook, to be followed by hand to the printed digits."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from orient.errors import UsageError
from orient.geometry.rotation import aok_from_matrix, rotation_exp
from orient.pipeline.registry import ALL_STAGES, how_to_get
from orient.pipeline.tables import Array
from orient.pipeline.textbook import Page, page
from orient.report.current import last_failure
from orient.report.matrix import matrix_lines
from orient.report.text import cell, console, print_json, print_table, printable
from orient.solvers.textbook import Group, Step, as_printed, textbook_step
from orient.store.project import RunInfo, open_project
from orient.units import DEGREES_PER_RADIAN
from orient.words import typed

WIDEST = 80
PLACES = 12
"""Digits of the approximations: a correction of few digits moves the last ones of a coordinate."""
MOST_POINTS, SHOWN_POINTS = 50, 10
ELSEWHERE = {
    "absolute": "The equations of a model are shown by: orient sql PROJECT absolute-equations",
    "digitize": "The polynomial of a sheet is linear, one step: orient sql PROJECT crosses",
}


def explain(path: Path, stage: str, iteration: int, version: int | None, digits: int, as_json: bool) -> None:
    """Print one iteration of the resection, or refuse in words."""
    _require_resection(stage)
    with open_project(path, "read") as project, project.snapshot():
        run = project.run("resection", version) if version else project.heads().get("resection")
        if run is None:
            failed = last_failure(project.runs("resection"))
            hint = how_to_get(["resection"], project.heads(), typed(path))
            hint = f"See a failed one: --version {failed.version}" if failed else hint
            raise UsageError("resection has no current version", hint)
        inputs = {role: project.read_tables(run_id) for role, run_id in run.inputs.items()}
        stored = project.read_tables(run.run_id)
    found = page(inputs, run.settings, stored, iteration)
    count = len(stored["iteration"])
    name = str(inputs["photo"]["photo"][0]["name"])
    if as_json:
        print_json(_content(run, found, iteration, count))
        return
    step = textbook_step([*found.groups, *found.prior_groups], digits)
    out = console()
    width = min(out.width, WIDEST)
    head = f"{printable(name)}, resection version {run.version}, iteration {iteration} of {count}"
    for line in (head, *_lines(found, step, digits, width)):
        out.print(printable(line), soft_wrap=True)
    _print_result(found, step, digits)


def _require_resection(stage: str) -> None:
    if stage not in ALL_STAGES:
        raise UsageError(f'there is no stage "{stage}"', "explain knows resection.")
    if stage != "resection":
        hint = ELSEWHERE.get(stage, "It has no iterations.")
        raise UsageError(f"explain knows the resection only, not {stage}", hint)


def _lines(found: Page, step: Step, digits: int, width: int) -> Iterator[str]:
    yield f"Every line is computed from the lines above as they are printed, {digits} digits."
    yield "Angles in rad, ground in m, image in mm; v = A x + l, l = computed - measured."
    yield from _approximations(found, width)
    yield from _equations(found, step, digits, width)
    yield from _known_beforehand(found, step, digits, width)
    names = [*found.unknowns, "l"]
    yield from ("", "4. Normal equations: N = A'PA, the column l is A'Pl, its last number l'Pl", "")
    yield from matrix_lines(names, names, step.Z, digits, width, is_triangle=True)
    yield from ("", "5. Algorithm Z: R_kk = sqrt(Z_kk), R_kj = Z_kj / R_kk, Z_ij <- Z_ij - R_ki R_kj")
    for k, reduced in enumerate(step.reductions):
        yield from ("", f"step {k + 1}: the row of {names[k]} is finished, those below are reduced", "")
        yield from matrix_lines(names[k:], names[k:], reduced[k:, k:], digits, width, is_triangle=True)


def _approximations(found: Page, width: int) -> Iterator[str]:
    yield from ("", "1. Approximations: R from image to east, north, up; then the other unknowns", "")
    axes = ["E", "N", "U"]
    yield from matrix_lines(axes, ["x", "y", "z"], found.rotation, PLACES, width)
    yield ""
    labels = [_label(name, unit) for name, unit in zip(found.unknowns[3:], found.units[3:], strict=True)]
    yield from matrix_lines(labels, ["value"], found.values[:, None], PLACES, width)


def _equations(found: Page, step: Step, digits: int, width: int) -> Iterator[str]:
    """A, l and P of the image coordinates."""
    groups = step.groups[: len(found.groups)]
    shown = groups if len(groups) <= MOST_POINTS else groups[:SHOWN_POINTS]
    yield from ("", f"2. Correction equations of {len(groups)} control points: A and l", "")
    rows = [f"{point} {axis}" for point in found.points[: len(shown)] for axis in "xy"]
    values = np.vstack([np.column_stack([one.design, one.free_term]) for one in shown])
    yield from matrix_lines(rows, [*found.unknowns, "l"], values, digits, width)
    if len(shown) < len(groups):
        yield f"... and {len(groups) - len(shown)} more points (--json has all); N below is the sum of all"
    if found.has_ground:
        yield ""
        yield "The unknown ground coordinates dP are taken out point by point: P below is"
        yield "P - P B M^+ B'P with M = B'PB + W, B = d(x, y)/d(X, Y, Z), W their weight."
    yield from _weights(found, shown, digits, width)


def _weights(found: Page, groups: Sequence[Group], digits: int, width: int) -> Iterator[str]:
    packed = np.array([[one.weight[0, 0], one.weight[0, 1], one.weight[1, 1]] for one in groups])
    yield ""
    if np.all(packed == packed[0]) and packed[0, 1] == 0 and packed[0, 0] == packed[0, 2]:
        yield f"Weight of every equation: p = {packed[0, 0]:.{digits}g}"
        return
    yield "Weights P of the two equations of a point:"
    yield from matrix_lines(found.points[: len(groups)], ["p_xx", "p_xy", "p_yy"], packed, digits, width)


def _known_beforehand(found: Page, step: Step, digits: int, width: int) -> Iterator[str]:
    """Equations of what is known of camera, station and common unknowns."""
    yield ""
    if not found.prior_groups:
        yield "3. No unknown is known beforehand."
        return
    groups = step.groups[len(found.groups) :]
    yield "3. What is known beforehand"
    single = [one for one in groups if len(one.free_term) == 1]
    names = list(found.priors)
    if single:
        values = np.vstack([np.column_stack([one.design, one.free_term]) for one in single])
        yield from ("", "Divided by its standard deviation (in units of sigma0), so that p = 1:", "")
        yield from matrix_lines(names[: len(single)], [*found.unknowns, "l"], values, digits, width)
    for one in groups[len(single) :]:
        common = list(found.unknowns[len(found.unknowns) - len(one.free_term) :])
        yield from ("", "v = dc + c of the unknowns that all points share; c, and their weights P:", "")
        yield from matrix_lines(common, ["c"], one.free_term[:, None], digits, width)
        yield ""
        yield from matrix_lines(common, common, one.weight, digits, width, is_triangle=True)


def _after(found: Page, step: Step) -> tuple[Array, Array]:
    """R and the other unknowns after the step, from what is printed."""
    rotation = rotation_exp(step.x[:3]) @ as_printed(found.rotation, PLACES)
    return as_printed(rotation, PLACES), as_printed(as_printed(found.values, PLACES) + step.x[3:], PLACES)


def _print_result(found: Page, step: Step, digits: int) -> None:
    """Corrections, the unknowns after them, and what the program had with all its digits."""
    out = console()
    out.print("\n6. Solution from the last unknown up: x_k = -(rho_k + sum R_kj x_j) / R_kk")
    rotation, values = _after(found, step)
    labels = list(zip(found.unknowns, found.units, strict=True))
    print_table(
        ["unknown", "unit", "x"],
        [[*one, _digits(x, digits)] for one, x in zip(labels, step.x, strict=True)],
        [False, False, True],
    )
    out.print("\n7. Unknowns after it: R = exp([r]x) R, the others + x")
    for line in matrix_lines(["E", "N", "U"], ["x", "y", "z"], rotation, PLACES, min(out.width, WIDEST)):
        out.print(line, soft_wrap=True)
    rows = [
        [name, _digits(ours, PLACES), _digits(theirs, PLACES), f"{ours - theirs:.1e}"]
        for name, ours, theirs in zip(
            [*("alpha deg", "omega deg", "kappa deg"), *(_label(*one) for one in labels[3:])],
            [*_angles(rotation), *values],
            [*_angles(found.rotation_after), *found.values_after],
            strict=True,
        )
    ]
    out.print()
    print_table(["unknown", "this page", "orient", "difference"], rows, [False, True, True, True])
    ground = "" if not found.has_ground else " (with the ground coordinates)"
    out.print(f"v'Pv of the approximations{ground}: {cell(found.vPv)} mm^2")
    if found.damping:
        out.print(
            f"orient shortened this step (damping {found.damping:.1g}): the whole one would not have lowered v'Pv.",
            soft_wrap=True,
        )


def _label(name: str, unit: str) -> str:
    return name if unit == "1" else f"{name} {unit}"


def _digits(value: float, digits: int) -> str:
    return f"{value:.{digits}g}"


def _angles(rotation: Array) -> list[float]:
    return [float(angle) * DEGREES_PER_RADIAN for angle in aok_from_matrix(rotation)]


def _content(run: RunInfo, found: Page, iteration: int, count: int) -> dict[str, object]:
    """Everything with all digits: nothing is rounded between the lines."""
    step = textbook_step([*found.groups, *found.prior_groups], None)
    return {
        "stage": run.stage,
        "version": run.version,
        "iteration": iteration,
        "iterations": count,
        "unknowns": list(found.unknowns),
        "units": list(found.units),
        "rotation": found.rotation.tolist(),
        "values": found.values.tolist(),
        "points": [_group(name, one) for name, one in zip(found.points, found.groups, strict=True)],
        "priors": {"names": list(found.priors), "groups": [_group("", one) for one in found.prior_groups]},
        "has_unknown_ground": found.has_ground,
        "normal": step.Z.tolist(),
        "reductions": [reduced.tolist() for reduced in step.reductions],
        "x": step.x.tolist(),
        "rotation_after": found.rotation_after.tolist(),
        "values_after": found.values_after.tolist(),
        "vPv": found.vPv,
        "damping": found.damping,
    }


def _group(name: str, one: Group) -> dict[str, object]:
    named = {"point": name} if name else {}
    return {**named, "A": one.design.tolist(), "l": one.free_term.tolist(), "P": one.weight.tolist()}
