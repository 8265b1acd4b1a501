"""Real commands with a fault: started by a server that has everything imported (victims_server.py)."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from tests.cli.commands import ROOT

LIBRARY = Path(__file__).with_name("fault_library.c")
KILLED = -signal.SIGKILL


@dataclass(frozen=True)
class Fault:
    """What happens to a command. In `folder` its `at`-th call that changes a file is killed (error 0) or fails."""

    folder: str = ""
    at: int = 0
    error: int = 0
    forever: bool = False
    log: str = ""
    synchronous: str | None = None
    patience_s: tuple[float, float] | None = None
    before_computing: tuple[str, ...] | None = None
    watched: str | None = None
    umask: int | None = None
    clock_s: int | None = None
    unprivileged: bool | None = None
    file_size: int | None = None
    max_pages: int | None = None
    more_memory: int | None = None


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit code (negative: killed by that signal), its texts, how long it took."""

    code: int
    out: str
    err: str
    seconds: float


@cache
def fault_library() -> Path | None:
    """The compiled library, None without a C compiler or on a system without preloading."""
    compiler = shutil.which("cc")
    if compiler is None or not sys.platform.startswith("linux"):
        return None
    target = Path(tempfile.mkdtemp(prefix="orient-faults-")) / "fault_library.so"
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", target, LIBRARY, "-ldl"], check=True)
    return target


class Started:
    def __init__(self, server: "Victims", number: int, out: Path, err: Path) -> None:
        self.server, self.number, self.out, self.err = server, number, out, err
        self.begun = time.monotonic()

    def send(self, number: int) -> None:
        with suppress(ProcessLookupError):
            os.kill(self.number, number)

    def ended(self) -> Ended:
        code = int(self.server.asked({"wait": self.number}))
        seconds = time.monotonic() - self.begun
        texts = (path.read_text(encoding="utf-8", errors="replace") for path in (self.out, self.err))
        return Ended(code, *texts, seconds)


class Victims:
    """The server. Commands may be started side by side."""

    def __init__(self) -> None:
        self.texts = Path(tempfile.mkdtemp(prefix="orient-victims-"))
        library = fault_library()
        preload = {"LD_PRELOAD": str(library)} if library else {}
        self.server = subprocess.Popen(
            [sys.executable, "-m", "tests.faults.victims_server"],
            cwd=ROOT,
            env={**os.environ, **preload, "OPENBLAS_NUM_THREADS": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.count = 0
        assert self._answer() == "ready"

    def _answer(self) -> str:
        assert self.server.stdout is not None
        return self.server.stdout.readline().strip()

    def asked(self, question: dict[str, object]) -> str:
        assert self.server.stdin is not None
        self.server.stdin.write(json.dumps(question) + "\n")
        self.server.stdin.flush()
        return self._answer()

    def start(self, *words: object, fault: Fault = Fault()) -> Started:
        self.count += 1
        out, err = (self.texts / f"{self.count}.{name}" for name in ("out", "err"))
        for path in (out, err):
            path.touch()  # the command may be killed before it opens them
        question = {**asdict(fault), "start": [str(word) for word in words], "out": str(out), "err": str(err)}
        return Started(self, int(self.asked(question)), out, err)

    def run(self, *words: object, fault: Fault = Fault()) -> Ended:
        return self.start(*words, fault=fault).ended()

    def killed_after(self, seconds: float, *words: object) -> Ended:
        started = self.start(*words)
        time.sleep(seconds)
        started.send(signal.SIGKILL)
        return started.ended()

    def close(self) -> None:
        self.server.communicate(timeout=30)
        shutil.rmtree(self.texts)
