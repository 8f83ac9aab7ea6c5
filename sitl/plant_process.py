"""The simulated boat for a companion in another process: its devices send and receive on real ports."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from companion.config.vessel import ConfigError, VesselConfig
from companion.core.ports import ByteStream
from sitl.device_ports import DevicePort, PortAddress, device_port
from sitl.shared_sea import LeadBoatConfig
from sitl.world import World

_DEPARTS_S = 30.0
_AHEAD_M = 20.0


@dataclass(frozen=True, slots=True)
class ServedDevice:
    """A device of the plant, or anything else that reads and writes like a stream, and the port that it uses."""

    name: str
    stream: ByteStream
    port: DevicePort


def serve_devices(
    world: World, vessel: VesselConfig, addresses: Mapping[str, PortAddress], folder: Path
) -> tuple[ServedDevice, ...]:
    """Every device of the vessel, plugged in at `addresses[name]`, where the companion looks for it. Devices at one
    address have one port.

    Raises ConfigError for an address that no simulated device can use, OSError for one that this machine refuses.
    """
    names = [*(row.name for row in vessel.sensors), *(row.name for row in vessel.actuators)]
    ports: list[tuple[PortAddress, DevicePort]] = []
    devices = []
    for name in names:
        address = addresses[name]
        port = next((port for place, port in ports if place == address), None)
        if port is None:
            port = device_port(address, folder)
            ports.append((address, port))
        devices.append(ServedDevice(name, world.open(name, ""), port))
    for _, port in ports:
        port.plug()
    return tuple(devices)


class PlantProcess:
    """Moves bytes between the world's devices and their ports, and the world's time on: `advance(now_s)`."""

    def __init__(self, world: World, devices: Sequence[ServedDevice]) -> None:
        self.world = world
        self._ports: dict[DevicePort, list[ByteStream]] = {}
        for device in devices:
            self._ports.setdefault(device.port, []).append(device.stream)

    def advance(self, now_s: float) -> None:
        """Pass on what the companion wrote, step the world to `now_s`, and send what its devices have sent by then."""
        heard_s = self.world.t_s
        for port, streams in self._ports.items():
            if data := port.take():
                for stream in streams:
                    stream.write(data, heard_s)
        self.world.advance(now_s)
        for port, streams in self._ports.items():
            if all(stream.fault() is not None for stream in streams):
                port.unplug()
                continue
            port.plug()
            for stream in streams:
                for _, data in stream.read(now_s):
                    port.give(data)

    def obey(self, text: str) -> str:
        """Carry out a typed line: `gnss_unplugged` or `gnss_unplugged+3` starts a fault, for so many seconds; `depart`
        starts the lead boat.

        Returns a line that says what happened. Raises ConfigError for anything else.
        """
        if text == "depart" and self.world.shared_sea is not None:
            for boat in self.world.shared_sea.boats:
                boat.depart(self.world.t_s)
            return f"{self.world.t_s:.1f} s: the lead boat departs"
        name, plus, duration = text.partition("+")
        try:
            duration_s = float(duration) if plus else math.inf
        except ValueError:
            duration_s = 0.0
        if not duration_s > 0.0:
            raise ConfigError([f"'{text}': write NAME or NAME+SECONDS"])
        self.world.add_fault(name, duration_s)
        return f"{self.world.t_s:.1f} s: {text}"

    def close(self) -> None:
        """Unplug all ports."""
        for port in self._ports:
            port.unplug()


def parse_leader(text: str, home_yaw_rad: float) -> LeadBoatConfig:
    """`thesis@8.2` or `thesis@8.2+60`: a lead boat 20 m ahead of home that departs after 30 s, or the seconds given.

    Raises ConfigError for a time that is no number of seconds. The script is checked when the lead boat is built.
    """
    script, plus, departs = text.partition("+")
    try:
        depart_s = float(departs) if plus else _DEPARTS_S
    except ValueError:
        depart_s = math.nan
    if not 0.0 <= depart_s < math.inf:
        raise ConfigError([f"leader '{text}': write SCRIPT@MPS+SECONDS, as thesis@8.2+30"])
    start = _AHEAD_M * math.cos(home_yaw_rad), _AHEAD_M * math.sin(home_yaw_rad), home_yaw_rad
    return LeadBoatConfig("leader", script, start, depart_s)
