"""The observations of a stored resection, as its adjustment saw them last, and its solution in the solver's axes."""

from collections.abc import Mapping
from dataclasses import dataclass

from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline.camera import is_estimated
from orient.pipeline.frames import frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.observations import Observations, observations, on_their_height
from orient.pipeline.resection import chain_of
from orient.pipeline.tables import Array, columns, required, single
from orient.pipeline.weights import ground_weights
from orient.solvers.independent_resection import ResectionObservations
from orient.values import Row, Settings, Tables


@dataclass(frozen=True, slots=True)
class ResectionCase:
    """Observations and stored solution of a resection, right-handed; `adjusted` (n, 3) ground, sigma0 a priori [mm]."""

    given: ResectionObservations
    station: Array
    rotation: Array
    adjusted: Array
    sigma0: float
    partner: Array


NOT_KNOWN = (
    "elements of the camera are unknowns, or [known] says something of the station or the angles: "
    "neither the second engine nor the simulation has these equations"
)


def knows_all_unknowns(settings: Settings, photo: Tables) -> bool:
    """Is the resection one of six elements and ground alone, as `ResectionObservations` describes it?"""
    return not is_estimated(settings) and not photo.get("known_element")


def resection_observations(inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> ResectionCase:
    """What a converged resection with these inputs and settings was computed from."""
    photo = single(inputs["photo"], "photo")
    ground = ground_of(photo)
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground)
    everyone = observations(inputs["refine"], inputs["topocentric"])[0]
    control = everyone.at(_that_carried(everyone, stored))
    sigma0 = required(photo, "sigma_image_mm")
    chain = chain_of(control, inputs, frame, ground, sigma0, settings)
    adjusted = _adjusted(control, stored)
    place, up = on_their_height(control, control.ground, adjusted, frame)
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
    )
    row = single(stored, "orientation")
    station, quaternion = columns([row], "X_S_m", "Y_S_m", "Z_S_m")[0], columns([row], "q_w", "q_x", "q_y", "q_z")[0]
    return ResectionCase(given, frame.right_handed(station), matrix_from_quaternion(quaternion),
                         frame.right_handed(adjusted), sigma0, frame.partner)  # fmt: skip


def _that_carried(seen: Observations, stored: Tables) -> list[int]:
    """Places of the control points that took part: those left out, by hand or by a test, have another role."""
    carried = {row["point"] for row in stored["image_residual"] if row["role"] == "control"}
    return [i for i, point in enumerate(seen.points) if point in carried]


def _adjusted(control: Observations, stored: Tables) -> Array:
    """(n, 3) adjusted ground in the stored frame; points without unknowns as given."""
    by_point: dict[str, Row] = {str(row["point"]): row for row in stored.get("adjusted_point", ())}
    rows = [by_point.get(point, given) for point, given in zip(control.points, control.rows, strict=True)]
    return columns(rows, "X_m", "Y_m", "Z_m")
