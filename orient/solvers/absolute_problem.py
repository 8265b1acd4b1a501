"""v = B d(r, ln H, C) + L, L = C + R x/H - P: the equations of an absolute orientation, for `functional_iteration`.

Errors of the model coordinates are part of it without further unknowns: with Q_e = K (Q_G + t^2 R Q_x R') K the
misclosure at the OBSERVED model point is weighted by P = Q_e^+, and the partials are taken at the ADJUSTED one. That is
what the elimination of the adjusted model coordinates leaves, also when one side is errorless.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import rotation_exp
from orient.geometry.similarity import partials_rotation
from orient.solvers.absolute_cofactors import Weight, added, times, turned, weight_of
from orient.solvers.engines import Engine, triangle

FloatArray = NDArray[np.float64]

ELEMENTS = ("r_X", "r_Y", "r_Z", "H", "X_0", "Y_0", "Z_0")
UNKNOWNS = len(ELEMENTS)


@dataclass(frozen=True, slots=True)
class Similarity:
    """State of the iteration: P = centre + R x/H, model and ground taken from the centres of the control."""

    rotation: FloatArray
    H: float
    centre: FloatArray

    @property
    def t(self) -> float:
        """Scale denominator 1/H [m per model unit]."""
        return 1.0 / self.H


@dataclass(frozen=True, slots=True)
class AbsoluteEquations:
    """The equations about one state: R (d / s) = -rho."""

    vPv: float
    triangle: FloatArray
    rho: FloatArray
    scales: FloatArray


@dataclass(frozen=True, slots=True)
class Fit:
    """Misclosures L, P L, partials B, whitened B (all in the known directions) and v of the model coordinates."""

    misclosures: FloatArray
    weighted: FloatArray
    partials: FloatArray
    weight: Weight
    model_residuals: FloatArray
    ground_residuals: FloatArray


@dataclass(frozen=True)
class AbsoluteProblem:
    """Control points: model (n, 3) and ground (n, 3) [m] from their centres, `known` K (n, 3, 3), cofactors, extent.

    `ground_cofactor`, `model_cofactor`: (n, 3, 3) or (3n, 3n); no model cofactor means an errorless model, whose
    weights do not change from step to step (`constant_weight`).
    """

    model: FloatArray
    ground: FloatArray
    known: FloatArray
    ground_cofactor: FloatArray
    model_cofactor: FloatArray | None
    extent: float
    constant_weight: Weight | None = None
    engine: Engine = Engine.QR

    @cached_property
    def is_full(self) -> bool:
        """Are all three coordinates of every point known?"""
        return bool((self.known == np.eye(3)).all())

    @property
    def scales(self) -> FloatArray:
        """1 for angles [rad] and ln H, the extent of the control for lengths [m]."""
        return np.array([1.0, 1.0, 1.0, 1.0, self.extent, self.extent, self.extent])

    def cofactor(self, rotation: FloatArray, t: float) -> FloatArray:
        """Q_G + t^2 R Q_x R'."""
        on_ground = None if self.model_cofactor is None else turned(t * rotation, self.model_cofactor)
        return added(self.ground_cofactor, on_ground)

    def weight(self, rotation: FloatArray, t: float) -> Weight:
        """P = (K (Q_G + t^2 R Q_x R') K)^+."""
        if self.constant_weight is not None:
            return self.constant_weight
        return weight_of(self.known, self.cofactor(rotation, t))

    def fit(self, state: Similarity) -> Fit:
        """Misclosures, partials and residuals of both sides at a state."""
        arms = state.t * state.rotation
        gaps = state.centre + self.model @ arms.T - self.ground
        misclosures = self.along_known(gaps[:, :, None])
        weight = self.weight(state.rotation, state.t)
        weighted = weight.times(misclosures)
        v_x = np.zeros_like(self.model)
        if self.model_cofactor is not None:
            v_x = -times(self.model_cofactor, arms.T @ weighted)[:, :, 0]
        v_P = times(self.ground_cofactor, weighted)[:, :, 0]
        partials = self.along_known(partials_rotation(self.model + v_x, state.rotation, state.t))
        return Fit(misclosures[:, :, 0], weighted[:, :, 0], partials, weight, v_x, v_P)

    def along_known(self, vectors: FloatArray) -> FloatArray:
        """K V (n, 3, k); V itself where all coordinates are known."""
        return vectors if self.is_full else np.asarray(self.known @ vectors)

    def linearise(self, state: Similarity) -> AbsoluteEquations:
        """Whitened equations about `state`, reduced by the engine."""
        try:
            fit = self.fit(state)
        except (np.linalg.LinAlgError, ZeroDivisionError, OverflowError):
            return _not_finite(self.scales)
        rows = np.concatenate([fit.partials * self.scales, fit.misclosures[:, :, None]], axis=2)
        if not np.isfinite(rows).all():
            return _not_finite(self.scales)
        white = fit.weight.whiten(rows).reshape(-1, UNKNOWNS + 1)
        R, rho = triangle(white[:, :-1], white[:, -1], self.engine)
        return AbsoluteEquations(float(np.sum(white[:, -1] ** 2)), R, rho, self.scales)

    def corrected(
        self, state: Similarity, linear: AbsoluteEquations, corrections: FloatArray
    ) -> tuple[Similarity, float]:
        """R <- exp([r]x) R, H <- H exp(d ln H), C <- C + dC: H keeps its sign whatever the step."""
        H = state.H * float(np.exp(corrections[3]))
        return Similarity(rotation_exp(corrections[:3]) @ state.rotation, H, state.centre + corrections[4:]), 0.0

    def redundancy_numbers(self, fit: Fit, Q: FloatArray) -> FloatArray:
        """diag(K - B Q B'P) (n, 3): they sum to n - 7; zero in the directions that are not known."""
        PB = fit.weight.times(fit.partials)
        own = np.diagonal(self.known, axis1=1, axis2=2)
        return np.asarray(own - np.einsum("nij,jk,nik->ni", fit.partials, Q, PB))

    def elements_with_model(self, state: Similarity, fit: Fit, Q: FloatArray) -> FloatArray:
        """Cofactors (n, 7, 3) between the elements (r, ln H, C) and each control point's model coordinates."""
        if self.model_cofactor is None:
            return np.zeros((len(self.model), UNKNOWNS, 3))
        PB = fit.weight.times(fit.partials)
        spread = times(self.model_cofactor, (state.t * state.rotation).T @ PB)
        return np.asarray(-Q @ spread.transpose(0, 2, 1))


def _not_finite(scales: FloatArray) -> AbsoluteEquations:
    """A state that cannot be linearised: infinite v'Pv, which the loop refuses."""
    return AbsoluteEquations(np.inf, np.zeros((UNKNOWNS, UNKNOWNS)), np.zeros(UNKNOWNS), scales)
