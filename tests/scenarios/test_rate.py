"""Rate in lockstep: chosen by the transmitter's mode switch, steered by its sticks, judged by the truth."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.control.manual import beyond_deadband
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import between, read_truth
from sitl.scenarios.rig import Conditions

RATE = 0x00050000
SURGE, YAW, SWITCH = 1, 3, 7  # the transmitter's channels 2, 4 and 8, from 0
SETTINGS = {"MAN_RC_SAFE_CH": 0.0, "RC_MAP_FLTMODE": 8.0, "COM_FLTMODE1": 0.0, "COM_FLTMODE6": 6.0}
CENTRE_US, HALF_US, HALF = 1500, 1750, 0.5
LOST_S = 50.0


@pytest.mark.parametrize("vessel", ["otter", pytest.param("revolt", marks=pytest.mark.sweep)])
def test_turn_rate_and_speed_are_kept_in_wind_and_without_a_fix_sticks_give_force(tmp_path: Path, vessel: str) -> None:
    faults = (f"gnss_lost@{LOST_S:g}",)
    rig = LockstepRig(Conditions(vessel, seed=44, wind="3", parameters=SETTINGS, faults=faults), tmp_path)
    gcs, pulses = GroundStation(rig), [CENTRE_US] * 7 + [1000]

    def throw(channel: int, pulse_us: int, duration_s: float) -> float:
        pulses[channel] = pulse_us
        rig.world.set_transmitter(tuple(pulses))
        gcs.sail(duration_s)
        return rig.now_s

    throw(SWITCH, 1000, 0.5)
    gcs.ready()
    throw(SWITCH, 2000, 0.5)
    gcs.wait("Rate", lambda: bool(gcs.last["HEARTBEAT"].custom_mode == RATE), 3.0)
    gcs.arm()
    ahead_s = throw(SURGE, HALF_US, 8.0)
    turning_s = throw(YAW, HALF_US, 4.0)
    turned_s = throw(YAW, HALF_US, 10.0)
    assert turned_s < LOST_S
    lost_s = throw(YAW, CENTRE_US, LOST_S - turned_s + 8.0)
    blind_s = throw(YAW, HALF_US, 8.0)
    assert "Rate: no position, sticks give force" in gcs.texts
    assert gcs.last["HEARTBEAT"].custom_mode == RATE
    gcs.command(400, 0.0)
    gcs.sail(3.0)
    parameters = rig.vessel.parameters
    rig.close()
    share = beyond_deadband(HALF, parameters["MAN_DEADBAND"])
    truth = read_truth(tmp_path)
    turn = mean(truth, "yaw_rate_radps", turning_s, turned_s)
    assert turn == pytest.approx(share * math.radians(parameters["MAN_YAW_RATE"]), rel=0.1)
    speed = mean(truth, "surge_mps", ahead_s - 2.0, ahead_s)
    assert speed == pytest.approx(share * parameters["WP_SPEED"], rel=0.1)
    assert abs(mean(truth, "yaw_rate_radps", turned_s + 6.0, LOST_S)) < math.radians(1.0), "straight on"
    assert mean(truth, "surge_mps", lost_s - 2.0, lost_s) > 0.2, "thrust goes on as the stick asks"
    blind = mean(truth, "yaw_rate_radps", lost_s + 4.0, blind_s)
    assert blind == pytest.approx(turn, rel=0.15), "the gyro goes on"
    thrust_n = [value for name, value in truth[-1].items() if name.endswith("_force_n")]
    assert len(thrust_n) == len(rig.config.thrusters) and max(map(abs, thrust_n)) < 0.5, "disarmed is neutral"


def mean(truth: list[dict[str, float]], name: str, from_s: float, until_s: float) -> float:
    rows = [row[name] for row in between(truth, from_s, until_s)]
    return sum(rows) / len(rows)
