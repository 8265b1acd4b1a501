"""`orient audit --serve`: Datasette on a verified, temporary copy of the project, for this machine alone."""

import contextlib
import os
import signal
import socket
import sys
import tempfile
from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orient.errors import NotInstalled, OrientError
from orient.report.audit_metadata import DATABASE, metadata
from orient.report.text import console, printable

LOOPBACK = "127.0.0.1"
TIME_LIMIT_MS = 10_000
MOST_ROWS = 10_000
SHUTDOWN_S = 2
SOURCE = "SELECT name, coalesce(taken_on, ''), platform FROM photo ORDER BY run_id DESC LIMIT 1"

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class Served:
    """How the copy is served. `source`, `licence`: of the photo, shown on every page."""

    port: int
    downloads: bool
    browser: bool
    source: str = ""
    licence: str = ""


def serve(path: Path, how: Served) -> None:
    """Copy, verify, serve until Ctrl-C or SIGTERM, remove the copy. The project itself is never opened by Datasette."""
    require_datasette()
    with _listening(how.port) as listener, tempfile.TemporaryDirectory(prefix="orient-audit-") as folder:
        copy = Path(folder) / f"{DATABASE}.sqlite"
        runs, about = _verified_copy(path, copy)
        port = listener.getsockname()[1]
        app = only_for(datasette_app(copy, about, how), port)
        address = f"http://{LOOPBACK}:{port}/"
        out = console()
        out.print(f"{printable(str(path))}: a copy with {runs} runs, every digest verified, is served read-only at")
        out.print(f"    {address}")
        out.print("Ctrl-C ends it and removes the copy.")
        sys.stdout.flush()
        if how.browser:
            import webbrowser

            webbrowser.open(address)
        _run(app, listener)
    out.print("stopped; the copy is removed")


def require_datasette() -> None:
    """One clear sentence where the extra is not installed."""
    os.environ["DATASETTE_LOAD_PLUGINS"] = ""  # plugins of other projects have no business here
    try:
        import datasette.app  # noqa: F401
    except ImportError:
        raise NotInstalled("the audit server needs", ["Datasette"], "audit") from None


def datasette_app(copy: Path, about: tuple[str, str], how: Served) -> App:
    """Datasette on one immutable file."""
    import datasette.handle_exception
    from datasette.app import Datasette

    # with rich at hand it would print pages of local variables for every mistyped query
    datasette.handle_exception.rich = None
    settings = {
        "sql_time_limit_ms": TIME_LIMIT_MS,
        "max_returned_rows": MOST_ROWS,
        "allow_download": how.downloads,
        "allow_csv_stream": how.downloads,
        "suggest_facets": False,
        "default_cache_ttl": 0,
    }
    told = metadata(about[0], about[1], how.source, how.licence)
    served = Datasette([], immutables=[str(copy)], metadata=told, settings=settings)
    app: App = served.app()
    return app


def only_for(app: App, port: int) -> App:
    """Requests that name another host are refused: a page elsewhere could have its name lead to this machine."""
    allowed = {f"{host}:{port}".encode() for host in (LOOPBACK, "localhost")}

    async def guarded(scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" and dict(scope["headers"]).get(b"host") not in allowed:
            start = {"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain")]}
            await send(start)
            await send({"type": "http.response.body", "body": b"This server answers on this machine only.\n"})
            return
        await app(scope, receive, send)

    return guarded


def _verified_copy(path: Path, copy: Path) -> tuple[int, tuple[str, str]]:
    """The gate first, then a copy of one moment in which every digest was found good; title and description."""
    from orient.report.status import standing
    from orient.store.copies import backup_project
    from orient.store.project import open_project

    open_project(path, "read").close()
    runs = backup_project(path, copy).runs
    with open_project(copy, "read") as project:
        rows, now = project.query(SOURCE)[1], standing(project)
    name, taken_on, platform = rows[0] if rows else (path.stem, "", "")
    when = f", taken on {taken_on}" if taken_on else ""
    kind = f"{platform} photo{when}. " if platform else ""
    return runs, (f"orient: {name}", f"{kind}{now.verdict.sentence}")


@contextlib.contextmanager
def _listening(port: int) -> Iterator[socket.socket]:
    """A socket on the loopback interface; port 0 is any free one."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((LOOPBACK, port))
            listener.listen()
        except OSError as error:
            raise OrientError(
                f"port {port} cannot be used: {error.strerror}", "Give another one: --port 0 takes any free port."
            ) from None
        yield listener


def _run(app: App, listener: socket.socket) -> None:
    """Serve until a signal asks to end; then return, so that the caller tidies up."""
    import uvicorn

    class Server(uvicorn.Server):
        @contextlib.contextmanager
        def capture_signals(self) -> Iterator[None]:
            names = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
            signals = [getattr(signal, name) for name in names if hasattr(signal, name)]
            before = {number: signal.signal(number, self.handle_exit) for number in signals}
            try:
                yield
            finally:
                for number, handler in before.items():
                    signal.signal(number, handler)

    config = uvicorn.Config(app, log_level="warning", lifespan="on", timeout_graceful_shutdown=SHUTDOWN_S)
    Server(config).run(sockets=[listener])
