"""Yaw loop of a boat under way: PD with feed-forward and the moment of the bias."""

from __future__ import annotations

import math

from companion.config.blades import without_blades
from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.control.bias import BiasForce
from companion.control.dynamic_positioning import pole_placement
from companion.control.model import damping, drift_moment_nm
from companion.control.slow_nozzle import SlowNozzle
from companion.control.turn_resistance import TurnResistance
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState, through_water
from companion.core.setpoint import HeadingSetpoint, PathSetpoint
from companion.params.store import Parameters

_DAMPING = 0.9
_INTEGRAL_SHARE = 0.1
_SLOW_INTEGRAL_SHARE = 0.3  # of a loop that slow steering has made slower, where a moment turns the bow further off
_BEND_RADPS = math.radians(8.0)  # in a faster turn, a loop with slow steering lags, which is no offset to learn
_FORGET_S = 4.0  # such a turn changes what the weather's moment is
# The share of the way to its stop that a nozzle must cover in 1/bandwidth: with less, its rate limit makes the loop
# oscillate.
_SWING_SHARE = 0.6
# The same for a rudder that turns slower than the file says: the loop may be oscillating already. What a nozzle still
# does until it is back is foreseen.
_SLOW_SWING_SHARE = 1.0
# The moment of the drift that is answered at once, of the limit, or as that of such an error of the heading. With the
# latter alone, five boats that are unstable on their course were a tenth to a half further off their squares.
_DRIFT_SHARE, _DRIFT_RAD = 0.5, 0.25
_LARGE_ERROR_RAD = math.radians(25.0)  # a larger error is a turn, not an offset to learn
_STALLED_SHARE = 0.25  # of the turn that is asked for
# In which a stalled bow gets as much moment again as the loop gives it; once it is free, the same is forgotten.
_HEAVE_S = 1.5
_ABLE_HEAVE_S = 6.0  # the same, growing, of a boat that pushes its bow sideways: few weathers hold that


class YawLoop:
    """Setpoint → yaw moment. For a large error the boat turns at PATH_YAW_RATE. Remembers the moment by which it heaves
    a bow round that the weather holds, and how hard the water resists its turns.

    Its bandwidth is PATH_BW_YAW, or what a jet's nozzle or a rudder can follow at its rate of turn, if that is less."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull = config.hull
        self._config, self._configured_radps = config, _first(config).azimuth_rate_radps
        self._nozzle = _nozzle(config)
        self.steers_at(self._configured_radps)
        self._heave_s = _heave_s(config)
        bladed = any(thruster.rudder is not None for thruster in config.thrusters)
        learns = config.limits.sway_n <= 0.0 and not bladed
        self._resistance = TurnResistance(config) if learns else None
        self._pushed = ZERO_WRENCH
        self._sails = config.has_sail
        self._parameters = parameters
        self.restart()

    def restart(self) -> None:
        """Forget what the weather held."""
        self._heave_nm = 0.0
        if self._resistance is not None:
            self._resistance.restart()

    def steers_at(self, rate_radps: float) -> None:
        """The rate at which the nozzle or the rudder turns, where it is not the configured one."""
        self._slow = rate_radps < self._configured_radps
        if self._nozzle is not None:
            self._nozzle.rate_radps = rate_radps
        cautious = self._slow and self._nozzle is None
        self._most_radps = _followed_radps(self._config, rate_radps, _SLOW_SWING_SHARE if cautious else _SWING_SHARE)

    def pushes(self, achieved: Wrench) -> None:
        """What the thrusters gave in the last cycle, before each `moment_nm`."""
        self._pushed = achieved
        if self._nozzle is not None:
            self._nozzle.pushed = achieved

    @property
    def resistance(self) -> float:
        """How many times as hard as its file says the water resists a turn, 1 or more."""
        return 1.0 if self._resistance is None else self._resistance.factor

    @property
    def late_s(self) -> float:
        """By how much the loop answers later than with steering as configured: difference of the times 1/bandwidth."""
        if not self._slowed:
            return 0.0
        configured_radps = _followed_radps(self._config, self._configured_radps, _SWING_SHARE)
        return 1.0 / self._bandwidth_radps - 1.0 / min(self._parameters["PATH_BW_YAW"], configured_radps)

    @property
    def _slowed(self) -> bool:
        """Whether steering is so much slower than configured that the loop is."""
        return self._slow and self._most_radps < self._parameters["PATH_BW_YAW"]

    @property
    def _bandwidth_radps(self) -> float:
        return min(self._parameters["PATH_BW_YAW"], self._most_radps)

    def moment_nm(
        self,
        setpoint: PathSetpoint | HeadingSetpoint,
        nav: NavState,
        bias: BiasForce,
        dt_s: float,
        flow: tuple[float, float] | None = None,
    ) -> float:
        """The moment that holds `setpoint.yaw_rad`, turning at `setpoint.yaw_rate_radps`, before saturation. `flow`:
        surge and sway through the water; None: by the estimated current."""
        hull = self._hull
        rate, yaw_rate = setpoint.yaw_rate_radps, nav.yaw_rate_radps
        error = wrap_pi(nav.yaw_rad - setpoint.yaw_rad)
        ahead = abs(nav.surge_mps)
        if self._resistance is not None:
            self._resistance.update(nav, self._pushed, dt_s)
        harder = self.resistance
        resisting = harder * (hull.damping.n_r + hull.damping.n_ur * ahead)
        bandwidth = self._bandwidth_radps
        kp, ki, kd = _gains(hull.m33_kgm2, resisting, bandwidth, self._integral_share(rate))
        fastest = math.radians(self._parameters["PATH_YAW_RATE"])
        learned_nm = bias.in_body(nav.yaw_rad)[2]
        growth = -ki * self._offset(error) - self._forgotten_1ps(rate, error, learned_nm) * learned_nm
        if growth != 0.0:
            bias.grow(0.0, 0.0, growth, nav.yaw_rad, dt_s)
        drag = harder * damping(hull, ahead, 0.0, rate)[2]
        fastest_drag = harder * damping(hull, ahead, 0.0, fastest)[2]
        # A steady turn at the fastest rate takes both the loop's damping and what the hull resists.
        bound = (kd * fastest + max(0.0, fastest_drag - abs(drag))) / kp
        heave = self._heaved_nm(error, bound, yaw_rate, kd * fastest, dt_s)
        u, v = through_water(nav) if flow is None else flow
        drift_nm = drift_moment_nm(hull, u, v)
        most_nm = max(_DRIFT_RAD * kp, _DRIFT_SHARE * self._config.limits.yaw_nm)
        drift_nm = min(most_nm, max(-most_nm, drift_nm))
        held_nm = bias.in_body(nav.yaw_rad)[2]
        if self._slow and self._nozzle is not None:
            foreseen = self._nozzle.foreseen(drag + drift_nm + held_nm, resisting)
            error += (yaw_rate - rate) * foreseen.time_s + foreseen.turned_rad
            yaw_rate += foreseen.grown_radps
        pull = min(bound, max(-bound, error))
        return drag + drift_nm - kp * pull - kd * (yaw_rate - rate) + heave + held_nm

    def _integral_share(self, rate_radps: float) -> float:
        """Integral action as a share of the bandwidth, in a turn at that rate. None under sail, where what turns the
        boat changes its side with the tack: who steers learns that (`companion.guidance.sailing`)."""
        if self._sails:
            return 0.0
        return _SLOW_INTEGRAL_SHARE * (1.0 - _in_bend(rate_radps)) if self._slowed else _INTEGRAL_SHARE

    def _forgotten_1ps(self, rate_radps: float, error: float, learned_nm: float) -> float:
        """Share of the learned moment that is forgotten a second, in a turn at that rate, or far off the heading where
        it turns the bow further off: it was of another course and speed."""
        if abs(error) >= _LARGE_ERROR_RAD and error * learned_nm > 0.0:
            return 1.0 / _FORGET_S
        return _in_bend(rate_radps) / _FORGET_S if self._slowed else 0.0

    def _offset(self, error: float) -> float:
        """The error that the bias learns from. A large one is a turn."""
        return error if abs(error) < _LARGE_ERROR_RAD else 0.0

    def _heaved_nm(self, error: float, bound: float, rate_radps: float, turning_nm: float, dt_s: float) -> float:
        """The moment against weather that holds the bow: it grows while the boat does not turn as asked for, and falls
        with the rest of the turn (`bound`: the error at which that begins). The bias would be too slow, and would turn
        the bow through the wind to the other side. `turning_nm`: what the loop gives for the fastest turn."""
        side = -math.copysign(1.0, error)
        heave = max(0.0, side * self._heave_nm)
        asked = min(1.0, abs(error) / bound)
        if math.isinf(self._heave_s) or abs(error) < _LARGE_ERROR_RAD:
            heave -= heave * min(1.0, dt_s / _HEAVE_S)
        elif side * rate_radps < _STALLED_SHARE * asked * math.radians(self._parameters["PATH_YAW_RATE"]):
            heave = min(self._config.limits.yaw_nm, heave + asked * turning_nm * dt_s / self._heave_s)
        elif self._heave_s == _ABLE_HEAVE_S:  # a heavy ship that has only begun to turn was no stalled one
            heave -= heave * min(1.0, dt_s / _ABLE_HEAVE_S)
        elif side * rate_radps > math.radians(self._parameters["PATH_YAW_RATE"]):
            heave -= heave * min(1.0, dt_s / _HEAVE_S)
        self._heave_nm = side * heave
        return asked * self._heave_nm


def _gains(inertia_kgm2: float, drag: float, bandwidth_radps: float, integral: float) -> tuple[float, float, float]:
    """As `pole_placement`; stiffer for a hull that its way holds straight, whose damping in yaw is above the critical.

    Its slower pole Kp/(d + Kd) is below the bandwidth by the factor `slow`. Kp and Ki grow by the root of that: with
    all of it a heading's noise turns the thrusters. Otter on a route, by 1, root, all: 0.11, 0.09, 0.08 m off the
    track, thrust varies by 1.9, 2.2, 3.7 % a second.
    """
    kp, ki, kd = pole_placement(inertia_kgm2, drag, bandwidth_radps, _DAMPING, integral)
    slow = (drag + kd) * bandwidth_radps / kp - 1.0
    more = math.sqrt(max(1.0, slow))
    return more * kp, more * ki, kd


def _first(config: VesselConfig) -> ThrusterConfig:
    """The thruster that steers a boat with nothing else."""
    return without_blades(config.thrusters)[0]


def _nozzle(config: VesselConfig) -> SlowNozzle | None:
    """Of a jet that alone steers the boat."""
    first = _first(config)
    stops = _stops_rad(config)
    return SlowNozzle(config, max(stops)) if first.kind == "jet" and stops else None


def _stops_rad(config: VesselConfig) -> list[float]:
    first = _first(config)
    return [abs(stop) for stop in (first.azimuth_min_rad, first.azimuth_max_rad) if stop is not None]


def held_nm_per_rad(config: VesselConfig) -> float:
    """The moment for each radian off the heading, of a boat at rest: stronger weather turns its bow away from it."""
    bandwidth_radps = Parameters(config.parameters)["PATH_BW_YAW"]
    return _gains(config.hull.m33_kgm2, config.hull.damping.n_r, bandwidth_radps, _INTEGRAL_SHARE)[0]


def _in_bend(rate_radps: float) -> float:
    """0 on a straight, 1 in a turn."""
    return min(1.0, abs(rate_radps) / _BEND_RADPS)


def _heave_s(config: VesselConfig) -> float:
    """The time in which a bow that the weather holds against the moment asked for gets as much again; infinite where
    the weather does not hold it: an outboard or an azimuth that steers a boat without sideways thrust turns it with all
    that it pushes with. A jet pushes no more than its moment takes."""
    if config.limits.sway_n > 0.0:
        return _ABLE_HEAVE_S
    turned = any(t.turns and t.kind not in ("rudder", "jet") for t in config.thrusters)
    return math.inf if turned else _HEAVE_S


def _followed_radps(config: VesselConfig, rate_radps: float, swing_share: float) -> float:
    """The bandwidth that a jet's nozzle or a rudder can follow in large turns; infinite for other boats."""
    first, stops = _first(config), _stops_rad(config)
    slow = first.kind in ("jet", "rudder", "sail") and stops
    return rate_radps / (swing_share * max(stops)) if slow else math.inf


class HeadingControl:
    """Law for heading setpoints: it holds the heading; surge and sway forces are those of the sticks."""

    def __init__(self, yaw: YawLoop) -> None:
        self._yaw = yaw

    def update(self, setpoint: HeadingSetpoint, nav: NavState, bias: BiasForce, dt_s: float) -> Wrench:
        """The forces of the sticks and the moment of the yaw loop."""
        moment = self._yaw.moment_nm(setpoint, nav, bias, dt_s)
        return Wrench(setpoint.wrench.surge_n, setpoint.wrench.sway_n, moment)
