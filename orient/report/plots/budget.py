"""The error budget: one bar for each point, its variance divided among the sources, and its sigma beside it."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from orient.report.budget import Share, median_shares, plan_variances
from orient.report.language import mark, tr
from orient.report.plots import PlotData
from orient.report.plots.canvas import GREY, INK, WHITE_BOX, new_figure, shown_name, source

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_BARS = 40
COLOURS = {
    mark("image readings"): "#0072b2",
    mark("interior orientation"): "#56b4e9",
    mark("digitiser"): "#e69f00",
    mark("map graticule"): "#009e73",
    mark("heights"): "#cc79a7",
    mark("survey"): "#d55e00",
    mark("camera"): "#f0e442",
}
"""The same in every picture; told apart by every eye."""
ROW_INCHES, FIXED_INCHES = 0.17, 1.7
NARROWEST_LABEL = 7.0
"""Percent of a bar in which its number still has room."""


def draw(data: PlotData) -> "Figure":
    """The figure: points with the largest sigma on top, shares of (sigma_X^2 + sigma_Y^2)/2 from left to right."""
    tables = data.tables["covariance"]
    shares = median_shares(tables)
    by_point = plan_variances(tables["error_budget"])
    ranked = sorted(by_point, key=lambda point: -sum(by_point[point].values()))
    chosen = ranked[:MOST_BARS]
    height = FIXED_INCHES + ROW_INCHES * (len(chosen) + 2)
    figure, axes = new_figure(_title(shares, len(chosen), len(ranked)), source(data), height=height)
    axes.set_aspect("auto")
    _draw_bars(axes, shares, [by_point[point] for point in chosen])
    _draw_median(axes, shares)
    names = [tr("median"), *(shown_name(point) for point in chosen)]
    axes.set_yticks([-1.5, *range(len(chosen))], names, fontsize=7)
    axes.set_ylim(len(chosen) - 0.4, -2.2)
    axes.set_xlim(0.0, 100.0)
    axes.set_xlabel(tr("share of the variance, %; at the right sqrt((sX² + sY²)/2)"))
    axes.tick_params(axis="y", length=0)
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False, columnspacing=1.2)
    return figure


def _title(shares: Sequence[Share], shown: int, all_points: int) -> str:
    if not shares:
        return tr("No error budget")
    if shown == all_points:
        return tr("Where the ground error comes from")
    return tr(
        "Where the ground error comes from, the {shown} least sure of {total} points", shown=shown, total=all_points
    )


def _draw_bars(axes: "Axes", shares: Sequence[Share], points: Sequence[Mapping[tuple[str, str], float]]) -> None:
    totals = [sum(parts.values()) for parts in points]
    left = [0.0] * len(points)
    for share, colour in zip(shares, _colours(shares), strict=True):
        of_source = [sum(v for (name, _), v in parts.items() if name == share.source) for parts in points]
        widths = [100 * part / total if total > 0 else 0.0 for part, total in zip(of_source, totals, strict=True)]
        axes.barh(range(len(points)), widths, left=left, height=0.8, color=colour, label=tr(share.source))
        left = [begin + width for begin, width in zip(left, widths, strict=True)]
    for i, total in enumerate(totals):
        axes.annotate(
            f"{total**0.5:.3g} m", (100.0, i), (4, 0), textcoords="offset points", va="center", fontsize=7, color=INK
        )


def _draw_median(axes: "Axes", shares: Sequence[Share]) -> None:
    """Medians need not sum to 100: they are drawn as if they did, with their numbers."""
    whole = sum(share.percent for share in shares) or 1.0
    left = 0.0
    for share, colour in zip(shares, _colours(shares), strict=True):
        width = 100 * share.percent / whole
        axes.barh([-1.5], [width], left=left, height=0.9, color=colour, edgecolor=GREY, linewidth=0.5)
        if width > NARROWEST_LABEL:
            place = (left + width / 2, -1.5)
            axes.annotate(f"{share.percent:.0f} %", place, ha="center", va="center", fontsize=7, bbox=WHITE_BOX)
        left += width


def _colours(shares: Sequence[Share]) -> list[str]:
    return [COLOURS.get(share.source, GREY) for share in shares]
