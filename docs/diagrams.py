"""The diagrams of conventions.md: axes, angles, corrections. No number in them comes from a computation."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Ellipse, Rectangle

# Okabe and Ito, which the colour-blind can tell apart
BLUE, RED, GREEN, GREY, BLACK = "#0072B2", "#D55E00", "#009E73", "#777777", "#111111"


# ------------------------------------------------------------------------------------------ strokes


def panels(widths: tuple[float, ...], height: float, title: tuple[str, ...]) -> tuple[Figure, list[Axes]]:
    """Blank panels of equal scale side by side."""
    figure, axes = plt.subplots(1, len(widths), figsize=(8.0, height), width_ratios=widths, squeeze=False)
    for ax, text in zip(axes[0], title, strict=True):
        ax.set_aspect("equal")
        ax.axis("off")
        ax.set_title(text)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.02, top=0.9, wspace=0.05)
    return figure, list(axes[0])


def arrow(
    ax: Axes, start: tuple[float, float], end: tuple[float, float], colour: str = BLACK, width: float = 1.6
) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": width, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 12}
    ax.annotate("", xy=end, xytext=start, arrowprops=style)


def both_ways(ax: Axes, start: tuple[float, float], end: tuple[float, float], colour: str) -> None:
    style = {"arrowstyle": "<->", "color": colour, "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=end, xytext=start, arrowprops=style)


def label(ax: Axes, x: float, y: float, text: str, colour: str = BLACK, **options: object) -> None:
    ax.text(x, y, text, color=colour, **{"ha": "center", "va": "center", **options})  # type: ignore[arg-type]


def axis(ax: Axes, azimuth: float, length: float, text: str, colour: str, style: str = "-") -> None:
    """An axis from the origin; azimuth in degrees, clockwise from up."""
    x, y = np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))
    arrow(ax, (0.0, 0.0), (length * x, length * y), colour)
    label(ax, (length + 0.28) * x, (length + 0.14) * y, text, colour)


def frame_points(ax: Axes, half: float) -> None:
    ax.add_patch(Rectangle((-half, -half), 2 * half, 2 * half, fill=False, edgecolor=GREY, lw=1.0))


# ------------------------------------------------------------------------------------------ diagrams


def ground_axes() -> Figure:
    titles = (
        "T: north, east, up (left-handed)",
        "T': T turned by gamma about up",
        "east, north, up: what the solvers see",
    )
    figure, (first, second, third) = panels((1, 1, 1), 3.0, titles)
    for ax in (first, second, third):
        ax.set_xlim(-0.8, 1.75)
        ax.set_ylim(-0.95, 1.45)
        ax.plot(0, 0, "o", ms=9, mfc="white", mec=BLACK)
        ax.plot(0, 0, ".", ms=4, color=BLACK)
        label(ax, -0.75, -0.14, "$Z$ up,\ntowards you", ha="left", va="top")
    axis(first, 0, 1.1, "$X_T$ north", BLUE)
    axis(first, 90, 1.0, "$Y_T$\neast", RED)
    axis(second, 0, 1.1, "$X_T$", GREY)
    axis(second, 90, 1.0, "$Y_T$", GREY)
    arrow(second, (0, 0), (0.376, 1.03), BLUE)
    arrow(second, (0, 0), (0.94, -0.342), RED)
    label(second, 0.42, 1.12, "$X$ grid north", BLUE, ha="left")
    label(second, 1.0, -0.5, "$Y$ grid east", RED)
    second.add_patch(Arc((0, 0), 1.5, 1.5, theta1=70, theta2=90, color=BLACK))
    label(second, 0.15, 0.85, "$\\gamma$")
    axis(third, 0, 1.1, "second axis: grid north", BLUE)
    axis(third, 90, 1.0, "", RED)
    label(third, 0.75, 0.22, "first axis: grid east", RED)
    label(first, 0.5, -0.78, "north, east, up turn like a left hand", GREY)
    label(second, 0.5, -0.78, "$\\gamma > 0$: grid north lies east of north", GREY)
    label(third, 0.5, -0.78, "right-handed: $X$ and $Y$ changed places", GREY)
    return figure


def camera() -> Figure:
    figure, (first, second) = panels((1, 1.35), 3.6, ("image (positive), looking down", "camera and ground"))
    first.set_xlim(-1.5, 1.75)
    first.set_ylim(-1.5, 1.5)
    frame_points(first, 1.05)
    arrow(first, (0, 0), (1.35, 0), RED)
    arrow(first, (0, 0), (0, 1.35), BLUE)
    label(first, 1.52, 0, "$x$", RED)
    label(first, 0.16, 1.3, "$y$", BLUE)
    first.plot(0.62, 0.45, "o", color=BLACK, ms=4)
    label(first, 0.62, 0.6, "point")
    label(first, 0.0, -0.2, "principal point\n$x = y = 0$, mm", GREY, va="top")
    _side_view(second)
    return figure


def _side_view(ax: Axes) -> None:
    ax.set_xlim(-2.1, 2.2)
    ax.set_ylim(-1.75, 1.45)
    ax.plot(0, 0.5, "o", color=BLACK, ms=5)
    label(ax, -0.13, 0.5, "$S$", ha="right")
    arrow(ax, (0, 0.5), (0, 1.25), BLUE)
    label(ax, 0.12, 1.15, "camera $Z$, away from the ground", BLUE, ha="left")
    ax.plot([-0.8, 0.8], [0.0, 0.0], color=BLACK, lw=2)
    label(ax, -0.85, 0.0, "image, $z = -f$", ha="right")
    both_ways(ax, (-0.35, 0.0), (-0.35, 0.5), GREY)
    label(ax, -0.47, 0.26, "$f$", GREY)
    ground = np.linspace(-2, 2, 80)
    ax.plot(ground, -1.45 + 0.06 * np.sin(4 * ground), color=GREEN, lw=2)
    foot = (1.1, -1.45 + 0.06 * np.sin(4.4))
    ax.plot([0, foot[0]], [0.5, foot[1]], color=RED, lw=1.2)
    ax.plot(*foot, "o", color=RED, ms=5)
    label(ax, foot[0] + 0.1, foot[1] + 0.2, "$P$", RED, ha="left")
    ax.plot(1.1 * 0.5 / (0.5 - foot[1]), 0.0, "o", color=RED, ms=4)
    both_ways(ax, (1.75, foot[1]), (1.75, 0.5), GREY)
    ax.plot([0.05, 1.85], [0.5, 0.5], color=GREY, lw=0.8, ls=":")
    label(ax, 1.68, -0.55, "$-z_s$, in front\nif $z_s < 0$", GREY, ha="right")


def angles() -> Figure:
    names = ("alpha, about Y", "omega, about X", "phi, about Y", "kappa, about Z")
    turns = (("X", "Z"), ("Y", "Z"), ("Z", "X"), ("X", "Y"))
    notes = ("aok: first\nlooks towards $+X$", "aok: second, opk: first\nlooks towards $+Y$",
             "opk: second\nlooks towards $-X$", "both: third, camera turns\nanticlockwise from above")  # fmt: skip
    figure, axes = panels((1, 1, 1, 1), 2.7, names)
    for ax, (start, end), note in zip(axes, turns, notes, strict=True):
        ax.set_xlim(-0.55, 1.65)
        ax.set_ylim(-0.85, 1.55)
        arrow(ax, (0, 0), (1.2, 0), GREY, 1.2)
        arrow(ax, (0, 0), (0, 1.2), GREY, 1.2)
        label(ax, 1.38, 0, f"${start}$")
        label(ax, 0, 1.4, f"${end}$")
        turn = np.radians(25)
        arrow(ax, (0, 0), (1.15 * np.cos(turn), 1.15 * np.sin(turn)), RED)
        arrow(ax, (0, 0), (-1.15 * np.sin(turn), 1.15 * np.cos(turn)), RED)
        ax.add_patch(Arc((0, 0), 1.4, 1.4, theta1=0, theta2=25, color=BLACK))
        label(ax, 0.85, 0.17, "+")
        label(ax, 0.5, -0.45, note, GREY)
    return figure


def image_corrections() -> Figure:
    titles = ("lens distortion: what d leads to", "refraction: towards the principal point")
    figure, (first, second) = panels((1.25, 1), 3.5, titles)
    first.set_xlim(-0.3, 6.6)
    first.set_ylim(-4.4, 1.1)
    rows = (
        ("correction", "corrected = measured + d(measured)", 0),
        ("displacement", "corrected = measured - d(measured)", 1),
        ("ideal_to_distorted", "measured = ideal + d(ideal)", 2),
    )
    for name, formula, row in rows:
        _direction(first, name, formula, -1.8 * row)
    _refraction(second)
    return figure


def _direction(ax: Axes, name: str, formula: str, y: float) -> None:
    ax.plot([0, 5.2], [y, y], color=GREY, lw=0.8)
    ax.plot(0, y, "+", color=BLACK, ms=8)
    measured, other = (3.2, 4.4) if name == "correction" else (4.4, 3.2)
    ax.plot(measured, y, "s", color=BLACK, ms=5)
    ax.plot(other, y, "o", color=GREEN, ms=6)
    arrow(ax, (3.2, y + 0.2), (4.4, y + 0.2), RED)
    label(ax, 3.8, y + 0.44, "d > 0", RED)
    label(ax, measured, y - 0.3, "measured")
    label(ax, other, y - 0.3, "ideal" if name == "ideal_to_distorted" else "corrected", GREEN)
    label(ax, 0.0, y + 0.85, f"{name}:  {formula}", ha="left")


def _refraction(ax: Axes) -> None:
    ax.set_xlim(-1.75, 1.75)
    ax.set_ylim(-1.45, 1.35)
    frame_points(ax, 1.2)
    ax.plot(0, 0, "+", color=BLACK, ms=10)
    for x in (-1.0, 0.0, 1.0):
        for y in (-1.0, 0.0, 1.0):
            shrink = 1 - 0.13 * (1 + 0.6 * (x * x + y * y))
            if x or y:
                ax.plot(x, y, "s", color=BLACK, ms=4)
                arrow(ax, (x, y), (x * shrink, y * shrink), RED, 1.4)
    label(ax, 0.0, -1.34, "correction $= -K\\,x\\,(1 + r^2/f^2)$", RED)


def ground_parts() -> Figure:
    titles = ("orientation: K = C Q C'", "reading: J Q J'", "height: h h' sigma²")
    figure, axes = panels((1, 1, 1), 2.8, titles)
    for ax, draw in zip(axes, (_orientation_part, _reading_part, _height_part), strict=True):
        ax.set_xlim(-1.15, 1.75)
        ax.set_ylim(-1.6, 0.85)
        ax.plot([-1.1, 1.7], [-1.0, -1.0], color=GREEN, lw=2)
        ax.plot(0, 0.6, "o", color=BLACK, ms=5)
        ax.plot([-0.4, 0.4], [0.25, 0.25], color=BLACK, lw=2)
        ax.plot([0, 0.9], [0.6, -1.0], color=BLACK, lw=1.2)
        draw(ax)
    return figure


def _orientation_part(ax: Axes) -> None:
    ax.add_patch(Ellipse((0, 0.6), 0.55, 0.3, fill=False, edgecolor=RED, lw=1.4))
    for shift in (-0.28, 0.28):
        ax.plot([shift, 0.9 + 0.6 * shift], [0.6, -1.0], color=RED, lw=0.9, ls="--")
    both_ways(ax, (0.73, -1.12), (1.07, -1.12), RED)
    label(ax, 0.3, -1.5, "station and rotation, full 6 x 6", RED)


def _reading_part(ax: Axes) -> None:
    both_ways(ax, (0.08, 0.15), (0.32, 0.15), RED)
    for foot in (0.62, 1.18):
        ax.plot([0, foot], [0.6, -1.0], color=RED, lw=0.9, ls="--")
    both_ways(ax, (0.62, -1.12), (1.18, -1.12), RED)
    label(ax, 0.3, -1.5, "one reading of the point", RED)


def _height_part(ax: Axes) -> None:
    for level in (-0.72, -1.28):
        ax.plot([-1.1, 1.7], [level, level], color=RED, lw=0.9, ls="--")
    ax.plot([0.9, 1.0575], [-1.0, -1.28], color=BLACK, lw=1.2)
    both_ways(ax, (-0.8, -1.28), (-0.8, -0.72), RED)
    both_ways(ax, (0.7425, -0.6), (1.0575, -0.6), RED)
    label(ax, 0.2, -1.5, "given height of the point", RED)


def sheet_axes() -> Figure:
    figure, (first, second) = panels((1.2, 1), 3.1, ("a sheet on the digitiser", "a scanned photo: pixels"))
    first.set_xlim(-0.7, 7.4)
    first.set_ylim(-1.1, 4.7)
    arrow(first, (-0.4, -0.6), (6.2, -0.6), BLACK)
    arrow(first, (-0.4, -0.6), (-0.4, 4.2), BLACK)
    label(first, 5.2, -0.92, "$X$, mm, right")
    label(first, -0.25, 4.4, "$Y$, mm, up", ha="left")
    across, along = np.meshgrid(np.linspace(0.6, 5.0, 6), np.linspace(0.3, 3.1, 4))
    first.plot(across + 0.08 * along, along + 0.03 * across, "+", color=BLUE, ms=9)
    corner, centre, half = (0.624, 0.318), (2.936, 1.784), (2.312, 1.466)
    first.add_patch(Rectangle(corner, 2 * half[0], 2 * half[1], fill=False, edgecolor=GREY, ls="--"))
    first.plot(*centre, "o", color=RED, ms=5)
    label(first, centre[0] - 0.12, centre[1] + 0.02, "$X_0, Y_0$", RED, ha="right")
    both_ways(first, centre, (centre[0] + half[0], centre[1]), RED)
    label(first, 5.4, centre[1], "scale: half\nthe longer side", RED, ha="left")
    label(first, 2.9, 3.85, "$u = (X - X_0)$ / scale,   $v = (Y - Y_0)$ / scale", GREY)
    _pixel_axes(second)
    return figure


def _pixel_axes(ax: Axes) -> None:
    ax.set_xlim(-1.2, 3.9)
    ax.set_ylim(-0.75, 3.6)
    ax.add_patch(Rectangle((0, 0), 3, 3, fill=False, edgecolor=GREY))
    ax.add_patch(Rectangle((0, 2.7), 0.3, 0.3, facecolor="#DDDDDD", edgecolor=GREY))
    ax.plot(0.15, 2.85, ".", color=BLACK)
    arrow(ax, (0.15, 2.85), (1.4, 2.85), BLACK)
    arrow(ax, (0.15, 2.85), (0.15, 1.6), BLACK)
    label(ax, 1.5, 2.66, "column", ha="left")
    label(ax, 0.3, 1.7, "row", ha="left")
    label(ax, 0.1, 3.25, "centre of the first pixel: 0, 0", ha="left")
    arrow(ax, (1.5, 1.5), (2.7, 1.5), RED)
    arrow(ax, (1.5, 1.5), (1.5, 2.5), BLUE)
    label(ax, 2.82, 1.5, "$x$", RED)
    label(ax, 1.66, 2.42, "$y$", BLUE)
    label(ax, 1.5, 1.15, "origin_col, origin_row", GREY, va="top")
    label(ax, 1.5, -0.38, "x_axis = right, y_axis = up", GREY)


DIAGRAMS = {
    "ground-axes": ground_axes,
    "camera": camera,
    "angles": angles,
    "image-corrections": image_corrections,
    "ground-parts": ground_parts,
    "sheet-axes": sheet_axes,
}
