"""|R z + rho|^2 -> min, |D dx| <= radius: the step of Levenberg and Marquardt, its damping found from its length."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

GOOD_GAIN, POOR_GAIN, LEAST_GAIN = 0.75, 0.25, 1e-4
"""Decrease of v'Pv over the promised one: that widens the region, that narrows it, that a step must have."""
NEAR_ENOUGH = 1.01
ROUNDS = 50
SMALLEST = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, slots=True)
class BoundedStep:
    """dx (u,) in the units of the unknowns, its damping lambda, its length |D dx|, the decrease of v'Pv it promises.

    `is_whole`: nothing but the equations determined it; only such a step can show that the iteration has arrived.
    """

    corrections: FloatArray
    damping: float
    length: float
    predicted: float
    is_whole: bool


@dataclass(frozen=True, slots=True)
class TrustRegion:
    """The ellipsoid |D dx| <= radius in which linearised equations are believed; D (u,).

    D: the longest columns of the design matrix so far, so that an unknown that has lost its influence (a saturated
    curve) does not run away. `reach`: length of one scale in all unknowns at the start. The radius is not bounded
    before a step has failed, but a step beyond `reach` must then keep its promise.
    """

    D: FloatArray
    reach: float
    radius: float = np.inf

    @classmethod
    def at_start(cls, R: FloatArray) -> "TrustRegion":
        """About the first approximations: R (u, u) triangle of the scaled design matrix."""
        return cls(np.zeros(len(R)), float(np.linalg.norm(R)))

    def including(self, R: FloatArray, scales: FloatArray) -> "TrustRegion":
        """With D not shorter than the columns of R / s."""
        return replace(self, D=np.maximum(self.D, np.linalg.norm(R, axis=0) / scales))

    def step(self, R: FloatArray, rho: FloatArray, scales: FloatArray, singular_ratio: float = 0.0) -> BoundedStep:
        """(R'R + lambda (D s)^2) z = -R'rho, dx = s z: lambda = 0 if that stays inside, else such that |D dx| = radius.

        With `singular_ratio` > 0 (R is singular) lambda is at least (singular_ratio x largest singular value)^2: the
        unknowns do not move along the null vector. Source: Moré (1978), lambda after Hebden (1973).
        """
        D = np.where(self.D > 0, self.D, 1.0) * scales
        if singular_ratio == 0:
            z = np.asarray(-np.linalg.solve(R, rho))
            if np.linalg.norm(D * z) <= self.radius:
                return _bounded_step(R, D, z, scales, 0.0, is_whole=True)
        U, S, Vt = np.linalg.svd(R / D)
        g = U.T @ rho
        least = max((singular_ratio * float(S[0])) ** 2, SMALLEST) if singular_ratio else 0.0
        damping = _damping(S, g, self.radius, least)
        z = np.asarray(-(Vt.T @ (S / (S**2 + damping) * g)) / D)
        return _bounded_step(R, D, z, scales, damping, is_whole=0 < damping == least)

    def accepts(self, step: BoundedStep, gain: float) -> bool:
        """Does a step with this `gain`, the decrease of v'Pv over the one promised, lead on?"""
        return gain >= (GOOD_GAIN if self._is_beyond_reach(step) else LEAST_GAIN)

    def after(self, step: BoundedStep, gain: float) -> "TrustRegion":
        """Wider after a step that kept its promise, half of it after one that did not."""
        if self._is_beyond_reach(step) and not gain >= GOOD_GAIN:
            return replace(self, radius=self.reach)
        if not gain >= POOR_GAIN:
            return replace(self, radius=min(self.radius, step.length) / 2)
        if gain > GOOD_GAIN:
            return replace(self, radius=max(self.radius, 2 * step.length) if step.is_whole else 2 * step.length)
        return self

    def _is_beyond_reach(self, step: BoundedStep) -> bool:
        return bool(np.isinf(self.radius)) and step.length > self.reach


def _damping(S: FloatArray, g: FloatArray, radius: float, least: float) -> float:
    """lambda >= `least` with |S g / (S^2 + lambda)| <= radius, and not much less: Newton on 1 / length."""
    damping = least
    for _ in range(ROUNDS):
        y = S * g / (S**2 + damping)
        length = float(np.linalg.norm(y))
        if not length > NEAR_ENOUGH * radius:
            break
        damping += (length / radius - 1) * length**2 / float(np.sum(y**2 / (S**2 + damping)))
    return damping


def _bounded_step(
    R: FloatArray, D: FloatArray, z: FloatArray, scales: FloatArray, damping: float, *, is_whole: bool
) -> BoundedStep:
    """|rho|^2 - |R z + rho|^2 = |R z|^2 + 2 lambda |D z|^2 is what the step promises, without cancellation."""
    length = float(np.linalg.norm(D * z))
    predicted = float(np.sum((R @ z) ** 2)) + 2 * damping * length**2
    return BoundedStep(scales * z, damping, length, predicted, is_whole)
