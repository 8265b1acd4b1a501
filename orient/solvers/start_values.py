"""Exterior orientations from nothing: several closed forms, each judged on all points, best first."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.solvers.direct_linear import direct_linear_resection
from orient.solvers.p3p import resections_of_triples
from orient.solvers.plane_resection import plane_resection

FloatArray = NDArray[np.float64]

SPREAD_POINTS = 6
LARGEST_TRIPLES = 20
SMALLEST_AREA = 1e-7
MIRRORED = 3
NEARLY_FLAT, SOME_RELIEF = 0.1, 1e-3
"""Thickness over length of the control: below, a plane may serve; above, twelve coefficients are determined."""
MOST_POINTS = 1000
MOST_JUDGED = 8192
"""Points that are projected at once."""
FARTHEST = 1e8
"""Camera distance in sizes of the control beyond which a candidate is rounding, no orientation."""


class Method(StrEnum):
    """The closed form that a candidate comes from."""

    THREE_POINTS = "three points"
    DIRECT_LINEAR = "direct linear"
    PLANE = "plane"
    STATION = "approximate station"
    GIVEN = "given orientation"


Form = tuple[FloatArray, FloatArray, tuple[int, ...], Method]
"""R, S, the three points it comes from, the closed form."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A possible exterior orientation and how it fits all points.

    `triple`: the three points it comes from, () if it comes from all; `is_reversed`: with the relief of the control
    taken the other way along the camera axis; `n_in_front`: points in front of the camera.
    """

    rotation: FloatArray
    station: FloatArray
    rms_mm: float
    n_in_front: int
    all_in_front: bool
    triple: tuple[int, ...]
    method: Method
    is_reversed: bool = False

    def at(self, station: FloatArray) -> "Candidate":
        """The same with its station in another unit or about another origin."""
        judged = self.rms_mm, self.n_in_front, self.all_in_front
        return Candidate(self.rotation, station, *judged, self.triple, self.method, self.is_reversed)


def start_candidates(
    image: FloatArray, ground: FloatArray, f_mm: float, approximate_station: FloatArray | None = None
) -> list[Candidate]:
    """Every (R, S) that a closed form offers, sorted: all points in front first, then by rms.

    `image` (n, 2) [mm], `ground` (n, 3) [m] right-handed, n >= 3, all coordinates known. The forms: exact resections
    of at most 20 triples, the largest in image and ground among six points far apart in the image, up to four each;
    from six points with relief the direct linear transformation, from four nearly on a plane its projective map; an
    approximate station with the rotation that turns the rays best onto its directions. The best ones are also taken
    with their relief reversed along the camera axis: flat ground in a narrow field has two nearly equal solutions.
    No triple that is not nearly a line, in the image or on the ground, and no approximate station: an empty list.
    Source: three_point_resections, direct_linear_resection, plane_resection; rotation between directions by Kabsch
    (1976); reversal as in Oberkampf, DeMenthon and Davis (1996).
    """
    centre = ground.mean(axis=0)
    size = float(np.max(np.linalg.norm(ground - centre, axis=1)))
    scaled = (ground - centre) / size
    near = None if approximate_station is None else (approximate_station - centre) / size
    candidates = _best_first(_judged(_closed_forms(image, scaled, f_mm, near), image, scaled, f_mm))
    reversed_forms: list[Form] = [
        (*_relief_reversed(candidate, scaled), candidate.triple, candidate.method)
        for candidate in distinct(candidates, scaled, limit=MIRRORED)
    ]
    candidates += [replace(one, is_reversed=True) for one in _judged(reversed_forms, image, scaled, f_mm)]
    return [candidate.at(centre + size * candidate.station) for candidate in _best_first(candidates)]


def _closed_forms(image: FloatArray, ground: FloatArray, f_mm: float, near: FloatArray | None) -> list[Form]:
    """(R, S, triple, method) of every closed form that applies to ground of size one about its centroid."""
    rays = camera_rays(image, f_mm)
    triples = spread_triples(image, ground)
    at = np.array(triples, dtype=np.intp).reshape(-1, 3)
    found: list[Form] = [
        (R, S, triple, Method.THREE_POINTS)
        for triple, resections in zip(triples, resections_of_triples(rays[at], ground[at]), strict=True)
        for R, S in resections
    ]
    every = slice(None, None, -(-len(image) // MOST_POINTS))
    values = np.linalg.svd(np.linalg.qr(ground, mode="r"), compute_uv=False)
    if found and values[-1] > SOME_RELIEF * values[0]:
        linear = direct_linear_resection(image[every], ground[every], f_mm)
        found += [(R, S, (), Method.DIRECT_LINEAR) for R, S in linear]
    if found and values[-1] < NEARLY_FLAT * values[0]:
        flat = plane_resection(image[every], ground[every], f_mm)
        found += [(R, S, (), Method.PLANE) for R, S in flat]
    if near is not None:
        found.append((_rotation_from_directions(rays, ground - near), near, (), Method.STATION))
    return [form for form in found if np.linalg.norm(form[1]) < FARTHEST]


def _best_first(candidates: Sequence[Candidate]) -> list[Candidate]:
    return sorted(candidates, key=lambda candidate: (not candidate.all_in_front, candidate.rms_mm))


def camera_rays(image: FloatArray, f_mm: float) -> FloatArray:
    """Unit vectors (x, y, -f) / |.| (n, 3) from the projection centre to the points, in the camera."""
    rays = np.column_stack([image, np.full(len(image), -f_mm)])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def spread_triples(image: FloatArray, ground: FloatArray) -> list[tuple[int, ...]]:
    """Triples of points with the largest triangles, image times ground area; none that is nearly a line."""
    chosen = sorted(_far_apart(image, SPREAD_POINTS))
    triples = np.array(list(combinations(chosen, 3)))
    areas = _triangle_areas(np.column_stack([image, np.zeros(len(image))]), triples)
    relief = _triangle_areas(ground, triples)
    order = np.argsort(-areas * relief, kind="stable")[:LARGEST_TRIPLES]
    clear = (areas > SMALLEST_AREA * np.max(areas)) & (relief > SMALLEST_AREA * np.max(relief))
    return [tuple(int(i) for i in triples[t]) for t in order if clear[t]]


def distinct(
    candidates: Sequence[Candidate], ground: FloatArray, apart: float = 0.02, limit: int = 6
) -> list[Candidate]:
    """The first `limit` candidates that differ by more than `apart` in rotation [rad] or station [distance]."""
    places = [one.rotation for one in candidates], [one.station for one in candidates]
    firsts = first_alike(*places, ground, apart, limit)
    return [candidates[first] for first in dict.fromkeys(firsts) if first >= 0]


def first_alike(rotations: ArrayLike, stations: ArrayLike, ground: FloatArray, apart: float, limit: int) -> list[int]:
    """For each orientation the first of those kept that equals it within `apart`: rotation [rad], station [distance].

    Kept is what equals none before it; -1 for what equals none of the first `limit`.
    """
    R, S = np.array(rotations).reshape(-1, 9), np.array(stations).reshape(-1, 3)
    distance = np.linalg.norm(S - ground.mean(axis=0), axis=1)
    firsts = np.full(len(R), -1)
    for _ in range(limit):
        left = np.flatnonzero(firsts < 0)
        if not len(left):
            break
        turned = np.linalg.norm(R[left] - R[left[0]], axis=1) / np.sqrt(2)
        moved = np.linalg.norm(S[left] - S[left[0]], axis=1) / distance[left]
        firsts[left[(turned <= apart) & (moved <= apart)]] = left[0]
        firsts[left[0]] = left[0]
    return firsts.tolist()


def _far_apart(image: FloatArray, count: int) -> list[int]:
    """Farthest-point sampling, from the point farthest from the centroid."""
    gap = np.linalg.norm(image - image.mean(axis=0), axis=1)
    chosen = [int(np.argmax(gap))]
    gap = np.linalg.norm(image - image[chosen[0]], axis=1)
    while len(chosen) < min(count, len(image)):
        chosen.append(int(np.argmax(gap)))
        gap = np.minimum(gap, np.linalg.norm(image - image[chosen[-1]], axis=1))
    return chosen


def _triangle_areas(points: FloatArray, triples: NDArray[np.intp]) -> FloatArray:
    a, b, c = (points[triples[:, k]] for k in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def _relief_reversed(candidate: Candidate, ground: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The orientation that fits best when every point is as much nearer than the mean as it was farther."""
    camera = (ground - candidate.station) @ candidate.rotation
    camera[:, 2] = 2 * camera[:, 2].mean() - camera[:, 2]
    R = _rotation_between(camera - camera.mean(axis=0), ground - ground.mean(axis=0))
    return R, ground.mean(axis=0) - R @ camera.mean(axis=0)


def _rotation_from_directions(rays: FloatArray, directions: FloatArray) -> FloatArray:
    """R with R ray_i nearest to the directions (n, 3), which need not be unit vectors."""
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    return _rotation_between(rays, directions / np.where(lengths > 0, lengths, 1.0))


def _rotation_between(camera: FloatArray, ground: FloatArray) -> FloatArray:
    """R with sum |R p_i - P_i|^2 -> min for vectors p, P (n, 3), det R = +1."""
    U, _, Vt = np.linalg.svd(ground.T @ camera)
    return np.asarray(U @ np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))]) @ Vt)


def _judged(forms: Sequence[Form], image: FloatArray, ground: FloatArray, f_mm: float) -> list[Candidate]:
    """How each form fits all points; some at a time, so that many points need little memory."""
    judged: list[Candidate] = []
    together = max(1, MOST_JUDGED // len(image))
    for begin in range(0, len(forms), together):
        some = forms[begin : begin + together]
        R, S = (np.array([form[k] for form in some]) for k in (0, 1))
        camera = (ground - S[:, None, :]) @ R
        with np.errstate(all="ignore"):
            computed = -f_mm * camera[..., :2] / camera[..., 2:]
            rms = np.sqrt(np.mean(np.sum((computed - image) ** 2, axis=2), axis=1))
        in_front = np.count_nonzero(camera[..., 2] < 0, axis=1).tolist()
        misfits = np.where(np.isfinite(rms), rms, np.inf).tolist()
        judged += [
            Candidate(R, S, misfit, seen, seen == len(image), triple, method)
            for (R, S, triple, method), misfit, seen in zip(some, misfits, in_front, strict=True)
        ]
    return judged
