"""v = h(F; c) - G(c) of a camera whose elements c are unknowns, written again for complex numbers.

F = f u by collinearity, q = measured - (x0, y0), B = [b1 b2; 0 0], a = refraction and curvature, d the lens:

    ideal_to_distorted        v = (I + B)(F - a + d(F - a)) - q
    correction, displacement  v = F - q -+ (d(q) + B q) - a

No partials: whoever wants them takes the complex step. Conventions 7; D. C. Brown 1971, OpenCV's rational model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
Values = Mapping[str, complex]


@dataclass(frozen=True, slots=True)
class IndependentCamera:
    """`names` (m,) of the unknown elements, `constants` every element and coefficient a priori, in its own unit.

    `cofactors` (m,): a-priori variance / sigma0^2, infinite for a free element. `frame` (n, 2) [mm] the readings before
    any correction of the camera, `air` (n, 2) what refraction and curvature add. `table` (k, 2): r, D(r) of a
    certificate.
    """

    names: Sequence[str]
    constants: Mapping[str, float]
    cofactors: FloatArray
    model: str
    direction: str
    table: FloatArray | None
    frame: FloatArray
    air: FloatArray

    @property
    def apriori(self) -> FloatArray:
        """(m,) values before the adjustment."""
        return np.array([self.constants.get(name, 0.0) for name in self.names])

    @property
    def observed(self) -> NDArray[np.intp]:
        """Places of the elements that have a standard deviation a priori."""
        return np.flatnonzero(np.isfinite(self.cofactors))

    def misclosures(self, slopes: ComplexArray, c: ComplexArray) -> ComplexArray:
        """v (n, 2) [mm] at the values c (m,), `slopes` u (n, 2) = F/f."""
        values: Values = {**self.constants, **dict(zip(self.names, c, strict=True))}
        computed = values["f"] * slopes
        q = self.frame - np.array([values["x0"], values["y0"]])
        if self.model != "none" and self.direction == "ideal_to_distorted":
            ideal = computed - self.air
            return np.asarray(_affine(ideal + self._lens(ideal, values), values) - q)
        sign = -1.0 if self.direction == "displacement" else 1.0
        return np.asarray(computed - q - sign * (self._lens(q, values) + _affine(q, values) - q) - self.air)

    def _lens(self, xy: ComplexArray, c: Values) -> ComplexArray:
        """d (n, 2) [mm] at xy (n, 2) [mm]."""
        if self.model == "none":
            return np.zeros_like(xy)
        if self.model == "opencv":
            # OpenCV's own axes: normalised, y down
            x, y = xy[:, 0] / c["f"], -xy[:, 1] / c["f"]
            dx, dy = _opencv(x, y, c)
            return np.asarray(c["f"] * np.stack([dx, -dy], axis=1))
        x, y = xy.T
        s = x * x + y * y
        g = _brown(s, c) if self.table is None else _certificate(np.sqrt(s), self.table)
        p1, p2, s1, s2, s3, s4 = (c.get(name, 0.0) for name in ("p1", "p2", "s1", "s2", "s3", "s4"))
        dx = x * g + p1 * (s + 2 * x * x) + 2 * p2 * x * y + s1 * s + s2 * s * s
        dy = y * g + p2 * (s + 2 * y * y) + 2 * p1 * x * y + s3 * s + s4 * s * s
        return np.stack([dx, dy], axis=1)


def _affine(xy: ComplexArray, c: Values) -> ComplexArray:
    """(I + B) xy."""
    return np.stack([xy[:, 0] + c["b1"] * xy[:, 0] + c["b2"] * xy[:, 1], xy[:, 1]], axis=1)


def _brown(s: ComplexArray, c: Values) -> ComplexArray:
    return np.asarray(sum(c.get(f"k{i}", 0.0) * s**i for i in range(4)))


def _opencv(x: ComplexArray, y: ComplexArray, c: Values) -> tuple[ComplexArray, ComplexArray]:
    """Distorted minus ideal, as OpenCV's documentation writes it: k1 ... k6, p1, p2, s1 ... s4."""
    s = x * x + y * y
    k = [c.get(f"k{i}", 0.0) for i in range(1, 7)]
    p1, p2, s1, s2, s3, s4 = (c.get(name, 0.0) for name in ("p1", "p2", "s1", "s2", "s3", "s4"))
    ratio = (1 + k[0] * s + k[1] * s**2 + k[2] * s**3) / (1 + k[3] * s + k[4] * s**2 + k[5] * s**3)
    dx = x * (ratio - 1) + 2 * p1 * x * y + p2 * (s + 2 * x * x) + s1 * s + s2 * s * s
    dy = y * (ratio - 1) + p1 * (s + 2 * y * y) + 2 * p2 * x * y + s3 * s + s4 * s * s
    return dx, dy


def _certificate(r: ComplexArray, table: FloatArray) -> ComplexArray:
    """D(r)/r, linear between the rows of the certificate, D(0) = 0."""
    rows = table if table[0, 0] == 0.0 else np.vstack([[0.0, 0.0], table])
    at = np.clip(np.searchsorted(rows[:, 0], r.real, side="right") - 1, 0, len(rows) - 2)
    slope = (np.diff(rows[:, 1]) / np.diff(rows[:, 0]))[at]
    at_centre = r == 0
    return np.where(at_centre, slope, (rows[at, 1] + slope * (r - rows[at, 0])) / np.where(at_centre, 1.0, r))
