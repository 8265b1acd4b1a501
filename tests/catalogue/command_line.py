"""E: the command line. Standard output stays empty, one sentence says why, and no file is made or changed."""

import os
from collections.abc import Callable
from pathlib import Path

from tests.catalogue.case import PROJECT, Case, Place
from tests.cli.commands import AERIAL

HUGE = 2**63
NINES = "9" * 30

_LINES: dict[str, tuple[tuple[object, ...], int, str]] = {
    "E1 empty name, new": (("new", "", "--from", AERIAL), 2, "Give the name of a file."),
    "E1 empty name, run": (("run", ""), 2, "Give the name of a file."),
    "E1 empty name, status": (("status", ""), 2, "Give the name of a file."),
    "E1 :memory: is a plain name": (("status", ":memory:"), 2, "no such project: :memory:"),
    "E1 URI is a plain name": (("status", "file:x?mode=memory"), 2, "no such project: file:x?mode=memory"),
    "E3 tolerance nan": (("resection", PROJECT, "--tolerance", "nan"), 2, "nan is not between 0 and 0.0001"),
    "E3 tolerance inf": (("resection", PROJECT, "--tolerance", "inf"), 2, "inf is not between 0 and 0.0001"),
    "E3 tolerance 0": (("resection", PROJECT, "--tolerance", "0"), 2, "0.0 is not between 0 and 0.0001"),
    "E3 tolerance -1": (("resection", PROJECT, "--tolerance", "-1"), 2, "-1.0 is not between 0 and 0.0001"),
    "E3 tolerance 1,5": (("resection", PROJECT, "--tolerance", "1,5"), 2, "'1,5' is not a valid float"),
    "E5 no iterations": (("resection", PROJECT, "--max-iterations", "0"), 2, "range 1<=x<=1000"),
    "E5 too many iterations": (("resection", PROJECT, "--max-iterations", "1000000000"), 2, "range 1<=x<=1000"),
    "degree 0": (("digitize", PROJECT, "--degree", "0"), 2, "is not auto or one of 1, 2, 3, 4, 5"),
    "degree 6": (("digitize", PROJECT, "--degree", "6"), 2, "is not auto or one of 1, 2, 3, 4, 5"),
    "control": (("resection", PROJECT, "--control", "none"), 2, "auto, fixed, weighted"),
    "variance": (("resection", PROJECT, "--variance", "none"), 2, "posteriori, priori"),
    "decimal": (("add", PROJECT, "control", "x.csv", "-m", "x", "--decimal", "dot"), 2, "point or comma"),
    "max rows": (("add", PROJECT, "control", "x.csv", "-m", "x", "--max-rows", "0"), 2, "range x>=1"),
    "E11 unknown stage": (("show", PROJECT, "resect"), 2, "Stages are photo, readings"),
    "E11 unknown stage, diff": (("diff", PROJECT, "resect", "1", "2"), 2, "There are runs of: photo, readings"),
    "E11 unknown stage, select": (("select", PROJECT, "resect", "1", "-m", "x"), 2, "There are runs of: photo"),
    "E11 unknown list": (("add", PROJECT, "points", "x.csv", "-m", "x"), 2, "Lists are photo, readings"),
    "E11 unknown version": (("show", PROJECT, "photo", "--version", "2"), 2, "There are versions 1."),
    "E11 unknown question": (("sql", PROJECT, "resid"), 2, "Questions are orientation"),
    "E12 version 2^63": (("show", PROJECT, "photo", "--version", HUGE), 2, f"photo has no version {HUGE}"),
    "E12 version -1": (("show", PROJECT, "photo", "--version", "-1"), 2, "range x>=1"),
    "E12 select 2^63": (("select", PROJECT, "photo", HUGE, "-m", "x"), 2, f"photo has no version {HUGE}"),
    "E12 diff 2^63": (("diff", PROJECT, "photo", "1", HUGE), 2, f"photo has no version {HUGE}"),
    "E13 message": (("run", PROJECT, "-m", "\udcff"), 2, "not valid text"),
    "E13 question": (("sql", PROJECT, "SELECT '\udcff'"), 2, "not valid text"),
    "E13 stage": (("show", PROJECT, "\udcff"), 2, "there is no stage"),
    "E14 stage": (("show", PROJECT, "\x1b[31m"), 2, 'there is no stage "\\x1b[31m"'),
    "E14 command": (("\x1b[31m",), 2, "\\x1b[31m"),
    "E14 option": (("--\x1b[31m",), 2, "\\x1b[31m"),
    "E14 project": (("status", "\x1b[31m"), 2, "\\x1b[31m"),
    "select without a reason": (("select", PROJECT, "photo", "1"), 2, "say why"),
    "add without a reason": (("add", PROJECT, "control", "x.csv"), 2, "--message"),
    "missing folder": (("new", "x.sqlite", "--from", "nowhere"), 2, "nowhere"),
    "no command": (("frobnicate",), 2, "No such command"),
    "show what is not there": (("show", PROJECT, "image"), 2, "image has no current version"),
    "missing project": (("run", "hose.orient"), 2, "no such project: hose.orient"),
    "folder": (("status", "."), 3, "not a regular file"),
    "foreign file": (("status", AERIAL / "photo.toml"), 3, "not an orient project"),
}

OUT = f"{PROJECT}.out"
SEAL = ("seal", PROJECT, "-o")
RANGE = "is not in the range"


def full(place: Place) -> None:
    place.take_full()


def beside(make: Callable[[Path], object]) -> Callable[[Place], None]:
    """Something has the name of the output already."""

    def before(place: Place) -> None:
        place.take_full()
        make(Path(str(place.placed(OUT))))

    return before


def link_to_letter(path: Path) -> None:
    path.with_name("letter.txt").write_text("mine")
    path.symlink_to("letter.txt")


def letter_stays(place: Place) -> None:
    assert (place.root / "letter.txt").read_text() == "mine"
    assert not Path(str(place.placed(OUT))).is_symlink()


def typed(words: tuple[object, ...], says: str, code: int = 2, before: Callable[[Place], None] = full) -> Case:
    return Case(words=words, code=code, says=[says], before=before)


CASES: dict[str, Case] = {
    **{name: typed(words, message, code) for name, (words, code, message) in _LINES.items()},
    "E2 seed -1": typed(("verify", PROJECT, "--seed", "-1"), RANGE),
    "E2 seed 1e3": typed(("verify", PROJECT, "--seed", "1e3"), "is not a valid int"),
    "E2 seed of 30 digits": typed(("verify", PROJECT, "--seed", NINES), RANGE),
    "E6 the project": typed((*SEAL, PROJECT), "would overwrite its own input"),
    "E6 the project, forced": typed((*SEAL, PROJECT, "--force"), "would overwrite its own input"),
    "E6 its journal": typed((*SEAL, f"{PROJECT}-journal", "--force"), "would overwrite its own input"),
    "E7": typed((*SEAL, OUT), "exists", before=beside(lambda path: path.write_text("mine"))),
    "E7 forced": Case(
        words=(*SEAL, OUT, "--force"), code=0, changes=True, before=beside(lambda path: path.write_text("mine"))
    ),
    "E7 a folder": typed((*SEAL, OUT, "--force"), "is not a file", before=beside(lambda path: path.mkdir())),
    "E7 a pipe": typed((*SEAL, OUT, "--force"), "is not a file", before=beside(os.mkfifo)),
    "E8": typed((*SEAL, OUT), "exists", before=beside(link_to_letter)),
    "E8 forced": Case(
        words=(*SEAL, OUT, "--force"), code=0, changes=True, before=beside(link_to_letter), then=letter_stays
    ),
    "E9 missing folder": typed((*SEAL, f"{OUT}/x.sqlite"), "does not exist"),
    "E9 a file for a folder": typed((*SEAL, f"{PROJECT}/x.sqlite"), "is no folder"),
}
