"""Whether the energy that is left still takes the boat home."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from companion.config.vessel import VesselConfig
from companion.control.wind import wind_force
from companion.core.decision import Home
from companion.core.estimate import NavState
from companion.core.geodesy import rough_distance_and_bearing
from companion.core.readings import Battery
from companion.mission.outlook import full_battery_s
from companion.params.store import Parameters
from companion.supervisor.outlook_duty import BatteryUse

_PERIOD_S = 2.0
_UNDER_WAY_SHARE = 0.5  # of the cruising speed, from which on consumption counts
_NEAR_S = 30.0  # of sailing: nearer than that the boat is at home
_CHARGED = 0.1  # share of the battery by which it has risen: it was charged or changed
_LEAST_MPS = 0.05
_MOST_FACTOR = 5.0


class RangeWatch:
    """`update(nav, battery, home, self_steered, now_s)` once a tick; then `need`: the share of the battery that has to
    be left to get home with BAT_CRIT_THR, or None where it is not known; and `short`: whether less is left.

    The way is the straight line to home at cruising speed over ground, times BAT_RET_MARG. Its energy is the time as a
    share of the battery's endurance (BAT_ENDURANCE, or as measured under way), times the power that current and wind
    ask for on that course, against calm: resistance at the speed through the water plus the wind's force, times that
    speed. What is short stays so until the boat is at home or the battery has risen, because the need falls on the way;
    or until an operator changes what it is computed from. A position or a charge that is lost does not end it.
    Remembers the consumption so far, what it was computed from, and the share that was left when it became short.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, speed_mps: Callable[[], float]) -> None:
        """`speed_mps()`: the cruising speed."""
        self._config, self._parameters, self._speed_mps = config, parameters, speed_mps
        self._use = BatteryUse()
        self._due_s = -math.inf
        self._onset = 1.0
        self._by: tuple[object, ...] = ()
        self.need: float | None = None
        self.short = False

    def update(
        self, nav: NavState, battery: Battery | None, home: Home | None, self_steered: bool, now_s: float
    ) -> None:
        """Count what is used, and every 2 s compute again. `self_steered`: armed, and no sticks steer."""
        speed_mps = self._speed_mps()
        fast = math.hypot(nav.north_mps, nav.east_mps) >= _UNDER_WAY_SHARE * speed_mps
        self._use.update(battery, self_steered and fast, now_s)
        if now_s < self._due_s:
            return
        self._due_s = now_s + _PERIOD_S
        remaining = None if battery is None else battery.remaining
        full_s = full_battery_s(self._parameters["BAT_ENDURANCE"], self._use.full_s)
        if home is None or remaining is None or full_s is None or not nav.position_valid:
            self.short = self.short and home is not None and full_s is not None
            self.need = self.need if self.short else None
            return
        distance_m, bearing_rad = rough_distance_and_bearing(nav.lat_deg, nav.lon_deg, home.lat_deg, home.lon_deg)
        time_s = distance_m / max(_LEAST_MPS, speed_mps)
        share = self._parameters["BAT_RET_MARG"] * self._factor(nav, bearing_rad, speed_mps) * time_s / full_s
        self.need = share + self._parameters["BAT_CRIT_THR"]
        by = (home, speed_mps, *(self._parameters[name] for name in ("BAT_ENDURANCE", "BAT_RET_MARG", "BAT_CRIT_THR")))
        if not self.short or by != self._by:
            self.short, self._onset, self._by = remaining < self.need, remaining, by
        self.short = self.short and time_s > _NEAR_S and remaining < self._onset + _CHARGED

    def _factor(self, nav: NavState, bearing_rad: float, speed_mps: float) -> float:
        """Power on the way home against power in calm; at least 1: a favourable stream may turn."""
        hull = self._config.hull
        calm_w = hull.drag_n(speed_mps) * speed_mps
        if calm_w <= 0.0:
            return 1.0
        north_mps = speed_mps * math.cos(bearing_rad) - (nav.current_north_mps or 0.0)
        east_mps = speed_mps * math.sin(bearing_rad) - (nav.current_east_mps or 0.0)
        water_mps = math.hypot(north_mps, east_mps)
        homeward = _on_course(nav, bearing_rad, speed_mps)
        wind_n = -wind_force(self._config.windage, self._config.length_m, homeward)[0]
        power_w = max(0.0, hull.drag_n(water_mps) + wind_n) * water_mps
        return min(_MOST_FACTOR, max(1.0, power_w / calm_w))


def _on_course(nav: NavState, bearing_rad: float, speed_mps: float) -> NavState:
    """The boat as it would be under way home."""
    return replace(nav, yaw_rad=bearing_rad, surge_mps=speed_mps, sway_mps=0.0)
