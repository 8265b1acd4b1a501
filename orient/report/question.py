"""A ready-made question, and what is filled in to ask it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from orient.errors import UsageError

PLACE = re.compile(r"'(?:[^']|'')*'|\"[^\"]*\"|--[^\n]*|/\*.*?\*/|[:@$](\w+)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Parameter:
    """Something to fill in; `default` holds where nothing is said."""

    name: str
    meaning: str
    default: str = ""


@dataclass(frozen=True, slots=True)
class Question:
    """A question with a plain name, in SQL over the shipped views. Parameters are bound as text.

    `brief`: the columns of a short answer; `nothing`: what it means that there are no rows.
    """

    name: str
    asks: str
    sql: str
    parameters: tuple[Parameter, ...] = ()
    brief: tuple[str, ...] = ()
    nothing: str = "no rows"


def filled(question: Question, given: Mapping[str, str]) -> dict[str, str]:
    """Every parameter of the question: as given, else its default. `UsageError` for one that it does not have."""
    known = {parameter.name: parameter.default for parameter in question.parameters}
    for name in given:
        if name not in known:
            has = f"It has: {', '.join(known)}." if known else "It has none."
            raise UsageError(f'the question "{question.name}" has no parameter "{name}"', has)
    return {**known, **given}


def filled_sql(sql: str, given: Mapping[str, str]) -> dict[str, str]:
    """The parameters of free SQL, all of them and no others."""
    wanted = list(dict.fromkeys(name for name in PLACE.findall(sql) if name))
    for name in wanted:
        if name not in given:
            raise UsageError(f"the SQL asks for :{name}", f"Say what it is: --set {name}=VALUE")
    for name in given:
        if name not in wanted:
            raise UsageError(f"the SQL has no place :{name}", "Write :NAME in the SQL where the value belongs.")
    return dict(given)


def settings_of(pairs: list[str]) -> dict[str, str]:
    """`NAME=VALUE` each; the value is taken as it is, also when it is empty or contains another =."""
    found: dict[str, str] = {}
    for pair in pairs:
        name, sign, value = pair.partition("=")
        if not sign or not re.fullmatch(r"\w+", name):
            raise UsageError(f'--set "{pair}" is not NAME=VALUE', "For example: --set point=P7")
        if name in found:
            raise UsageError(f"--set {name} is given twice", "Give it once.")
        found[name] = value
    return found
