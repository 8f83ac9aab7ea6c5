"""MAV_CMD_DO_ORBIT, and the circle that ground stations draw."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.core.decision import ModeId, OrbitState
from companion.modes.circle import OrbitOrder

ACCEPTED, DENIED = 0, 2
DO_ORBIT = 34
NAN = math.nan
ANYWHERE = 0x7FFFFFFF


def result(messages: list[Any]) -> int:
    (answer,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    return int(answer.result)


def test_as_qgroundcontrol_sends_it(rig: Any) -> None:
    """COMMAND_INT in MAV_FRAME_GLOBAL: speed and orbits NaN, front to the centre."""
    assert result(rig.command_int(DO_ORBIT, (-25.0, NAN, 0.0, NAN), 634_400_000, 104_000_000)) == ACCEPTED
    assert rig.supervisor.asked == [
        ("give_order", OrbitOrder((pytest.approx(63.44), pytest.approx(10.4)), 25.0, False, None, None))
    ]


def test_as_qgroundcontrol_sends_it_to_vehicles_without_command_int(rig: Any) -> None:
    assert result(rig.command(DO_ORBIT, 25.0, NAN, 0.0, NAN, 63.5, 10.5, 20.0)) == ACCEPTED
    assert rig.supervisor.asked == [("give_order", OrbitOrder((63.5, 10.5), 25.0, True))]


def test_everything_given(rig: Any) -> None:
    assert result(rig.command(DO_ORBIT, 10.0, 0.5, 3.0, 4.0, 63.5, 10.5)) == ACCEPTED
    assert rig.supervisor.asked == [("give_order", OrbitOrder((63.5, 10.5), 10.0, True, 0.5, 4.0))]


def test_zero_orbits_are_without_end(rig: Any) -> None:
    assert result(rig.command(DO_ORBIT, 10.0, 0.5, 3.0, 0.0, 63.5, 10.5)) == ACCEPTED
    assert rig.supervisor.asked[0][1].total_rad == math.inf


def test_everything_left_out(rig: Any) -> None:
    assert result(rig.command_int(DO_ORBIT, (NAN, NAN, NAN, NAN), ANYWHERE, ANYWHERE)) == ACCEPTED
    assert result(rig.command(DO_ORBIT, NAN, NAN, NAN, NAN, NAN, NAN, NAN)) == ACCEPTED
    assert rig.supervisor.asked == [("give_order", OrbitOrder())] * 2


@pytest.mark.parametrize("behaviour", range(6))
def test_every_yaw_behaviour_is_taken(rig: Any, behaviour: int) -> None:
    assert result(rig.command(DO_ORBIT, 10.0, NAN, float(behaviour), 0.0, 63.5, 10.5)) == ACCEPTED


@pytest.mark.parametrize(
    ("params", "said"),
    [
        ((0.0, NAN, 0.0, 0.0, 63.5, 10.5), "radius"),
        ((math.inf, NAN, 0.0, 0.0, 63.5, 10.5), "radius"),
        ((10.0, 0.0, 0.0, 0.0, 63.5, 10.5), "speed"),
        ((10.0, -1.0, 0.0, 0.0, 63.5, 10.5), "speed"),
        ((10.0, NAN, 6.0, 0.0, 63.5, 10.5), "yaw behaviour"),
        ((10.0, NAN, 0.5, 0.0, 63.5, 10.5), "yaw behaviour"),
        ((10.0, NAN, 0.0, -1.0, 63.5, 10.5), "orbits"),
        ((10.0, NAN, 0.0, 0.0, 95.0, 10.5), "no such place"),
        ((10.0, NAN, 0.0, 0.0, 0.0, 0.0), "no such place"),
        ((10.0, NAN, 0.0, 0.0, NAN, 10.5), "no such place"),
    ],
)
def test_what_cannot_be_meant(rig: Any, params: tuple[float, ...], said: str) -> None:
    messages = rig.command(DO_ORBIT, *params)
    assert result(messages) == DENIED and rig.supervisor.asked == []
    assert any(m.get_type() == "STATUSTEXT" and said in m.text for m in messages)


def test_a_local_frame_is_refused(rig: Any) -> None:
    messages = rig.command_int(DO_ORBIT, (10.0, NAN, 0.0, 0.0), 100_000, 100_000, the_frame=1)
    assert result(messages) == DENIED and rig.supervisor.asked == []


def test_sent_again_by_a_client_that_missed_the_answer_it_is_done_once(rig: Any) -> None:
    for _ in range(3):
        assert result(rig.command(DO_ORBIT, 10.0, NAN, 0.0, 6.28, 63.5, 10.5)) == ACCEPTED
    assert len(rig.supervisor.asked) == 1


def circles(rig: Any) -> list[Any]:
    return [message for message in rig.desk.hear() if message.get_type() == "ORBIT_EXECUTION_STATUS"]


def test_the_circle_is_drawn_in_circle_only(rig: Any) -> None:
    """QGroundControl draws ORBIT_EXECUTION_STATUS as an orbit with an arrow: in Hold that would be a lie."""
    rig.supervisor.change(mode=ModeId.HOLD, armed=True)
    rig.run(3.0)
    assert circles(rig) == []
    rig.supervisor.change(mode=ModeId.CIRCLE, orbit=OrbitState(100.0, -50.0, -12.5))
    rig.run(3.0)
    drawn = circles(rig)
    lat_deg, lon_deg = rig.vessel.frame.to_geodetic(100.0, -50.0)
    assert 2 <= len(drawn) <= 4
    assert {(m.radius, m.frame, m.x, m.y) for m in drawn} == {(-12.5, 5, round(lat_deg * 1e7), round(lon_deg * 1e7))}
    rig.supervisor.change(orbit=None)
    rig.run(3.0)
    assert circles(rig) == []
