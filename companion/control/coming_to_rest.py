"""What remains of the bias when a boat comes to rest. Under way it learnt the model's error of the hull's drag, too,
which ends with the way: kept whole, it would drive the boat on past its point."""

from __future__ import annotations

import math

from companion.config.hull import HullConfig
from companion.config.vessel import VesselConfig
from companion.control.bias import BiasForce
from companion.control.model import damping
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned

_DRAG_SHARE = 0.25  # one sigma of the model's error of the drag
_CURRENT_MPS, _KNOWN_CURRENT_MPS = 0.2, 0.05  # one sigma of a current that nobody knows, and of one that is estimated
_WIND_MPS, _MEASURED_WIND_MPS = 4.0, 2.0  # the same of the wind, as one of that speed at rest
_LEARNT_S = 8.0  # the bias follows more slowly than the boat slows down
_LEAST_MPS = 0.05


class ComingToRest:
    """`sail` every cycle under way, then `rest` as the boat is to brake or positioning begins, or `forget`. Remembers
    the velocity over ground of the last seconds, at which the bias was learnt."""

    def __init__(self, config: VesselConfig) -> None:
        self._config = config
        self.forget()

    def forget(self) -> None:
        """Nothing was learnt under way."""
        self._way_mps: tuple[float, float] | None = None  # surge, sway

    def sail(self, nav: NavState, dt_s: float) -> None:
        """Take a cycle under way."""
        if self._way_mps is None:
            self._way_mps = nav.surge_mps, nav.sway_mps
            return
        part = dt_s / (dt_s + _LEARNT_S)
        u, v = self._way_mps
        self._way_mps = u + part * (nav.surge_mps - u), v + part * (nav.sway_mps - v)

    def rest(self, bias: BiasForce, nav: NavState) -> None:
        """Take from `bias`, once, the share of its force along the boat's way that ends with the way."""
        if self._way_mps is None:
            return
        u, v = self._way_mps
        self.forget()
        speed_mps = math.hypot(u, v)
        if speed_mps < _LEAST_MPS:
            return
        x, y = u / speed_mps, v / speed_mps
        bias_x, bias_y, _ = bias.in_body(nav.yaw_rad)
        north, east = body_to_ned(x, y, nav.yaw_rad)
        kept = kept_share(self._config, nav, speed_mps, x, y)
        bias.take(kept * (bias_x * x + bias_y * y), north, east, nav.yaw_rad)


def kept_share(config: VesselConfig, nav: NavState, speed_mps: float, x: float, y: float) -> float:
    """The expected share, 0 to 1, of a force along the way at `speed_mps` that stays at rest. `x`, `y`: the way, a unit
    vector in body axes.

    Errors of drag, current and wind are independent; the share is the regression of their sum at rest on that under
    way.
    """
    hull = config.hull
    current_mps = _CURRENT_MPS if nav.current_north_mps is None else _KNOWN_CURRENT_MPS
    wind_mps = _WIND_MPS if nav.wind_speed_mps is None else _MEASURED_WIND_MPS
    drag_n = _drag_n(hull, speed_mps, x, y)
    flow_n = _drag_n(hull, speed_mps + current_mps, x, y) - drag_n
    rest_n = _drag_n(hull, current_mps, x, y)
    blown = config.windage.force(-wind_mps * x, -wind_mps * y, config.length_m)
    wind_n = blown[0] * x + blown[1] * y
    total = (_DRAG_SHARE * drag_n) ** 2 + flow_n * flow_n + wind_n * wind_n
    return min(1.0, (flow_n * rest_n + wind_n * wind_n) / total) if total > 0.0 else 1.0


def _drag_n(hull: HullConfig, speed_mps: float, x: float, y: float) -> float:
    surge_n, sway_n, _ = damping(hull, speed_mps * x, speed_mps * y, 0.0)
    return surge_n * x + sway_n * y
