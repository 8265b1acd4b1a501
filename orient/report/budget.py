"""The error budget for people: which source of errors a ground sigma comes from, in words and in one small table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

from orient.values import Row, Tables

PHOTO = "photo"
HEADERS = ["source", "share %", "through photo %", "sigma m"]


@dataclass(frozen=True, slots=True)
class Share:
    """Medians over the points: share of a source in the variance of a plan position, in percent, and its sigma [m].

    `through_photo` is the part of the share that comes through what all points of the photo have in common.
    """

    source: str
    percent: float
    through_photo: float
    sigma_m: float


def median_shares(tables: Tables) -> list[Share]:
    """Of (sigma_X^2 + sigma_Y^2)/2, the largest first; none for a version without a budget."""
    by_point = plan_variances(tables.get("error_budget", ()))
    points = [parts for parts in by_point.values() if sum(parts.values()) > 0]
    sources = dict.fromkeys(source for parts in points for source, _ in parts)
    shares = [_share(source, points) for source in sources]
    return sorted(shares, key=lambda share: -share.percent)


def plan_variances(rows: Sequence[Row]) -> Mapping[str, dict[tuple[str, str], float]]:
    """(sigma_X^2 + sigma_Y^2)/2 [m^2] by point, then by source and part (photo or point)."""
    found: dict[str, dict[tuple[str, str], float]] = {}
    for row in rows:
        variance = (float(row["cov_XX_m2"] or 0.0) + float(row["cov_YY_m2"] or 0.0)) / 2
        found.setdefault(str(row["point"]), {})[str(row["source"]), str(row["part"])] = variance
    return found


def _share(source: str, points: Sequence[Mapping[tuple[str, str], float]]) -> Share:
    of_source = [sum(v for (name, _), v in parts.items() if name == source) for parts in points]
    of_photo = [parts.get((source, PHOTO), 0.0) for parts in points]
    totals = [sum(parts.values()) for parts in points]
    return Share(
        source,
        100 * median(part / total for part, total in zip(of_source, totals, strict=True)),
        100 * median(part / total for part, total in zip(of_photo, totals, strict=True)),
        median(max(part, 0.0) ** 0.5 for part in of_source),
    )


def budget_lines(tables: Tables) -> list[str]:
    """The largest source in words, and what would be left without it."""
    shares = median_shares(tables)
    if not shares:
        return []
    largest = shares[0]
    by_point = plan_variances(tables["error_budget"]).values()
    total = median(sum(parts.values()) ** 0.5 for parts in by_point)
    rest = median(sum(v for (name, _), v in parts.items() if name != largest.source) ** 0.5 for parts in by_point)
    many = f"median of {len(by_point)} points" if len(by_point) > 1 else "one point"
    if len(shares) == 1:
        return [f"All of the ground error ({total:.3g} m, {many}) comes from: {largest.source}."]
    return [
        f"Largest source of the ground error: {largest.source}, {largest.percent:.0f} % of the variance ({many}).",
        f"Ground sigma {total:.3g} m; without this source {rest:.3g} m would be left.",
    ]


def budget_tables(tables: Tables) -> list[tuple[str, list[str], list[list[str]]]]:
    """Title, headers, cells of the one table; none for a version without a budget."""
    shares = median_shares(tables)
    if not shares:
        return []
    cells = [[s.source, f"{s.percent:.1f}", f"{s.through_photo:.1f}", f"{s.sigma_m:.3g}"] for s in shares]
    return [("Where the ground error comes from, medians (each point: orient sql error-budget)", HEADERS, cells)]
