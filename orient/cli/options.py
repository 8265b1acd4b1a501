"""Arguments that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

ProjectPath = Annotated[Path, typer.Argument(metavar="PROJECT", help="The project file, one per photo.")]
Reason = Annotated[str, typer.Option("--message", "-m", help="Why, in your words; it is kept with the version.")]
Again = Annotated[bool, typer.Option("--again", help="Compute (or store) again even if nothing has changed.")]
AsJson = Annotated[bool, typer.Option("--json", help="Answer as JSON, with all digits, for programs.")]
