"""Every command on every sample fits a terminal of 80 columns; without colour or Unicode it says the same."""

import re
from functools import cache
from pathlib import Path

import pytest

from orient.pipeline.registry import ALL_STAGES
from orient.report.questions import QUESTIONS
from orient.report.terminal import folded
from tests.cli.commands import SAMPLES, orient
from tests.cli.terminal import in_terminal, on_screen, plain, too_wide

NAMES = sorted(path.name for path in SAMPLES.iterdir() if (path / "photo.toml").exists())
COLOURS = re.compile(r"\x1b\[[0-9;]*\b(3[0-8]|4[0-8]|9[0-7]|10[0-7])\b[0-9;]*m")


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> "Made":
    @cache
    def project(name: str) -> Path:
        path = tmp_path_factory.mktemp(name) / "p.sqlite"
        assert orient("new", path, "--from", SAMPLES / name).code == 0
        orient("run", path)
        orient("verify", path)
        return path

    return project


Made = type(lambda name: Path())


def commands(path: Path) -> list[list[object]]:
    shown = [["show", path, stage] for stage in (*ALL_STAGES, "verify")]
    asked = [["sql", path, question.name] for question in QUESTIONS]
    others = [
        ["status", path],
        ["log", path],
        ["show", path],
        ["diff", path, "photo", 1, 1],
        ["check", path],
        ["run", path],
        ["explain", path],
        ["sql", path, "SELECT * FROM v_version"],
        ["sql", path, "--list"],
    ]
    return [*shown, *asked, *others]


@pytest.mark.parametrize("name", NAMES)
def test_every_command_fits_eighty_columns(name: str, made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERM", "xterm")
    path = made(name)
    wide = {}
    for words in commands(path):
        _, text = on_screen(*words)
        if lines := too_wide(text, 80, path):
            wide[" ".join(map(str, words[:1] + words[2:]))] = lines[:2]
        assert "…" not in text, words
    assert wide == {}


def test_nothing_is_lost_by_folding(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    """The words and numbers on the terminal are those that a file gets."""
    path = made("calgary-28")
    monkeypatch.setenv("COLUMNS", "80")
    for words in (["show", path, "resection"], ["status", path], ["show", path, "covariance"]):
        _, text = on_screen(*words)
        assert set(orient(*words).out.split()) - set(text.split()) <= rules(orient(*words).out)


def rules(text: str) -> set[str]:
    """Lines under the heads of tables are as long as the table."""
    return {word for word in text.split() if set(word) <= set("─-")}


@pytest.mark.parametrize("columns", [80, 40])
@pytest.mark.parametrize("words", [("show",), ("status",), ("sql", "residuals"), ("log",), ("explain",)], ids=" ".join)
def test_in_a_real_terminal(words: tuple[str, ...], columns: int, made: Made) -> None:
    path = made("calgary-28")
    code, text = in_terminal(words[0], path, *words[1:], columns=columns)
    assert code == 0
    assert too_wide(text, columns, path) == []
    piped = orient(words[0], path, *words[1:]).out
    numbers = set(re.findall(r"-?\d+\.\d{3,}", piped))
    assert numbers <= set(re.findall(r"-?\d+\.\d{3,}", plain(text)))


def test_run_shows_progress_and_one_line_for_each_stage(tmp_path: Path) -> None:
    path = tmp_path / "p.sqlite"
    assert orient("new", path, "--from", SAMPLES / "simulated-space-krasovsky").code == 0
    code, text = in_terminal("run", path, columns=80)
    assert code == 0
    assert "resection: exterior orientation" in text  # the moving line, while it computes
    for stage in ("refine", "digitize", "bl", "topocentric", "resection", "covariance"):
        found = [line for line in plain(text).split("\n") if line.startswith(f"{stage:<12} version 1")]
        assert len(found) == 1
    assert too_wide(text, 80, path) == []


POOR = {
    "no colour": {"NO_COLOR": "1"},
    "dumb": {"TERM": "dumb"},
    "ascii": {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0", "PYTHONIOENCODING": "ascii"},
    "no terminal known": {"TERM": ""},
}


@pytest.mark.parametrize("env", POOR.values(), ids=POOR)
def test_poor_terminals(env: dict[str, str], made: Made, tmp_path: Path) -> None:
    """No colour where none is wanted, no escape on a dumb terminal, ASCII in ASCII; the same words and numbers."""
    path = made("calgary-28")
    fresh = tmp_path / "p.sqlite"
    assert orient("new", fresh, "--from", SAMPLES / "calgary-28").code == 0
    code, running = in_terminal("run", fresh, columns=80, env=env)
    assert code == 0, running
    for words in (["show", path], ["status", path], ["sql", path, "residuals"], ["explain", path]):
        code, text = in_terminal(*words, columns=80, env=env)
        assert code == 0, text
        wanted = set(re.findall(r"[\w+]+", orient(*words).out))
        assert wanted <= set(re.findall(r"[\w+]+", plain(text)))
        for output in (running, text):
            assert not COLOURS.search(output) or "NO_COLOR" not in env
            if env.get("TERM") == "dumb":
                assert "\x1b" not in output
            if "LC_ALL" in env:
                assert output.isascii()


def test_a_long_word_stays_whole() -> None:
    word = "x" * 50
    assert folded(f"  see {word} and more words", 30) == f"  see\n    {word}\n    and more words"
    assert folded("short", 30) == "short"
