"""ÅBOAT under way with another load than its controllers were tuned for: a heading step of 60° and a speed step, on the
simulator's hull."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from companion.allocation.allocator import Allocator
from companion.baselines.controller_choice import controller_with_baselines
from companion.config.hull import HullConfig
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ZERO_WRENCH
from companion.core.angles import wrap_pi
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters
from sitl import thrusters
from sitl.hull import Hull
from tests.unit.control.simple_boat import nav_state

ABOAT = load(find("aboat"))
AFLOAT_KG = 160.0  # for which the vessel's file is
HULL_KG = 34.0
_STEPS = 10
_DT_S = 0.1


@dataclass(frozen=True, slots=True)
class Response:
    """To the step of heading: integral of the error in degree seconds, overshoot in degrees, standard deviation over
    the last 20 s; to the step of speed: integral of the error in metres, and overshoot in m/s."""

    heading_iae: float
    overshoot_deg: float
    restless_deg: float
    speed_iae: float
    overshoot_mps: float


def loaded(load_kg: float, config: VesselConfig) -> HullConfig:
    """The true hull with that load: inertia goes with mass, damping stays."""
    share = (HULL_KG + load_kg) / AFLOAT_KG
    hull = config.hull
    return replace(hull, m11_kg=share * hull.m11_kg, m22_kg=share * hull.m22_kg, m33_kgm2=share * hull.m33_kgm2)


def respond(load_kg: float, config: VesselConfig = ABOAT, **values: float) -> Response:
    """0.8 m/s straight on for 30 s, 1.2 m/s from then on, and at 70 s 60° to starboard, with the state perfectly
    known."""
    parameters = Parameters({**config.parameters, **values})
    controller, allocator = controller_with_baselines(config, parameters), Allocator(config, parameters)
    hull = Hull(loaded(load_kg, config))
    motors = thrusters.build(config.thrusters, 0.4, None)
    achieved = ZERO_WRENCH
    headings: list[float] = []
    speeds: list[float] = []
    for k in range(1300):
        t = k * _DT_S
        wanted, speed = (math.radians(60.0) if t >= 70.0 else 0.0), (1.2 if t >= 30.0 else 0.8)
        nav = nav_state(hull.north_m, hull.east_m, hull.yaw_rad, hull.surge_mps, hull.sway_mps, hull.yaw_rate_radps, t)
        setpoint = PathSetpoint(yaw_rad=wanted, surge_mps=speed)
        wrench = controller.update(setpoint, nav, achieved, _DT_S)
        allocation = allocator.update(wrench, _DT_S)
        achieved = allocation.achieved
        for motor, command in zip(motors, allocation.thrusters, strict=True):
            motor.demand(command.throttle, command.azimuth_rad)
        for _ in range(_STEPS):
            x = y = n = 0.0
            for motor in motors:
                motor.step(_DT_S / _STEPS)
                a, b, c = motor.wrench()
                x, y, n = x + a, y + b, n + c
            hull.step(x, y, n, _DT_S / _STEPS)
        headings.append(math.degrees(wrap_pi(hull.yaw_rad - wanted)))
        speeds.append(hull.surge_mps - speed)
    turn, end, faster = headings[700:], headings[-200:], speeds[300:700]
    mean = sum(end) / len(end)
    return Response(
        heading_iae=sum(map(abs, turn)) * _DT_S,
        overshoot_deg=max(0.0, *turn),
        restless_deg=math.sqrt(sum((h - mean) ** 2 for h in end) / len(end)),
        speed_iae=sum(map(abs, faster)) * _DT_S,
        overshoot_mps=max(0.0, *faster),
    )
