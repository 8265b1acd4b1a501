"""How the kernels of the solvers are compiled by numba (extra `orient[fast]`)."""

from numba import njit

# error_model: the default raises on division by zero, which forbids vector instructions
compiled = njit(cache=True, fastmath={"reassoc", "contract", "arcp", "nsz"}, error_model="numpy")
# within the function that makes the arrays it is plain that they do not overlap
inlined = njit(inline="always")
