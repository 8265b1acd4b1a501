"""What Datasette tells about the tables: the texts of docs/schema.md, units, and the questions as ready queries."""

import inspect
import re
from typing import Any

from orient.report.audit_questions import AUDIT_QUESTIONS
from orient.report.question import Question
from orient.report.questions import QUESTIONS
from orient.store.views import view_texts

DATABASE = "project"
UNITS = {
    "_mm_m": "mm/m", "_mm2": "mm^2", "_m2": "m^2", "_mm": "mm", "_m": "m", "_deg": "deg", "_px": "px",
}  # fmt: skip
"""Unit by the end of a column's name, the longest first."""
CLAUSE = re.compile(r" (FROM|JOIN|WHERE|AND|GROUP BY|ORDER BY) ")
"""Where the SQL of a question is broken into lines."""


def metadata(title: str, about: str, source: str, licence: str) -> dict[str, Any]:
    """Title, source and licence of the project; description, columns and units of each table; the ready queries."""
    told = {"title": title, "description": about}
    if source:
        told["source"] = source
    if licence:
        told["license"] = licence
    database = {
        "description": "Read-only copy of the project as it was when this server started; tables: docs/schema.md.",
        "tables": {**_views(), **_tables()},
        "queries": {question.name: _query(question) for question in reviewer_first()},
    }
    return {**told, "databases": {DATABASE: {**told, **database}}}


def reviewer_first() -> list[Question]:
    """All ready questions, those of `orient audit` before the others."""
    return sorted(QUESTIONS, key=lambda question: question not in AUDIT_QUESTIONS)


def _views() -> dict[str, Any]:
    return {
        view.name: {
            "description": view.question,
            "columns": {name: with_unit(name, text) for name, text in view.columns.items()},
        }
        for view in view_texts()
    }


def _tables() -> dict[str, Any]:
    from orient.models import Base

    return {
        str(mapper.class_.__tablename__): {
            "description": inspect.cleandoc(mapper.class_.__doc__ or ""),
            "columns": {
                column.name: with_unit(column.name, column.comment or "") for column in mapper.class_.__table__.columns
            },
        }
        for mapper in Base.registry.mappers
    }


def _query(question: Question) -> dict[str, Any]:
    fills = "".join(
        f"\n:{one.name} - {one.meaning}{f' (empty: {one.default})' if one.default else ''}"
        for one in question.parameters
    )
    sql = CLAUSE.sub(r"\n\1 ", question.sql)
    return {"sql": sql, "title": f"{question.name}: {question.asks}", "description": question.asks + fills}


def with_unit(name: str, meaning: str) -> str:
    """The meaning of a column and its unit, which its name ends in."""
    unit = next((unit for end, unit in UNITS.items() if re.search(rf"{end}$", name)), "")
    return f"{meaning} [{unit}]" if unit else meaning
