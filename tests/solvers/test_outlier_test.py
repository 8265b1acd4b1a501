"""The mean-shift test: the same as fitting the shift, and F distributed."""

import numpy as np
import pytest

from orient.solvers.outlier_test import ShiftTest, bonferroni, f_probability, mean_shift_test, t_probability


def adjustment(seed, n=12, u=4, k=2):
    random = np.random.default_rng(seed)
    A = random.normal(size=(n, u))
    observed = random.normal(size=(n, k))
    hat = A @ np.linalg.pinv(A)
    return A, observed, (hat - np.eye(n)) @ observed, 1.0 - np.diag(hat)


def test_the_statistic_is_that_of_an_adjustment_with_the_shift_as_unknown():
    A, observed, residuals, numbers = adjustment(1)
    test = mean_shift_test(residuals, numbers, 8)
    full = np.sum(residuals**2)
    for i in range(12):
        extended = np.column_stack([A, np.eye(12)[i]])
        rest = np.sum((observed - extended @ np.linalg.lstsq(extended, observed, rcond=None)[0]) ** 2)
        assert test.statistic[i] == pytest.approx(((full - rest) / 2) / (rest / (2 * 7)))


def test_the_probability_is_uniform_without_errors():
    drawn = []
    for seed in range(600):
        _, _, residuals, numbers = adjustment(seed)
        drawn.append(mean_shift_test(residuals, numbers, 8).probability[0])
    for level in (0.05, 0.3, 0.7):
        assert np.mean(np.array(drawn) < level) == pytest.approx(level, abs=3.5 * np.sqrt(level * (1 - level) / 600))


def test_no_test_without_rest_of_redundancy():
    _, _, residuals, numbers = adjustment(2)
    assert mean_shift_test(residuals, numbers, 1) == ShiftTest((None,) * 12, (None,) * 12)
    assert mean_shift_test(residuals, numbers, 1).worst() is None


def test_an_observation_that_nothing_checks_has_no_test():
    _, _, residuals, numbers = adjustment(3)
    numbers[4], residuals[4] = 1e-16, 1e-17
    test = mean_shift_test(residuals, numbers, 8)
    assert test.statistic[4] is None and test.probability[4] is None
    assert sum(value is None for value in test.statistic) == 1


def test_the_worst_is_corrected_for_the_number_of_tests():
    test = ShiftTest((1.0, None, 9.0), (0.4, None, 0.002))
    assert test.worst() == (2, pytest.approx(0.004))
    # probabilities too small to differ: the larger statistic
    assert ShiftTest((1e9, 3e9), (0.0, 0.0)).worst() == (1, 0.0)


def test_probabilities_of_the_tables():
    assert f_probability(np.array([4.10]), 2, 10)[0] == pytest.approx(0.05, abs=1e-4)
    assert f_probability(np.array([3.0]), 2, 10)[0] == pytest.approx((1 + 2 * 3.0 / 10) ** -5)
    assert t_probability(np.array([2.228]), np.array([10.0]))[0] == pytest.approx(0.05, abs=1e-4)
    assert bonferroni(0.3, 9) == 1.0
