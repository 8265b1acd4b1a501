"""The image file of the photo: what kind of file it is, its size and digest, its parts for embedding."""

import hashlib
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from orient.errors import InputError, OrientError, Problem, UsageError
from orient.intake.findings import Findings, shown
from orient.intake.image_size import size_px
from orient.intake.text_file import opened
from orient.values import Blob, InputTables, Row
from orient.words import is_valid

PART_BYTES = 2**20
LARGEST_EMBEDDED = 2**30
"""Bytes. A larger image is better sent beside the project, which then knows its digest."""

KINDS = (
    (b"II*\x00", "image/tiff"),
    (b"MM\x00*", "image/tiff"),
    (b"II+\x00", "image/tiff"),
    (b"MM\x00+", "image/tiff"),
    (b"\x89PNG\r\n\x1a\n", "image/png"),
    (b"\xff\xd8\xff", "image/jpeg"),
    (b"\x00\x00\x00\x0cjP  \r\n\x87\n", "image/jp2"),
    (b"\xff\x4f\xff\x51", "image/j2c"),
    (b"NITF", "image/nitf"),
    (b"BM", "image/bmp"),
    (b"CCSD", "application/x-pds"),
    (b"PDS_VERSION_ID", "application/x-pds"),
    (b"Object = IsisCube", "application/x-isis-cube"),
)
CHANGED = "changed while reading, try again"
OTHER = "application/octet-stream"


@dataclass(frozen=True, slots=True)
class ImageFile:
    """Facts of an image file; `parts` tells its bytes 1 MiB at a time without keeping them."""

    name: str
    media_type: str
    size_bytes: int
    sha256: str
    size_px: tuple[int, int] | None
    parts: tuple[Blob, ...]


def read_image(path: Path, embed: bool, photo: Mapping[str, object] | None = None) -> InputTables:
    """The tables of the stage `image`; with `embed` the bytes of the file too, fetched when they are stored.

    `photo`: the row of the table `photo`; a file of another name or size than it tells is a warning. Raises
    `UsageError` for what cannot be opened, `OrientError` for an empty or (embedded) too large file.
    """
    image = image_facts(path)
    if embed and image.size_bytes > LARGEST_EMBEDDED:
        raise OrientError(
            f"{shown(image.name)}: {image.size_bytes:,} bytes are more than the {LARGEST_EMBEDDED:,} that are embedded",
            "Send the image beside the project and seal its digest: --reference",
        )
    width, height = image.size_px or (None, None)
    row: Row = {
        "name": image.name,
        "media_type": image.media_type,
        "size_bytes": image.size_bytes,
        "sha256": image.sha256,
        "width_px": width,
        "height_px": height,
        "n_parts": len(image.parts) if embed else 0,
    }
    parts: list[Row] = [{"seq": seq, "content": part} for seq, part in enumerate(image.parts, 1)]
    findings = Findings()
    _compare(image, photo or {}, findings)
    return InputTables(
        "image", {"image": [row], "image_part": parts if embed else []}, tuple(findings.events), (image.name,)
    )


def image_facts(path: Path) -> ImageFile:
    """One pass over the file in constant memory; a file that changes meanwhile is refused."""
    name = _name(path)
    findings = Findings()
    source = opened(path, shown(str(path)), findings)
    if source is None:
        raise InputError(findings.problems, exit_code=2)
    with source:
        before = os.fstat(source.fileno())
        start = source.read(PART_BYTES)
        if not start:
            raise OrientError(f"{shown(name)} is empty")
        whole, parts = hashlib.sha256(), []
        for number, part in enumerate(_parts(start, source)):
            whole.update(part)
            parts.append(Blob(part, partial(_part_again, path, number, Blob(part))))
        after = os.fstat(source.fileno())
        if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
            raise InputError([Problem(shown(name), 0, CHANGED)])
        return ImageFile(name, media_type(start), after.st_size, whole.hexdigest(), size_px(source), tuple(parts))


def media_type(start: bytes) -> str:
    return next((kind for signature, kind in KINDS if start.startswith(signature)), OTHER)


def _name(path: Path) -> str:
    """The last part of the path, which is all that is kept of it."""
    name = path.name
    if not is_valid(name):
        raise UsageError(f"the name {shown(name)} is not valid text (UTF-8)", "Rename the image.")
    return name


def _parts(start: bytes, source: object) -> Iterator[bytes]:
    yield start
    yield from iter(partial(source.read, PART_BYTES), b"")  # type: ignore[attr-defined]


def _part_again(path: Path, number: int, meant: Blob) -> bytes:
    """The bytes of one part once more; a file that is another one meanwhile is refused."""
    try:
        with path.open("rb") as file:
            file.seek(number * PART_BYTES)
            content = file.read(PART_BYTES)
    except OSError as error:
        raise InputError([Problem(shown(path.name), 0, f"cannot be read: {error.strerror}")]) from None
    if Blob(content) != meant:
        raise InputError([Problem(shown(path.name), 0, CHANGED)])
    return content


def _compare(image: ImageFile, photo: Mapping[str, object], findings: Findings) -> None:
    name = photo.get("image_file")
    if name and str(name) != image.name:
        message = f"the image is {shown(image.name)}, photo.toml names {shown(str(name))}"
        findings.warn("image_name", image.name, message)
    told = (photo.get("image_width_px"), photo.get("image_height_px"))
    if image.size_px and None not in told and told != image.size_px:
        message = f"the image has {_by(image.size_px)} pixels, photo.toml says {_by(told)}"
        findings.warn("image_size", image.name, message)


def _by(size: tuple[object, object]) -> str:
    return f"{size[0]} x {size[1]}"
