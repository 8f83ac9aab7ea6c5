"""A boat for closed loops: three degrees of freedom, thrusters with lag and turning rate, a constant current and a
constant force."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ActuatorCommand, Deployment, ThrusterFeedback
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned, ned_to_body
from tests.unit.estimates import AT_REST

REVOLT = load(find("revolt"))
BOW_DOWN = (None, None, ThrusterFeedback(0.0, "board", 2, 0.0, None, True, Deployment.LOWERED))
STEPS = 5
LAG_S = 0.3


def nav_state(
    north_m: float = 0.0,
    east_m: float = 0.0,
    yaw_rad: float = 0.0,
    surge_mps: float = 0.0,
    sway_mps: float = 0.0,
    yaw_rate_radps: float = 0.0,
    t_s: float = 0.0,
    wind: tuple[float, float] | None = None,
    current: tuple[float, float] | None = None,
) -> NavState:
    """A perfectly known state; `wind` is (speed, direction it comes from)."""
    north_mps, east_mps = body_to_ned(surge_mps, sway_mps, yaw_rad)
    return replace(
        AT_REST,
        t_s=t_s,
        lat_deg=0.0,
        lon_deg=0.0,
        north_m=north_m,
        east_m=east_m,
        yaw_rad=yaw_rad,
        surge_mps=surge_mps,
        sway_mps=sway_mps,
        north_mps=north_mps,
        east_mps=east_mps,
        yaw_rate_radps=yaw_rate_radps,
        satellites=12,
        hdop=0.8,
        wind_speed_mps=None if wind is None else wind[0],
        wind_from_rad=None if wind is None else wind[1],
        current_north_mps=None if current is None else current[0],
        current_east_mps=None if current is None else current[1],
    )


class SimpleBoat:
    """The controller's own hull, heavier or lighter by `factor`, its stern and bow thrusters where the tape measure put
    them."""

    def __init__(
        self,
        config: VesselConfig = REVOLT,
        factor: float = 1.0,
        force_ned: tuple[float, float] = (0.0, 0.0),
        moment_nm: float = 0.0,
        current: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.config, self.factor = config, factor
        self.force_ned, self.moment_nm, self.current = force_ned, moment_nm, current
        self.north_m = self.east_m = self.yaw_rad = 0.0
        self.surge_mps = self.sway_mps = self.yaw_rate_radps = 0.0
        self.t_s = 0.0
        self.forces_n = [0.0] * len(config.thrusters)
        self.azimuths_rad = [t.azimuth_rad for t in config.thrusters]
        self.x_m = [math.copysign(1.12, t.x_m) for t in config.thrusters]

    def nav(self) -> NavState:
        return nav_state(
            self.north_m, self.east_m, self.yaw_rad, self.surge_mps, self.sway_mps, self.yaw_rate_radps, self.t_s
        )

    def sail(self, command: ActuatorCommand, dt_s: float) -> None:
        """Advance under `command`."""
        for _ in range(STEPS):
            self._step(self._thrust(command, dt_s / STEPS), dt_s / STEPS)
        self.t_s += dt_s

    def _thrust(self, command: ActuatorCommand, h: float) -> tuple[float, float, float]:
        x = y = n = 0.0
        for i, (thruster, demand) in enumerate(zip(self.config.thrusters, command.thrusters, strict=True)):
            gain = thruster.ahead_n if demand.throttle >= 0.0 else thruster.astern_n
            self.forces_n[i] += (gain * demand.throttle * abs(demand.throttle) - self.forces_n[i]) * (
                1.0 - math.exp(-h / LAG_S)
            )
            if demand.azimuth_rad is not None:
                turn = wrap_pi(demand.azimuth_rad - self.azimuths_rad[i])
                reach = thruster.azimuth_rate_radps * h
                self.azimuths_rad[i] += max(-reach, min(reach, turn))
            c, s = math.cos(self.azimuths_rad[i]), math.sin(self.azimuths_rad[i])
            x += c * self.forces_n[i]
            y += s * self.forces_n[i]
            n += (self.x_m[i] * s - thruster.y_m * c) * self.forces_n[i]
        return x, y, n

    def _step(self, thrust: tuple[float, float, float], h: float) -> None:
        hull, k = self.config.hull, self.factor
        push_x, push_y = ned_to_body(*self.force_ned, self.yaw_rad)
        stream_x, stream_y = ned_to_body(*self.current, self.yaw_rad)
        u, v, r = self.surge_mps - stream_x, self.sway_mps - stream_y, self.yaw_rate_radps
        m11, m22, m33 = k * hull.m11_kg, k * hull.m22_kg, k * hull.m33_kgm2
        d = hull.damping
        x = thrust[0] + push_x - k * d.x_u * u + m22 * v * r
        y = thrust[1] + push_y - k * (d.y_v + d.y_vv * abs(v)) * v - m11 * u * r
        n = thrust[2] + self.moment_nm - k * (d.n_r + d.n_rr * abs(r)) * r - (m22 - m11) * u * v
        self.surge_mps += h * (x / m11 + r * stream_y)  # a constant current turns in body axes as the boat turns
        self.sway_mps += h * (y / m22 - r * stream_x)
        self.yaw_rate_radps += h * n / m33
        north_mps, east_mps = body_to_ned(self.surge_mps, self.sway_mps, self.yaw_rad)
        self.north_m += h * north_mps
        self.east_m += h * east_mps
        self.yaw_rad = wrap_pi(self.yaw_rad + h * self.yaw_rate_radps)
