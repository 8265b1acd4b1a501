"""What an absolute orientation hands back: seven elements with their whole proof, as frozen values."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.functional_iteration import Termination

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class AbsoluteIteration:
    """Approximations of one iteration and what it added: a small rotation, dH, dX0."""

    rotation: FloatArray
    following_rotation: FloatArray
    H: float
    X0: FloatArray
    correction_rotation: FloatArray
    correction_H: float
    correction_X0: FloatArray
    vPv: float
    max_scaled_step: float
    damping: float


@dataclass(frozen=True, slots=True)
class OtherOrientation:
    """Another similarity in which the adjustment converged; `is_as_good`: by v'Pv alone."""

    rotation: FloatArray
    H: float
    X0: FloatArray
    vPv: float
    is_as_good: bool


@dataclass(frozen=True, slots=True)
class AbsoluteOrientation:
    """X_G = R x/H + X0 with its proof; a result only if `is_result`.

    Q (7, 7): cofactors of r_X, r_Y, r_Z [rad], H, X_0, Y_0, Z_0 [m]; `Q_centred` of r, ln H and the ground position of
    `model_centre`, which large coordinates leave their digits. `residuals` (n, 3): computed minus given in the known
    directions [m], of the OBSERVED model points; `model_residuals` and `ground_residuals` (n, 3): v = adjusted minus
    observed of either side. `redundancy_numbers` (n, 3) sum to r. `elements_with_model` (n, 7, 3): cofactors between
    the centred elements and each control point's model coordinates. NaN in Q when the control is singular;
    `undetermined` names the combination of unknowns (also when it is only nearly so), `cause` the layout.
    `vPv_mirrored`: what the mirrored model would leave, NaN if there was no need to ask.
    """

    termination: Termination
    message: str
    rotation: FloatArray
    H: float
    X0: FloatArray
    vPv: float
    n_equations: int
    n_unknowns: int
    residuals: FloatArray
    model_residuals: FloatArray
    ground_residuals: FloatArray
    redundancy_numbers: FloatArray
    Q: FloatArray
    Q_centred: FloatArray
    model_centre: FloatArray
    ground_centre: FloatArray
    elements_with_model: FloatArray
    condition_ratio: float
    iterations: tuple[AbsoluteIteration, ...]
    undetermined: str
    cause: str
    weak: tuple[tuple[str, str, float], ...]
    alternatives: tuple[OtherOrientation, ...]
    candidates_tried: int
    vPv_mirrored: float
    is_mirrored: bool

    @property
    def is_result(self) -> bool:
        """Converged, and not the fit of mirrored points."""
        return self.termination is Termination.CONVERGED and not self.is_mirrored

    @property
    def redundancy(self) -> int:
        """r = n - 7, n the number of EQUATIONS: 3 of a full point, 2 of a plan, 1 of a height. Source: seed 002."""
        return self.n_equations - self.n_unknowns

    @property
    def sigma0(self) -> float | None:
        """mu = sqrt(v'Pv / (n - 7)); None without redundancy. Source: seed 002, unit-weight error."""
        return float(np.sqrt(self.vPv / self.redundancy)) if self.redundancy > 0 else None

    @property
    def t(self) -> float:
        """Scale denominator t = 1/H of seed 002 [m per model unit]."""
        return 1.0 / self.H

    @property
    def T(self) -> FloatArray:
        """T = H X0 of form (4') [model units]."""
        return np.asarray(self.H * self.X0)

    @property
    def is_upside_down(self) -> bool:
        """r22 = c3 < 0: the model's Z axis points down on the ground."""
        return bool(self.rotation[2, 2] < 0)

    @property
    def is_ambiguous(self) -> bool:
        """Does another upright orientation fit as well?"""
        return any(other.is_as_good and other.rotation[2, 2] > 0 for other in self.alternatives)
