"""P Q_v P = S'(N - H)S: what each observation of an adjustment shows of its own error, and what it hides.

The observations stand in blocks (the image coordinates of a point with its given ground coordinates, the N and E of a
cross). A block may have unknowns of its own, such as the coordinates of its point: N projects them away. What is left
is reduced by one QR decomposition to the unknowns on the rim, H = Q_1 Q_1'. The cost grows with the number of blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.critical_values import Limits

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

UNTESTED = 1e-6
"""Share of an error below which its trace in the residuals is rounding noise: no w, no smallest findable error."""
HARDLY = 0.1
"""Share below which an observation is called hardly checked."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """n blocks of k observations with the equations v = A d + B o + L, weight matrix P = S'S.

    `root` S (n, m, k); `inverse` S^+ (n, k, m); `design` A (n, k, u) by the rim; `residuals` v (n, k) = adjusted minus
    observed; `own` B (n, k, p) by the unknowns o of the block alone, of rank `own_rank` (n,); None without any.
    `tested` (n, k) marks the observations that there are (False: a coordinate that was not given), `rank` (n,) of S
    counts them; None: all k, and m. `weights` (n, k): (Q^-1)_ii of each observation where S is the root of a weight
    that several observations of the block make together, `inverse` then Q S'; None: P_ii of S'S.
    """

    root: FloatArray
    inverse: FloatArray
    design: FloatArray
    residuals: FloatArray
    own: FloatArray | None = None
    own_rank: IntArray | None = None
    tested: BoolArray | None = None
    rank: IntArray | None = None
    weights: FloatArray | None = None

    @property
    def freedom(self) -> IntArray:
        """(n,) equations that each block adds to the rim: its rank less its own unknowns."""
        n, m, _ = self.root.shape
        rank = np.full(n, m) if self.rank is None else self.rank
        return rank if self.own_rank is None else rank - self.own_rank


@dataclass(frozen=True, slots=True)
class BlockTests:
    """The tests of one group of blocks; (n, k) arrays hold NaN where an observation is not there or not tested.

    redundancy      r_i = (Q_v P)_ii; all of them sum to n - u
    share           (P Q_v P)_ii / P_ii: r_i where observations do not correlate, always within 0 ... 1
    w               (P v)_i / (sigma0 sqrt((P Q_v P)_ii)), Baarda's w, with the sigma0 of `limits`
    mdb             smallest findable error delta0 sigma0 / sqrt((P Q_v P)_ii), unit of the observation
    effect          (n, k, u_e) change of the elements by an error of that size, Q A'P e_i mdb
    bias_to_noise   sqrt(effect' Q_e^-1 effect) / sigma0, the effect in units of the elements' own precision
    trace           (n, k, u) Q_1'S: rows whose products are the correlations between blocks
    own_block       (n, k, k) P Q_v P within a block
    """

    redundancy: FloatArray
    share: FloatArray
    w: FloatArray
    mdb: FloatArray
    effect: FloatArray
    bias_to_noise: FloatArray
    trace: FloatArray
    own_block: FloatArray
    weighted_residuals: FloatArray

    @property
    def is_tested(self) -> BoolArray:
        """(n, k) observations with a test."""
        return np.isfinite(self.w)


@dataclass(frozen=True, slots=True)
class Reliability:
    """The tests of every group of blocks, and `root` R (u, u) of the reduced equations of the rim: A'PA = R'R."""

    tests: list[BlockTests]
    root: FloatArray


@dataclass(frozen=True, slots=True)
class Correlated:
    """The test that goes most with another one: |rho| and where that stands (group, block, observation)."""

    rho: float
    partner: tuple[int, int, int]


def observation_tests(groups: Sequence[Blocks], limits: Limits, elements: int) -> Reliability:
    """w_i = (P v)_i / (sigma0 sqrt((P Q_v P)_ii)) and all that goes with it, for every observation of an adjustment.

    `groups` share the u unknowns of the rim, the last `elements` of which are the elements whose change is asked for.
    Correlated observations are tested rightly: P Q_v P, not r_i alone, is what an error of one of them meets.
    An observation that no other checks (share below 1e-6) has NaN for w, mdb, effect and bias_to_noise.
    Source: W. Baarda, A testing procedure for use in geodetic networks, 1968; W. Foerstner 1983 for the external
    reliability; J. Wang and Y. Chen 1994 for correlated observations.
    """
    projectors = [_without_own(blocks) for blocks in groups]
    reduced = [N @ blocks.root @ blocks.design for blocks, N in zip(groups, projectors, strict=True)]
    stacked = np.vstack([rows.reshape(-1, rows.shape[2]) for rows in reduced])
    scales = np.linalg.norm(stacked, axis=0)
    scales = np.where(scales > 0, scales, 1.0)
    Q_1, R = np.linalg.qr(stacked / scales)
    tests, first = [], 0
    for blocks, N in zip(groups, projectors, strict=True):
        n, m, _ = blocks.root.shape
        rows = Q_1[first : first + n * m].reshape(n, m, -1)
        first += n * m
        tests.append(_tests(blocks, N, rows, (R, scales), limits, elements))
    return Reliability(tests, R * scales)


def prediction_statistic(blocks: Blocks, rim: Reliability, limits: Limits) -> tuple[FloatArray, IntArray]:
    """T_i = e'(I + A Q A')^-1 e / sigma0^2 of blocks that took no part in the adjustment, and degrees of freedom.

    e: whitened misfit of the block at the adjusted rim, its own unknowns fitted; Q the cofactors of the rim. Without a
    gross error T is chi^2 distributed. `residuals` of the blocks are computed - observed.
    """
    N = _without_own(blocks)
    white = N @ blocks.root
    e = white @ blocks.residuals[:, :, None]
    A = white @ blocks.design
    Y = np.linalg.solve(rim.root.T, A.reshape(-1, A.shape[2]).T).T.reshape(A.shape)
    spread = np.eye(A.shape[1]) + Y @ Y.transpose(0, 2, 1)
    T = np.sum(e * np.linalg.solve(spread, e), axis=(1, 2)) / limits.sigma0**2
    return T, blocks.freedom


def own_misfits(blocks: Blocks) -> FloatArray:
    """e'e (n,): weighted squared misfit of each block when only its own unknowns are fitted, the rim held fixed."""
    e = _without_own(blocks) @ blocks.root @ blocks.residuals[:, :, None]
    return np.asarray(np.sum(e * e, axis=(1, 2)))


def block_statistic(tests: BlockTests, observations: Sequence[int], limits: Limits) -> tuple[FloatArray, IntArray]:
    """T_i = (P v)'(P Q_v P)^+ (P v) / sigma0^2 of some observations of each block, and its degrees of freedom.

    It tests whether these observations of block i have any errors at all: chi^2 with as many degrees of freedom as
    there are directions that the others check; NaN where there are none. Source: Baarda 1968.
    """
    chosen = list(observations)
    Pv = tests.weighted_residuals[:, chosen]
    values, axes = np.linalg.eigh(tests.own_block[:, chosen][:, :, chosen])
    has_test = tests.is_tested[:, chosen].max(axis=1)
    present = (values > UNTESTED * np.maximum(values[:, -1:], 0.0)) & has_test[:, None]
    along = np.einsum("nij,ni->nj", axes, Pv)
    squares = np.where(present, along**2 / np.where(present, values, 1.0), 0.0)
    freedom = present.sum(axis=1).astype(np.int64)
    return np.where(freedom > 0, squares.sum(axis=1) / limits.sigma0**2, np.nan), freedom


def most_correlated(
    tests: Sequence[BlockTests], chosen: Sequence[tuple[int, int, int]], only_group: int | None = None
) -> dict[tuple[int, int, int], Correlated]:
    """rho_w of each chosen observation (group, block, observation) with the test of another block that is nearest.

    rho_ij = (P Q_v P)_ij / sqrt((P Q_v P)_ii (P Q_v P)_jj): above 0.9 an error of one is taken for one of the other.
    Observations of the same block are left out: they belong to one point and go together. `only_group` limits the
    partners to one group. Cost: len(chosen) x n.
    Source: W. Foerstner 1983.
    """
    places, rows = _numbered(tests, only_group)
    if not len(places):
        return {}
    trace = np.vstack([test.trace[number >= 0] for test, number in zip(tests, rows, strict=True)])
    root = np.concatenate([np.sqrt(_diagonal(test)[number >= 0]) for test, number in zip(tests, rows, strict=True)])
    found = {}
    for group, block, observation in chosen:
        test = tests[group]
        if not test.is_tested[block, observation]:
            continue
        own_root = np.sqrt(test.own_block[block, observation, observation])
        rho = np.abs(trace @ test.trace[block, observation]) / (root * own_root)
        own = rows[group][block]
        rho[own[own >= 0]] = 0.0
        nearest = int(np.argmax(rho))
        partner = tuple(places[nearest].tolist())
        found[group, block, observation] = Correlated(float(min(rho[nearest], 1.0)), partner)
    return found


def _numbered(tests: Sequence[BlockTests], only_group: int | None) -> tuple[IntArray, list[IntArray]]:
    """Group, block and observation (k, 3) of everything that is tested, in order; its number in each group, else -1."""
    places, rows, first = [], [], 0
    for group, test in enumerate(tests):
        wanted = test.is_tested if only_group in (None, group) else np.zeros_like(test.is_tested)
        number = np.full(wanted.shape, -1)
        number[wanted] = first + np.arange(np.count_nonzero(wanted))
        first += int(np.count_nonzero(wanted))
        places.append(np.column_stack([np.full(np.count_nonzero(wanted), group), np.argwhere(wanted)]))
        rows.append(number)
    return np.concatenate(places), rows


def _without_own(blocks: Blocks) -> FloatArray:
    """N = I - U U' with U the orthonormal base of S B: the projector that takes the block's own unknowns away."""
    n, m, _ = blocks.root.shape
    N = np.broadcast_to(np.eye(m), (n, m, m))
    if blocks.own is None or blocks.own_rank is None:
        return np.asarray(N)
    U = np.linalg.svd(blocks.root @ blocks.own, full_matrices=False)[0]
    U = U * (np.arange(U.shape[2]) < blocks.own_rank[:, None])[:, None, :]
    return np.asarray(N - U @ U.transpose(0, 2, 1))


def _tests(
    blocks: Blocks,
    N: FloatArray,
    Q_1: FloatArray,
    triangle: tuple[FloatArray, FloatArray],
    limits: Limits,
    elements: int,
) -> BlockTests:
    S, turned = blocks.root, blocks.root.transpose(0, 2, 1)
    M = N - Q_1 @ Q_1.transpose(0, 2, 1)
    own_block = turned @ M @ S
    Pv = (turned @ (S @ blocks.residuals[:, :, None]))[:, :, 0]
    P_ii = np.sum(S**2, axis=1) if blocks.weights is None else blocks.weights
    d = np.diagonal(own_block, axis1=1, axis2=2)
    given = P_ii > 0 if blocks.tested is None else blocks.tested & (P_ii > 0)
    share = np.where(given, np.maximum(d, 0.0) / np.where(given, P_ii, 1.0), np.nan)
    tested = given & (share > UNTESTED)
    root = np.sqrt(np.where(tested, d, np.nan))
    mdb = limits.delta0 * limits.sigma0 / root
    trace = (turned @ Q_1).astype(np.float64)
    R, scales = triangle
    effect = np.linalg.solve(R, trace.reshape(-1, len(R)).T).T.reshape(trace.shape) / scales
    return BlockTests(
        redundancy=np.where(given, np.einsum("nkm,nmk->nk", blocks.inverse, M @ S), np.nan),
        share=share,
        w=Pv / (limits.sigma0 * root),
        mdb=mdb,
        effect=effect[:, :, -elements:] * mdb[:, :, None],
        # the lower right block of R is the root of Q_e^-1, so the trace of the elements is the effect in its units
        bias_to_noise=np.linalg.norm(trace[:, :, -elements:], axis=2) * mdb / limits.sigma0,
        trace=trace,
        own_block=own_block,
        weighted_residuals=Pv,
    )


def _diagonal(test: BlockTests) -> FloatArray:
    return np.diagonal(test.own_block, axis1=1, axis2=2)
