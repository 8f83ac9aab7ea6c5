"""GPS_RTK and DISTANCE_SENSOR: what they say, and that they are silent without a receiver that uses corrections, or a
sounder."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from companion.core.readings import Corrections, Depth, FixType
from companion.core.tick import Inputs
from companion.io.mavlink.wire import messages as mavlink
from tests.unit.io.mavlink.hub.conftest import Rig, still

KINDS = {"GPS_RTK", "DISTANCE_SENSOR"}


def heard(rig: Rig, inputs: Inputs, seconds: float, **nav: Any) -> list[Any]:
    rig.desk.hear()
    for _ in range(round(10 * seconds)):
        rig.tick(inputs=inputs, nav=replace(still(rig.now_s + 0.1), **nav))
    return [message for message in rig.desk.hear() if message.get_type() in KINDS]


def test_nothing_without_them(rig: Rig) -> None:
    assert heard(rig, Inputs(), 5.0) == []


def test_corrections(rig: Rig) -> None:
    rig.run(10.0)
    found = heard(rig, Inputs(corrections=Corrections(10.0, "gnss", 1.5, 33)), 5.0)
    assert len(found) == 5
    rtk = found[0]
    assert (rtk.time_last_baseline_ms, rtk.rtk_health, rtk.nsats, rtk.accuracy, rtk.baseline_coords_type) == (
        8500,
        1,
        17,
        50,
        1,
    )
    gps = datetime(1980, 1, 6, tzinfo=UTC) + timedelta(weeks=rtk.wn, milliseconds=rtk.tow)
    assert gps - datetime.fromtimestamp(1_780_000_000, UTC) == pytest.approx(
        timedelta(seconds=18 + 10.5), abs=timedelta(seconds=1)
    )
    assert {
        m.rtk_health for m in heard(rig, Inputs(corrections=Corrections(14.0, "gnss", 1.5, 33)), 3.0, fix=FixType.DGPS)
    } == {0}
    assert heard(rig, Inputs(corrections=Corrections(0.0, "gnss", 1.5, 33)), 15.0)[-1].time_last_baseline_ms == 0
    assert heard(rig, Inputs(corrections=Corrections(0.0, "gnss", 1.5, 33)), 2.0) == [], "old news is no news"


def test_corrections_after_seven_weeks(rig: Rig) -> None:
    """Times since the start count modulo 2**32 ms. This one did not: it was an error every few seconds."""
    rig.now_s = 2.0**32 / 1000.0
    rig.run(10.0)
    found = heard(rig, Inputs(corrections=Corrections(rig.now_s, "gnss", 1.5, 33)), 5.0)
    assert len(found) == 5 and found[0].time_last_baseline_ms == 8500


def test_depth(rig: Rig) -> None:
    rig.run(1.0)
    found = heard(rig, Inputs(depth=Depth(1.0, "sounder", 7.4, 0.3, 100.0)), 4.0)
    assert len(found) == 8
    assert (found[0].current_distance, found[0].max_distance, found[0].orientation, found[0].type) == (
        740,
        10_000,
        25,
        1,
    )
    assert heard(rig, Inputs(depth=Depth(1.0, "sounder", 7.4)), 3.0)[-1].max_distance == 0xFFFE
    assert heard(rig, Inputs(depth=Depth(1.0, "sounder", 7.4)), 3.0) == []
    deep = heard(rig, Inputs(depth=Depth(rig.now_s, "sounder", 4000.0)), 1.0)
    assert deep[0].current_distance == 0xFFFE


def test_asked_for(rig: Rig) -> None:
    rig.tick(inputs=Inputs(depth=Depth(0.1, "sounder", 7.4)))
    answers = rig.ask(
        mavlink.MAVLink_command_long_message(1, 1, 512, 0, mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR, 0, 0, 0, 0, 0, 0)
    )
    assert [m.current_distance for m in answers if m.get_type() == "DISTANCE_SENSOR"] == [740]
