"""The boat that a scenario sails: what it must be able to do, and with what it was sailed."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.config.dimensions.limits import support_n
from companion.config.hull import AIR_KGPM3, HullConfig
from companion.config.reversing import stern_first_refusal, turns_on_the_spot
from companion.config.rough_water import ROUGH, USUAL
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from sitl.emulators import is_receiver
from sitl.leader_script import script
from sitl.magnetometer import MAGNETIC_DRIVER
from sitl.rough_water import is_rough, plant_name
from sitl.scenarios.rig import Conditions

Ability = Callable[[VesselConfig], str | None]
"""Why a boat cannot do a scenario, in one sentence; None where it can."""

_HALVINGS = 20
_COMPASS_DEG = 1.0
_REST_MPS, _STEP_MPS = 0.3, 0.05
_REACTION_S = 2.0  # to hear of the line, to decide, and to reverse the thrust
_FAST_SHARE = 0.8  # of the top speed: also in wind and current, such a boat is fast


def sideways(config: VesselConfig) -> str | None:
    """It must hold a heading at a point, or move sideways."""
    if config.limits.sway_n > 0.0:
        return None
    return "it needs sideways thrust, and this boat has none (limits.sway_n = 0); bow_hold measures its Hold"


def comes_back(config: VesselConfig) -> bool:
    """Whether it holds by coming back to its point: under sail, and without way astern."""
    return config.has_sail or not any(thruster.pushes_astern for thruster in config.thrusters)


def holds_by_drifting(config: VesselConfig) -> bool:
    """Whether it holds inside its watch circle and is never at rest: a rudder steers by its way alone, too."""
    return comes_back(config) or config.has_rudder


def fast_mps(config: VesselConfig, asked_mps: float) -> float:
    """The least speed at which the boat counts as fast: as asked, or a share of the top speed of a slower one."""
    return min(asked_mps, _FAST_SHARE * top_speed_mps(config))


def stopping_room_m(config: VesselConfig, speed_mps: float) -> float:
    """What the boat needs ahead of its middle to stop its bow short of a line: by all its thrust astern and the drag of
    its hull, or by a turn where it has no way astern. Less is more than such a boat can do."""
    begins_m = 0.5 * config.length_m + _REACTION_S * speed_mps
    if not comes_back(config):
        return begins_m + way_to_rest_m(config.hull, speed_mps, all_astern_n(config))
    return begins_m + min(way_to_rest_m(config.hull, speed_mps, 0.0), _turning_m(config, speed_mps))


def all_astern_n(config: VesselConfig) -> float:
    """All its thrust astern; 0 or less where it has none."""
    return min(config.limits.surge_n, sum(support_n(thruster, -1.0, 0.0, 0.0) for thruster in config.thrusters))


def way_to_rest_m(hull: HullConfig, speed_mps: float, astern_n: float) -> float:
    """The way of the hull from that speed to rest, with a thrust astern: ∫ m u / (D(u) + T) du."""
    steps = max(1, math.ceil((speed_mps - _REST_MPS) / _STEP_MPS))
    speeds = [_REST_MPS + (i + 0.5) * _STEP_MPS for i in range(steps)]
    return sum(_STEP_MPS * hull.m11_kg * u / max(1e-3, hull.drag_n(u) + astern_n) for u in speeds)


def _turning_m(config: VesselConfig, speed_mps: float) -> float:
    """Radius of the steady turn by all the yaw moment at that speed."""
    d, moment_nm = config.hull.damping, config.limits.yaw_nm
    linear = d.n_r + d.n_ur * speed_mps
    rate_radps = 2.0 * moment_nm / (linear + math.sqrt(linear**2 + 4.0 * d.n_rr * moment_nm))
    return speed_mps / max(1e-3, rate_radps)


def leeway_mps(config: VesselConfig, wind_ahead_mps: float) -> float:
    """Speed through the water at which wind from astern drives the hull ahead, by the drag and the windage of the file;
    0 in wind from ahead. `wind_ahead_mps`: its part along the hull, positive ahead."""
    low, high = 0.0, max(0.0, wind_ahead_mps)
    pull = 0.5 * AIR_KGPM3 * config.windage.cx * config.windage.frontal_m2
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        pushed = config.hull.drag_n(middle) < pull * (wind_ahead_mps - middle) ** 2
        low, high = (middle, high) if pushed else (low, middle)
    return 0.5 * (low + high)


def drifting(config: VesselConfig) -> str | None:
    """It must hold by coming back to its point."""
    if comes_back(config):
        return None
    other = "hold" if config.limits.sway_n > 0.0 else "bow_hold"
    return f"it is about boats that drift in Hold and sail back, and this one stays at its point; try {other}"


def astern(config: VesselConfig) -> str | None:
    """It must be able to sail stern first."""
    refusal = stern_first_refusal(config.thrusters)
    return None if refusal is None else f"it needs way astern that can be steered, and {refusal}; try mission_square"


def motor(config: VesselConfig) -> str | None:
    """It must be able to go in every direction, at the speed asked for."""
    if not config.has_sail:
        return None
    return "it asks for tracks and speeds that no sail gives against the wind, and this boat sails; try sail_triangle"


def turning(config: VesselConfig) -> str | None:
    """It must be able to turn on the spot."""
    if turns_on_the_spot(config.thrusters):
        return None
    return "it needs a turn on the spot, and this boat turns by its way alone; gnss_dropout measures its estimate"


def berth(config: VesselConfig) -> str | None:
    """It must have a berth of its own."""
    if config.dock is not None:
        return None
    return "it needs a berth, and this boat has none; add a [dock] table to its file"


def magnetometer(config: VesselConfig) -> str | None:
    """It must have a magnetometer."""
    if any(row.driver == MAGNETIC_DRIVER for row in config.sensors):
        return None
    return f"it needs a magnetometer, and this boat has no sensor of driver {MAGNETIC_DRIVER}; add one to its file"


def other_hull(config: VesselConfig, name: str) -> str | None:
    """Why its controller cannot begin with the hull of the plant of that name; None where it can."""
    plants = {} if config.sitl is None else config.sitl.plants
    if not name or name in plants:
        return None
    known = f"try --set hull={next(iter(plants))}" if plants else "add one, [sitl.plant.NAME], to its file"
    return f"its controller begins with the hull of a plant '{name}', and this boat has none of that name; {known}"


def outrun(config: VesselConfig, leader: str) -> str | None:
    """Why it cannot keep up with the script of that name and speed. Raises ConfigError for an unknown script."""
    speed_mps, top_mps = max(order.speed_mps for order in script(leader)), top_speed_mps(config)
    if speed_mps <= top_mps:
        return None
    slower = f"{leader.partition('@')[0]}@{math.floor(6.0 * top_mps) / 10.0:g}"
    return f"its leader sails {speed_mps:g} m/s, and this boat {top_mps:.1f} at most; try --set leader={slower}"


def sailed_with(config: VesselConfig, conditions: Conditions) -> str:
    """Receiver, compass, plant, water and limits of a run, for its report."""
    plant = water = ""
    if config.sitl is not None:
        rough = is_rough(conditions.water, config.sitl)
        plant, water = plant_name(config.sitl, conditions.plant, rough), ROUGH if rough else USUAL
    limits = config.limits
    wrench = f"{limits.surge_n:g} N ahead, {limits.sway_n:g} N sideways, {limits.yaw_nm:g} Nm"
    senses = f"receiver {conditions.gnss}, compass {_compass(config, conditions)}"
    return f"{config.name}: {senses}, plant {plant}, {water} water, limits {wrench}"


def heading_error_deg(config: VesselConfig, conditions: Conditions) -> float:
    """How far a boat may be off its heading by the slow error of its compass alone, which no law can know; 0 with two
    antennas."""
    return 0.0 if _compass(config, conditions) == "two antennas" else _COMPASS_DEG


def _compass(config: VesselConfig, conditions: Conditions) -> str:
    """Where the heading comes from."""
    if conditions.magnetometer:
        return f"magnetometer, {conditions.magnetometer}"
    if any(is_receiver(row) and row.antennas == 2 for row in config.sensors):
        return "two antennas"
    return next((row.heading for row in config.sensors if row.heading != "none"), "none")
