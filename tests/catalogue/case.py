"""One row of the bad-input catalogue: what is on the disk, what is typed, what must be said and must not happen."""

import hashlib
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from tests.cli.commands import Said, orient
from tests.intake.conftest import CONTROL, PHOTO, READINGS

PROJECT, FOLDER = "{project}", "{folder}"
"""Stand for the path of the project and of the folder with the input files in the words of a command."""
NEW = ("new", PROJECT, "--from", FOLDER)
GOOD: Mapping[str, str] = {"photo.toml": PHOTO, "readings.csv": READINGS, "control.csv": CONTROL}
NEVER = ("Traceback", "fault of orient", "\x1b", "\x07")


@dataclass(frozen=True)
class Place:
    """Where a case happens: an input folder that is in order, and the name of a project beside it."""

    root: Path
    full: Path
    """A project with every stage, to be copied."""

    @property
    def folder(self) -> Path:
        return self.root / "in"

    @property
    def project(self) -> Path:
        return self.root / "photo.sqlite"

    def write(self, files: Mapping[str, str | bytes | None]) -> None:
        """Files of the folder; None removes one."""
        self.folder.mkdir(exist_ok=True)
        for name, content in {**GOOD, **files}.items():
            path = self.folder / name
            if content is None:
                path.unlink(missing_ok=True)
            else:
                path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))

    def take_full(self) -> Path:
        """The project is there, with a version of every stage."""
        return Path(shutil.copy(self.full, self.project))

    def say(self, words: Sequence[object]) -> Said:
        return orient(*map(self.placed, words))

    def placed(self, word: object) -> object:
        """A word of a command, or a text that is expected, with the real paths in it."""
        if not isinstance(word, str):
            return word
        return word.replace(PROJECT, str(self.project)).replace(FOLDER, str(self.folder))

    def content(self) -> dict[str, str]:
        """Every regular file that is there, by its digest; what is no file by its kind. Nothing is followed."""
        found = {}
        for path in sorted(self.root.rglob("*")):
            name = str(path.relative_to(self.root))
            if path.is_symlink():
                found[name] = f"link to {path.readlink()}"
            elif path.is_file():
                found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
            else:
                found[name] = "no file"
        return found


Step = Callable[[Place], object]


@dataclass(frozen=True)
class Case:
    """A row. `err` is the whole of standard error; `says` are parts of what is said anywhere, `matches` a pattern.

    Without `changes` a command may change no file at all, whether it refuses or accepts. `then` looks at what came out.
    """

    words: Sequence[object] = NEW
    files: Mapping[str, str | bytes | None] = field(default_factory=dict)
    code: int = 1
    err: str | None = None
    says: Sequence[str] = ()
    matches: str = ""
    before: Step | None = None
    then: Callable[[Place], None] | None = None
    changes: bool = False


def examine(case: Case, place: Place) -> None:
    """Bring the case about and compare."""
    place.write(case.files)
    if case.before is not None:
        case.before(place)
    before = place.content()
    said = place.say(case.words)
    everything = said.out + said.err
    assert said.code == case.code, everything
    assert case.err is None or said.err == place.placed(case.err), said.err
    for part in case.says:
        assert str(place.placed(part)) in everything, everything
    assert re.search(case.matches, everything), everything
    for never in NEVER:
        assert never not in everything, everything
    if case.code:
        assert said.err.startswith(("orient: ", "Usage: ")), said.err
        assert case.code != 2 or said.out == "", said.out
    if not case.changes:
        assert place.content() == before
    if case.then is not None:
        case.then(place)


def refused(message: str, **files: str | bytes | None) -> Case:
    """`orient new` says exactly this and makes nothing; `files` by name without suffix (`readings`, `photo`)."""
    return Case(files={_named(name): content for name, content in files.items()}, err=f"orient: {message}\n")


def accepted(
    then: Callable[[Place], None] | None = None, says: Sequence[str] = (), **files: str | bytes | None
) -> Case:
    return Case(
        files={_named(name): content for name, content in files.items()}, code=0, says=says, then=then, changes=True
    )


def _named(name: str) -> str:
    return f"{name.removesuffix('_toml')}.toml" if name.endswith("_toml") or name == "photo" else f"{name}.csv"


def rows_of(sql: str, expected: str) -> Callable[[Place], None]:
    """What the project answers to a question, as CSV without its header."""

    def look(place: Place) -> None:
        said = orient("sql", place.project, sql, "--csv", "--raw")
        assert said.code == 0, said.err
        assert "\n".join(said.out.splitlines()[1:]) == expected

    return look
