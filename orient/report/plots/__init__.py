"""The plots: each is one module with `draw(tables) -> Figure`. This page imports no matplotlib."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from orient.report.current import read_current
from orient.values import Tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Plot:
    """One plot: its name, what it shows, and the stages whose current results it reads."""

    name: str
    shows: str
    stages: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class PlotData:
    """Tables of the current results by stage, and their versions."""

    tables: Mapping[str, Tables]
    versions: Mapping[str, int]


class Draw(Protocol):
    def __call__(self, data: PlotData) -> "Figure": ...


PLOTS = (
    Plot("accuracy", "ground sigma over the frame, with contours", ("photo", "resection", "covariance")),
    Plot("budget", "which source each ground sigma comes from", ("photo", "covariance")),
    Plot("ellipses", "error ellipses of the points on the ground", ("photo", "topocentric", "covariance")),
    Plot("residuals", "the frame with the residual vectors", ("photo", "resection")),
)
BY_NAME = {plot.name: plot for plot in PLOTS}
FORMATS = ("svg", "png")


def make_plot(path: Path, name: str, format_name: str) -> bytes:
    """The picture of the current results as the bytes of a file; the same project gives the same bytes."""
    plot = BY_NAME[name]
    current = read_current(path, plot.stages, f"the plot {name}", "a picture would mix versions")
    data = PlotData(current.tables, current.versions)
    from orient.report.plots.canvas import encoded, require_matplotlib, style

    require_matplotlib()
    module = import_module(f"orient.report.plots.{name}")
    with style():
        return encoded(cast(Draw, module.draw)(data), format_name)
