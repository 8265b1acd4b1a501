"""NIST StRD: 27 nonlinear problems, two starts each, through the loop of every stage; RELIABILITY 8.1."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from orient.solvers.engines import Engine
from orient.solvers.functional_iteration import Iterated, Termination, cofactor_matrix, iterate
from tests.solvers.nist_strd import FOLDER, MODELS, Certified, Curve, CurveEquations, FloatArray, certified

CERTIFIED_DIGITS = 11.0
EXACT_FIT = "Lanczos1"
"""Its residuals, and with them its standard errors, are rounding noise of the certified values."""


@dataclass(frozen=True)
class Score:
    """Agreeing digits (log relative error) of the worst parameter and of the worst standard error of one run."""

    name: str
    start: int
    parameters: float
    standard_errors: float
    iterated: Iterated[FloatArray, CurveEquations]

    def __str__(self) -> str:
        end = self.iterated
        return (
            f"{self.name:9} start {self.start}  LRE of parameters {self.parameters:5.2f}"
            f"  of standard errors {self.standard_errors:5.2f}"
            f"  {end.termination} after {len(end.steps)}, condition ratio {end.condition_ratio:.0e}"
        )


def digits(found: FloatArray, certified_values: FloatArray) -> float:
    """min_j -log10 |found - certified| / |certified|, between 0 and the 11 digits that are certified."""
    with np.errstate(all="ignore"):
        lre = -np.log10(np.abs(found - certified_values) / np.abs(certified_values))
    return float(np.clip(np.min(np.nan_to_num(lre, nan=0.0, posinf=CERTIFIED_DIGITS)), 0.0, CERTIFIED_DIGITS))


def solved(data: Certified, start: int, engine: Engine) -> Score:
    polish = None if engine is Engine.QR else Curve(data, Engine.QR)
    end = iterate(Curve(data, engine), data.starts[start - 1], polish=polish, tolerance=1e-13, max_iterations=1000)
    if end.termination is not Termination.CONVERGED:
        return Score(data.name, start, digits(end.state, data.parameters), 0.0, end)
    sigma = np.sqrt(np.diag(cofactor_matrix(end.linear)) * end.linear.vPv / data.redundancy)
    return Score(data.name, start, digits(end.state, data.parameters), digits(sigma, data.standard_errors), end)


@cache
def scores(engine: Engine) -> tuple[Score, ...]:
    return tuple(solved(certified(name), start, engine) for name in MODELS for start in (1, 2))


def table(engine: Engine) -> str:
    """What a failing test prints."""
    return "\n".join(["", *map(str, scores(engine))])


def test_all_files_of_the_set_are_there() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.dat")) == sorted(MODELS)
    assert len(MODELS) == 27


@pytest.mark.parametrize("name", MODELS)
def test_certified_values_leave_the_certified_sum_of_squares(name: str) -> None:
    """The model, its transcription and the file belong together."""
    data = certified(name)
    v = MODELS[name](data.parameters, data.x) - data.y
    if name != EXACT_FIT:
        assert float(v @ v) == pytest.approx(data.vPv, rel=1e-8)


def test_rat43_has_eleven_degrees_of_freedom() -> None:
    """Its file prints 9; its residual standard deviation 28.262414662 is that of 15 - 4."""
    data = certified("Rat43")
    assert np.sqrt(data.vPv / data.redundancy) == pytest.approx(2.8262414662e1, rel=1e-10)


@pytest.mark.parametrize("engine", Engine)
def test_all_54_runs_are_solved(engine: Engine) -> None:
    unsolved = [score for score in scores(engine) if score.parameters < 4]
    assert not unsolved, table(engine)
    assert all(score.iterated.termination is Termination.CONVERGED for score in scores(engine)), table(engine)


@pytest.mark.parametrize("engine", Engine)
def test_digits_of_the_parameters(engine: Engine) -> None:
    """Mean 10.74, least 10.33 with exact derivatives, scaled columns and QR in the last step."""
    lre = [score.parameters for score in scores(engine)]
    assert np.mean(lre) >= 10.5, table(engine)
    assert min(lre) >= 9.5, table(engine)


@pytest.mark.parametrize("engine", Engine)
def test_digits_of_the_standard_errors(engine: Engine) -> None:
    lre = {(score.name, score.start): score.standard_errors for score in scores(engine)}
    assert np.mean([value for (name, _), value in lre.items() if name != EXACT_FIT]) >= 10, table(engine)
    assert min(value for (name, _), value in lre.items() if name != EXACT_FIT) >= 9, table(engine)


def test_the_engines_agree() -> None:
    """Issue 3, 1: to 1e-9 relative; parameters and standard errors (not of the fit whose residuals are rounding)."""
    for by_Z, by_qr in zip(scores(Engine.ZLATANOV), scores(Engine.QR), strict=True):
        np.testing.assert_allclose(by_Z.iterated.state, by_qr.iterated.state, rtol=1e-9, err_msg=str(by_Z))
        if by_Z.name != EXACT_FIT:
            of_Z, of_qr = (np.sqrt(np.diag(cofactor_matrix(s.iterated.linear))) for s in (by_Z, by_qr))
            np.testing.assert_allclose(of_Z, of_qr, rtol=1e-9, err_msg=str(by_Z))
