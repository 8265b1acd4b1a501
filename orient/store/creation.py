"""A new project file: tables by Alembic, guards, views, identity. The only place that calls Alembic's commands."""

from pathlib import Path

from sqlalchemy import Connection

from orient.store.connection import open_engine
from orient.store.error_map import translated
from orient.store.errors import OurFault
from orient.store.fingerprint import schema_objects, table_shapes, tables_and_indexes
from orient.store.format import SCHEMA_FILE, Format, SchemaObject, json_from_format
from orient.store.guards import drop_copies, store_copies
from orient.store.watch import Watch

PLACES = (
    Path(__file__).parents[1] / "_migrations",  # installed from a wheel
    Path(__file__).parents[2] / "migrations",  # a checkout
)


def migrations_folder() -> Path:
    for place in PLACES:
        if (place / "env.py").is_file():
            return place
    raise OurFault("the migrations are missing from this installation", "Install orient again.")


def head_revision(migrations: Path) -> str:
    from alembic.script import ScriptDirectory

    head = ScriptDirectory.from_config(_config(migrations)).get_current_head()
    if head is None:
        raise OurFault("there is no migration")
    return head


def migrate(connection: Connection, migrations: Path, revision: str = "head") -> None:
    """Bring the tables to a revision, inside the caller's transaction."""
    from alembic import command

    config = _config(migrations)
    config.attributes["connection"] = connection
    command.upgrade(config, revision)


def _config(migrations: Path):  # type: ignore[no-untyped-def]
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(migrations).replace("%", "%%"))
    config.set_main_option("path_separator", "os")
    return config


def build(connection: Connection, version: int, application_id: int, migrations: Path) -> None:
    """Make an empty or older base a project of format `version`; one transaction, owned by the caller."""
    drop_copies(connection)
    migrate(connection, migrations)
    tables = [name for kind, name, _, _ in schema_objects(connection) if kind == "table"]
    store_copies(connection, tables)
    connection.exec_driver_sql(f"PRAGMA application_id = {application_id}")
    connection.exec_driver_sql(f"PRAGMA user_version = {version}")


def fill_empty_file(path: Path, version: int, application_id: int, migrations: Path | None = None) -> None:
    """Turn an existing empty file into an empty project."""
    watch = Watch()
    engine = open_engine(path, "write", watch)
    try:
        with translated(path, watch), engine.connect() as connection:
            connection.execution_options(immediate=True)
            with connection.begin():
                build(connection, version, application_id, migrations or migrations_folder())
    finally:
        engine.dispose()


def tables_of_version(scratch: Path, version: int, migrations: Path) -> list[SchemaObject]:
    """Tables and indexes as an older orient made them, in an empty file. Its views and guards are not known."""
    engine = open_engine(scratch, "write", Watch())
    try:
        with engine.connect() as connection:
            connection.execution_options(immediate=True)
            with connection.begin():
                migrate(connection, migrations, f"{version:04d}")
                return tables_and_indexes(connection)
    finally:
        engine.dispose()


def format_of(path: Path, version: int, application_id: int, head: str) -> Format:
    """The format as a fresh file shows it."""
    engine = open_engine(path, "read", Watch())
    try:
        with engine.connect() as connection, connection.begin():
            objects = tuple(schema_objects(connection))
            return Format(version, application_id, head, objects, table_shapes(connection))
    finally:
        engine.dispose()


def expected_format(folder: Path, version: int, application_id: int, migrations: Path | None = None) -> Format:
    """What a file made now looks like; `folder` is a scratch folder."""
    scratch = folder / "expected.sqlite"
    scratch.touch(exist_ok=False)
    source = migrations or migrations_folder()
    fill_empty_file(scratch, version, application_id, source)
    return format_of(scratch, version, application_id, head_revision(source))


def write_expected_schema(target: Path = SCHEMA_FILE) -> None:
    """Write schema.json anew; call it after a change of models.py, guards.sql or views.sql."""
    import tempfile

    from orient.models import APPLICATION_ID, SCHEMA_VERSION

    with tempfile.TemporaryDirectory() as folder:
        form = expected_format(Path(folder), SCHEMA_VERSION, APPLICATION_ID)
    target.write_text(json_from_format(form), encoding="utf-8")
