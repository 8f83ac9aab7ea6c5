"""The plant beside a companion in another process: its devices speak through real ports."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from companion.config import ConfigError, VesselConfig
from companion.core.ports import ByteStream
from sitl.far_ends import FarEnd, Place, far_end
from sitl.waters import OtherBoat
from sitl.world import World

_DEPARTS_S = 30.0
_AHEAD_M = 20.0


@dataclass(frozen=True, slots=True)
class Offered:
    """A device of the plant: its own stream, and the port that it is offered at. Whatever can be read like a stream can be offered."""

    name: str
    stream: ByteStream
    end: FarEnd


def offered(world: World, vessel: VesselConfig, places: Mapping[str, Place], folder: Path) -> tuple[Offered, ...]:
    """Every device of the vessel, plugged in where `places` has the companion look for it by its name.

    Raises ConfigError for a port at which no simulated device can be, OSError for one that this machine does not give.
    """
    names = [*(row.name for row in vessel.sensors), *(row.name for row in vessel.actuators)]
    devices = [Offered(name, world.open(name, ""), far_end(places[name], folder)) for name in names]
    for device in devices:
        device.end.plug()
    return tuple(devices)


class PlantProcess:
    """`advance(now_s)`: take what the companion wrote, bring the world up to `now_s`, and give what its devices have sent by then."""

    def __init__(self, world: World, devices: Sequence[Offered]) -> None:
        self.world = world
        self._devices = tuple(devices)

    def advance(self, now_s: float) -> None:
        heard_s = self.world.t_s
        for device in self._devices:
            if data := device.end.take():
                device.stream.write(data, heard_s)
        self.world.advance(now_s)
        for device in self._devices:
            if device.stream.fault() is None:
                device.end.plug()
                for _, data in device.stream.read(now_s):
                    device.end.give(data)
            else:
                device.end.unplug()

    def obey(self, text: str) -> str:
        """What somebody types: `gnss_unplugged` or `gnss_unplugged+3`, a fault from now on, for so many seconds; `depart`, for a lead boat.

        Returns what has been done. Raises ConfigError for what does not exist.
        """
        if text == "depart" and self.world.waters is not None:
            for boat in self.world.waters.boats:
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
        for device in self._devices:
            device.end.unplug()


def leader(text: str, home_yaw_rad: float) -> OtherBoat:
    """`thesis@8.2` or `thesis@8.2+60`: a lead boat 20 m ahead of home that departs after 30 s, or so many. The script is judged where it is read.

    Raises ConfigError for a time that is none.
    """
    script, plus, departs = text.partition("+")
    try:
        depart_s = float(departs) if plus else _DEPARTS_S
    except ValueError as error:
        raise ConfigError([f"leader '{text}': write SCRIPT@MPS+SECONDS, as thesis@8.2+30"]) from error
    start = _AHEAD_M * math.cos(home_yaw_rad), _AHEAD_M * math.sin(home_yaw_rad), home_yaw_rad
    return OtherBoat("leader", script, start, depart_s)
