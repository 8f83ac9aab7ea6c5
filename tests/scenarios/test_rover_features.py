"""What people know from ArduPilot's Rover, in lockstep on the Otter: functions of the transmitter, the fence off on the
way, limits of a stay in Offboard. Ordered by transmitter, mission or ground station, judged by the truth."""

from __future__ import annotations

import math
from pathlib import Path

from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import between, read_truth
from sitl.scenarios.offboard import VELOCITY, setpoint
from sitl.scenarios.rig import Conditions

MANUAL, HOLD, MISSION, RTL, CIRCLE, OFFBOARD = 0x00010000, 0x03040000, 0x04040000, 0x05040000, 0x01030000, 0x00060000
SURGE, YAW, LEARN, SMART, ORBIT, STOP = 1, 3, 4, 5, 6, 7  # channels of the transmitter, from 0
CENTRE_US, OFF_US, ON_US = 1500, 1000, 2000
SETTINGS = {
    "MAN_RC_SAFE_CH": 0.0, "ARMING_RUDDER": 1.0, "RC5_OPTION": 50.0, "RC6_OPTION": 42.0, "RC7_OPTION": 72.0,
    "RC8_OPTION": 81.0, "CIRC_RADIUS": 8.0,
}  # fmt: skip


def sailing(folder: Path, **parameters: float) -> GroundStation:
    conditions = Conditions("otter", seed=45, wind="2", gnss="rtk", parameters={**SETTINGS, **parameters})
    return GroundStation(LockstepRig(conditions, folder))


def in_mode(gcs: GroundStation, mode: int) -> bool:
    return bool(gcs.last["HEARTBEAT"].custom_mode == mode)


def place(gcs: GroundStation) -> tuple[float, float]:
    truth = gcs.rig.world.truth
    return truth.north_m, truth.east_m


def test_armed_by_stick_cruise_learnt_orbit_return_and_disarmed_by_the_transmitter(tmp_path: Path) -> None:
    gcs = sailing(tmp_path)
    pulses = [CENTRE_US] * 4 + [OFF_US] * 4

    def throw(channel: int, pulse_us: int, duration_s: float = 0.5) -> float:
        pulses[channel] = pulse_us
        gcs.rig.world.set_transmitter(tuple(pulses))
        gcs.sail(duration_s)
        return gcs.rig.now_s

    throw(YAW, CENTRE_US)
    gcs.ready()
    gcs.set_mode(MANUAL)
    throw(YAW, ON_US, 2.5)
    throw(YAW, CENTRE_US, 1.0)
    assert "Armed" in gcs.texts
    throw(SURGE, 1800, 5.0)
    learning_s = throw(LEARN, ON_US)
    learnt_s = throw(SURGE, 1800, 6.0)
    throw(LEARN, OFF_US)
    throw(SURGE, CENTRE_US)
    throw(ORBIT, ON_US)
    gcs.wait("Circle", lambda: in_mode(gcs, CIRCLE), 3.0)
    throw(ORBIT, ON_US, 3.0)
    throw(SMART, ON_US)
    gcs.wait("RTL", lambda: in_mode(gcs, RTL), 3.0)
    throw(STOP, ON_US)
    assert "Disarmed" in gcs.texts
    speed_mps = gcs.rig.vessel.parameters["WP_SPEED"]
    gcs.rig.close()
    truth = read_truth(tmp_path)
    sailed = [row["surge_mps"] for row in between(truth, learning_s, learnt_s)]
    assert abs(speed_mps - sum(sailed) / len(sailed)) < 0.05


def test_a_mission_leaves_the_fence_only_where_its_items_switch_it_off(tmp_path: Path) -> None:
    gcs = sailing(tmp_path)
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    corners = ((-15.0, -15.0), (15.0, -15.0), (15.0, 15.0), (-15.0, 15.0))
    gcs.upload(
        [Item(5001, *frame.to_geodetic(*corner), params=(4.0, 0.0, 0.0, 0.0)) for corner in corners],
        mavlink.MAV_MISSION_TYPE_FENCE,
    )
    gcs.ready()
    way = [Item(16, *frame.to_geodetic(*point)) for point in ((25.0, 0.0), (5.0, 0.0))]
    off, on = (Item(207, 0.0, 0.0, params=(value, 0.0, 0.0, 0.0)) for value in (0.0, 1.0))
    gcs.upload([off, *way, on])
    gcs.set_mode(MISSION)
    gcs.arm()
    gcs.wait("beyond the fence", lambda: place(gcs)[0] > 20.0, 60.0)
    gcs.wait("the end", lambda: "Mission complete" in gcs.texts, 90.0)
    assert place(gcs)[0] < 10.0 and not any("Outside the fence" in text for text in gcs.texts)
    assert gcs.last["FENCE_STATUS"].breach_status == 0
    gcs.rig.close()


def test_a_stay_in_offboard_ends_at_its_limit(tmp_path: Path) -> None:
    gcs = sailing(tmp_path)
    ahead = setpoint(1, VELOCITY, 1.0, 0.0, 0.0)
    gcs.ready()
    gcs.set_mode(HOLD)
    gcs.arm()
    gcs.streamed = lambda: (ahead,)
    gcs.command(222, 0.0, 0.0, 0.0, 10.0)
    gcs.sail(1.0)
    gcs.set_mode(OFFBOARD)
    gcs.wait("Hold", lambda: in_mode(gcs, HOLD), 30.0)
    assert any("limit of 10 m reached" in text for text in gcs.texts)
    gcs.sail(15.0)
    assert 9.0 < place(gcs)[0] < 20.0 and math.hypot(*place(gcs)) < 20.0
    gcs.rig.close()
