"""`orient upgrade`: migrate a copy, verify it, keep the old file as a backup, replace it in one step."""

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import Connection

from orient.errors import ProjectError
from orient.store import verify
from orient.store.connection import open_engine
from orient.store.copies import copy_pages
from orient.store.creation import build, migrations_folder, tables_of_version
from orient.store.error_map import disk_errors, replaced, translated
from orient.store.errors import StorageError
from orient.store.fingerprint import (
    check_fingerprint,
    check_migration,
    check_pages,
    compare_objects,
    tables_and_indexes,
)
from orient.store.format import Format, current_format
from orient.store.gate import CHECK_DEADLINE_S, recover, require_writable
from orient.store.guards import quoted
from orient.store.new_file import make_file, sync_name, temporary_file
from orient.store.preflight import Preflight, identity, preflight
from orient.store.watch import Watch


@dataclass(frozen=True, slots=True)
class Upgraded:
    """Formats before and after, and where the old file is kept; `backup` is None if there was nothing to do."""

    before: int
    after: int
    backup: Path | None
    warnings: tuple[str, ...] = ()


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
                with watch.within(CHECK_DEADLINE_S):
                    _check_tables(original, look.path, before, migrations or migrations_folder())
                    check_pages(original, look.path)
                return _upgrade(look, before, form, migrations or migrations_folder())
    finally:
        engine.dispose()


def _check_tables(original: Connection, path: Path, before: int, migrations: Path) -> None:
    """A stranger's tables are refused unread. His views and triggers go unused: all of them are made anew."""
    with disk_errors(path), temporary_file(path.parent) as scratch:
        expected = tables_of_version(scratch, before, migrations)
    compare_objects(tables_and_indexes(original), expected, path)
    check_migration(original, f"{before:04d}", path)


def _upgrade(look: Preflight, before: int, form: Format, migrations: Path) -> Upgraded:
    backup = look.path.with_name(f"{look.path.name}.bak-{before:04d}")
    _let_go(backup, look.path)
    with disk_errors(look.path), temporary_file(look.path.parent, look.path.stat().st_mode & 0o777) as copy:
        copy_pages(look.path, copy)
        same, warnings = _sha256(copy), _warnings(look)
        _migrate(copy, form, migrations)
        _keep(look.path, backup, same)
        try:
            copy.replace(look.path)
        except OSError:
            backup.unlink(missing_ok=True)
            raise
        sync_name(look.path)
    return Upgraded(before, form.version, backup, warnings)


def _keep(path: Path, backup: Path, same: str) -> None:
    """The old file itself under a second name; where a file can have only one, a copy that is as the one upgraded."""
    try:
        os.link(path, backup)
    except FileExistsError:
        raise ProjectError(f"{backup} exists.", "Move it away and run the upgrade again.") from None
    except OSError:
        make_file(backup, lambda temporary: _copied(path, temporary, same), path.stat().st_mode & 0o777)


def _copied(path: Path, target: Path, same: str) -> None:
    copy_pages(path, target)
    if _sha256(target) != same:
        raise StorageError(
            f"the backup of {path} is not what was read from it. Nothing was changed.", "Check the disk."
        )


def _sha256(path: Path) -> str:
    """Of a file that SQLite does not have open."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _warnings(look: Preflight) -> tuple[str, ...]:
    """What a new file under the old name changes besides its content."""
    owner = look.path.stat().st_uid
    if not hasattr(os, "geteuid") or owner == os.geteuid():
        return look.warnings
    return (*look.warnings, f"{look.path} belonged to another user (number {owner}); now it is yours.")


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
