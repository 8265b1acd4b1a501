"""`orient audit`: in the terminal, and as a real server on the loopback interface."""

import json
import re
import shutil
import signal
import sqlite3
import stat
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from urllib.parse import urlencode

import pytest

from orient.report.audit_questions import AUDIT_QUESTIONS
from orient.report.questions import QUESTIONS
from tests.cli.commands import orient, start, without

ADDRESS = re.compile(r"http://127\.0\.0\.1:(\d+)/")
DEADLINE_S = 60


# ------------------------------------------------------------------------------- terminal


def test_the_terminal_answers_ten_questions(aerial: Path) -> None:
    said = orient("audit", aerial)
    assert (said.code, said.err) == (0, "")
    numbered = re.findall(r"^(\d+)\. (.+)$", said.out, re.MULTILINE)
    assert numbered == [(str(i), question.asks) for i, question in enumerate(AUDIT_QUESTIONS, 1)]
    assert len(numbered) == 10
    assert "Nobody: the newest result of each stage is current." in said.out
    assert re.search(r"\.\.\. 16 in all: orient sql .* moved-most", said.out)


def test_a_project_without_results_has_answers_too(fresh: Path) -> None:
    said = orient("audit", fresh)
    assert (said.code, said.err) == (0, "")
    assert "No orientation yet" in said.out
    assert "There is no check point" in said.out


def test_every_question_has_a_short_form_of_columns_that_exist(space: Path) -> None:
    for question in AUDIT_QUESTIONS:
        rows = json.loads(orient("sql", space, question.name, "--json").out)
        assert question.brief and (not rows or set(question.brief) <= set(rows[0])), question.name


@pytest.mark.parametrize("words", [(), ("--serve", "--port", "0")], ids=["terminal", "server"])
def test_what_does_not_pass_the_gate_is_not_shown(aerial: Path, tmp_path: Path, words: tuple[str, ...]) -> None:
    hostile, damaged, stranger = (tmp_path / f"{name}.sqlite" for name in ("hostile", "damaged", "stranger"))
    shutil.copy(aerial, hostile)
    with closing(sqlite3.connect(hostile)) as connection:
        connection.execute("CREATE VIEW v_evil AS SELECT load_extension('x')")
        connection.commit()
    stranger.write_text("<html>")
    assert orient("audit", hostile, *words).code == 3
    assert orient("audit", stranger, *words).code == 3
    assert orient("audit", tmp_path / "missing.sqlite", *words).code == 2
    if words:  # a number changed by hand: only the digests of the copy show it
        shutil.copy(aerial, damaged)
        _change_a_number(damaged)
        said = orient("audit", damaged, *words)
        assert (said.code, said.out) == (3, "")
        assert "altered after the seal" in said.err
    assert not (tmp_path / "missing.sqlite").exists()


def _change_a_number(path: Path) -> None:
    with closing(sqlite3.connect(path)) as connection:
        (text,) = connection.execute(
            "SELECT sql FROM sqlite_schema WHERE name = 'guard_control_point_update'"
        ).fetchone()
        connection.execute("DROP TRIGGER guard_control_point_update")
        connection.execute("UPDATE control_point SET X_m = X_m + 0.001 WHERE point = '102'")
        connection.execute(text)
        connection.commit()


# ------------------------------------------------------------------------------- server

datasette = pytest.mark.skipif(
    subprocess.run([sys.executable, "-c", "import datasette"], capture_output=True, check=False).returncode != 0,
    reason="Datasette is not installed: pip install 'orient[audit]'",
)


@contextmanager
def served(path: Path, temporary: Path, *words: str) -> Iterator[tuple[str, "subprocess.Popen[bytes]"]]:
    """The address of a running server, and its process; it is ended by SIGTERM."""
    temporary.mkdir(exist_ok=True)
    child = start("audit", path, "--serve", "--port", "0", *words, env={"TMPDIR": str(temporary)})
    assert child.stdout is not None
    try:
        lines = [child.stdout.readline().decode() for _ in range(3)]
        found = ADDRESS.search("".join(lines))
        assert found, child.stderr.read().decode() if child.stderr else lines
        yield found[0], child
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGTERM)
        child.communicate(timeout=DEADLINE_S)


def get(address: str, **headers: str) -> tuple[int, str]:
    request = urllib.request.Request(address, headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=DEADLINE_S) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


@pytest.fixture(scope="session")
def server(space_once: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path]]:
    folder = tmp_path_factory.mktemp("served")
    path = Path(shutil.copy(space_once, folder / "space.sqlite"))
    words = ("--source", "simulated", "--licence", "CC0")
    with served(path, folder / "tmp", *words) as (address, _):
        yield address, path


@datasette
def test_the_pages_have_titles_descriptions_and_units(server: tuple[str, Path]) -> None:
    address, _ = server
    code, index = get(address)
    assert code == 200
    assert "orient: simulated-space-krasovsky" in index
    assert "Oriented" in index
    code, page = get(f"{address}project/image_point")
    assert code == 200
    assert "each correction in its own column" in page
    assert "correction for lens distortion [mm]" in page
    assert "covariance of x, y [mm^2]" in page
    code, page = get(f"{address}project")
    assert "simulated" in page and "CC0" in page
    for question in QUESTIONS:
        assert f"/project/{question.name}" in page
    first = min(page.index(f'"/project/{question.name}"') for question in QUESTIONS)
    assert page.index(f'"/project/{AUDIT_QUESTIONS[0].name}"') == first


@datasette
def test_nothing_on_the_pages_comes_from_outside(server: tuple[str, Path]) -> None:
    address, _ = server
    for place in ("", "project", "project/image_point", "project/moved-most"):
        page = get(f"{address}{place}")[1]
        loaded = re.findall(r'<(?:script|link|img|iframe)[^>]*(?:src|href)="([^"]+)"', page)
        assert [one for one in loaded if not one.startswith(("/", address, "data:"))] == []


@datasette
@pytest.mark.parametrize("question", QUESTIONS, ids=lambda question: question.name)
def test_every_ready_query_answers_as_orient_sql(server: tuple[str, Path], question: object) -> None:
    address, path = server
    name = question.name  # type: ignore[attr-defined]
    code, text = get(f"{address}project/{name}.json?_shape=array")
    assert code == 200, text
    assert json.loads(text) == json.loads(orient("sql", path, name, "--json").out)


@datasette
def test_ready_queries_take_what_is_filled_in(server: tuple[str, Path]) -> None:
    address, path = server
    for name, given in {"moved-most": {"element": "Z_S"}, "version-change": {"stage": "covariance"}}.items():
        text = get(f"{address}project/{name}.json?{urlencode({'_shape': 'array', **given})}")[1]
        sets = [word for pair in given.items() for word in ("--set", "=".join(pair))]
        assert json.loads(text) == json.loads(orient("sql", path, name, *sets, "--json").out) != []


@datasette
def test_it_is_for_this_machine_and_for_reading_only(server: tuple[str, Path]) -> None:
    address, path = server
    before = path.read_bytes()
    assert get(address, Host="evil.example")[0] == 403
    assert get(f"{address}project.db")[0] == 403
    assert get(f"{address}project/image_point.csv?_stream=on")[0] >= 400
    for sql in (
        "DELETE FROM stage_run",
        "PRAGMA writable_schema = 1",
        "ATTACH 'x.db' AS x",
        "SELECT load_extension('x')",
    ):
        assert get(f"{address}project.json?{urlencode({'sql': sql})}")[0] >= 400, sql
    endless = "WITH RECURSIVE n(i) AS (VALUES (1) UNION ALL SELECT i + 1 FROM n) SELECT max(i) FROM n"
    assert get(f"{address}project.json?{urlencode({'sql': endless, '_timelimit': 300})}")[0] >= 400
    assert path.read_bytes() == before
    assert sorted(entry.name for entry in path.parent.iterdir()) == ["space.sqlite", "tmp"]


@datasette
def test_the_copy_is_private_and_listens_on_loopback_only(server: tuple[str, Path]) -> None:
    address, path = server
    (folder,) = (path.parent / "tmp").iterdir()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert [entry.name for entry in folder.iterdir()] == ["project.sqlite"]
    port = int(ADDRESS.search(address)[1])  # type: ignore[index]
    listening = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    hosts = {row[1].split(":")[0] for row in listening if row[3] == "0A" and int(row[1].split(":")[1], 16) == port}
    assert hosts == {"0100007F"}


@datasette
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=lambda number: number.name)
def test_a_signal_ends_it_and_leaves_nothing(aerial: Path, tmp_path: Path, number: signal.Signals) -> None:
    temporary, before = tmp_path / "tmp", aerial.read_bytes()
    with served(aerial, temporary) as (address, child):
        assert get(address)[0] == 200
        assert get(f"{address}project.json?sql=DELETE")[0] == 400
        assert orient("resection", aerial, "--again", "-m", "others go on").code == 0
        child.send_signal(number)
        out, err = child.communicate(timeout=DEADLINE_S)
    assert (child.returncode, err) == (0, b"")
    assert out == b"stopped; the copy is removed\n"  # the first lines were read for the address; nothing between
    assert list(temporary.iterdir()) == []
    assert aerial.read_bytes() != before  # by the other command alone
    assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith(aerial.name)] == [aerial.name]


@datasette
def test_downloads_only_when_asked(aerial: Path, tmp_path: Path) -> None:
    with served(aerial, tmp_path / "tmp", "--downloads") as (address, _):
        request = urllib.request.urlopen(f"{address}project.db", timeout=DEADLINE_S)
        (tmp_path / "copy.sqlite").write_bytes(request.read())
    assert orient("check", tmp_path / "copy.sqlite").code == 0


@datasette
def test_a_port_in_use_is_one_sentence(aerial: Path, tmp_path: Path) -> None:
    with served(aerial, tmp_path / "tmp") as (address, _):
        port = ADDRESS.search(address)[1]  # type: ignore[index]
        said = orient("audit", aerial, "--serve", "--port", port)
    assert (said.code, said.out) == (1, "")
    assert f"port {port} cannot be used" in said.err


def test_without_datasette_the_command_says_what_to_install(aerial: Path) -> None:
    said = without("datasette", "audit", aerial, "--serve")
    assert (said.returncode, said.stdout) == (2, "")
    assert "pip install 'orient[audit]'" in said.stderr
