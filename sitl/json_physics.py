"""The plant behind ArduPilot's JSON simulation interface, in lockstep: servo pulses in, the state of the boat out.

Source: ArduPilot, libraries/SITL/examples/JSON/readme.md. A packet of servo pulses takes the plant one frame on, and is
answered with the state after it. The autopilot makes its own sensor errors, so the state is the truth.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from companion.config.devices import ThrusterConfig
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.geodesy import LocalFrame
from companion.core.nearest import did_you_mean
from sitl.sensors import gravity_mps2, true_imu
from sitl.world import World

PORT = 9002
_CHANNELS = {18458: 16, 29569: 32}  # by the packet's first number
_HEAD = struct.Struct("<HHI")
_NEUTRAL_US, _SPAN_US = 1500.0, 400.0
_LEAST_HZ, _MOST_HZ = 50, 1200
_SPHERE_M = 6_378_100.0  # radius of the Earth by which ArduPilot turns metres into degrees


@dataclass(frozen=True, slots=True)
class ServoPacket:
    """`rate_hz`: frames a second of the boat's time. `count`: frames since the autopilot started. `pulses_us`: 0 where
    a channel sends nothing."""

    rate_hz: int
    count: int
    pulses_us: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ThrusterChannels:
    """Numbers, from 1, of the channels that drive one thruster; `azimuth` None for one that does not turn."""

    throttle: int
    azimuth: int | None = None


def read_packet(data: bytes) -> ServoPacket | None:
    """The packet in a datagram; None for anything else."""
    if len(data) < _HEAD.size:
        return None
    magic, rate_hz, count = _HEAD.unpack_from(data)
    channels = _CHANNELS.get(magic)
    if channels is None or len(data) != _HEAD.size + 2 * channels:
        return None
    return ServoPacket(rate_hz, count, struct.unpack_from(f"<{channels}H", data, _HEAD.size))


def parse_outputs(text: str, vessel: VesselConfig) -> Mapping[str, ThrusterChannels]:
    """`port=1,starboard=3` or, for a thruster that turns, `stern=1/2`: throttle on channel 1, azimuth on 2. Empty: in
    the order of the file, from 1 on.

    Raises ConfigError for a thruster that does not exist, one left out, or a number that is not 1 to 32.
    """
    if not text:
        return _in_order(vessel.thrusters)
    names = [thruster.name for thruster in vessel.thrusters]
    found: dict[str, ThrusterChannels] = {}
    for part in text.split(","):
        name, _, numbers = part.strip().partition("=")
        if name not in names:
            raise ConfigError([f"outputs '{part}': no thruster '{name}'{did_you_mean(name, names)}"])
        throttle, slash, azimuth = numbers.partition("/")
        found[name] = ThrusterChannels(_channel(throttle, part), _channel(azimuth, part) if slash else None)
    problems = [
        f"outputs: thruster '{row.name}' needs {'NAME=THROTTLE/AZIMUTH' if row.turns else 'NAME=THROTTLE'}"
        for row in vessel.thrusters
        if row.name not in found or row.turns != (found[row.name].azimuth is not None)
    ]
    if problems:
        raise ConfigError(problems)
    return found


def _in_order(thrusters: Sequence[ThrusterConfig]) -> Mapping[str, ThrusterChannels]:
    found: dict[str, ThrusterChannels] = {}
    free = 1
    for thruster in thrusters:
        found[thruster.name] = ThrusterChannels(free, free + 1 if thruster.turns else None)
        free += 2 if thruster.turns else 1
    return found


def _channel(text: str, part: str) -> int:
    if not (text.isascii() and text.isdigit() and 1 <= int(text) <= 32):
        raise ConfigError([f"outputs '{part}': write a channel, 1 to 32"])
    return int(text)


def without_boards(vessel: VesselConfig) -> VesselConfig:
    """The vessel for a world that another autopilot steers: its own boards would hold the thrusters neutral."""
    return replace(vessel, actuators=(), cameras=())


class JsonPhysics:
    """Steps a world `without_boards` by servo packets. `answer(data)`: the reply to a datagram; None where it deserves
    none.

    A frame that comes again is answered again, without a step. A count that goes back is a new autopilot: the boat goes
    on from where it is.
    """

    def __init__(self, world: World, vessel: VesselConfig, outputs: Mapping[str, ThrusterChannels]) -> None:
        self.world = world
        self._rows = [(row, outputs[row.name]) for row in vessel.thrusters]
        self._gravity_mps2 = gravity_mps2(vessel.home.lat_deg)
        self._frame = LocalFrame(vessel.home.lat_deg, vessel.home.lon_deg)
        self._count: int | None = None
        self._now_s = world.t_s
        self._reply = b""

    def answer(self, data: bytes) -> bytes | None:
        """The state after the frame in `data`, as a line of JSON."""
        packet = read_packet(data)
        if packet is None:
            return None
        if packet.count != self._count or not self._reply:
            self._count = packet.count
            self._drive(packet.pulses_us)
            self._now_s += 1.0 / min(max(packet.rate_hz, _LEAST_HZ), _MOST_HZ)
            self.world.advance(self._now_s)
            self._reply = self._state()
        return self._reply

    def _drive(self, pulses_us: Sequence[int]) -> None:
        for (row, channels), thruster in zip(self._rows, self.world.thrusters, strict=True):
            throttle = _share(pulses_us, channels.throttle)
            if channels.azimuth is None:
                thruster.demand(throttle, None)
            else:
                thruster.demand(throttle, _azimuth_rad(row, _share(pulses_us, channels.azimuth)))

    def _on_sphere(self, north_m: float, east_m: float) -> tuple[float, float]:
        """North and east of home on ArduPilot's sphere, so that its receivers tell the true latitude and longitude. On
        the ellipsoid a degree is up to half a per cent shorter or longer."""
        home = self._frame
        lat_deg, lon_deg = home.to_geodetic(north_m, east_m)
        shrink = math.cos(math.radians(0.5 * (lat_deg + home.lat_deg)))
        return (
            math.radians(lat_deg - home.lat_deg) * _SPHERE_M,
            math.radians(math.remainder(lon_deg - home.lon_deg, 360.0)) * shrink * _SPHERE_M,
        )

    def _state(self) -> bytes:
        world, hull, waves = self.world, self.world.hull, self.world.waves
        north_mps, east_mps = body_to_ned(hull.surge_mps, hull.sway_mps, hull.yaw_rad)
        felt = true_imu(self._gravity_mps2, hull, waves)
        ahead_mps, starboard_mps = ned_to_body(
            world.wind.north_mps - north_mps, world.wind.east_mps - east_mps, hull.yaw_rad
        )
        state = {
            "timestamp": round(self._now_s, 6),
            "imu": {"gyro": felt[3:], "accel_body": felt[:3]},
            "position": [*self._on_sphere(hull.north_m, hull.east_m), waves.heave_m],
            "attitude": [waves.roll_rad, waves.pitch_rad, hull.yaw_rad],
            "velocity": [north_mps, east_mps, waves.heave_mps],
            "windvane": {
                "direction": math.atan2(-starboard_mps, -ahead_mps),
                "speed": math.hypot(ahead_mps, starboard_mps),
            },
            "battery": {"voltage": world.battery.voltage_v, "current": world.battery.current_a},
        }
        return f"\n{json.dumps(state, separators=(',', ':'))}\n".encode()  # ArduPilot reads no space before a value


def _share(pulses_us: Sequence[int], channel: int) -> float:
    """−1 to 1; 0 where the channel sends nothing."""
    pulse_us = pulses_us[channel - 1] if channel <= len(pulses_us) else 0
    return 0.0 if pulse_us == 0 else min(max((pulse_us - _NEUTRAL_US) / _SPAN_US, -1.0), 1.0)


def _azimuth_rad(row: ThrusterConfig, share: float) -> float:
    """Neutral is the azimuth of the file; full deflection the stop on that side, or half a turn where there is none."""
    if share >= 0.0:
        most = row.azimuth_rad + math.pi if row.azimuth_max_rad is None else row.azimuth_max_rad
        return row.azimuth_rad + share * (most - row.azimuth_rad)
    least = row.azimuth_rad - math.pi if row.azimuth_min_rad is None else row.azimuth_min_rad
    return row.azimuth_rad - share * (least - row.azimuth_rad)
