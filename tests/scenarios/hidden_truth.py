"""What a hidden hull truly has of the quantities that an identification finds, for coverage and error of the result."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.analysis.hull_model import ANTENNA, COUPLING, CURRENT, HEADING, INERTIA, LIFT, RACE, HullModel
from companion.analysis.log_reader import read_table
from companion.config.devices import ThrusterConfig
from companion.config.vessel import AS_MODELLED, VesselConfig
from sitl.hidden_hull import HiddenHull
from sitl.hull_flow import strips
from sitl.wave_hull import wave_hull

Array = NDArray[np.float64]
_TRUTH = (
    "t_s",
    "yaw_rad",
    "surge_mps",
    "sway_mps",
    "yaw_rate_radps",
    "current_north_mps",
    "current_east_mps",
)
_SWAY = ("y_v", "y_vv", "y_r", "y_rr", "y_rv", "y_uv")
_YAW = ("n_v", "n_vv", "n_r", "n_rr", "n_vr", "n_uv", "n_ur")


def truth_of(boat: HiddenHull, model: HullModel) -> dict[str, float]:
    """By the names of `HullModel.model`; what has no true value, such as the weather's forces, is missing."""
    real, hull = boat.real, boat.real.hull
    assert real.sitl is not None
    log = read_truth(model)
    found = {name: float(getattr(hull, name)) for name in (*INERTIA, COUPLING)} | asdict(hull.damping)
    for group in model.groups:
        found[f"x_m {group.name}"] = arm_m(real.thrusters[group.members[0]])
        found[f"scale {group.name}"] = strength(boat, group.members)
    for thruster in real.thrusters:
        if thruster.rudder is not None:
            found |= {LIFT: thruster.rudder.lift_scale, RACE: thruster.rudder.race_gain}
    found["lag_s"] = real.sitl.plants[real.sitl.plant].thruster_lag_s
    found |= {name: float(np.mean(log[name])) for name in CURRENT}
    wrong = model.manoeuvre.yaw_rad - np.interp(model.manoeuvre.t_s, log["t_s"], np.unwrap(log["yaw_rad"]))
    found[HEADING] = float(np.angle(np.exp(1j * wrong).mean()))
    off = np.subtract(antenna_m(real), antenna_m(boat.known))
    found |= dict(zip(ANTENNA, off.tolist(), strict=True))
    for name, value in by_strips(boat, model, log).items():
        found[name] += value
    return {name: value for name, value in found.items() if name in model.model}


def read_truth(model: HullModel) -> dict[str, Array]:
    """Columns of the trial's truth.csv."""
    return {name: np.array(column) for name, column in read_table(model.log.folder / "truth.csv", _TRUTH, []).items()}


def by_strips(boat: HiddenHull, model: HullModel, log: dict[str, Array]) -> dict[str, float]:
    """The terms that come nearest to a hull's cross-flow drag by strips, over the true motion of the log; empty for a
    hull without."""
    assert boat.real.sitl is not None
    plant = boat.real.sitl.plants[AS_MODELLED]
    if plant.cross_flow is None:
        return {}
    flow = strips(plant.cross_flow, wave_hull(plant.hull, boat.real))
    u, v, r = model.band.sampled(through_water(model, log)).T
    force = np.array([flow(*one) for one in zip(u.tolist(), v.tolist(), r.tolist(), strict=True)])
    parts = {"v": v, "vv": v * abs(v), "r": r, "rr": r * abs(r), "rv": abs(r) * v, "vr": abs(v) * r}
    parts |= {"uv": abs(u) * v, "ur": abs(u) * r}
    found: dict[str, float] = {}
    for axis, names in ((0, _SWAY), (1, _YAW)):
        columns = np.stack([parts[name.split("_")[1]] for name in names], axis=1)
        solution, *_ = np.linalg.lstsq(columns, -force[:, axis], rcond=None)
        found |= dict(zip(names, solution.tolist(), strict=True))
    return found


def through_water(model: HullModel, log: dict[str, Array]) -> Array:
    """(n, 3): true velocities through the water at the ticks of the model's manoeuvre."""

    def at(name: str) -> Any:
        return np.interp(model.manoeuvre.t_s, log["t_s"], log[name])

    yaw = np.interp(model.manoeuvre.t_s, log["t_s"], np.unwrap(log["yaw_rad"]))
    c, s, north, east = np.cos(yaw), np.sin(yaw), at(CURRENT[0]), at(CURRENT[1])
    surge, sway = at("surge_mps") - north * c - east * s, at("sway_mps") - east * c + north * s
    return np.stack([surge, sway, at("yaw_rate_radps")], axis=1)


def antenna_m(config: VesselConfig) -> tuple[float, float]:
    """Place of the receiver's antenna, ahead and to starboard."""
    sensor = next(one for one in config.sensors if one.name == "gnss")
    return sensor.x_m, sensor.y_m


def arm_m(thruster: ThrusterConfig) -> float:
    """Where the thruster pushes sideways: at its rudder, if it has one."""
    return thruster.x_m if thruster.rudder is None else thruster.rudder.x_m


def strength(boat: HiddenHull, members: Sequence[int]) -> float:
    """Thrust in truth over that in the file."""
    return math.fsum(boat.real.thrusters[i].ahead_n / boat.known.thrusters[i].ahead_n for i in members) / len(members)
