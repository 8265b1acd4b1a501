"""docs/performance.md and its figure, from what was measured."""

import re
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from benchmarks.measuring import OWN, Timed, exponent
from orient.store.ledger import tool_version

HEAD = """# Performance

Made by `make bench`; do not edit. All candidates of a row run interleaved in shuffled rounds on the same inputs, one
BLAS thread: **the ratios are the result, the times are only this machine's**. Rows that compute are in processor time;
rows that start processes or sync files (commands, rows, files) in time on the wall. Median ratio, quartiles in
brackets; below 1 orient is faster. *apart*: largest difference of the results, each number relative to the largest of
its kind; resections are compared in R, S, standard deviations, correlations and v'v. Targets are set in advance, by the
limits of one machine and the speed of the peers there, not by what was reached; on another processor Python, BLAS and
memory are not faster or slower alike, and ratios of the same code differ by up to 60 %.

"""
MANY_PHOTOS = """
## Many photos

`orient batch` on a cluster of this machine, against the stages in a loop of one process; each photo is a project of its
own with all stages stored:

"""
PACKAGES = ("sqlalchemy", "numba", "poselib", "opencv-python-headless", "gtsam", "pymap3d")
LINEAR = 1.1
SIZE = re.compile(r",? (n = )?\d+")


def write(done: Sequence[Timed], memory: Sequence[tuple[int, float, float]], batch: str, root: Path) -> None:
    """The page and docs/figures/growth.svg. `memory`: points, seconds, megabytes of projects; `batch`: its text."""
    text = HEAD + _machine() + _table(done) + _growth(done) + _whole_projects(memory) + MANY_PHOTOS + batch
    (root / "docs" / "performance.md").write_text(text, encoding="utf-8")
    _plot(done, root / "docs" / "figures" / "growth.svg")


def _machine() -> str:
    versions = []
    for name in PACKAGES:
        try:
            versions.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            versions.append(f"{name} not installed")
    return f"{tool_version()}; {', '.join(versions)}.\n\n"


def _table(done: Sequence[Timed]) -> str:
    lines = ["| task | candidate | time | ratio to the anchor | target | apart |", "|---|---|---:|---:|---:|---:|"]
    for timed in done:
        lines += [_row(timed, name) for name in timed.seconds if name != timed.anchor]
        lines.append(f"| | *{timed.anchor}* | {_time(timed.median(timed.anchor))} | 1 | | |")
    return "\n".join([*lines, "", *_notes(done), "", ""])


def _notes(done: Sequence[Timed]) -> list[str]:
    """One line for each note; that of several rows under their name without the size."""
    rows: dict[str, list[str]] = {}
    for timed in done:
        if timed.task.note:
            rows.setdefault(timed.task.note, []).append(timed.task.name)
    return [f"* {names[0] if len(names) == 1 else SIZE.sub('', names[0])}: {note}." for note, names in rows.items()]


def _row(timed: Timed, name: str) -> str:
    low, middle, high = timed.ratios(name)
    target = timed.task.target_of(name)
    mark = "" if target is None else f"<= {target:g}" + ("" if middle <= target else " **missed**")
    apart = f"{timed.apart[name]:.0e}" if name in timed.apart else ""
    task = timed.task.name if name == OWN else ""
    return (
        f"| {task} | {name} | {_time(timed.median(name))} | {middle:.3g} ({low:.3g} - {high:.3g}) | {mark} | {apart} |"
    )


def _time(seconds: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-6:.3g} us"


def _lines(done: Sequence[Timed]) -> dict[str, list[tuple[int, float, int]]]:
    """Size, seconds and bytes of each line of the growth plot."""
    lines: dict[str, list[tuple[int, float, int]]] = {}
    for timed in done:
        if timed.task.growth is not None:
            line, size = timed.task.growth
            lines.setdefault(line, []).append((size, timed.median(OWN), timed.peak_bytes))
    return {line: sorted(points) for line, points in lines.items() if len(points) > 1}


def _growth(done: Sequence[Timed]) -> str:
    """Exponents of the larger half of each line."""
    lines = ["## Growth", "", "![Time against the number of points](figures/growth.svg)", ""]
    lines += [
        "time ~ n^p and memory ~ n^q over the larger half of the sizes; memory of one call beyond its inputs:",
        "",
    ]
    lines += ["| work | sizes | p | q | memory at the end |", "|---|---|---:|---:|---:|"]
    for line, points in _lines(done).items():
        sizes, seconds, peaks = zip(*points, strict=True)
        p, q = _marked(exponent(sizes, seconds)), _marked(exponent(sizes, peaks))
        lines.append(f"| {line} | {sizes[0]} - {sizes[-1]} | {p} | {q} | {peaks[-1] / 1e6:.3g} MB |")
    return "\n".join([*lines, "", ""])


def _marked(power: float) -> str:
    return f"{power:.2f}" + ("" if power <= LINEAR else " **more than linear**")


def _whole_projects(memory: Sequence[tuple[int, float, float]]) -> str:
    lines = [
        "## A whole project",
        "",
        "`orient run` on points with their own sigmas (6 + 3n unknowns), everything stored:",
        "",
    ]
    lines += ["| points | time | largest memory |", "|---:|---:|---:|"]
    lines += [f"| {n} | {_time(seconds)} | {megabytes:.0f} MB |" for n, seconds, megabytes in memory]
    return "\n".join([*lines, ""])


def _plot(done: Sequence[Timed], path: Path) -> None:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    mpl.rcParams["svg.hashsalt"] = "orient"
    figure = Figure(figsize=(7.5, 5.0), layout="constrained")
    axes = figure.add_subplot()
    for line, points in _lines(done).items():
        sizes, seconds, _ = zip(*points, strict=True)
        axes.loglog(sizes, seconds, marker="o", markersize=3, label=line)
    axes.set_xlabel("points")
    axes.set_ylabel("time [s]")
    axes.grid(True, which="major", linewidth=0.3)
    axes.legend(fontsize=7)
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, metadata={"Date": None})
