"""The closed formulas of `topocentric` in one loop over the points, compiled by numba (extra `orient[fast]`).

Without contracted products, so that the numbers are those of numpy. Numba keeps the machine code until this file
changes: who changes the formulas removes __pycache__.
"""

import numpy as np
from numba import njit

from orient.geodesy.topocentric import by_half_tangents

_compiled = njit(cache=True, error_model="numpy")
_by_half_tangents = _compiled(by_half_tangents)

BLOCK = 128


@_compiled  # type: ignore[misc, unused-ignore]
def topocentric(t_B, t_L, H, constants, T):  # type: ignore[no-untyped-def]
    """T (n, 3), a block of columns at a time: only loops over columns become vector instructions."""
    columns = np.empty((3, BLOCK))
    for begin in range(0, len(H), BLOCK):
        m = min(BLOCK, len(H) - begin)
        for i in range(m):
            at = begin + i
            columns[0, i], columns[1, i], columns[2, i] = _by_half_tangents(t_B[at], t_L[at], H[at], constants, None)
        for i in range(m):
            T[begin + i, 0], T[begin + i, 1], T[begin + i, 2] = columns[0, i], columns[1, i], columns[2, i]
