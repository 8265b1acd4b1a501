"""sha256 of canonical JSON: the same content gives the same digest, whatever the order it was stored in."""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from json.encoder import encode_basestring_ascii
from types import NoneType
from typing import Protocol

from orient.store.format import current_format
from orient.store.plain import PlainTable, plain_tables
from orient.values import Blob, Event, Scalar, Settings, Tables

OWN_CONTENT = "content"
"""Role of a run without inputs (an imported list): its input digest goes over its own output digest."""


def input_digest(stage: str, stage_version: int, settings: Settings, inputs: Mapping[str, str]) -> str:
    """Digest of what a run depends on; `inputs` maps each role to the output digest of the run it read.

    A run without inputs gives `{"content": its own output digest}`.
    """
    return _sha256(canonical(["input", stage, stage_version, dict(settings), dict(inputs)]))


@dataclass(frozen=True)
class Content:
    """Everything that a run stores, and its digest; tables without rows are left out."""

    tables: Mapping[str, PlainTable]

    @cached_property
    def digest(self) -> str:
        return rows_digest(self.tables)


def content_of(tables: Tables, events: Sequence[Event] = ()) -> Content:
    """Every column of every table, and the events, as they will be stored."""
    return Content(plain_tables(tables, events, current_format()))


def output_digest(tables: Tables, events: Sequence[Event] = ()) -> str:
    """Digest of everything that a run with these rows and events stores."""
    return content_of(tables, events).digest


class KeptRows(Protocol):
    """Rows of one table of a run in the order of the primary key: about to be stored, or in the file."""

    @property
    def names(self) -> Sequence[str]: ...
    @property
    def used(self) -> Sequence[str]: ...
    def __len__(self) -> int: ...
    def column_chunks(self) -> Iterable[list[Sequence[Scalar]]]: ...


def rows_digest(tables: Mapping[str, KeptRows]) -> str:
    """Digest of everything that a run stores: every used column of every table and of the events, without `run_id`.

    It goes over `canonical(["output", {table: {"columns": names sorted, "rows": rows in the order of the key}}])`,
    some rows at a time. Tables without rows and columns without values do not count, so that a later format may add
    some of both.
    """
    digest = hashlib.sha256(b'["s:output",{')
    separator = ""
    for name in sorted(tables):
        if len(tables[name]):
            digest.update(f'{separator}"{name}":'.encode("ascii"))
            _add_table(digest, tables[name])
            separator = ","
    digest.update(b"}]")
    return digest.hexdigest()


def _add_table(digest: "hashlib._Hash", table: KeptRows) -> None:
    used = sorted(table.used)
    places = [table.names.index(name) for name in used]
    digest.update(_head_of(tuple(used)))
    separator = ""
    for columns in table.column_chunks():
        digest.update((separator + _rows_text(columns, places)).encode("ascii"))
        separator = ","
    digest.update(b"]}")


@cache
def _head_of(used: tuple[str, ...]) -> bytes:
    return f'{{"columns":{canonical(used)},"rows":['.encode("ascii")


def _rows_text(columns: Sequence[Sequence[Scalar]], places: Sequence[int]) -> str:
    """`canonical` of each row, column by column: what is done for a whole column costs little for a value."""
    if not places:
        return ",".join(["[]"] * len(columns[0]))
    patterns, tokens = zip(*(_tokens(columns[place]) for place in places), strict=True)
    pattern = f"[{','.join(patterns)}]"
    return ",".join(map(pattern.__mod__, zip(*tokens, strict=True)))


def _tokens(values: Sequence[Scalar]) -> tuple[str, Iterable[Scalar]]:
    """How a value of this column stands in a row, and the part of each value that differs."""
    kinds = set(map(type, values))
    if kinds == {float}:
        return '"f:%s"', list(map(float.hex, values))  # type: ignore[arg-type]
    if kinds == {int}:
        return "%d", values
    if kinds == {NoneType}:
        return "null%.0s", values
    if kinds == {str}:
        return "%s", [encode_basestring_ascii(f"s:{word}") for word in values]
    if float in kinds:
        return "%s", [f'"f:{(value + 0.0).hex()}"' if type(value) is float else canonical(value) for value in values]
    if Blob in kinds:
        return "%s", [canonical(value) for value in values]
    words = {word: canonical(word) for word in set(values)}
    return "%s", [words[word] for word in values]


def record_digest(kind: str, *parts: object) -> str:
    """Digest of one entry of the ledger; its last part is the digest of the entry before."""
    return _sha256(canonical([kind, *parts]))


def canonical(value: object) -> str:
    """JSON without blanks, keys sorted, floats as `float.hex()` so that no digit is lost."""
    return json.dumps(_hex_floats(value), sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False)


def plain_json(value: object) -> str:
    """JSON for people, without blanks and with sorted keys; NaN and infinity are refused."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def _hex_floats(value: object) -> object:
    """Floats become `f:` + hex, texts get `s:` and bytes `b:` before them, so that none can look like another."""
    if isinstance(value, str):
        return ("b:" if isinstance(value, Blob) else "s:") + value
    if isinstance(value, float):
        return "f:" + (value + 0.0).hex()
    if isinstance(value, bytes):  # never stored by orient, but a forger may
        return "b:" + value.hex()
    if isinstance(value, Mapping):
        return {str(key): _hex_floats(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_hex_floats(item) for item in value]
    return value


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode("ascii")).hexdigest()
