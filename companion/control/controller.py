"""Setpoint and state → wrench: each type of setpoint has its own law, and all laws share one bias force."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from companion.config.vessel import VesselConfig
from companion.config.yaw_limit import YawLimit
from companion.control.bias import BiasForce
from companion.control.coming_to_rest import ComingToRest
from companion.control.dynamic_positioning import DynamicPositioning, finite
from companion.control.economy import MeanForce
from companion.control.free_drift import FreeDrift
from companion.control.heading import HeadingControl, YawLoop
from companion.control.known_current import KnownCurrent
from companion.control.lqr import LqrTracking
from companion.control.path_control import PathControl, turned_soon_rad
from companion.control.planned_steps import planned_steps
from companion.control.predictive import PredictiveControl
from companion.control.wind import SlowWind, force_of_air, wind_force
from companion.control.wind_handover import WindHandover
from companion.control.yaw_disturbance import YawDisturbance
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState, air_over_ground, through_water, without_waves
from companion.core.frames import ned_to_body
from companion.core.setpoint import (
    HeadingSetpoint,
    NeutralSetpoint,
    PathSetpoint,
    PoseSetpoint,
    Setpoint,
    WrenchSetpoint,
)
from companion.params.store import Parameters

_BASELINE = 1  # value of DP_LAW and WP_LAW
_FEWEST_POSES = 3  # of which a change of the wrench can be told
_STEERED = (PoseSetpoint, PathSetpoint, HeadingSetpoint)
_TURN_RAD = math.radians(20.0)  # off the heading: the estimate takes part of a fast turn for waves


class PositioningLaw(Protocol):
    """A dynamic positioning law with an integral of its own."""

    def start(self, surge_n: float, sway_n: float, yaw_nm: float) -> None:
        """Begin with the bias force so far, in body axes."""
        ...

    def update(self, setpoint: PoseSetpoint, nav: NavState, dt_s: float) -> Wrench:
        """The wrench for the setpoint, before saturation."""
        ...


class TrackingLaw(Protocol):
    """A law for speed and heading under way, with integrals of its own."""

    def start(self) -> None:
        """Begin with integrals of zero."""
        ...

    def update(self, setpoint: PathSetpoint, nav: NavState, dt_s: float) -> Wrench:
        """The wrench for the setpoint, before saturation."""
        ...


class Controller:
    """Setpoint → wrench within the vessel's limits.

    The bias force stays while the sticks demand forces or thrusters, and is reset when the boat is neutral, as is what
    turns a bow that the weather holds. Remembers the bias force, the last wrench that a law demanded, and which law is
    active.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        baseline: PositioningLaw | None = None,
        baseline_tracking: TrackingLaw | None = None,
    ) -> None:
        """`baseline`, `baseline_tracking`: the theses' laws, which DP_LAW 1 and WP_LAW 1 choose; None: not
        available."""
        self._config = config
        self._yaw_limit = YawLimit(config)
        self._yaw = yaw = YawLoop(config, parameters)
        self._parameters = parameters
        self._positioning = DynamicPositioning(config, parameters)
        self._free_drift = FreeDrift(config.hull)
        self._mean_wind = MeanForce()
        self._wind_handover = WindHandover()
        self._gusts = YawDisturbance(config, parameters)
        self._slow_wind = SlowWind()
        self._baseline = baseline
        self._by_baseline = False
        self._tracking = PathControl(config, parameters, yaw)
        self._current = KnownCurrent(config.hull)
        self._baseline_tracking = baseline_tracking
        self._lqr = LqrTracking(config, parameters)
        self._predictive = PredictiveControl(config, parameters)
        self._other_law: TrackingLaw | None = None  # the law in use under way, if it is not `_tracking`
        self._heading = HeadingControl(yaw)
        self._bias = BiasForce(config.limits, self._yaw_limit.most_nm)
        self._coming_to_rest = ComingToRest(config)
        self._demanded: Wrench | None = None
        self._surge_mps = 0.0  # through the water, as far as it counts for the limits
        self._under_way = False
        self._ahead: tuple[Wrench, ...] = ()

    def reset(self) -> None:
        """Forget the bias force, and what the laws remember of earlier cycles."""
        self._bias.reset()
        self._yaw.restart()
        self._demanded = None
        self._restart_positioning()
        self._restart_tracking()

    def _restart_positioning(self) -> None:
        self._positioning.restart()
        self._mean_wind.restart()
        self._wind_handover.restart()
        self._gusts.restart()
        self._by_baseline = False

    def _restart_tracking(self) -> None:
        self._other_law = None
        self._tracking.restart()
        self._predictive.restart()
        self._slow_wind.restart()
        self._current.restart()

    def set_turn_rate(self, index: int, rate_radps: float) -> None:
        """Thruster `index` turns no faster: one that alone steers the boat bounds the yaw loop's bandwidth."""
        if index == 0:
            self._yaw.steers_at(rate_radps)

    @property
    def steers_late_s(self) -> float:
        """By how much the yaw loop under way answers later than with thrusters that turn as the file says."""
        return self._yaw.late_s

    @property
    def turn_resistance(self) -> float:
        """How many times as hard as the vessel's file says the water resists a turn, 1 or more."""
        return self._yaw.resistance

    @property
    def ahead(self) -> tuple[Wrench, ...]:
        """The wrenches that a planned path will demand, PATH_STEP_S apart, the first after PATH_STEP_S; empty without
        one."""
        return self._ahead

    def update(self, setpoint: Setpoint, nav: NavState, achieved: Wrench, dt_s: float) -> Wrench:
        """The wrench for the setpoint. `achieved`: what the thrusters gave in the last cycle, by the allocation; the
        bias is reduced by what fell short of the last demand."""
        self._ahead = ()
        self._surge_mps = through_water(nav)[0] if self._yaw_limit.by_speed else 0.0
        self._under_way = isinstance(setpoint, PathSetpoint)
        self._yaw.pushes(achieved)
        if not isinstance(setpoint, _STEERED):
            self._free_drift.see(nav, achieved, dt_s)
        self._restart_others(setpoint)
        self._bias.keeps_across = isinstance(setpoint, PathSetpoint) and setpoint.keeps_place
        match setpoint:
            case PoseSetpoint():
                self._coming_to_rest.rest(self._bias, nav)
                return self._position(setpoint, nav, achieved, dt_s)
            case PathSetpoint():
                if _brakes(setpoint):
                    self._coming_to_rest.rest(self._bias, nav)
                else:
                    self._coming_to_rest.sail(nav, dt_s)
                return self._track(setpoint, nav, achieved, dt_s)
            case HeadingSetpoint():
                return self._head(setpoint, nav, achieved, dt_s)
            case WrenchSetpoint(wrench) if finite(wrench):
                self._demanded = None
                return self._saturated(wrench)
            case NeutralSetpoint():
                self._bias.reset()
                self._yaw.restart()
        self._demanded = None
        return ZERO_WRENCH

    def _restart_others(self, setpoint: Setpoint) -> None:
        """Forget what the laws remember that do not steer now."""
        if not isinstance(setpoint, PoseSetpoint):
            self._restart_positioning()
        if not isinstance(setpoint, PathSetpoint):
            self._restart_tracking()
        if not isinstance(setpoint, (PoseSetpoint, PathSetpoint)):
            self._coming_to_rest.forget()

    def _head(self, setpoint: HeadingSetpoint, nav: NavState, achieved: Wrench, dt_s: float) -> Wrench:
        """The moment that holds the heading, with the forces of the sticks."""
        self._unwind(achieved, nav, dt_s, lambda d: Wrench(achieved.surge_n, achieved.sway_n, d.yaw_nm))
        if (pushed_n := math.hypot(*setpoint.pushed_ned_n)) > 0.0:  # near a fence, the next law has no room to learn it
            north, east = setpoint.pushed_ned_n[0] / pushed_n, setpoint.pushed_ned_n[1] / pushed_n
            x, y = ned_to_body(north, east, nav.yaw_rad)
            air_x, air_y, _ = wind_force(self._config.windage, self._config.length_m, nav)
            self._bias.take(x * air_x + y * air_y - pushed_n, north, east, nav.yaw_rad)
        wrench = self._heading.update(setpoint, nav, self._bias, dt_s)
        return self._limited(self._against_wind_moment(wrench, nav))

    def _position(self, setpoint: PoseSetpoint, nav: NavState, achieved: Wrench, dt_s: float) -> Wrench:
        """The wrench of dynamic positioning, by the law that DP_LAW chooses; a moment that the gyro tells is answered
        before the heading is off."""
        if self._baseline is not None and self._parameters["DP_LAW"] == _BASELINE:
            return self._position_by_baseline(self._baseline, setpoint, nav, dt_s)
        self._by_baseline = False
        self._take_up_drift(nav)
        nav = without_waves(nav)
        self._unwind(achieved, nav, dt_s, lambda demanded: demanded)
        air = wind_force(self._config.windage, self._config.length_m, nav)
        known = None if air_over_ground(nav) is None else air
        wind = self._wind_handover.update(known, self._bias, nav.yaw_rad, dt_s)
        if (handover := self._wind_handover).changed:
            self._mean_wind.restart()
            self._gusts.hand_over(nav, handover.gone_nm, handover.handed_nm, handover.came)
        wrench = self._positioning.update(setpoint, nav, self._bias, dt_s)
        firmness = self._positioning.firmness
        x, y, n = self._mean_wind.update(wind, firmness, dt_s)
        told_nm = self._gusts.update(nav, achieved.yaw_nm + wind[2], dt_s)
        if not setpoint.bow_on:  # a boat that is driven off has no thrust to spare for the heading
            n += firmness.yaw * told_nm
        return self._limited(Wrench(wrench.surge_n - x, wrench.sway_n - y, wrench.yaw_nm - n))

    def _take_up_drift(self, nav: NavState) -> None:
        """Begin with a bias against what has pushed the boat while it lay adrift, unless a measured wind tells it."""
        push = self._free_drift.push(nav.t_s)
        self._free_drift.forget()
        if push is None or nav.wind_speed_mps is not None:
            return
        self._bias.take(-push[0], 1.0, 0.0, nav.yaw_rad)
        self._bias.take(-push[1], 0.0, 1.0, nav.yaw_rad)

    def _track(self, setpoint: PathSetpoint, nav: NavState, achieved: Wrench, dt_s: float) -> Wrench:
        """The wrench under way, by the law that PATH_CTRL and WP_LAW choose."""
        law = self._chosen_other_law()
        if law is not None:
            return self._track_without_bias(law, setpoint, nav, dt_s)
        self._other_law = None
        if setpoint.exact:
            self._current.hand_over(setpoint, nav, self._bias)
        if self._predictive.chosen(setpoint):
            wind = wind_force(self._config.windage, self._config.length_m, nav)
            wrench = self._predictive.update(setpoint, nav, self._bias, wind, achieved, dt_s)
            if wrench is not None:
                self._demanded = None
                self._tracking.restart()
                return self._saturated(wrench)
        if setpoint.keeps_place and abs(wrap_pi(setpoint.yaw_rad - nav.yaw_rad)) < _TURN_RAD:
            nav = without_waves(nav)
        exact = setpoint.exact
        self._unwind(achieved, nav, dt_s, lambda d: Wrench(d.surge_n, d.sway_n if exact else achieved.sway_n, d.yaw_nm))
        wrench = self._tracking.update(setpoint, nav, self._bias, dt_s)
        wrench = self._limited(self._against_wind(wrench, nav, turned_soon_rad(setpoint), dt_s))
        if len(setpoint.ahead) > _FEWEST_POSES:
            self._ahead = self._later(wrench, setpoint, nav)
        return wrench

    def _later(self, wrench: Wrench, setpoint: PathSetpoint, nav: NavState) -> tuple[Wrench, ...]:
        """How the demand `wrench` will change along the planned poses, with wind and bias from where they come then."""
        config, air = self._config, self._slow_wind.air
        water = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        steps = planned_steps(config.hull, setpoint.ahead, water)
        needed = []
        for yaw_rad, (x, y, n) in zip(steps.yaw_rad, steps.wrench, strict=False):
            bias_x, bias_y, _ = self._bias.in_body(yaw_rad)
            turned_rad = wrap_pi(yaw_rad - nav.yaw_rad)
            wind_x, wind_y, wind_n = force_of_air(config.windage, config.length_m, nav, air, turned_rad)
            needed.append((x + bias_x - wind_x, y + bias_y - wind_y, n - wind_n))
        now_x, now_y, now_n = needed[0]
        later = [
            Wrench(wrench.surge_n + x - now_x, wrench.sway_n + y - now_y, wrench.yaw_nm + n - now_n)
            for x, y, n in needed[1:]
        ]
        return tuple(map(self._saturated, later)) if all(map(finite, later)) else ()

    def _unwind(self, achieved: Wrench, nav: NavState, dt_s: float, relevant: Callable[[Wrench], Wrench]) -> None:
        """Reduce the bias by what fell short of the last demand. `relevant` keeps the demand on the axes whose bias the
        law learns, and replaces it by the achieved wrench on the others."""
        if self._demanded is not None and finite(achieved):
            self._bias.unwind(relevant(self._demanded), achieved, nav.yaw_rad, dt_s)

    def _limited(self, wrench: Wrench) -> Wrench:
        """The wrench within the limits, remembered as the demand; after one that is not finite all begins anew."""
        if not finite(wrench):
            self.reset()
            return ZERO_WRENCH
        self._demanded = wrench
        return self._saturated(wrench)

    def _chosen_other_law(self) -> TrackingLaw | None:
        """The law to use under way instead of the companion's loops; None for those."""
        if self._lqr.chosen:
            return self._lqr
        return self._baseline_tracking if self._parameters["WP_LAW"] == _BASELINE else None

    def _track_without_bias(self, law: TrackingLaw, setpoint: PathSetpoint, nav: NavState, dt_s: float) -> Wrench:
        """The wrench of a law with its own integrals, which uses neither the wind nor the achieved wrench."""
        self._demanded = None
        self._positioning.restart()
        if law is not self._other_law:
            law.start()
        self._other_law = law
        wrench = law.update(setpoint, nav, dt_s)
        if not finite(wrench):
            law.start()
            return ZERO_WRENCH
        return self._saturated(wrench)

    def _position_by_baseline(self, law: PositioningLaw, setpoint: PoseSetpoint, nav: NavState, dt_s: float) -> Wrench:
        """The wrench of the thesis's law, which uses neither the wind nor the achieved wrench."""
        self._positioning.restart()
        self._gusts.restart()
        if not self._by_baseline:
            law.start(*self._bias.in_body(nav.yaw_rad))
        self._by_baseline = True
        self._demanded = None
        wrench = law.update(setpoint, nav, dt_s)
        if not finite(wrench):
            self.reset()
            return ZERO_WRENCH
        return self._saturated(wrench)

    def _against_wind(self, wrench: Wrench, nav: NavState, turned_rad: float, dt_s: float) -> Wrench:
        """The wrench, plus force and moment against the wind under way, without its short gusts, on a heading that is
        turned by `turned_rad`."""
        air = self._slow_wind.update(nav, self._parameters["PATH_GUST_T"], dt_s)
        x, y, n = force_of_air(self._config.windage, self._config.length_m, nav, air, turned_rad)
        return Wrench(wrench.surge_n - x, wrench.sway_n - y, wrench.yaw_nm - n)

    def _against_wind_moment(self, wrench: Wrench, nav: NavState) -> Wrench:
        """The wrench, plus a moment against the wind; the forces of the sticks stay."""
        _, _, n = wind_force(self._config.windage, self._config.length_m, nav)
        return Wrench(wrench.surge_n, wrench.sway_n, wrench.yaw_nm - n)

    def _saturated(self, wrench: Wrench) -> Wrench:
        limits = self._config.limits
        surge_n = min(limits.surge_n, max(-limits.surge_n, wrench.surge_n))
        surge_n, yaw_nm = self._yaw_limit.within(surge_n, wrench.yaw_nm, self._surge_mps, self._under_way)
        return Wrench(surge_n, min(limits.sway_n, max(-limits.sway_n, wrench.sway_n)), yaw_nm)


def _brakes(setpoint: PathSetpoint) -> bool:
    """Whether it asks for rest, as positioning does of a boat that is faster than it moves one."""
    return not setpoint.exact and setpoint.surge_mps == setpoint.sway_mps == setpoint.surge_mps2 == 0.0
