"""The summary holds each project's own numbers, on SQLite and on a real PostgreSQL, and is written all or nothing."""

import json
import math
import os
import stat
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import pytest
from sqlalchemy import create_engine, text

from orient.batch.photo_task import work_through
from orient.batch.summary import Summary, open_summary
from orient.batch.values import Ending, Item, Order
from orient.errors import OrientError, ProjectError, UsageError
from orient.report.status import standing
from orient.store.project import open_project
from orient.store.summary_engine import summary_place
from tests.batch.postgresql import PASSWORD, cluster, programs
from tests.batch.reading import rows
from tests.cli.commands import MODEL, SPACE, orient

FACTS = {
    "actor": "me", "host": "here", "workers": "none", "reason": "test", "settings": "{}", "tool_version": "1",
    "n_photos": 1, "n_done_before": 0,
}  # fmt: skip


@pytest.fixture(scope="session")
def server() -> Iterator[tuple[str, int]]:
    if programs() is None:
        pytest.skip("PostgreSQL is not installed (apt-get install postgresql)")
    with cluster() as running:
        yield running


@pytest.fixture(params=["sqlite", "postgresql"])
def address(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """A summary that does not exist yet: a file, or an empty base of the server."""
    if request.param == "sqlite":
        return str(tmp_path / "summary.db")
    host, port = request.getfixturevalue("server")
    name = f"base{abs(hash(str(tmp_path)))}"
    url = f"postgresql://tester:{quote(PASSWORD, safe='')}@{host}:{port}"
    engine = create_engine(f"{url}/postgres", isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(f"CREATE DATABASE {name}"))
    engine.dispose()
    return f"{url}/{name}"


@pytest.fixture
def summary(address: str) -> Iterator[Summary]:
    opened = open_summary(summary_place(address))
    yield opened
    opened.close()


def asked(summary: Summary, query: str) -> list[dict[str, object]]:
    """As a user asks: a file with any SQLite program (orient itself runs no view of a file)."""
    if "://" not in summary.shown:
        return rows(Path(summary.shown), query)
    with summary._engine.connect() as connection:
        return [dict(row._mapping) for row in connection.execute(text(query))]


@pytest.fixture(scope="session")
def ended(space_project: Path, model_project: Path) -> list[Ending]:
    return work_through([Item(str(space_project)), Item(str(model_project))], Order())


@pytest.fixture(scope="session")
def space_project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("summary") / "space.sqlite"
    assert orient("new", path, "--from", SPACE).code == 0
    return path


@pytest.fixture(scope="session")
def model_project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("summary") / "model.sqlite"
    assert orient("new", path, "--from", MODEL).code == 0
    return path


def test_every_number_is_the_projects(summary: Summary, ended: list[Ending], space_project: Path) -> None:
    summary.store(summary.begin(FACTS), ended)
    (row,) = asked(summary, f"SELECT * FROM orient_latest WHERE path = '{space_project}'")
    with open_project(space_project) as project:
        status, head = standing(project), project.heads()["resection"]
        tables = project.read_tables(head.run_id)
    found = tables["orientation"][0]
    for column, value in found.items():
        if column.lower() in row:
            assert row[column.lower()] == value, column
    for angle in tables["orientation_angle"]:
        if (angle["triple"], angle["frame"]) == ("aok", "ground"):
            assert row[f"{angle['angle']}_deg"] == angle["value_deg"]
            assert row[f"sigma_{angle['angle']}_deg"] == angle["sigma_deg"]
    seen = [entry for entry in tables["image_residual"] if entry["role"] == "control"]
    for axis in "xy":  # the order of summing may differ from SQLite's: 1e-15 of a few micrometres
        rms = math.sqrt(math.fsum(float(entry[f"v{axis}_mm"] or 0) ** 2 for entry in seen) / len(seen))
        assert row[f"rms_{axis}_mm"] == pytest.approx(rms, rel=1e-12)
    assert (row["verdict"], row["sentence"]) == (status.verdict.word, status.verdict.sentence)
    severities = Counter(finding.severity for finding in status.findings)
    assert (row["n_errors"], row["n_warnings"], row["n_notes"]) == tuple(
        severities[word] for word in ("error", "warning", "info")
    )
    assert sum(int(str(one["n"])) for one in asked(summary, _of("orient_finding", row))) == len(status.findings)


def test_full_matrix_and_digests(summary: Summary, ended: list[Ending], space_project: Path) -> None:
    summary.store(summary.begin(FACTS), ended)
    (row,) = asked(summary, f"SELECT * FROM orient_latest WHERE path = '{space_project}'")
    with open_project(space_project) as project:
        heads = project.heads()
        tables = project.read_tables(heads["resection"].run_id)
    cofactors = {(one["unknowns"], one["i"], one["j"]): one for one in tables["cofactor"]}
    stored = asked(summary, _of("orient_covariance", row))
    assert len(stored) == 2 * 21
    for one in stored:
        meant = cofactors[one["unknowns"], one["i"], one["j"]]
        assert (one["unknown_i"], one["unknown_j"]) == (meant["unknown_i"], meant["unknown_j"])
        assert one["cofactor"] == meant["value"]
        assert one["covariance"] == float(str(row["variance_scale"])) * float(str(meant["value"]))
    x, y = (next(float(str(one["covariance"])) for one in stored if one["unknown_i"] == one["unknown_j"] == name)
            for name in ("X_S", "Y_S"))  # fmt: skip
    assert (row["sigma_x_s_m"], row["sigma_y_s_m"]) == (math.sqrt(x), math.sqrt(y))
    stages = {str(one["stage"]): one for one in asked(summary, _of("orient_stage", row))}
    assert set(stages) == set(heads)
    for stage, head in heads.items():
        one = stages[stage]
        assert (one["version"], one["input_digest"], one["output_digest"]) == (
            head.version, head.input_digest, head.output_digest
        )  # fmt: skip
        assert json.loads(str(one["settings"])) == dict(head.settings)


def test_model_without_a_photo_has_its_verdict(summary: Summary, ended: list[Ending], model_project: Path) -> None:
    summary.store(summary.begin(FACTS), ended)
    (row,) = asked(summary, f"SELECT * FROM orient_latest WHERE path = '{model_project}'")
    assert (row["exit_code"], row["x_s_m"], row["resection_version"]) == (0, None, None)
    (stage,) = asked(summary, _of("orient_stage", row) + " AND stage = 'absolute'")
    with open_project(model_project) as project:
        assert stage["output_digest"] == project.heads()["absolute"].output_digest


def _of(table: str, row: dict[str, object]) -> str:
    return f"SELECT * FROM {table} WHERE photo_id = {row['photo_id']}"


def test_a_photo_that_ends_twice_has_one_row(summary: Summary, ended: list[Ending]) -> None:
    batch = summary.begin(FACTS)
    summary.store(batch, ended)
    summary.store(batch, ended)
    counts = asked(summary, "SELECT count(*) AS n, count(DISTINCT path) AS paths FROM orient_photo")
    assert counts == [{"n": 2, "paths": 2}]
    (covariances,) = asked(summary, "SELECT count(*) AS n FROM orient_covariance")
    assert covariances["n"] == 2 * 21


def test_the_latest_batch_counts(summary: Summary) -> None:
    for code in (1, 0):
        summary.store(summary.begin(FACTS), [Ending("/p", code, "because" * code)])
    assert [row["exit_code"] for row in asked(summary, "SELECT exit_code FROM orient_latest")] == [0]
    assert [row["exit_code"] for row in asked(summary, "SELECT exit_code FROM orient_photo ORDER BY batch_id")] == [
        1,
        0,
    ]
    assert {path: done.exit_code for path, done in summary.done().items()} == {"/p": 0}


def test_a_chunk_is_stored_whole_or_not_at_all(summary: Summary) -> None:
    batch = summary.begin(FACTS)
    broken = Ending("/b", 0, stages=[{"stage": None}])
    with pytest.raises((ProjectError, OrientError)):
        summary.store(batch, [Ending("/a", 0), broken])
    assert asked(summary, "SELECT * FROM orient_photo") == []
    summary.store(batch, [Ending("/a", 0)])


def test_names_and_words_that_databases_refuse(summary: Summary) -> None:
    strange = os.fsdecode(b"/photos/\xff\n'\".sqlite")
    summary.store(summary.begin(FACTS), [Ending(strange, 1, "zero \0 byte and half \ud800 a letter")])
    (row,) = asked(summary, "SELECT path, error FROM orient_photo")
    assert row == {"path": "/photos/\\xff\n'\".sqlite", "error": "zero  byte and half \\ud800 a letter"}
    assert list(summary.done()) == [row["path"]]


def test_batch_on_a_server_hides_the_password(address: str, projects: Path) -> None:
    said = orient("batch", projects, "--workers", "0", "--summary", address)
    assert (said.code, said.err) == (0, "")
    assert quote(PASSWORD, safe="") not in said.out
    assert PASSWORD not in said.out
    again = orient("batch", projects, "--workers", "0", "--summary", address)
    assert "Nothing to do" in again.out


def test_a_new_file_is_its_owners(tmp_path: Path) -> None:
    open_summary(summary_place(str(tmp_path / "s.db"))).close()
    assert stat.S_IMODE((tmp_path / "s.db").stat().st_mode) == 0o600
    assert [path.name for path in tmp_path.iterdir()] == ["s.db"]


def test_foreign_files_are_left_as_they_are(space_project: Path, tmp_path: Path) -> None:
    other = tmp_path / "text.db"
    other.write_text("something else")
    for path in (space_project, other):
        before = path.read_bytes()
        with pytest.raises(ProjectError, match="is not a summary of orient batch"):
            open_summary(summary_place(str(path)))
        assert path.read_bytes() == before


@pytest.mark.parametrize(
    ("place", "kind", "said"),
    [
        ("nowhere://host/base", UsageError, "no such database"),
        ("", UsageError, "needs the name of a file"),
        ("sqlite://", UsageError, "needs the name of a file"),
        ("postgresql://me:secret@127.0.0.1:1/base", ProjectError, "cannot be used"),
        ("oracle://me:secret@127.0.0.1:1/base", UsageError, "needs the package"),
        ("postgresql://me:secret@host:port/base", UsageError, "cannot be read"),
    ],
    ids=["unknown database", "empty", "no file", "no server", "no driver", "bad URL"],
)
def test_a_summary_that_cannot_be_used(place: str, kind: type[OrientError], said: str) -> None:
    with pytest.raises(kind) as refused:
        open_summary(summary_place(place))
    assert said in refused.value.message
    assert "secret" not in refused.value.message + refused.value.hint


def test_another_format_is_refused(address: str, summary: Summary) -> None:
    with summary._engine.begin() as connection:
        connection.execute(text("UPDATE orient_summary SET version = 99"))
    with pytest.raises(ProjectError, match="another version of orient"):
        open_summary(summary_place(address))
