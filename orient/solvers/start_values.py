"""Exterior orientations from nothing: exact three-point resections of well-spread triples, best first."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import project
from orient.solvers.p3p import three_point_resections

FloatArray = NDArray[np.float64]

SPREAD_POINTS = 6
LARGEST_TRIPLES = 20
SMALLEST_AREA = 1e-7
MIRRORED = 3


@dataclass(frozen=True, slots=True)
class Candidate:
    """A possible exterior orientation; `triple` are the three points it comes from, () for an approximate station."""

    rotation: FloatArray
    station: FloatArray
    rms_mm: float
    all_in_front: bool
    triple: tuple[int, ...]


def start_candidates(
    image: FloatArray, ground: FloatArray, f_mm: float, approximate_station: FloatArray | None = None
) -> list[Candidate]:
    """Every (R, S) that sees three of the points exactly, sorted: all points in front first, then by rms.

    `image` (n, 2) [mm], `ground` (n, 3) [m] right-handed, n >= 3, all coordinates known. At most 20 triples: the
    largest in image and ground among six points far apart in the image. Each triple gives up to four candidates; an
    approximate station adds the rotation that turns the rays best onto its directions. The best ones are also taken
    with their relief reversed along the camera axis: flat ground in a narrow field has two nearly equal solutions.
    No triple that is not nearly a line, in the image or on the ground: an empty list.
    Source: three_point_resections; rotation between directions by Kabsch (1976); reversal as in Oberkampf, DeMenthon
    and Davis (1996).
    """
    centre = ground.mean(axis=0)
    size = float(np.max(np.linalg.norm(ground - centre, axis=1)))
    scaled = (ground - centre) / size
    rays = camera_rays(image, f_mm)
    found = [
        (R, S, triple)
        for triple in spread_triples(image, scaled)
        for R, S in three_point_resections(rays[list(triple)], scaled[list(triple)])
    ]
    if approximate_station is not None:
        station = (approximate_station - centre) / size
        found.append((_rotation_from_directions(rays, scaled - station), station, ()))
    candidates = _best_first([_judged(R, S, triple, image, scaled, f_mm) for R, S, triple in found])
    for candidate in distinct(candidates, scaled, limit=MIRRORED):
        R, S = _relief_reversed(candidate, scaled)
        candidates.append(_judged(R, S, candidate.triple, image, scaled, f_mm))
    return [_at_size(candidate, centre, size) for candidate in _best_first(candidates)]


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
    kept: list[Candidate] = []
    centre = ground.mean(axis=0)
    for candidate in candidates:
        if len(kept) == limit:
            break
        if not any(is_same(candidate, other, centre, apart) for other in kept):
            kept.append(candidate)
    return kept


def is_same(one: Candidate, other: Candidate, centre: FloatArray, apart: float) -> bool:
    """Are two orientations equal within `apart`: rotation [rad], station [distance to the ground]?"""
    turned = np.linalg.norm(one.rotation - other.rotation) / np.sqrt(2)
    moved = np.linalg.norm(one.station - other.station) / np.linalg.norm(one.station - centre)
    return bool(turned <= apart and moved <= apart)


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


def _judged(
    R: FloatArray, S: FloatArray, triple: tuple[int, ...], image: FloatArray, ground: FloatArray, f_mm: float
) -> Candidate:
    with np.errstate(all="ignore"):
        computed, zs = project(ground, S, R, f_mm)
        rms = float(np.sqrt(np.mean(np.sum((computed - image) ** 2, axis=1))))
    return Candidate(R, S, rms if np.isfinite(rms) else np.inf, bool(np.all(zs < 0)), triple)


def _at_size(candidate: Candidate, centre: FloatArray, size: float) -> Candidate:
    station = centre + size * candidate.station
    return Candidate(candidate.rotation, station, candidate.rms_mm, candidate.all_in_front, candidate.triple)
