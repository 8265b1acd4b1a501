"""What a local worker does before its first photo: import the mathematics once, leave Ctrl-C to the coordinator."""

import signal
from importlib import import_module
from typing import Any

from orient import __version__
from orient.pipeline.registry import STAGES


def dask_setup(worker: Any) -> None:
    """Called by dask when the worker starts (`preload`)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for stage in STAGES:
        import_module(f"orient.pipeline.{stage.name}")


def version() -> str:
    """What must be the same on every worker: orient and the versions of its computations."""
    return f"orient {__version__} ({', '.join(f'{stage.name} {stage.version}' for stage in STAGES)})"
