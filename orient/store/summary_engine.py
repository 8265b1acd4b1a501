"""From a file name or a database URL to an engine for the summary of a batch."""

import os
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import Engine, create_engine
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError, NoSuchModuleError

from orient.errors import ProjectError, UsageError
from orient.store.connection import open_engine
from orient.store.new_file import make_file, new_name
from orient.store.preflight import SQLITE_MAGIC
from orient.store.watch import Watch

SUMMARY_APPLICATION_ID = 0x4F524E42
"""ORNB, in the header of a summary file."""
EXAMPLE = "For example: --summary survey.db, or --summary postgresql://USER@HOST/BASE"


@dataclass(frozen=True, slots=True)
class SummaryPlace:
    """Where the summary is: a file, or a server. `shown` never holds a password."""

    shown: str
    file: Path | None = None
    url: URL | None = None

    @property
    def exists(self) -> bool:
        return self.file is None or os.path.lexists(self.file)


def summary_place(text: str) -> SummaryPlace:
    """A file name, or any URL that SQLAlchemy knows."""
    if "://" not in text:
        return _of_file(text)
    try:
        url = make_url(text)
        backend = url.get_backend_name()
    except (ArgumentError, ValueError):
        raise UsageError("the URL of the summary cannot be read.", EXAMPLE) from None
    if backend == "sqlite":
        return _of_file(url.database or "")
    return SummaryPlace(url.render_as_string(hide_password=True), url=url)


def _of_file(text: str) -> SummaryPlace:
    if not text or "\0" in text or text == ":memory:":
        raise UsageError("the summary needs the name of a file.", EXAMPLE)
    return SummaryPlace(text, file=Path(os.path.abspath(text)))  # noqa: PTH100  (a new file takes exactly this name)


def summary_engine(place: SummaryPlace) -> Engine:
    """An engine whose every transaction may write. A file that is not there is made, for its owner only."""
    if place.file is not None:
        if not place.exists:
            make_file(new_name(place.file), _mark)
        _check_file(place.file)
        return open_engine(place.file, "write", Watch()).execution_options(immediate=True)
    assert place.url is not None
    try:
        return create_engine(place.url, hide_parameters=True)
    except NoSuchModuleError:
        raise UsageError(f"{place.shown}: SQLAlchemy knows no such database.", EXAMPLE) from None
    except ImportError as error:
        hint = "pip install 'orient[postgresql]'" if place.url.get_backend_name() == "postgresql" else ""
        raise UsageError(f"{place.shown} needs the package {error.name}.", hint or "Install it.") from None


def _mark(temporary: Path) -> None:
    engine = open_engine(temporary, "write", Watch())
    try:
        with engine.begin() as connection:
            connection.exec_driver_sql(f"PRAGMA application_id = {SUMMARY_APPLICATION_ID}")
    finally:
        engine.dispose()


def _check_file(path: Path) -> None:
    """Nothing but a summary is written to: neither a project nor somebody else's base."""
    if not path.is_file():
        raise ProjectError(f"{path} is not a regular file.", "Give another --summary.")
    try:
        with path.open("rb") as file:
            header = file.read(100)
    except OSError as error:
        raise ProjectError(f"{path} cannot be read: {error.strerror}.", "Give another --summary.") from None
    if header[:16] != SQLITE_MAGIC or int.from_bytes(header[68:72], "big") != SUMMARY_APPLICATION_ID:
        raise ProjectError(f"{path} is not a summary of orient batch; it was left as it is.", "Give another --summary.")
    if not (os.access(path, os.W_OK) and os.access(path.parent, os.W_OK)):
        raise ProjectError(f"{path} cannot be written (read-only file or folder).", "Give another --summary.")
