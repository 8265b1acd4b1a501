"""Interior orientation: from the comparator to the fiducial system, by the fiducial marks."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry import plane
from orient.solvers.engines import Engine
from orient.solvers.linear_adjustment import adjust, weakest_unknown
from orient.words import counted

Vector = NDArray[np.float64]

MARKS_NEEDED = {"similarity": 2, "affine": 3, "projective": 4}
SINGULAR_RATIO = 1e-6
MAX_ITERATIONS = 20


@dataclass(frozen=True, slots=True)
class InteriorFit:
    """x = T(X), named `parameters` for X in mm of the comparator (not reduced to a centre); covariance sigma0^2 Q.

    residuals (n, 2) = transformed - calibrated [mm]; sigma0 [mm] and sigmas are None without redundancy.
    """

    transformation: str
    names: tuple[str, ...]
    parameters: Vector
    cofactor: Vector
    sigmas: Vector | None
    transformed: Vector
    residuals: Vector
    sigma0: float | None
    redundancy: int
    is_mirrored: bool


def fit_interior(
    measured: Vector,
    calibrated: Vector,
    transformation: str,
    *,
    marks: Sequence[str] = (),
    engine: Engine = Engine.ZLATANOV,
) -> InteriorFit:
    """v = T(X) - x: least squares of the fiducial marks in the calibrated system, all with the same weight.

    measured (n, 2) comparator X, Y [mm], calibrated (n, 2) x, y of the certificate [mm], `transformation`
    similarity | affine | projective (equations: `geometry.plane`), `marks` names for the messages. Similarity and
    affine are linear; projective goes from the linear (homogeneous) start by Gauss-Newton.

    Refuses (GeometryError) fewer than 2, 3, 4 marks, two marks in one place, marks on one line (affine; projective also
    three of four), and a projective horizon between the marks.
    Source: K. Kraus, Photogrammetry, 2007, 2.1 and 3.2.1; R. Hartley 1997 for the normalised coordinates.
    """
    labels = tuple(marks) or tuple(str(i + 1) for i in range(len(measured)))
    _refuse(measured, calibrated, transformation, labels)
    centre, scale = np.mean(measured, axis=0), float(np.max(np.abs(measured - np.mean(measured, axis=0))))
    reduced = (measured - centre) / scale
    solution, R_inverse = _solve(reduced, calibrated, transformation, labels, engine)
    parameters, J = _from_reduced(solution, transformation, centre, scale)
    cofactor = J @ R_inverse @ R_inverse.T @ J.T
    transformed = plane.apply(transformation, solution, reduced)
    residuals = transformed - calibrated
    redundancy = residuals.size - len(parameters)
    sigma0 = float(np.sqrt(np.sum(residuals**2) / redundancy)) if redundancy > 0 else None
    return InteriorFit(
        transformation=transformation,
        names=tuple(plane.parameter_names(transformation)),
        parameters=parameters,
        cofactor=cofactor,
        sigmas=None if sigma0 is None else sigma0 * np.sqrt(np.diag(cofactor)),
        transformed=transformed,
        residuals=residuals,
        sigma0=sigma0,
        redundancy=redundancy,
        is_mirrored=bool(_determinant(transformation, parameters) < 0),
    )


def _solve(
    reduced: Vector, calibrated: Vector, transformation: str, labels: Sequence[str], engine: Engine
) -> tuple[Vector, Vector]:
    """Parameters, and R^-1 of the equations about them."""
    names = plane.parameter_names(transformation)
    parameters = _start(reduced, calibrated, transformation)
    for _ in range(MAX_ITERATIONS):
        A = _design(parameters, transformation, reduced, labels)
        L = (plane.apply(transformation, parameters, reduced) - calibrated).ravel()
        step = adjust(names, A, L, engine).X
        parameters = parameters + step
        if np.max(np.abs(step)) <= 1e-13 * np.max(np.abs(parameters)):
            break
    A = _design(parameters, transformation, reduced, labels)
    return parameters, adjust(names, A, np.zeros(len(A)), engine).R_inverse


def _start(reduced: Vector, calibrated: Vector, transformation: str) -> Vector:
    """Zero for the linear ones; else the linear form x (1 + c1 X + c2 Y) = a0 + a1 X + a2 Y."""
    names = plane.parameter_names(transformation)
    if transformation != "projective":
        return np.zeros(len(names))
    ones, zeros = np.ones(len(reduced)), np.zeros(len(reduced))
    X, Y = reduced.T
    x, y = calibrated.T
    columns_x = {"a0": ones, "a1": X, "a2": Y, "c1": -x * X, "c2": -x * Y}
    columns_y = {"b0": ones, "b1": X, "b2": Y, "c1": -y * X, "c2": -y * Y}
    A = np.vstack(
        [
            np.column_stack([columns_x.get(name, zeros) for name in names]),
            np.column_stack([columns_y.get(name, zeros) for name in names]),
        ]
    )
    parameters = np.linalg.lstsq(A, np.concatenate([x, y]), rcond=None)[0]
    c = dict(zip(names, parameters, strict=True))
    if np.min(1.0 + c["c1"] * X + c["c2"] * Y) <= 0.0:
        raise GeometryError(
            "the horizon of the projective transformation passes between the fiducial marks",
            "Check the names and the order of the marks, or use transformation = affine.",
        )
    return np.asarray(parameters)


def _design(parameters: Vector, transformation: str, reduced: Vector, labels: Sequence[str]) -> Vector:
    partials = plane.partials(transformation, parameters, reduced)
    A = partials.reshape(-1, partials.shape[-1])
    singular = np.linalg.svd(A / np.maximum(np.linalg.norm(A, axis=0), 1e-300), compute_uv=False)
    if singular[-1] < SINGULAR_RATIO * singular[0]:
        weakest = weakest_unknown(plane.parameter_names(transformation), A)
        raise GeometryError(
            f"the fiducial marks {', '.join(labels)} do not determine {weakest} of a {transformation} transformation",
            "Measure marks that do not lie on one line, or use a simpler transformation.",
        )
    return A


def _matrix(transformation: str, parameters: Vector) -> Vector:
    """Homogeneous 3x3 matrix of the transformation: (x, y, 1) ~ M (X, Y, 1)."""
    p = dict(zip(plane.parameter_names(transformation), parameters, strict=True))
    if transformation == "similarity":
        p = {**p, "b1": -p["a2"], "b2": p["a1"]}
    return np.array(
        [[p["a1"], p["a2"], p["a0"]], [p["b1"], p["b2"], p["b0"]], [p.get("c1", 0.0), p.get("c2", 0.0), 1.0]]
    )


def _determinant(transformation: str, parameters: Vector) -> float:
    return float(np.linalg.det(_matrix(transformation, parameters)))


def _from_reduced(solution: Vector, transformation: str, centre: Vector, scale: float) -> tuple[Vector, Vector]:
    """Parameters for X instead of (X - centre)/scale, and their derivatives by those of the reduced form."""
    reduce = np.array([[1 / scale, 0.0, -centre[0] / scale], [0.0, 1 / scale, -centre[1] / scale], [0.0, 0.0, 1.0]])
    names = plane.parameter_names(transformation)
    full = _matrix(transformation, solution) @ reduce
    places = [_PLACES[name] for name in names]
    weight = full[2, 2]
    parameters = np.array([full[place] for place in places]) / weight
    zero = _matrix(transformation, np.zeros(len(names)))
    J = np.empty((len(names), len(names)))
    for k, unit in enumerate(np.eye(len(names))):
        # the matrix is linear in the parameters, its quotient by the lower right element is not
        change = (_matrix(transformation, unit) - zero) @ reduce
        J[:, k] = (np.array([change[place] for place in places]) - parameters * change[2, 2]) / weight
    return parameters, J


_PLACES = {
    "a1": (0, 0), "a2": (0, 1), "a0": (0, 2),
    "b1": (1, 0), "b2": (1, 1), "b0": (1, 2),
    "c1": (2, 0), "c2": (2, 1),
}  # fmt: skip


def _refuse(measured: Vector, calibrated: Vector, transformation: str, labels: Sequence[str]) -> None:
    if transformation not in MARKS_NEEDED:
        raise GeometryError(f"unknown transformation {transformation}", f"Use {', '.join(MARKS_NEEDED)}.")
    needed = MARKS_NEEDED[transformation]
    if len(measured) < needed:
        marks = counted(len(measured), "fiducial mark is", "fiducial marks are")
        raise GeometryError(
            f"{marks} measured; {transformation} needs {needed}",
            "Measure more marks or use a simpler transformation.",
        )
    for places, what in ((measured, "measured"), (calibrated, "calibrated")):
        _refuse_same(places, labels, what)
        if transformation != "similarity":
            _refuse_line(places, what)


def _refuse_same(places: Vector, labels: Sequence[str], what: str) -> None:
    distance = np.linalg.norm(places[:, None] - places[None, :], axis=2)
    limit = 1e-6 * np.max(distance)
    rows, columns = np.nonzero(np.triu(distance <= limit, k=1))
    if len(rows):
        raise GeometryError(
            f"fiducial marks {labels[rows[0]]} and {labels[columns[0]]} have the same {what} place",
            "Check the names and coordinates of the marks.",
        )


def _refuse_line(places: Vector, what: str) -> None:
    singular = np.linalg.svd(places - np.mean(places, axis=0), compute_uv=False)
    if singular[1] < 1e-4 * singular[0]:
        raise GeometryError(
            f"the {what} fiducial marks lie on one line",
            "Measure marks off the line or use transformation = similarity.",
        )
