"""Followed in Follow mode, by the running process: MAVSDK's follow-me, QGroundControl's stream, and the module on a
lead boat as a process of its own."""

from __future__ import annotations

import contextlib
import math
import os
import socket
import tty
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.action import Action, ActionError
from mavsdk.plugins.follow_me import Config, FollowMe, TargetLocation
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FlightMode, Telemetry
from pymavlink.dialects.v20 import common as mavlink

from tests.protocol.driver import Driver
from tests.protocol.lead_boat_module import FRAME, LeaderProcess, Receiver, along
from tests.protocol.process import Companion, free_port
from tests.waiting import CAP_S, wait_until

pytestmark = pytest.mark.process

FOLLOW = 0x08040000
START_M = 45.0  # of the leader, ahead of the follower
NEARER_M = 8.0


def test_mavsdks_follow_me(tmp_path: Path) -> None:
    """Its plugin sets six parameters, chooses the mode, and only then tells where the target is, once a second.
    Disarmed, the mode may be chosen so."""
    with (
        Companion(tmp_path, vessel="rescuerunner") as companion,
        Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk,
    ):
        sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
        system = sdk.first_autopilot(CAP_S)
        assert system is not None
        telemetry, action, follow_me = Telemetry(system), Action(system), FollowMe(system)
        wait_until(lambda: telemetry.health().is_armable, "armable")
        wanted = Config(11.0, 15.0, 0.4, Config.FollowAltitudeMode.TARGET_GPS, 6.0, 170.0)
        follow_me.set_config(wanted)
        param = Param(system)
        served = [param.get_param_float(f"FLW_TGT_{name}") for name in ("HT", "DST", "RS", "MAX_VEL", "FA")]
        assert served == pytest.approx([11.0, 15.0, 0.4, 6.0, 170.0], abs=1e-6)
        assert param.get_param_int("FLW_TGT_ALT_M") == 2
        follow_me.start()
        wait_until(lambda: telemetry.flight_mode() is FlightMode.FOLLOW_ME, "Follow")
        started_s, distances = companion.now_s, []

        def led_on() -> bool:
            """The target goes on by the boat's clock; MAVSDK sends the newest place once a second."""
            north_m = START_M + 2.0 * (companion.now_s - started_s)
            lat_deg, lon_deg = FRAME.to_geodetic(north_m, 0.0)
            follow_me.set_target_location(TargetLocation(lat_deg, lon_deg, 0.0, 0.0, 0.0, 0.0))
            here = telemetry.position()
            at = FRAME.to_ned(here.latitude_deg, here.longitude_deg)
            distances.append(math.hypot(north_m - at[0], at[1]))
            assert telemetry.flight_mode() is FlightMode.FOLLOW_ME
            if not telemetry.armed():
                with contextlib.suppress(ActionError):  # until the leader has been heard often enough
                    action.arm()
            return telemetry.armed() and distances[-1] < distances[0] - NEARER_M

        wait_until(led_on, "armed and nearer")
        follow_me.stop()
        action.disarm()
        for plugin in (follow_me, param, telemetry, action):
            plugin.destroy()


class Station:
    """A ground station on UDP in driven time: says that it is there, once a second, and keeps what it hears."""

    def __init__(self, companion: Companion, driver: Driver) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", companion.udp_port))
        self._socket.settimeout(CAP_S)
        self._codec = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self._codec.robust_parsing = True
        self.latest: dict[str, Any] = {}
        self.texts: list[str] = []
        self.driver = driver
        driver.step()
        first, self._vehicle = self._socket.recvfrom(65535)
        self._system = self._codec.parse_buffer(first)[0].get_srcSystem()
        self._socket.setblocking(False)
        driver.between.append(self._beat)

    def send(self, message: Any) -> None:
        self._socket.sendto(message.pack(self._codec), self._vehicle)
        self._codec.seq = (self._codec.seq + 1) % 256

    def _beat(self, now_s: float) -> None:
        if now_s % 1.0 < self.driver.step_s - 1e-6:
            self.send(mavlink.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3))

    def hear(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while True:
                for message in self._codec.parse_buffer(self._socket.recv(65535)) or ():
                    if message.get_srcSystem() != self._system:  # of others, passed on
                        continue
                    self.latest[message.get_type()] = message
                    if message.get_type() == "STATUSTEXT":
                        self.texts.append(message.text)

    def until(self, what: str, condition: Callable[[], Any]) -> None:
        """The boat sails on until `condition()`."""

        def heard() -> Any:
            self.hear()
            return condition()

        try:
            self.driver.until(what, heard)
        except AssertionError as error:
            raise AssertionError(f"{error}; {self.texts[-5:]}") from None

    def sail(self, duration_s: float) -> None:
        self.driver.run(duration_s)
        self.hear()

    def _field(self, kind: str, name: str) -> Any:
        return getattr(self.latest.get(kind), name, None)

    @property
    def armed(self) -> bool:
        return bool((self._field("HEARTBEAT", "base_mode") or 0) & 128)

    @property
    def following(self) -> bool:
        return bool(self._field("HEARTBEAT", "custom_mode") == FOLLOW)

    @property
    def place(self) -> tuple[float, float]:
        """North and east of the follower's home."""
        here = self.latest["GLOBAL_POSITION_INT"]
        return FRAME.to_ned(here.lat * 1e-7, here.lon * 1e-7)

    def choose(self) -> None:
        """Follow, disarmed, as soon as the boat knows where it is."""
        self.until("a position", lambda: "Home set here" in self.texts)
        self.send(mavlink.MAVLink_set_mode_message(1, 1, FOLLOW))
        self.until("Follow", lambda: self._field("HEARTBEAT", "custom_mode") == FOLLOW)

    def arm(self) -> None:
        """Ask for it; the boat refuses until it has heard enough of the leader."""
        if not self.armed:
            self.send(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))

    def arm_as_soon_as_allowed(self) -> None:
        """Asks once a second."""
        while not self.armed:
            self.arm()
            self.sail(1.0)
            assert self.driver.now_s < 60.0, self.texts[-5:]

    def close(self) -> None:
        self.driver.between.remove(self._beat)
        self._socket.close()


@contextlib.contextmanager
def station_of(companion: Companion, driver: Driver) -> Iterator[Station]:
    station = Station(companion, driver)
    try:
        yield station
    finally:
        station.close()


def test_qgroundcontrols_follow_me(tmp_path: Path) -> None:
    """As FollowMe.cc sends it (qgroundcontrol: only once the vehicle is in Follow, 4 Hz, position and velocity, no
    heading)."""
    driver = Driver(0.05)
    with Companion(tmp_path, vessel="rescuerunner", driver=driver) as boat, station_of(boat, driver) as station:
        station.choose()
        started_s, distances = driver.now_s, []
        for _ in range(90):
            t_s = driver.now_s - started_s
            north_m = START_M + 5.0 * t_s
            lat_deg, lon_deg = FRAME.to_geodetic(north_m, 0.0)
            station.send(
                mavlink.MAVLink_follow_target_message(
                    round(1000.0 * t_s) + 5000,
                    3,
                    round(lat_deg * 1e7),
                    round(lon_deg * 1e7),
                    0.0,
                    (5.0, 0.0, 0.0),
                    (0.0,) * 3,
                    (0.0,) * 4,
                    (0.0,) * 3,
                    (3.0, 0.0, 4.0),
                    0,
                )
            )
            station.sail(0.25)
            at = station.place
            distances.append(math.hypot(north_m - at[0], at[1]))
            station.arm()
            assert station.following, station.texts[-5:]
        assert station.armed and distances[-1] < distances[4] - NEARER_M, distances


class Radio:
    """A serial radio: two ptys, and what passes between them in each step of the driven time, counted."""

    def __init__(self, driver: Driver) -> None:
        ends = [os.openpty() for _ in range(2)]
        for _, slave in ends:
            tty.setraw(slave)
        self._masters, self._slaves = [master for master, _ in ends], [slave for _, slave in ends]
        self.ports = [os.ttyname(slave) for slave in self._slaves]
        self.carried = [0, 0]
        for master in self._masters:
            os.set_blocking(master, False)
        driver.between.append(self._carry)

    def _carry(self, now_s: float) -> None:
        for n in (0, 1):
            with contextlib.suppress(BlockingIOError):
                data = os.read(self._masters[n], 4096)
                os.write(self._masters[1 - n], data)
                self.carried[n] += len(data)

    def close(self) -> None:
        for fd in (*self._masters, *self._slaves):
            os.close(fd)


@pytest.mark.parametrize("way", ["udp", "serial"])
def test_a_leader_module_is_followed(tmp_path: Path, way: str) -> None:
    """Two processes. Over the serial line both ways together stay under 2,000 bytes a second."""
    driver = Driver(0.05)
    with contextlib.ExitStack() as stack:
        if way == "serial":
            radio = Radio(driver)
            stack.callback(radio.close)
            theirs, ours = (f"serial:{port}:57600" for port in radio.ports)
            theirs += "?telemetry=leader"
        else:
            port = free_port()
            theirs, ours = f"udpin:127.0.0.1:{port}?telemetry=leader", f"udpout:127.0.0.1:{port}"
        companion = Companion(tmp_path, vessel="rescuerunner", driver=driver)
        companion.links = (companion.links[0], theirs)
        stack.enter_context(companion)
        station = stack.enter_context(station_of(companion, driver))
        receiver = Receiver(along(2.0, 0.0, START_M, 0.0), driver)
        stack.callback(receiver.close)
        leader = LeaderProcess(tmp_path / "leader", ours, receiver.port, driver)
        stack.callback(leader.stop)
        station.until("the leader is heard", lambda: "AIS_VESSEL" in station.latest)
        leader.press("a")
        station.choose()
        station.arm_as_soon_as_allowed()
        gaps, before, began_s = [], sum(radio.carried) if way == "serial" else 0, driver.now_s
        for _ in range(6):
            station.sail(1.0)
            assert station.following, station.texts[-5:]
            gaps.append(float(leader.rows[-1]["gap_m"]))
        assert gaps[-1] < gaps[0] - NEARER_M, gaps
        assert {"lead_gap", "lead_link", "lead_sigma", "lead_by"} >= {station.latest["NAMED_VALUE_FLOAT"].name}
        if way == "serial":
            rate = (sum(radio.carried) - before) / (driver.now_s - began_s)
            print(f"{rate:.0f} bytes/s on the serial line, both ways")
            assert 1000.0 < rate < 2000.0
        last = leader.rows[-1]
        assert (last["wish"], last["follower_mode"], last["follower_armed"]) == ("AUTONOMOUS", "Follow", "1") and int(
            last["link_counter"]
        ) <= 2
        code, said, errors = leader.stop()
        assert code == 0 and not errors, errors
        assert all(text in said for text in ("asks Autonomous", "asked for: Autonomous", "follower: Armed")), said
