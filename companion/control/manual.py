"""Sticks → wrench, and sticks → thrusters. Each stick is −1…1: surge ahead, sway to starboard, yaw clockwise."""

from __future__ import annotations

import math

from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import ThrusterCommand, Wrench
from companion.params.store import Parameters

_SIDEWAYS = 0.7  # share of its push across the hull from which a fixed thruster counts as a side thruster
# The same between which one counts as diagonal, on a boat that pushes sideways: 22.5° to 67.5° off bow or stern.
_DIAGONAL = (0.38, 0.93)
_LEAST_LEVER_M = 0.01  # a diagonal thruster whose push passes the middle of the boat by less does not turn it


def stick_to_wrench(surge: float, sway: float, yaw: float, config: VesselConfig, parameters: Parameters) -> Wrench:
    """The wrench that the sticks demand: full stick is the vessel's limit on that axis. Non-finite sticks count as
    centred."""
    dead = parameters["MAN_DEADBAND"]
    limits = config.limits
    return Wrench(
        beyond_deadband(surge, dead) * limits.surge_n,
        beyond_deadband(sway, dead) * limits.sway_n,
        beyond_deadband(yaw, dead) * limits.yaw_nm,
    )


def stick_to_thrusters(
    surge: float, sway: float, yaw: float, config: VesselConfig, parameters: Parameters
) -> tuple[ThrusterCommand, ...]:
    """A demand for each thruster, by direct mapping as on ReVolt.

    Surge is the throttle of thrusters that push ahead, sway that of side thrusters, and yaw turns azimuths by up to
    `manual_azimuth_rad`. On a boat without such azimuths, yaw is differential throttle, or else throttle of the side
    thrusters. Diagonal thrusters, as of a vectored layout, follow all three sticks. The sticks keep their sense astern:
    azimuths then turn the other way. A jet cannot push astern: its nozzle keeps its sense, and its throttle ends at 0.
    A rudder keeps its sense, too, as at a wheel. The throttle of a sail is its sheet."""
    dead = parameters["MAN_DEADBAND"]
    surge, sway, yaw = beyond_deadband(surge, dead), beyond_deadband(sway, dead), beyond_deadband(yaw, dead)
    steered = any(t.turns and t.manual_azimuth_rad > 0.0 for t in config.thrusters)
    vectored = config.limits.sway_n > 0.0 and any(_is_diagonal(t) for t in config.thrusters)
    differential = not steered and any(
        t.kind == "fixed" and not _is_sideways(t) and t.y_m != 0.0 for t in config.thrusters
    )
    return tuple(
        _diagonal(t, surge, sway, 0.0 if steered else yaw)
        if vectored and _is_diagonal(t)
        else _one(t, surge, sway, yaw, steered, vectored or differential)
        for t in config.thrusters
    )


def _diagonal(t: ThrusterConfig, surge: float, sway: float, yaw: float) -> ThrusterCommand:
    """Every stick pushes the way in which this thruster serves it."""
    ahead, side = math.cos(t.azimuth_rad), math.sin(t.azimuth_rad)
    lever_m = t.x_m * side - t.y_m * ahead
    throttle = math.copysign(1.0, ahead) * surge + math.copysign(1.0, side) * sway
    if abs(lever_m) > _LEAST_LEVER_M:
        throttle += math.copysign(1.0, lever_m) * yaw
    return _command(t, throttle, t.azimuth_rad)


def _one(
    t: ThrusterConfig, surge: float, sway: float, yaw: float, steered: bool, differential: bool
) -> ThrusterCommand:
    if t.turns and t.manual_azimuth_rad > 0.0:
        # a thruster at the stern turns the boat by pushing the stern the other way
        lever = math.copysign(1.0, t.x_m) * (-1.0 if surge < 0.0 and t.kind == "azimuth" else 1.0)
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


def _is_diagonal(t: ThrusterConfig) -> bool:
    least, most = _DIAGONAL
    return t.kind == "fixed" and least < abs(math.sin(t.azimuth_rad)) < most


def _command(t: ThrusterConfig, throttle: float, azimuth_rad: float) -> ThrusterCommand:
    throttle = min(1.0, max(0.0 if t.kind in ("jet", "sail") else -1.0, throttle))
    gain = t.ahead_n if throttle >= 0.0 else t.astern_n
    force = min(t.max_n, max(t.min_n, gain * throttle * abs(throttle)))
    return ThrusterCommand(force, throttle, azimuth_rad if t.turns else None)


def beyond_deadband(stick: float | None, deadband: float) -> float:
    """The stick as −1…1, with 0 for the share `deadband` around the centre and the rest stretched. A missing axis or a
    value that is not finite gives 0."""
    if stick is None or not math.isfinite(stick) or abs(stick) <= deadband:
        return 0.0
    return math.copysign(min(1.0, (abs(stick) - deadband) / (1.0 - deadband)), stick)
