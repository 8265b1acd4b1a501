"""Arguments that several commands share."""

import os
from pathlib import Path
from typing import Annotated

import typer

from orient.errors import UsageError
from orient.pipeline.reasons import check_reason
from orient.words import is_valid

SEPARATORS = tuple(separator for separator in (os.sep, os.altsep) if separator)


def project_path(name: str) -> Path:
    if not name:
        raise UsageError("the name of the project is empty", "Give the name of a file.")
    if name.endswith(SEPARATORS):
        raise UsageError(f"{name} is the name of a folder", "Give the name of a file.")
    path = Path(name)
    if not path.is_absolute():
        _require_current_folder(name)
    return path


def _require_current_folder(name: str) -> None:
    try:
        Path.cwd()
    except OSError as error:
        told = f"{name}: there is no current folder any more ({error.strerror})"
        raise UsageError(told, "Go to another folder first: cd FOLDER") from None


def valid_text(text: str) -> str:
    """A text for the project; bytes that are no text cannot be stored or asked for."""
    if not is_valid(text):
        raise UsageError("an argument is not valid text (UTF-8)", "Write it in the encoding of your terminal.")
    return text


def reason_text(text: str) -> str:
    """A reason that `log` can show."""
    check_reason(text)
    return text


ProjectPath = Annotated[
    Path, typer.Argument(metavar="PROJECT", parser=project_path, help="The project file, one per photo.")
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
