from __future__ import annotations

from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.twin import Twin

DAY_S = 86_400.0
WRAP_S = 2**32 / 1000.0


def position(boot_s: float) -> Any:
    boot_ms = int(boot_s * 1000.0) % 2**32
    return mavlink.MAVLink_global_position_int_message(boot_ms, 634_389_000, 103_990_000, 0, 0, 0, 0, 0, 0)


def warnings(twin: Twin, ahead_s: float, begin_s: float, duration_s: float, period_s: float = 0.2) -> list[float]:
    """When it warns of packets whose boot time is that much ahead of ours."""
    times = [begin_s + period_s * i for i in range(round(duration_s / period_s))]
    return [now_s for now_s in times if twin.take(position(now_s + ahead_s), now_s)]


@pytest.mark.parametrize("ahead_s", [3.0, DAY_S, -61.0, -900.0])
def test_another_boot_time_is_another_vehicle(ahead_s: float) -> None:
    times = warnings(Twin(), ahead_s, 1000.0, 620.0)
    assert times == [pytest.approx(1005.0, abs=0.3), pytest.approx(1305.0, abs=0.5), pytest.approx(1605.0, abs=0.7)]


@pytest.mark.parametrize("ahead_s", [0.0, -0.1, -30.0])
def test_our_own_packets_that_come_back_are_none(ahead_s: float) -> None:
    assert warnings(Twin(), ahead_s, 1000.0, 120.0) == []
    assert warnings(Twin(), ahead_s, WRAP_S - 20.0, 60.0) == [], "the boot time wraps"


def test_what_was_under_way_from_before_a_restart_is_none() -> None:
    twin = Twin()
    assert warnings(twin, 5000.0, 1.0, 4.0) == []
    assert warnings(twin, 5000.0, 60.0, 4.0) == []


def test_echoes_to_a_vessel_in_fast_motion_may_be_older() -> None:
    assert warnings(Twin(patience=20.0), -300.0, 1000.0, 60.0) == []


def test_other_messages_do_not_count() -> None:
    twin = Twin()
    beat = mavlink.MAVLink_heartbeat_message(11, 12, 1, 0, 3, 3)
    target = mavlink.MAVLink_set_position_target_local_ned_message(7, 1, 1, 1, 0, *(0.0,) * 11)
    assert not any(twin.take(message, 1000.0 + i) for i in range(60) for message in (beat, target))
