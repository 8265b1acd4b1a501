"""Every operation on a small disk that is all but full; runs in a mount namespace of its own.

`unshare --mount python -m tests.faults.full_disk FOLDER`: mounts a disk of 8 MB on FOLDER and writes one line of
JSON per trial: [what, "" or what went wrong].
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.faults.operations import OPERATIONS, PROJECT, make_templates
from tests.faults.oracle import Clean, judge, undisturbed
from tests.faults.victims import Ended, Victims

DISK = "8m"
PAGE = 4096
FREE_PAGES = (0, 1, 3, 8, 20, 50, 100, 150)


def fill(disk: Path, free_bytes: int) -> Path:
    """A file that leaves `free_bytes`."""
    filler, space = disk / "filler", os.statvfs(disk)
    size = space.f_bavail * space.f_frsize - free_bytes
    if size > 0:
        with filler.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, size)
    else:
        filler.touch()
    return filler


def on_a_full_disk(clean: Clean, pages: int, disk: Path, victims: Victims) -> Ended:
    """The command with that much room; a reading command while the disk is full; then the judge with space again."""
    folder = clean.scene(disk / "scene")
    filler = fill(disk, pages * PAGE)
    ended = victims.run(*clean.words(folder))
    assert ended.code in (0, 3), ended
    assert ended.code == 0 or "No space left" in ended.err or "full" in ended.err, ended.err
    if clean.template.name in ("done", "model"):
        assert victims.run("status", folder / PROJECT).code == 0
    filler.unlink()
    judge(clean, folder, ended, victims)
    return ended


def main(disk: Path) -> None:
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", str(disk)], check=True)
    beside = Path(tempfile.mkdtemp(prefix="orient-templates-"))
    templates, victims = make_templates(beside), Victims()
    for operation in OPERATIONS:
        clean = undisturbed(operation, templates, beside / "clean", victims, beside / "log")
        for pages in FREE_PAGES:
            wrong = ""
            try:
                ended = on_a_full_disk(clean, pages, disk, victims)
            except AssertionError as error:
                wrong = str(error)[:500]
            print(json.dumps([f"{operation} with {pages} pages free: {ended.code}", wrong]), flush=True)
    victims.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
