"""Names of files that are handed in, as paths, or one clear sentence why not."""

import os
from pathlib import Path

from orient.errors import UsageError
from orient.store.new_file import absolute

PathLike = str | os.PathLike[str]


def path_of(given: PathLike, what: str) -> Path:
    """The path; whether there is a file is seen by who opens or makes it."""
    name = os.fspath(given) if isinstance(given, str | os.PathLike) else None
    if not isinstance(name, str):
        raise UsageError(f"the name of {what} is no text", "Give a text or a pathlib.Path.")
    if not name or "\0" in name:
        raise UsageError(f"the name of {what} is empty or contains a zero byte", "Give another name.")
    try:
        os.fsencode(absolute(name))
    except UnicodeEncodeError:
        raise UsageError(f"the name of {what} has letters that no file can have", "Give another name.") from None
    return Path(name)
