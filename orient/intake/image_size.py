"""Columns and rows of an image as its header says: PNG, JPEG, TIFF and BigTIFF. Decodes nothing."""

import struct
from collections.abc import Callable
from typing import BinaryIO

TIFF_WIDTH, TIFF_HEIGHT = 256, 257
TIFF_FORMATS = {3: "H", 4: "I", 16: "Q"}
MOST_TAGS = 4096
MOST_MARKERS = 10_000
FRAME_MARKERS = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}

Size = tuple[int, int]


def size_px(source: BinaryIO) -> Size | None:
    """(columns, rows), or None if the file does not say so in a way that is read here, or is damaged."""
    source.seek(0)
    start = source.read(8)
    for signature, read in READERS:
        if start.startswith(signature):
            try:
                size = read(source)
            except (struct.error, KeyError, ValueError, OverflowError, OSError):
                return None
            return size if size and min(size) > 0 and max(size) < 2**31 else None
    return None


def _png(source: BinaryIO) -> Size:
    source.seek(16)
    columns, rows = struct.unpack(">II", source.read(8))
    return columns, rows


def _jpeg(source: BinaryIO) -> Size | None:
    """The first frame header; segments before it are passed over by their length."""
    source.seek(2)
    for _ in range(MOST_MARKERS):
        lead, marker = source.read(2)
        if lead != 0xFF:
            return None
        if marker == 0xFF:  # a fill byte
            source.seek(-1, 1)
            continue
        (length,) = struct.unpack(">H", source.read(2))
        if marker in FRAME_MARKERS:
            _, rows, columns = struct.unpack(">BHH", source.read(5))
            return columns, rows
        source.seek(length - 2, 1)
    return None


def _tiff(source: BinaryIO) -> Size:
    """The first directory, whose entries hold width and height in themselves."""
    source.seek(0)
    order = "<" if source.read(2) == b"II" else ">"
    is_big = struct.unpack(order + "H", source.read(2))[0] == 43
    offset, count, value = ("Q", "Q", "Q") if is_big else ("I", "H", "I")
    source.seek(8 if is_big else 4)
    source.seek(_one(source, order + offset))
    tags = {}
    for _ in range(min(_one(source, order + count), MOST_TAGS)):
        tag, kind = struct.unpack(order + "HH", source.read(4))
        _one(source, order + offset)  # how many values: one
        cell = source.read(struct.calcsize(order + value))
        if tag in (TIFF_WIDTH, TIFF_HEIGHT):
            tags[tag] = struct.unpack_from(order + TIFF_FORMATS[kind], cell)[0]
    return tags[TIFF_WIDTH], tags[TIFF_HEIGHT]


def _one(source: BinaryIO, form: str) -> int:
    return int(struct.unpack(form, source.read(struct.calcsize(form)))[0])


READERS: tuple[tuple[bytes, Callable[[BinaryIO], Size | None]], ...] = (
    (b"\x89PNG\r\n\x1a\n", _png),
    (b"\xff\xd8", _jpeg),
    (b"II", _tiff),
    (b"MM", _tiff),
)
