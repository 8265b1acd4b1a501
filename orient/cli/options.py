"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

from orient.errors import UsageError
from orient.pipeline.reasons import check_reason


def _project_path(name: str) -> Path:
    if not name:
        raise UsageError("the name of the project is empty", "Give the name of a file.")
    return Path(name)


def valid_text(text: str) -> str:
    """A text for the project; bytes that are no text cannot be stored or asked for."""
    if not text.isascii() and any("\ud800" <= letter <= "\udfff" for letter in text):
        raise UsageError("an argument is not valid text (UTF-8)", "Write it in the encoding of your terminal.")
    return text


def reason_text(text: str) -> str:
    """A reason that `log` can show."""
    check_reason(text)
    return text


ProjectPath = Annotated[
    Path, typer.Argument(metavar="PROJECT", parser=_project_path, help="The project file, one per photo.")
]
Reason = Annotated[
    str,
    typer.Option("--message", "-m", callback=reason_text, help="Why, in your words; it is kept with the version."),
]
Again = Annotated[bool, typer.Option("--again", help="Compute (or store) again even if nothing has changed.")]
AsJson = Annotated[bool, typer.Option("--json", help="Answer as JSON, with all digits, for programs.")]
Force = Annotated[bool, typer.Option("--force", help="Replace the file if it exists.")]
Language = Annotated[
    str, typer.Option("--language", metavar="en|bg|uk|ru", callback=valid_text, help="Language of the words in it.")
]
