"""One running vessel, three identities: MAVSDK on a px4 link, MAVProxy on an ardupilot one, a generic client. Each sees
the same mission its own way."""

from __future__ import annotations

import math
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from mavsdk import System
from mavsdk.plugins.action import Action
from mavsdk.plugins.mission_raw import MissionItem, MissionRaw
from mavsdk.plugins.telemetry import FlightMode, Telemetry
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import Companion, free_port
from tests.protocol.test_mavproxy import items_of, row, write
from tests.protocol.test_mavsdk import connected, item, same
from tests.waiting import CAP_S, Every, wait_until

pytestmark = pytest.mark.process

FRAME = LocalFrame(63.4389, 10.3990)
WAYPOINT, JUMP = 16, 177
POINTS = ((10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
HOLD, MISSION = 0x03040000, 0x04040000


def plan(shift_m: float = 0.0) -> list[MissionItem]:
    """A square with a jump back to its first point, once."""
    points = [(north + shift_m, east) for north, east in POINTS]
    items = [item(n, WAYPOINT, point, 0.0, 0.0, 0.0, math.nan) for n, point in enumerate(points)]
    return [*items, item(3, JUMP, None, 0.0, 1.0), item(4, WAYPOINT, (-5.0 + shift_m, -5.0), 0.0, 0.0, 0.0, math.nan)]


class GenericStation:
    """A ground station that knows nothing but the common dialect."""

    def __init__(self, port: int) -> None:
        self._link: Any = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", source_system=253, source_component=190)
        self.heartbeat: Any = None
        self._beat = Every(0.5)

    def close(self) -> None:
        self._link.close()

    def send(self, message: Any) -> None:
        self._link.mav.send(message)

    def hear(self, kind: str, wanted: Callable[[Any], bool] = lambda message: True) -> Any:
        return wait_until(lambda: self._heard(kind, wanted), f"a generic client hears such a {kind}")

    def _heard(self, kind: str, wanted: Callable[[Any], bool]) -> Any:
        """The next such message that has come in."""
        if self._beat.due():
            self.send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
        while (message := self._link.recv_match(blocking=False)) is not None:
            if message.get_type() == "HEARTBEAT" and message.get_srcSystem() == 1:
                self.heartbeat = message
            if message.get_type() == kind and message.get_srcSystem() == 1 and wanted(message):
                return message
        return None

    def download(self) -> list[Any]:
        self.send(mavlink.MAVLink_mission_request_list_message(1, 1, 0))
        count = self.hear("MISSION_COUNT", lambda m: m.target_system == 253).count
        found = []
        for seq in range(count):
            self.send(mavlink.MAVLink_mission_request_int_message(1, 1, seq, 0))
            found.append(self.hear("MISSION_ITEM_INT", lambda m, seq=seq: m.seq == seq and m.target_system == 253))
        self.send(mavlink.MAVLink_mission_ack_message(1, 1, 0, 0))
        return found

    def upload(self, items: list[MissionItem]) -> None:
        self.send(mavlink.MAVLink_mission_count_message(1, 1, len(items), 0))
        while True:
            message = self._link.recv_match(type=["MISSION_REQUEST_INT", "MISSION_ACK"], blocking=True, timeout=CAP_S)
            assert message is not None, "the upload stands still"
            if message.get_type() == "MISSION_ACK":
                assert message.type == mavlink.MAV_MISSION_ACCEPTED
                return
            i = items[message.seq]
            params = (i.param1, i.param2, i.param3, i.param4)
            self.send(
                mavlink.MAVLink_mission_item_int_message(
                    1, 1, i.seq, i.frame, i.command, i.current, i.autocontinue, *params, i.x, i.y, i.z, 0
                )
            )

    def mode(self, number: int) -> None:
        self.send(
            mavlink.MAVLink_command_long_message(
                1, 1, 176, 0, 1.0, number >> 16 & 0xFF, number >> 24, 0.0, 0.0, 0.0, 0.0
            )
        )
        assert self.hear("COMMAND_ACK", lambda m: m.command == 176).result == mavlink.MAV_RESULT_ACCEPTED
        self.hear("HEARTBEAT", lambda m: m.custom_mode == number)


@contextmanager
def all_three(folder: Path) -> Iterator[tuple[System, MavProxy, GenericStation]]:
    rover, plain = free_port(socket.SOCK_STREAM), free_port(socket.SOCK_STREAM)
    boat = Companion(folder, speed=5.0)
    others = (f"tcpin:127.0.0.1:{rover}?dialect=ardupilot", f"tcpin:127.0.0.1:{plain}?dialect=generic")
    boat.links = (boat.links[0], *others)
    with boat, connected(boat) as system, MavProxy(f"tcp:127.0.0.1:{rover}", folder / "mavproxy") as proxy:
        generic = GenericStation(plain)
        try:
            yield system, proxy, generic
        finally:
            generic.close()


def near(wanted: list[MissionItem], rows: list[list[float]]) -> bool:
    """MAVProxy's file of the ardupilot view: home first, everything one higher, the jump's target too."""
    if len(rows) != len(wanted) + 1:
        return False
    for i, cells in zip(wanted, rows[1:], strict=True):
        seq, _, _, command, param1, *_ = cells
        expected = i.param1 + 1.0 if i.command == JUMP else i.param1
        place = (cells[8], cells[9]) if i.command == WAYPOINT else (i.x * 1e-7, i.y * 1e-7)
        if (
            (seq, command, param1) != (i.seq + 1, i.command, expected)
            or abs(place[0] - i.x * 1e-7) > 2e-6
            or abs(place[1] - i.y * 1e-7) > 2e-6
        ):
            return False
    return True


def test_each_uploads_downloads_and_flies_its_own_view_of_the_same_mission(tmp_path: Path) -> None:
    with all_three(tmp_path) as (system, proxy, generic):
        telemetry, action, mission = Telemetry(system), Action(system), MissionRaw(system)
        wait_until(lambda: telemetry.health_all_ok() and telemetry.health().is_armable, "ready to arm")
        heard = generic.hear("HEARTBEAT")
        assert heard.autopilot == mavlink.MAV_AUTOPILOT_GENERIC and heard.type == mavlink.MAV_TYPE_SURFACE_BOAT
        proxy.expect("online system 1")

        mission.upload_mission(plan())
        assert same(mission.download_mission(), plan())
        assert [(m.command, m.x, m.y) for m in generic.download()] == [(i.command, i.x, i.y) for i in plan()]
        proxy.ask("wp list", r"Saved 6 waypoints to .*way.txt", again_s=5.0)
        proxy.ask(f"wp save {tmp_path / 'first.txt'}", r"Saved 6 waypoints to .*first.txt")
        assert near(plan(), items_of(tmp_path / "first.txt"))

        generic.upload(plan(2.0))
        assert [(m.command, m.x, m.y) for m in generic.download()] == [(i.command, i.x, i.y) for i in plan(2.0)]
        assert same(mission.download_mission(), plan(2.0))

        corners = [(0.0, 0.0), *POINTS]
        rows = [row(n, WAYPOINT, corner) for n, corner in enumerate(corners)]
        proxy.say(f"wp load {write(tmp_path / 'rover.txt', rows)}")
        proxy.expect("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
        assert [(m.command, m.seq) for m in generic.download()] == [(WAYPOINT, 0), (WAYPOINT, 1), (WAYPOINT, 2)]
        assert len(mission.download_mission()) == 3

        action.arm()
        mission.start_mission()
        wait_until(lambda: telemetry.flight_mode() == FlightMode.MISSION, "Mission, as MAVSDK has it")
        proxy.expect("Mode AUTO")
        proxy.say("mode hold")
        proxy.expect("Mode HOLD")
        wait_until(lambda: telemetry.flight_mode() == FlightMode.HOLD, "Hold, as MAVSDK has it")
        generic.hear("HEARTBEAT", lambda m: m.custom_mode == HOLD)
        generic.mode(MISSION)
        proxy.expect("Mode AUTO")
        wait_until(lambda: mission.mission_progress().current >= 1, "the first waypoint is behind it")
        proxy.expect(r"waypoint [23]")
        action.disarm()
        wait_until(lambda: not telemetry.armed(), "disarmed")
