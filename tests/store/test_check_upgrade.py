"""`check` on healthy files, `upgrade` from an older format made for the test."""

import hashlib
import os
import shutil
import stat
from dataclasses import dataclass
from pathlib import Path

import pytest

from orient.errors import ProjectError, UsageError
from orient.models import APPLICATION_ID, SCHEMA_VERSION
from orient.store import creation, upgrade
from orient.store.check import check_project
from orient.store.errors import DiskFull
from orient.store.format import Format
from orient.store.gate import pass_gate
from orient.store.preflight import preflight
from orient.store.project import create_project, open_project
from orient.store.upgrade import upgrade_project

NEXT = f"""
from alembic import op

revision = "{SCHEMA_VERSION + 1:04d}"
down_revision = "{SCHEMA_VERSION:04d}"


def upgrade() -> None:
    op.execute("ALTER TABLE model_point ADD COLUMN sigma_m REAL")
    op.execute("CREATE TABLE later (run_id INTEGER NOT NULL, zone TEXT NOT NULL, "
               "CONSTRAINT pk_later PRIMARY KEY (run_id, zone)) STRICT")
"""


@dataclass(frozen=True)
class NextFormat:
    form: Format
    migrations: Path


@pytest.fixture(scope="module")
def following(tmp_path_factory: pytest.TempPathFactory) -> NextFormat:
    """A format that does not exist yet: one table and one column more."""
    folder = tmp_path_factory.mktemp("next format")
    migrations = Path(shutil.copytree(creation.migrations_folder(), folder / "migrations"))
    (migrations / "versions" / "9999_later.py").write_text(NEXT)
    return NextFormat(creation.expected_format(folder, SCHEMA_VERSION + 1, APPLICATION_ID, migrations), migrations)


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_a_healthy_project(full: Path) -> None:
    steps: list[tuple[int, int]] = []
    report = check_project(full, lambda done, total: steps.append((done, total)))
    assert report.ok
    assert [line.name for line in report.lines] == [
        "SQLite", "file", "schema", "pages", "seals", "numbers", "rows", "digests", "selections",
    ]  # fmt: skip
    assert [done for done, _ in steps] == sorted(done for done, _ in steps)
    (total,) = {total for _, total in steps}
    assert steps[-1] == (total, total) and total > 80  # a row of every table


def test_check_of_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no such project"):
        check_project(tmp_path / "none")


def test_check_tidies_a_stale_journal(full: Path) -> None:
    journal = Path(f"{full}-journal")
    journal.write_bytes(bytes(512))
    report = check_project(full)
    assert report.lines[-1].detail == "a stale journal of an interrupted command was removed"
    assert not journal.exists()


def test_nothing_to_upgrade(full: Path) -> None:
    before = sha256(full)
    assert upgrade_project(full).backup is None
    assert sha256(full) == before
    assert [file.name for file in full.parent.iterdir()] == [full.name]


def test_upgrade_keeps_everything(full: Path, following: NextFormat) -> None:
    full.chmod(0o640)
    before = sha256(full)
    with open_project(full) as project:
        digests = [run.output_digest for run in project.runs()]
    done = upgrade_project(full, following.form, following.migrations)
    assert (done.before, done.after) == (SCHEMA_VERSION, SCHEMA_VERSION + 1)
    assert done.backup is not None and sha256(done.backup) == before
    assert sorted(file.name for file in full.parent.iterdir()) == [full.name, f"{full.name}.bak-{SCHEMA_VERSION:04d}"]
    assert stat.S_IMODE(full.stat().st_mode) == 0o640
    gated = pass_gate(preflight(full, following.form), "write", following.form)
    with gated.connection.begin():
        found = gated.connection.exec_driver_sql("SELECT output_digest FROM run_seal ORDER BY run_id").scalars().all()
    gated.close()
    assert list(found) == digests
    with pytest.raises(ProjectError, match="newer orient"):
        open_project(full)


def test_an_older_format_says_how_to_upgrade(full: Path, following: NextFormat) -> None:
    with pytest.raises(ProjectError, match=f"has format {SCHEMA_VERSION}") as error:
        preflight(full, following.form)
    assert error.value.hint.startswith("Run: orient upgrade house.orient")


BROKEN = {
    "raises": 'op.execute("CREATE TABLE half (a)")\n    raise RuntimeError("broken")',
    "loses rows": 'op.execute("DROP TABLE orientation_angle")\n    op.execute("CREATE TABLE orientation_angle (a)")',
    "forgets a table": "pass",
}


@pytest.mark.parametrize("body", BROKEN.values(), ids=BROKEN)
def test_a_failed_upgrade_changes_nothing(full: Path, following: NextFormat, tmp_path: Path, body: str) -> None:
    broken = Path(shutil.copytree(following.migrations, tmp_path / "migrations"))
    text = NEXT.split("def upgrade")[0] + f"def upgrade() -> None:\n    {body}\n"
    (broken / "versions" / "9999_later.py").write_text(text)
    before = sha256(full)
    with pytest.raises((ProjectError, RuntimeError)):
        upgrade_project(full, following.form, broken)
    shutil.rmtree(broken)
    assert sha256(full) == before
    assert [file.name for file in tmp_path.iterdir()] == [full.name]


def test_an_older_backup_is_not_overwritten(full: Path, following: NextFormat) -> None:
    backup = full.with_name(f"{full.name}.bak-{SCHEMA_VERSION:04d}")
    backup.write_text("precious")
    with pytest.raises(ProjectError, match="exists"):
        upgrade_project(full, following.form, following.migrations)
    assert backup.read_text() == "precious"


def test_a_full_disk_during_the_upgrade(full: Path, following: NextFormat, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_space(*_: object) -> None:
        raise OSError(28, os.strerror(28))

    before = sha256(full)
    monkeypatch.setattr(upgrade, "copy_pages", no_space)
    with pytest.raises(DiskFull):
        upgrade_project(full, following.form, following.migrations)
    assert sha256(full) == before
    assert [file.name for file in full.parent.iterdir()] == [full.name]


def test_garbage_behind_the_last_page_is_found(tmp_path: Path) -> None:
    path = tmp_path / "grown.sqlite"
    create_project(path)
    with path.open("ab") as file:
        file.write(b"garbage\n")
    (line,) = (line for line in check_project(path).lines if not line.ok)
    assert line.name == "size"
