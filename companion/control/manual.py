"""Sticks → wrench, and sticks → thrusters, each stick −1…1: surge ahead, sway to starboard, yaw clockwise."""

from __future__ import annotations

import math

from companion.config import ThrusterConfig, VesselConfig
from companion.core.types import ThrusterCommand, Wrench
from companion.params import Parameters

_SIDEWAYS = 0.7  # share of a fixed thruster's push across the hull from which it counts as a side thruster


def stick_to_wrench(surge: float, sway: float, yaw: float, config: VesselConfig, parameters: Parameters) -> Wrench:
    """Full stick is the vessel's limit on that axis. Non-finite sticks count as centred."""
    dead = parameters["MAN_DEADBAND"]
    limits = config.limits
    return Wrench(_beyond(surge, dead) * limits.surge_n, _beyond(sway, dead) * limits.sway_n, _beyond(yaw, dead) * limits.yaw_nm)


def stick_to_thrusters(surge: float, sway: float, yaw: float, config: VesselConfig, parameters: Parameters) -> tuple[ThrusterCommand, ...]:
    """Direct mapping, as on ReVolt: surge is throttle of whatever pushes ahead, yaw turns azimuths by up to `manual_azimuth_rad`, sway is
    throttle of side thrusters. Where nothing turns, yaw is differential throttle, or else the side thrusters'. Sticks keep their sense
    astern: azimuths then turn the other way. A jet knows no astern: its nozzle keeps its sense and its throttle ends at 0."""
    dead = parameters["MAN_DEADBAND"]
    surge, sway, yaw = _beyond(surge, dead), _beyond(sway, dead), _beyond(yaw, dead)
    steered = any(t.turns and t.manual_azimuth_rad > 0.0 for t in config.thrusters)
    differential = not steered and any(t.kind == "fixed" and not _is_sideways(t) and t.y_m != 0.0 for t in config.thrusters)
    return tuple(_one(t, surge, sway, yaw, steered, differential) for t in config.thrusters)


def _one(t: ThrusterConfig, surge: float, sway: float, yaw: float, steered: bool, differential: bool) -> ThrusterCommand:
    if t.turns and t.manual_azimuth_rad > 0.0:
        lever = math.copysign(1.0, t.x_m) * (-1.0 if surge < 0.0 and t.kind != "jet" else 1.0)  # a stern thruster turns the boat by pushing the stern the other way
        return _command(t, surge, t.azimuth_rad + lever * yaw * t.manual_azimuth_rad)
    if _is_sideways(t):
        side = math.copysign(1.0, math.sin(t.azimuth_rad))
        turn = 0.0 if steered or differential else yaw * math.copysign(1.0, t.x_m)
        return _command(t, side * (sway + turn), t.azimuth_rad)
    ahead = math.copysign(1.0, math.cos(t.azimuth_rad))
    turn = -yaw * math.copysign(1.0, t.y_m) if differential and t.y_m != 0.0 else 0.0
    return _command(t, ahead * (surge + turn), t.azimuth_rad)


def _is_sideways(t: ThrusterConfig) -> bool:
    return abs(math.sin(t.azimuth_rad)) > _SIDEWAYS


def _command(t: ThrusterConfig, throttle: float, azimuth_rad: float) -> ThrusterCommand:
    throttle = min(1.0, max(0.0 if t.kind == "jet" else -1.0, throttle))
    gain = t.ahead_n if throttle >= 0.0 else t.astern_n
    force = min(t.max_n, max(t.min_n, gain * throttle * abs(throttle)))
    return ThrusterCommand(force, throttle, azimuth_rad if t.turns else None)


def _beyond(stick: float, dead: float) -> float:
    """The stick outside its dead band, stretched to −1…1 again."""
    if not math.isfinite(stick) or abs(stick) <= dead:
        return 0.0
    return math.copysign(min(1.0, (abs(stick) - dead) / (1.0 - dead)), stick)
