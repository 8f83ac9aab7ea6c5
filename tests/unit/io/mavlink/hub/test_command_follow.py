"""DO_FOLLOW, DO_FOLLOW_REPOSITION and MAV_CMD_USER_3: the leader and the station on it. And whose sticks are taken."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.core.decision import ModeId, Outcome, Result
from companion.io.mavlink.wire import messages as mavlink

ACCEPTED, TEMPORARILY_REJECTED, DENIED = 0, 1, 2
FOLLOW, REPOSITION, STATION = 32, 33, 31012
NAN = math.nan


def result(messages: list[Any]) -> int:
    (answer,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    return int(answer.result)


@pytest.mark.parametrize(("param", "system"), [(-1.0, None), (NAN, None), (1.0, 1), (255.0, 255)])
def test_follow(rig: Any, param: float, system: int | None) -> None:
    assert result(rig.command(FOLLOW, param)) == ACCEPTED
    assert rig.supervisor.asked == [("follow", system)]


def test_follow_that_is_refused_is_told(rig: Any) -> None:
    rig.supervisor.outcome = Outcome(Result.TEMPORARILY_REJECTED, "no leader heard")
    assert result(rig.command(FOLLOW, -1.0)) == TEMPORARILY_REJECTED


@pytest.mark.parametrize("param", [256.0, -2.0, 1.5, math.inf])
def test_no_system(rig: Any, param: float) -> None:
    assert result(rig.command(FOLLOW, param)) == DENIED
    assert rig.supervisor.asked == []


def test_system_0_ends_following_as_mavlink_has_it(rig: Any) -> None:
    assert result(rig.command(FOLLOW, 0.0)) == ACCEPTED
    assert rig.supervisor.asked == []
    rig.supervisor.change(mode=ModeId.HOLD, intended_mode=ModeId.FOLLOW)  # also while the leader is lost
    assert result(rig.command(FOLLOW, 0.0)) == ACCEPTED
    assert rig.supervisor.asked == [("hold_here",)]


@pytest.mark.parametrize(
    ("params", "asked"),
    [
        ((90.0, 30.0), (math.pi / 2, 30.0)),
        ((NAN, 30.0), (None, 30.0)),
        ((-135.0, NAN), (math.radians(-135.0), None)),
        ((0.0, 12.0), (0.0, 12.0)),
    ],
)
def test_a_station(rig: Any, params: tuple[float, ...], asked: tuple[float | None, ...]) -> None:
    assert result(rig.command(STATION, *params)) == ACCEPTED
    ((name, *values),) = rig.supervisor.asked
    assert name == "set_follow_position" and values == [
        None if value is None else pytest.approx(value) for value in asked
    ]


def test_a_station_by_command_int(rig: Any) -> None:
    assert result(rig.command_int(STATION, (45.0, 20.0, 0.0, 0.0), 0, 0)) == ACCEPTED
    assert rig.supervisor.asked == [("set_follow_position", pytest.approx(math.pi / 4), 20.0)]


def test_no_station(rig: Any, named: Any) -> None:
    heard = rig.command(STATION, NAN, NAN)
    assert result(heard) == DENIED and "give a bearing" in named(heard, "STATUSTEXT")[0].text
    assert rig.supervisor.asked == []


@pytest.mark.parametrize(
    ("ahead_m", "starboard_m", "bearing_deg", "distance_m"),
    [(-20.0, 0.0, 180.0, 20.0), (0.0, 15.0, 90.0, 15.0), (-30.0, -40.0, -126.869898, 50.0)],
)
def test_a_station_by_offsets(
    rig: Any, ahead_m: float, starboard_m: float, bearing_deg: float, distance_m: float
) -> None:
    assert result(rig.command(REPOSITION, 0.0, 0.0, 0.0, 0.0, 0.0, ahead_m, starboard_m)) == ACCEPTED
    assert rig.supervisor.asked == [
        ("set_follow_position", pytest.approx(math.radians(bearing_deg)), pytest.approx(distance_m))
    ]


def test_offsets_that_cannot_be_meant(rig: Any) -> None:
    assert result(rig.command(REPOSITION, 0.0, 0.0, 0.0, 0.0, 0.0, NAN, 5.0)) == DENIED
    assert result(rig.command_int(REPOSITION, (0.0, 0.0, 0.0, 0.0), 0, -20)) == DENIED
    assert rig.supervisor.asked == []


# --- sticks --------------------------------------------------------------------------------------------------------


def manual(x: int) -> Any:
    return mavlink.MAVLink_manual_control_message(1, x, 0, 0, 0, 0, 0)


def override(value: int) -> Any:
    return mavlink.MAVLink_rc_channels_override_message(1, 1, 1500, value, 1500, 1500, *(65535 for _ in range(4)))


def test_a_lead_boat_that_steers_by_remote_steers_at_once_and_alone(make_rig: Any, named: Any) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    rig.vessel.parameters.set("MAN_GCS_SYSID", 255)
    rig.ask(manual(100))
    rig.supervisor.remote_system = 254
    told = []
    for _ in range(5):
        rig.now_s = round(rig.now_s + 0.1, 9)
        told += named(rig.ask(manual(200)), "STATUSTEXT") + named(rig.ask(override(1600)), "STATUSTEXT")
        rig.ask(manual(300), desk=1)
    assert [sticks.surge for sticks in rig.supervisor.sticks] == [0.1, *(0.3 for _ in range(5))]
    text = "".join(message.text for message in told)
    assert set(text.split("Sticks ignored: ")) == {"", "lead boat 254 steers: choose a mode"}
    assert text.count("Sticks") <= 2  # once, and again when the lead boat began


def test_a_lead_boat_is_told_why_its_sticks_are_not_taken(rig: Any, named: Any) -> None:
    rig.supervisor.module = 255
    heard = named(rig.ask(manual(500)), "STATUSTEXT")
    text = "".join(message.text for message in heard)
    assert text == "Sticks ignored: the crew has not asked for remote control" and rig.supervisor.sticks == []
