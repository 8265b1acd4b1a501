"""When Gauss-Newton of one photo or of many has ended, and which points lead where there are many."""

import numpy as np
from numpy.typing import NDArray

LAST_STEP = 3e-9
"""Sum of |r| [rad] and |t| [camera distances]: Q, which is that of the place before the last step, is right to 1e-8."""
SMALL_STEP, LAST_IN_SIGMAS = 1e-5, 1e-6
"""Or a small one in standard deviations, for photos so weak that rounding alone makes larger steps."""
SINGULAR = 1e-14
"""Share of an unknown's weight that must be left when those before it are unknown too."""
MANY_POINTS, EVERY = 4000, 16
"""From so many points without errors on every 16th is solved first."""


def some_points(n: int) -> NDArray[np.intp]:
    """One of every sixteen, without the rhythm of a grid."""
    k = np.arange(n // EVERY)
    return EVERY * k + (k * 40503 >> 7) % EVERY
