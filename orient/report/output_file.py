"""Files that a command writes for the user: whole or not at all, never over something by accident."""

import os
import stat
from collections.abc import Iterable, Sequence
from pathlib import Path

from orient.errors import OrientError, UsageError
from orient.store.errors import ReadOnly
from orient.store.new_file import SIDE_FILES, give_name, name_in_folder, temporary_file

STDOUT = "-"
"""Instead of a name: the standard output."""
NOTHING = "Nothing was written; choose another folder."


def output_path(text: str, project: Path, force: bool) -> Path:
    """The absolute path of a file that may be written; a `UsageError` says why it may not.

    Call it before anything is computed. A link is replaced, never written through. The project, its side files, folders
    and devices are refused even with force.
    """
    target = name_in_folder(text, "the output")
    if _is_own_input(target, project):
        raise UsageError(f"{text}: the output would overwrite its own input", "Give another name.")
    if not os.path.lexists(target):
        return target
    mode = target.lstat().st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISLNK(mode)):
        raise UsageError(f"{text} is not a file", "Give the name of a file.")
    if not force:
        raise UsageError(f"{text} exists", "Use --force, or give another name.")
    return target


def ending_of(name: str, endings: Sequence[str], what: str) -> str:
    """The ending of the name, in small letters; a `UsageError` unless it is one of those that `what` may have."""
    ending = Path(name).suffix.lower()
    if ending not in endings:
        raise UsageError(f'"{name}": the name of a {what} ends in {" or ".join(endings)}')
    return ending


def write_output(target: Path, content: bytes | Iterable[bytes], project: Path, force: bool) -> None:
    """Write `content` (or its parts) beside `target`, then give it its name; no more readable than the project."""
    mode = stat.S_IMODE(project.stat().st_mode) & 0o666
    try:
        with temporary_file(target.parent, mode) as temporary:
            with temporary.open("wb") as file:
                file.writelines([content] if isinstance(content, bytes) else content)
                file.flush()
                os.fsync(file.fileno())
            give_name(temporary, target, replace=force)
    except FileExistsError:
        raise UsageError(f"{target} exists", "Use --force, or give another name.") from None
    except ReadOnly as error:
        raise OrientError(error.message, NOTHING) from None
    except OSError as error:
        raise OrientError(f"{target} cannot be written: {error.strerror}", NOTHING) from None


def _is_own_input(target: Path, project: Path) -> bool:
    own = Path(os.path.abspath(project))  # noqa: PTH100
    names = {own.with_name(own.name + side) for side in ("", *SIDE_FILES)}
    real = Path(os.path.realpath(own))  # not resolve(): it fails on a loop of links
    names |= {real.with_name(real.name + side) for side in ("", *SIDE_FILES)}
    if target in names or Path(os.path.realpath(target)) in names:
        return True
    return target.exists() and project.exists() and target.samefile(project)
