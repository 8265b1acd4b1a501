"""docs/equations.md tells the truth: its functions can be imported, its tests exist, no equation is left out."""

import ast
import re
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from tests.docs.reached import all_names, reached_names

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "equations.md"
COLUMNS = 6
NUMBERED = {
    "000": range(1, 17),
    "002": (59, 108, 109, 110, 111),
    "003": range(1, 22),
    "004": range(1, 6),
}
NAMED = {
    "004": (
        "N",
        "N polynomial",
        "gamma",
        "axes of T",
        "T'",
        "(2) X'",
        "(2) Y'",
        "(2) Z'",
        "(3) x",
        "(3) y",
        "(4) rank",
    ),
    "pre": ("5.1 integral", "5.1 ARDC", "5.1 space", "5.1 Schut", "5.2 Brown", "5.2 table", "5.3 earth curvature"),
}
STATES = re.compile(r"later \(issue \d+\)|not built")


@dataclass(frozen=True)
class Equation:
    """One row of the page."""

    seed: str
    number: str
    formula: str
    slip: str
    function: str
    test: str

    @property
    def is_built(self) -> bool:
        return STATES.fullmatch(self.function) is None

    @property
    def id(self) -> str:
        return f"{self.seed}-{self.number}"


def read_page() -> tuple[Equation, ...]:
    lines = PAGE.read_text("utf-8").splitlines()
    rows = [line for line in lines if line.startswith("| ") and not line.startswith("| seed ")]
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in rows]
    assert [row for row in cells if len(row) != COLUMNS] == []
    return tuple(Equation(*row) for row in cells)


EQUATIONS = read_page()
BUILT = [equation for equation in EQUATIONS if equation.is_built]
NOT_YET = [equation for equation in EQUATIONS if not equation.is_built]


def names_in(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


@cache
def defined_in(path: Path) -> frozenset[str]:
    """`test_x` and `TestClass::test_x` of a test file."""
    found: set[str] = set()
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}::{part.name}" for part in node.body if isinstance(part, ast.FunctionDef)}
    return frozenset(found)


@pytest.mark.parametrize("equation", BUILT, ids=lambda equation: equation.id)
def test_its_functions_can_be_imported(equation: Equation) -> None:
    assert names_in(equation.function), f"{equation.id} names no function"
    for dotted in names_in(equation.function):
        module, name = dotted.rsplit(".", 1)
        assert dotted.startswith("orient.")
        assert callable(getattr(import_module(module), name, None)), f"{dotted} does not exist"


@pytest.mark.parametrize("equation", BUILT, ids=lambda equation: equation.id)
def test_its_functions_are_reached_from_a_command(equation: Equation) -> None:
    """An equation that only its test uses is no part of the program."""
    assert [dotted for dotted in names_in(equation.function) if dotted not in reached_names()] == []


def test_no_mathematics_is_left_unused() -> None:
    """`matrix_from_opk` is the definition of the triple that opk_from_matrix reads; scenes of tests are built by it."""
    floors = ("orient.geometry.", "orient.geodesy.", "orient.solvers.")
    unused = [
        name for name in sorted(all_names() - reached_names()) if name.startswith(floors) and name[-8:] != ".__all__"
    ]
    assert unused == ["orient.geometry.rotation.matrix_from_opk"]


@pytest.mark.parametrize("equation", BUILT, ids=lambda equation: equation.id)
def test_its_tests_exist(equation: Equation) -> None:
    assert names_in(equation.test), f"{equation.id} names no test"
    for named in names_in(equation.test):
        file, _, test = named.partition("::")
        assert test in defined_in(ROOT / file), f"{named} does not exist"


@pytest.mark.parametrize("seed", NUMBERED)
def test_every_numbered_equation_has_a_row(seed: str) -> None:
    cells = [equation.number for equation in EQUATIONS if equation.seed == seed]
    missing = [number for number in NUMBERED[seed] if not any(f"({number})" in cell for cell in cells)]
    assert missing == []


@pytest.mark.parametrize("seed", NAMED)
def test_every_named_equation_has_a_row(seed: str) -> None:
    cells = {equation.number for equation in EQUATIONS if equation.seed == seed}
    assert sorted(set(NAMED[seed]) - cells) == []


def test_no_row_stands_twice() -> None:
    ids = [equation.id for equation in EQUATIONS]
    assert sorted(ids) == sorted(set(ids))


def test_what_is_not_built_is_counted_on_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    later = [equation.id for equation in NOT_YET if equation.function.startswith("later")]
    others = len(NOT_YET) - len(later)
    with capsys.disabled():
        print(f"\nequations not built yet: {len(later)} ({', '.join(later)})")
    told = f"{len(EQUATIONS)} rows: {len(BUILT)} implemented, {len(later)} later, {others} not built."
    assert told in PAGE.read_text("utf-8")


def test_what_is_not_built_names_no_test() -> None:
    assert [equation.id for equation in NOT_YET if equation.test != "-"] == []
