"""Whether a lead boat has a fix right now."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.core.readings import FixType, GnssFix
from companion.leader_module.fix_watch import FixWatch
from tests.unit.io.mavlink.services.test_leader import NAV


@pytest.mark.parametrize(("rate_hz", "within_s"), [(10.0, 0.25), (5.0, 0.4), (1.0, 1.6)])
def test_silence_is_noticed_after_one_and_a_half_intervals(rate_hz: float, within_s: float) -> None:
    watch, placed_s, last_fix_s = FixWatch(), 0.0, 30.0
    for n in range(700):
        now_s = 0.05 * n
        due = now_s <= last_fix_s and n % round(20.0 / rate_hz) == 0
        fixes = [GnssFix(now_s, "gnss", 57.0, 11.0, 0.0, FixType.FIX_3D, 10, 1.0)] if due else []
        age_s = now_s - min(now_s, last_fix_s)
        placed = watch.update(fixes, replace(NAV, position_age_s=age_s), now_s)
        placed_s = now_s if placed else placed_s
        if 5.0 < now_s <= last_fix_s:
            assert placed
    assert 0.0 < placed_s - last_fix_s <= within_s


def test_a_receiver_that_says_that_it_has_none_is_believed_at_once() -> None:
    watch = FixWatch()
    for n in range(100):
        watch.update([GnssFix(0.1 * n, "gnss", 57.0, 11.0, 0.0, FixType.FIX_3D, 10, 1.0)], NAV, 0.1 * n)
    assert watch.update([], NAV, 9.95)
    assert not watch.update([], replace(NAV, fix=FixType.NONE), 9.95)
    assert not watch.update([], replace(NAV, position_valid=False), 9.95)
    assert not watch.update([], replace(NAV, position_age_s=0.8), 9.95), "fixes come, and all are rejected"
