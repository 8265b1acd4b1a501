"""The pose of a photo by other people's programs, where they are installed: OpenCV and PoseLib.

Both take a known camera, ground without errors, and readings of one precision: they can check the pose of such a
resection, nothing else. OpenCV begins without a start (SQPNP), PoseLib next to what it is told. They stop where their
own tolerances are met: thousandths of a standard deviation short of the minimum, which `ALLOWED` allows.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orient.solvers.independent_algebra import DISPLACED
from orient.solvers.independent_resection import ResectionObservations

FloatArray = NDArray[np.float64]

ALLOWED = 0.05
"""Standard deviations between two minima: OpenCV's refinement ends up to 4e-4 off with 6 points, 0.03 with 100 000."""
EQUAL = 1e-9
STEPS = 200
FLIP = np.diag([1.0, -1.0, -1.0])
"""From image axes x right, y up, z backwards to their x right, y down, z forwards."""


@dataclass(frozen=True, slots=True)
class ForeignPose:
    """Station (3,) [m] and rotation (3, 3) as in `resect`, by `engine`."""

    engine: str
    station: FloatArray
    rotation: FloatArray


def can_solve(given: ResectionObservations) -> bool:
    """Known camera, six unknowns, errorless ground, equal and uncorrelated weights, four points or more."""
    Q = given.image_cofactor
    is_equal = bool(np.max(np.abs(Q - Q[0, 0, 0] * np.eye(2))) <= EQUAL * Q[0, 0, 0])
    return given.n_unknowns == 6 and given.n_camera == 0 and not given.observed and is_equal and len(given.image) >= 4


def solve_by_others(given: ResectionObservations, station: FloatArray, rotation: FloatArray) -> list[ForeignPose]:
    """The poses of all engines that are installed; empty without any. Only for what `can_solve`.

    `station`, `rotation`: the solution to be checked, from which PoseLib's start is displaced, OpenCV's not taken.
    """
    installed = [module for module in ENGINES if find_spec(module) is not None]
    return [ENGINES[module](import_module(module), given, station, rotation) for module in installed]


def _opencv(cv2: Any, given: ResectionObservations, station: FloatArray, rotation: FloatArray) -> ForeignPose:
    """SQPNP, then Levenberg-Marquardt with steps down to rounding."""
    centre, distance, ground = _scaled(given, station)
    image = given.image * [1.0, -1.0] / given.f_mm
    K, none = np.eye(3), np.zeros(4)
    _, r, t = cv2.solvePnP(ground, image, K, none, flags=cv2.SOLVEPNP_SQPNP)
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, STEPS, np.finfo(np.float64).eps)
    r, t = cv2.solvePnPRefineLM(ground, image, K, none, r, t, criteria=criteria)
    return _pose(f"opencv {cv2.__version__} SQPNP + LM", cv2.Rodrigues(r)[0], t[:, 0], centre, distance)


def _poselib(poselib: Any, given: ResectionObservations, station: FloatArray, rotation: FloatArray) -> ForeignPose:
    """Levenberg-Marquardt from a start displaced by a milliradian and a thousandth of the distance."""
    centre, distance, ground = _scaled(given, station)
    start = poselib.CameraPose()
    turned = FLIP @ rotation.T @ _turn(DISPLACED)
    start.R = turned
    start.t = -turned @ ((station - centre) / distance + DISPLACED)
    # in units of f their tolerances for gradient and step would end the search early
    scale = 1e4
    camera = {"model": "SIMPLE_PINHOLE", "width": 0, "height": 0, "params": [scale, 0.0, 0.0]}
    options = {"loss_type": "TRIVIAL", "max_iterations": STEPS, "gradient_tol": 1e-14, "step_tol": 1e-14}
    image = given.image * [1.0, -1.0] * scale / given.f_mm
    pose, _ = poselib.refine_absolute_pose(image, ground, start, camera, options)
    return _pose("poselib LM", np.asarray(pose.R), np.asarray(pose.t), centre, distance)


ENGINES: dict[str, Callable[[Any, ResectionObservations, FloatArray, FloatArray], ForeignPose]] = {
    "cv2": _opencv,
    "poselib": _poselib,
}


def _scaled(given: ResectionObservations, station: FloatArray) -> tuple[FloatArray, float, FloatArray]:
    """Ground from its centre in units of the camera distance: in metres their damping ends a sigma off."""
    centre = given.ground.mean(axis=0)
    distance = float(np.mean(np.linalg.norm(given.ground - station, axis=1)))
    return centre, distance, np.ascontiguousarray((given.ground - centre) / distance)


def _pose(engine: str, R: FloatArray, t: FloatArray, centre: FloatArray, distance: float) -> ForeignPose:
    """X_camera = R X + t of theirs in the words of `resect`."""
    return ForeignPose(engine, centre - distance * (R.T @ t), np.asarray(R.T @ FLIP))


def _turn(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
