"""The language of reports and pictures: gettext catalogues as .po files in the package, read when they are asked for.

Messages are English sentences with named fields in braces; numbers keep the point in every language. What is recorded
in a project (names, reasons, remarks of a run) is shown as it is.
"""

import gettext
import io
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from importlib.resources import files
from importlib.util import find_spec

from orient.errors import NotInstalled, UsageError

ENGLISH = "en"
LANGUAGES = {"en": "English", "bg": "Български", "uk": "Українська", "ru": "Русский"}

_spoken: ContextVar[str] = ContextVar("spoken", default=ENGLISH)


def tr(message: str, **fields: object) -> str:
    """The message in the language that is spoken, its fields filled in."""
    found = _catalogue(_spoken.get()).gettext(message) if message else ""
    return found.format(**fields) if fields else found


def trn(one: str, many: str, n: int, **fields: object) -> str:
    """The form of the message that goes with the number n; `{n}` is a field of it."""
    return _catalogue(_spoken.get()).ngettext(one, many, n).format(n=n, **fields)


def mark(message: str) -> str:
    """A message that stands in a table and is translated where it is used."""
    return message


def spoken() -> str:
    return _spoken.get()


@contextmanager
def speaking(language: str) -> Iterator[None]:
    """Everything inside is said in this language."""
    if language not in LANGUAGES:
        raise UsageError(f'there is no language "{language}"', f"Languages are {', '.join(LANGUAGES)}.")
    if language != ENGLISH and find_spec("babel") is None:
        raise NotInstalled("other languages need", ["babel"], "report")
    token = _spoken.set(language)
    try:
        yield
    finally:
        _spoken.reset(token)


@cache
def _catalogue(language: str) -> gettext.NullTranslations:
    if language == ENGLISH:
        return gettext.NullTranslations()
    from babel.messages.mofile import write_mo
    from babel.messages.pofile import read_po

    source = files("orient.report").joinpath("locale", f"{language}.po").read_bytes()
    compiled = io.BytesIO()
    write_mo(compiled, read_po(io.BytesIO(source), locale=language))
    compiled.seek(0)
    return gettext.GNUTranslations(compiled)
