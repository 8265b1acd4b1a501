"""Points that are left out of an adjustment: by hand, by robust estimation, by data snooping; as rows and in words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from orient.errors import OrientError
from orient.solvers.critical_values import ALPHA0
from orient.solvers.snooping import Decision
from orient.units import listed
from orient.values import Event, Row, Scalar, Settings, Severity

NAMED, NAMED_BY_ROBUST = 3, 10
"""Points that one sentence names; the table holds all of them."""

SURPRISE = 0.05
EVENTS: Mapping[str, tuple[Severity, str, str]] = {
    "excluded": ("info", "excluded", "left out"),
    "taken back": ("info", "taken_back", "it takes part again"),
    "not separable": ("warning", "not_separable", "both are kept"),
    "not removable": ("warning", "suspect", "kept, because the rest would not be checked without it"),
}


@dataclass(frozen=True, slots=True)
class Decided:
    """Places of the points left out by hand and by robust estimation, and the steps of the snooping."""

    by_hand: Sequence[int]
    by_robust: Sequence[int]
    decisions: Sequence[Decision]


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


def by_hand_in_parts(settings: Settings, points: Mapping[str, Sequence[str]], what: str) -> dict[str, list[int]]:
    """The same for points in named parts (sheets, zones): POINT is meant in every part, PART/POINT in one."""
    places: dict[str, list[int]] = {part: [] for part in points}
    for name in excluded_names(settings):
        title, slash, own = name.rpartition("/")
        asked = [(part, name) for part in points] + ([(title, own)] if slash and title in points else [])
        found = [(part, points[part].index(point)) for part, point in asked if point in points[part]]
        if not found:
            raise OrientError(
                f'--exclude names "{name}", which is no {what} of this adjustment',
                "Give names that the residuals list, separated by commas; --exclude none takes all points again.",
            )
        for part, place in found:
            places[part].append(place)
    return {part: sorted(set(own)) for part, own in places.items()}


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


def decision_rows(
    part: str, points: Sequence[str], decided: Decided, settings: Settings, test: str, observations: Sequence[str]
) -> list[Row]:
    """All decisions about the points of one adjustment, in their order."""
    rejects = bool(settings["reject"])
    return [
        *(hand_row(part, points[i], settings) for i in decided.by_hand),
        *(robust_row(part, points[i], None, ALPHA0) for i in decided.by_robust),
        *(
            snooping_row(part, points, decision, test=test, is_rejected=rejects, observations=observations)
            for decision in decided.decisions
        ),
    ]


def robust_events(part: str, wrong: Sequence[str], n: int, what: str) -> list[Event]:
    """Which points robust estimation left out; nothing if none. `part`: sheet or zone, in words."""
    if not wrong:
        return []
    message = (
        f"{part}robust estimation left out {len(wrong)} of {n} {what}: {listed(wrong, NAMED_BY_ROBUST)}; "
        f"the result is a plain adjustment of the others"
    )
    return [Event("warning", "robust", ", ".join(wrong[:NAMED_BY_ROBUST]), message, float(len(wrong)))]


def suspicion(exclusions: Sequence[Row]) -> str:
    """What the snooping proposes, as the remedy of an adjustment that does not fit."""
    named = [_named(row) for row in exclusions if row["action"] == "proposed"][:NAMED_BY_ROBUST]
    if not named:
        return ""
    be, them = ("is", "it") if len(named) == 1 else ("are", "them")
    return f"{', '.join(named)} {be} suspected of a gross error: leave {them} out with --reject, or try --robust"


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


def masking_events(part: str, test: Row, exclusions: Sequence[Row]) -> list[Event]:
    """A remark where the whole does not fit, but no single observation (any more) contradicts the others.

    tau divides by the sigma0 that the errors themselves have made: several can hide one another.
    """
    suspects = [row for row in exclusions if row["action"] in ("proposed", "not separable", "not removable")]
    if test["verdict"] != "too large" or suspects:
        return []
    message = (
        f"{part}the global test fails, but no single observation stands out: several errors may hide one another, or "
        "the sigmas are too small"
    )
    return [Event("info", "masked", str(test["part"]), message)]


def _proposals(rows: Sequence[Row], surprise: float) -> list[Event]:
    if not rows:
        return []
    told = listed([f"{_named(row)} ({row['reason']})" for row in rows], NAMED)
    be = "is" if len(rows) == 1 else "are"
    subject = ", ".join(_named(row) for row in rows)
    message = f"{told} {be} suspected of a gross error and kept"
    if surprise < SURPRISE:
        return [Event("warning", "suspect", subject, message, _number(rows[0]))]
    message += f"; with so many tests a good photo shows one in {100 * surprise:.0f} % of the cases"
    return [Event("info", "suspect", subject, message, _number(rows[0]))]


def _event(row: Row) -> Event:
    severity, code, told = EVENTS[str(row["action"])]
    return Event(severity, code, _named(row), f"{_named(row)}: {row['reason']}; {told}", _number(row))


def _named(row: Row) -> str:
    """POINT, or PART/POINT as --exclude takes it."""
    return f"{row['part']}/{row['point']}" if row["part"] else str(row["point"])


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
