"""x_i = T(X_i; p + c): the parameters p of the interior orientation carry the errors c of film and fiducial readings.

All image points share them: H_i = dT/dp at the comparator coordinates X_i of the point. Their covariance a priori is
that of the fit to the fiducial marks. Corrections behind T (lens, refraction) turn a shift by too little to matter.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry import plane
from orient.pipeline.resection_rows import Rows
from orient.pipeline.tables import Array, columns, required, single
from orient.solvers.common_unknowns import CommonUnknowns
from orient.solvers.packed import unpack_upper
from orient.values import Row, Tables

UNITS = {"a0": "mm", "b0": "mm", "c1": "1/mm", "c2": "1/mm"}


@dataclass(frozen=True, slots=True)
class InteriorUnknowns:
    """The named parameters p (k,) of a transformation, with their covariance (k, k) from the fiducial marks."""

    transformation: str
    names: Sequence[str]
    values: Array
    covariance: Array

    @property
    def units(self) -> list[str]:
        """Of each parameter: x, y and X, Y are in mm."""
        return [UNITS.get(name, "1") for name in self.names]

    def by_image(self, comparator: Array) -> Array:
        """H (n, 2, k) [mm per unit] at the comparator coordinates (n, 2) [mm]."""
        return plane.partials(self.transformation, self.values, comparator)

    def in_solver(self, comparator: Array, sigma0: float) -> CommonUnknowns:
        """The same for the solver: cofactors instead of covariances, no effect on the ground."""
        no_partials = np.zeros((len(comparator), 3, len(self.names)))
        names = [f"{name} of the interior orientation" for name in self.names]
        return CommonUnknowns(no_partials, self.covariance / sigma0**2, names, self.by_image(comparator))


def interior_unknowns(refine: Tables) -> InteriorUnknowns | None:
    """What the image points share, None without fiducial marks or when their covariance was not stored."""
    packed = [required(row, "value") for row in refine.get("interior_covariance", ())]
    if not packed:
        return None
    transformation = str(single(refine, "interior_orientation")["transformation"])
    by_name = {str(row["name"]): required(row, "value") for row in refine["interior_parameter"]}
    names = plane.parameter_names(transformation)
    values = np.array([by_name[name] for name in names])
    return InteriorUnknowns(transformation, names, values, unpack_upper(np.array(packed)))


def adjusted_interior_rows(
    interior: InteriorUnknowns | None, corrections: Array, cofactors: Array, sigma0: float
) -> Rows:
    """The parameters after the adjustment, with what the control has added to the fiducial marks.

    `corrections` (k,), `cofactors` (k,): of these unknowns.
    """
    if interior is None:
        return []
    before = np.diagonal(interior.covariance) / sigma0**2
    return [
        {
            "name": name,
            "value": float(interior.values[i] + corrections[i]),
            "correction": float(corrections[i]),
            "q": float(cofactors[i]),
            "variance_ratio": float(cofactors[i] / before[i]) if before[i] > 0 else 1.0,
        }
        for i, name in enumerate(interior.names)
    ]


def image_shift(interior: InteriorUnknowns | None, adjusted: Sequence[Row], comparator: Array) -> Array:
    """(n, 2) [mm] what the adjusted parameters (rows of `adjusted_interior`) add to the image coordinates."""
    if interior is None or not adjusted:
        return np.zeros_like(comparator)
    by_name = {str(row["name"]): row for row in adjusted}
    corrections = columns([by_name[name] for name in interior.names], "correction")[:, 0]
    return np.asarray(interior.by_image(comparator) @ corrections)
