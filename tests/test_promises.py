"""The table of promises itself: counts of two tests and of failing trials are added up, with and without workers."""

import re
import textwrap

import pytest

pytest_plugins = ["pytester"]

INNER = """
def test_one(promise):
    kept = promise("F1")
    for number in range(10):
        with kept.trial(f"number {number}"):
            assert number != 3
    kept.largest("s", 0.25)

def test_two(promise):
    with promise("F1").trial():
        pass
    with promise("F2").trial():
        pass
    promise("F1").largest("s", 0.5)

def test_three(promise):
    import pytest
    promise("F3")
    pytest.skip("no such machine")
"""


@pytest.mark.parametrize("workers", [(), ("-n", "2")], ids=["one process", "two workers"])
def test_table(workers: tuple[str, ...], pytester: pytest.Pytester) -> None:
    pytester.makeconftest('pytest_plugins = ["tests.promises"]')
    pytester.makepyfile(textwrap.dedent(INNER))
    pytester.makeini("[pytest]\nmarkers = promise")
    done = pytester.runpytest_subprocess(*workers, "--promises", "table/promises.md")
    done.assert_outcomes(passed=1, failed=1, skipped=1)
    out = done.stdout.str()
    assert "F1: number 3: AssertionError" in out
    table = (pytester.path / "table" / "promises.md").read_text().splitlines()[2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table]
    assert [[row[0], *row[2:]] for row in cells] == [
        ["F1", "11", "1", "largest s 0.5"],
        ["F2", "1", "0", ""],
        ["F3", "0", "0", "NOT TRIED"],
    ]
    assert re.search(r"^F1 +11 +1 ", out, re.MULTILINE)
