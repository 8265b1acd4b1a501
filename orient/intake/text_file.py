"""Text files as a stream of lines: kind of file, encoding, length of lines, and that nobody changed them meanwhile."""

import codecs
import errno
import io
import os
import re
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import BinaryIO

from orient.errors import UsageError
from orient.intake.findings import Findings, shown
from orient.intake.options import MAX_ROWS, ReadOptions

CSV_LINE_LIMIT = 10_000
TOML_LINE_LIMIT = 50_000
TOML_SIZE_LIMIT = 1_000_000
CHUNK = 1 << 20

SIGNATURES = (
    (b"PK\x03\x04", "a ZIP file (Excel?)"),
    (b"\xd0\xcf\x11\xe0", "an old Excel or Word file"),
    (b"\x1f\x8b", "a gzip file"),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"II*\x00", "a TIFF image"),
    (b"MM\x00*", "a TIFF image"),
    (b"%PDF", "a PDF file"),
    (b"SQLite format 3\x00", "an SQLite file"),
)
KINDS = (
    (stat.S_ISDIR, "is a folder"),
    (stat.S_ISFIFO, "is a pipe, not a file"),
    (stat.S_ISCHR, "is a device, not a file"),
    (stat.S_ISBLK, "is a device, not a file"),
    (stat.S_ISSOCK, "is a socket, not a file"),
)
REASONS = {
    errno.ENOENT: "no such file",
    errno.ENOTDIR: "no such file",
    errno.EACCES: "permission denied",
    errno.EPERM: "permission denied",
    errno.ELOOP: "too many links",
    errno.ENAMETOOLONG: "the file name is too long",
}
ESCAPED_BYTE = re.compile("[\udc80-\udcff]")

Lines = Iterator[tuple[int, str]]
SizeCheck = Callable[[BinaryIO, ReadOptions], str]
"""Says what is too large about an open file, or nothing."""


def csv_lines(path: Path, file: str, options: ReadOptions, findings: Findings) -> Lines:
    """Line number (from 1) and text of every line of a CSV file that can be read; the others become problems."""
    yield from _lines(path, file, options, findings, CSV_LINE_LIMIT, _too_many_lines)


def toml_text(path: Path, file: str, options: ReadOptions, findings: Findings) -> str | None:
    """The whole text of a TOML file, or None when there are problems."""
    before = len(findings.problems)
    lines = [text for _, text in _lines(path, file, options, findings, TOML_LINE_LIMIT, _too_large_for_toml)]
    return "\n".join(lines) + "\n" if len(findings.problems) == before else None


def read_options(decimal: str, encoding: str, ignore_columns: bool = False, max_rows: int = MAX_ROWS) -> ReadOptions:
    """What a user said in words; a `UsageError` where they mean nothing."""
    if decimal not in ("point", "comma"):
        raise UsageError(f'--decimal is "{decimal}"', "It is point or comma.")
    check_encoding(encoding)
    return ReadOptions("comma" if decimal == "comma" else "point", encoding, ignore_columns, max_rows)


def check_encoding(encoding: str) -> None:
    """Only encodings that keep ASCII as it is can be split into lines and cells."""
    ascii_bytes = bytes(range(0x20, 0x7F)) + b"\r\n\t"
    try:
        decoded = ascii_bytes.decode(encoding, "surrogateescape")
        same = decoded == ascii_bytes.decode("ascii") and codecs.lookup(encoding).name != "utf-7"
    except (LookupError, ValueError, TypeError):
        same = False
    if not same:
        raise UsageError(f'encoding "{shown(encoding)}" is not known or not usable.', "Try utf-8, latin-1 or cp1251.")


def _lines(
    path: Path, file: str, options: ReadOptions, findings: Findings, line_limit: int, oversize: SizeCheck
) -> Lines:
    source = opened(path, file, findings)
    if source is None:
        return
    with source:
        before = _state(source)
        if not _is_text(source, file, findings):
            return
        if complaint := oversize(source, options):
            findings.problem(file, 0, complaint)
            return
        source.seek(0)
        yield from _decoded(source, file, options, findings, line_limit)
        if _state(source) != before or _path_state(path) != before:
            findings.problem(file, 0, "changed while reading, try again")


def opened(path: Path, file: str, findings: Findings) -> BinaryIO | None:
    try:
        mode = path.stat().st_mode
        for is_kind, words in KINDS:
            if is_kind(mode):
                findings.path_problem(file, words)
                return None
        return path.open("rb")
    except ValueError:
        findings.path_problem(file, "no such file")
    except OSError as error:
        findings.path_problem(file, reason(error))
    return None


def reason(error: OSError) -> str:
    """Why a file or a folder cannot be read."""
    return REASONS.get(error.errno or 0, os.strerror(error.errno or 0))


def _state(source: BinaryIO) -> tuple[int, int]:
    state = os.fstat(source.fileno())
    return state.st_size, state.st_mtime_ns


def _path_state(path: Path) -> tuple[int, int]:
    try:
        state = path.stat()
    except OSError:
        return -1, -1
    return state.st_size, state.st_mtime_ns


def _is_text(source: BinaryIO, file: str, findings: Findings) -> bool:
    start = source.read(512)
    for signature, words in SIGNATURES:
        if start.startswith(signature):
            findings.problem(file, 0, f"this is {words}", f"Export it as {_wanted(file)}")
            return False
    if _looks_like_utf16(start):
        findings.problem(file, 0, "looks like UTF-16", "Save as UTF-8")
        return False
    return True


def _wanted(file: str) -> str:
    return "TOML text" if file.lower().endswith(".toml") else "CSV"


def _looks_like_utf16(start: bytes) -> bool:
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return True
    pairs = len(start) // 2
    return pairs > 1 and max(start[0::2].count(0), start[1::2].count(0)) > 0.4 * pairs


def _too_large_for_toml(source: BinaryIO, options: ReadOptions) -> str:
    if _state(source)[0] > TOML_SIZE_LIMIT:
        return "larger than 1 MB, not a description of a camera, sheet or control"
    return ""


def _too_many_lines(source: BinaryIO, options: ReadOptions) -> str:
    """Counted before a single row is kept, so that a file of any size is refused in constant memory."""
    newlines = returns = 0
    source.seek(0)
    while chunk := source.read(CHUNK):
        newlines += chunk.count(b"\n")
        returns += chunk.count(b"\r")
        if max(newlines, returns) > options.max_rows + 1:
            return f"more than {options.max_rows:,} data lines. Raise with --max-rows"
    return ""


def _decoded(source: BinaryIO, file: str, options: ReadOptions, findings: Findings, line_limit: int) -> Lines:
    # surrogateescape keeps a byte that does not decode in its place, so that its line can be named
    encoding = "utf-8-sig" if codecs.lookup(options.encoding).name == "utf-8" else options.encoding
    text = io.TextIOWrapper(source, encoding=encoding, errors="surrogateescape", newline=None)
    number = 0
    while line := text.readline(line_limit + 1):
        number += 1
        if len(line) > line_limit and not line.endswith("\n"):
            findings.problem(file, number, f"line is longer than {line_limit:,} characters")
            _skip_line(text)
        elif complaint := _unreadable(line, options.encoding):
            findings.problem(file, number, *complaint)
        else:
            yield number, line.rstrip("\n")
    text.detach()


def _skip_line(text: io.TextIOWrapper) -> None:
    while (rest := text.readline(CHUNK)) and not rest.endswith("\n"):
        pass


def _unreadable(line: str, encoding: str) -> tuple[str, str] | None:
    if escaped := ESCAPED_BYTE.search(line):
        byte = ord(escaped.group()) - 0xDC00
        if codecs.lookup(encoding).name == "utf-8":
            return f"not UTF-8 (byte 0x{byte:02x})", "Save as UTF-8, or --encoding latin-1"
        return f"not {encoding} (byte 0x{byte:02x})", "Give the right --encoding"
    if "\0" in line:
        return "contains a NUL byte", ""
    return None
