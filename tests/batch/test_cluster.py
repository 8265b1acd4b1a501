"""Real workers: killed on the way, coordinator killed or stopped, scheduler by address. Each photo ends once."""

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import psutil
import pytest

from orient.store.check import check_project
from tests.batch.reading import assert_each_ended_once, latest, rows, versions
from tests.cli.commands import ROOT, Said, orient, start

PATIENCE_S = 300.0
STOP_S = 60.0
"""A stop waits for the photo that a worker is at; beyond that the machine may be busy."""


def until(condition: Callable[[], bool], child: "subprocess.Popen[bytes] | None" = None) -> None:
    give_up = time.monotonic() + PATIENCE_S
    while not condition():
        assert child is None or child.poll() is None, "it ended too early"
        assert time.monotonic() < give_up, "it took too long"
        time.sleep(0.02)


def finished(*words: object, env: dict[str, str] | None = None) -> Said:
    child = start(*words, env=env)
    out, err = child.communicate(timeout=PATIENCE_S)
    return Said(child.returncode, out.decode(), err.decode())


def worker_processes(coordinator: int) -> list[psutil.Process]:
    """The processes that work for a coordinator."""
    with contextlib.suppress(psutil.NoSuchProcess):
        children = psutil.Process(coordinator).children(recursive=True)
        return [child for child in children if is_worker(child)]
    return []


def is_worker(process: psutil.Process) -> bool:
    with contextlib.suppress(psutil.NoSuchProcess, psutil.AccessDenied):
        return any("spawn_main" in word for word in process.cmdline())
    return False


def names_in(folder: Path) -> set[str]:
    return {path.name for path in folder.glob("*.sqlite")}


def ended(summary: Path) -> int:
    if not summary.exists() or summary.stat().st_size == 0:
        return 0
    with contextlib.suppress(Exception):
        return int(rows(summary, "SELECT count(*) AS n FROM orient_photo")[0]["n"])
    return 0


def begun(folder: Path) -> int:
    """Projects in which something was computed."""
    return sum(bool(versions(path)) for path in folder.glob("*.sqlite"))


@pytest.fixture
def scratch(tmp_path: Path) -> Path:
    """The folder for temporary files of the commands under test."""
    place = tmp_path / "scratch"
    place.mkdir()
    return place


def test_summary_of_two_workers_is_that_of_one_process(projects: Path, tmp_path: Path, scratch: Path) -> None:
    other = Path(shutil.copytree(projects, tmp_path / "other"))
    child = start("batch", projects, "--workers", "2", "--json", env={"TMPDIR": str(scratch)})
    until(lambda: begun(projects) >= 1, child)
    assert_private(child.pid)
    out, err = child.communicate(timeout=PATIENCE_S)
    assert (child.returncode, err) == (0, b"")
    content = json.loads(out)
    assert (content["photos"], content["computed"], content["failed"]) == (12, 12, 0)
    assert orient("batch", other, "--workers", "0").code == 0
    assert_each_ended_once(projects, projects / "orient-summary.db", names_in(projects))
    assert list(scratch.iterdir()) == []
    kept = ("verdict", "x_s_m", "y_s_m", "z_s_m", "sigma_kappa_deg", "sigma0_mm", "rms_x_mm", "n_notes")
    one, two = (latest(folder / "orient-summary.db") for folder in (other, projects))
    assert {name: [row[key] for key in kept] for name, row in one.items()} == {
        name: [row[key] for key in kept] for name, row in two.items()
    }


def test_killed_workers(projects: Path, scratch: Path) -> None:
    """Each time some photo has ended or begun, a worker is killed in the middle of its work."""
    names = names_in(projects)
    child = start("batch", projects, "--workers", "2", env={"TMPDIR": str(scratch)})
    killed = 0
    for wanted in (1, 4, 7):
        until(lambda wanted=wanted: begun(projects) >= wanted and len(worker_processes(child.pid)) > 0, child)
        for victim in worker_processes(child.pid)[:1]:
            victim.kill()
            killed += 1
    out, err = child.communicate(timeout=PATIENCE_S)
    assert (child.returncode, err) == (0, b""), out
    assert killed == 3
    assert_each_ended_once(projects, projects / "orient-summary.db", names)
    assert all(check_project(projects / name).ok for name in names)
    assert list(scratch.iterdir()) == []


def test_killed_coordinator_goes_on(many_projects: Path, scratch: Path) -> None:
    names, summary = names_in(many_projects), many_projects / "orient-summary.db"
    child = start("batch", many_projects, "--workers", "2", env={"TMPDIR": str(scratch)})
    until(lambda: ended(summary) >= 3, child)
    workers = worker_processes(child.pid)
    assert workers
    child.kill()
    child.communicate()
    _, alive = psutil.wait_procs(workers, timeout=STOP_S)
    assert alive == [], "workers outlive their coordinator"
    before = ended(summary)
    assert 0 < before < len(names)
    again = finished("batch", many_projects, "--workers", "2", env={"TMPDIR": str(scratch)})
    assert (again.code, again.err) == (0, "")
    assert f"{before} done before" in again.out
    assert_each_ended_once(many_projects, summary, names)
    (first, second) = rows(summary, "SELECT * FROM orient_batch ORDER BY batch_id")
    assert (first["state"], first["ended_at"], second["state"], second["n_done_before"]) == (
        "running", None, "finished", before
    )  # fmt: skip
    assert list(scratch.iterdir()) == [], "what the killed batch left is swept by the next"


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["Ctrl-C", "SIGTERM"])
def test_stopped(number: int, code: int, many_projects: Path, scratch: Path) -> None:
    """As a terminal does it: the signal goes to the whole group of processes."""
    names, summary = names_in(many_projects), many_projects / "orient-summary.db"
    child = start("batch", many_projects, "--workers", "2", env={"TMPDIR": str(scratch)}, start_new_session=True)
    until(lambda: ended(summary) >= 2, child)
    workers = worker_processes(child.pid)
    if number == signal.SIGINT:
        os.killpg(child.pid, number)
    else:
        child.send_signal(number)
    out, err = child.communicate(timeout=STOP_S)
    assert (child.returncode, out) == (code, b"")
    kept = ended(summary)
    assert 2 <= kept < len(names)
    assert err.decode().startswith(f"stopped: {kept} of {len(names)} photos have ended and are kept in ")
    assert b"Traceback" not in err
    _, alive = psutil.wait_procs(workers, timeout=5)
    assert alive == []
    assert list(scratch.iterdir()) == []
    assert rows(summary, "SELECT state FROM orient_batch") == [{"state": "stopped"}]
    assert finished("batch", many_projects, "--workers", "2").code == 0
    assert_each_ended_once(many_projects, summary, names)


def assert_private(coordinator: int) -> None:
    """Loopback only, no page for anybody, no port that takes a stranger's work, one BLAS thread per worker."""
    processes = [psutil.Process(coordinator), *worker_processes(coordinator)]
    assert len(processes) == 3
    connections = [one for process in processes for one in process.net_connections("inet")]
    assert {one.laddr.ip for one in connections} == {"127.0.0.1"}
    assert {one.raddr.ip for one in connections if one.raddr} == {"127.0.0.1"}
    environment = processes[-1].environ()
    assert {environment[name] for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")} == {"1"}
    ports = {one.laddr.port for one in connections if one.status == psutil.CONN_LISTEN}
    assert len(ports) > 3
    assert {first_line(port) for port in ports} <= {b"", b"HTTP/1.1 404 Not Found"}


def first_line(port: int) -> bytes:
    """What somebody else on the machine gets without the batch's own certificate."""
    with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=2) as other:
        other.sendall(b"GET /info/main/workers.html HTTP/1.0\r\n\r\n")
        return other.recv(4096).partition(b"\r\n")[0]
    return b""


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A scheduler and one worker with two threads, as somebody would start them."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{probe.getsockname()[1]}"
    port = address.rpartition(":")[2]
    folder = str(tmp_path_factory.mktemp("scheduler"))
    serve = ["scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard", "--dashboard-address", "127.0.0.1:0"]
    work = ["worker", address, "--host", "127.0.0.1", "--nthreads", "2", "--nworkers", "1", "--no-dashboard",
            "--local-directory", folder]  # fmt: skip
    with _dask(serve), _dask(work):
        yield address


@contextlib.contextmanager
def _dask(words: Sequence[str]) -> Iterator[None]:
    code = "import sys; from dask.__main__ import main; sys.argv[0] = 'dask'; main()"
    child = subprocess.Popen(
        [sys.executable, "-c", code, *words],
        env={**os.environ, "PYTHONPATH": str(ROOT)}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        yield
    finally:
        child.terminate()
        child.wait(timeout=30)


def test_scheduler_by_address(scheduler: str, projects: Path) -> None:
    names, summary = names_in(projects), projects / "orient-summary.db"
    done = finished("batch", projects, "--scheduler", scheduler)
    assert (done.code, done.err) == (0, "")
    assert_each_ended_once(projects, summary, names)
    assert rows(summary, "SELECT workers FROM orient_batch") == [{"workers": scheduler}]
    assert "Nothing to do" in finished("batch", projects, "--scheduler", scheduler).out
    again = finished("batch", projects, "--scheduler", scheduler, "--control", "fixed")
    assert (again.code, "12 good" in again.out or "12 doubtful" in again.out) == (0, True)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x"])
def test_no_scheduler_there(address: str, projects: Path) -> None:
    done = finished("batch", projects, "--scheduler", address)
    assert done.code == 2
    assert done.err.startswith("orient: no scheduler answers at ")
    assert begun(projects) == 0


def test_a_photo_that_kills_its_worker_is_a_row(projects: Path) -> None:
    """Three photos are given to a worker whose computation ends its process at one of them."""
    code = """
import os, sys
from pathlib import Path
from orient.batch import cluster
from orient.batch.values import Item, Order
from tests.batch.deadly import work_through
if __name__ == "__main__":
    cluster.work_through = work_through
    items = [Item(str(path)) for path in sorted(Path(sys.argv[1]).glob("P00[0-2].sqlite"))]
    with cluster.local_workers(2, None) as pool:
        for endings in pool.work([items], Order()):
            for ending in endings:
                print(Path(ending.path).name, ending.exit_code, ending.message, flush=True)
"""
    script = projects.parent / "deadly.py"
    script.write_text(code)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, script, projects], capture_output=True, text=True, env=environment,
                          timeout=PATIENCE_S, check=False)  # fmt: skip
    told = dict(line.split(" ", 1) for line in done.stdout.splitlines())
    assert done.returncode == 0, done.stderr
    assert told["P001.sqlite"].startswith("70 the worker ended while it worked on this photo")
    assert told["P000.sqlite"] == told["P002.sqlite"] == "0 "
