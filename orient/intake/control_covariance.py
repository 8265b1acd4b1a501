"""Covariance of a control point from its standard deviations or from its six covariances."""

from collections.abc import Sequence

from orient.intake.cells import CellReader
from orient.values import Scalar

COVARIANCES = ("cov_XX_m2", "cov_XY_m2", "cov_XZ_m2", "cov_YY_m2", "cov_YZ_m2", "cov_ZZ_m2")
SIGMAS_HORIZON = ("sigma_N_m", "sigma_E_m", "sigma_H_m")
SIGMAS_XYZ = ("sigma_X_m", "sigma_Y_m", "sigma_Z_m")
AXES = "XYZ"
LARGEST_VARIANCE = 1e15
SMALLEST_EIGENVALUE_RATIO = 1e-13
HINT = "Leave all of them empty for a point that is taken as known"

Known = tuple[bool, bool, bool]
"""Which of X, Y, Z (or north, east, up) of the point are given."""


def read_covariance(cells: CellReader, sigma_columns: tuple[str, ...], known: Known) -> dict[str, Scalar]:
    """The six columns cov_*; all None for a point taken as known, None for the axes that are not known."""
    has_sigma = any(cells.has(column) for column in sigma_columns)
    has_covariance = any(cells.has(column) for column in COVARIANCES)
    if has_sigma and has_covariance:
        cells.problem("give standard deviations or covariances of a point, not both")
    elif has_sigma:
        return _from_sigmas(cells, sigma_columns, known)
    elif has_covariance:
        return _from_covariances(cells, known)
    return dict.fromkeys(COVARIANCES)


def _from_sigmas(cells: CellReader, sigma_columns: tuple[str, ...], known: Known) -> dict[str, Scalar]:
    covariance: dict[str, Scalar] = dict.fromkeys(COVARIANCES)
    for axis, column, is_known in zip(AXES, sigma_columns, known, strict=True):
        sigma = cells.sigma(column, "Leave the sigmas empty for a point that is taken as known")
        _check_presence(cells, column, is_known)
        covariance[f"cov_{axis}{axis}_m2"] = None if sigma is None else sigma * sigma
    for column in ("cov_XY_m2", "cov_XZ_m2", "cov_YZ_m2"):
        if all(_is_known(axis, known) for axis in column[4:6]):
            covariance[column] = 0.0
    return covariance


def _from_covariances(cells: CellReader, known: Known) -> dict[str, Scalar]:
    covariance: dict[str, Scalar] = {}
    for column in COVARIANCES:
        covariance[column] = cells.number(column, LARGEST_VARIANCE)
        _check_presence(cells, column, all(_is_known(axis, known) for axis in column[4:6]))
    if cells.ok:
        axes = [axis for axis in AXES if _is_known(axis, known)]
        check_positive_definite(cells, [[covariance[f"cov_{min(i, j)}{max(i, j)}_m2"] for j in axes] for i in axes])
    return covariance


def _is_known(axis: str, known: Known) -> bool:
    return known[AXES.index(axis)]


def _check_presence(cells: CellReader, column: str, is_known: bool) -> None:
    if is_known and not cells.has(column):
        cells.problem(f'column "{column}": value is missing', HINT)
    elif cells.has(column) and not is_known:
        cells.problem(f'column "{column}": given for a coordinate that is missing')


def check_positive_definite(cells: CellReader, covariance: Sequence[Sequence[Scalar]]) -> None:
    """A problem of the line if the covariance matrix has an eigenvalue that is not above zero."""
    import numpy as np

    eigenvalues = np.linalg.eigvalsh(np.array(covariance, dtype=np.float64))
    if eigenvalues[0] <= SMALLEST_EIGENVALUE_RATIO * abs(eigenvalues[-1]):
        cells.problem(f"covariance matrix is not valid (eigenvalue {eigenvalues[0]:.1g})")
