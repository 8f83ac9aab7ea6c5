"""Three processes on one machine: a jet boat sails by itself, and two others follow what it tells of its position, as
they would any autopilot."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.app import load_vessel
from companion.config.vessel import find
from companion.core.geodesy import LocalFrame
from tests.protocol.driver import Driver
from tests.protocol.process import Companion, free_port
from tests.protocol.test_follow_me import FOLLOW, Station, station_of

pytestmark = pytest.mark.process

LEADER, NEAR, FAR = 2, 1, 3  # system ids
AHEAD_M = {NEAR: 26.0, FAR: 52.0}  # the leader, of each
GAP_M = {NEAR: 20.0, FAR: 45.0}
LEADER_MPS = 3.0
HOLD = 0x03040000


def vessel_file(folder: Path, system: int) -> str:
    """The RescueRunner as that system, which follows the leader."""
    text = find("rescuerunner").read_text(encoding="utf-8")
    own = f"MAV_SYS_ID = {system}\n" + (
        "" if system == LEADER else f"FOLL_SYSID = {LEADER}\nFLW_TGT_DST = {GAP_M[system]}\n"
    )
    path = folder / f"boat{system}.toml"
    path.write_text(text.replace("[parameters]\n", "[parameters]\n" + own, 1), encoding="utf-8")
    return str(path)


class Watch:
    """The ground stations of all boats, heard in turn."""

    def __init__(self, stations: dict[int, Station], frame: LocalFrame, driver: Driver) -> None:
        self._stations, self._frame, self._driver = stations, frame, driver

    def until(self, what: str, condition: Callable[[], Any], within_s: float = 160.0) -> None:
        def heard() -> Any:
            for station in self._stations.values():
                station.hear()
            return condition()

        try:
            self._driver.until(what, heard, within_s)
        except AssertionError as error:
            raise AssertionError(f"{error}; {[s.texts[-4:] for s in self._stations.values()]}") from None

    def mode(self, system: int) -> tuple[int, bool]:
        beat = self._stations[system].latest.get("HEARTBEAT")
        return (0, False) if beat is None else (beat.custom_mode, bool(beat.base_mode & 128))

    def asks(self, system: int, mode: int) -> None:
        """Armed and in that mode; asked again until it is, since arming waits for the sensors."""
        station, asked_s = self._stations[system], -math.inf

        def there() -> bool:
            nonlocal asked_s
            if self._driver.now_s - asked_s > 2.0:
                asked_s = self._driver.now_s
                station.send(mavlink.MAVLink_set_mode_message(system, 1, mode))
                station.send(mavlink.MAVLink_command_long_message(system, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
            return self.mode(system) == (mode, True)

        self.until(f"system {system} armed in {mode:#x}", there)

    def place(self, system: int) -> tuple[float, float]:
        here = self._stations[system].latest["GLOBAL_POSITION_INT"]
        return self._frame.to_ned(here.lat * 1e-7, here.lon * 1e-7)

    def distance_m(self, system: int) -> float:
        return math.dist(self.place(system), self.place(LEADER))


def test_two_follow_a_boat_of_its_own_process(tmp_path: Path) -> None:
    home = load_vessel("rescuerunner").home
    frame, driver = LocalFrame(home.lat_deg, home.lon_deg), Driver()
    with contextlib.ExitStack() as stack:
        ports = {system: free_port() for system in (NEAR, FAR)}
        stations = {}
        for system in (NEAR, FAR, LEADER):
            lat_deg, lon_deg = frame.to_geodetic(0.0 if system == LEADER else -AHEAD_M[system], 0.0)
            extra = ["--home", f"{lat_deg:.7f},{lon_deg:.7f},0", "--seed", str(system)]
            heard = ports.values() if system == LEADER else [ports[system]]
            for port in heard:
                extra += ["--link", f"udpout:127.0.0.1:{port}" if system == LEADER else f"udpin:127.0.0.1:{port}"]
            folder, vessel = tmp_path / str(system), vessel_file(tmp_path, system)
            boat = Companion(folder, extra=tuple(extra), vessel=vessel, driver=driver)
            stations[system] = stack.enter_context(station_of(stack.enter_context(boat), driver))
        watch = Watch(stations, frame, driver)
        watch.asks(LEADER, HOLD)
        for system in (NEAR, FAR):
            watch.asks(system, FOLLOW)
        point = [round(1e7 * degrees) for degrees in frame.to_geodetic(1500.0, 0.0)]
        command = mavlink.MAVLink_command_int_message(
            LEADER, 1, 6, mavlink.MAV_CMD_DO_REPOSITION, 0, 0, LEADER_MPS, 1, 0, math.nan, *point, math.nan
        )
        stations[LEADER].send(command)
        watch.until("the leader is under way", lambda: watch.place(LEADER)[0] > 40.0)
        since_s = driver.now_s

        def in_station() -> bool:
            """All of them for four seconds, the leader being on its way; never too near meanwhile."""
            nonlocal since_s
            assert all(watch.distance_m(system) > 12.0 and watch.mode(system) == (FOLLOW, True) for system in GAP_M)
            off_m = max(abs(watch.distance_m(system) - gap_m) for system, gap_m in GAP_M.items())
            if off_m > 5.0 or stations[LEADER].latest["GLOBAL_POSITION_INT"].vx < 50.0 * LEADER_MPS:
                since_s = driver.now_s
            return driver.now_s - since_s > 4.0

        watch.until("both in station", in_station)
        for station in stations.values():
            assert (
                math.hypot(*(getattr(station.latest["GLOBAL_POSITION_INT"], v) for v in ("vx", "vy")))
                > 30.0 * LEADER_MPS
            )
