"""Faults of a run: NAME[:DEVICE][=SIZE]@T[+DURATION], in seconds. Without a duration a fault lasts to the end.

Only a lie of a sensor and a trouble of a receiver (`lie_table.py`) have a device and a size: without them it is all
devices, by the size of the table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.actuators.nanotec import NanotecConfig
from companion.config.actuators.nmea2000 import Nmea2000Config
from companion.config.devices import ThrusterConfig
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.nearest import did_you_mean
from sitl.lie_table import SIZED, Lie, text_of

OFFSETS_M = (1, 3, 10, 100, 1000, 10_000, 100_000, 1_000_000)
_FIXED = {
    "gnss_lost": "receivers have no fix, position, velocity and heading fields stay empty",
    **{f"gnss_off_{m}m": f"positions are {m} m off to the north-east" for m in OFFSETS_M},
    "gnss_wild": "every tenth position is near the Equator",
    "rtk_lost": "receivers fall back to a standalone fix",
    "rtk_float": "receivers fall back to a float solution",
    "heading_lost": "the heading sentence stays empty",
    "imu_lost": "inertial sensors are silent",
    "leak": "the leak sensor is wet",
    "capsized": "the boat rolls over to starboard, by 60 degrees a second, and stays so",
    "aground": "the keel is on the ground: the hull stops, and creeps at most",
    "shallow": "there is 0.5 m of water below sounders",
    "battery_low": "the battery reports 8 % and a low voltage",
    "mcu_silent": "boards have stopped: they neither receive nor send, thrust is neutral",
    "mcu_deaf": "commands do not reach the boards, whose watchdogs go neutral",
    "rc_safe": "the transmitter's safe switch is on",
    "rc_lost": "the RC receiver has no signal",
    "disk_full": "the medium of the log takes nothing: no space is left",
    "disk_read_only": "the medium of the log has become read-only",
}


_OF_THRUSTERS = {  # the board reports only the first
    "dead": "gives nothing",
    "stalled": "gives nothing, and its board does not report it",
    "stuck": "does not turn its azimuth",
    "runaway": "runs ahead at half force, whatever the command",
    "reversed": "pushes the other way, as with two wires exchanged",
    "fouled": "turns as commanded and gives a tenth of its force",
    "jammed": "moves neither up nor down",
}


def _can(thruster: ThrusterConfig, kind: str) -> bool:
    return {
        "stuck": thruster.turns,
        "jammed": thruster.retractable,
        "reversed": thruster.min_n < 0.0,
    }.get(kind, True)


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault, active in [start_s, end_s). `size`, `device`: of a lie or trouble; without a device it is all
    devices'."""

    name: str
    start_s: float
    end_s: float = math.inf
    size: float | None = None
    device: str | None = None


def known(vessel: VesselConfig) -> dict[str, str]:
    """Names of the faults that this vessel can have, each with what it does."""
    devices = [sensor.name for sensor in vessel.sensors] + [bridge.name for bridge in vessel.actuators]
    single: list[str] = []  # thrusters with a drive or motor of their own on a shared line
    for bridge in vessel.actuators:
        if isinstance(bridge, NanotecConfig):
            single += [row.thruster for row in bridge.drives]
        elif isinstance(bridge, Nmea2000Config):
            single += [row.thruster for row in bridge.motors]
    return {
        **_FIXED,
        **{name: text_of(lie) for name, lie in SIZED.items()},
        **{
            f"thruster_{t.name}_{kind}": f"thruster {t.name} {text}"
            for t in vessel.thrusters
            for kind, text in _OF_THRUSTERS.items()
            if _can(t, kind)
        },
        **{f"drive_{name}_lost": f"the drive or motor of {name} does not answer" for name in single},
        **{f"{device}_unplugged": f"the port of {device} vanishes" for device in devices},
        **{f"{device}_garbled": f"on the line of {device} one byte in ten is wrong" for device in devices},
    }


def parse(text: str, vessel: VesselConfig) -> Fault:
    """`leak@60`, `gnss_lost@120+12` or `gnss_jump:spare=5@60` → Fault. Raises ConfigError that says what is wrong and
    names the faults there are."""
    what, at, times = text.partition("@")
    start_s, duration_s = _times(text, times) if at else (-1.0, 0.0)
    if not (0.0 <= start_s < math.inf and duration_s > 0.0):
        raise _badly_written(text)
    named, sized, size = what.partition("=")
    name, limited, device = named.partition(":")
    names = known(vessel)
    if name not in names:
        raise ConfigError(
            [f"fault '{text}': no fault named '{name}'; known: {', '.join(sorted(names))}{did_you_mean(name, names)}"]
        )
    lie = SIZED.get(name)
    if lie is None and (sized or limited):
        raise ConfigError([f"fault '{text}': '{name}' takes neither a size nor a device"])
    return Fault(
        name,
        start_s,
        start_s + duration_s,
        None if lie is None else _size(text, size, lie) if sized else lie.size,
        _device(text, device, vessel) if limited else None,
    )


def _times(text: str, times: str) -> tuple[float, float]:
    """(start_s, duration_s) of `T` or `T+DURATION`."""
    start, plus, duration = times.partition("+")
    try:
        return float(start), float(duration) if plus else math.inf
    except ValueError as error:
        raise _badly_written(text) from error


def _badly_written(text: str) -> ConfigError:
    return ConfigError([f"fault '{text}': write NAME@T or NAME@T+DURATION, in seconds, as gnss_lost@120+12"])


def _size(text: str, size: str, lie: Lie) -> float:
    try:
        value = float(size)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError([f"fault '{text}': write NAME=SIZE@T, as gnss_jump=5@60"])
    least, most = lie.limits
    if not least <= value <= most:
        raise ConfigError([f"fault '{text}': the size must be {least:g} to {most:g} {lie.unit}".rstrip()])
    return value


def _device(text: str, device: str, vessel: VesselConfig) -> str:
    names = [sensor.name for sensor in vessel.sensors]
    if device not in names:
        raise ConfigError([f"fault '{text}': no sensor named '{device}'; there is {', '.join(names)}"])
    return device


class Faults:
    """The faults of a run. `active`: names of those active now; emulated devices read it, and `lies`."""

    __slots__ = ("_change_s", "_faults", "_lies", "active")

    def __init__(self, texts: Sequence[str], vessel: VesselConfig) -> None:
        """Raises ConfigError with one line for each text that is wrong."""
        self._faults: list[Fault] = []
        problems: list[str] = []
        for text in texts:
            try:
                self._faults.append(parse(text, vessel))
            except ConfigError as error:
                problems += error.problems
        if problems:
            raise ConfigError(problems)
        self.active: frozenset[str] = frozenset()
        self._lies: tuple[Fault, ...] = ()
        self._change_s = -math.inf

    def planned(self, prefix: str) -> bool:
        """Whether the run has a fault whose name begins with `prefix`."""
        return any(fault.name.startswith(prefix) for fault in self._faults)

    def lies(self, device: str) -> Sequence[Fault]:
        """The lies that the sensor of that name tells now, and its troubles, in the order in which they were asked
        for."""
        lies = self._lies
        return [lie for lie in lies if lie.device is None or lie.device == device] if lies else ()

    def add(self, fault: Fault) -> None:
        """Add a fault during the run."""
        self._faults.append(fault)
        self._change_s = -math.inf

    def update(self, t_s: float) -> bool:
        """Set `active` for `t_s`. Returns True if it may have changed."""
        if t_s < self._change_s:
            return False
        now_s = t_s + 1e-9
        active = [fault for fault in self._faults if fault.start_s <= now_s < fault.end_s]
        self.active = frozenset(fault.name for fault in active)
        self._lies = tuple(fault for fault in active if fault.name in SIZED)
        edges = [edge for fault in self._faults for edge in (fault.start_s, fault.end_s) if edge > now_s]
        self._change_s = min(edges, default=math.inf) - 1e-9
        return True
