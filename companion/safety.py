"""The last gate before the bridges. It uses only the vessel's own limits, and relies on neither controller nor
allocation."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import (
    NO_AUXILIARY,
    ActuatorCommand,
    Allocation,
    Auxiliary,
    Deployment,
    ThrusterCommand,
    ThrusterFeedback,
)

_FORCE_RATE_SHARE = 1.5  # of the configured rate: the gate cuts only what the allocation should never demand
_FORCE_SLACK_SHARE = 0.02  # of full force, for rounding
_SECTOR_SLACK_RAD = 1.0e-6


class Gate:
    """Allocation → ActuatorCommand that is finite and within all limits and rates.

    `gated` names each limit that changed the demand: "count" for a wrong number of thrusters, else "<thruster>.finite",
    ".throttle", ".slew", ".azimuth", ".sector" or ".retracted", and "<servo>.pulse".

    While disarmed every throttle is exactly 0 at once, and every servo and relay rests, except those that may move
    then. A retractable thruster runs only while its bridge reports it lowered and it is not ordered up. If the bridge
    does not report its position, it runs once it has been ordered down for its travel time. Remembers the last force
    and azimuth of each thruster, and since when the retractable ones are ordered down.
    """

    def __init__(self, config: VesselConfig) -> None:
        self._thrusters = config.thrusters
        self._servos, self._relays = config.servos, config.relays
        self._forces = [0.0] * len(config.thrusters)
        self._azimuths = [t.azimuth_rad for t in config.thrusters]
        self._retractable = tuple(i for i, t in enumerate(config.thrusters) if t.retractable)
        self._down = [not t.retractable for t in config.thrusters]
        self._told_down_s: float | None = None

    def update(
        self,
        allocation: Allocation,
        armed: bool,
        now_s: float,
        dt_s: float,
        lower: bool | None = None,
        feedback: Sequence[ThrusterFeedback | None] = (),
        auxiliary: Auxiliary = NO_AUXILIARY,
    ) -> ActuatorCommand:
        """The command for the bridges. `lower`: the order to the retractable thrusters (None: none); `feedback`: the
        newest of each thruster."""
        gated: list[str] = []
        if self._retractable:
            self._see_which_are_down(lower, feedback, now_s)
        demands: tuple[ThrusterCommand | None, ...] = allocation.thrusters
        if len(demands) != len(self._thrusters):
            gated.append("count")
            demands = (None,) * len(self._thrusters)
        commands = tuple(self._one(i, demand, armed, dt_s, gated) for i, demand in enumerate(demands))
        outputs = Auxiliary(self._pulses(auxiliary.servos_us, armed, gated), self._switches(auxiliary.relays, armed))
        return ActuatorCommand(now_s, armed, commands, tuple(gated), lower, auxiliary=outputs)

    def _see_which_are_down(
        self, lower: bool | None, feedback: Sequence[ThrusterFeedback | None], now_s: float
    ) -> None:
        if lower is not True:
            self._told_down_s = None
        elif self._told_down_s is None:
            self._told_down_s = now_s
        for i in self._retractable:
            report = feedback[i] if i < len(feedback) else None
            if report is not None and report.deployment is not None:
                self._down[i] = lower is not False and report.deployment is Deployment.LOWERED
            else:
                self._down[i] = (
                    self._told_down_s is not None and now_s - self._told_down_s >= self._thrusters[i].travel_s
                )

    def _pulses(self, demands: tuple[float | None, ...], armed: bool, gated: list[str]) -> tuple[float | None, ...]:
        """The demanded pulses within limits; a servo rests if its demand is invalid or not allowed now."""
        if len(demands) != len(self._servos):
            demands = tuple(servo.rest_us for servo in self._servos)
        pulses: list[float | None] = []
        for servo, demand in zip(self._servos, demands, strict=True):
            if not armed and not servo.while_disarmed:
                pulses.append(servo.rest_us)
            elif demand is None or servo.min_us <= demand <= servo.max_us:
                pulses.append(demand)
            else:
                gated.append(f"{servo.name}.pulse")
                pulses.append(min(servo.max_us, max(servo.min_us, demand)) if math.isfinite(demand) else servo.rest_us)
        return tuple(pulses)

    def _switches(self, demands: tuple[bool, ...], armed: bool) -> tuple[bool, ...]:
        if len(demands) != len(self._relays):
            return (False,) * len(self._relays)
        return tuple(on and (armed or relay.while_disarmed) for relay, on in zip(self._relays, demands, strict=True))

    def _one(
        self, i: int, demand: ThrusterCommand | None, armed: bool, dt_s: float, gated: list[str]
    ) -> ThrusterCommand:
        thruster = self._thrusters[i]
        throttle = self._throttle(thruster, demand, gated) if armed else 0.0
        if throttle != 0.0 and not self._down[i]:
            gated.append(f"{thruster.name}.retracted")
            throttle = 0.0
        force = _force_n(thruster, throttle)
        if armed:
            slewed = self._slewed(thruster, self._forces[i], force, dt_s)
            if slewed != force:
                gated.append(f"{thruster.name}.slew")
                force, throttle = slewed, _throttle_for(thruster, slewed)
        self._forces[i] = force
        azimuth = None
        if thruster.turns:
            azimuth = self._azimuths[i] = self._azimuth(thruster, self._azimuths[i], demand, gated)
            if throttle != 0.0 and _forbidden(thruster, azimuth):
                gated.append(f"{thruster.name}.sector")
                force = throttle = self._forces[i] = 0.0
        return ThrusterCommand(force, throttle, azimuth)

    @staticmethod
    def _throttle(thruster: ThrusterConfig, demand: ThrusterCommand | None, gated: list[str]) -> float:
        """The demanded throttle within the thruster's limits; 0 for none or a non-finite one."""
        if demand is None:
            return 0.0
        if not math.isfinite(demand.throttle):
            gated.append(f"{thruster.name}.finite")
            return 0.0
        highest = _throttle_for(thruster, thruster.max_n)
        lowest = -min(1.0, math.sqrt(-thruster.min_n / thruster.astern_n))
        throttle = min(highest, max(lowest, demand.throttle))
        if abs(throttle - demand.throttle) > 1.0e-9:
            gated.append(f"{thruster.name}.throttle")
        return throttle

    @staticmethod
    def _slewed(thruster: ThrusterConfig, last_n: float, force_n: float, dt_s: float) -> float:
        """The force as near to the demanded one as the rate allows. A change towards zero is never delayed."""
        if last_n * force_n >= 0.0 and abs(force_n) <= abs(last_n):
            return force_n
        begin = 0.0 if last_n * force_n < 0.0 else last_n
        reach = _FORCE_RATE_SHARE * thruster.force_rate_nps * (max(0.0, dt_s) if math.isfinite(dt_s) else 0.0)
        reach += _FORCE_SLACK_SHARE * thruster.max_n
        return min(begin + reach, max(begin - reach, force_n))

    @staticmethod
    def _azimuth(thruster: ThrusterConfig, last_rad: float, demand: ThrusterCommand | None, gated: list[str]) -> float:
        """The demanded azimuth within the stops; the last one for none or a non-finite one."""
        if demand is None or demand.azimuth_rad is None:
            return last_rad
        azimuth = demand.azimuth_rad
        if not math.isfinite(azimuth):
            gated.append(f"{thruster.name}.finite")
            return last_rad
        low = -math.inf if thruster.azimuth_min_rad is None else thruster.azimuth_min_rad
        high = math.inf if thruster.azimuth_max_rad is None else thruster.azimuth_max_rad
        held = min(high, max(low, azimuth))
        if abs(held - azimuth) > _SECTOR_SLACK_RAD:
            gated.append(f"{thruster.name}.azimuth")
        return held


def _forbidden(thruster: ThrusterConfig, azimuth_rad: float) -> bool:
    """Whether the azimuth is inside a forbidden sector."""
    return any(
        _SECTOR_SLACK_RAD < (azimuth_rad - start) % math.tau < (end - start) % math.tau - _SECTOR_SLACK_RAD
        for start, end in thruster.forbidden_rad
    )


def _force_n(thruster: ThrusterConfig, throttle: float) -> float:
    """The force at that throttle; for a jet at rest, where it is largest."""
    if thruster.jet is not None:
        return 0.0 if throttle < thruster.dead_band else thruster.jet.bollard_n(throttle)
    gain = thruster.ahead_n if throttle >= 0.0 else thruster.astern_n
    return 0.0 if abs(throttle) < thruster.dead_band else gain * throttle * abs(throttle)


def _throttle_for(thruster: ThrusterConfig, force_n: float) -> float:
    """The throttle that gives a force, within −1…1."""
    jet = thruster.jet
    if jet is not None:
        share = (math.sqrt(max(0.0, force_n) / jet.density_area_kgpm) - jet.idle_mps) / jet.span_mps
        return min(1.0, math.pow(share, 1.0 / jet.exponent)) if share > 0.0 else 0.0
    gain = thruster.ahead_n if force_n >= 0.0 else thruster.astern_n
    return math.copysign(min(1.0, math.sqrt(abs(force_n) / gain)), force_n)
