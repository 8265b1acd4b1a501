"""The same resections by other libraries, with their best settings; each adds the 6 x 6 covariance that it lacks."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.scenes import F_MM, HEIGHT_M, POINT_SIGMA_M, SIGMA_MM

Array = NDArray[np.float64]
FLIP = np.diag([1.0, -1.0, -1.0])
"""From orient's camera (y up, looking along -z) to theirs (y down, looking along +z)."""
PIXELS = 1.0 / SIGMA_MM
DENSE_STEPS = 5
"""As many as the steps of orient."""


def station_and_sigmas(R_cv: Array, t: Array, ground: Array) -> Array:
    """S [m] and its standard deviations: x = f X/Z, camera = R P + t; `ground` and t in flying heights."""
    X, Y, Z = (ground @ R_cv.T + t).T
    f = F_MM * PIXELS
    u, v, w = X / Z, Y / Z, 1.0 / Z
    J = np.zeros((2, len(u), 6))
    J[0, :, 0], J[0, :, 1], J[0, :, 2], J[0, :, 3], J[0, :, 5] = -u * v, 1 + u * u, -v, w, -u * w
    J[1, :, 0], J[1, :, 1], J[1, :, 2], J[1, :, 4], J[1, :, 5] = -1 - v * v, u * v, u, w, -v * w
    J = J.reshape(-1, 6) * f
    covariance = np.linalg.inv(J.T @ J)
    of_station = R_cv.T @ covariance[3:, 3:] @ R_cv
    return HEIGHT_M * np.concatenate([-R_cv.T @ t, np.sqrt(np.diag(of_station))])


def poselib_refined(image: Array, ground: Array, R0: Array, S0: Array) -> Array:
    """PoseLib's refinement, ground in flying heights, then the covariance."""
    import poselib

    R_cv, scaled = FLIP @ R0.T, ground / HEIGHT_M
    pose = poselib.CameraPose()
    pose.R, pose.t = R_cv, -R_cv @ (S0 / HEIGHT_M)
    pixels = image * np.array([PIXELS, -PIXELS])
    camera = {"model": "SIMPLE_PINHOLE", "width": 1, "height": 1, "params": [F_MM * PIXELS, 0.0, 0.0]}
    options = {"gradient_tol": 1e-12, "step_tol": 1e-12, "max_iterations": 100, "loss_type": "TRIVIAL"}
    found, _ = poselib.refine_absolute_pose(pixels, scaled, pose, camera, options)
    return station_and_sigmas(np.array(found.R), np.array(found.t), scaled)


def opencv_refined(image: Array, ground: Array, R0: Array, S0: Array) -> Array:
    """OpenCV's solvePnPRefineLM, then the covariance."""
    import cv2

    R_cv, scaled = FLIP @ R0.T, ground / HEIGHT_M
    rotation = cv2.Rodrigues(R_cv)[0]
    return _opencv_lm(cv2, image, scaled, rotation, (-R_cv @ (S0 / HEIGHT_M))[:, None])


def opencv_from_nothing(image: Array, ground: Array) -> Array:
    """OpenCV's SQPNP, refined, then the covariance."""
    import cv2

    scaled = ground / HEIGHT_M
    pixels = image * np.array([PIXELS, -PIXELS])
    K = np.diag([F_MM * PIXELS, F_MM * PIXELS, 1.0])
    _, rotation, t = cv2.solvePnP(scaled, pixels, K, None, flags=cv2.SOLVEPNP_SQPNP)
    return _opencv_lm(cv2, image, scaled, rotation, t)


def _opencv_lm(cv2: Any, image: Array, scaled: Array, rotation: Array, t: Array) -> Array:
    pixels = image * np.array([PIXELS, -PIXELS])
    K = np.diag([F_MM * PIXELS, F_MM * PIXELS, 1.0])
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-14)
    rotation, t = cv2.solvePnPRefineLM(scaled, pixels, K, None, rotation, t, criteria)
    return station_and_sigmas(cv2.Rodrigues(rotation)[0], t[:, 0], scaled)


def gtsam_weighted(image: Array, given: Array, R0: Array, S0: Array) -> Array:
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
    covariance = gtsam.Marginals(graph, found).marginalCovariance(0)
    of_station = pose.rotation().matrix() @ covariance[3:, 3:] @ pose.rotation().matrix().T
    return HEIGHT_M * np.concatenate([pose.translation(), np.sqrt(np.diag(of_station))])


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
