"""The plots: each is one module with `draw(tables) -> Figure`. This page imports no matplotlib."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Protocol, cast

from orient.errors import OrientError, UsageError
from orient.store.project import Project, open_project
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
    data = _read(path, plot)
    from orient.report.plots.canvas import encoded, require_matplotlib, style

    require_matplotlib()
    module = import_module(f"orient.report.plots.{name}")
    with style():
        return encoded(cast(Draw, module.draw)(data), format_name)


def _read(path: Path, plot: Plot) -> PlotData:
    with open_project(path, "read") as project, project.snapshot():
        heads = project.heads()
        missing = [stage for stage in plot.stages if stage not in heads]
        if missing:
            raise UsageError(f"the plot {plot.name} needs {', '.join(missing)}", f"Run: orient run {path}")
        stale = {str(row[0]) for row in project.query("SELECT stage FROM v_stale WHERE is_stale")[1]}
        if stale.intersection(plot.stages):
            listed = ", ".join(stage for stage in plot.stages if stage in stale)
            raise OrientError(
                f"the results are out of date ({listed}); a picture would mix versions", f"Run: orient run {path}"
            )
        return PlotData(_tables(project, plot), {stage: heads[stage].version for stage in plot.stages})


def _tables(project: Project, plot: Plot) -> dict[str, Tables]:
    heads = project.heads()
    return {stage: project.read_tables(heads[stage].run_id) for stage in plot.stages}
