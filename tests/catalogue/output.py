"""F: what comes out of a project whose names a stranger chose: answers, pictures, files.

The names are put into the rows behind orient's back: its own lists refuse most of them (A21).
"""

from collections.abc import Callable

from tests.catalogue.case import PROJECT, Case, Place
from tests.store.test_opening import unguarded

NAMED = "SELECT name FROM photo"
TABLE, CSV, SHOW = ("sql", PROJECT, NAMED), ("sql", PROJECT, NAMED, "--csv"), ("show", PROJECT, "photo")


def named(name: str) -> Callable[[Place], None]:
    """The photo has a name that nobody would type."""

    def before(place: Place) -> None:
        text = "'" + name.replace("'", "''") + "'"
        unguarded(f"UPDATE photo SET name = {text}")(place.take_full())

    return before


def full(place: Place) -> None:
    place.take_full()


def answered(name: str, shown: str, words: tuple[object, ...] = CSV) -> Case:
    return Case(words=words, code=0, says=[shown], before=named(name))


CASES: dict[str, Case] = {
    "F1 =": answered("=1+1", "name\r\n'=1+1\r\n"),
    "F1 +": answered("+cmd|' /C calc'!A0", "name\r\n'+cmd|' /C calc'!A0\r\n"),
    "F1 -": answered("-2+3", "name\r\n'-2+3\r\n"),
    "F1 @": answered("@SUM(A1)", "name\r\n'@SUM(A1)\r\n"),
    "F1 tab": answered("\tx", "name\r\n'\tx\r\n"),
    "F1 return": answered("\rx", 'name\r\n"\'\rx"\r\n'),
    "F1 raw": answered("=1+1", "name\r\n=1+1\r\n", (*CSV, "--raw")),
    "F2 quote": answered('a "b", c', 'name\r\n"a ""b"", c"\r\n'),
    "F2 new line": answered("a\nb", 'name\r\n"a\nb"\r\n'),
    "F8 escape": answered("\x1b[31mred", "\\x1b[31mred", SHOW),
    "F8 bell": answered("\x07", "\\x07", TABLE),
    "F8 bidi": answered("a\u202eb", "a\\u202eb", SHOW),
    "F8 one line": answered("a\nb", "a\\nb", TABLE),
    "F8 return": answered("a\rb", "a\\rb", TABLE),
    "F12 infinity": Case(
        words=("sql", PROJECT, "SELECT 9e999 AS a, -9e999 AS b", "--json"),
        code=0,
        says=['"a": "inf"', '"b": "-inf"'],
        before=full,
    ),
    "F14 numbers": Case(
        words=("sql", PROJECT, "SELECT 0.1 + 0.2, 1e300, 5e-324, 1e20", "--csv"),
        code=0,
        says=["0.30000000000000004,1e+300,5e-324,1e+20"],
        before=full,
    ),
}
