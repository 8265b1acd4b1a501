"""sha256 of canonical JSON: the same content gives the same digest, whatever the order it was stored in."""

import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence

from orient.store.format import TableShape, current_format
from orient.store.plain import plain_tables
from orient.values import Blob, Event, Scalar, Settings, Tables

OWN_CONTENT = "content"
"""Role of a run without inputs (an imported list): its input digest goes over its own output digest."""


def input_digest(stage: str, stage_version: int, settings: Settings, inputs: Mapping[str, str]) -> str:
    """Digest of what a run depends on; `inputs` maps each role to the output digest of the run it read.

    A run without inputs gives `{"content": its own output digest}`.
    """
    return _sha256(canonical(["input", stage, stage_version, dict(settings), dict(inputs)]))


def output_digest(tables: Tables, events: Sequence[Event] = ()) -> str:
    """Digest of everything that a run stores: every column of every table, and the events."""
    form = current_format()
    return rows_digest(plain_tables(tables, events, form), form.tables)


def rows_digest(rows: Mapping[str, Iterable[Sequence[Scalar]]], shapes: Mapping[str, TableShape]) -> str:
    """Digest of stored rows, each without `run_id`, columns in stored order.

    Tables without rows and columns without values do not count, so that a later format may add some of both.
    """
    content = {table: _table_content(list(values), shapes[table]) for table, values in rows.items()}
    return _sha256(canonical(["output", {table: part for table, part in content.items() if part}]))


def _table_content(rows: list[Sequence[Scalar]], shape: TableShape) -> dict[str, object]:
    if not rows:
        return {}
    names = [name for name in shape.names if name != "run_id"]
    places = {name: place for place, name in enumerate(names)}
    key = [places[name] for name in shape.key if name != "run_id"]
    used = [name for name in sorted(names) if any(row[places[name]] is not None for row in rows)]
    ordered = sorted(rows, key=lambda row: [row[place] for place in key])
    return {"columns": used, "rows": [[row[places[name]] for name in used] for row in ordered]}


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
    if isinstance(value, Mapping):
        return {str(key): _hex_floats(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_hex_floats(item) for item in value]
    return value


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode("ascii")).hexdigest()
