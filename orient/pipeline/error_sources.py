"""Which errors the observations of a resection have, by their source, and what each source does to the unknowns.

image readings        readings of the control points
interior orientation  film and readings of the fiducial marks: covariance of the parameters of `refine`
digitiser             readings of map points, and of the crosses as far as the digitiser's own sigma explains sigma0
map graticule         the rest of sigma0^2 of a sheet: drawing, paper, model of the polynomial
heights               heights of map points
survey                coordinates given in control with their covariance
camera                sigmas of the camera's elements, and of what is known of station and angles
"""

import numpy as np
from numpy.typing import NDArray

from orient.pipeline.chain import INTERIOR, Chain
from orient.pipeline.frames import Frame
from orient.pipeline.resection_rows import ROTATIONS, STATION, Rows
from orient.pipeline.tables import Array, named_packed_rows
from orient.solvers.error_budget import Sources, error_budget, sensitivities
from orient.solvers.resection import Resection
from orient.solvers.resection_problem import ELEMENTS

IMAGE, DIGITISER, MAP, HEIGHTS, SURVEY, CAMERA = (
    "image readings",
    "digitiser",
    "map graticule",
    "heights",
    "survey",
    "camera",
)
SOURCES = (IMAGE, INTERIOR, DIGITISER, MAP, HEIGHTS, SURVEY, CAMERA)


def source_cofactor_rows(found: Resection, chain: Chain, frame: Frame) -> Rows:
    """Rows of `source_cofactor`: the parts of the cofactors of the elements and the interior orientation."""
    parts = error_budget(sensitivities(found), sources(found, chain, frame))
    names, to_stored = ray_unknowns(found, chain, frame)
    u = len(names)
    rows: Rows = []
    for source in SOURCES:
        part = parts.get(source)
        if part is not None and part[:u, :u].any():
            matrix = to_stored @ part[:u, :u] @ to_stored
            rows += [{"source": source, **row} for row in named_packed_rows(matrix, names)]
    return rows


def ray_cofactor_rows(found: Resection, chain: Chain, frame: Frame) -> Rows:
    """Rows of `cofactor` for `ray`; none where the interior orientation is taken as known."""
    if chain.interior is None:
        return []
    names, to_stored = ray_unknowns(found, chain, frame)
    matrix = to_stored @ found.joint_cofactors[: len(names), : len(names)] @ to_stored
    return [{"unknowns": "ray", **row} for row in named_packed_rows(matrix, names)]


def ray_unknowns(found: Resection, chain: Chain, frame: Frame) -> tuple[list[str], Array]:
    """Names (u,) of the elements, those of the camera too, and the interior parameters; (u, u) to the stored frame."""
    interior = () if chain.interior is None else chain.interior.names
    names = [*ROTATIONS, *STATION, *found.unknowns[len(ELEMENTS) :], *interior]
    to_stored = np.eye(len(names))
    to_stored[3:6, 3:6] = frame.partner
    return names, to_stored


def sources(found: Resection, chain: Chain, frame: Frame) -> Sources:
    """Cofactors of the observations of the resection by source; they sum to those whose inverses were the weights."""
    return Sources(
        image={IMAGE: found.problem.image_cofactor},
        ground=_of_ground(found, chain, frame),
        common=_of_common(chain),
        known={CAMERA: np.diag(found.problem.known_cofactors)},
    )


def _of_ground(found: Resection, chain: Chain, frame: Frame) -> dict[str, Array]:
    """Given coordinates: what the weights say, split into reading, height and, for points apart, the sheet's share."""
    root = found.problem.known.weight_root
    weight: Array = root.transpose(0, 2, 1) @ root
    whole: Array = np.asarray(np.linalg.pinv(weight, rcond=1e-13, hermitian=True))
    is_weighted: NDArray[np.bool_] = np.any(weight != 0.0, axis=(1, 2))
    parts = {name: np.zeros_like(whole) for name in (DIGITISER, MAP, HEIGHTS)}
    survey = whole.copy()
    for sheet in chain.sheets:
        at = sheet.at
        reading, heights = (
            frame.right_handed_matrix(part) / chain.sigma0**2 * is_weighted[at][:, None, None]
            for part in (sheet.reading, sheet.heights)
        )
        of_sheet = np.zeros_like(reading) if chain.shared is not None else whole[at] - reading - heights
        by_digitiser = frame.right_handed_matrix(sheet.digitiser_share(frame.right_handed_matrix(of_sheet)))
        parts[DIGITISER][at] = reading + by_digitiser
        parts[MAP][at] = of_sheet - by_digitiser
        parts[HEIGHTS][at] = heights
        survey[at] = 0.0
    parts[SURVEY] = survey
    return parts


def _of_common(chain: Chain) -> dict[str, Array]:
    """A-priori covariances of the common unknowns: interior orientation first, then the coefficients of the sheets."""
    first = chain.interior_unknowns
    size = first + (0 if chain.shared is None else len(chain.shared.coefficients))
    parts: dict[str, Array] = {}
    if chain.interior is not None:
        parts[INTERIOR] = np.zeros((size, size))
        parts[INTERIOR][:first, :first] = chain.interior.covariance / chain.sigma0**2
    if chain.shared is not None:
        of_digitiser, of_map = np.zeros((2, size, size))
        root = np.sqrt(chain.shared.digitiser_share)
        covariance = chain.shared.covariance / chain.sigma0**2
        of_digitiser[first:, first:] = root[:, None] * covariance * root
        of_map[first:, first:] = covariance - of_digitiser[first:, first:]
        parts |= {DIGITISER: of_digitiser, MAP: of_map}
    return parts
