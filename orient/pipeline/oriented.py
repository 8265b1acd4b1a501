"""The stored orientation of the photo, back in the solver's right-handed frame."""

from dataclasses import dataclass

from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline.frames import Frame
from orient.pipeline.ground_budget import ELEMENTS, RayUnknowns, ray_unknowns_of, right_handed_cofactors
from orient.pipeline.tables import Array, columns, required, single
from orient.values import Tables


@dataclass(frozen=True, slots=True)
class Oriented:
    """The orientation in the solver's right-handed frame, with the covariance of its six elements.

    `rays`: cofactors of all that an image ray depends on, camera and interior orientation too. `variance_scale` [mm^2]:
    variance of unit weight by which all cofactors are multiplied; `scale`: the same in units of the one a priori.
    """

    station: Array
    rotation: Array
    f_mm: float
    covariance: Array
    scale: float
    variance_scale: float
    rays: RayUnknowns

    @property
    def ray_covariance(self) -> Array:
        """(6+m+k, 6+m+k) of the elements, the m of the camera and the k parameters of the interior orientation."""
        return self.variance_scale * self.rays.cofactor


def oriented_by(photo: Tables, refine: Tables, resection: Tables, frame: Frame) -> Oriented:
    """The orientation that the stage `resection` stored; elements r (right-handed ground axes), X_S, Y_S, Z_S."""
    row = single(resection, "orientation")
    scale = required(row, "variance_scale")
    Q = right_handed_cofactors([entry for entry in resection["cofactor"] if entry["unknowns"] == "rotation"], frame)
    return Oriented(
        station=frame.right_handed(columns([row], "X_S_m", "Y_S_m", "Z_S_m")[0]),
        rotation=matrix_from_quaternion(columns([row], "q_w", "q_x", "q_y", "q_z")[0]),
        f_mm=required(row, "f_mm"),
        covariance=scale * Q[:ELEMENTS, :ELEMENTS],
        scale=scale / required(row, "sigma0_apriori_mm") ** 2,
        variance_scale=scale,
        rays=ray_unknowns_of(photo, refine, resection, frame),
    )
