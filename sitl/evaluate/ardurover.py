"""ArduRover on the project's plant, in lockstep and in one thread: its physics packets are answered here, and its
MAVLink is heard in between, so that it cannot run ahead of its ground station however loaded the machine is.

The binary is the user's own. It speaks to this process alone, over the loopback interface.
"""

from __future__ import annotations

import math
import select
import socket
import subprocess
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from companion.config.vessel import HomeConfig, VesselConfig
from sitl.evaluate.rover_station import RoverStation
from sitl.json_physics import JsonPhysics, ThrusterChannels
from sitl.scenarios.measure import Point
from sitl.truth_log import TruthLog
from sitl.world import World

_LOOPBACK = "127.0.0.1"
_TRUTH_S = 0.05
_WAIT_S, _WAITS = 1.0, 60  # by the wall clock: so often it may be silent for so long
_AGAIN_S = 2.0  # of the boat's time, between two sendings of an order
_LIVE_HZ: Mapping[int, float] = {
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 5.0,
    mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: 2.0,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT: 2.0,
    mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: 10.0,
}


class RoverError(Exception):
    """ArduRover did not do what it was asked."""


class ArduRover:
    """A binary of ArduRover that steers `world`, and its ground station, `station`.

    `folder` gets its files and truth.csv. Every method that waits advances the boat's time.
    """

    def __init__(
        self,
        binary: Path,
        parameters: Mapping[str, float],
        vessel: VesselConfig,
        world: World,
        outputs: Mapping[str, ThrusterChannels],
        folder: Path,
    ) -> None:
        """Start it with these of its parameters. Raises OSError where it cannot be started."""
        folder.mkdir(parents=True, exist_ok=True)
        self.station = RoverStation(vessel.home)
        self._physics = JsonPhysics(world, vessel, outputs)
        self._truth = TruthLog(folder, world, tuple(thruster.name for thruster in vessel.thrusters))
        self._truth_s = 0.0
        self._pulses, self._words = _bound(), _bound()
        self._peer: tuple[str, int] | None = None
        (folder / "parameters.parm").write_text("".join(f"{name} {value:.9g}\n" for name, value in parameters.items()))
        self._printed = (folder / "ardurover.txt").open("wb")
        command = [str(binary.resolve()), *_options(vessel.home, _port(self._pulses), _port(self._words))]
        self._process = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=self._printed, stderr=subprocess.STDOUT
        )

    def close(self) -> None:
        """End it."""
        self._process.kill()
        self._process.wait()
        for thing in (self._pulses, self._words, self._printed, self._truth):
            thing.close()

    @property
    def t_s(self) -> float:
        """The boat's time."""
        return self._physics.world.t_s

    def ready(self) -> None:
        """Wait until its estimate holds a position."""
        self.wait("a heartbeat", lambda: self.station.mode is not None, 60.0)
        self._say(self.station.command(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION))
        for message, rate_hz in _LIVE_HZ.items():
            self._say(self.station.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message, 1.0e6 / rate_hz))
        self.wait("a position of its estimate", lambda: self.station.knows_place, 180.0)

    def set_mode(self, mode: int) -> None:
        """Change the mode."""
        order = self.station.command(
            mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, float(mode)
        )
        self.wait(f"mode {mode}", lambda: self.station.mode == mode, 30.0, lambda: self._say(order))

    def arm(self) -> None:
        """Arm."""
        order = self.station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
        self.wait("armed", lambda: self.station.armed, 60.0, lambda: self._say(order))

    def go_to(self, point: Point) -> None:
        """Send it to a point, in mode Guided."""
        self._say(self.station.go_to(point))

    def upload(self, points: Sequence[Point]) -> None:
        """Upload a mission of waypoints, numbered from 1. Raises RoverError where it is refused."""
        station, items = self.station, [(0.0, 0.0), *points]  # item 0 is its home
        station.verdict = None

        def accepted() -> bool:
            while station.asked:
                number = station.asked.pop()
                self._say(station.item(number, items[number]))
            return station.verdict is not None

        self.wait("an answer to a mission", accepted, 60.0, lambda: self._say(station.count(items)))
        if station.verdict != mavlink.MAV_MISSION_ACCEPTED:
            raise RoverError(f"the mission was refused ({station.verdict})")

    def sail(self, seconds: float) -> None:
        """Let it sail for so long."""
        end_s = self.t_s + seconds
        while self.t_s < end_s:
            self._step()

    def wait(self, what: str, done: Callable[[], bool], limit_s: float, ask: Callable[[], None] | None = None) -> None:
        """Sail until `done()`; `ask` is called at once and again every two seconds.

        Raises RoverError where it takes longer than `limit_s`.
        """
        end_s, due_s = self.t_s + limit_s, self.t_s
        while not done():
            if self.t_s >= end_s:
                raise RoverError(f"{what}: not within {limit_s:.0f} s ({'; '.join(self.station.texts[-3:])})")
            if ask is not None and self.t_s >= due_s:
                due_s = self.t_s + _AGAIN_S
                ask()
            self._step()

    def _say(self, data: bytes) -> None:
        if self._peer is not None:
            self._words.sendto(data, self._peer)

    def _step(self) -> None:
        """Answer one packet of pulses, and hear what was said until it came. Raises RoverError where none comes."""
        silent = 0
        while self._pulses not in (ready := select.select([self._pulses, self._words], [], [], _WAIT_S)[0]):
            if self._words in ready:
                self._hear()
                continue
            silent += 1
            if self._process.poll() is not None or silent >= _WAITS:
                raise RoverError("it went away; what it printed stands in ardurover.txt")
        if self._words in ready:
            self._hear()
        data, peer = self._pulses.recvfrom(2048)
        reply = self._physics.answer(data)
        if self.t_s >= self._truth_s:
            self._truth_s = self.t_s + _TRUTH_S
            self._truth.write()
        if reply is not None:
            self._pulses.sendto(reply, peer)

    def _hear(self) -> None:
        data, self._peer = self._words.recvfrom(4096)
        self.station.hear(data)


def _options(home: HomeConfig, pulses_port: int, words_port: int) -> list[str]:
    return [
        "--wipe",
        "--model", f"JSON:{_LOOPBACK}", "--sim-port-out", str(pulses_port), "--speedup", "1000",
        "--home", f"{home.lat_deg},{home.lon_deg},0,{math.degrees(home.yaw_rad)}",
        "--defaults", "parameters.parm",
        "--base-port", str(_free_port()), "--rc-in-port", str(_free_port()),
        "--serial0", f"udpclient:{_LOOPBACK}:{words_port}", "--serial1", "none:", "--serial2", "none:",
    ]  # fmt: skip


def _bound() -> socket.socket:
    found = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    found.bind((_LOOPBACK, 0))
    return found


def _port(bound: socket.socket) -> int:
    port: int = bound.getsockname()[1]
    return port


def _free_port() -> int:
    with _bound() as found:
        return _port(found)
