"""Numbers and angles of a text cell: one ASCII grammar, then `float()`, then finite, then the range."""

import math
import re
import sys
import unicodedata

from orient.intake.findings import BadValue, shown
from orient.intake.options import ReadOptions
from orient.units import NUMBER

LONGEST_NUMBER = 40
SMALLEST_SIGMA = 1e-12
"""Below this a standard deviation is a zero in disguise."""

DECIMAL_COMMA = re.compile(r"[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]{1,3})?", re.ASCII)
THOUSANDS = re.compile(r"[+-]?[0-9]{1,3}([ '’\u00a0\u2009\u202f,.][0-9]{3})+([.,][0-9]*)?", re.ASCII)
NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
SEXAGESIMAL = re.compile(
    r"(?P<sign>[+-]?)(?P<deg>[0-9]{1,3})[° ] *(?P<min>[0-9]{1,2})"
    r"(?:(?P<min_part>\.[0-9]*)? *['′’]?|['′’ ] *(?P<sec>[0-9]{1,2}(?:\.[0-9]*)?) *(?:\"|″|”|'')?)",
    re.ASCII,
)


def parse_number(text: str, options: ReadOptions) -> float:
    """The finite number that the cell holds; -0.0 becomes 0.0. Raises `BadValue` with the reason."""
    body = text.strip(" \t")
    if not body:
        raise BadValue("value is missing")
    if len(body) > LONGEST_NUMBER:
        raise BadValue(f"number longer than {LONGEST_NUMBER} characters")
    plain = _with_point(body, options)
    if not NUMBER.fullmatch(plain):
        raise _not_a_number(body, options)
    value = float(plain)
    if math.isinf(value):
        raise BadValue(f'"{body}" is too large')
    mantissa = re.split("[eE]", plain)[0]
    if abs(value) < sys.float_info.min and re.search("[1-9]", mantissa):
        raise BadValue(f'"{body}" is too small to be a measurement')
    return value + 0.0


def parse_angle(text: str, options: ReadOptions) -> float:
    """Degrees of `42.504`, `42 30.25`, `42 30 15.5` or `42°30'15.5"`; the sign of `-0 30 15` counts."""
    body = text.strip(" \t")
    parts = SEXAGESIMAL.fullmatch(_with_point(body, options)) if len(body) <= LONGEST_NUMBER else None
    if parts is None:
        return parse_number(body.removesuffix("°"), options)
    minutes = float(parts["min"] + (parts["min_part"] or ""))
    seconds = float(parts["sec"] or 0)
    for name, value in (("minutes", minutes), ("seconds", seconds)):
        if value >= 60:
            raise BadValue(f"{value:g} {name} are not less than 60")
    size = (float(parts["deg"]) * 3600 + minutes * 60 + seconds) / 3600
    return (-size if parts["sign"] == "-" else size) + 0.0


def parse_whole(text: str, low: int, high: int) -> int:
    body = text.strip(" \t")
    if not body:
        raise BadValue("value is missing")
    if not re.fullmatch("[+-]?[0-9]{1,18}", body, re.ASCII):
        raise BadValue(f'"{shown(body)}" is not a whole number')
    return int(check_range(int(body), low, high))


def check_range(value: float, low: float, high: float, unit: str = "", hint: str = "") -> float:
    if not low <= value <= high:
        tail = f" {unit}" if unit else ""
        raise BadValue(f"{plain(value)}{tail} is not in {plain(low)} … {plain(high)}{tail}", hint)
    return value


def check_sigma(value: float, hint: str = "") -> float:
    if value < SMALLEST_SIGMA:
        raise BadValue("must be > 0", hint)
    return check_range(value, 0, 1e8)


def check_degrees(value: float, limit: float) -> float:
    hint = "Grads? Write degrees" if 90 < abs(value) <= 400 else ""
    return check_range(value, -limit, limit, hint=hint)


def east_of_half_turn(longitude: float) -> float:
    """Longitudes are kept as written, -180 ... 360; what lies below -180 gets a full turn."""
    return longitude + 360 if longitude < -180 else longitude


def plain(value: float) -> str:
    """A number in a message: 100,000 and 0.1, and 1e+300 for what nobody wants to read in full."""
    if abs(value) >= 1e15:
        return f"{value:.6g}"
    if float(value).is_integer():
        return f"{value:,.0f}"
    return f"{value:,.6f}".rstrip("0") if abs(value) >= 1e-5 else f"{value:g}"


def _with_point(body: str, options: ReadOptions) -> str:
    if options.decimal == "point":
        return body
    if "." in body:
        raise BadValue(f'"{shown(body)}": decimal point found, but --decimal comma was given')
    return body.replace(",", ".")


def _not_a_number(body: str, options: ReadOptions) -> BadValue:
    quoted = f'"{shown(body)}"'
    if "_" in body:
        return BadValue(f"{quoted} is not a number (underscore)")
    if dash := next((c for c in body if unicodedata.category(c) in ("Pd", "Sm") and ord(c) > 127), ""):
        return BadValue(f'the minus sign of {quoted} is not "-" (U+{ord(dash):04X})')
    if NOT_FINITE.fullmatch(body):
        return BadValue(f"{quoted} is not a number orient accepts")
    if any(character.isnumeric() and not character.isascii() for character in body):
        return BadValue(f"{quoted} is not a number: digits must be 0-9")
    if options.decimal == "point" and DECIMAL_COMMA.fullmatch(body):
        return BadValue(f"{quoted}: decimal comma found", "Use a point, or --decimal comma")
    if THOUSANDS.fullmatch(body):
        return BadValue(f"{quoted} is not a number (thousands separator)")
    return BadValue(f"{quoted} is not a number")
