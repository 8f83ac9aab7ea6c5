"""The share of a work of which only the usual length is known, and the parts of a whole."""

from __future__ import annotations

import pytest

from companion.core.progress import Work, part, usual_share


def test_a_long_work_creeps_on_and_never_ends() -> None:
    shares = [usual_share(done, 10.0) for done in range(100)]
    assert shares[:9] == [done / 10.0 for done in range(9)]
    assert shares == sorted(shares)
    assert 0.98 < shares[-1] < 1.0
    assert usual_share(9.0, 10.0) == pytest.approx(0.9)


def test_a_part_tells_its_share_of_the_whole() -> None:
    told: list[tuple[str, float]] = []
    work = Work(part(lambda text, share: told.append((text, share)), 0.2, 0.6), "fitting", 4.0)
    work.step()
    work.step()
    assert told == [("fitting", pytest.approx(0.3)), ("fitting", pytest.approx(0.4))]
