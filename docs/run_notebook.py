"""Runs a notebook and writes its outputs: `python docs/run_notebook.py docs/notebooks/door.ipynb [--check]`.

A notebook starts in a new folder with `sample_projects` and, where its metadata names a page, with what the ```sh
blocks of that page make. Cells share one namespace, the last expression of a cell is shown, as in Jupyter.
"""

import ast
import base64
import contextlib
import io
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
import outputs

Notebook = dict[str, Any]
Output = dict[str, Any]


def executed(notebook: Notebook, folder: Path) -> Notebook:
    """The notebook with the outputs that its cells give now, in `folder`."""
    prepare(notebook, folder)
    names: dict[str, Any] = {"__name__": "__main__"}
    before = Path.cwd()
    os.chdir(folder)
    try:
        cells, count = [], 0
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                count += 1
                cell = {**cell, "execution_count": count, "outputs": run_cell("".join(cell["source"]), names, count)}
            cells.append(cell)
    finally:
        os.chdir(before)
    return {**notebook, "cells": cells}


def prepare(notebook: Notebook, folder: Path) -> None:
    """What the notebook finds when it starts."""
    (folder / "sample_projects").symlink_to(outputs.ROOT / "sample_projects")
    page = notebook["metadata"].get("orient", {}).get("page")
    for block in outputs.SETUP.findall((outputs.ROOT / page).read_text("utf-8")) if page else ():
        outputs.said(block, folder)


def run_cell(source: str, names: dict[str, Any], count: int) -> list[Output]:
    """What one cell prints and shows."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, shown = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "<cell>", "exec"), names)
        if isinstance(last, ast.Expr):
            shown = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    found: list[Output] = []
    if printed.getvalue():
        found.append({"name": "stdout", "output_type": "stream", "text": lines(printed.getvalue())})
    if shown is not None:
        found.append(
            {"data": mime_bundle(shown), "execution_count": count, "metadata": {}, "output_type": "execute_result"}
        )
    return found


def mime_bundle(value: Any) -> dict[str, Any]:
    """The forms in which a notebook shows a value; a picture as PNG."""
    bundle: dict[str, Any] = {}
    if hasattr(value, "_repr_png_"):
        bundle["image/png"] = base64.b64encode(value._repr_png_()).decode("ascii")
    elif hasattr(value, "_repr_html_"):
        bundle["text/html"] = lines(value._repr_html_())
    bundle["text/plain"] = lines(repr(value))
    return bundle


def lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def comparable(notebook: Notebook) -> list[Any]:
    """Everything but the bytes of pictures, which depend on fonts and libraries."""
    told = []
    for cell in notebook["cells"]:
        outs = json.loads(json.dumps(cell.get("outputs", [])))
        for out in outs:
            if "image/png" in out.get("data", {}):
                out["data"]["image/png"] = out["data"]["image/png"][:8]
        told.append((cell["cell_type"], cell["source"], outs))
    return told


def main(arguments: list[str]) -> int:
    stale = []
    for path in [Path(name).absolute() for name in arguments if name != "--check"]:
        notebook = json.loads(path.read_text("utf-8"))
        with tempfile.TemporaryDirectory() as folder:
            new = executed(notebook, Path(folder))
        if "--check" not in arguments:
            path.write_text(json.dumps(new, indent=1, ensure_ascii=False) + "\n", "utf-8")
        elif comparable(new) != comparable(notebook):
            stale.append(path)
    for path in stale:
        print(f"{path} is not up to date; run: python docs/run_notebook.py {path}", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
