"""The same resections by other libraries, with their best settings; what a library lacks of `Orientation` is added."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.scenes import F_MM, HEIGHT_M, POINT_SIGMA_M, SIGMA_MM

Array = NDArray[np.float64]
FLIP = np.diag([1.0, -1.0, -1.0])
"""From orient's camera (y up, looking along -z) to theirs (y down, looking along +z)."""
PIXELS = 1.0 / SIGMA_MM
K_CV = np.diag([F_MM * PIXELS, F_MM * PIXELS, 1.0])
DENSE_STEPS = 5
"""As many as the steps of orient."""


class Orientation(NamedTuple):
    """What each candidate finds: R (3, 3), S (3,), covariance (6, 6) of (r, S) with R_new = exp([r]x) R, v'v [mm^2]."""

    rotation: Array
    station: Array
    covariance: Array
    vv: float


def with_covariance(R_cv: Array, t: Array, scaled: Array, pixels: Array) -> Orientation:
    """Of x = f X/Z, camera = R P + t; `scaled` P and t in flying heights, `pixels` of one sigma."""
    X, Y, Z = (scaled @ R_cv.T + t).T
    f = F_MM * PIXELS
    u, v, w = X / Z, Y / Z, 1.0 / Z
    J = np.zeros((6, 2, len(u)))
    J[0, 0], J[1, 0], J[2, 0], J[3, 0], J[5, 0] = -u * v, 1 + u * u, -v, w, -u * w
    J[0, 1], J[1, 1], J[2, 1], J[4, 1], J[5, 1] = -1 - v * v, u * v, u, w, -v * w
    J = J.reshape(6, -1) * f
    dx, dy = pixels[:, 0] - f * u, pixels[:, 1] - f * v
    covariance = _on_ground(np.linalg.inv(J @ J.T), R_cv.T)  # r -> -R' r, dS = -R' dt
    return Orientation((FLIP @ R_cv).T, -HEIGHT_M * (t @ R_cv), covariance, float(dx @ dx + dy @ dy) * SIGMA_MM**2)


def _on_ground(covariance: Array, R: Array) -> Array:
    """Of (r, dS) in the ground's axes and metres, from that in the axes of the camera and flying heights."""
    turn = np.zeros((6, 6))
    turn[:3, :3], turn[3:, 3:] = R, HEIGHT_M * R
    return turn @ covariance @ turn.T


def poselib_refined(image: Array, ground: Array, R0: Array, S0: Array) -> Orientation:
    """PoseLib's refinement, ground in flying heights."""
    import poselib

    R_cv, scaled = FLIP @ R0.T, ground / HEIGHT_M
    pose = poselib.CameraPose()
    pose.R, pose.t = R_cv, -R_cv @ (S0 / HEIGHT_M)
    pixels = image * np.array([PIXELS, -PIXELS])
    camera = {"model": "SIMPLE_PINHOLE", "width": 1, "height": 1, "params": [F_MM * PIXELS, 0.0, 0.0]}
    options = {"gradient_tol": 1e-12, "step_tol": 1e-12, "max_iterations": 100, "loss_type": "TRIVIAL"}
    found, _ = poselib.refine_absolute_pose(pixels, scaled, pose, camera, options)
    return with_covariance(np.array(found.R), np.array(found.t), scaled, pixels)


def opencv_refined(image: Array, ground: Array, R0: Array, S0: Array) -> Orientation:
    """OpenCV's solvePnPRefineLM."""
    import cv2

    R_cv, scaled = FLIP @ R0.T, ground / HEIGHT_M
    rotation = cv2.Rodrigues(R_cv)[0]
    pixels = image * np.array([PIXELS, -PIXELS])
    return _opencv_lm(cv2, pixels, scaled, rotation, (-R_cv @ (S0 / HEIGHT_M))[:, None])


def opencv_from_nothing(image: Array, ground: Array) -> Orientation:
    """OpenCV's SQPNP, refined."""
    import cv2

    scaled = ground / HEIGHT_M
    pixels = image * np.array([PIXELS, -PIXELS])
    _, rotation, t = cv2.solvePnP(scaled, pixels, K_CV, None, flags=cv2.SOLVEPNP_SQPNP)
    return _opencv_lm(cv2, pixels, scaled, rotation, t)


def _opencv_lm(cv2: Any, pixels: Array, scaled: Array, rotation: Array, t: Array) -> Orientation:
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-14)
    rotation, t = cv2.solvePnPRefineLM(scaled, pixels, K_CV, None, rotation, t, criteria)
    return with_covariance(cv2.Rodrigues(rotation)[0], t[:, 0], scaled, pixels)


def gtsam_weighted(image: Array, given: Array, R0: Array, S0: Array) -> Orientation:
    """GTSAM: projection factors and priors on the points, Levenberg-Marquardt, the marginal of the pose."""
    import gtsam

    K = gtsam.Cal3_S2(F_MM * PIXELS, F_MM * PIXELS, 0.0, 0.0, 0.0)
    reading = gtsam.noiseModel.Isotropic.Sigma(2, 1.0)
    known = gtsam.noiseModel.Diagonal.Sigmas(POINT_SIGMA_M / HEIGHT_M)
    graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    values.insert(0, gtsam.Pose3(gtsam.Rot3(R0 @ FLIP), S0 / HEIGHT_M))
    pixels = image * np.array([PIXELS, -PIXELS])
    for i, (seen, point) in enumerate(zip(pixels, given / HEIGHT_M, strict=True), 1):
        graph.add(gtsam.GenericProjectionFactorCal3_S2(seen, reading, 0, i, K))
        graph.add(gtsam.PriorFactorPoint3(i, point, known))
        values.insert(i, point)
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-14)
    parameters.setAbsoluteErrorTol(1e-14)
    found = gtsam.LevenbergMarquardtOptimizer(graph, values, parameters).optimize()
    pose = found.atPose3(0)
    R = pose.rotation().matrix()
    covariance = _on_ground(gtsam.Marginals(graph, found).marginalCovariance(0), R)
    return Orientation(R @ FLIP, HEIGHT_M * pose.translation(), covariance, 2.0 * graph.error(found) * SIGMA_MM**2)


def dense_weighted(image: Array, given: Array, R: Array, S: Array) -> Array:
    """What a script does: the dense normal equations of 6 + 3n unknowns from rough R, S, and all covariances."""
    from orient.geometry.collinearity import projected_with_partials
    from orient.geometry.rotation import rotation_exp

    P, n = given, len(given)
    sigmas = np.concatenate([np.full(2 * n, SIGMA_MM), np.tile(POINT_SIGMA_M, n)])
    A, l = np.zeros((5 * n, 6 + 3 * n)), np.empty(5 * n)
    A[2 * n :, 6:] = np.eye(3 * n)
    for _ in range(DENSE_STEPS):
        computed, partials = projected_with_partials(P, S, R, F_MM)
        A[: 2 * n, :6] = partials[:, :, :6].reshape(-1, 6)
        for i in range(n):
            A[2 * i : 2 * i + 2, 6 + 3 * i : 9 + 3 * i] = partials[i, :, 6:]
        l[: 2 * n], l[2 * n :] = (image - computed).ravel(), (given - P).ravel()
        whitened = A / sigmas[:, None]
        N = whitened.T @ whitened
        d = np.linalg.solve(N, whitened.T @ (l / sigmas))
        R, S, P = rotation_exp(d[:3]) @ R, S + d[3:6], P + d[6:].reshape(-1, 3)
    return np.asarray(np.linalg.inv(N))
