"""What a reader must know of a resection before its numbers, in plain words."""

import re
from collections.abc import Sequence

import numpy as np

from orient.geometry.collinearity import project
from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array
from orient.solvers.critical_values import GlobalTest, global_test
from orient.solvers.functional_iteration import WEAK_RATIO
from orient.solvers.resection import Resection
from orient.solvers.start_values import Candidate, start_candidates
from orient.values import Event

STRONG_CORRELATION = 0.95
TOLD_CHANCE = 1e-3
ODD_RATIO, ODD_MM, MOST_ODD, MOST_PAIRS = 30.0, 0.5, 5, 2
SMALLEST_REDUNDANCY_NUMBER = 1e-6
SOLVER_NAME = re.compile(r"\b(r_[XYZ]|[XYZ]_S|[XYZ])\b")


def resection_findings(found: Resection, frame: Frame, points: Sequence[str], sigma0: float) -> list[Event]:
    """Events about fit, redundancy, ambiguity and correlation of a result, the grave ones first."""
    return [*_fit(found, points, sigma0), *_ambiguity(found), *_weak(found, frame), *_correlations(found, frame)]


def odd_points(image: Array, ground: Array, f_mm: float, points: Sequence[str]) -> list[Event]:
    """Where no orientation was found: points that miss the place where most others say they should be.

    Among the three-point starts the one with the smallest median residual is asked; ground is right-handed.
    """
    residuals = [_residuals(candidate, image, ground, f_mm) for candidate in start_candidates(image, ground, f_mm)]
    if not residuals:
        return []
    best = min(residuals, key=lambda values: float(np.median(values)))
    limit = max(ODD_RATIO * float(np.median(best)), ODD_MM)
    odd = [i for i in np.argsort(-best) if best[i] > limit]
    if not odd or len(odd) > len(points) // 2:
        return []
    return [_odd_event(points[i], float(best[i]), len(points) - len(odd)) for i in odd[:MOST_ODD]]


def _residuals(candidate: Candidate, image: Array, ground: Array, f_mm: float) -> Array:
    computed, zs = project(ground, candidate.station, candidate.rotation, f_mm)
    apart: Array = np.linalg.norm(computed - image, axis=1)
    return np.where(zs < 0, apart, np.inf)


def _odd_event(point: str, apart: float, others: int) -> Event:
    where = "lies behind the camera" if np.isinf(apart) else f"lies {apart:.3g} mm away"
    message = f"{point} {where} where {others} other points agree: check its coordinates and its reading"
    return Event("warning", "odd_point", point, message, None if np.isinf(apart) else apart)


def _fit(found: Resection, points: Sequence[str], sigma0: float) -> list[Event]:
    """Redundancy and global test of a resection."""
    if found.redundancy == 0:
        return [Event("warning", "no_redundancy", "", "no redundancy: the solution cannot be checked")]
    ratio = (found.vPv / found.redundancy) ** 0.5 / sigma0
    words = f"sigma0 is {ratio:.3g} times its value a priori", f"sigma0 is only {ratio:.3g} of its value a priori"
    causes = f"a gross error, a wrong camera or too small sigmas; {_worst(found, points)} fits worst"
    return global_test_events("", global_test(found.vPv, found.redundancy, sigma0), ratio, words, causes)


def global_test_events(
    subject: str, test: GlobalTest, ratio: float, words: tuple[str, str], causes: str
) -> list[Event]:
    """The verdict of the global test in words, by the same limits as the row of adjustment_test: 5 % on both sides.

    `words` say how sigma0 compares where it is too large, and where too small; `ratio` is that to sigma0 a priori.
    """
    if test.verdict == "too large":
        message = f"{words[0]}, the global test fails{_chance(test)}: {causes}"
        return [Event("warning", "global_test", subject, message, ratio)]
    if test.verdict == "too small":
        message = f"{words[1]}{_chance(test)}: the sigmas given are too large"
        return [Event("info", "small_sigma0", subject, message, ratio)]
    return []


def _chance(test: GlobalTest) -> str:
    """Told where a good adjustment may well be so far out once."""
    return f" (chance {100 * test.probability:.2g} %)" if test.probability > TOLD_CHANCE else ""


def fails_global_test(found: Resection, sigma0: float) -> bool:
    """Is v'Pv too large for sigma0 a priori?"""
    return found.redundancy > 0 and global_test(found.vPv, found.redundancy, sigma0).verdict == "too large"


def _worst(found: Resection, points: Sequence[str]) -> str:
    """The point whose residual is largest for what the others let it show."""
    share = np.maximum(found.redundancy_numbers, SMALLEST_REDUNDANCY_NUMBER)
    normalised = np.where(
        found.redundancy_numbers > SMALLEST_REDUNDANCY_NUMBER, found.residuals**2 / share, found.residuals**2
    )
    return points[int(np.argmax(normalised.max(axis=1)))]


def _ambiguity(found: Resection) -> list[Event]:
    if not found.is_ambiguous:
        return []
    others = sum(alternative.is_as_good for alternative in found.alternatives)
    fits = "orientation fits" if others == 1 else "orientations fit"
    message = f"{others} other {fits} as well; give an approximate station in photo.toml to choose"
    return [Event("warning", "ambiguous", "", message, float(others))]


def _weak(found: Resection, frame: Frame) -> list[Event]:
    """Nearly singular: the combination of unknowns that the control hardly determines."""
    if found.condition_ratio >= WEAK_RATIO:
        return []
    message = (
        f"weak geometry (singular values {found.condition_ratio:.1e} : 1), hardly determined: "
        f"{in_stored_names(found.undetermined, frame)}"
    )
    return [Event("warning", "weak_geometry", "", message, found.condition_ratio)]


def _correlations(found: Resection, frame: Frame) -> list[Event]:
    """One remark for all strongly correlated pairs of elements, led by the strongest."""
    strong = sorted((pair for pair in found.weak if abs(pair[2]) > STRONG_CORRELATION), key=lambda pair: -abs(pair[2]))
    if not strong:
        return []
    told = [f"{in_stored_names(f'{a} and {b}', frame)} {value:+.4f}" for a, b, value in strong[:MOST_PAIRS]]
    more = f" and {len(strong) - MOST_PAIRS} pairs more" if len(strong) > MOST_PAIRS else ""
    message = f"strong correlations: {', '.join(told)}{more}; judge ground points, not single sigmas"
    return [Event("info", "correlation", "", message, strong[0][2])]


def in_stored_names(text: str, frame: Frame, names: re.Pattern[str] = SOLVER_NAME) -> str:
    """The solver's unknowns (X east, Y north) in the words of the stored frame; `names` finds them in the text."""
    if frame.origin is None:
        words = {"r_X": "the rotation about X", "r_Y": "the rotation about Y", "r_Z": "the rotation about Z"}
    else:
        words = {"r_X": "the tilt about grid east", "r_Y": "the tilt about grid north", "r_Z": "the turn about up"}
    if frame.partner[0, 1]:
        words |= {f"{axis}{tail}": f"{other}{tail}" for axis, other in ("XY", "YX") for tail in ("", "_S", "_0")}
    return names.sub(lambda match: words.get(match.group(), match.group()), text)
