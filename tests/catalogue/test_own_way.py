"""Rows of the catalogue that need more than files and one command: other processes, terminals, clocks, rights."""

import os
import pty
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from orient.store import check, connection, ledger, preflight
from orient.store.project import open_project
from tests.catalogue.case import NEVER, PROJECT, Place
from tests.catalogue.project import hot_journal
from tests.cli.commands import AERIAL, ENTRY, ROOT, Said, orient, orient_process, start
from tests.faults.conftest import victims
from tests.faults.test_surroundings import modes_bind
from tests.faults.victims import Ended, Fault, Victims
from tests.promises import Promise
from tests.store.made import new_run, outcome_of
from tests.store.test_opening import unguarded

__all__ = ["modes_bind", "victims"]

HOLD = """
import sqlite3, sys
holder = sqlite3.connect(sys.argv[1], isolation_level=None)
holder.execute("BEGIN EXCLUSIVE")
print("held", flush=True)
sys.stdin.read()
"""


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Another process has the project locked."""
    child = subprocess.Popen([sys.executable, "-c", HOLD, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdout is not None
    child.stdout.readline()
    try:
        yield
    finally:
        child.communicate()


def clean(said: Said | Ended) -> str:
    everything = said.out + said.err
    assert not [never for never in NEVER if never in everything], everything
    return everything


@pytest.mark.usefixtures("modes_bind")
def test_D21_a_hot_journal_in_a_read_only_folder(place: Place, victims: Victims, promise: Promise) -> None:
    with promise("B").trial("D21"):
        place.write({})
        hot_journal(place)
        place.project.chmod(0o444)
        place.root.chmod(0o555)
        try:
            said = victims.run("status", place.project, fault=Fault(unprivileged=True))
        finally:
            place.root.chmod(0o755)
        assert said.code == 3
        assert "an interrupted command must be undone first, but the folder is read-only" in clean(said)
        assert Path(f"{place.project}-journal").exists()
        place.project.chmod(0o644)
        assert orient("status", place.project).code == 0


PATHS = ("../../x", "/etc/passwd", "file:///etc/passwd", "\\\\server\\share", "C:\\x", "http://example.org/x.tif")


@pytest.mark.parametrize("name", PATHS)
def test_D31_a_stored_path_is_only_text(name: str, place: Place, promise: Promise) -> None:
    place.take_full()
    with open_project(place.project, "write") as project:
        outcome = outcome_of("photo")
        row = {**outcome.tables["photo"][0], "image_file": name, "name": name}
        project.append(new_run(project, "photo", outcome=type(outcome)({**outcome.tables, "photo": [row]})))
    with promise("S8").trial(name):
        before = place.content()
        for words in (("status",), ("show", "photo"), ("log",), ("check",)):
            said = orient(words[0], place.project, *words[1:])
            assert said.code == 0, clean(said)
        assert name in orient("show", place.project, "photo", "--json").out.replace("\\\\", "\\")
        assert place.content() == before
        sealed = place.root / "sealed.sqlite"
        assert orient("seal", place.project, "-o", sealed).code == 0
        assert sorted(path.name for path in place.root.iterdir()) == ["photo.sqlite", "sealed.sqlite"]


TIMES = ("2100-01-01T00:00:00.000Z", "-001-01-01T00:00:00.000Z", "1970-01-01T00:00:00.000Z")


def test_D32_the_clock_is_decoration(place: Place, promise: Promise, monkeypatch: pytest.MonkeyPatch) -> None:
    place.take_full()
    for moment in TIMES:
        with promise("B").trial(f"D32 {moment}"):
            monkeypatch.setattr(ledger, "now", lambda moment=moment: moment)
            with open_project(place.project, "write") as project:
                project.append(new_run(project, "photo", TIMES.index(moment) + 1.5))
            told = orient("log", place.project).out
            assert moment[:10] in told
            assert orient("check", place.project).code == 0
    versions = [row["version"] for row in _log(place) if row["stage"] == "photo" and row["action"] == "run"]
    assert versions == [1, 2, 3, 4]


def _log(place: Place) -> list[dict[str, object]]:
    import json

    return json.loads(orient("log", place.project, "--json").out)  # type: ignore[no-any-return]


@pytest.mark.parametrize("words", [("status",), ("select", "photo", "1", "-m", "x"), ("check",), ("backup",)])
def test_D33_locked_by_another(
    words: tuple[str, ...], place: Place, promise: Promise, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_TIMEOUT_S", 0.2)
    place.take_full()
    before = place.content()
    with promise("B").trial(f"D33 {words[0]}"), held(place.project):
        said = orient(words[0], place.project, *words[1:])
        assert said.code == 3
        assert "is in use by another command" in clean(said)
    assert place.content() == before
    assert orient("status", place.project).code == 0


def test_D36_replaced_during_the_command(place: Place, promise: Promise) -> None:
    """The command has the old file open and waits for its lock; meanwhile another file takes the name."""
    place.take_full()
    other = Path(shutil.copy(place.full, place.root / "other"))
    meant = other.read_bytes()
    with promise("B").trial("D36"):
        with held(place.project):
            waiting = start("select", place.project, "photo", "1", "-m", "x")
            _wait_for_open(waiting.pid, place.project)
            other.replace(place.project)
        out, err = waiting.communicate(timeout=60)
        assert waiting.returncode == 3, err
        assert b"was replaced" in err
        assert b"Traceback" not in err + out
        assert place.project.read_bytes() == meant


def _wait_for_open(pid: int, path: Path) -> None:
    """Until the process has the file open (and so has found it in order and waits)."""
    give_up = time.monotonic() + 30
    while time.monotonic() < give_up:
        links = list(Path(f"/proc/{pid}/fd").iterdir())
        with suppress(FileNotFoundError):  # the process closed one meanwhile
            if str(path) in [str(link.readlink()) for link in links]:
                time.sleep(0.3)
                return
        time.sleep(0.02)
    raise AssertionError("the command never opened the project")


def test_D37_a_network_share_is_a_warning(place: Place, promise: Promise, monkeypatch: pytest.MonkeyPatch) -> None:
    mounts = f"tmpfs / tmpfs rw 0 0\nserver:/share {place.root} nfs4 rw 0 0\n"
    real = Path.read_text

    def read_text(self: Path, *words: object, **named: object) -> str:
        return mounts if str(self) == "/proc/mounts" else real(self, *words, **named)  # type: ignore[arg-type]

    place.take_full()
    with promise("B").trial("D37"):
        assert not preflight.is_on_network(place.project)
        monkeypatch.setattr(Path, "read_text", read_text)
        said = orient("status", place.project)
        assert said.code == 0
        assert said.out.count("lies on a network file system") == 1


def test_E10_bytes_do_not_go_to_a_terminal(place: Place, promise: Promise) -> None:
    """To a pipe they do."""
    image = place.root / "photo.tif"
    image.write_bytes(b"II*\0" + bytes(range(256)))
    sealed = place.root / "sealed.sqlite"
    with promise("B").trial("E10"):
        assert orient("seal", place.take_full(), "-o", sealed, "--image", image).code == 0
        command = [sys.executable, "-c", ENTRY, "image", str(sealed), "-o", "-"]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        piped = subprocess.run(command, env=environment, capture_output=True, check=False)
        assert (piped.returncode, piped.stdout, piped.stderr) == (0, image.read_bytes(), b"")
        ours, theirs = pty.openpty()
        shown = subprocess.run(command, env=environment, stdout=theirs, stderr=subprocess.PIPE, check=False)
        os.close(theirs)
        os.close(ours)
        assert shown.returncode == 2
        assert shown.stderr.startswith(b"orient: an image is not for the terminal")


def test_E17_an_old_sqlite_is_named(place: Place, promise: Promise, monkeypatch: pytest.MonkeyPatch) -> None:
    """An old Python cannot install orient (requires-python), and `make setup` says so."""
    import tomllib

    place.take_full()
    with promise("B").trial("E17"):
        monkeypatch.setattr(check.sqlite3, "sqlite_version_info", (3, 36, 0))
        monkeypatch.setattr(check.sqlite3, "sqlite_version", "3.36.0")
        said = orient("check", place.project)
        assert said.code == 3
        assert "3.36.0 is too old, orient needs 3.37" in clean(said)
        stated = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["requires-python"]
        assert stated == ">=3.11"


MARKUP = ("<script>alert(1)</script>", '"><image href="http://example.org/x"/>', "a & b", "]]>", "$\\frac{1}{0}$")


@pytest.fixture(scope="module")
def oriented_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("oriented") / "photo.sqlite"
    assert orient("new", path, "--from", AERIAL).code == 0
    assert orient("run", path).code == 0
    return path


@pytest.mark.parametrize("name", MARKUP)
def test_F6_a_picture_holds_no_markup_of_a_name(
    name: str, oriented_once: Path, tmp_path: Path, promise: Promise
) -> None:
    """Every point and the photo get the name, in every table of the project."""
    path = Path(shutil.copy(oriented_once, tmp_path / "photo.sqlite"))
    text = "'" + name.replace("'", "''") + "'"
    tables = ("image_residual", "image_point", "adjusted_point", "ground_covariance", "topocentric_point")
    changes = [f"UPDATE {table} SET point = {text} WHERE point = '100'" for table in tables]
    unguarded("PRAGMA foreign_keys = OFF", *changes, f"UPDATE photo SET name = {text}")(path)
    for kind in ("residuals", "accuracy", "ellipses"):
        with promise("S7").trial(f"F6 {kind} {name}"):
            said = orient("plot", path, kind, "-o", tmp_path / f"{kind}.svg")
            assert said.code == 0, clean(said)
            root = ET.parse(tmp_path / f"{kind}.svg").getroot()
            tags = {str(node.tag).rpartition("}")[2] for node in root.iter()}
            assert not tags & {"script", "foreignObject", "image", "a", "iframe"}
            for node in root.iter():
                for key, value in node.attrib.items():
                    assert not key.lower().startswith("on"), key
                    is_link = key.rpartition("}")[2] == "href"
                    assert not is_link or value.startswith("#"), value


def test_F13_a_killed_export_leaves_no_file_or_the_old_one(place: Place, promise: Promise) -> None:
    """Killed at moments all over its time; what it leaves under a name of its own goes with the next command."""
    image, sealed, out = (place.root / name for name in ("photo.tif", "sealed.sqlite", "out.tif"))
    image.write_bytes(b"II*\0" + os.urandom(20 * 2**20))
    assert orient("seal", place.take_full(), "-o", sealed, "--image", image).code == 0
    began = time.monotonic()
    assert orient_process("image", sealed, "-o", out).code == 0
    seconds = time.monotonic() - began
    kept, whole = promise("B"), image.read_bytes()
    for number in range(8):
        with kept.trial(f"F13 killed at {number}/8"):
            old = b"the old one" if number % 2 else None
            out.unlink(missing_ok=True)
            if old:
                out.write_bytes(old)
            child = start("image", sealed, "-o", out, "--force")
            time.sleep(seconds * (0.5 + number / 16))
            child.send_signal(signal.SIGKILL)
            child.communicate()
            assert (out.read_bytes() if out.exists() else None) in (old, whole)
    assert orient("image", sealed, "-o", out, "--force").code == 0
    names = {path.name for path in place.root.iterdir()}
    assert names == {"photo.tif", "photo.sqlite", "sealed.sqlite", "out.tif"}


def test_the_words_of_a_case_are_placed(tmp_path: Path) -> None:
    place = Place(tmp_path, tmp_path)
    assert place.placed(f"{PROJECT}.x") == f"{tmp_path}/photo.sqlite.x"
    assert place.placed(3) == 3
