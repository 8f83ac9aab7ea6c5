"""Thrust allocation of propellers with rudders beside other thrusters: two screws with a rudder each, or one with
thrusters across bow or stern.

To the constrained allocation propellers count as fixed, and all blades together as one more thruster across the stern:
the blades push sideways with up to what the flow over them gives (`RudderCurve`), which changes with speed and thrust.
So the programme decides what blades, differential thrust and side thrusters do. The flow that counts rises slowly, and
in a lull a blade stays as it is for the usual one: thrust that comes and goes, as in station keeping, carries no
rudder. On a boat that pushes itself sideways the race does not count at all: there each screw pushes to and fro.
Where a boat without sideways thrust has long had too little moment, thrust ahead for the blades is added, up to
RUD_STEER of the largest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from companion.allocation.allocator import Allocator
from companion.allocation.geometry import Thruster
from companion.allocation.rudder_curve import RudderCurve
from companion.allocation.shortfall import limited_axes
from companion.config.blades import without_blades
from companion.config.devices import ThrusterConfig
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.estimate import NavState, Rig
from companion.params.store import Parameters

_FLOW_S = 1.0  # in which the flow that counts rises, and the usual one follows
_SHORT_SHARE = 0.1  # of the limit: moment that is missing from which thrust is added for the blades
_SHORT_S, _MORE_S = 0.5, 1.5  # that must be missing for so long; then thrust grows for so long
_KEPT_SHARE = 0.9  # of what the blades can give: they need some room to be exact


class RuddersAllocator:
    """Wrench → Allocation. Remembers what the constrained allocation does, the blades, and for how long the moment has
    been too little."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        """Raises ValueError for a vessel without rudders."""
        self._limits, self._period_s = config.limits, 1.0 / config.control_rate_hz
        self._parameters = parameters
        self._by_race = config.limits.sway_n <= 0.0
        self._short_s = 0.0
        self._blades = [_Blade(i, t) for i, t in enumerate(config.thrusters) if t.kind == "rudder"]
        if not self._blades:
            raise ValueError(f"{config.name}: no thruster has a rudder")
        top_mps = top_speed_mps(config)
        top_mps = top_mps if math.isfinite(top_mps) else 0.0
        most_n = sum(blade.curve.most_n(blade.curve.inflow(blade.max_n, top_mps)) for blade in self._blades)
        self._count = len(config.thrusters)
        self._lever_m = sum(blade.curve.lever_m for blade in self._blades) / len(self._blades)
        together = (*without_blades(config.thrusters), _across(self._lever_m, most_n))
        self._inner = _WithBlades(replace(config, thrusters=together), parameters)

    def set_failed(self, index: int, failed: bool) -> None:
        """Mark thruster `index` as failed or not. One that has failed gives no thrust; its blade steers in the flow of
        the boat's speed."""
        if 0 <= index < self._count:
            self._inner.set_failed(index, failed)

    def set_turn_rate(self, index: int, rate_radps: float) -> None:
        """Turn the blade of thruster `index` no faster from now on."""
        for blade in self._blades:
            if blade.index == index:
                blade.rate_radps = rate_radps

    def feel(self, rig: Rig | None, nav: NavState) -> None:
        """No effect."""

    def neutral(self) -> Allocation:
        """Set all forces to zero; the blades stay where they are."""
        self._inner.low_n = self._inner.high_n = 0.0
        for blade in self._blades:
            blade.thrust_n = blade.steady_flow = blade.usual_flow = 0.0
        self._short_s = 0.0
        return self._result(None, self._inner.neutral(), 0.0)

    def direct(
        self, thrusters: Sequence[ThrusterCommand], dt_s: float | None = None, surge_mps: float = 0.0
    ) -> Allocation:
        """Take throttles and angles as demanded, within limits and rates over `dt_s` (None: one control period): the
        manual path. Missing or non-finite demands count as no thrust."""
        dt_s = self._period_s if dt_s is None else dt_s
        self._inner.low_n = self._inner.high_n = 0.0
        for blade in self._blades:
            angle_rad = thrusters[blade.index].azimuth_rad if blade.index < len(thrusters) else None
            if angle_rad is not None and math.isfinite(angle_rad):
                blade.turn(angle_rad, dt_s)
        given = self._inner.direct(thrusters[: self._count], dt_s, surge_mps)
        self._follow(given, surge_mps, dt_s)
        return self._result(None, given, surge_mps)

    def update(
        self,
        wrench: Wrench,
        dt_s: float,
        surge_mps: float = 0.0,
        planned: bool = False,
        ahead: Sequence[Wrench] = (),
    ) -> Allocation:
        """The allocation for `wrench`, within `dt_s` of the last by all rates. `surge_mps`: speed ahead through the
        water. A non-finite input counts as no demand. `ahead` has no effect: nothing turns for seconds here."""
        if not all(map(math.isfinite, (wrench.surge_n, wrench.sway_n, wrench.yaw_nm, surge_mps))):
            wrench, surge_mps = Wrench(0.0, 0.0, 0.0), 0.0
        steering_n = self._steering_n()
        asked = replace(wrench, surge_n=steering_n) if 0.0 <= wrench.surge_n < steering_n else wrench
        shares = self._bound_blades(asked.surge_n, surge_mps, dt_s)
        given = self._inner.update(asked, dt_s, surge_mps, planned)
        self._follow(given, surge_mps, dt_s)
        side_n, whole_n = given.thrusters[self._count].force_n, sum(shares)
        for blade, share_n in zip(self._blades, shares, strict=True):
            part_n = side_n * share_n / whole_n if whole_n > 0.0 else 0.0
            flow = max(blade.curve.inflow(blade.thrust_n, surge_mps), blade.usual_flow)
            blade.turn(blade.curve.angle_in_flow_rad(part_n, flow), dt_s)
        result = self._result(wrench, given, surge_mps)
        missing_nm = math.copysign(1.0, wrench.yaw_nm) * (wrench.yaw_nm - result.achieved.yaw_nm)
        short = missing_nm / (_SHORT_SHARE * self._limits.yaw_nm) - 1.0 if self._by_race else -1.0
        grown_s = dt_s * min(1.0, max(-1.0, short))
        self._short_s = min(_SHORT_S + _MORE_S, max(0.0, self._short_s + grown_s))
        return result

    def _steering_n(self) -> float:
        """The least thrust ahead, for the blades."""
        share = max(0.0, self._short_s - _SHORT_S) / _MORE_S
        return share * self._parameters["RUD_STEER"] * sum(blade.max_n for blade in self._blades)

    def _bound_blades(self, surge_n: float, surge_mps: float, dt_s: float) -> list[float]:
        """Tell the programme what all blades can give in this cycle, of the thrust that it will give, and within what
        they turn. Returns what each can give."""
        shares, low_n, high_n = [], 0.0, 0.0
        more_n = (surge_n - sum(blade.thrust_n for blade in self._blades)) / len(self._blades)
        for blade in self._blades:
            thrust_n = blade.next_n(more_n, dt_s)
            counted_n = thrust_n if self._by_race else min(0.0, thrust_n)
            flow = min(blade.steady_flow, blade.curve.inflow(counted_n, surge_mps))
            shares.append(_KEPT_SHARE * blade.curve.most_n(flow))
            to_port_n, to_starboard_n = blade.reach_n(thrust_n, surge_mps, dt_s)
            low_n, high_n = low_n + to_port_n, high_n + to_starboard_n
        most_n = sum(shares)
        self._inner.low_n = min(high_n, max(low_n, -most_n))
        self._inner.high_n = max(low_n, min(high_n, most_n))
        return shares

    def _follow(self, given: Allocation, surge_mps: float, dt_s: float) -> None:
        """Let the flow that counts follow that of the thrust: up slowly, down at once. The usual one is its mean."""
        share = dt_s / (dt_s + _FLOW_S) if dt_s > 0.0 else 0.0
        for blade in self._blades:
            blade.thrust_n = given.thrusters[blade.index].force_n
            flow = blade.curve.inflow(blade.thrust_n, surge_mps)
            blade.steady_flow = min(flow, blade.steady_flow + share * (flow - blade.steady_flow))
            blade.usual_flow += share * (flow - blade.usual_flow)

    def _result(self, demanded: Wrench | None, given: Allocation, surge_mps: float) -> Allocation:
        """The commands with the blades' angles, and what all of them give: each blade in place of its part of the one
        that stands for all."""
        commands, side_n = list(given.thrusters[: self._count]), given.thrusters[self._count].force_n
        x, y = given.achieved.surge_n, given.achieved.sway_n - side_n
        n = given.achieved.yaw_nm - self._lever_m * side_n
        for blade in self._blades:
            command = commands[blade.index]
            commands[blade.index] = ThrusterCommand(command.force_n, command.throttle, blade.angle_rad)
            ahead_n, side_n = blade.curve.force_n(command.force_n, blade.angle_rad, surge_mps)
            drag_n = ahead_n - command.force_n
            x, y, n = x + drag_n, y + side_n, n + blade.curve.lever_m * side_n - blade.y_m * drag_n
        achieved = Wrench(x, y, n)
        return Allocation(tuple(commands), achieved, limited_axes(demanded, achieved, self._limits))


class _Blade:
    """A blade: its angle, the last thrust, the flow U² that counts and the usual one, m²/s²."""

    def __init__(self, index: int, thruster: ThrusterConfig) -> None:
        self.index, self.y_m, self.max_n = index, thruster.y_m, min(thruster.max_n, thruster.ahead_n)
        self._force_rate_nps = thruster.force_rate_nps
        self.curve = RudderCurve(thruster)
        self.rate_radps = thruster.azimuth_rate_radps
        self._low_rad, self._high_rad = thruster.azimuth_min_rad or 0.0, thruster.azimuth_max_rad or 0.0
        self.angle_rad = self.thrust_n = self.steady_flow = self.usual_flow = 0.0

    def next_n(self, more_n: float, dt_s: float) -> float:
        """The thrust that is next where so much more is asked for."""
        reach_n = self._force_rate_nps * max(0.0, dt_s)
        return self.thrust_n + min(reach_n, max(-reach_n, more_n))

    def reach_n(self, thrust_n: float, surge_mps: float, dt_s: float) -> tuple[float, float]:
        """(least, most) push to starboard with what the blade turns in `dt_s`."""
        reach = self.rate_radps * max(0.0, dt_s)
        low_rad = min(self._high_rad, max(self._low_rad, self.angle_rad - reach))
        high_rad = min(self._high_rad, max(self._low_rad, self.angle_rad + reach))
        return self.curve.force_n(thrust_n, low_rad, surge_mps)[1], self.curve.force_n(thrust_n, high_rad, surge_mps)[1]

    def turn(self, angle_rad: float, dt_s: float) -> None:
        """Towards that angle, within stops and rate."""
        reach = self.rate_radps * max(0.0, dt_s)
        held = min(self._high_rad, max(self._low_rad, math.remainder(angle_rad, math.tau)))
        self.angle_rad = min(self.angle_rad + reach, max(self.angle_rad - reach, held))


class _WithBlades(Allocator):
    """The constrained allocation, whose last thruster stands for the blades. `low_n`, `high_n`: between which they can
    push to starboard in this cycle."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        super().__init__(config, parameters)
        self.low_n = self.high_n = 0.0

    def _force_bounds(self, i: int, t: Thruster, dt_s: float) -> tuple[float, float]:
        return super()._force_bounds(i, t, dt_s) if i < len(self._thrusters) - 1 else (self.low_n, self.high_n)


def _across(lever_m: float, most_n: float) -> ThrusterConfig:
    """All blades as one thruster that pushes to starboard."""
    return ThrusterConfig(
        name="blades",
        kind="fixed",
        x_m=lever_m,
        y_m=0.0,
        max_n=most_n,
        min_n=-most_n,
        ahead_n=most_n,
        astern_n=most_n,
        force_rate_nps=most_n,
        azimuth_rad=0.5 * math.pi,
    )
