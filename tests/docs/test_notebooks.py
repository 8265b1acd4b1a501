"""The notebooks run as they stand, give the outputs that they show, and tell nothing of the machine they ran on."""

import getpass
import json
import os
import re
import socket
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
for needed in ("pandas", "matplotlib"):
    pytest.importorskip(needed)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_outputs_are_those_of_the_cells(path: Path) -> None:
    command = [sys.executable, ROOT / "docs" / "run_notebook.py", path, "--check"]
    plain = {name: os.environ[name] for name in ("HOME", "PATH", "TMPDIR") if name in os.environ}
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=plain, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_is_a_notebook_with_outputs_and_without_paths(path: Path) -> None:
    text = path.read_text("utf-8")
    notebook = json.loads(text)
    pytest.importorskip("nbformat").validate(notebook)
    shown = [cell for cell in notebook["cells"] if cell["cell_type"] == "code" and cell["outputs"]]
    assert len(shown) >= 7
    without_pictures = re.sub(r'"image/png": "[^"]+"', "", text)
    for word in ("/tmp", "/home", "/root", "/Users", str(ROOT), socket.gethostname(), f'"{getpass.getuser()}"'):
        assert word not in without_pictures, word


def test_the_reader_of_the_file_needs_nothing_of_orient() -> None:
    cells = json.loads((ROOT / "docs" / "notebooks" / "audit.ipynb").read_text("utf-8"))["cells"]
    code = "".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    assert set(re.findall(r"^\s*(?:import|from) (\w+)", code, re.MULTILINE)) == {"sqlite3", "numpy", "pandas"}


def test_the_other_notebook_needs_no_sql() -> None:
    cells = json.loads((ROOT / "docs" / "notebooks" / "door.ipynb").read_text("utf-8"))["cells"]
    code = "".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    assert not re.search(r"\b(SELECT|sqlite3)\b", code)


@pytest.mark.parametrize("change", ["stream", "html"])
def test_a_changed_output_would_be_found(change: str) -> None:
    sys.path.insert(0, str(ROOT / "docs"))
    import run_notebook

    notebook = json.loads((ROOT / "docs" / "notebooks" / "audit.ipynb").read_text("utf-8"))
    other = json.loads(json.dumps(notebook))
    for cell in other["cells"]:
        for out in cell.get("outputs", []):
            if change == "stream" and "text" in out:
                out["text"] = ["something else"]
            if change == "html" and "text/html" in out.get("data", {}):
                out["data"]["text/html"] = ["something else"]
    assert run_notebook.comparable(other) != run_notebook.comparable(notebook)
