"""v'Pv -> min for an absolute orientation by scipy.optimize.least_squares: a second solution by other equations.

The first engine compares on the ground and weights a misclosure by both sides; this one has the adjusted ground points
as unknowns and compares in the model, x = H R'(P - X0), where the model has errors. Rotation by Cayley's quotient,
partials by the complex step, one dense system, Levenberg-Marquardt.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from orient.solvers.independent_algebra import (
    DISPLACED,
    STEP,
    cayley,
    last_cofactors,
    minimised,
    weight_root,
)

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

KNOWN = 0.5
"""Eigenvalue of a projector above which a direction belongs to it."""


@dataclass(frozen=True)
class ModelObservations:
    """What the orientation of a zone is computed from, right-handed, as the arguments of `orient_model`."""

    model: FloatArray
    ground: FloatArray
    known: FloatArray
    ground_cofactor: FloatArray
    model_cofactor: FloatArray | None

    @cached_property
    def known_axes(self) -> list[FloatArray]:
        """Per point (3, k): orthonormal known directions."""
        return [_axes(K) for K in self.known]

    @cached_property
    def unknown_axes(self) -> list[FloatArray]:
        """Per point (3, k): directions in which its ground place is an unknown; none where only the ground has errors.

        Those that are not known, and of the known ones those that have errors.
        """
        if self.model_cofactor is None:
            return [np.zeros((3, 0)) for _ in self.model]
        return [
            np.hstack([_axes(np.eye(3) - K), E @ _axes_of_errors(E.T @ Q @ E)])
            for K, E, Q in zip(self.known, self.known_axes, self.ground_cofactor, strict=True)
        ]

    @cached_property
    def ground_roots(self) -> list[FloatArray]:
        """Per point (m, 3): G with G'G the weight of the given ground coordinates."""
        roots = []
        for E, Q in zip(self.known_axes, self.ground_cofactor, strict=True):
            inside = E.T @ Q @ E
            F = _axes_of_errors(inside)
            roots.append(weight_root(np.linalg.inv(F.T @ inside @ F)) @ (E @ F).T if F.shape[1] else np.zeros((0, 3)))
        return roots

    @property
    def n_points(self) -> int:
        return sum(axes.shape[1] for axes in self.unknown_axes)

    @property
    def n_unknowns(self) -> int:
        return 7 + self.n_points


@dataclass(frozen=True, slots=True)
class IndependentAbsolute:
    """Rotation, H and the ground place `centre` (3,) of the mean of the model; Q (7, 7) of r, ln H, centre."""

    rotation: FloatArray
    H: float
    centre: FloatArray
    model_centre: FloatArray
    vPv: float
    Q: FloatArray
    converged: bool


@dataclass(frozen=True, slots=True)
class _System:
    """Unknowns (r, ln H - ln H_0, (C - C_0) / extent, own ones of points / extent)."""

    given: ModelObservations
    rotation: FloatArray
    H: float
    centre: FloatArray
    extent: float
    places: FloatArray = field(init=False)
    whitening: FloatArray | None = field(init=False)

    def __post_init__(self) -> None:
        places, first = np.zeros((len(self.given.model), 3, self.given.n_points)), 0
        for index, axes in enumerate(self.given.unknown_axes):
            places[index, :, first : first + axes.shape[1]] = axes
            first += axes.shape[1]
        object.__setattr__(self, "places", places)
        Q = self.given.model_cofactor
        whitening = None if Q is None else np.linalg.inv(np.linalg.cholesky(Q))
        object.__setattr__(self, "whitening", whitening)

    def residuals(self, x: ComplexArray | FloatArray) -> ComplexArray:
        """Whitened v of the ground, then of the model."""
        shift = self.extent * (self.places @ x[7:])
        if self.whitening is None:
            shift = self._on_ground(x) - self.given.ground
        of_ground = [G @ s for G, s in zip(self.given.ground_roots, shift, strict=True)]
        if self.whitening is None:
            return np.concatenate(of_ground)
        R, H, C = self.placed(x)
        computed = H * (self.given.ground + shift - C) @ R
        white = self.whitening @ (computed - self.given.model)[:, :, None]
        return np.concatenate([*of_ground, white.ravel()])

    def jacobian(self, x: FloatArray) -> FloatArray:
        columns = []
        for column in range(len(x)):
            step = x.astype(np.complex128)
            step[column] += STEP * 1j
            columns.append(self.residuals(step).imag / STEP)
        return np.stack(columns, axis=1)

    def placed(self, x: ComplexArray | FloatArray) -> tuple[ComplexArray, complex, ComplexArray]:
        """R, H, C of the unknowns."""
        R = cayley(x[:3].astype(np.complex128)) @ self.rotation
        return np.asarray(R), self.H * np.exp(x[3]), np.asarray(self.centre + self.extent * x[4:7])

    def _on_ground(self, x: ComplexArray | FloatArray) -> ComplexArray:
        R, H, C = self.placed(x)
        return np.asarray(C + self.given.model @ R.T / H)


def solve_model_independently(
    given: ModelObservations, rotation: FloatArray, H: float, X0: FloatArray
) -> IndependentAbsolute:
    """The orientation next to `rotation` (3, 3), H and X0 (3,) [m], from a start displaced from them.

    Minimises v'Pv over the seven elements and the unknown ground coordinates together. numpy's LinAlgError where the
    model's covariance is not positive definite.
    """
    model_centre, ground_centre = given.model.mean(axis=0), given.ground.mean(axis=0)
    centred = ModelObservations(
        given.model - model_centre, given.ground - ground_centre, given.known, given.ground_cofactor,
        given.model_cofactor,
    )  # fmt: skip
    extent = float(np.sqrt(np.mean(np.sum((centred.model / H) ** 2, axis=1))))
    at = X0 + rotation @ model_centre / H - ground_centre
    system = _System(centred, rotation, H, at, extent)
    start = np.zeros(given.n_unknowns)
    start[:7] = DISPLACED * (-1.0) ** np.arange(7)
    x, vPv, converged = minimised(lambda x: np.asarray(system.residuals(x).real), system.jacobian, start)
    R, scale, C = system.placed(x)
    end = np.asarray(R.real, dtype=np.float64)
    centre, Q = np.asarray(C.real + ground_centre), _cofactors(system, x)
    return IndependentAbsolute(end, float(np.real(scale)), centre, model_centre, vPv, Q, converged=converged)


def _cofactors(system: _System, x: FloatArray) -> FloatArray:
    """(J'J)^-1 of r, ln H, C [m], about the end."""
    R, H, C = system.placed(x)
    here = _System(system.given, np.asarray(R.real), float(H.real), np.asarray(C.real), system.extent)
    J = here.jacobian(np.concatenate([np.zeros(7), x[7:]]))
    scales = np.concatenate([np.ones(4), np.full(3, system.extent)])
    return np.asarray(scales[:, None] * last_cofactors(np.roll(J, -7, axis=1), 7) * scales)


def _axes(projector: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh(projector)
    return np.asarray(vectors[:, values > KNOWN])


def _axes_of_errors(cofactor: FloatArray) -> FloatArray:
    """(k, m): directions in which a cofactor (k, k) is not zero."""
    values, vectors = np.linalg.eigh(cofactor)
    return np.asarray(vectors[:, values > 1e-12 * np.max(values, initial=0.0)])
