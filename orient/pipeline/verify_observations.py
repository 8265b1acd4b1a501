"""The observations of a stored resection, as its adjustment saw them last, and its solution in the solver's axes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from orient.geometry.camera import INTERIOR
from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline.camera import is_estimated, with_element
from orient.pipeline.chain import Chain
from orient.pipeline.frames import frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.known_elements import known_elements
from orient.pipeline.observations import Observations, observations, on_their_height
from orient.pipeline.resection import chain_of
from orient.pipeline.tables import Array, columns, required, single
from orient.pipeline.weights import ground_weights
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.element_observations import ElementObservation
from orient.solvers.independent_camera import IndependentCamera
from orient.solvers.independent_resection import KnownNumber, ResectionObservations
from orient.values import Row, Settings, Tables


@dataclass(frozen=True, slots=True)
class ResectionCase:
    """Observations and stored solution of a resection, right-handed; `adjusted` (n, 3) ground, sigma0 a priori [mm].

    `camera` (m,): stored values of the estimated elements.
    """

    given: ResectionObservations
    station: Array
    rotation: Array
    adjusted: Array
    sigma0: float
    partner: Array
    camera: Array


NOT_SIMULATED = (
    "elements of the camera are unknowns, or [known] says something of the station or the angles: "
    "the simulation has no such observations"
)


def knows_all_unknowns(settings: Settings, photo: Tables) -> bool:
    """Is the resection one of six elements and ground alone, as the simulation draws it?"""
    return not is_estimated(settings) and not photo.get("known_element")


def resection_observations(inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> ResectionCase:
    """What a converged resection with these inputs and settings was computed from."""
    photo = single(inputs["photo"], "photo")
    ground = ground_of(photo)
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground)
    everyone = observations(inputs["refine"], inputs["topocentric"])[0]
    control = everyone.at(_that_carried(everyone, stored))
    sigma0 = required(photo, "sigma_image_mm")
    chain = _with_calibrated(chain_of(control, inputs, frame, ground, sigma0, settings), photo, inputs, stored)
    adjusted = _adjusted(control, stored)
    place, up = on_their_height(control, control.ground, adjusted, frame)
    known = known_elements(inputs["photo"].get("known_element", ()), frame, sigma0)
    own = None if chain.shared is None else chain.shared.own
    free, weight = ground_weights(control.rows, str(settings["control"]), sigma0, own).at(up)
    given = ResectionObservations(
        image=control.image,
        image_cofactor=control.image_covariance / sigma0**2,
        ground=frame.right_handed(place),
        f_mm=required(photo, "f_mm"),
        free=frame.right_handed_matrix(free),
        weight=frame.right_handed_matrix(weight),
        common=chain.in_solver(control.comparator, frame),
        camera=None if chain.camera is None else independent_camera(chain.camera),
        observed=[_number(one) for one in known.observations],
        is_station_fixed=known.fixed_station is not None,
    )
    row = single(stored, "orientation")
    station, quaternion = columns([row], "X_S_m", "Y_S_m", "Z_S_m")[0], columns([row], "q_w", "q_x", "q_y", "q_z")[0]
    return ResectionCase(given, frame.right_handed(station), matrix_from_quaternion(quaternion),
                         frame.right_handed(adjusted), sigma0, frame.partner, _stored_camera(stored))  # fmt: skip


def _with_calibrated(chain: Chain, photo: Row, inputs: Mapping[str, Tables], stored: Tables) -> Chain:
    """The chain with the elements that --calibrate auto has taken."""
    camera = chain.camera
    for row in stored.get("camera_element", ()):
        name = str(row["unknown"])
        if camera is not None and name not in camera.names:
            camera = with_element(camera, name, photo, inputs["photo"], chain.sigma0)
    return replace(chain, camera=camera)


def _number(one: ElementObservation) -> KnownNumber:
    """What is known of station and angles by its value alone, without the partials of the first engine."""
    return KnownNumber(lambda rotation, station: one.misclosure(rotation, station)[0], one.cofactor)


def independent_camera(unknowns: CameraUnknowns) -> IndependentCamera:
    """The unknown camera for the second engine."""
    camera, lens = unknowns.camera, unknowns.camera.distortion
    own = {"f": camera.f_mm, "x0": camera.x0_mm, "y0": camera.y0_mm, "b1": camera.b1, "b2": camera.b2}
    return IndependentCamera(
        unknowns.names,
        {**lens.coefficients, **own},
        unknowns.cofactors,
        lens.model,
        lens.direction,
        lens.table,
        unknowns.measured.frame,
        unknowns.measured.air,
    )


def _stored_camera(stored: Tables) -> Array:
    """(m,) in the order of the cofactors."""
    value = {str(row["unknown"]): required(row, "value") for row in stored.get("camera_element", ())}
    return np.array([value[name] for name in INTERIOR if name in value])


def _that_carried(seen: Observations, stored: Tables) -> list[int]:
    """Places of the control points that took part: those left out, by hand or by a test, have another role."""
    carried = {row["point"] for row in stored["image_residual"] if row["role"] == "control"}
    return [i for i, point in enumerate(seen.points) if point in carried]


def _adjusted(control: Observations, stored: Tables) -> Array:
    """(n, 3) adjusted ground in the stored frame; points without unknowns as given."""
    by_point: dict[str, Row] = {str(row["point"]): row for row in stored.get("adjusted_point", ())}
    rows = [by_point.get(point, given) for point, given in zip(control.points, control.rows, strict=True)]
    return columns(rows, "X_m", "Y_m", "Z_m")
