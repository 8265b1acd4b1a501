"""Three-point resections of many triples: the misfits of all points to each, as starts for `consensus`."""

import numpy as np
from numpy.typing import NDArray

from orient.solvers.consensus import samples
from orient.solvers.p3p import three_point_resections
from orient.solvers.resection_reliability import Measured, View, view_misfits
from orient.solvers.start_values import camera_rays

FloatArray = NDArray[np.float64]


def triple_misfits(points: Measured, full: NDArray[np.bool_], f_mm: float) -> list[FloatArray]:
    """T (n,) of all points to every exact resection of triples of `full` points (three known coordinates).

    All triples of up to 10 points, else 120 random ones: with 40 % wrong points a triple is right with 21 %, so that
    none of 120 is with 1e-12. Weighted squared misfits [mm^2], infinite behind the camera.
    An unknown camera has its values a priori.
    """
    rays, ground = camera_rays(points.image, f_mm), points.ground.given
    centre = ground[full].mean(axis=0)
    camera = np.zeros(0) if points.interior is None else points.interior.apriori
    starts = []
    for triple in samples(np.flatnonzero(full).tolist(), 3):
        at = list(triple)
        for R, S in three_point_resections(rays[at], ground[at] - centre):
            starts.append(view_misfits(View(R, S + centre, f_mm, camera), points))
    return starts
