"""300 damaged files: none crashes, none hangs, none passes `orient check` with other content than was stored."""

import random
import time
from pathlib import Path

from orient.store.check import check_project
from tests.promises import Promise
from tests.store.mutations import KINDS, content_of


def test_no_damage_passes_unseen(full: Path, tmp_path: Path, promise: Promise) -> None:
    original = full.read_bytes()
    meant = content_of(full)
    chance = random.Random(300)
    path = tmp_path / "damaged.orient"
    found = harmless = 0
    for number in range(300):
        content = bytearray(original)
        kind = KINDS[number % len(KINDS)]
        kind(content, chance)
        path.write_bytes(content)
        started = time.monotonic()
        with promise("S3").trial(f"{kind.__name__}, number {number}"):
            ok = check_project(path).ok
            assert time.monotonic() - started < 3
            found, harmless = found + (not ok), harmless + ok
        with promise("F11").trial(f"{kind.__name__}, number {number}"):
            assert not ok or content_of(path) == meant
    assert found > 150
    assert harmless > 10
