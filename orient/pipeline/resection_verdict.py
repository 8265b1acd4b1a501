"""Is what the resection found a result? Refusals that name their cause, and the trial with exchanged axes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.errors import GeometryError
from orient.pipeline.findings import fails_global_test, in_stored_names, odd_points
from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.functional_iteration import Termination
from orient.solvers.resection import Resection, resect
from orient.values import Event

MICROMETRES = 1000.0
NO_FIT_SHARE = 0.05
"""Residuals over the spread of the image points, both rms: beyond, the coordinates are not those of this photo."""
EXCHANGE_GAIN = 5.0
NEARLY_FLAT = 0.05
DECISIVE = 0.5
"""The approximate station chooses an orientation that is at most half as far from it as any other."""
DOUBLE_ROOT = 1e-6
"""Three points find a double solution to the root of the rounding error only: a condition ratio below is singular."""
INSEPARABLE = "cannot be separated"
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Scene:
    """The control points with all coordinates, right-handed, and what else decides: station near [m], place.

    `camera`: elements of the camera that are unknowns, with the readings of these points; `is_place_known`: something
    is known of station or angles.
    """

    points: Sequence[str]
    image: Array
    image_cofactor: Array
    ground: Array
    sigma0_mm: float
    near: Array | None
    camera_above: Array | None
    frame: Frame
    camera: CameraUnknowns | None = None
    is_place_known: bool = False


@dataclass(frozen=True, slots=True)
class Verdict:
    """Why there is no result (empty: there is one), what to do, and what else was noticed."""

    error: str = ""
    hint: str = ""
    events: tuple[Event, ...] = ()


def verdict(found: Resection, scene: Scene) -> Verdict:
    """CONVERGED and nothing against it, or the first of: no end, wrong axes, no fit, singular, ambiguous."""
    exchanged = _exchange(found, scene)
    if found.termination is not Termination.CONVERGED:
        error = f"{found.termination.value}: {in_stored_names(found.message, scene.frame)}{_cylinder(found, scene)}"
        return Verdict(error, _hint(found, exchanged), (*exchanged, *_odd(found, scene)))
    if exchanged:
        return Verdict(f"WRONG_AXES: {exchanged[0].message}", EXCHANGE_HINT, exchanged)
    apart = _misfit(found)
    if apart:
        return Verdict(apart, HINTS[Termination.MAX_ITERATIONS], tuple(_odd(found, scene)))
    if len(scene.points) == len(found.residuals) == 3 and found.condition_ratio < DOUBLE_ROOT:
        message = "SINGULAR: The control does not determine the orientation."
        return Verdict(message + _cylinder(found, scene), HINTS[Termination.SINGULAR])
    refused = _ambiguous(found, scene)
    return refused if refused.error else _mirrored(found, scene)


HINTS = {
    Termination.BEHIND_CAMERA: "Check signs and axes of the image coordinates and the order of the ground coordinates.",
    Termination.BELOW_GROUND: "X and Y of the ground may be exchanged, or handedness is wrong; see "
    "docs/conventions.md.",
    Termination.SINGULAR: "Add control off the line or plane of the others, or mend the points named above.",
    Termination.MAX_ITERATIONS: "Check coordinates (B and L exchanged? degrees for metres?), f and the axes of the "
    "readings.",
}
EXCHANGE_HINT = "Correct the order or the handedness of the ground coordinates, or the sign of the image's x."


def _hint(found: Resection, exchanged: Sequence[Event]) -> str:
    if exchanged:
        return EXCHANGE_HINT
    if INSEPARABLE in found.message:
        name = found.message.split(" ", 1)[0]
        return (
            f"Leave {name} out of --estimate, give its standard deviation in photo.toml, or add control at other "
            "heights or an oblique view."
        )
    return HINTS.get(found.termination, "Look at the iterations: orient show PROJECT resection")


def _odd(found: Resection, scene: Scene) -> list[Event]:
    return odd_points(scene.image, scene.ground, found.problem.f_mm, scene.points)


def _misfit(found: Resection) -> str:
    """The refusal of an adjustment that converged on data that do not belong together."""
    off = float(np.sqrt(np.mean(np.sum(found.residuals**2, axis=1))))
    image = found.computed - found.residuals
    spread = float(np.sqrt(np.mean(np.sum((image - image.mean(axis=0)) ** 2, axis=1))))
    if off <= NO_FIT_SHARE * spread:
        return ""
    return (
        f"NO_FIT: no orientation fits: the best leaves residuals of {off:.2g} mm rms "
        f"on image points spread over {spread:.3g} mm"
    )


def _exchange(found: Resection, scene: Scene) -> tuple[Event, ...]:
    """Would the control fit with two of its coordinates exchanged? Asked where it does not fit as it is, by so much
    that the standard deviations given leave room for the gain.

    A mirrored photo (x with the wrong sign) or a wrong handedness is the same for the fit.
    """
    is_converged = found.termination is Termination.CONVERGED
    does_not_fit = not is_converged or fails_global_test(found, scene.sigma0_mm)
    if 2 * len(scene.points) <= _unknowns(scene) or not does_not_fit:
        return ()
    before = _fit_as_given(found, scene)
    if before is None or (is_converged and before <= EXCHANGE_GAIN * scene.sigma0_mm):
        return ()
    is_misplaced = found.termination in (Termination.BEHIND_CAMERA, Termination.BELOW_GROUND)
    for name, ground, up in _exchanged_grounds(scene):
        after = _fit(found.problem.f_mm, scene, ground, up)
        if after is not None and EXCHANGE_GAIN * after < before:
            was, now = (_micrometres(sigma0) for sigma0 in (before, after))
            return (Event("warning", "exchange", "", f"exchange of {name} lowers sigma0 from {was} to {now}", after),)
        if after is not None and is_misplaced and after <= before + scene.sigma0_mm:
            message = f"with {name} exchanged the control fits and the camera is on the right side"
            return (Event("warning", "exchange", "", message, after),)
    return ()


def _unknowns(scene: Scene) -> int:
    """How many unknowns the points must determine in such a trial."""
    camera = scene.camera
    return 6 if camera is None else 6 + len(camera.names) - len(camera.observed)


def _fit_as_given(found: Resection, scene: Scene) -> float | None:
    """sigma0 [mm] that a trial has to undercut: where a known station takes part, of a resection without it."""
    if not scene.is_place_known:
        return _sigma0(found)
    return _fit(found.problem.f_mm, scene, scene.ground, UP if scene.camera_above is None else scene.camera_above)


def _micrometres(sigma0_mm: float) -> str:
    value = MICROMETRES * sigma0_mm
    return f"{value:.3g} um" if value < 1000 else f"{value:,.0f} um"


def _mirrored(found: Resection, scene: Scene) -> Verdict:
    """A terrestrial photo of points on a plane: data with exchanged axes fit as well, from the plane's other side."""
    centre = scene.ground.mean(axis=0)
    _, thickness, axes = np.linalg.svd(scene.ground - centre, full_matrices=False)
    if scene.camera_above is not None or len(scene.points) <= 3 or thickness[-1] > NEARLY_FLAT * thickness[0]:
        return Verdict()
    after = _fit(found.problem.f_mm, scene, scene.ground[:, [1, 0, 2]], UP)
    if after is None or after > 2 * _sigma0(found) + scene.sigma0_mm:
        return Verdict()
    if scene.near is None:
        height = float(found.station[2] - centre[2])
        message = (
            "the control lies on a plane and fits as well with X and Y exchanged: make sure that the camera stood on "
            f"this side of it, {abs(height):.4g} m {'below' if height < 0 else 'above'} the mean of the points"
        )
        return Verdict(events=(Event("warning", "mirror", "", message),))
    if (axes[2] @ (found.station - centre)) * (axes[2] @ (scene.near - centre)) < 0:
        return Verdict(
            "WRONG_SIDE: the approximate station lies on the other side of the control's plane", EXCHANGE_HINT
        )
    return Verdict()


def _exchanged_grounds(scene: Scene) -> list[tuple[str, Array, Array]]:
    """Name, ground and upward direction of each exchange that could have happened."""
    trials = [("X and Y", scene.ground[:, [1, 0, 2]], UP)]
    if scene.frame.origin is not None:
        B, L, H = scene.frame.geographic(scene.frame.right_handed(scene.ground)).T
        if np.all(np.abs(L) < np.pi / 2):
            place, above = (scene.frame.from_geographic(L, B, height) for height in (H, H + 1.0))
            up = (above - place).mean(axis=0)
            trials.append(("B and L", scene.frame.right_handed(place), scene.frame.right_handed(up)))
    return trials


def _fit(f_mm: float, scene: Scene, ground: Array, up: Array) -> float | None:
    """sigma0 [mm] of the resection with other ground, all of it fixed; None without a valid one.

    What is known of station and angles is in the axes that are in question: it does not take part.
    """
    try:
        found = resect(
            scene.image,
            scene.image_cofactor,
            ground,
            f_mm,
            interior=scene.camera,
            camera_above=None if scene.camera_above is None else up,
        )
    except GeometryError:
        return None
    return _sigma0(found) if found.termination is Termination.CONVERGED else None


def _sigma0(found: Resection) -> float:
    return float(np.sqrt(found.vPv / found.redundancy)) if found.redundancy > 0 else float(np.sqrt(found.vPv))


def _cylinder(found: Resection, scene: Scene) -> str:
    """Three points and a camera on the right cylinder through their circle: the danger cylinder, in words."""
    if len(scene.points) != 3:
        return ""
    a, b, c = scene.ground
    normal = np.cross(b - a, c - a)
    area = float(np.linalg.norm(normal))
    u, w = b - a, c - a
    centre = a + (np.cross(normal, u) * (w @ w) + np.cross(w, normal) * (u @ u)) / (2 * area**2)
    radius = float(np.linalg.norm(centre - a))
    across = found.station - centre
    across = across - (across @ normal) * normal / area**2
    off = abs(float(np.linalg.norm(across)) - radius)
    if not off < 0.01 * radius:
        return ""
    return f" The camera lies on the cylinder through {', '.join(scene.points)} (off by {off:.2g} m of {radius:.4g} m)."


def _ambiguous(found: Resection, scene: Scene) -> Verdict:
    """Refused unless the approximate station is clearly nearest to the one that was chosen."""
    rivals = [one.station for one in found.alternatives if one.is_as_good]
    if not rivals or _is_decided(found.station, rivals, scene.near):
        return Verdict()
    stations = [scene.frame.right_handed(station) for station in (found.station, *rivals)]
    stations.sort(key=lambda station: -station[2])  # they fit equally well: only rounding would order them
    places = "; ".join(", ".join(f"{value:.7g}" for value in station) for station in stations)
    why = f"{len(scene.points)} control points" + ("" if scene.near is None else " and the approximate station")
    message = f"AMBIGUOUS: {why} leave {len(stations)} orientations that fit equally well, X_S, Y_S, Z_S: {places}"
    hint = (
        "Give an approximate station in photo.toml ([station]), or measure one more control point; "
        "orient sql PROJECT solutions"
    )
    return Verdict(message, hint)


def _is_decided(chosen: Array, rivals: Sequence[Array], near: Array | None) -> bool:
    if near is None:
        return False
    nearest = min(float(np.linalg.norm(rival - near)) for rival in rivals)
    return float(np.linalg.norm(chosen - near)) <= DECISIVE * nearest
