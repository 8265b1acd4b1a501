"""Start-up of the commands as ratios against the bare import of the libraries they need.

Candidates run interleaved, so that a busy machine slows all of them alike; medians of the ratios' parts. Prints a
markdown table. Exit code 1 if a ratio is above its limit and `--strict` is given.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROUNDS = 15
ROOT = Path(__file__).parents[1]
SAMPLE = ROOT / "sample_projects" / "apollo15-metric-0585"
ORIENT = [sys.executable, "-c", "from orient.cli.main import run; run()"]
SMALL_LIBRARIES = "import sqlalchemy, rich, typer"
RUN_LIBRARIES = (
    "import sqlalchemy, rich.console, rich.table, rich.progress, typer, numpy, scipy.linalg, scipy.special, pyproj"
)
LIMITS = {"orient status": 1.5, "orient run": 2.0}


def seconds(command: list[str]) -> float:
    """Wall time of one command."""
    begin = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env={**os.environ, "PYTHONPATH": str(ROOT)})
    return time.perf_counter() - begin


def measure(folder: Path) -> dict[str, list[float]]:
    """Times of all candidates, interleaved."""
    times: dict[str, list[float]] = {}
    project = folder / "status.sqlite"
    seconds([*ORIENT, "new", str(project), "--from", str(SAMPLE)])
    for number in range(ROUNDS):
        fresh = folder / f"run-{number}.sqlite"
        seconds([*ORIENT, "new", str(fresh), "--from", str(SAMPLE)])
        candidates = {
            "import sqlalchemy, rich, typer": [sys.executable, "-c", SMALL_LIBRARIES],
            "orient status": [*ORIENT, "status", str(project)],
            "import of the libraries of run": [sys.executable, "-c", RUN_LIBRARIES],
            "orient run": [*ORIENT, "run", str(fresh)],
            "orient --help": [*ORIENT, "--help"],
        }
        for name, command in candidates.items():
            times.setdefault(name, []).append(seconds(command))
    return times


def main(arguments: list[str]) -> int:
    """Print the table; see the module."""
    with tempfile.TemporaryDirectory() as folder:
        times = measure(Path(folder))
    median = {name: statistics.median(values) for name, values in times.items()}
    bases = {
        "orient --help": "import sqlalchemy, rich, typer",
        "orient status": "import sqlalchemy, rich, typer",
        "orient run": "import of the libraries of run",
    }
    print("| command | against | median s | ratio | limit |\n|---|---|---|---|---|")
    too_slow = False
    for name, base in bases.items():
        ratio, limit = median[name] / median[base], LIMITS.get(name)
        too_slow |= limit is not None and ratio > limit
        print(f"| {name} | {base} ({median[base]:.3f} s) | {median[name]:.3f} | {ratio:.2f} | {limit or ''} |")
    return int(too_slow and "--strict" in arguments)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
