"""Units at the border: degrees outside, radians inside; `42 30 15.5` is degrees, minutes, seconds."""

import math
import re
from collections.abc import Sequence

RADIANS_PER_DEGREE = math.pi / 180.0
DEGREES_PER_RADIAN = 180.0 / math.pi
ARC_SECONDS_PER_RADIAN = 3600.0 * DEGREES_PER_RADIAN

NUMBER = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]{1,3})?|[+-]?\.[0-9]+([eE][+-]?[0-9]{1,3})?", re.ASCII)
"""The one grammar of a number in any input of orient; `float()` alone accepts far too much."""


def format_dms(degrees: float, seconds_decimals: int = 2) -> str:
    """Decimal degrees as `-42 30 15.50`, rounded once so that 59.999 seconds carry over."""
    scale = 10**seconds_decimals
    ticks = round(abs(degrees) * 3600 * scale)
    whole_seconds, fraction = divmod(ticks, scale)
    minutes, seconds = divmod(whole_seconds, 60)
    whole_degrees, minutes = divmod(minutes, 60)
    sign = "-" if degrees < 0 and ticks else ""
    tail = f".{fraction:0{seconds_decimals}d}" if seconds_decimals else ""
    return f"{sign}{whole_degrees} {minutes:02d} {seconds:02d}{tail}"


def in_words(metres: float) -> str:
    """A length for a sentence: `1 mm`, `80 m`, `5,000 km`."""
    if metres < 1.0:
        return f"{1000 * metres:.2g} mm"
    return f"{metres:,.4g} m" if metres < 10_000 else f"{metres / 1000:,.4g} km"


def listed(names: Sequence[str], most: int = 10) -> str:
    """`A, B, C and 7 more`."""
    text = ", ".join(names[:most])
    return text + (f" and {len(names) - most} more" if len(names) > most else "")


def wrap_half_turn(angle: float) -> float:
    """The same angle in (-pi, pi] [rad]."""
    wrapped = math.remainder(angle, 2 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped
