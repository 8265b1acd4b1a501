"""Writes the outputs on a page anew: `python docs/outputs.py docs/audit.md [--check]`.

A block ```sh is run first, in a new folder with `sample_projects`; then each block ```console is a command after `$ `
and what it says. The user is anna; times differ from run to run and are not compared.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
SETUP = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
SHOWN = re.compile(r"^```console\n\$ (.*?)\n(.*?)^```", re.MULTILINE | re.DOTALL)
TIME = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d\.\d+Z)?")
WIDTH = "132"


def refreshed(text: str, folder: Path) -> str:
    """The page with its outputs as they are now; the project is made in `folder`."""
    (folder / "sample_projects").symlink_to(ROOT / "sample_projects")
    for block in SETUP.findall(text):
        said(block, folder)
    return SHOWN.sub(lambda match: f"```console\n$ {match[1]}\n{said(match[1], folder)}```", text)


def said(commands: str, folder: Path) -> str:
    """Standard output of shell commands, which must succeed."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "LOGNAME": "anna", "NO_COLOR": "1", "COLUMNS": WIDTH}
    environment["PYTHONPATH"] = str(ROOT)
    shell = ["sh", "-e", "-c", commands]
    done = subprocess.run(shell, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{commands}\n-> {done.returncode}\n{done.stderr}")
    return "".join(line.rstrip() + "\n" for line in done.stdout.splitlines())


def comparable(text: str) -> str:
    """Times are those of the day the page was made."""
    return TIME.sub("TIME", text)


def main(arguments: list[str]) -> int:
    pages, stale = [Path(name) for name in arguments if name != "--check"], []
    for page in pages:
        text = page.read_text("utf-8")
        with tempfile.TemporaryDirectory() as folder:
            new = refreshed(text, Path(folder))
        if "--check" not in arguments:
            page.write_text(new, "utf-8")
        elif comparable(new) != comparable(text):
            stale.append(page)
    for page in stale:
        print(f"{page} is not up to date; run: python docs/outputs.py {page}", file=sys.stderr)
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
