"""The four-corner test with the thesis's hull in the controller; the hull is identified from the log, and the test
repeated."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.hull import HullConfig
from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, Track, between, read_truth
from sitl.scenarios.scenario import Scenario, Settings

_HOLD = 0x03040000
_AGAIN = "again"
_SIDE_M = 5.0
_TURN_RAD = math.radians(45.0)
_SETTLE_S = 20.0
# north and east in sides of the box, heading in eighths of a turn from the start's, time for the leg
_LEGS = ((1, 0, 0, 45.0), (1, -1, 0, 75.0), (1, -1, -1, 35.0), (0, -1, -1, 60.0), (0, 0, 0, 75.0))


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """The test, the identification, and the test again with the identified hull."""
    rig = gcs.rig
    first = _four_corners(gcs)
    found = rig.identify()
    second_rig = rig.rerun_with(found, _AGAIN)
    try:
        second = _four_corners(GroundStation(second_rig))
    finally:
        second_rig.close()
    sitl = rig.config.sitl
    assert sitl is not None
    return {"first_s": first, "second_s": second, "found": found.hull, "true": sitl.plants[sitl.plant].hull}


def _four_corners(gcs: GroundStation) -> tuple[float, float]:
    """(from_s, to_s) of the test. It begins and ends at home with home's heading."""
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    gcs.ready()
    gcs.set_mode(_HOLD)
    gcs.arm()
    _go(gcs, frame, 0.0, 0.0, home.yaw_rad)
    gcs.sail(_SETTLE_S)
    from_s = gcs.rig.now_s
    for north, east, eighths, duration_s in _LEGS:
        _go(gcs, frame, north * _SIDE_M, east * _SIDE_M, wrap_pi(home.yaw_rad + eighths * _TURN_RAD))
        gcs.sail(duration_s)
    return from_s, gcs.rig.now_s


def _go(gcs: GroundStation, frame: LocalFrame, north_m: float, east_m: float, yaw_rad: float) -> None:
    """Go to a place with a heading. COMMAND_INT, since COMMAND_LONG would round the place to half a metre."""
    lat_deg, lon_deg = frame.to_geodetic(north_m, east_m)
    command = mavlink.MAV_CMD_DO_REPOSITION
    gcs.acks.clear()
    gcs.send(
        mavlink.MAVLink_command_int_message(
            1,
            1,
            mavlink.MAV_FRAME_GLOBAL,
            command,
            0,
            0,
            -1.0,
            1.0,
            0.0,
            yaw_rad,
            round(lat_deg * 1e7),
            round(lon_deg * 1e7),
            0.0,
        )
    )
    gcs.wait("go-to accepted", lambda: any(ack.command == command and ack.result == 0 for ack in gcs.acks), 3.0)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Errors of the identified damping, and the tracking error before and after."""
    first = between(read_truth(folder), *asked["first_s"])
    second = between(read_truth(folder / _AGAIN), *asked["second_s"])
    wrong = damping_errors(asked["found"], asked["true"], first)
    before, after = (tracking_iae(track, where) for track, where in ((first, folder), (second, folder / _AGAIN)))
    metrics = {
        "surge_damping_error": wrong[0],
        "sway_damping_error": wrong[1],
        "yaw_damping_error": wrong[2],
        "iae_thesis_model": before,
        "iae_identified": after,
        "iae_ratio": after / before,
    }
    checks = (
        Check("surge damping at the speeds sailed, relative error", wrong[0], 0.1, ""),
        Check("sway damping at the speeds sailed, relative error", wrong[1], 0.15, ""),
        Check("yaw damping at the speeds sailed, relative error", wrong[2], 0.1, ""),
        Check("tracking error with the identified hull over that with the thesis's", after / before, 1.0, ""),
    )
    return metrics, checks


def damping_errors(found: HullConfig, true: HullConfig, track: Track) -> tuple[float, float, float]:
    """RMS difference of the damping forces over the track, as a share of the RMS of the true ones: surge, sway, yaw."""
    errors, sizes = [0.0] * 3, [0.0] * 3
    for row in track:
        theirs, ours = (
            _damping(hull, row["surge_mps"], row["sway_mps"], row["yaw_rate_radps"]) for hull in (true, found)
        )
        for axis in range(3):
            errors[axis] += (ours[axis] - theirs[axis]) ** 2
            sizes[axis] += theirs[axis] ** 2
    surge, sway, yaw = (math.sqrt(error / size) for error, size in zip(errors, sizes, strict=True))
    return surge, sway, yaw


def _damping(hull: HullConfig, u: float, v: float, r: float) -> tuple[float, float, float]:
    """(surge_n, sway_n, yaw_nm) as `companion.config.DampingConfig` defines it."""
    d, au, av, ar = hull.damping, abs(u), abs(v), abs(r)
    return (
        u * (d.x_u + d.x_uu * au + d.x_uuu * au * au),
        v * (d.y_v + d.y_vv * av + d.y_rv * ar + d.y_uv * au) + r * (d.y_r + d.y_vr * av + d.y_rr * ar),
        v * (d.n_v + d.n_vv * av + d.n_rv * ar + d.n_uv * au) + r * (d.n_r + d.n_vr * av + d.n_rr * ar + d.n_ur * au),
    )


def tracking_iae(track: Track, folder: Path) -> float:
    """The thesis's ∫ sqrt((ΔN/5 m)² + (ΔE/5 m)² + (Δψ/50°)²) dt between the truth and the tick's reference."""
    wanted: dict[float, tuple[float, float, float]] = {}
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        for tick in csv.DictReader(file):
            if tick["desired_north_m"]:
                wanted[float(tick["t_s"])] = (
                    float(tick["desired_north_m"]),
                    float(tick["desired_east_m"]),
                    float(tick["desired_yaw_rad"]),
                )
    total, last_s = 0.0, track[0]["t_s"]
    for row in track:
        if row["t_s"] in wanted:
            north, east, yaw = wanted[row["t_s"]]
            error = math.hypot(
                (row["north_m"] - north) / 5.0,
                (row["east_m"] - east) / 5.0,
                wrap_pi(row["yaw_rad"] - yaw) / math.radians(50.0),
            )
            total += error * (row["t_s"] - last_s)
        last_s = row["t_s"]
    return total


SCENARIO = Scenario(
    name="identify",
    text="a hull identified from a four-corner test with a wrong hull, and the test repeated with it",
    vessel="revolt",
    defaults={"wind": "", "current": "", "gnss": "rtk", "hull": "thesis", "anemometer": "off"},
    sail=sail,
    measure=measure,
    lasts_s=620.0,
)
