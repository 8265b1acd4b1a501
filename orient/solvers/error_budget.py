"""Sigma_u = sum over s of S_s C_s S_s': which part of the covariance of a resection comes from which observations.

S = du/dl are the sensitivities of the unknowns u = (elements, common unknowns c) to the observations l for the
weights that were used; C_s is the covariance of l as far as the source s makes it. The sources are independent, so
their parts sum to the covariance of u.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from orient.solvers.ground_points import point_cofactors
from orient.solvers.resection import Resection

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Sensitivities:
    """du/dl of the unknowns u = (e, c), 6+m elements (m of the camera) and k common ones.

    `by_image` (n, 6+m+k, 2) [per mm] by the measured image coordinates, `by_ground` (n, 6+m+k, 3) [per m] by the given
    ground coordinates, `by_common` (6+m+k, k) by the a-priori values of c, `by_known` (6+m+k, p) by what is known of
    the elements: priors of the camera, then station and angles.
    """

    by_image: FloatArray
    by_ground: FloatArray
    by_common: FloatArray
    by_known: FloatArray


@dataclass(frozen=True, slots=True)
class Sources:
    """Covariances (or cofactors) by the name of their source, of the observations that the source makes uncertain.

    `image` (n, 2, 2) of readings, `ground` (n, 3, 3) of given coordinates, `common` (k, k) of a-priori values.
    `known` (p, p) of what is known of the elements. A source may stand in all of them.
    """

    image: Mapping[str, FloatArray] = field(default_factory=dict)
    ground: Mapping[str, FloatArray] = field(default_factory=dict)
    common: Mapping[str, FloatArray] = field(default_factory=dict)
    known: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """In order of appearance."""
        return tuple(dict.fromkeys([*self.image, *self.ground, *self.common, *self.known]))


def sensitivities(found: Resection) -> Sensitivities:
    """S_x = Q (A + B T)' P,  S_p = Q T' W,  S_c = Q_z F^-1,  S_k = Q K' P_k: sensitivities of the unknowns.

    What a change of one observation does. A, B: partials of the image coordinates by the unknowns of the rim and by
    the point, T = dp/drim of the eliminated points, P and W: weights of the image and of the given ground coordinates,
    F: root of the cofactors of c, K and P_k: partials and weights of what is known of the elements. All linearised at
    the solution; a given coordinate in a direction that is taken as errorless has no sensitivity.
    Singular geometry gives NaN. Source: dx = -Q A'P dl of least squares, points eliminated.
    """
    problem, linear, rim = found.problem, found.linear, found.rim
    common = problem.common
    q = common.rank
    scales = np.concatenate([np.ones(q), linear.scales])
    by_rim = point_cofactors(linear.points, scales, rim, problem.known, common.by_ground).by_rim
    design, by_point = problem.image_rows(found.state)
    root = problem.known.weight_root
    weight = root.transpose(0, 2, 1) @ root
    by_image = rim @ (design + by_point @ by_rim).transpose(0, 2, 1) @ np.linalg.inv(problem.image_cofactor)
    by_ground = rim @ by_rim.transpose(0, 2, 1) @ weight
    by_known = rim[:, q:] @ (problem.known_equations(found.state)[0].T / np.sqrt(problem.known_cofactors))
    turn = problem.to_named
    by_common = turn @ rim[:, :q] @ common.inverse
    return Sensitivities(turn @ by_image, turn @ by_ground, by_common, turn @ by_known)


def error_budget(sensitive: Sensitivities, sources: Sources) -> dict[str, FloatArray]:
    """S C_s S' (u, u) of every source: its part of the covariance of the elements and the common unknowns."""
    u = sensitive.by_common.shape[0]
    parts = {name: np.zeros((u, u)) for name in sources.names}
    for name, covariance in sources.image.items():
        parts[name] += _summed(sensitive.by_image, covariance)
    for name, covariance in sources.ground.items():
        parts[name] += _summed(sensitive.by_ground, covariance)
    for name, covariance in sources.common.items():
        parts[name] += sensitive.by_common @ covariance @ sensitive.by_common.T
    for name, covariance in sources.known.items():
        parts[name] += sensitive.by_known @ covariance @ sensitive.by_known.T
    return {name: 0.5 * (part + part.T) for name, part in parts.items()}


def _summed(S: FloatArray, covariance: FloatArray) -> FloatArray:
    """sum_i S_i C_i S_i' as one product of (u, n m) matrices."""
    u = S.shape[1]
    weighted = (S @ covariance).transpose(1, 0, 2).reshape(u, -1)
    return np.asarray(weighted @ S.transpose(1, 0, 2).reshape(u, -1).T)
