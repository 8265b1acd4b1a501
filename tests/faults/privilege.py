"""Tests run as root too, whom modes do not bind: a process that gives up this privilege."""

import ctypes
import os
import subprocess

import pytest

PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, CAPABILITY_VERSION = 24, 1, 2, 0x20080522


def without_privilege() -> None:
    """In a new process, before or instead of an exec: root loses the right to write what modes forbid."""
    if os.geteuid() == 0:
        system = ctypes.CDLL(None)
        system.prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)
        system.capset((ctypes.c_uint32 * 2)(CAPABILITY_VERSION, 0), (ctypes.c_uint32 * 6)())


def like_anybody() -> None:
    """In the new process: root neither writes nor reads what modes forbid."""
    if os.geteuid() == 0:
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_READ_SEARCH, 0, 0, 0)
    without_privilege()


@pytest.fixture(scope="session")
def modes_bind(tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("modes") / "closed"
    path.touch(0o444)
    words = ["sh", "-c", ': >> "$0"', str(path)]
    ended = subprocess.run(words, preexec_fn=without_privilege, check=False, capture_output=True)
    if ended.returncode == 0:
        pytest.skip("root cannot give up its privilege here, and modes do not bind root")
