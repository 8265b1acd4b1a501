"""Draws docs/figures: `python docs/make_figures.py [FOLDER]`.

The diagrams of conventions.md are in diagrams.py; the two result figures come from the sample projects, computed
in a temporary folder and asked with SQL. `orient` must be installed (`make setup`).
"""

import json
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from diagrams import BLACK, BLUE, DIAGRAMS, GREEN, RED, frame_points
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.frames import frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.runner import create, run_stale
from orient.pipeline.tables import columns
from orient.report.plots import make_plot
from orient.store.project import Project, open_project

ROOT = Path(__file__).parents[1]
SETTINGS = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "svg.hashsalt": "orient",
    "axes.titlesize": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
PLOTS = {
    "accuracy": "apollo15-metric-0585",
    "budget": "simulated-space-krasovsky",
    "iterations": "apollo15-metric-0585",
    "residuals": "simulated-space-krasovsky",
}
"""Plots of the program itself, and the samples that they show."""
MICROMETRES = 1000.0
KM = 1000.0


def main(arguments: list[str]) -> int:
    folder = Path(arguments[0]) if arguments else Path(__file__).with_name("figures")
    folder.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update(SETTINGS)
    for name, draw in DIAGRAMS.items():
        save(draw(), folder / f"{name}.svg")
    for name, (sample, draw_result) in RESULTS.items():
        with tempfile.TemporaryDirectory() as scratch, open_project(computed(sample, Path(scratch))) as project:
            save(draw_result(project), folder / f"{name}.png")
    for plot, sample in PLOTS.items():
        with tempfile.TemporaryDirectory() as scratch:
            picture = make_plot(computed(sample, Path(scratch)), plot, "png")
        (folder / f"{plot}.png").write_bytes(picture)
    return 0


def save(figure: Figure, path: Path) -> None:
    """The same bytes at every run: no date, no random identifiers."""
    if path.suffix == ".svg":
        figure.savefig(path, metadata={"Date": None})
    else:
        figure.savefig(path, dpi=140, metadata={"Software": None}, pil_kwargs={"optimize": True})
    plt.close(figure)


def computed(sample: str, scratch: Path) -> Path:
    """A project of a sample folder with all its stages run."""
    path = scratch / "photo.sqlite"
    create(path, read_project(ROOT / "sample_projects" / sample, ReadOptions()), "figures")
    run_stale(path, {}, "figures", lambda stage: None, lambda result: None)
    return path


# ------------------------------------------------------------------------------------------ results


def apollo(project: Project) -> Figure:
    """The photo with its residuals, and the ground with its error ellipses."""
    figure, (photo, ground) = plt.subplots(1, 2, figsize=(8.0, 4.5))
    residuals = numbers(project, "SELECT x_mm, y_mm, vx_mm, vy_mm FROM v_residual WHERE is_current")
    sigma0 = numbers(project, "SELECT sigma0_mm FROM orientation")[0, 0] * MICROMETRES
    photo_frame(photo, 57.15)
    scale = vectors(photo, residuals[:, :2], residuals[:, 2:] * MICROMETRES, BLUE, 0.4)
    scale_bar(photo, (-54, -53.5), 20.0, scale, "residual 20 µm (400 times)")
    photo.set_title(f"Image: {len(residuals)} points, $\\sigma_0$ = {sigma0:.1f} µm")
    query = "SELECT Y_m, X_m, ellipse_a_m, ellipse_b_m, ellipse_azimuth_deg FROM v_ground_accuracy WHERE is_current"
    ellipses(ground, numbers(project, query))
    figure.suptitle("AS15-M-0585: the Hadley region of the Moon from 103 km", fontsize=11)
    figure.subplots_adjust(left=0.075, right=0.985, bottom=0.11, top=0.86, wspace=0.24)
    return figure


def simulated(project: Project) -> Figure:
    """The map sheet with its crosses, and on the ground what map, photo and truth say of each other."""
    figure, (sheet, ground) = plt.subplots(1, 2, figsize=(8.0, 4.5), width_ratios=(1.1, 1))
    map_sheet(sheet, project)
    scale = 0.3  # km per metre
    for role, colour in (("control", BLUE), ("check", RED)):
        query = f"SELECT Y_m, X_m, dY_m, dX_m FROM v_ground_accuracy WHERE is_current AND role = '{role}'"
        rows = numbers(project, query)
        vectors(ground, rows[:, :2] / KM, rows[:, 2:], colour, scale)
        ground.plot([], [], "o", ms=4, color=colour, label=f"{len(rows)} {role} points")
    ground.set_aspect("equal")
    ground.set_xlim(-150, 150)
    ground.set_ylim(-175, 125)
    scale_bar(ground, (-140, -167), 100.0, scale, "100 m (300 times)")
    ground.legend(loc="lower right", fontsize=8, frameon=False)
    ground.set_xlabel("Y, grid east, km")
    ground.set_ylabel("X, grid north, km", labelpad=0)
    off_map, off_truth = medians(project)
    ground.set_title(f"Photo minus map: median {off_map:.0f} m\n(photo minus truth: {off_truth:.0f} m)")
    figure.suptitle("From the map to the photo: the simulated Krasovsky project", fontsize=11)
    figure.subplots_adjust(left=0.075, right=0.985, bottom=0.11, top=0.86, wspace=0.22)
    return figure


def medians(project: Project) -> tuple[float, float]:
    """Median plan distance [m] of the rays from the map's points and from the true ones."""
    tables = {name: project.read_tables(run.run_id) for name, run in project.heads().items()}
    ground = ground_of(tables["photo"]["photo"][0])
    frame = frame_of(tables["topocentric"]["topocentric_frame"][0], ground)
    truth = json.loads((ROOT / "sample_projects" / RESULTS["simulated"][0] / "truth.json").read_text("utf-8"))["points"]
    rows = tables["covariance"]["ground_covariance"]
    B, L, H = np.array([[truth[row["point"]][key] for key in ("B_deg", "L_deg", "H_m")] for row in rows]).T
    true = frame.from_geographic(np.radians(B), np.radians(L), H)
    rays = columns(rows, "X_m", "Y_m", "Z_m")
    off_map = np.hypot(*columns(rows, "dX_m", "dY_m").T)
    return float(np.median(off_map)), float(np.median(np.linalg.norm((rays - true)[:, :2], axis=1)))


def numbers(project: Project, query: str) -> np.ndarray:
    return np.array(project.query(query)[1], dtype=np.float64)


def photo_frame(ax: Axes, half: float) -> None:
    frame_points(ax, half)
    ax.plot(0, 0, "+", color=BLACK, ms=9)
    ax.set_aspect("equal")
    ax.set_xlim(-half * 1.04, half * 1.04)
    ax.set_ylim(-half * 1.04, half * 1.04)
    ax.set_xlabel("x, mm")
    ax.set_ylabel("y, mm", labelpad=0)


def vectors(ax: Axes, places: np.ndarray, sizes: np.ndarray, colour: str, scale: float) -> float:
    """Points with their vectors; `scale` is in axis units per unit of size."""
    ax.quiver(
        *places.T, *(scale * sizes).T, angles="xy", scale_units="xy", scale=1, color=colour, width=0.004, zorder=3
    )
    ax.plot(*places.T, "o", ms=2, color=colour)
    return scale


def scale_bar(ax: Axes, place: tuple[float, float], size: float, scale: float, text: str) -> None:
    end = (place[0] + size * scale, place[1])
    ax.plot(*zip(place, end, strict=True), color=BLACK, lw=2.5, solid_capstyle="butt", zorder=4)
    bar = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    ax.annotate(text, end, (5, 0), textcoords="offset points", va="center", fontsize=8, bbox=bar, zorder=4)


def ellipses(ax: Axes, rows: np.ndarray) -> None:
    """Error ellipses at east, north [km]; the azimuth counts from north towards east."""
    magnified = 300.0
    widths, heights, angle = 2 * rows[:, 3] * magnified / KM, 2 * rows[:, 2] * magnified / KM, -rows[:, 4]
    ax.add_collection(
        EllipseCollection(
            widths,
            heights,
            angle,
            units="xy",
            offsets=rows[:, :2] / KM,
            offset_transform=ax.transData,
            facecolors="none",
            edgecolors=RED,
            linewidths=0.9,
        )
    )
    ax.set_aspect("equal")
    low, high = rows[:, :2].min(axis=0) / KM, rows[:, :2].max(axis=0) / KM
    margin = 0.06 * float(np.max(high - low))
    ax.set_xlim(low[0] - margin, high[0] + margin)
    ax.set_ylim(low[1] - 2.2 * margin, high[1] + margin)
    scale_bar(ax, (low[0], low[1] - 1.5 * margin), 20.0, magnified / KM, f"20 m of semi-axis ({magnified:.0f} times)")
    ax.set_xlabel("Y, east of the origin, km")
    ax.set_ylabel("X, north, km", labelpad=0)
    ax.set_title(f"Ground: error ellipses, median a = {np.median(rows[:, 2]):.1f} m")


def map_sheet(ax: Axes, project: Project) -> None:
    query = """SELECT g.L_deg, g.B_deg, r.v_E_m, r.v_N_m FROM v_cross_residual AS r
               JOIN graticule_cross AS g ON g.sheet = r.sheet AND g."cross" = r."cross" WHERE r.is_current"""
    crosses = numbers(project, query)
    points = numbers(project, "SELECT L_deg, B_deg FROM digitized_point")
    ((degree,),) = project.query("SELECT degree FROM sheet_transform")[1]
    stretch = 1 / np.cos(np.radians(crosses[:, 1]))
    scale = 0.005  # degrees of latitude per metre
    arrows = crosses[:, 2:] * np.column_stack([stretch, np.ones_like(stretch)])
    ax.plot(*crosses[:, :2].T, "+", color=BLACK, ms=7)
    ax.quiver(*crosses[:, :2].T, *(scale * arrows).T, angles="xy", scale_units="xy", scale=1, color=BLUE, width=0.004)
    ax.plot(*points.T, "o", ms=3, color=GREEN)
    ax.set_aspect(float(np.mean(stretch)))
    ax.set_xlim(17.6, 24.4)
    ax.set_ylim(39.2, 44.35)
    scale_bar(ax, (17.8, 39.5), 100.0, scale * float(np.mean(stretch)), "residual 100 m")
    ax.plot([], [], "+", color=BLACK, label=f"{len(crosses)} crosses")
    ax.plot([], [], "o", ms=3, color=GREEN, label=f"{len(points)} map points")
    ax.legend(loc="lower right", fontsize=8, frameon=False, handletextpad=0.3, borderaxespad=0.0)
    ax.set_xlabel("L, degrees east")
    ax.set_ylabel("B, degrees north", labelpad=2)
    ax.set_title(f"Map 1:1 000 000, polynomial of degree {degree}")


RESULTS = {
    "apollo15": ("apollo15-metric-0585", apollo),
    "simulated": ("simulated-space-krasovsky", simulated),
}

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
