"""`orient seal` and `orient image`: one file to send, a project as any other, with the very image in it."""

import hashlib
import json
import os
import shutil
import sqlite3
import stat
import struct
import tracemalloc
import zlib
from contextlib import closing
from pathlib import Path

import pytest

from orient.intake import image_file
from orient.models import IMAGE_PART_BYTES
from orient.store.check import check_project
from orient.store.project import open_project
from tests.cli.commands import ROOT, orient

PNG = ROOT / "docs" / "figures" / "apollo15.png"


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def files(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


@pytest.fixture
def picture(tmp_path: Path) -> Path:
    """A file of three parts, the last one short."""
    path = tmp_path / "scan.tif"
    content = b"II*\0" + bytes(range(256)) * (2 * 4096) + b"end"
    assert 2 < len(content) / image_file.PART_BYTES < 3
    path.write_bytes(content)
    return path


@pytest.fixture
def sealed(aerial: Path, picture: Path, tmp_path: Path) -> Path:
    target = tmp_path / "sealed.sqlite"
    assert orient("seal", aerial, "-o", target, "--image", picture).code == 0
    return target


def test_a_part_is_as_large_as_the_table_allows() -> None:
    assert image_file.PART_BYTES == IMAGE_PART_BYTES


def test_the_project_itself_is_not_touched(aerial: Path, picture: Path) -> None:
    before = sha256(aerial)
    aerial.chmod(0o440)
    said = orient("seal", aerial, "-o", aerial.with_name("s.sqlite"), "--image", picture)
    assert (said.code, said.err) == (0, "")
    assert sha256(aerial) == before
    assert files(aerial.parent) == {aerial.name, picture.name, "s.sqlite"}
    assert stat.S_IMODE(aerial.with_name("s.sqlite").stat().st_mode) == 0o440


def test_the_manifest_tells_everything_in_the_file(aerial: Path, picture: Path) -> None:
    with open_project(aerial) as project:
        runs = project.runs()
    target = aerial.with_name("s.sqlite")
    told = json.loads(orient("seal", aerial, "-o", target, "--image", picture, "--json").out)
    assert (told["sha256"], told["size_bytes"]) == (sha256(target), target.stat().st_size)
    assert [row["output_digest"] for row in told["runs"][:-1]] == [run.output_digest for run in runs]
    assert [row["tool_version"] for row in told["runs"][:-1]] == [run.tool_version for run in runs]
    assert told["runs"][-1]["stage"] == "image"
    manifest = told["manifest"]
    assert (manifest["project"], manifest["image"], manifest["image_name"]) == (aerial.name, "embedded", "scan.tif")
    assert (manifest["image_sha256"], manifest["n_runs"]) == (sha256(picture), len(runs) + 1)
    shown = json.loads(orient("show", target, "seal", "--json").out)
    assert shown["tables"] == {"sealed_file": [manifest], "sealed_run": told["runs"]}
    assert set(shown["run"]["inputs"]) == {row["stage"] for row in told["runs"]}


def test_a_sealed_file_is_a_project_as_any_other(sealed: Path) -> None:
    report = {line.name: line for line in check_project(sealed).lines}
    assert all(line.ok for line in report.values())
    assert {"image", "manifest"} <= report.keys()
    assert orient("run", sealed).out.count("(unchanged)") == 5
    assert "image         " in orient("status", sealed).out
    assert orient("refine", sealed, "--again").code == 0
    assert orient("verify", sealed).code == 0
    again = sealed.with_name("again.sqlite")
    said = orient("seal", sealed, "-o", again)
    assert (said.code, "scan.tif, " in said.out) == (0, True)
    assert "seal version 2" in orient("show", again, "seal").out
    assert check_project(again).ok


def test_receive_and_backup_keep_the_image(sealed: Path, picture: Path, tmp_path: Path) -> None:
    for command in ("receive", "backup"):
        copy = tmp_path / f"{command}.sqlite"
        assert orient(command, sealed, copy).code == 0
        assert orient("image", copy, "-o", tmp_path / f"{command}.tif").code == 0
        assert (tmp_path / f"{command}.tif").read_bytes() == picture.read_bytes()


def test_the_image_comes_out_as_it_went_in(sealed: Path, picture: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.tif"
    said = orient("image", sealed, "-o", out)
    assert (said.code, "SHA-256 as sealed" in said.out) == (0, True)
    assert sha256(out) == sha256(picture)
    assert orient("image", sealed, "--compare", out).out == f"{out} is the image of this project.\n"
    out.write_bytes(out.read_bytes()[:-1])
    said = orient("image", sealed, "--compare", out)
    assert (said.code, "is not the image of this project" in said.err) == (1, True)
    said = orient("image", sealed, "-o", out)
    assert (said.code, "Use --force" in said.err) == (2, True)
    assert orient("image", sealed, "-o", out, "--force").code == 0
    assert sha256(out) == sha256(picture)


def test_only_the_digest_goes_along_with_reference(aerial: Path, picture: Path) -> None:
    target = aerial.with_name("s.sqlite")
    said = orient("seal", aerial, "-o", target, "--image", picture, "--reference")
    assert "only this digest" in said.out
    assert target.stat().st_size < picture.stat().st_size + aerial.stat().st_size / 2
    assert sha256(picture) in orient("image", target).out
    assert orient("image", target, "--compare", picture).code == 0
    said = orient("image", target, "-o", aerial.with_name("o.tif"))
    assert said.code == 1
    assert "holds only the digest of scan.tif" in said.err
    assert "o.tif" not in files(aerial.parent)
    embedded = aerial.with_name("e.sqlite")
    assert orient("seal", target, "-o", embedded, "--image", picture).code == 0
    assert "image version 2" in orient("show", embedded, "image").out


def test_another_image_is_another_version(sealed: Path) -> None:
    target = sealed.with_name("two.sqlite")
    assert orient("seal", sealed, "-o", target, "--image", PNG).code == 0
    assert "1120 x 630 pixels" in orient("image", target).out
    assert orient("select", target, "image", 1, "-m", "the first scan").code == 0
    assert "scan.tif" in orient("image", target).out


def test_no_image_is_said(aerial: Path) -> None:
    said = orient("seal", aerial, "-o", aerial.with_name("s.sqlite"))
    assert "image: none" in said.out
    assert orient("image", aerial.with_name("s.sqlite")).code == 1


def test_stale_results_are_said(aerial: Path, tmp_path: Path) -> None:
    folder = ROOT / "sample_projects" / "calgary-28"
    assert orient("add", aerial, "control", folder / "control.csv", folder / "control.toml", "-m", "x", "--again")
    control = (folder / "control.csv").read_text().splitlines()
    (tmp_path / "control.csv").write_text("\n".join(control[:-1]) + "\n")
    assert orient("add", aerial, "control", tmp_path / "control.csv", folder / "control.toml", "-m", "x").code == 0
    said = orient("seal", aerial, "-o", aerial.with_name("s.sqlite"))
    assert "STALE: run orient run first" in said.out


BAD = {
    "name is a path": (lambda folder: folder / "x/y.sqlite", None, 2, "does not exist"),
    "own input": (lambda folder: folder / "photo.sqlite", None, 2, "overwrite its own input"),
    "stream": (lambda folder: "-", None, 2, "not a stream"),
    "side file": (lambda folder: folder / "p.sqlite-wal", None, 2, "belongs to SQLite"),
    "exists": (lambda folder: folder / "there.sqlite", None, 2, "Use --force"),
    "image missing": (lambda folder: folder / "s.sqlite", "no.tif", 2, "no such file"),
    "image folder": (lambda folder: folder / "s.sqlite", ".", 2, "is a folder"),
    "image fifo": (lambda folder: folder / "s.sqlite", "fifo", 2, "is a pipe"),
    "image empty": (lambda folder: folder / "s.sqlite", "empty.tif", 1, "empty.tif is empty"),
    "image is the project": (lambda folder: folder / "s.sqlite", "photo.sqlite", 2, "is the project itself"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_sealed(case: str, aerial: Path) -> None:
    target, image, code, words = BAD[case]
    folder = aerial.parent
    (folder / "there.sqlite").write_text("precious")
    (folder / "empty.tif").touch()
    os.mkfifo(folder / "fifo")
    before = files(folder)
    with_image = ["--image", folder / image] if image else []
    said = orient("seal", aerial, "-o", target(folder), *with_image)
    assert said.code == code
    assert words in said.err
    assert files(folder) == before
    assert (folder / "there.sqlite").read_text() == "precious"


def test_an_image_too_large_is_referenced(aerial: Path, picture: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(image_file, "LARGEST_EMBEDDED", 1000)
    said = orient("seal", aerial, "-o", aerial.with_name("s.sqlite"), "--image", picture)
    assert (said.code, "--reference" in said.err) == (1, True)
    assert orient("seal", aerial, "-o", aerial.with_name("s.sqlite"), "--image", picture, "--reference").code == 0


def test_an_image_that_changes_meanwhile_is_refused(
    aerial: Path, picture: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Changed between the first pass and the storing."""
    real = image_file.image_facts

    def then_changed(path: Path) -> image_file.ImageFile:
        facts = real(path)
        with path.open("r+b") as file:
            file.seek(100)
            file.write(b"changed")
        return facts

    monkeypatch.setattr(image_file, "image_facts", then_changed)
    said = orient("seal", aerial, "-o", aerial.with_name("s.sqlite"), "--image", picture)
    assert said.code == 1
    assert "scan.tif: changed while reading" in said.err
    assert files(aerial.parent) == {aerial.name, picture.name}


def test_memory_does_not_grow_with_the_image(aerial: Path, tmp_path: Path) -> None:
    large = tmp_path / "large.tif"
    large.write_bytes(b"II*\0")
    os.truncate(large, 60 * 2**20)
    tracemalloc.start()
    assert orient("seal", aerial, "-o", tmp_path / "s.sqlite", "--image", large).code == 0
    assert orient("image", tmp_path / "s.sqlite", "-o", tmp_path / "o.tif").code == 0
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 25 * 2**20


def unguarded(path: Path, statement: str) -> None:
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        guards = connection.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger'").fetchall()
        for name, _ in guards:
            connection.execute(f"DROP TRIGGER {name}")
        connection.execute(statement)
        for _, text in guards:
            connection.execute(text)


CHANGES = {
    "one byte of the image": "UPDATE image_part SET content = CAST('en' AS BLOB) WHERE seq = 3",
    "parts exchanged": "UPDATE image_part SET seq = CASE seq WHEN 1 THEN 5 ELSE 1 END WHERE seq < 3",
    "a part missing": "DELETE FROM image_part WHERE seq = 2",
    "another digest": f"UPDATE image SET sha256 = '{'0' * 64}'",
    "another name": "UPDATE image SET name = '../../x'",
    "a digest in the manifest": "UPDATE sealed_run SET output_digest = 'x' WHERE sealed_run_id = 2",
}


@pytest.mark.parametrize("case", CHANGES)
def test_check_finds_what_was_changed(case: str, sealed: Path, tmp_path: Path) -> None:
    unguarded(sealed, CHANGES[case])
    said = orient("check", sealed)
    assert said.code == 3
    assert "FAULT" in said.out
    assert orient("receive", sealed, tmp_path / "r.sqlite").code == 3
    if "image" in case or "part" in case:
        assert orient("image", sealed, "-o", tmp_path / "o.tif").code == 3
    assert not (tmp_path / "o.tif").exists()
    assert not (tmp_path / "r.sqlite").exists()


def test_a_stored_name_never_becomes_a_path(aerial: Path, tmp_path: Path) -> None:
    """Whatever a name looks like, files appear only where the user says."""
    folder = tmp_path / "pictures"
    folder.mkdir()
    for number, name in enumerate(["=1+1.tif", "..hidden", "-rf", "C:\\x.tif", "a\x1b[31m.tif", "x" * 200]):
        (folder / name).write_bytes(b"MM\0*")
        target = tmp_path / f"{number}.sqlite"
        assert orient("seal", aerial, "-o", target, "--image", folder / name).code == 0
        assert orient("image", target, "-o", tmp_path / f"{number}.tif").code == 0
        assert "\x1b" not in orient("image", target).out
        shutil.rmtree(folder)
        folder.mkdir()
    assert files(folder) == set()
    assert files(tmp_path) == {aerial.name, "pictures", *(f"{n}.{e}" for n in range(6) for e in ("sqlite", "tif"))}


def png(columns: int, rows: int) -> bytes:
    body = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + b"IHDR" + body + struct.pack(">I", zlib.crc32(b"IHDR" + body))


def tiff(order: str, columns: int, rows: int) -> bytes:
    entries = b"".join(struct.pack(order + "HHII", tag, 4, 1, value) for tag, value in ((256, columns), (257, rows)))
    head = (b"II" if order == "<" else b"MM") + struct.pack(order + "HI", 42, 8)
    return head + struct.pack(order + "H", 2) + entries + bytes(4)


def bigtiff(columns: int, rows: int) -> bytes:
    entries = b"".join(struct.pack("<HHQQ", tag, 4, 1, value) for tag, value in ((256, columns), (257, rows)))
    return b"II" + struct.pack("<HHHQ", 43, 8, 0, 16) + struct.pack("<Q", 2) + entries + bytes(8)


JPEG = b"\xff\xd8\xff\xe0\x00\x04ab\xff\xff\xc2\x00\x11\x08" + struct.pack(">HH", 40, 30) + bytes(10)
SIZES = {
    "png": (png(30, 40), (30, 40), "image/png"),
    "tiff, little-endian": (tiff("<", 30, 40), (30, 40), "image/tiff"),
    "tiff, big-endian": (tiff(">", 30, 40), (30, 40), "image/tiff"),
    "bigtiff": (bigtiff(30, 40), (30, 40), "image/tiff"),
    "jpeg": (JPEG, (30, 40), "image/jpeg"),
    "png, cut": (png(30, 40)[:20], None, "image/png"),
    "png, zero": (png(0, 40), None, "image/png"),
    "jpeg, cut": (JPEG[:12], None, "image/jpeg"),
    "tiff, directory beyond the end": (b"II*\0\xff\xff\xff\xff", None, "image/tiff"),
    "tiff, many entries": (tiff("<", 30, 40)[:8] + b"\xff\xff", None, "image/tiff"),
    "bigtiff, far": (b"II+\0\x08\0\0\0" + b"\xff" * 8, None, "image/tiff"),
    "nitf": (b"NITF02.10" + bytes(20), None, "image/nitf"),
    "anything": (b"a photo", None, "application/octet-stream"),
}


@pytest.mark.parametrize("case", SIZES)
def test_what_the_file_says_of_itself(case: str, tmp_path: Path) -> None:
    content, size, kind = SIZES[case]
    path = tmp_path / "image"
    path.write_bytes(content)
    facts = image_file.image_facts(path)
    assert (facts.size_px, facts.media_type, facts.size_bytes) == (size, kind, len(content))


def test_an_image_of_another_size_or_name_is_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "scan.png"
    path.write_bytes(png(30, 40))
    photo = {"image_file": "photo.tif", "image_width_px": 40, "image_height_px": 30}
    events = image_file.read_image(path, True, photo).events
    assert [event.message for event in events] == [
        "the image is scan.png, photo.toml names photo.tif",
        "the image has 30 x 40 pixels, photo.toml says 40 x 30",
    ]
    assert image_file.read_image(path, True, {**photo, "image_file": None, "image_width_px": None}).events == ()
