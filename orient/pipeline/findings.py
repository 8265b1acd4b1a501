"""What a reader must know of a resection before its numbers, in plain words."""

import re
from collections.abc import Sequence

import numpy as np
from scipy.special import chdtr, chdtrc

from orient.pipeline.frames import Frame
from orient.solvers.resection import Resection
from orient.values import Event

STRONG_CORRELATION = 0.95
GLOBAL_TEST_LEVEL = 0.001
SMALLEST_REDUNDANCY_NUMBER = 1e-6
SOLVER_NAME = re.compile(r"\b(r_[XYZ]|[XYZ]_S|[XYZ])\b")


def resection_findings(found: Resection, frame: Frame, points: Sequence[str], sigma0: float) -> list[Event]:
    """Events about rank, fit, redundancy, ambiguity and correlation, the grave ones first."""
    events = []
    if found.undetermined:
        message = f"not determined: {in_stored_names(found.undetermined, frame)}"
        events.append(Event("error", "singular", "", message, found.condition_ratio))
    if found.termination == "CONVERGED":
        events += _fit(found, points, sigma0)
        events += _ambiguity(found)
        events += _correlations(found, frame)
    return events


def _fit(found: Resection, points: Sequence[str], sigma0: float) -> list[Event]:
    """Global test: v'Pv / sigma0^2 against chi^2 with r degrees of freedom."""
    if found.redundancy == 0:
        return [Event("warning", "no_redundancy", "", "no redundancy: the solution cannot be checked")]
    statistic, ratio = found.vPv / sigma0**2, (found.vPv / found.redundancy) ** 0.5 / sigma0
    if chdtrc(found.redundancy, statistic) < GLOBAL_TEST_LEVEL:
        message = (
            f"sigma0 is {ratio:.3g} times its value a priori, the global test fails: a gross error, a wrong camera or "
            f"too small sigmas; {_worst(found, points)} fits worst"
        )
        return [Event("warning", "global_test", "", message, ratio)]
    if chdtr(found.redundancy, statistic) < GLOBAL_TEST_LEVEL:
        message = f"sigma0 is only {ratio:.3g} of its value a priori: the sigmas given are too large"
        return [Event("info", "global_test", "", message, ratio)]
    return []


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
    message = f"{others} other orientations fit as well; give an approximate station in photo.toml to choose"
    return [Event("warning", "ambiguous", "", message, float(others))]


def _correlations(found: Resection, frame: Frame) -> list[Event]:
    events = []
    for first, second, correlation in found.weak:
        if abs(correlation) > STRONG_CORRELATION:
            subject = in_stored_names(f"{first} and {second}", frame)
            message = f"{subject} are correlated by {correlation:+.4f}: judge ground points, not these sigmas"
            events.append(Event("info", "correlation", subject, message, correlation))
    return events


def in_stored_names(text: str, frame: Frame) -> str:
    """The solver's unknowns (X east, Y north) in the words of the stored frame."""
    if frame.origin is None:
        words = {"r_X": "the rotation about X", "r_Y": "the rotation about Y", "r_Z": "the rotation about Z"}
    else:
        words = {"r_X": "the tilt about grid east", "r_Y": "the tilt about grid north", "r_Z": "the turn about up"}
    if frame.partner[0, 1]:
        words |= {"X": "Y", "Y": "X", "X_S": "Y_S", "Y_S": "X_S"}
    return SOLVER_NAME.sub(lambda match: words.get(match.group(), match.group()), text)
