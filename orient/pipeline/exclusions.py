"""Points that are left out of an adjustment: by hand, by robust estimation, by data snooping; as rows and in words."""

from collections.abc import Mapping, Sequence

from orient.errors import OrientError
from orient.solvers.snooping import Decision
from orient.units import listed
from orient.values import Event, Row, Scalar, Settings, Severity

NAMED = 3
"""Suspects that one sentence names; the table holds all of them."""

SURPRISE = 0.05
EVENTS: Mapping[str, tuple[Severity, str, str]] = {
    "excluded": ("info", "excluded", "left out"),
    "taken back": ("info", "taken_back", "it takes part again"),
    "not separable": ("warning", "not_separable", "both are kept"),
    "not removable": ("warning", "suspect", "kept, because the rest would not be checked without it"),
}


def by_hand(settings: Settings, points: Sequence[str], what: str) -> list[int]:
    """Places of the points that `--exclude` names, separated by commas."""
    asked = excluded_names(settings)
    unknown = [name for name in asked if name not in points]
    if unknown:
        raise OrientError(
            f'--exclude names "{unknown[0]}", which is no {what} of this adjustment',
            "Give names that the residuals list, separated by commas; --exclude none takes all points again.",
        )
    return sorted({points.index(name) for name in asked})


def suspect_row(part: str, point: str, chance: float, limit: float, is_rejected: bool) -> Row:
    """A cross that the test of `digitize` names: all its coordinates together, sigma0 without the cross itself."""
    action = "excluded" if is_rejected else "proposed"
    reason = f"chance of such a residual without an error {chance:.2g}, below {limit:g}"
    return _row(part, point, "snooping", action, reason, test="chance", statistic=chance, critical=limit)


def excluded_names(settings: Settings) -> list[str]:
    """The names in the setting `exclude`."""
    return [name.strip() for name in str(settings["exclude"] or "").split(",") if name.strip()]


def hand_row(part: str, point: str, settings: Settings) -> Row:
    """An exclusion that the user asked for."""
    return _row(part, point, "hand", "excluded", str(settings["exclude_reason"] or ""))


def robust_row(part: str, point: str, statistic: float | None, critical: float) -> Row:
    """An exclusion by robust estimation, with the misfit of the point to the consensus of the others."""
    words = "contradicts the points that agree (least trimmed squares, then tested with their orientation)"
    return _row(part, point, "robust", "excluded", words, test="chance", statistic=statistic, critical=critical)


def snooping_row(
    part: str,
    points: Sequence[str],
    decision: Decision,
    *,
    test: str,
    is_rejected: bool,
    observations: Sequence[str],
) -> Row:
    """One step of the snooping; `is_rejected` False: it is only a proposal. `observations` of a point, by name."""
    observation = observations[decision.observation] if decision.observation >= 0 else None
    action = "proposed" if decision.action == "excluded" and not is_rejected else decision.action
    other = None if decision.twin is None else points[decision.twin]
    return _row(
        part,
        points[decision.point],
        "snooping",
        action,
        _in_words(decision, test, observation, other),
        observation=observation,
        round=decision.round,
        test="chance" if decision.action == "taken back" else test,
        statistic=decision.statistic,
        critical=decision.critical,
        other=other,
    )


def numbered(rows: Sequence[Row]) -> list[Row]:
    """The decisions in their order."""
    return [{"seq": seq, **row} for seq, row in enumerate(rows, 1)]


def snooping_events(rows: Sequence[Row], surprise: float) -> list[Event]:
    """What a reader must know of the decisions of the snooping; proposals stand in one sentence.

    `surprise`: chance that the largest statistic of all tests together is so large without any gross error. One that
    is no surprise among so many tests is a remark, not a warning.
    """
    proposed = [row for row in rows if row["action"] == "proposed"]
    others = [row for row in rows if row["decided_by"] == "snooping" and row["action"] != "proposed"]
    return [*_proposals(proposed, surprise), *(_event(row) for row in others)]


def _proposals(rows: Sequence[Row], surprise: float) -> list[Event]:
    if not rows:
        return []
    told = listed([f"{row['point']} ({row['reason']})" for row in rows], NAMED)
    be = "is" if len(rows) == 1 else "are"
    subject = ", ".join(str(row["point"]) for row in rows)
    message = f"{told} {be} suspected of a gross error and kept"
    if surprise < SURPRISE:
        return [Event("warning", "suspect", subject, message, _number(rows[0]))]
    message += f"; with so many tests a good photo shows one in {100 * surprise:.0f} % of the cases"
    return [Event("info", "suspect", subject, message, _number(rows[0]))]


def _event(row: Row) -> Event:
    severity, code, told = EVENTS[str(row["action"])]
    return Event(severity, code, str(row["point"]), f"{row['point']}: {row['reason']}; {told}", _number(row))


def _number(row: Row) -> float | None:
    value = row["statistic"]
    return None if value is None else float(value)


def _in_words(decision: Decision, test: str, observation: str | None, other: str | None) -> str:
    if decision.action == "taken back":
        return f"fits the orientation of the others after all (chance {decision.statistic:.2g})"
    limit = f"|{test}| {decision.statistic:.3g} of {observation} exceeds {decision.critical:.3g}"
    if other is None:
        return limit
    return f"{limit}, and it is not separable from {other} (|rho_w| {decision.rho:.2f}): one of the two is wrong"


def _row(part: str, point: str, decided_by: str, action: str, reason: str, **numbers: Scalar) -> Row:
    empty: dict[str, Scalar] = dict.fromkeys(("observation", "round", "test", "statistic", "critical", "other"))
    return {
        "part": part,
        "point": point,
        "decided_by": decided_by,
        "action": action,
        "reason": reason,
        **empty,
        **numbers,
    }
