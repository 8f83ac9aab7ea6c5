"""Faults of a run: NAME@T[+DURATION], in seconds. Without a duration a fault lasts to the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.actuators.nanotec import NanotecConfig
from companion.config.actuators.nmea2000 import Nmea2000Config
from companion.config.devices import ThrusterConfig
from companion.config.vessel import ConfigError, VesselConfig

OFFSETS_M = (1, 3, 10, 100, 1000, 10_000, 100_000, 1_000_000)
_FIXED = {
    "gnss_lost": "receivers have no fix, position, velocity and heading fields stay empty",
    "gnss_jump": "positions are 25 m off to the north-east",
    **{f"gnss_off_{m}m": f"positions are {m} m off to the north-east" for m in OFFSETS_M},
    "gnss_wild": "every tenth position is near the Equator",
    "rtk_lost": "receivers fall back to a standalone fix",
    "heading_lost": "the heading sentence stays empty",
    "imu_lost": "inertial sensors are silent",
    "leak": "the leak sensor is wet",
    "battery_low": "the battery reports 8 % and a low voltage",
    "mcu_silent": "boards have stopped: they neither receive nor send, thrust is neutral",
    "mcu_deaf": "commands do not reach the boards, whose watchdogs go neutral",
    "rc_safe": "the transmitter's safe switch is on",
    "rc_lost": "the RC receiver has no signal",
}


_OF_THRUSTERS = {  # the board reports only the first
    "dead": "gives nothing",
    "stalled": "gives nothing, and its board does not report it",
    "stuck": "does not turn its azimuth",
    "runaway": "runs ahead at half force, whatever the command",
    "jammed": "moves neither up nor down",
}


def _can(thruster: ThrusterConfig, kind: str) -> bool:
    return {"stuck": thruster.turns, "jammed": thruster.retractable}.get(kind, True)


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault, active in [start_s, end_s)."""

    name: str
    start_s: float
    end_s: float = math.inf


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
        **{
            f"thruster_{t.name}_{kind}": f"thruster {t.name} {text}"
            for t in vessel.thrusters
            for kind, text in _OF_THRUSTERS.items()
            if _can(t, kind)
        },
        **{f"drive_{name}_lost": f"the drive or motor of {name} does not answer" for name in single},
        **{f"{device}_unplugged": f"the port of {device} vanishes" for device in devices},
    }


def parse(text: str, vessel: VesselConfig) -> Fault:
    """`leak@60` or `gnss_lost@120+12` → Fault. Raises ConfigError that says what is wrong and names the faults there
    are."""
    name, at, times = text.partition("@")
    start, plus, duration = times.partition("+")
    try:
        start_s = float(start) if at else 0.0
        duration_s = float(duration) if plus else math.inf
    except ValueError as error:
        raise ConfigError(
            [f"fault '{text}': write NAME@T or NAME@T+DURATION, in seconds, as gnss_lost@120+12"]
        ) from error
    if not at or not (0.0 <= start_s < math.inf and duration_s > 0.0):
        raise ConfigError([f"fault '{text}': write NAME@T or NAME@T+DURATION, in seconds, as gnss_lost@120+12"])
    names = known(vessel)
    if name not in names:
        raise ConfigError([f"fault '{text}': no fault named '{name}'; known: {', '.join(sorted(names))}"])
    return Fault(name, start_s, start_s + duration_s)


class Faults:
    """The faults of a run. `active`: names of those active now; emulated devices read it."""

    __slots__ = ("_change_s", "_faults", "active")

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
        self._change_s = -math.inf

    def planned(self, prefix: str) -> bool:
        """Whether the run has a fault whose name begins with `prefix`."""
        return any(fault.name.startswith(prefix) for fault in self._faults)

    def add(self, fault: Fault) -> None:
        """Add a fault during the run."""
        self._faults.append(fault)
        self._change_s = -math.inf

    def update(self, t_s: float) -> bool:
        """Set `active` for `t_s`. Returns True if it may have changed."""
        if t_s < self._change_s:
            return False
        now_s = t_s + 1e-9
        self.active = frozenset(fault.name for fault in self._faults if fault.start_s <= now_s < fault.end_s)
        edges = [edge for fault in self._faults for edge in (fault.start_s, fault.end_s) if edge > now_s]
        self._change_s = min(edges, default=math.inf) - 1e-9
        return True
