"""The lines in which the plug-ins tell of the boat."""

from __future__ import annotations

import math
from typing import Any

from companion.io.mavlink.wire import messages as mavlink
from gcs_plugins.commands import MODES
from gcs_plugins.readout import Readout

HERE = (634389000, 103990000)


def heard(*messages: Any) -> Readout:
    readout = Readout()
    for message in messages:
        readout.hear(message.get_type(), message, 100.0)
    return readout


def beat(mode: str, autopilot: int = mavlink.MAV_AUTOPILOT_PX4, armed: bool = True) -> Any:
    number = MODES[mode].rover if autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA else MODES[mode].px4
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_SURFACE_BOAT, autopilot, 0x81 if armed else 1, number, 4, 3
    )


def position(heading_cdeg: int = 1000) -> Any:
    return mavlink.MAVLink_global_position_int_message(0, *HERE, 0, 0, 0, 0, 0, heading_cdeg)


def test_before_anything_is_heard_and_when_it_falls_silent() -> None:
    assert Readout().lines(0.0) == ["no heartbeat of the boat yet"]
    station = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3)
    assert heard(station).mode is None
    assert heard(beat("Manual", armed=False)).lines(110.0) == ["Manual, disarmed (silent for 10 s)"]


def test_dynamic_positioning_is_told_by_distance_and_heading() -> None:
    """The setpoint 3 m north and 4 m east; the bow at 10 degrees, 20 wanted."""
    lat = HERE[0] + round(3.0 / 111_195.0 * 1e7)
    lon = HERE[1] + round(4.0 / 111_195.0 / math.cos(math.radians(63.4389)) * 1e7)
    mask = 0b100100100  # downwards means nothing
    target = mavlink.MAVLink_position_target_global_int_message(
        0, 5, mask, lat, lon, 0.0, 0, 0, 0, 0, 0, 0, math.radians(20.0), 0.0
    )
    lines = heard(beat("Hold"), position(), target).lines(100.0)
    assert lines[1] == "DP: 5.00 m off the setpoint, heading -10.0 deg off 20.0"


def test_path_and_follow() -> None:
    output = mavlink.MAVLink_nav_controller_output_message(0.0, 0.0, 0, 45, 12, 0.0, 0.0, -0.25)
    mission = mavlink.MAVLink_mission_current_message(3, 9)
    assert heard(beat("Mission", mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA), output, mission).lines(100.0)[1:] == [
        "path: 0.25 m to port of it, 12 m to go, item 3 of 9"
    ]
    px4 = mavlink.MAVLink_mission_current_message(2, 9)
    assert heard(beat("Mission"), output, px4).lines(100.0)[1].endswith("item 3 of 9"), "sequence number 2 there"
    assert heard(beat("RTL"), output, mission).lines(100.0)[1:] == ["path: 0.25 m to port of it, 12 m to go"]
    assert heard(beat("Follow"), output).lines(100.0)[1:] == ["follow: 12 m to go, towards 45 deg"]


def test_the_thruster_that_retracts() -> None:
    for value, where in ((0.0, "up"), (0.5, "on its way"), (1.0, "down"), (math.nan, "failed")):
        named = mavlink.MAVLink_named_value_float_message(0, b"bow_down\0\0", value)
        assert heard(beat("Manual"), named).lines(100.0)[1:] == [f"bow thruster: {where}"]
