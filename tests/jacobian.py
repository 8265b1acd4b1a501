"""The one checker for all Jacobians."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def central_difference(f: Callable[[Array], ArrayLike], x: ArrayLike, steps: ArrayLike | float = 1e-6) -> Array:
    """J[..., j] = (f(x + h_j e_j) - f(x - h_j e_j)) / (2 h_j): shape of f, then m.

    `x` (m,), `steps` the h_j (m,) or one for all, in the units of x. f may return any shape.
    """
    point = np.asarray(x, dtype=np.float64)
    h = np.broadcast_to(np.asarray(steps, dtype=np.float64), point.shape)
    columns = []
    for j in range(len(point)):
        e = np.zeros_like(point)
        e[j] = h[j]
        columns.append((np.asarray(f(point + e)) - np.asarray(f(point - e))) / (2.0 * h[j]))
    return np.stack(columns, axis=-1)
