"""The 27 nonlinear problems of NIST StRD: models, certified files, and each as a problem for the iteration."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Model = Callable[[Any, Any], Any]
"""Model (b, x): real or complex parameters b, predictor x (n,) or (k, n) -> (n,)."""

FOLDER = Path(__file__).parents[1] / "data" / "nist-strd"
COMPLEX_STEP = 1e-200


def _saturation(b: Any, x: Any) -> Any:
    return b[0] * (1 - np.exp(-b[1] * x))


def _decay_over_line(b: Any, x: Any) -> Any:
    return np.exp(-b[0] * x) / (b[1] + b[2] * x)


def _two_gaussians(b: Any, x: Any) -> Any:
    peaks = b[2] * np.exp(-((x - b[3]) ** 2) / b[4] ** 2) + b[5] * np.exp(-((x - b[6]) ** 2) / b[7] ** 2)
    return b[0] * np.exp(-b[1] * x) + peaks


def _three_decays(b: Any, x: Any) -> Any:
    return b[0] * np.exp(-b[1] * x) + b[2] * np.exp(-b[3] * x) + b[4] * np.exp(-b[5] * x)


def _cubic_over_cubic(b: Any, x: Any) -> Any:
    return (b[0] + b[1] * x + b[2] * x**2 + b[3] * x**3) / (1 + b[4] * x + b[5] * x**2 + b[6] * x**3)


def _quadratic_over_quadratic(b: Any, x: Any) -> Any:
    return (b[0] + b[1] * x + b[2] * x**2) / (1 + b[3] * x + b[4] * x**2)


def _cycles(b: Any, x: Any) -> Any:
    year, second, third = 2 * np.pi * x / 12, 2 * np.pi * x / b[3], 2 * np.pi * x / b[6]
    yearly = b[0] + b[1] * np.cos(year) + b[2] * np.sin(year)
    return yearly + b[4] * np.cos(second) + b[5] * np.sin(second) + b[7] * np.cos(third) + b[8] * np.sin(third)


MODELS: dict[str, Model] = {
    "Misra1a": _saturation,
    "Chwirut2": _decay_over_line,
    "Chwirut1": _decay_over_line,
    "Lanczos3": _three_decays,
    "Gauss1": _two_gaussians,
    "Gauss2": _two_gaussians,
    "DanWood": lambda b, x: b[0] * x ** b[1],
    "Misra1b": lambda b, x: b[0] * (1 - (1 + b[1] * x / 2) ** -2),
    "Kirby2": _quadratic_over_quadratic,
    "Hahn1": _cubic_over_cubic,
    "Nelson": lambda b, x: b[0] - b[1] * x[0] * np.exp(-b[2] * x[1]),
    "MGH17": lambda b, x: b[0] + b[1] * np.exp(-x * b[3]) + b[2] * np.exp(-x * b[4]),
    "Lanczos1": _three_decays,
    "Lanczos2": _three_decays,
    "Gauss3": _two_gaussians,
    "Misra1c": lambda b, x: b[0] * (1 - (1 + 2 * b[1] * x) ** -0.5),
    "Misra1d": lambda b, x: b[0] * b[1] * x / (1 + b[1] * x),
    "Roszman1": lambda b, x: b[0] - b[1] * x - np.arctan(b[2] / (x - b[3])) / np.pi,
    "ENSO": _cycles,
    "MGH09": lambda b, x: b[0] * (x**2 + x * b[1]) / (x**2 + x * b[2] + b[3]),
    "Thurber": _cubic_over_cubic,
    "BoxBOD": _saturation,
    "Rat42": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)),
    "MGH10": lambda b, x: b[0] * np.exp(b[1] / (x + b[2])),
    "Eckerle4": lambda b, x: b[0] / b[1] * np.exp(-0.5 * ((x - b[2]) / b[1]) ** 2),
    "Rat43": lambda b, x: b[0] / (1 + np.exp(b[1] - b[2] * x)) ** (1 / b[3]),
    "Bennett5": lambda b, x: b[0] * (b[1] + x) ** (-1 / b[2]),
}


@dataclass(frozen=True)
class Certified:
    """One data file: observations y (n,), predictors x (n,) or (2, n), starts (2, u), certified values (u,)."""

    name: str
    y: FloatArray
    x: FloatArray
    starts: FloatArray
    parameters: FloatArray
    standard_errors: FloatArray
    vPv: float

    @property
    def redundancy(self) -> int:
        """n - u; the file of Rat43 prints 9 where 15 - 4 = 11 is right."""
        return len(self.y) - len(self.parameters)


def certified(name: str) -> Certified:
    """Contents of `name`.dat."""
    lines = (FOLDER / f"{name}.dat").read_text(encoding="ascii").splitlines()
    rows = [line.split("=")[1].split() for line in lines[40:60] if line.strip().startswith("b") and "=" in line]
    start_1, start_2, parameters, standard_errors = np.array(rows, dtype=np.float64).T
    vPv = next(float(line.split(":")[1]) for line in lines if line.startswith("Residual Sum of Squares:"))
    data = np.array([line.split() for line in lines[60:] if line.strip()], dtype=np.float64).T
    y, x = data[0], data[1] if len(data) == 2 else data[1:]
    y = np.log(y) if name == "Nelson" else y
    return Certified(name, y, x, np.array([start_1, start_2]), parameters, standard_errors, vPv)
