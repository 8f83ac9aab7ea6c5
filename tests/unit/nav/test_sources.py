"""Choice of sources and grades of fix."""

from __future__ import annotations

import pytest

from companion.core.readings import FixType
from companion.nav.sources import GradeWatch, SourceSelector


def test_first_in_the_file_is_used_and_returns_only_after_a_while() -> None:
    selector = SourceSelector({"a": 1.0, "b": 1.0})
    assert selector.offer("a", 0.0)
    assert not selector.offer("b", 0.1)
    assert not selector.offer("b", 0.9)
    assert selector.offer("b", 1.6)  # a has been silent for more than its second
    times = [2.0 + 0.5 * k for k in range(20)]
    used = []
    for t_s in times:
        selector.offer("b", t_s)
        used.append(selector.offer("a", t_s))
    back = times[used.index(True)]
    assert back == pytest.approx(7.0)  # 5 s after its first good reading
    assert all(used[used.index(True) :])


def test_a_source_that_reports_a_bad_reading_is_replaced_at_once() -> None:
    selector = SourceSelector({"a": 2.0, "b": 2.0})
    assert selector.offer("a", 0.0)
    assert not selector.offer("b", 0.0)
    assert not selector.offer("a", 0.1, good=False)
    assert selector.offer("b", 0.1)


def test_a_higher_grade_goes_before_the_order_after_a_while() -> None:
    """Carrier phase on the second receiver while the first has none: taken over after 5 s, given back 5 s after the
    first has it too."""
    selector = SourceSelector({"a": 2.0, "b": 2.0})
    used = []
    for k in range(400):
        t_s = 0.1 * k
        first = selector.offer("a", t_s, grade=0 if t_s < 20.0 else 1)
        second = selector.offer("b", t_s, grade=0 if t_s < 10.0 else 1)
        assert first + second == 1 or not used or abs(t_s - 15.0) < 0.15 or abs(t_s - 25.0) < 0.15
        used.append("a" if first else "b")
    changes = [(round(0.1 * k, 1), used[k]) for k in range(1, 400) if used[k] != used[k - 1]]
    assert changes == [(pytest.approx(15.0, abs=0.15), "b"), (pytest.approx(25.0, abs=0.15), "a")]


def test_a_flickering_grade_never_counts() -> None:
    selector = SourceSelector({"a": 2.0, "b": 2.0})
    assert all(
        selector.offer("a", 0.1 * k) and not selector.offer("b", 0.1 * k, grade=int(k % 40 > 0)) for k in range(300)
    )


def test_of_two_that_come_back_the_higher_grade_is_taken() -> None:
    selector = SourceSelector({"a": 2.0, "b": 2.0, "c": 2.0})
    assert selector.offer("a", 0.0)
    assert not selector.offer("b", 1.9) and not selector.offer("c", 1.9, grade=1)
    assert not selector.offer("b", 2.1), "c is better"
    assert selector.offer("c", 2.2, grade=1)


def test_an_unconfigured_source_is_used_last() -> None:
    selector = SourceSelector({"a": 1.0})
    assert selector.offer("stranger", 0.0)
    assert not selector.offer("a", 0.1)
    assert selector.offer("stranger", 0.2)


def test_variance_is_added_when_a_better_fix_type_takes_over() -> None:
    watch = GradeWatch()
    assert watch.update(0.0, FixType.DGPS, 1.0) == 0.0
    assert watch.update(19.0, FixType.DGPS, 1.0) == 0.0
    assert watch.update(20.0, FixType.RTK_FIXED, 0.03) == 1.0
    assert watch.update(20.1, FixType.DGPS, 1.0) == 0.0  # falling: the good position is not forgotten
    assert watch.update(20.2, FixType.RTK_FIXED, 0.03) == pytest.approx(0.01)  # it was worse for 0.1 of 10 s
