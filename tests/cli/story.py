"""The photo with a history of docs/audit.md: its own commands, run once."""

import sys
from pathlib import Path

from tests.cli.commands import ROOT

sys.path.insert(0, str(ROOT / "docs"))
import outputs

PAGE = ROOT / "docs" / "audit.md"


def make_story(folder: Path) -> Path:
    """calgary.sqlite in `folder`."""
    (folder / "sample_projects").symlink_to(ROOT / "sample_projects")
    for block in outputs.SETUP.findall(PAGE.read_text("utf-8")):
        outputs.said(block, folder)
    return folder / "calgary.sqlite"
