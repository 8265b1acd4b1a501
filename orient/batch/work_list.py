"""Which photos: folders, lists, patterns and single files become one list in which every file stands once."""

import fnmatch
import glob
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from orient.batch.values import Item, Refusal
from orient.errors import UsageError
from orient.store.preflight import SQLITE_MAGIC
from orient.store.summary_engine import SUMMARY_APPLICATION_ID

STANDARD_INPUT = "-"
LONGEST_LIST = 64 * 2**20


@dataclass(frozen=True, slots=True)
class WorkList:
    """The photos in the order of the command line, and how many names stood for a file that was there already."""

    items: tuple[Item, ...]
    repeated: int


def work_list(places: Sequence[str], pattern: str, recursive: bool, source: str = "") -> WorkList:
    """All photos of the places; with `source`, those of its folders with photo.toml first."""
    made = list(_from_folders(places, source)) if source else []
    if source and not made:
        raise UsageError(
            f"no folder in {source} has a photo.toml.", "Give the folder that holds the folders of the photos."
        )
    known = [place for place in places if not source or os.path.lexists(place)]
    found = [item for place in known for item in _items_of(place, pattern, recursive)]
    found = [item for item in found if not _is_summary(item.path)]
    items = _each_once([*made, *found])
    if not items:
        raise UsageError(_nothing(places, pattern), "Give a folder of projects, a list of their paths, or --from.")
    return WorkList(tuple(items), len(made) + len(found) - len(items))


def _nothing(places: Sequence[str], pattern: str) -> str:
    for place in places:
        if (Path(place) / "photo.toml").exists():
            return f"{place} holds photo.toml but no project; make projects of such folders with --from."
    return f"there is no {pattern} in {', '.join(places)}."


def _is_folder(place: str) -> bool:
    try:
        return Path(place).is_dir()
    except PermissionError as error:
        raise UsageError(f"{place} cannot be read: {error.strerror}.", "Check its rights.") from None


def _items_of(place: str, pattern: str, recursive: bool) -> Iterator[Item]:
    if place == STANDARD_INPUT:
        yield from _lines(sys.stdin.buffer.read(LONGEST_LIST), Path())
    elif _is_folder(place):
        yield from _in_folder(place, pattern, recursive)
    elif not os.path.lexists(place):
        names = _matches(place)
        if not names:
            raise UsageError(f"there is no file or folder {place}.", "Give a folder of projects, or a list of paths.")
        yield from (Item(name) for name in names)
    elif not Path(place).is_file() or fnmatch.fnmatch(Path(place).name, pattern) or _head(place, 16) == SQLITE_MAGIC:
        yield Item(place)
    else:
        yield from _lines(_list_file(place), Path(place).parent)


def _in_folder(folder: str, pattern: str, recursive: bool) -> Iterator[Item]:
    """Files whose name fits, in the order of their names; a folder that cannot be read is an item with its refusal."""
    refused: list[OSError] = []
    for here, folders, files in os.walk(folder, onerror=refused.append):
        folders.sort()
        names = sorted(name for name in files if fnmatch.fnmatch(name, pattern) and not name.startswith("."))
        yield from (Item(str(Path(here, name))) for name in names)
        if not recursive:
            break
    for error in refused:
        message = f"the folder {error.filename} cannot be read: {error.strerror}."
        yield Item(str(error.filename), refusal=Refusal(message, "Check its rights.", 3))


def _matches(text: str) -> list[str]:
    if not glob.has_magic(text):
        return []
    return sorted(glob.glob(text, recursive=True))  # noqa: PTH207  (Path.glob knows no absolute patterns)


def _list_file(place: str) -> bytes:
    content = _head(place, LONGEST_LIST)
    if b"\0" in content:
        raise UsageError(f"{place} is neither a project nor a list of paths.", "A list has one path a line.")
    return content


def _head(place: str, size: int) -> bytes:
    try:
        with open(place, "rb") as file:
            return file.read(size)
    except OSError as error:
        raise UsageError(f"{place} cannot be read: {error.strerror}.", "Check its rights.") from None


def _lines(content: bytes, base: Path) -> Iterator[Item]:
    """One path a line, relative to the list; `#` begins a comment line; a pattern stands for what it fits."""
    for line in content.removeprefix(b"\xef\xbb\xbf").split(b"\n"):
        name = os.fsdecode(line).strip()
        if name and not name.startswith("#"):
            path = str(base / name)
            yield from (Item(one) for one in ([] if os.path.lexists(path) else _matches(path)) or [path])


def _from_folders(places: Sequence[str], source: str) -> Iterator[Item]:
    """A project DIR/NAME.sqlite for every folder SOURCE/NAME with photo.toml."""
    if len(places) != 1 or (os.path.lexists(places[0]) and not Path(places[0]).is_dir()):
        raise UsageError("--from needs one folder for the projects.", "orient batch DIR --from FOLDER")
    try:
        names = sorted(entry.name for entry in os.scandir(source) if entry.is_dir())
    except OSError as error:
        raise UsageError(f"{source} cannot be read: {error.strerror}.", "Give the folder of the photos.") from None
    for name in names:
        folder = Path(source, name)
        project = str(Path(places[0], f"{name}.sqlite"))
        if not os.access(folder, os.R_OK | os.X_OK):
            yield Item(project, refusal=Refusal(f"the folder {folder} cannot be read.", "Check its rights.", 3))
        elif os.path.lexists(folder / "photo.toml"):
            yield Item(project, source=str(folder.absolute()))


def _is_summary(path: str) -> bool:
    """Summaries of earlier batches may lie beside the projects."""
    try:
        header = _head(path, 72) if Path(path).is_file() else b""
    except (UsageError, OSError):
        return False
    return header[:16] == SQLITE_MAGIC and int.from_bytes(header[68:72], "big") == SUMMARY_APPLICATION_ID


def _each_once(items: Sequence[Item]) -> list[Item]:
    """Absolute paths, links followed; of several names of one file the first."""
    known: set[object] = set()
    kept = []
    for item in items:
        path = os.path.realpath(item.path)
        keys = {path, _file_of(path)}
        if not keys & known:
            kept.append(Item(path, item.source, item.refusal))
        known |= keys
    return kept


def _file_of(path: str) -> object:
    try:
        status = Path(path).stat()
    except OSError:
        return path
    return (status.st_dev, status.st_ino)
