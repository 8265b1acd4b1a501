"""The plots: each is one module with `draw(data) -> Figure`. This page imports no matplotlib and no SQL."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from orient.errors import UsageError
from orient.report.current import fresh_heads
from orient.values import Tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from orient.store.project import Project, RunInfo


@dataclass(frozen=True, slots=True)
class Plot:
    """One plot: its name, what it shows, and the tables of the current results that it reads, by stage.

    `optional`: drawn too where it exists. `one_of`: the first of these stages that has a current version is needed.
    """

    name: str
    shows: str
    tables: Mapping[str, tuple[str, ...]]
    optional: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    one_of: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class PlotData:
    """Tables of the results by stage, and their versions; `part` is the sheet or zone that is drawn."""

    tables: Mapping[str, Tables]
    versions: Mapping[str, int]
    part: str = ""


class Draw(Protocol):
    def __call__(self, data: PlotData) -> "Figure": ...


PHOTO = {"photo": ("photo",)}
PLOTS = (
    Plot(
        "accuracy",
        "ground sigma over the frame, with contours",
        {**PHOTO, "resection": ("image_residual",), "covariance": ("ground_accuracy",)},
    ),
    Plot("budget", "which source each ground sigma comes from", {**PHOTO, "covariance": ("error_budget",)}),
    Plot(
        "ellipses",
        "error ellipses of the points on the ground",
        {**PHOTO, "topocentric": ("topocentric_frame",), "covariance": ("ground_covariance",)},
    ),
    Plot(
        "iterations",
        "how the adjustment converged",
        PHOTO,
        one_of={
            "resection": ("iteration", "iteration_parameter"),
            "absolute": ("absolute_iteration", "absolute_iteration_parameter"),
        },
    ),
    Plot(
        "residuals",
        "the frame with the residual vectors and the error ellipses",
        {**PHOTO, "resection": ("image_residual", "orientation")},
        optional={"covariance": ("ground_covariance_image",)},
    ),
    Plot(
        "sheet",
        "a map sheet with the residuals of its crosses",
        {**PHOTO, "sheet": ("graticule_cross",), "digitize": ("sheet_transform", "cross_residual", "digitized_point")},
    ),
)
BY_NAME = {plot.name: plot for plot in PLOTS}
ENDINGS = (".svg", ".png")


def plot_named(name: str) -> Plot:
    """The plot; a `UsageError` lists what there is."""
    if name not in BY_NAME:
        raise UsageError(f'there is no plot "{name}"', f"Plots are {', '.join(BY_NAME)}.")
    return BY_NAME[name]


def make_plot(path: Path, name: str, format_name: str, part: str = "") -> bytes:
    """The picture of the current results as the bytes of a file; the same project gives the same bytes."""
    data = _read(path, BY_NAME[name], part)
    from orient.report.plots.canvas import require_matplotlib

    require_matplotlib()
    return drawn(name, data, format_name)


def drawn(name: str, data: PlotData, format_name: str) -> bytes:
    """The picture of these tables."""
    from orient.report.plots.canvas import encoded, style

    module = import_module(f"orient.report.plots.{name}")
    with style():
        return encoded(cast(Draw, module.draw)(data), format_name)


def _read(path: Path, plot: Plot, part: str) -> PlotData:
    from orient.store.project import open_project

    with open_project(path, "read") as project, project.snapshot():
        there = project.heads()
        chosen = next((stage for stage in plot.one_of if stage in there), next(iter(plot.one_of), ""))
        wanted = {**plot.tables, **({chosen: plot.one_of[chosen]} if chosen else {})}
        what = f"the plot {plot.name}"
        heads = fresh_heads(project, tuple(wanted), what, "a picture would mix versions", tuple(plot.optional))
        extra = {stage: names for stage, names in plot.optional.items() if stage in heads}
        return plot_data(project, heads, {**wanted, **extra}, part)


def plot_data(
    project: "Project", runs: Mapping[str, "RunInfo"], wanted: Mapping[str, tuple[str, ...]], part: str = ""
) -> PlotData:
    """The wanted tables of these runs."""
    from orient.report.rows import read_rows

    tables = {
        stage: {name: read_rows(project, runs[stage].run_id, name) for name in names} for stage, names in wanted.items()
    }
    return PlotData(tables, {stage: runs[stage].version for stage in wanted}, part)
