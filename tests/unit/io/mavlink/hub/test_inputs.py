from __future__ import annotations

from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink

ABSENT = 0x7FFF


def manual(x: int = 0, y: int = 0, z: int = 0, r: int = 0, target: int = 1, **more: int) -> Any:
    return mavlink.MAVLink_manual_control_message(target, x, y, z, r, more.get("buttons", 0), more.get("buttons2", 0))


def override(*values: int, target: int = 1, component: int = 1) -> Any:
    padded = (*values, *(65535 for _ in range(8 - len(values))))
    return mavlink.MAVLink_rc_channels_override_message(target, component, *padded)


def test_sticks_reach_the_supervisor_at_once(rig: Any) -> None:
    rig.now_s = 2.0
    rig.ask(manual(500, -250, 0, 1000, buttons=0x8001, buttons2=0x2))
    (sticks,) = rig.supervisor.sticks
    assert (sticks.surge, sticks.sway, sticks.yaw, sticks.t_s, sticks.buttons) == (0.5, -0.25, 1.0, 2.0, 0x28001)
    assert sticks.source == "mavlink:255"


def test_the_surge_axis_is_a_parameter(rig: Any) -> None:
    rig.vessel.parameters.set("MAN_AXIS_SURGE", 1)
    rig.ask(manual(500, 0, -700, 0))
    assert rig.supervisor.sticks[0].surge == -0.7


def test_absent_axes_and_values_out_of_range(rig: Any) -> None:
    rig.ask(manual(ABSENT, -1500, ABSENT, -32768))
    sticks = rig.supervisor.sticks[0]
    assert (sticks.surge, sticks.sway, sticks.yaw) == (None, -1.0, -1.0)


@pytest.mark.parametrize("target", [0, 2, 255])
def test_sticks_for_others_are_not_ours(rig: Any, target: int) -> None:
    rig.ask(manual(500, target=target))
    rig.ask(override(1600, 1600, 1600, 1600, target=target))
    assert rig.supervisor.sticks == []


def test_one_station_may_be_chosen(make_rig: Any) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    rig.vessel.parameters.set("MAN_GCS_SYSID", 254)
    rig.ask(manual(500))
    rig.ask(override(1600, 1600, 1600, 1600))
    assert rig.supervisor.sticks == []
    rig.ask(manual(300), desk=1)
    assert [sticks.source for sticks in rig.supervisor.sticks] == ["mavlink:254"]


@pytest.mark.parametrize(
    "stick", [lambda: manual(500), lambda: override(1600, 1600, 1600, 1600)], ids=["manual control", "override"]
)
def test_of_two_stations_the_first_steers_until_it_is_silent(make_rig: Any, named: Any, stick: Any) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    told = []
    for _ in range(20):
        rig.now_s = round(rig.now_s + 0.1, 9)
        rig.ask(manual(300))
        told += named(rig.ask(stick(), desk=1), "STATUSTEXT")
    assert {sticks.source for sticks in rig.supervisor.sticks} == {"mavlink:255"}
    text = "".join(message.text for message in told)
    assert text == "Sticks ignored: system 255 steers"
    silent_s = rig.now_s
    for _ in range(10):
        rig.now_s = round(rig.now_s + 0.1, 9)
        rig.ask(stick(), desk=1)
    taken = [sticks.t_s for sticks in rig.supervisor.sticks if sticks.source == "mavlink:254"]
    assert min(taken) == pytest.approx(silent_s + 0.6)  # COM_RC_LOSS_T is 0.5 s
    before = len(rig.supervisor.sticks)
    assert named(rig.ask(manual(300)), "STATUSTEXT")
    assert len(rig.supervisor.sticks) == before


def test_two_stations_of_the_same_number_are_told_apart(make_rig: Any, named: Any) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    rig.desks[1].system = 255
    rig.ask(manual(300))
    heard = named(rig.ask(manual(-300), desk=1), "STATUSTEXT")
    assert "system 255 on another link steers" in "".join(message.text for message in heard)
    assert [sticks.surge for sticks in rig.supervisor.sticks] == [0.3]
    rig.vessel.parameters.set("MAN_GCS_SYSID", 255)  # chosen: on whichever link it comes
    rig.ask(manual(-300), desk=1)
    assert [sticks.surge for sticks in rig.supervisor.sticks] == [0.3, -0.3]


def test_who_only_releases_channels_does_not_steer(make_rig: Any) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    rig.ask(override(0, 0, 0, 0))
    rig.ask(manual(300), desk=1)
    assert [sticks.source for sticks in rig.supervisor.sticks] == ["mavlink:254"]


def test_overridden_channels_are_those_of_the_transmitter(rig: Any) -> None:
    rig.ask(override(1250, 1750, 2000, 1000))
    sticks = rig.supervisor.sticks[-1]
    assert (sticks.sway, sticks.surge, sticks.yaw) == (-0.5, 0.5, -1.0)
    rig.vessel.parameters.set("MAN_AXIS_SURGE", 1)
    rig.ask(override(65535, 65535, 2200, 65535))  # the others stay as they were
    sticks = rig.supervisor.sticks[-1]
    assert (sticks.sway, sticks.surge, sticks.yaw) == (-0.5, 1.0, -1.0)


@pytest.mark.parametrize("by_throttle", [0, 1])
def test_clients_of_ardupilot_override_the_channels_of_a_rover(make_rig: Any, by_throttle: int) -> None:
    """Mission Planner's joystick, MAVProxy's `rc 1`, DroneKit's `channels.overrides`: 1 steers, 3 is the throttle."""
    rig = make_rig(["memory:rover?dialect=ardupilot"])
    rig.vessel.parameters.set("MAN_AXIS_SURGE", by_throttle)
    rig.ask(override(1700, 65535, 1250, 65535))
    sticks = rig.supervisor.sticks[-1]
    assert (sticks.surge, sticks.sway, sticks.yaw) == (-0.5, None, 0.4)
    rig.ask(override(1500, 2000, 1500, 1600))
    sticks = rig.supervisor.sticks[-1]
    assert (sticks.surge, sticks.sway, sticks.yaw) == (0.0, 0.2, 0.0)


def test_released_channels_are_absent_and_all_released_is_silence(rig: Any) -> None:
    rig.ask(override(1250, 1750, 1500, 1600), override(0, 65535, 65535, 0))
    sticks = rig.supervisor.sticks[-1]
    assert (sticks.sway, sticks.surge, sticks.yaw) == (None, 0.5, None)
    rig.ask(override(0, 0, 0, 0))
    rig.ask(override(65535, 65535, 65535, 65535))
    assert len(rig.supervisor.sticks) == 2


def test_channels_are_forgotten_when_their_source_falls_silent(rig: Any) -> None:
    rig.ask(override(65535, 1800, 65535, 65535))
    rig.now_s += rig.vessel.parameters["COM_RC_LOSS_T"]
    rig.ask(override(65535, 65535, 65535, 1600))
    assert (rig.supervisor.sticks[-1].surge, rig.supervisor.sticks[-1].yaw) == (0.6, 0.2)
    rig.now_s += rig.vessel.parameters["COM_RC_LOSS_T"] + 0.01
    rig.ask(override(65535, 65535, 65535, 1500))
    assert (rig.supervisor.sticks[-1].surge, rig.supervisor.sticks[-1].yaw) == (None, 0.0)
    rig.now_s += 60.0
    rig.ask(override(65535, 65535, 65535, 65535))
    assert len(rig.supervisor.sticks) == 3


def test_timesync_answers_questions_only(rig: Any, named: Any) -> None:
    rig.now_s = 12.5
    (answer,) = named(rig.ask(mavlink.MAVLink_timesync_message(0, 987654321)), "TIMESYNC")
    assert (answer.tc1, answer.ts1) == (12_500_000_000, 987654321)
    assert (answer.target_system, answer.target_component) == (255, 190)
    assert named(rig.ask(mavlink.MAVLink_timesync_message(5, 6)), "TIMESYNC") == []


def test_ping_is_returned_to_the_sender(rig: Any, named: Any) -> None:
    (answer,) = named(rig.ask(mavlink.MAVLink_ping_message(77, 5, 0, 0)), "PING")
    assert (answer.time_usec, answer.seq, answer.target_system, answer.target_component) == (77, 5, 255, 190)
    assert named(rig.ask(mavlink.MAVLink_ping_message(77, 5, 1, 1)), "PING") == []
