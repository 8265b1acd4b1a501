"""Who may do what on a connection, and for how long: SQLite's authorizer and progress handler."""

import sqlite3
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Literal

Phase = Literal["setup", "read", "write", "query"]

STOP = threading.Event()
"""Set by the signal handlers of the command line; every long statement then ends within 10 000 operations."""

READING = frozenset({sqlite3.SQLITE_SELECT, sqlite3.SQLITE_READ, sqlite3.SQLITE_RECURSIVE, sqlite3.SQLITE_TRANSACTION})
NEVER = frozenset(
    {
        sqlite3.SQLITE_ATTACH,
        sqlite3.SQLITE_DETACH,
        sqlite3.SQLITE_CREATE_VTABLE,
        sqlite3.SQLITE_DROP_VTABLE,
    }
)
FORBIDDEN_FUNCTIONS = frozenset({"load_extension", "fts3_tokenizer", "readfile", "writefile", "edit"})
OWN_PRAGMAS = frozenset(
    {
        "cache_size", "cache_spill", "data_version", "foreign_key_check", "integrity_check", "journal_mode",
        "page_count", "page_size", "query_only", "quick_check", "schema_version", "user_version",
    }
)  # fmt: skip
ASKED_PRAGMAS = frozenset({"table_info", "table_xinfo", "table_list", "index_list", "index_info"})


@dataclass
class Watch:
    """Limits of one connection. `names` are the views, triggers and CTEs that may run; nothing else may."""

    phase: Phase = "setup"
    names: frozenset[str] = frozenset()
    deadline: float = field(default=float("inf"))

    @property
    def is_stopped(self) -> bool:
        return STOP.is_set()

    def progress(self) -> bool:
        """True ends the running statement."""
        return STOP.is_set() or time.monotonic() > self.deadline

    @contextmanager
    def within(self, seconds: float | None) -> Iterator[None]:
        before = self.deadline
        self.deadline = before if seconds is None else time.monotonic() + seconds
        try:
            yield
        finally:
            self.deadline = before

    @contextmanager
    def in_phase(self, phase: Phase) -> Iterator[None]:
        before = self.phase
        self.phase = phase
        try:
            yield
        finally:
            self.phase = before

    def authorize(self, action: int, first: str | None, second: str | None, base: str | None, inner: str | None) -> int:
        """SQLITE_OK or SQLITE_DENY; `inner` is the innermost view, trigger or CTE that causes the action."""
        if action == sqlite3.SQLITE_READ and inner is None:  # by far the most
            return sqlite3.SQLITE_OK
        if action in NEVER or (action == sqlite3.SQLITE_FUNCTION and second in FORBIDDEN_FUNCTIONS):
            return sqlite3.SQLITE_DENY
        if inner is not None and self.phase != "query" and inner not in self.names:
            return sqlite3.SQLITE_DENY
        is_allowed = action in READING or self._is_allowed(action, first)
        return sqlite3.SQLITE_OK if is_allowed else sqlite3.SQLITE_DENY

    def _is_allowed(self, action: int, first: str | None) -> bool:
        if self.phase == "setup" or action == sqlite3.SQLITE_FUNCTION:
            return True
        # json_each and the like announce their columns as updates of the schema table; query_only or a connection
        # that only reads stand behind
        announces = action == sqlite3.SQLITE_UPDATE and first in ("sqlite_master", "sqlite_schema")
        if announces and self.phase in ("read", "query"):
            return True
        if self.phase == "query":
            return action == sqlite3.SQLITE_PRAGMA and first in ASKED_PRAGMAS
        if action == sqlite3.SQLITE_PRAGMA:
            return first in OWN_PRAGMAS
        is_insert = action == sqlite3.SQLITE_INSERT and not str(first).startswith("sqlite_")
        return self.phase == "write" and is_insert
