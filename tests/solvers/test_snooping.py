"""Iterative snooping and consensus on linear models, where every decision can be foreseen."""

import numpy as np
import pytest
from numpy.typing import NDArray

from orient.solvers.consensus import RobustFailed, all_agreeing, least_trimmed, samples, trimmed_size
from orient.solvers.critical_values import w_limits
from orient.solvers.snooping import Decision, Verdicts, snoop
from tests.solvers.linear_models import judged, solution
from tests.solvers.resection_scenes import FloatArray, generator

Mask = NDArray[np.bool_]


def line(name: str, n: int = 12) -> tuple[FloatArray, FloatArray]:
    """y = a + b t with unit errors, measured n times: blocks of one observation."""
    t = np.arange(n, dtype=np.float64)
    A = np.stack([np.ones(n), t], axis=1)[:, None, :]
    return A, generator(name).normal(size=(n, 1))


def everyone(n: int) -> Mask:
    return np.ones(n, dtype=np.bool_)


def decided(A: FloatArray, L: FloatArray, start: Mask | None = None) -> tuple[tuple[Decision, ...], Mask]:
    found = snoop(lambda kept, first: judged(A, L, kept), everyone(len(A)) if start is None else start)
    assert found is not None
    return found.decisions, found.kept


def test_clean_data_lose_nothing() -> None:
    decisions, kept = decided(*line("clean"))
    assert decisions == ()
    assert kept.all()


def test_blunders_go_one_at_a_time_the_largest_first() -> None:
    A, L = line("two")
    L[3] += 40.0
    L[9] -= 15.0
    decisions, kept = decided(A, L)
    assert [(d.point, d.action, d.round) for d in decisions] == [(3, "excluded", 1), (9, "excluded", 2)]
    assert all(d.statistic > d.critical == w_limits(1.0).critical for d in decisions)
    assert np.flatnonzero(~kept).tolist() == [3, 9]


def test_wrongly_excluded_point_comes_back() -> None:
    """Two errors of one sign near the end of a line lift it: the good point at its end looks worst at first."""
    A, _ = line("back", 10)
    L = 0.3 * np.random.default_rng(2606).normal(size=(10, 1))
    L[[1, 2], 0] += 11.0
    decisions, kept = decided(A, L)
    assert [(d.point, d.action) for d in decisions] == [
        (0, "excluded"),
        (2, "excluded"),
        (1, "excluded"),
        (0, "taken back"),
    ]
    assert np.flatnonzero(~kept).tolist() == [1, 2]


def test_points_left_out_at_the_start_stay_out() -> None:
    A, L = line("start")
    start = everyone(12)
    start[4] = False
    decisions, kept = decided(A, L, start)
    assert decisions == ()
    assert not kept[4]


def test_two_inseparable_suspects_are_named_and_kept() -> None:
    """Far out only two readings fix the slope: an error of one cannot be told from one of the other."""
    t = np.concatenate([np.linspace(0, 1, 12), [1000.0, 1000.0]])
    A = np.stack([np.ones(14), t], axis=1)[:, None, :]
    L = 0.3 * generator("twins").normal(size=(14, 1))
    L[13] += 20.0
    decisions, kept = decided(A, L)
    (decision,) = decisions
    assert decision.action == "not separable"
    assert {decision.point, decision.twin} == {12, 13}
    assert decision.rho == pytest.approx(1.0, abs=0.01)
    assert kept.all()


def test_redundancy_is_not_used_up() -> None:
    A, L = line("short", 4)
    L[[1, 2], 0] += [300.0, -100.0]
    decisions, kept = decided(A[:4], L[:4])
    assert kept.sum() == 4
    assert [d.action for d in decisions] in (["not removable"], ["not separable"])


def test_an_adjustment_that_fails_without_a_point_keeps_it() -> None:
    A, L = line("fails")
    L[5] += 50.0

    def adjust(kept: Mask, first: FloatArray | None) -> Verdicts[FloatArray] | None:
        return judged(A, L, kept) if kept.all() else None

    found = snoop(adjust, everyone(12))
    assert found is not None
    assert [d.action for d in found.decisions] == ["not removable"]
    assert found.kept.all()
    assert snoop(lambda kept, first: None, everyone(12)) is None


@pytest.mark.parametrize("keep_last", [True, False], ids=["rejecting", "proposing"])
def test_proposals_may_begin_at_the_first_adjustment(keep_last: bool) -> None:
    A, L = line("begin")
    L[3] += 40.0
    L[9] -= 15.0
    firsts = []

    def adjust(kept: Mask, first: FloatArray | None) -> Verdicts[FloatArray] | None:
        firsts.append(first)
        return judged(A, L, kept)

    found = snoop(adjust, everyone(12), keep_last=keep_last)
    assert found is not None and len(found.decisions) == 2
    expected = [None, None, None] if keep_last else [None, found.first.adjusted, found.first.adjusted]
    assert all(one is other for one, other in zip(firsts, expected, strict=True))


# ---------------------------------------------------------------------------------------------- consensus


def consensus(A: FloatArray, L: FloatArray) -> Mask:
    """Least trimmed squares from all pairs of points, then all that agree."""

    def misfits(chosen: Mask) -> FloatArray:
        return np.asarray(np.sum((A @ solution(A[chosen], L[chosen]) + L) ** 2, axis=1))

    def of_pair(pair: tuple[int, ...]) -> FloatArray:
        chosen = np.isin(np.arange(len(A)), pair)
        return misfits(chosen)

    starts = [of_pair(pair) for pair in samples(range(len(A)), 2)]
    trimmed = least_trimmed(starts, np.ones(len(A), dtype=np.int64), 2, 3, misfits)
    limits = w_limits(trimmed.scale)
    return all_agreeing(lambda kept: judged(A, L, kept, limits), trimmed, everyone(len(A)))


@pytest.mark.parametrize("wrong", [0, 1, 2, 3, 4])
def test_up_to_forty_percent_wrong_points_are_left_out(wrong: int) -> None:
    A, L = line("robust")
    # a conspiracy: the wrong ones lie on a line of their own
    L[:wrong, 0] += 200.0 + 30.0 * np.arange(wrong)
    assert np.flatnonzero(~consensus(A, L)).tolist() == list(range(wrong))


@pytest.mark.parametrize("wrong", [5, 6])
def test_more_wrong_points_are_a_failure(wrong: int) -> None:
    A, L = line("too many")
    L[:wrong, 0] += generator("size").uniform(100, 900, wrong)
    with pytest.raises(RobustFailed, match=r"^ROBUST_FAILED: ") as refused:
        consensus(A, L)
    assert refused.value.exit_code == 1


def test_clean_points_are_all_kept_whatever_their_number() -> None:
    """The trimmed scale is freed of its trimming: few good points are lost."""
    lost = [int((~consensus(*line(f"scale {i}", 20))).sum()) for i in range(40)]
    assert sum(lost) <= 4  # 800 points at 0.1 %, and the trimmed scale is itself uncertain


def test_sizes_and_samples() -> None:
    assert [trimmed_size(n, 4) for n in (4, 5, 10, 12, 100)] == [4, 4, 6, 8, 60]
    assert len(list(samples(range(10), 3))) == 120
    many = list(samples(range(100), 3))
    assert len(many) == 120
    assert many == list(samples(range(100), 3))
    assert all(len(set(triple)) == 3 for triple in many)
