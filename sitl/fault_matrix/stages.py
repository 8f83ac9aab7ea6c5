"""A vessel under way in a mode, some seconds after it began: where every cell of that mode starts from."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.fault_matrix.table import VesselRow
from sitl.scenarios.convoy import Convoy
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.offboard import VELOCITY, setpoint
from sitl.scenarios.rig import Composer, Conditions, Rig
from sitl.shared_sea import LeadBoatConfig

PX4_MODES = {
    "Manual": 0x00010000, "Forces": 0x00020000, "Rate": 0x00050000, "Heading": 0x00070000, "Hold": 0x03040000,
    "Mission": 0x04040000, "RTL": 0x05040000, "Dock": 0x06040000, "Follow": 0x08040000, "Offboard": 0x00060000,
    "Circle": 0x01030000, "Trial": 0x040C0000,
}  # fmt: skip
BY_STICK = ("Manual", "Forces", "Rate", "Heading")
_GAP_M = 20.0
_FAR_M = 2000.0
_AWAY_S = 400.0  # of sailing home
_STICK_AHEAD = 250
_UNDER_WAY, _CHECKS_S, _SURGE_S = "Trial: 3/", 600.0, 3.0  # the text of a trial's third manoeuvre; time until then
_FOLLOW = {"kind": "module", "gnss": "standalone", "latency": "0.03", "loss": ""}

Measure = Callable[[float, float], float]
"""(north_m, east_m) → distance from the place or the line, m."""


class Stage:
    """A vessel in a mode. `later(after_s, do)`: something that happens in the course of a cell."""

    def __init__(self, gcs: GroundStation, mode: str, row: VesselRow, convoy: Convoy | None = None) -> None:
        self.gcs, self.mode, self.row, self.convoy = gcs, mode, row, convoy
        self.knowable: Callable[[], bool] | None = None  # whether it can be known now; None: from the onset on
        self.known_s: float | None = None  # since when
        self._later: list[tuple[float, Callable[[], None]]] = []

    @property
    def rig(self) -> Rig:
        """The vessel and its world."""
        return self.gcs.rig

    def later(self, after_s: float, do: Callable[[], None]) -> None:
        """Do something after that time."""
        self._later.append((self.rig.now_s + after_s, do))

    def sail(self, duration_s: float) -> None:
        """Step for that time; what is due is done before its step."""
        end_s = self.rig.now_s + duration_s
        while self.rig.now_s < end_s - 1e-9:
            due = [do for at_s, do in self._later if at_s <= self.rig.now_s + 1e-9]
            self._later = [(at_s, do) for at_s, do in self._later if at_s > self.rig.now_s + 1e-9]
            for do in due:
                do()
            self.gcs.step()
            if self.known_s is None and self.knowable is not None and self.knowable():
                self.known_s = self.rig.now_s

    def measure(self) -> Measure | None:
        """How far the boat is from where it should be, for a fault that begins now. Lines run north and south."""
        truth = self.rig.world.truth
        north_m, east_m = truth.north_m, truth.east_m
        if self.mode in BY_STICK:
            return None
        if self.mode == "Hold":
            return lambda north, east: math.hypot(north - north_m, east - east_m)
        if self.mode == "Dock":
            return _from_line((north_m, east_m), _berth(self.rig))
        if self.mode == "Circle":
            radius_m = math.hypot(north_m - self.row.circle_m, east_m)
            return lambda north, east: abs(math.hypot(north - self.row.circle_m, east) - radius_m)
        if self.mode == "Trial":
            return _outside_circle(self.gcs)
        return lambda north, east: abs(east - east_m)


def begin(row: VesselRow, mode: str, compose: Composer, folder: Path, seed: int) -> Stage:
    """Sail a vessel in a mode until it has settled. Raises GroundStationTimeout where it does not get there."""
    conditions = Conditions(row.name, seed=seed, wind=row.wind or None, gnss=row.gnss, ais=True)
    return _BEGIN.get(mode, _sticks)(row, mode, compose, folder, conditions)


def _sticks(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    gcs = GroundStation(compose(conditions, folder))
    ahead = mavlink.MAVLink_manual_control_message(1, _STICK_AHEAD, 0, 0, 0, 0)
    centred = mavlink.MAVLink_manual_control_message(1, 0, 0, 0, 0, 0)
    gcs.streamed = lambda: (centred,)
    gcs.ready()
    gcs.set_mode(PX4_MODES[mode])
    gcs.arm()
    gcs.streamed = lambda: (ahead,)
    return _settled(Stage(gcs, mode, row))


def _chosen(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    """The mode alone, with nothing to upload or to order."""
    gcs = GroundStation(compose(conditions, folder))
    gcs.ready()
    gcs.set_mode(PX4_MODES[mode])
    gcs.arm()
    return _settled(Stage(gcs, mode, row))


def _mission(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    gcs = GroundStation(compose(conditions, folder))
    gcs.ready()
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *_at(gcs, _FAR_M, 0.0))])
    gcs.set_mode(PX4_MODES["Mission"])
    gcs.arm()
    return _settled(Stage(gcs, mode, row))


def _rtl(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    """From the north, bow to the south."""
    away_m = max(40.0, _AWAY_S * row.leader_mps)
    gcs = GroundStation(compose(_replaced(conditions, start=(away_m, 0.0, math.pi)), folder))
    gcs.ready()
    lat_deg, lon_deg = _at(gcs, 0.0, 0.0)
    frame, set_home = mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_SET_HOME
    x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)
    gcs.send(mavlink.MAVLink_command_int_message(gcs.vessel, 1, frame, set_home, 0, 0, 0.0, 0.0, 0.0, 0.0, x, y, 0.0))
    gcs.set_mode(PX4_MODES["Hold"])
    gcs.arm()
    gcs.set_mode(PX4_MODES["RTL"])
    return _settled(Stage(gcs, mode, row))


def _circle(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    """Around a point north of home, beginning on the circle and along it."""
    gcs = GroundStation(compose(_replaced(conditions, start=(0.0, 0.0, 0.5 * math.pi)), folder))
    gcs.ready()
    gcs.set_mode(PX4_MODES["Hold"])
    gcs.arm()
    lat_deg, lon_deg = _at(gcs, row.circle_m, 0.0)
    gcs.send(
        mavlink.MAVLink_command_int_message(
            gcs.vessel, 1, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_ORBIT, 0, 0,
            -row.circle_m, math.nan, 0.0, math.nan, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0,
        )
    )  # fmt: skip
    return _settled(Stage(gcs, mode, row), 1.5 * row.warm_s)


def _trial(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    """Under way in the first manoeuvre after motor check and dead bands."""
    gcs = GroundStation(compose(conditions, folder))
    gcs.ready()
    gcs.set_mode(PX4_MODES["Hold"])
    gcs.arm()
    gcs.set_mode(PX4_MODES["Trial"])
    gcs.wait("first surge step", lambda: any(_UNDER_WAY in text for text in gcs.texts), _CHECKS_S)
    return _settled(Stage(gcs, mode, row), _SURGE_S)


def _offboard(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    gcs = GroundStation(compose(conditions, folder))
    north = setpoint(1, VELOCITY, row.leader_mps, 0.0, 0.0)
    gcs.ready()
    gcs.arm()
    gcs.streamed = lambda: (north,)
    gcs.sail(0.5)
    gcs.set_mode(PX4_MODES["Offboard"])
    return _settled(Stage(gcs, mode, row))


def _follow(row: VesselRow, mode: str, compose: Composer, folder: Path, conditions: Conditions) -> Stage:
    leader = LeadBoatConfig("leader", f"straight@{row.leader_mps:g}", (_GAP_M, 0.0, 0.0), None, row.gnss)
    follow = {"FLW_TGT_DST": _GAP_M, "FLW_TGT_FA": 180.0}
    rig = compose(_replaced(conditions, lead_boats=(leader,), start=(0.0, 0.0, 0.0), parameters=follow), folder)
    convoy = Convoy((rig,), {**_FOLLOW, "gnss": row.gnss})
    convoy.follow()
    convoy.sail(3.0)
    convoy.boat.depart(convoy.now_s)
    return _settled(Stage(convoy.ground_stations[0], mode, row, convoy), 1.5 * row.warm_s)


_BEGIN = {
    "Hold": _chosen,
    "Mission": _mission,
    "RTL": _rtl,
    "Dock": _chosen,
    "Circle": _circle,
    "Trial": _trial,
    "Offboard": _offboard,
    "Follow": _follow,
}


def _settled(stage: Stage, warm_s: float | None = None) -> Stage:
    """After `warm_s`, or what the vessel's row says."""
    mode = PX4_MODES[stage.mode]
    stage.gcs.wait(stage.mode, lambda: bool(stage.gcs.last["HEARTBEAT"].custom_mode == mode), 3.0)
    stage.sail(stage.row.warm_s if warm_s is None else warm_s)
    return stage


def _replaced(conditions: Conditions, **changes: Any) -> Conditions:
    from dataclasses import replace

    return replace(conditions, **changes)


def _at(gcs: GroundStation, north_m: float, east_m: float) -> tuple[float, float]:
    home = gcs.rig.config.home
    return LocalFrame(home.lat_deg, home.lon_deg).to_geodetic(north_m, east_m)


def _berth(rig: Rig) -> tuple[float, float]:
    dock, home = rig.config.dock, rig.config.home
    if dock is None:
        return 0.0, 0.0
    return LocalFrame(home.lat_deg, home.lon_deg).to_ned(dock.lat_deg, dock.lon_deg)


def _outside_circle(gcs: GroundStation) -> Measure:
    """Distance beyond the circle that the boat tells ground stations."""
    circle, home = gcs.last["ORBIT_EXECUTION_STATUS"], gcs.rig.config.home
    centre = LocalFrame(home.lat_deg, home.lon_deg).to_ned(circle.x * 1e-7, circle.y * 1e-7)
    return lambda north, east: max(0.0, math.hypot(north - centre[0], east - centre[1]) - abs(circle.radius))


def _from_line(begin: Sequence[float], end: Sequence[float]) -> Measure:
    """Distance from the stretch between two places."""
    along = (end[0] - begin[0], end[1] - begin[1])
    square = along[0] ** 2 + along[1] ** 2

    def off_m(north_m: float, east_m: float) -> float:
        share = ((north_m - begin[0]) * along[0] + (east_m - begin[1]) * along[1]) / square if square else 0.0
        share = min(1.0, max(0.0, share))
        return math.hypot(north_m - begin[0] - share * along[0], east_m - begin[1] - share * along[1])

    return off_m
