"""`orient audit`: the reviewer's questions with their answers in short."""

from pathlib import Path
from typing import TYPE_CHECKING

from orient.report.audit_questions import AUDIT_QUESTIONS
from orient.report.question import Question, filled
from orient.report.text import cell, console, one_line, print_table, printable
from orient.values import Scalar
from orient.words import typed

if TYPE_CHECKING:
    from orient.store.project import Project

SHOWN = 5
DIGITS = 4
LONGEST = 72


def show_audit(path: Path) -> None:
    """Every question of `AUDIT_QUESTIONS` to the project as it is now."""
    from orient.report.status import standing
    from orient.store.project import open_project

    out = console()
    with open_project(path, "read") as project, project.snapshot():
        out.print(f"{printable(str(path))}: {standing(project).verdict.sentence}", soft_wrap=True)
        for number, question in enumerate(AUDIT_QUESTIONS, 1):
            out.print(f"\n{number}. {question.asks}", soft_wrap=True)
            _print_answer(project, question, path)


def _print_answer(project: "Project", question: Question, path: Path) -> None:
    columns, rows = project.query(question.sql, filled(question, {}))
    out = console()
    if not rows:
        out.print(f"   {question.nothing}")
        return
    at = [columns.index(name) for name in question.brief]
    shown = [[_short(row[i]) for i in at] for row in rows[:SHOWN]]
    numeric = [any(isinstance(row[i], int | float) for row in rows) for i in at]
    print_table([one_line(name) for name in question.brief], shown, numeric)
    if len(rows) > SHOWN:
        out.print(f"   ... {len(rows)} in all: orient sql {printable(typed(path))} {question.name}", soft_wrap=True)


def _short(value: Scalar) -> str:
    if isinstance(value, float):
        return f"{value:.{DIGITS}g}"
    text = cell(value)
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
