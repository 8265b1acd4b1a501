"""The pages made from the code are up to date, and what README.md tells to type works."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
SHELL_BLOCK = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
RESULT_LINE = re.compile(r"^    ((?:[a-z]+ +version \d+   |Near-vertical, )\S.*)$", re.MULTILINE)
RUN = [sys.executable, "-c", "from orient.cli.main import run; run()"]
DEADLINE_S = 120


def command_names() -> list[str]:
    from typer.main import get_command

    from orient.cli.command_line import command_line

    return list(get_command(command_line()).commands)  # type: ignore[attr-defined]


def readme_commands() -> list[str]:
    """Lines `orient ...` of the sh blocks of README.md; a backslash at the end joins the next line."""
    text = README.read_text("utf-8") if README.exists() else ""
    blocks = "".join(block + "\n" for block in SHELL_BLOCK.findall(text)).replace("\\\n", " ")
    lines = [line.strip().removeprefix("$ ") for line in blocks.splitlines()]
    return [line for line in lines if line.startswith("orient ")]


@pytest.mark.parametrize("page", ["cli.md", "schema.md", "summary.md"])
def test_the_page_is_what_the_code_makes(page: str) -> None:
    from orient.cli import reference

    pages = {"cli.md": reference.command_page, "schema.md": reference.schema_page, "summary.md": reference.summary_page}
    made = pages[page]()
    assert (ROOT / "docs" / page).read_text("utf-8") == made, "run: make docs"


def test_every_command_is_documented() -> None:
    pages = [ROOT / "docs" / "cli.md", README]
    text = "\n".join(page.read_text("utf-8") for page in pages if page.exists())
    assert [name for name in command_names() if f"orient {name}" not in text] == []


def test_the_commands_of_the_readme_run(tmp_path: Path) -> None:
    """In order, in a folder with `sample_projects`; `# fails` after a command expects a non-zero exit.

    What the page shows of the results of stages, and of closed formulas, is what they said.
    """
    commands = readme_commands()
    if not commands:
        pytest.skip("README.md has no commands yet")
    (tmp_path / "sample_projects").symlink_to(ROOT / "sample_projects")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NO_COLOR": "1"}
    surprises, said = [], set[str]()
    for command in commands:
        words = shlex.split(command, comments=True)[1:]
        done = subprocess.run(
            [*RUN, *words],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=DEADLINE_S,
            check=False,
        )
        said |= {line.strip() for line in done.stdout.splitlines()}
        if (done.returncode != 0) != command.endswith("# fails"):
            surprises.append(f"{command}\n-> {done.returncode}\n{done.stdout[-500:]}{done.stderr[-500:]}")
    assert not surprises, "\n".join(surprises)
    results = RESULT_LINE.findall(README.read_text("utf-8"))
    assert results and [line for line in results if line not in said] == []
