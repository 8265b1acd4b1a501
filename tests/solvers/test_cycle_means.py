"""Cycle means: means, pooled sigmas, and the readings that differ."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orient.solvers.cycle_means import cycle_means


def readings(n_points, cycles, seed, sigma=0.004):
    random = np.random.default_rng(seed)
    names = [f"P{i}" for _ in range(cycles) for i in range(n_points)]
    places = random.uniform(-90.0, 90.0, (n_points, 2))
    return names, np.tile(places, (cycles, 1)) + random.normal(0.0, sigma, (n_points * cycles, 2)), places


def test_means_and_sigmas_by_hand():
    result = cycle_means(
        ["a", "a", "b", "a", "b"], np.array([[1.0, 5.0], [2.0, 5.0], [8.0, 1.0], [3.0, 5.0], [9.0, 3.0]])
    )
    assert result.points == ("a", "b")
    assert result.means == pytest.approx(np.array([[2.0, 5.0], [8.5, 2.0]]))
    assert result.deviations[:3] == pytest.approx(np.array([[1.0, 0.0], [0.0, 0.0], [0.5, 1.0]]))
    assert result.n_used.tolist() == [3, 2]
    assert result.redundancy == 3
    assert result.sigma_xy == pytest.approx(np.sqrt([(2.0 + 0.5) / 3, 2.0 / 3]))
    assert result.sigma == pytest.approx(np.sqrt(4.5 / 6))
    assert result.sigma_point == pytest.approx(np.sqrt([2.0 / 4, 2.5 / 2]))


def test_the_statistic_is_external():
    """t of a reading: its deviation over the spread of the OTHER points."""
    names, xy, _ = readings(6, 3, 1)
    result = cycle_means(names, xy)
    others = [i for i, name in enumerate(names) if name != "P2"]
    s = np.sqrt(np.sum(result.deviations[others] ** 2, axis=0) / 10)
    i = names.index("P2")
    assert result.statistic[i] == pytest.approx(np.max(np.abs(result.deviations[i]) / (s * np.sqrt(2 / 3))))


def test_one_cycle_has_no_sigma_and_no_test():
    result = cycle_means(["a", "b"], np.array([[1.0, 2.0], [3.0, 4.0]]), reject=True)
    assert (result.sigma_xy, result.sigma, result.redundancy) == (None, None, 0)
    assert result.statistic == (None, None)
    assert np.isnan(result.sigma_point).all() and result.is_used.all() and not result.is_outlier.any()
    assert result.deviations == pytest.approx(np.zeros((2, 2)))


def test_a_single_point_in_cycles_has_a_sigma_but_no_test():
    result = cycle_means(["a", "a", "a"], np.array([[1.0, 2.0], [1.1, 2.0], [90.0, 2.0]]), reject=True)
    assert result.sigma is not None
    assert result.statistic == (None, None, None) and result.is_used.all()


def test_unequal_numbers_of_cycles():
    names, xy, _ = readings(20, 3, 2)
    keep = [i for i in range(60) if not (i >= 40 and i % 2) and i not in (3, 23, 43)]
    result = cycle_means([names[i] for i in keep], xy[keep])
    assert sorted(set(result.n_used.tolist())) == [2, 3]
    assert "P3" not in result.points
    assert result.sigma == pytest.approx(0.004, rel=0.35)
    assert not result.is_outlier.any()


class TestGrossError:
    def test_in_three_cycles_it_is_named_alone_and_left_out(self):
        names, xy, _ = readings(12, 3, 3)
        xy[17] += [0.06, 0.0]
        kept, rejected = cycle_means(names, xy), cycle_means(names, xy, reject=True)
        assert np.flatnonzero(kept.is_outlier).tolist() == np.flatnonzero(rejected.is_outlier).tolist() == [17]
        assert kept.is_used.all() and np.flatnonzero(~rejected.is_used).tolist() == [17]
        assert rejected.n_used[5] == 2
        assert rejected.means[5] == pytest.approx((xy[5] + xy[29]) / 2)
        # the deviation of a reading that is left out is its own error
        assert rejected.deviations[17, 0] == pytest.approx(-0.06, abs=0.015)
        assert rejected.sigma == pytest.approx(0.004, rel=0.3)

    def test_in_two_cycles_both_are_named_and_kept(self):
        names, xy, _ = readings(12, 2, 4)
        xy[5] += [0.0, 0.08]
        result = cycle_means(names, xy, reject=True)
        assert np.flatnonzero(result.is_outlier).tolist() == [5, 17]
        assert result.is_used.all()
        assert result.statistic[5] == pytest.approx(result.statistic[17])

    def test_three_readings_that_all_differ_are_all_named_and_kept(self):
        names, xy, _ = readings(12, 3, 5)
        xy[5] += [0.10, 0.0]
        xy[17] -= [0.25, 0.0]
        result = cycle_means(names, xy, reject=True)
        assert np.flatnonzero(result.is_outlier).tolist() == [5, 17, 29]
        assert result.is_used.all()

    def test_it_does_not_mask_itself(self):
        """Two cycles, five points: inside the common sigma the error would be its own excuse (t <= sqrt 5)."""
        names, xy, _ = readings(5, 2, 6)
        xy[1] += [0.5, 0.0]
        result = cycle_means(names, xy)
        assert np.flatnonzero(result.is_outlier).tolist() == [1, 6]
        assert result.statistic[1] > 50.0

    def test_a_big_one_does_not_hide_a_smaller_one(self):
        names, xy, _ = readings(15, 3, 7)
        xy[4] += [5.0, 0.0]
        xy[26] += [0.0, 0.06]
        result = cycle_means(names, xy, reject=True)
        assert np.flatnonzero(~result.is_used).tolist() == [4, 26]

    def test_cycles_copied_to_the_last_digit_but_one(self):
        names, xy, _ = readings(6, 1, 8)
        names, xy = names * 3, np.tile(xy, (3, 1))
        assert not cycle_means(names, xy).is_outlier.any()
        xy[8, 1] += 0.01
        assert np.flatnonzero(cycle_means(names, xy).is_outlier).tolist() == [8]

    @pytest.mark.parametrize(("n_points", "cycles"), [(3, 2), (10, 2), (10, 3), (30, 4)])
    def test_false_alarms_stay_at_one_percent(self, n_points, cycles):
        alarms = sum(cycle_means(*readings(n_points, cycles, 1000 + seed)[:2]).is_outlier.any() for seed in range(400))
        assert alarms <= 11


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    shift=st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)),
    scale=st.floats(0.01, 100.0),
)
def test_moving_scaling_and_ordering_move_the_means_alike(seed, shift, scale):
    names, xy, _ = readings(8, 3, seed)
    xy[3] += [0.1, 0.0]
    order = np.random.default_rng(seed).permutation(len(names))
    plain = cycle_means(names, xy, reject=True)
    moved = cycle_means([names[i] for i in order], (xy * scale + np.array(shift))[order], reject=True)
    means = dict(zip(moved.points, moved.means, strict=True))
    expected = plain.means * scale + np.array(shift)
    assert np.array([means[name] for name in plain.points]) == pytest.approx(expected, abs=1e-7)
    assert np.array_equal(moved.is_outlier, plain.is_outlier[order])
    assert moved.sigma == pytest.approx(plain.sigma * scale, rel=1e-6)


def test_arguments_are_not_written_to():
    names, xy, _ = readings(5, 3, 9)
    xy[2] += 1.0
    before = xy.copy()
    cycle_means(names, xy, reject=True)
    assert np.array_equal(xy, before)


def test_no_readings():
    result = cycle_means([], np.empty((0, 2)))
    assert (result.points, result.redundancy, result.sigma) == ((), 0, None)
