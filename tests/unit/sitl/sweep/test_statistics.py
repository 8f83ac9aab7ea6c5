"""Statistics against closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from sitl.sweep.statistics import adjusted, failure_rate, influences, paired, paired_failures, percentiles

_Z = stats.norm.ppf(0.975)


@given(st.integers(1, 2000).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_a_failure_rate_has_wilsons_interval(counts: tuple[int, int]) -> None:
    k, n = counts
    middle = (k + _Z**2 / 2.0) / (n + _Z**2)
    half = _Z / (n + _Z**2) * math.sqrt(k * (n - k) / n + _Z**2 / 4.0)
    rate = failure_rate(k, n)
    assert rate.value == k / n
    assert (rate.low, rate.high) == (pytest.approx(middle - half, abs=1e-12), pytest.approx(middle + half, abs=1e-12))


def test_sixteen_good_seeds_do_not_exclude_a_failure_in_ten() -> None:
    assert failure_rate(0, 16).high > 0.1 > failure_rate(0, 1000).high


def test_percentiles_and_their_intervals_agree_with_the_order_statistics() -> None:
    """Of the ranks that the binomial distribution gives, as scipy's test of a quantile has them."""
    count = 400
    values = np.random.default_rng(1).normal(size=count)
    ordered = np.sort(values)
    for share, found in zip((0.05, 0.5, 0.95), percentiles(list(values)), strict=True):
        assert found.value == pytest.approx(float(np.quantile(values, share)))
        low, high = stats.binom.ppf((0.025, 0.975), count, share).astype(int)
        assert (found.low, found.high) == (ordered[low - 1], ordered[high])
        assert (found.low, found.high) == tuple(stats.quantile_test(values, p=share).confidence_interval(0.95))


@pytest.mark.parametrize("count", [1, 2, 5, 16, 40, 100])
def test_an_interval_holds_what_it_says_of_few_values_too(count: int) -> None:
    """The 95th percentile of ten skewed runs lay outside of half of its 95 % intervals."""
    generator, sweeps = np.random.default_rng(7), 300
    held = np.zeros(3)
    for _ in range(sweeps):
        found = percentiles(list(generator.exponential(size=count)))
        held += [
            one.low <= -math.log(1.0 - share) <= one.high for one, share in zip(found, (0.05, 0.5, 0.95), strict=True)
        ]
    assert (held / sweeps >= 0.925).all(), "a share of 0.95 of 300 errs by 0.025"


def test_few_values_leave_an_end_open() -> None:
    low, median, high = percentiles([float(value) for value in range(16)])
    assert low.low == -math.inf and math.isfinite(low.high)
    assert math.isfinite(median.low) and math.isfinite(median.high)
    assert math.isfinite(high.low) and high.high == math.inf
    assert all(math.isfinite(end) for one in percentiles(list(range(72))) for end in (one.low, one.high))
    assert [one.low for one in percentiles(list(range(71)))[:1]] == [-math.inf]
    assert [(one.low, one.high) for one in percentiles([3.0])] == [(-math.inf, math.inf)] * 3


def test_the_same_values_give_the_same_intervals() -> None:
    values = [float(value) for value in np.random.default_rng(2).normal(size=50)]
    assert percentiles(values) == percentiles(values)


def test_what_does_not_vary_has_no_width() -> None:
    assert all((found.value, found.low, found.high) == (3.0, 3.0, 3.0) for found in percentiles([3.0] * 72))


def test_all_of_five_pairs_higher_is_two_of_thirty_two() -> None:
    """Wilcoxon's exact two-sided p of n differences of one sign: 2 / 2^n."""
    found = paired("iae", [1.0, 2.0, 3.0, 4.0, 5.0], [1.1, 2.2, 3.3, 4.4, 5.5])
    assert found is not None
    assert found.p == pytest.approx(2.0 / 2**5)
    assert (found.count, found.first, found.second, found.median.value) == (5, 3.0, 3.3, pytest.approx(0.3))


def test_equal_pairs_differ_by_chance() -> None:
    found = paired("iae", [1.0, 2.0, 3.0] * 2, [1.0, 2.0, 3.0] * 2)
    assert found is not None and found.p == 1.0 and found.median.low == found.median.high == 0.0


@pytest.mark.parametrize("equal", [0, 1, 9, 40])
def test_pairs_that_are_equal_do_not_make_five_others_clear(equal: int) -> None:
    """With many pairs, some of them equal, the p was that of a normal distribution: 0.043."""
    found = paired("iae", [0.0] * (5 + equal), [0.0] * equal + [1.0, 2.0, 3.0, 4.0, 5.0])
    assert found is not None and found.count == 5 + equal
    assert found.p == pytest.approx(2.0 / 2**5)


def test_pairs_without_two_figures_do_not_count() -> None:
    found = paired("iae", [1.0, math.nan, 3.0, 4.0], [2.0, 2.0, math.inf, 6.0])
    assert found is not None and found.count == 2
    assert paired("iae", [1.0, math.nan], [1.0, 2.0]) is None


@pytest.mark.parametrize(("b", "c"), [(0, 0), (0, 6), (1, 7), (5, 5)])
def test_failures_are_compared_by_mcnemars_exact_test(b: int, c: int) -> None:
    first = [False] * b + [True] * c + [True] * 10 + [False] * 3
    second = [True] * b + [False] * c + [True] * 10 + [False] * 3
    found = paired_failures(first, second)
    tail = sum(math.comb(b + c, k) for k in range(min(b, c) + 1)) / 2 ** (b + c)
    assert (found.only_first, found.only_second, found.both) == (b, c, 3)
    assert found.p == pytest.approx(min(1.0, 2.0 * tail))


def test_many_tests_are_adjusted_after_benjamini_and_hochberg() -> None:
    assert adjusted([0.01, 0.04, 0.03, 0.5]) == pytest.approx([0.04, 0.16 / 3.0, 0.16 / 3.0, 0.5])
    assert adjusted([]) == []


def test_a_metric_follows_the_factor_that_drives_it() -> None:
    factors = {"wind": [1.0, 2.0, 3.0, 4.0], "waves": [4.0, 3.0, 2.0, 1.0], "fixed": [1.0] * 4}
    assert influences(factors, [1.0, 4.0, 9.0, 16.0]) == {"wind": pytest.approx(1.0), "waves": pytest.approx(-1.0)}
    assert influences(factors, [1.0] * 4) == {}
