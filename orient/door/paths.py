"""Names of files that are handed in, as paths, or one clear sentence why not."""

import os
from pathlib import Path

from orient.errors import UsageError

PathLike = str | os.PathLike[str]


def path_of(given: PathLike, what: str) -> Path:
    """The path; whether there is a file is seen by who opens or makes it."""
    name = os.fspath(given) if isinstance(given, str | os.PathLike) else None
    if not isinstance(name, str):
        raise UsageError(f"the name of {what} is no text", "Give a text or a pathlib.Path.")
    if not name or "\0" in name:
        raise UsageError(f"the name of {what} is empty or contains a zero byte", "Give another name.")
    try:
        os.fsencode(os.path.abspath(name))  # noqa: PTH100  (this is what the floors below do)
    except UnicodeEncodeError:
        raise UsageError(f"the name of {what} has letters that no file can have", "Give another name.") from None
    except FileNotFoundError:
        raise UsageError("the current folder is gone", "Change to another one, or give absolute names.") from None
    return Path(name)
