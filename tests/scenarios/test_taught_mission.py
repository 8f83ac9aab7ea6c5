"""A mission taught by the transmitter's switch and sailed by another, in lockstep: judged by the truth."""

from __future__ import annotations

import math
from pathlib import Path

from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import between, read_truth
from sitl.scenarios.rig import Conditions

HOLD, MISSION = 0x03040000, 0x04040000
TAUGHT = ((8.0, 0.0), (8.0, 8.0))
SAVE, AUTO = 6, 7  # the transmitter's channels 7 and 8, from 0
OPTIONS = {"MAN_RC_SAFE_CH": 0.0, "RC7_OPTION": 7.0, "RC8_OPTION": 16.0}


def test_a_mission_is_taught_and_sailed(tmp_path: Path) -> None:
    gcs = GroundStation(LockstepRig(Conditions("otter", seed=43, wind="2", gnss="rtk", parameters=OPTIONS), tmp_path))
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    pulses = [1500] * 4 + [1000] * 4

    def throw(channel: int, pulse_us: int) -> None:
        pulses[channel] = pulse_us
        gcs.rig.world.set_transmitter(tuple(pulses))
        gcs.sail(0.5)

    throw(SAVE, 1000)
    gcs.ready()
    gcs.set_mode(HOLD)
    gcs.arm()
    for number, point in enumerate((*TAUGHT, (0.0, 0.0)), start=1):
        gcs.reposition(*frame.to_geodetic(*point), math.nan)
        gcs.wait("the point", lambda at=point: math.dist(place(gcs), at) < 0.7, 120.0)  # type: ignore[misc]
        if number <= len(TAUGHT):
            throw(SAVE, 2000)
            throw(SAVE, 1000)
            assert f"Waypoint saved: item {number}" in gcs.texts
    began_s = gcs.rig.now_s
    throw(AUTO, 2000)
    gcs.wait("Mission", lambda: bool(gcs.last["HEARTBEAT"].custom_mode == MISSION), 3.0)
    gcs.wait("its end", lambda: "Mission complete" in gcs.texts, 200.0)
    gcs.rig.close()
    track = [(row["north_m"], row["east_m"]) for row in between(read_truth(tmp_path), began_s)]
    for point in TAUGHT:
        assert min(math.dist(at, point) for at in track) < 1.5


def place(gcs: GroundStation) -> tuple[float, float]:
    truth = gcs.rig.world.truth
    return truth.north_m, truth.east_m
