"""What the plots share: style, the photo frame, vectors, scale bars, and files that are the same at every run."""

import io
import logging
import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orient.errors import NotInstalled
from orient.geometry.frame_centre import frame_centre
from orient.report.language import tr, trn
from orient.report.plots import PlotData
from orient.report.text import CONTROL
from orient.values import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

INK, BLUE, RED, GREY = "#222222", "#0072b2", "#d55e00", "#888888"
COLOURS = {"control": BLUE, "check": RED}
"""Blue and vermilion are told apart by every eye."""
MARKERS = {"control": "^", "check": "o"}
SETTINGS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "text.parse_math": False,
    "svg.hashsalt": "orient",
    "path.simplify": False,
}
DPI = 150
MOST_NAMES = 40
"""Beyond so many points their names would cover each other."""
MOST_POINTS = 2000
"""Beyond so many points a picture would be black, and its file would be large."""
LONGEST_NAME = 24
NAME_WIDTH, NAME_HEIGHT = 0.06, 0.025
MARGIN, BAR_ROOM = 0.03, 0.09
"""Around and below what is drawn, as part of its extent."""
WHITE_BOX = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}


def require_matplotlib() -> None:
    """Say what to install instead of failing with a traceback."""
    if find_spec("matplotlib") is None:
        raise NotInstalled("plots need", ["matplotlib"], "plot")


@contextmanager
def style() -> Iterator[None]:
    """The settings of orient, whatever the user's matplotlibrc says; no word from matplotlib to the terminal."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    import matplotlib

    with matplotlib.rc_context(), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a letter that the font does not have
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(SETTINGS)
        yield


def encoded(figure: "Figure", format_name: str) -> bytes:
    """The bytes of the picture, without date and version."""
    stream = io.BytesIO()
    metadata = {"Date": None, "Creator": "orient"} if format_name == "svg" else {"Software": None}
    figure.savefig(stream, format=format_name, dpi=DPI, metadata=metadata)
    return stream.getvalue()


def new_figure(title: str, origin: str, width: float = 6.4, height: float = 6.0) -> tuple["Figure", "Axes"]:
    """A figure with one axes of equal scales; `origin` says in small letters where the picture comes from."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    figure = Figure(figsize=(width, height), layout=ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.08))
    axes = figure.add_subplot()
    axes.set_aspect("equal")
    axes.set_title(origin, fontsize=7, color=GREY)
    figure.suptitle(title, fontsize=10)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    return figure, axes


def panels(title: str, origin: str, count: int) -> tuple["Figure", Sequence["Axes"]]:
    """A figure with `count` axes one below the other that share x; heading as `new_figure`."""
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    figure = Figure(figsize=(6.4, 2.1 * count), layout=ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.04))
    drawn = [figure.add_subplot(count, 1, 1)]
    drawn += [figure.add_subplot(count, 1, i + 1, sharex=drawn[0]) for i in range(1, count)]
    drawn[0].set_title(origin, fontsize=7, color=GREY)
    figure.suptitle(title, fontsize=10)
    for axes in drawn:
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    return figure, drawn


def source(data: PlotData) -> str:
    """Photo and versions."""
    versions = ", ".join(
        tr("{stage} version {version}", stage=stage, version=version)
        for stage, version in data.versions.items()
        if stage != "photo"
    )
    return f"{shown_name(str(data.tables['photo']['photo'][0]['name']), 60)}: {versions}"


def shown_name(text: str, longest: int = LONGEST_NAME) -> str:
    """A name from the file as it may stand in a picture."""
    safe = CONTROL.sub(" ", text.replace("\n", " "))
    return safe if len(safe) <= longest else f"{safe[: longest - 1]}…"


def numbers(rows: Sequence[Row], *names: str) -> Array:
    """(n, k) of the named columns, NULL as NaN."""
    values = [[math.nan if row[name] is None else float(row[name] or 0.0) for name in names] for row in rows]
    return np.array(values, dtype=np.float64).reshape(len(rows), len(names))


def draw_frame(axes: "Axes", photo: Row, points: Array, below: float = MARGIN) -> None:
    """Edge of the frame and principal point; x right, y up [mm], with room for `points` (n, 2) and `below` it."""
    from matplotlib.patches import Rectangle

    width, height, x0, y0 = numbers([photo], "frame_width_mm", "frame_height_mm", "x0_mm", "y0_mm")[0]
    centre = np.array(frame_centre(photo)) - np.array([x0, y0])
    half = np.array([width, height]) / 2
    axes.add_patch(Rectangle(tuple(centre - half), width, height, fill=False, edgecolor=GREY, linewidth=1.0))
    axes.plot([0], [0], "+", color=INK, markersize=9, label=tr("principal point"), linestyle="none")
    corners = np.vstack([centre - half, centre + half, points])
    low, high = corners.min(axis=0), corners.max(axis=0)
    extent = float(np.max(high - low))
    axes.set_xlim(float(low[0]) - MARGIN * extent, float(high[0]) + MARGIN * extent)
    axes.set_ylim(float(low[1]) - below * extent, float(high[1]) + MARGIN * extent)
    axes.set_xlabel(tr("x, mm"))
    axes.set_ylabel(tr("y, mm"))


def draw_points(axes: "Axes", rows: Sequence[Row], places: Array, away_from: Array | None = None) -> None:
    """Control and check points, each with its own sign, and names where there is room for them.

    `away_from` (n, 2): a direction from each point on whose other side its name goes.
    """
    for role, colour in COLOURS.items():
        chosen = [i for i, row in enumerate(rows) if row["role"] == role]
        if chosen:
            label = _counted(role, len(chosen))
            axes.plot(
                *places[chosen].T, MARKERS[role], color=colour, markersize=3.5, linestyle="none", label=label, zorder=3
            )
    label_points(axes, [str(row["point"]) for row in rows], places, away_from)


def label_points(axes: "Axes", names: Sequence[str], places: Array, away_from: Array | None = None) -> None:
    """The names beside the places (n, 2), where there is room and if they are not too many."""
    if len(names) > MOST_NAMES:
        return
    for i in _with_room(places, np.ptp(axes.get_xlim())):
        left, below = (False, False) if away_from is None else away_from[i] > 0
        axes.annotate(
            shown_name(names[i]),
            (float(places[i, 0]), float(places[i, 1])),
            (-3 if left else 3, -3 if below else 3),
            textcoords="offset points",
            ha="right" if left else "left",
            va="top" if below else "bottom",
            fontsize=7,
            color=INK,
            zorder=4,
        )


def _counted(role: str, n: int) -> str:
    if role == "control":
        return trn("{n} control point", "{n} control points", n)
    return trn("{n} check point", "{n} check points", n)


def largest_first(rows: Sequence[Row], sizes: Array) -> list[Row]:
    """At most MOST_POINTS rows, those of the largest sizes (n,), in their own order."""
    if len(rows) <= MOST_POINTS:
        return list(rows)
    chosen = np.sort(np.argsort(-sizes, kind="stable")[:MOST_POINTS])
    return [rows[i] for i in chosen]


def title_of_part(title: str, shown: int, total: int) -> str:
    """The title, and how many of all points are drawn if not all are."""
    if shown == total:
        return title
    return title + "\n" + tr("the {shown} largest of {total}", shown=shown, total=total)


def _with_room(places: Array, extent: float) -> list[int]:
    """Points whose name would not cover that of a point before."""
    chosen: list[int] = []
    for i, place in enumerate(places):
        apart = np.abs(places[chosen] - place) / extent
        if not np.any((apart[:, 0] < NAME_WIDTH) & (apart[:, 1] < NAME_HEIGHT)):
            chosen.append(i)
    return chosen


def draw_legend(figure: "Figure") -> None:
    """Below the axes, where no point can lie."""
    figure.legend(loc="outside lower center", ncols=5, fontsize=8, frameon=False, handletextpad=0.4, columnspacing=1.2)


def draw_scale(axes: "Axes", length: float, text: str) -> None:
    """A bar of `length` in units of the axes, in the lower left corner above the points."""
    low_x, high_x = axes.get_xlim()
    low_y, high_y = axes.get_ylim()
    x, y = low_x + 0.03 * (high_x - low_x), low_y + 0.025 * (high_y - low_y)
    axes.plot([x, x + length], [y, y], color=INK, linewidth=2.5, solid_capstyle="butt", zorder=5)
    axes.annotate(
        text, (x + length, y), (5, 0), textcoords="offset points", va="center", fontsize=8, bbox=WHITE_BOX, zorder=5
    )


def magnification(size: float, room: float) -> tuple[float, float]:
    """Scale (units of the axes per unit of size) and a round size whose bar is at most `room` units long.

    `size` is the largest that is drawn; without any size the scale is 1.
    """
    if not size > 0:
        return 1.0, 0.0
    scale = _round_down(room / size)
    return scale, _round_down(room / scale)


def _round_down(value: float) -> float:
    """1, 2 or 5 times a power of ten, at most `value`."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= value * (1 + 1e-9))
