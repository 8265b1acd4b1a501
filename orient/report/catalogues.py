"""Brings the catalogues of messages up to date: `python -m orient.report.catalogues` (a developer's tool, needs babel).

Every message that the code can say is in orient/report/locale/*.po, and nothing else; a new one comes in without a
translation, and a test fails until it has one.
"""

import io
from collections.abc import Iterator
from contextlib import redirect_stderr
from datetime import UTC, datetime
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract
from babel.messages.pofile import read_po, write_po

from orient.report.findings import REMEDIES
from orient.report.language import ENGLISH, LANGUAGES

FOLDER = Path(__file__).with_name("locale")
CODE = Path(__file__).parent
KEYWORDS = {"tr": None, "mark": None, "trn": (1, 2)}
MADE = datetime(2026, 1, 1, tzinfo=UTC)
"""A catalogue holds no date of its own: the same messages give the same file."""
TEMPLATE_WORDS = ("Contents",)
Message = str | tuple[str, ...]


def messages() -> Iterator[Message]:
    """All messages of code, template and remedies, in the order in which they stand there."""
    for path in sorted(CODE.rglob("*.py")):
        with redirect_stderr(io.StringIO()):  # it complains of f-strings in the fields of a message
            found = list(extract("python", io.BytesIO(path.read_bytes()), keywords=KEYWORDS))
        yield from (message for _, message, *_ in found if message)
    yield from TEMPLATE_WORDS
    yield from REMEDIES.values()


def catalogue(language: str) -> Catalog:
    """The catalogue as it is in the package; an empty one for a new language."""
    path = FOLDER / f"{language}.po"
    return read_po(io.BytesIO(path.read_bytes()), locale=language) if path.exists() else Catalog(locale=language)


def updated(language: str) -> bytes:
    """The file with the messages of today and the translations that were there."""
    old = catalogue(language)
    new = Catalog(
        locale=language, project="orient", version="report", creation_date=MADE, revision_date=MADE, charset="utf-8"
    )
    for message in dict.fromkeys(messages()):
        known = old.get(message if isinstance(message, str) else message[0])
        new.add(message, known.string if known else None)
    stream = io.BytesIO()
    write_po(stream, new, width=120, omit_header=False, no_location=True)
    return stream.getvalue()


def main() -> None:
    for language in LANGUAGES:
        if language != ENGLISH:
            (FOLDER / f"{language}.po").write_bytes(updated(language))


if __name__ == "__main__":
    main()
