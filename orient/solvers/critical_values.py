"""Critical values: Baarda's w with known sigma0, Pope's tau with estimated sigma0, and the global test.

alpha0 = 0.001 for one test, power 0.80: |w| > 3.2905, delta0 = 4.1321, lambda0 = delta0^2 = 17.075.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtr, chdtrc, chdtri, nctdtrinc, ndtr, ndtri, stdtr, stdtrit

ALPHA0 = 0.001
"""Chance that one observation without a gross error is named."""
POWER = 0.80
"""Chance that a gross error of the size of the smallest findable one is named."""
GLOBAL_LEVEL = 0.05
"""Chance that an adjustment without gross errors fails the global test, both sides together."""
NORMAL_FREEDOM = 1e5
"""Degrees of freedom from which Student's distribution is taken as normal (difference of the critical value: 1e-4)."""

W_CRITICAL = float(ndtri(1.0 - ALPHA0 / 2.0))
DELTA0 = W_CRITICAL + float(ndtri(POWER))


@dataclass(frozen=True, slots=True)
class Limits:
    """The test that decides: `name` w or tau, the `sigma0` that scales it, its `critical` value, and delta0.

    w: sigma0 is known. tau: sigma0 is estimated from the adjustment that is tested. `critical` is infinite where tau
    cannot test: with r = 1 every |tau| is 1.
    """

    name: str
    sigma0: float
    critical: float
    delta0: float


@dataclass(frozen=True, slots=True)
class GlobalTest:
    """v'Pv / sigma0^2 against chi^2 with r degrees of freedom: accepted between `lower` and `upper`."""

    statistic: float
    lower: float
    upper: float
    probability: float

    @property
    def verdict(self) -> str:
        """accepted | too large | too small"""
        if self.statistic > self.upper:
            return "too large"
        return "too small" if self.statistic < self.lower else "accepted"


def w_limits(sigma0: float) -> Limits:
    """|w| > 3.2905 with the sigma0 known a priori. Source: Baarda 1968."""
    return Limits("w", sigma0, W_CRITICAL, DELTA0)


def tau_limits(vPv: float, redundancy: int) -> Limits:
    """|tau| > t sqrt(r / (r - 1 + t^2)), t = Student's 1 - alpha0/2 quantile of r - 1; sigma0 = sqrt(v'Pv / r).

    delta0 is the noncentrality for which Student's test of r - 1 degrees of freedom has the power 0.80: larger than
    that of w, because sigma0 is not known. tau is beta distributed: tau^2 / r ~ B(1/2, (r - 1)/2).
    Source: A. J. Pope, The statistics of residuals and the detection of outliers, NOAA NOS 65 NGS 1, 1976.
    """
    sigma0 = float(np.sqrt(vPv / redundancy))
    if redundancy < 2:
        return Limits("tau", sigma0, np.inf, np.inf)
    freedom = float(redundancy - 1)
    if freedom > NORMAL_FREEDOM:
        return Limits("tau", sigma0, W_CRITICAL, DELTA0)
    t = float(stdtrit(freedom, 1.0 - ALPHA0 / 2.0))
    critical = t * np.sqrt(redundancy / (freedom + t * t))
    return Limits("tau", sigma0, float(critical), float(nctdtrinc(freedom, 1.0 - POWER, t)))


def chance(statistic: float, limits: Limits, redundancy: int) -> float:
    """P(|w| or |tau| > statistic) of one observation without a gross error, r the redundancy of the adjustment."""
    if limits.name == "w":
        return float(2.0 * ndtr(-statistic))
    rest = max(redundancy - statistic**2, 0.0)
    return float(2.0 * stdtr(redundancy - 1, -statistic * np.sqrt((redundancy - 1) / rest))) if rest else 0.0


def global_test(vPv: float, redundancy: int, sigma0: float) -> GlobalTest:
    """P(chi^2_r outside lower ... upper) = 0.05, half on each side; `probability` is two-sided. Needs r > 0."""
    statistic = vPv / sigma0**2
    tail = min(float(chdtr(redundancy, statistic)), float(chdtrc(redundancy, statistic)))
    upper = float(chdtri(redundancy, GLOBAL_LEVEL / 2))
    lower = float(chdtri(redundancy, 1.0 - GLOBAL_LEVEL / 2))
    return GlobalTest(statistic, lower, upper, min(1.0, 2.0 * tail))
