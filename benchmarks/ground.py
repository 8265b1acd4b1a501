"""Ground covariances, topocentric coordinates, similarity and polynomials of many points."""

from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from benchmarks.measuring import Task, compiled
from benchmarks.scenes import F_MM, photo
from orient.geodesy.ellipsoid import WGS84
from orient.geodesy.topocentric import Origin, geographic_from_topocentric, topocentric_from_geographic
from orient.geometry import polynomial
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.ground_covariance import (
    RayJacobians,
    all_pairs,
    covariance_by_orientation,
    covariance_factor,
    orientation_covariance,
    ray_at_height_jacobians,
)
from orient.solvers.lean_polynomial import lean_polynomial
from orient.solvers.lean_similarity import lean_similarity
from orient.solvers.polynomial_degree import Crosses, Rule
from orient.solvers.polynomial_fit import fit_sheet

Array = NDArray[np.float64]
MILLION = 1_000_000
DEGREE = 5


def tasks() -> Iterator[Task]:
    yield from map(_blocks, (100, 10_000, MILLION))
    yield _blocks_from_pose(MILLION)
    yield from _all_pairs(2000)
    for n in (100, 10_000, MILLION):
        yield from _topocentric(n)
    for n in (1000, 10_000, 100_000):
        yield _seven_parameters(n)
    yield _polynomial_fit(10_000)
    yield _polynomial_values(MILLION)


def _partials(n: int, rows: int) -> tuple[Array, Array]:
    """C (n, rows, 6) and a strongly correlated Q (6, 6)."""
    rng = np.random.default_rng(3)
    A = rng.normal(size=(12, 6)) @ np.tril(rng.normal(size=(6, 6)))
    return rng.normal(size=(n, rows, 6)), np.linalg.inv(A.T @ A)


def _blocks(n: int) -> Task:
    C, Q = _partials(n, 2)
    jacobians = RayJacobians(C, np.zeros((n, 2, 2)), np.zeros((n, 2)))

    def own(compiled: bool = False) -> Array:
        return _packed(orientation_covariance(jacobians, Q, compiled=compiled))

    def numpy() -> Array:
        return _packed(np.einsum("nik,kl,njl->nij", C, Q, C, optimize=True))

    name, line, anchor = f"2x2 blocks of K, C given, n = {n}", ("2x2 blocks of K", n), {"einsum(optimize=True)": numpy}
    if n < MILLION:
        return Task(name, {"orient": own, **anchor}, growth=line)
    candidates = {"orient": own, **compiled(partial(own, compiled=True)), **anchor}
    return Task(name, candidates, 0.75, growth=line, numba_target=0.25)


def _blocks_from_pose(n: int) -> Task:
    """Where rays meet their heights: how sure is the place, from the orientation alone."""
    rng = np.random.default_rng(4)
    ground = np.column_stack([rng.uniform(-75_000, 75_000, (n, 2)), rng.uniform(0, 3000, n)])
    one = photo(12)
    up = np.array([0.0, 0.0, 1.0])
    each_up = np.broadcast_to(up, (n, 3))
    Q = _partials(1, 2)[1] * np.outer(*[[1e-5] * 3 + [3.0] * 3] * 2)

    def own(compiled: bool = False) -> Array:
        return _packed(covariance_by_orientation(ground, one.S0, Q, up, plan=True, compiled=compiled))

    def by_partials() -> Array:
        jacobians = ray_at_height_jacobians(ground, one.S0, one.R0, F_MM, each_up)
        return _packed(orientation_covariance(jacobians, Q)[:, :2, :2])

    def numpy() -> Array:
        arms = ground - one.S0
        zs = arms @ one.R0[:, 2]
        xy = -F_MM * (arms @ one.R0[:, :2]) / zs[:, None]
        by_S = (F_MM * one.R0.T[None, :2] + xy[:, :, None] * one.R0.T[None, 2:]) / zs[:, None, None]
        by_r = np.cross(by_S, arms[:, None, :])
        C = np.linalg.inv(by_S[:, :, :2]) @ np.concatenate([-by_r, by_S], axis=2)
        return _packed(np.einsum("nik,kl,njl->nij", C, Q, C, optimize=True))

    note = "orient's are for any vertical; the partials of the stage serve the parts of reading and height too"
    candidates = {"orient": own, **compiled(partial(own, compiled=True)), "orient, partials of the stage": by_partials}
    candidates["numpy in one block"] = numpy
    return Task(f"2x2 blocks of K from pose and points, n = {n}", candidates, 0.45, note=note, numba_target=0.03)


def _packed(K: Array) -> Array:
    return K.reshape(len(K), -1)


def _all_pairs(n: int) -> Iterator[Task]:
    C, Q = _partials(n, 2)
    jacobians = RayJacobians(C, np.zeros((n, 2, 2)), np.zeros((n, 2)))
    wide = C.reshape(-1, 6)

    def factor() -> Array:
        return covariance_factor(jacobians, Q).reshape(-1, 6)

    def whole() -> Array:
        return all_pairs(factor())

    def numpy() -> Array:
        return np.asarray(wide @ Q @ wide.T)

    yield Task(f"all pairs, full K, N = {n}", {"orient": whole, "C @ Q @ C.T": numpy}, 1.0, note="exactly symmetric")
    yield Task(f"all pairs as the factor F = C L, N = {n}", {"orient": factor, "C @ Q @ C.T": numpy}, 0.001, None)


def _topocentric(n: int) -> Iterator[Task]:
    rng = np.random.default_rng(5)
    B, L, H = np.radians(rng.uniform(42, 44, n)), np.radians(rng.uniform(24, 26, n)), rng.uniform(0, 3000, n)
    origin = Origin(*np.radians([43.0, 25.0]), 100.0)
    T = topocentric_from_geographic(B, L, H, origin, WGS84)
    is_large = n == MILLION
    own_forward = partial(topocentric_from_geographic, B, L, H, origin, WGS84)
    forward: dict[str, Callable[[], object]] = {"orient": own_forward}
    if is_large:
        forward |= compiled(partial(own_forward, compiled=True))
    inverse: dict[str, Callable[[], object]] = {"orient": partial(geographic_from_topocentric, T, origin, WGS84)}
    if find_spec("pymap3d"):
        import pymap3d

        own = (origin.B, origin.L, origin.H)
        forward = {**forward, "pymap3d": lambda: _neu(pymap3d.geodetic2enu(B, L, H, *own, deg=False))}
        inverse = {
            **inverse,
            "pymap3d": lambda: np.column_stack(pymap3d.enu2geodetic(T[:, 1], T[:, 0], T[:, 2], *own, deg=False)),
        }
    forward["pyproj"], inverse["pyproj"] = _pyproj(B, L, H, T)
    name, line = f"geodetic to topocentric, n = {n}", ("geodetic to topocentric", n)
    yield Task(name, forward, 0.55 if is_large else None, 1e-9, line, numba_target=0.25)
    name, line = f"topocentric to geodetic, n = {n}", ("topocentric to geodetic", n)
    yield Task(name, inverse, 0.4 if is_large else None, 1e-9, line)


def _neu(enu: tuple[Array, Array, Array]) -> Array:
    return np.column_stack([enu[1], enu[0], enu[2]])


def _pyproj(B: Array, L: Array, H: Array, T: Array) -> tuple[Callable[[], object], Callable[[], object]]:
    from pyproj import Transformer

    pipeline = "+proj=pipeline +step +proj=cart +ellps=WGS84 +step +proj=topocentric +ellps=WGS84 "
    change = Transformer.from_pipeline(pipeline + "+lat_0=43 +lon_0=25 +h_0=100")

    def forward() -> Array:
        return _neu(change.transform(L, B, H, radians=True))

    def inverse() -> Array:
        found = change.transform(T[:, 1], T[:, 0], T[:, 2], radians=True, direction="INVERSE")
        return np.column_stack([found[1], found[0], found[2]])

    return forward, inverse


def _seven_parameters(n: int) -> Task:
    rng = np.random.default_rng(8)
    model = rng.normal(size=(n, 3))
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R *= np.linalg.det(R)
    ground = 20.0 * model @ R.T + [310.0, -2600.0, 120.0] + rng.normal(scale=0.1, size=(n, 3))

    def own(compiled: bool = False) -> Array:
        found = lean_similarity(model, ground, compiled=compiled)
        return np.concatenate([found.X0, found.rotation.ravel(), [found.H]])

    def stage() -> Array:
        found = orient_model(model, ground, allow_upside_down=True)
        return np.concatenate([found.X0, found.rotation.ravel(), [found.H]])

    def umeyama() -> Array:
        a, b = model - model.mean(axis=0), ground - ground.mean(axis=0)
        U, d, Vt = np.linalg.svd(b.T @ a)
        d[2] *= np.sign(np.linalg.det(U @ Vt))
        turn = U @ np.diag([1, 1, np.sign(np.linalg.det(U @ Vt))]) @ Vt
        t = d.sum() / np.sum(a * a)
        X0 = ground.mean(axis=0) - t * turn @ model.mean(axis=0)
        return np.concatenate([X0, turn.ravel(), [1 / t]])

    note = "orient's has the 7 x 7 cofactors, that of the stage iterations and all redundancy numbers too; Umeyama none"
    target, numba_target = (1.1, 0.15) if n == 100_000 else (None, None)
    candidates = {"orient": own, **compiled(partial(own, compiled=True)), "orient, stage": stage}
    candidates["numpy Umeyama"] = umeyama
    line = ("seven parameters", n)
    return Task(f"seven parameters, n = {n}", candidates, target, 1e-8, line, note, numba_target=numba_target)


def _crosses(n: int) -> tuple[Crosses, Array, Array]:
    rng = np.random.default_rng(9)
    XY = rng.uniform([0, 0], [500, 400], (n, 2))
    u, v = ((XY - [250, 200]) / 250).T
    coefficients = rng.normal(size=(21, 2)) * 100
    ground = polynomial.design(u, v, DEGREE) @ coefficients + rng.normal(scale=0.5, size=(n, 2))
    metres = np.ones((n, 2))
    return Crosses(XY, ground, metres), XY, coefficients


def _polynomial_fit(n: int) -> Task:
    crosses, XY, _ = _crosses(n)
    u, v = ((XY - [250, 200]) / 250).T

    def own() -> Array:
        fit = lean_polynomial(XY, crosses.target, DEGREE)
        assert fit.Q.shape == (21, 21)
        at = (XY[:100] - fit.centre) / fit.scale
        return np.asarray(polynomial.design(*at.T, DEGREE) @ fit.coefficients)

    def stage() -> Array:
        fit = fit_sheet(crosses, Rule(degree=DEGREE))
        at = (XY[:100] - fit.centre_mm) / fit.scale_mm
        return np.asarray(polynomial.design(*at.T, DEGREE) @ fit.coefficients)

    def numpy() -> Array:
        D = polynomial.design(u, v, DEGREE)
        return np.asarray(D[:100] @ np.linalg.lstsq(D, crosses.target, rcond=None)[0])

    note = "orient's has the cofactors, that of the stage tests every cross too; lstsq neither"
    candidates = {"orient": own, "orient, stage": stage, "numpy lstsq, normalised": numpy}
    return Task(f"polynomial fit, order {DEGREE}, n = {n}", candidates, 0.3, 1e-9, note=note)


def _polynomial_values(n: int) -> Task:
    rng = np.random.default_rng(9)
    u, v = rng.uniform(-1, 1, (2, n))
    coefficients = rng.normal(size=(21, 2))
    square = np.zeros((DEGREE + 1, DEGREE + 1, 2))
    for row, (j, k) in zip(coefficients, polynomial.exponents(DEGREE), strict=True):
        square[j, k] = row

    def own(compiled: bool = False) -> Array:
        return polynomial.values(u, v, coefficients, compiled=compiled)

    def numpy() -> Array:
        return np.column_stack([np.polynomial.polynomial.polyval2d(u, v, square[:, :, c]) for c in range(2)])

    candidates = {"orient": own, **compiled(partial(own, compiled=True)), "numpy polyval2d": numpy}
    return Task(f"polynomial evaluation, order {DEGREE}, n = {n}", candidates, 0.1, 1e-9, numba_target=0.01)
