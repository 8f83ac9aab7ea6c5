"""Model feed-forward for dynamic positioning: the companion's, and the two of the ReVolt thesis (4.13, 4.14, 8.13,
8.14)."""

from __future__ import annotations

from companion.config.hull import HullConfig, ThesisModelConfig
from companion.config.vessel import VesselConfig
from companion.control.model import damping, force_for
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.frames import ned_to_body
from companion.core.setpoint import PoseSetpoint

OFF, PRINTED, SCALED, FULL = range(4)  # values of DP_FF_KIND
SEA_SCALE = (1.0, 0.05, 0.2)  # by which the thesis scaled its feed-forward at sea, in surge, sway and yaw


def feedforward(kind: int, config: VesselConfig, setpoint: PoseSetpoint, turn_rad: float) -> Wrench:
    """The wrench that moves the boat as the reference moves, in the boat's body axes. `kind`: DP_FF_KIND; `turn_rad`:
    the boat's heading minus the reference's."""
    if kind == FULL:
        u, v = ned_to_body(setpoint.surge_mps, setpoint.sway_mps, turn_rad)
        ax, ay = ned_to_body(setpoint.surge_mps2, setpoint.sway_mps2, turn_rad)
        return force_for(config.hull, u, v, setpoint.yaw_rate_radps, ax, ay, setpoint.yaw_radps2)
    if kind == OFF or config.thesis_model is None:
        return ZERO_WRENCH
    printed = as_printed(config.hull, config.thesis_model, setpoint)
    if kind == PRINTED:
        return printed
    x, y, n = SEA_SCALE
    return Wrench(x * printed.surge_n, y * printed.sway_n, n * printed.yaw_nm)


def as_printed(hull: HullConfig, model: ThesisModelConfig, setpoint: PoseSetpoint) -> Wrench:
    """M ν̇ + C ν + D ν with the errata of the thesis: the added mass enters C with the wrong sign (8.13), and ν̇ = Rᵀη̈
    + S(r)Rᵀη̇ (4.14)."""
    u, v, r = setpoint.surge_mps, setpoint.sway_mps, setpoint.yaw_rate_radps
    ax, ay = setpoint.surge_mps2 - 2.0 * r * v, setpoint.sway_mps2 + 2.0 * r * u
    lateral = (2.0 * model.mass_kg - hull.m22_kg) * v - hull.m23_kgm * r
    axial = (2.0 * model.mass_kg - hull.m11_kg) * u
    dx, dy, dn = damping(HullConfig(hull.m11_kg, hull.m22_kg, hull.m33_kgm2, damping=model.damping), u, v, r)
    return Wrench(
        hull.m11_kg * ax - lateral * r + dx,
        hull.m22_kg * ay + hull.m23_kgm * setpoint.yaw_radps2 + axial * r + dy,
        hull.yaw_coupling_kgm * ay + hull.m33_kgm2 * setpoint.yaw_radps2 + lateral * u - axial * v + dn,
    )
