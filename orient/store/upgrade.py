"""`orient upgrade`: migrate a copy, verify it, keep the old file as a backup, replace it in one step."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import Connection

from orient.errors import ProjectError
from orient.store import verify
from orient.store.connection import open_engine
from orient.store.copies import copy_pages
from orient.store.creation import build, migrations_folder
from orient.store.error_map import disk_errors, replaced, translated
from orient.store.fingerprint import check_fingerprint, check_pages
from orient.store.format import Format, current_format
from orient.store.gate import recover, require_writable
from orient.store.guards import quoted
from orient.store.new_file import sync_name, temporary_file
from orient.store.preflight import Preflight, identity, preflight
from orient.store.watch import Watch


@dataclass(frozen=True, slots=True)
class Upgraded:
    """Formats before and after, and where the old file is kept; `backup` is None if there was nothing to do."""

    before: int
    after: int
    backup: Path | None


def upgrade_project(
    path: str | os.PathLike[str], form: Format | None = None, migrations: Path | None = None
) -> Upgraded:
    """Bring a project of an older format to the current one; the old file stays beside it as NAME.bak-<format>.

    Whatever goes wrong before the last step leaves the project as it was. `form` and `migrations` are for tests.
    """
    form = form or current_format()
    look = preflight(path, form, any_version=True)
    require_writable(look.path)
    if look.journal == "hot":
        recover(look)
    file, watch = identity(look.path), Watch()
    engine = open_engine(look.path, "write", watch)
    try:
        with translated(look.path, watch), engine.connect() as original:
            original.execution_options(immediate=True)
            with original.begin():  # nobody else writes until the new file is in place
                if identity(look.path) != file:
                    raise replaced(look.path)
                before = int(original.exec_driver_sql("PRAGMA main.user_version").scalar_one())
                if before == form.version:
                    return Upgraded(before, before, None)
                check_pages(original, look.path)
                return _upgrade(look, before, form, migrations or migrations_folder())
    finally:
        engine.dispose()


def _upgrade(look: Preflight, before: int, form: Format, migrations: Path) -> Upgraded:
    backup = look.path.with_name(f"{look.path.name}.bak-{before:04d}")
    _let_go(backup, look.path)
    with disk_errors(look.path), temporary_file(look.path.parent, look.path.stat().st_mode & 0o777) as copy:
        copy_pages(look.path, copy)
        _migrate(copy, form, migrations)
        os.link(look.path, backup)
        try:
            copy.replace(look.path)
        except OSError:
            backup.unlink(missing_ok=True)
            raise
        sync_name(look.path)
    return Upgraded(before, form.version, backup)


def _let_go(backup: Path, project: Path) -> None:
    """The name of the backup must be free; a killed upgrade can have given it to the project itself already."""
    if not os.path.lexists(backup):
        return
    if not (backup.exists() and backup.samefile(project)):
        raise ProjectError(f"{backup} exists.", "Move the older backup away and run the upgrade again.")
    backup.unlink()


def _migrate(path: Path, form: Format, migrations: Path) -> None:
    """All steps in one transaction on the copy, then compare: schema as in a new file, same rows, same digests."""
    watch = Watch()
    engine = open_engine(path, "write", watch)
    try:
        with translated(path, watch), engine.connect() as connection:
            _without_foreign_keys(connection)
            connection.execution_options(immediate=True)
            with connection.begin():
                counts = _row_counts(connection)
                build(connection, form.version, form.application_id, migrations)
                check_fingerprint(connection, form, path)
                _compare(counts, _row_counts(connection), path)
            with connection.begin():
                check_pages(connection, path, thorough=True)
                for problem in verify.all_problems(connection, form):
                    raise ProjectError(f"the upgrade of {path.name} does not keep the results: {problem}.")
    finally:
        engine.dispose()


def _without_foreign_keys(connection: Connection) -> None:
    """Rebuilding a table must not delete the rows that refer to it; has no effect inside a transaction."""
    driver = connection.connection.driver_connection
    if driver is not None:
        driver.execute("PRAGMA foreign_keys = OFF").fetchall()


def _row_counts(connection: Connection) -> dict[str, int]:
    names = connection.exec_driver_sql("SELECT name FROM main.sqlite_schema WHERE type = 'table'").scalars().all()
    return {
        name: int(connection.exec_driver_sql(f"SELECT count(*) FROM main.{quoted(name)}").scalar_one())
        for name in names
        if name != "alembic_version"
    }


def _compare(before: Mapping[str, int], after: Mapping[str, int], path: Path) -> None:
    for table, count in before.items():
        if after.get(table, 0) < count:
            raise ProjectError(f'{path}: the upgrade lost rows of table "{table}".', "Nothing was changed.")
