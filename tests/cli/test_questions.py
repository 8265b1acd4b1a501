"""`orient sql`: named questions, free questions, nothing else."""

import csv
import io
import json
from pathlib import Path

import pytest

from orient.report.questions import QUESTIONS
from orient.store.project import open_project
from tests.cli.commands import orient

MAY_BE_EMPTY = {"stale", "verification", "went-back", "version-change"}


@pytest.mark.parametrize("question", QUESTIONS, ids=lambda question: question.name)
def test_each_named_question_has_an_answer(space: Path, model: Path, question: object) -> None:
    name = question.name  # type: ignore[attr-defined]
    path = model if "absolute" in name or "model" in name else space
    said = orient("sql", path, name, "--json")
    assert (said.code, said.err) == (0, "")
    assert name in MAY_BE_EMPTY or json.loads(said.out)
    assert orient("sql", path, name).code == 0


REFUSED = {
    "delete": ("DELETE FROM stage_run", "Only questions are allowed"),
    "drop": ("DROP TABLE stage_run", "Only questions are allowed"),
    "pragma": ("PRAGMA user_version = 7", "Only questions are allowed"),
    "attach": ("ATTACH 'x.db' AS x", "Only questions are allowed"),
    "write in WITH": ("WITH a AS (SELECT 1) DELETE FROM stage_run", "Only questions are allowed"),
    "two statements": ("SELECT 1; SELECT 2", "SQL: "),
    "second one writes": ("SELECT 1; DELETE FROM stage_run", "SQL: "),
    "unknown table": ("SELECT * FROM nowhere", "no such table: nowhere"),
    "unknown column": ("SELECT nowhere FROM v_current", "no such column: nowhere"),
    "syntax": ("SELECT FROM WHERE", "SQL: "),
    "unknown name": ("residual", 'there is no question "residual"'),
    "load_extension": ("SELECT load_extension('x')", ""),
}


@pytest.mark.parametrize("case", REFUSED)
def test_only_questions_are_answered(aerial: Path, case: str) -> None:
    sql, words = REFUSED[case]
    before = aerial.read_bytes()
    said = orient("sql", aerial, sql)
    assert (said.code, said.out) == (2, "")
    assert words in said.err
    assert aerial.read_bytes() == before


def test_csv_and_json_exclude_each_other(aerial: Path) -> None:
    assert orient("sql", aerial, "residuals", "--csv", "--json").code == 2


def test_csv_has_every_digit(aerial: Path) -> None:
    said = orient("sql", aerial, "SELECT point, vx_mm FROM image_residual ORDER BY point", "--csv")
    rows = list(csv.reader(io.StringIO(said.out, newline="")))
    with open_project(aerial) as project:
        _, stored = project.query("SELECT point, vx_mm FROM image_residual ORDER BY point")
    assert [(point, float(value)) for point, value in rows[1:]] == stored
    assert said.out.endswith("\r\n")


STRANGE = ("=1+1", "+cmd", "-2+3", "@SUM(A1)", "\tx", "\rx", 'with "quotes", and comma', "two\nlines")


@pytest.mark.parametrize("raw", [False, True], ids=["guarded", "raw"])
def test_csv_guards_formulas_in_text_cells_and_leaves_numbers(aerial: Path, raw: bool) -> None:
    cells = ", ".join(f"('{name}', -1.5)" for name in STRANGE)
    said = orient("sql", aerial, f"VALUES {cells}", "--csv", *(["--raw"] if raw else []))
    rows = list(csv.reader(io.StringIO(said.out, newline="")))[1:]
    guard = "" if raw else "'"
    assert [name for name, _ in rows] == [*(guard + name for name in STRANGE[:6]), *STRANGE[6:]]
    assert {number for _, number in rows} == {"-1.5"}


VALUES = {
    "infinity": ("SELECT 9e999 AS a", [{"a": "inf"}]),
    "bytes": ("SELECT x'00ff' AS a", [{"a": "00ff"}]),
    "null": ("SELECT NULL AS a", [{"a": None}]),
    "no space": ("VALUES(1)", [{"column1": 1}]),
    "new lines": ("SELECT\n1 AS a", [{"a": 1}]),
    "no rows": ("SELECT 1 AS a WHERE 0", []),
}


@pytest.mark.parametrize("case", VALUES)
def test_any_value_can_be_answered(aerial: Path, case: str) -> None:
    sql, expected = VALUES[case]
    assert json.loads(orient("sql", aerial, sql, "--json").out) == expected
    for style in ([], ["--csv"]):
        assert orient("sql", aerial, sql, *style).code == 0


def test_control_codes_do_not_reach_the_terminal(aerial: Path) -> None:
    said = orient("sql", aerial, "SELECT char(27) || '[31m' || char(10) || 'x' AS a")
    assert "\x1b" not in said.out
    assert "\\x1b[31m" in said.out
