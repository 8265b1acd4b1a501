"""A power-cut simulator: replay what a command wrote, losing a random part of what was not synced.

The log is that of fault_library.c. The model of the disk (RELIABILITY.md 10): a written sector of 512 bytes is there or
not, in any order, until its file is synced; a sync of a file makes its own name durable too; changes of names land in
order; a sync of the folder makes all of them durable. Size changes are like writes.
"""

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

HEAD = struct.Struct("<8s4q")
SECTOR = 512


@dataclass(frozen=True)
class Call:
    """One call: w write, t truncate to `offset`, s sync, c create, u unlink, r rename, l link (path to other)."""

    kind: str
    path: str
    other: str
    offset: int
    content: bytes


def read_log(path: Path) -> list[Call]:
    return list(_calls(path.read_bytes())) if path.exists() else []


def _calls(log: bytes) -> Iterator[Call]:
    place = 0
    while place < len(log):
        kind, path, other, offset, length = HEAD.unpack_from(log, place)
        names = place + HEAD.size
        start = names + path + other
        place = start + length
        yield Call(
            kind[:1].decode(), log[names : names + path].decode(), log[names + path : start].decode(), offset,
            log[start:place],
        )  # fmt: skip


@dataclass
class Inode:
    """A file: its durable content, and what was done since its last sync."""

    content: bytearray
    pending: list[Call] = field(default_factory=list)
    names_before: int = 0
    """How many changes of names were made when it got its first name."""

    def after_cut(self, chance: Random) -> bytes:
        content = bytearray(self.content)
        share = chance.choice((0.0, 0.2, 0.5, 0.8, 1.0))
        for call in self.pending:
            _apply(content, call, chance, share)
        return bytes(content)

    def sync(self) -> None:
        for call in self.pending:
            _apply(self.content, call, Random(0), 1.0)
        self.pending.clear()


def _apply(content: bytearray, call: Call, chance: Random, share: float) -> None:
    """The sectors of a write, or a change of size, that reach the disk with probability `share`."""
    if call.kind == "t":
        if chance.random() < share:
            del content[call.offset :]
            content.extend(bytes(call.offset - len(content)))
        return
    for start in range(0, len(call.content), SECTOR):
        piece = call.content[start : start + SECTOR]
        if chance.random() < share:
            place = call.offset + start
            content.extend(bytes(max(0, place - len(content))))
            content[place : place + len(piece)] = piece


class Disk:
    """A folder on a disk that a command writes to, call by call."""

    def __init__(self, folder: Path, start: Path) -> None:
        self.folder = str(folder)
        self.names: dict[str, Inode] = {
            f"{folder}/{path.name}": Inode(bytearray(path.read_bytes())) for path in start.iterdir()
        }
        self.durable_names = dict(self.names)
        self.changes: list[Call] = []
        self.made: dict[int, Inode] = {}

    def do(self, call: Call) -> None:
        if call.kind == "s":
            self._sync(call.path)
        elif call.kind in "wt":
            if inode := self.names.get(call.path):  # a file without a name cannot come back
                inode.pending.append(call)
        else:
            self.changes.append(call)
            if call.kind == "c":
                self.made[id(call)] = Inode(bytearray(), names_before=len(self.changes))
            _rename(self.names, call, self.made)

    def _sync(self, path: str) -> None:
        if path == self.folder:
            self._keep_names(len(self.changes))
        elif inode := self.names.get(path):
            inode.sync()
            self._keep_names(inode.names_before)

    def _keep_names(self, count: int) -> None:
        for call in self.changes[:count]:
            _rename(self.durable_names, call, self.made)
        del self.changes[:count]
        for inode in self.names.values():
            inode.names_before = max(0, inode.names_before - count)

    def after_cut(self, chance: Random) -> dict[str, bytes]:
        """Names and contents as they may be found after the power came back."""
        names = dict(self.durable_names)
        for call in self.changes[: chance.randint(0, len(self.changes))]:
            _rename(names, call, self.made)
        found: dict[int, bytes] = {}
        for inode in names.values():
            if id(inode) not in found:
                found[id(inode)] = inode.after_cut(chance)
        return {name: found[id(inode)] for name, inode in names.items()}


def _rename(names: dict[str, Inode], call: Call, made: dict[int, Inode]) -> None:
    if call.kind == "c":
        names[call.path] = made[id(call)]
    elif call.kind == "u":
        names.pop(call.path, None)
    elif call.kind == "l":
        names[call.other] = names[call.path]
    elif call.path in names:
        names[call.other] = names.pop(call.path)


def cut(calls: Sequence[Call], at: int, folder: Path, start: Path, chance: Random) -> dict[str, bytes]:
    """The folder after a power cut before call number `at`; it held the files of `start` when the command began."""
    disk = Disk(folder, start)
    for call in calls[:at]:
        disk.do(call)
    return disk.after_cut(chance)


def write_out(found: dict[str, bytes], folder: Path) -> None:
    for path in folder.iterdir():
        path.unlink()
    for name, content in found.items():
        (folder / Path(name).name).write_bytes(content)
