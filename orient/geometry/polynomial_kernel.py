"""Horner's rule of `polynomial.values` in one loop over the points, compiled by numba (extra `orient[fast]`)."""

from collections.abc import Callable
from functools import cache

from numba import njit

_compiled = njit(cache=True, fastmath={"contract"}, error_model="numpy")


@cache
def horner(degree: int) -> Callable[..., None]:
    """z (n,) = sum a_jk u^j v^k, `a` (degree+1, degree+1).

    The degree is a constant of the machine code: the sums have no loops any more, and stay in registers.
    """

    @_compiled  # type: ignore[misc, unused-ignore]
    def values(u, v, a, z):  # type: ignore[no-untyped-def]
        for i in range(len(u)):
            total = a[0, degree]
            for k in range(degree - 1, -1, -1):
                inner = a[degree - k, k]
                for j in range(degree - k - 1, -1, -1):
                    inner = inner * u[i] + a[j, k]
                total = total * v[i] + inner
            z[i] = total

    return values  # type: ignore[no-any-return, unused-ignore]
