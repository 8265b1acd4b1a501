"""What each setting of a stage may be, for the command line and for Python alike. Imports no mathematics."""

from collections.abc import Callable, Mapping
from typing import Any

from orient.errors import UsageError
from orient.values import Settings

CAMERA_ELEMENTS = ("f", "x0", "y0", "k1", "k2", "k3", "p1", "p2", "b1", "b2")
LARGEST_TOLERANCE = 1e-4
SMALLEST_SIGMA, LARGEST_SIGMA = 1e-12, 1e8
MOST_ITERATIONS = 1000
MAP_SIDES = (2, 101)
DEGREES = (1, 5)
WORDS: Mapping[str, tuple[str, ...]] = {
    "engine": ("zlatanov", "qr"),
    "choice": ("f-test", "leave-one-out"),
    "radius": ("exact", "polynomial"),
    "control": ("auto", "fixed", "weighted"),
    "correlation": ("sheet", "point"),
    "interior": ("weighted", "fixed"),
    "test": ("auto", "w", "tau"),
    "variance": ("posteriori", "priori"),
    "camera": ("fixed", "weighted"),
    "calibrate": ("none", "auto"),
    "distortion": ("camera", "correction", "displacement", "ideal_to_distorted"),
}
FLAGS = ("reject", "robust", "allow_ballpark", "free_camera", "pairs", "upside_down", "small_angles")
TEXTS = ("exclude", "exclude_reason")


def check_settings(settings: Settings) -> None:
    """`UsageError` for the first setting that is not what its stage can take."""
    for name, value in settings.items():
        expected = _refusal(name, value)
        if expected:
            raise UsageError(f"{name} = {value!r} is not {expected}")
    if settings.get("exclude") and not str(settings.get("exclude_reason") or "").strip():
        raise UsageError("say why the points are left out", 'Give exclude_reason, e.g. "wrong house".')


def _refusal(name: str, value: Any) -> str:
    """What the value should have been; empty if it is that."""
    if name in WORDS:
        return "" if isinstance(value, str) and value in WORDS[name] else f"one of {', '.join(WORDS[name])}"
    if name in FLAGS:
        return "" if isinstance(value, bool) else "True or False"
    if name in TEXTS:
        return "" if isinstance(value, str) else "a text"
    expected, is_right = CHECKS[name]
    return "" if is_right(value) else expected


def _elements(value: Any) -> bool:
    if not isinstance(value, str):
        return False
    names = value.split(",")
    return value == "none" or names == [name for name in CAMERA_ELEMENTS if name in names]


def _whole(low: int, high: int) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


def _number(low: float, high: float) -> Callable[[Any], bool]:
    def is_right(value: Any) -> bool:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return is_number and low <= value <= high

    return is_right


def _or_none(check: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: value is None or check(value)


CHECKS: Mapping[str, tuple[str, Callable[[Any], bool]]] = {
    "estimate": (f"none or a list of {','.join(CAMERA_ELEMENTS)} in this order", _elements),
    "degree": (f"None or a whole number, {DEGREES[0]} to {DEGREES[1]}", _or_none(_whole(*DEGREES))),
    "max_iterations": (f"a whole number, 1 to {MOST_ITERATIONS}", _whole(1, MOST_ITERATIONS)),
    "map_side": (f"a whole number, {MAP_SIDES[0]} to {MAP_SIDES[1]}", _whole(*MAP_SIDES)),
    "tolerance": (
        f"a number above 0 and at most {LARGEST_TOLERANCE}",
        lambda value: _number(0.0, LARGEST_TOLERANCE)(value) and value > 0,
    ),
    "map_height_sigma_m": (f"a number, 0 to {LARGEST_SIGMA:g}", _number(0.0, LARGEST_SIGMA)),
    "sigma_model": (
        f"None or a number, {SMALLEST_SIGMA} to {LARGEST_SIGMA:g}",
        _or_none(_number(SMALLEST_SIGMA, LARGEST_SIGMA)),
    ),
}
