"""A PostgreSQL cluster of the test's own: on loopback, by an unprivileged user, with a password, gone afterwards."""

import os
import pwd
import shutil
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PASSWORD = "a:secret/of@the?test"
BINARIES = ["/usr/lib/postgresql", "/usr/local/pgsql", "/opt/homebrew/opt/postgresql"]


def programs() -> Path | None:
    """The folder with initdb and postgres, or None."""
    found = shutil.which("initdb")
    places = [Path(found).resolve().parent] if found else []
    places += [path.parent for base in BINARIES for path in sorted(Path(base).glob("**/initdb"), reverse=True)]
    return next((place for place in places if (place / "postgres").exists()), None)


@contextmanager
def cluster() -> Iterator[tuple[str, int]]:
    """Host and port of a running server with a superuser `tester`."""
    binaries = programs()
    assert binaries is not None
    folder = Path(tempfile.mkdtemp(prefix="orient-pg-"))
    user = _unprivileged()
    try:
        password = folder / "password"
        password.write_text(PASSWORD)
        if user is not None:
            for path in (folder, password):
                shutil.chown(path, user)
        data = folder / "data"
        initdb = [binaries / "initdb", "-D", data, "-U", "tester", "--auth=scram-sha-256", f"--pwfile={password}",
                  "--encoding=UTF8", "--locale=C", "--no-sync"]  # fmt: skip
        subprocess.run(initdb, check=True, user=user, stdout=subprocess.DEVNULL, cwd=folder)
        yield from _running(binaries, folder, data, user)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _running(binaries: Path, folder: Path, data: Path, user: str | None) -> Iterator[tuple[str, int]]:
    port = _free_port()
    options = f"-c listen_addresses=127.0.0.1 -c unix_socket_directories='' -c fsync=off -p {port}"
    control = [binaries / "pg_ctl", "-D", data, "-w", "-l", folder / "log"]
    subprocess.run(
        [*control, "-o", options, "start"], check=True, user=user, stdout=subprocess.DEVNULL, cwd=folder, timeout=60
    )
    try:
        yield "127.0.0.1", port
    finally:
        subprocess.run([*control, "-m", "immediate", "stop"], user=user, stdout=subprocess.DEVNULL, cwd=folder)


def _unprivileged() -> str | None:
    """PostgreSQL refuses to run as root."""
    if os.getuid() != 0:
        return None
    known = {entry.pw_name for entry in pwd.getpwall()}
    return "postgres" if "postgres" in known else "nobody"


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
