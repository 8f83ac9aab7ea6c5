"""Setpoint and state → wrench: each kind of setpoint goes to its own law, and all share one bias force."""

from __future__ import annotations

from companion.config import VesselConfig
from companion.control.bias import BiasForce
from companion.control.dynamic_positioning import DynamicPositioning, finite
from companion.control.heading import HeadingControl, YawLoop
from companion.control.path_tracking import PathTracking
from companion.control.quadratic import QuadraticTracking
from companion.control.thesis_positioning import ThesisPositioning
from companion.control.thesis_tracking import ThesisTracking
from companion.control.wind import wind_force
from companion.core.types import ZERO_WRENCH, NavState, Setpoint, SetpointKind, Wrench
from companion.params import Parameters

_THESIS = 1  # DP_LAW, WP_LAW
_STEERED = (SetpointKind.POSE, SetpointKind.PATH, SetpointKind.HEADING)


class Controller:
    """`update(setpoint, nav, achieved, dt_s)` → wrench within the vessel's limits.

    Remembers the bias force (one for all laws: a change of law is no bump), the wrench last demanded and whether a law demanded it. The bias
    is kept while a person steers by force or thruster, and forgotten when the boat is neutral. `achieved` is what the allocation of
    the last cycle said the thrusters give; the bias gives back what fell short.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        yaw = YawLoop(config, parameters)
        self._parameters = parameters
        self._positioning = DynamicPositioning(config, parameters)
        self._thesis = ThesisPositioning(config, parameters)
        self._by_thesis = False
        self._tracking = PathTracking(config, parameters, yaw)
        self._thesis_tracking = ThesisTracking(config.limits, parameters)
        self._quadratic = QuadraticTracking(config, parameters)
        self._other: ThesisTracking | QuadraticTracking | None = None  # at work under way in place of `_tracking`
        self._heading = HeadingControl(yaw)
        self._bias = BiasForce(config.limits)
        self._demanded: Wrench | None = None

    def reset(self) -> None:
        """Forget the bias force."""
        self._bias.reset()
        self._demanded = None

    def update(self, setpoint: Setpoint, nav: NavState, achieved: Wrench, dt_s: float) -> Wrench:
        """The wrench that the setpoint asks for now."""
        kind = setpoint.kind
        other = self._other_tracking(kind)
        if other is not None and other is not self._other:
            other.start()
        self._other = other
        if other is not None:
            self._by_thesis = False
            self._positioning.restart()
            return self._without_bias(other, setpoint, nav, dt_s)
        by_thesis = kind is SetpointKind.POSE and self._parameters["DP_LAW"] == _THESIS
        if by_thesis and not self._by_thesis:
            self._thesis.start(*self._bias.in_body(nav.yaw_rad))
        self._by_thesis = by_thesis
        if by_thesis:
            self._positioning.restart()
            return self._as_in_the_thesis(setpoint, nav, dt_s)
        if kind not in _STEERED:
            self._demanded = None
            self._positioning.restart()
            if kind is SetpointKind.WRENCH and setpoint.wrench is not None and finite(setpoint.wrench):
                return self._saturated(setpoint.wrench)
            if kind is SetpointKind.NEUTRAL:
                self._bias.reset()
            return ZERO_WRENCH
        if self._demanded is not None and finite(achieved):
            self._bias.unwind(self._learning(kind, self._demanded, achieved), achieved, nav.yaw_rad, dt_s)
        if kind is not SetpointKind.POSE:
            self._positioning.restart()
        law = self._positioning if kind is SetpointKind.POSE else self._tracking if kind is SetpointKind.PATH else self._heading
        wrench = self._against_wind(law.update(setpoint, nav, self._bias, dt_s), kind, nav)
        if not finite(wrench):
            self.reset()
            return ZERO_WRENCH
        self._demanded = wrench
        return self._saturated(wrench)

    def _other_tracking(self, kind: SetpointKind) -> ThesisTracking | QuadraticTracking | None:
        """What steers along a path in place of the companion's own loops."""
        if kind is not SetpointKind.PATH:
            return None
        if self._quadratic.chosen:
            return self._quadratic
        return self._thesis_tracking if self._parameters["WP_LAW"] == _THESIS else None

    def _without_bias(self, law: ThesisTracking | QuadraticTracking, setpoint: Setpoint, nav: NavState, dt_s: float) -> Wrench:
        """A law with integrals of its own, which knows neither wind nor what the thrusters achieve."""
        self._demanded = None
        wrench = law.update(setpoint, nav, dt_s)
        if not finite(wrench):
            law.start()
            return ZERO_WRENCH
        return self._saturated(wrench)

    def _as_in_the_thesis(self, setpoint: Setpoint, nav: NavState, dt_s: float) -> Wrench:
        """Neither wind nor what the thrusters achieve is known to that law."""
        self._demanded = None
        wrench = self._thesis.update(setpoint, nav, dt_s)
        if not finite(wrench):
            self._by_thesis = False
            self.reset()
            return ZERO_WRENCH
        return self._saturated(wrench)

    @staticmethod
    def _learning(kind: SetpointKind, demanded: Wrench, achieved: Wrench) -> Wrench:
        """The demand on the axes whose bias the law now learns; on the others nothing falls short."""
        if kind is SetpointKind.POSE:
            return demanded
        surge = demanded.surge_n if kind is SetpointKind.PATH else achieved.surge_n
        return Wrench(surge, achieved.sway_n, demanded.yaw_nm)

    def _against_wind(self, wrench: Wrench, kind: SetpointKind, nav: NavState) -> Wrench:
        """The wrench plus what counters the wind; forces that the stick asks for are left as they are."""
        x, y, n = wind_force(self._config.windage, self._config.length_m, nav)
        if kind is SetpointKind.HEADING:
            return Wrench(wrench.surge_n, wrench.sway_n, wrench.yaw_nm - n)
        return Wrench(wrench.surge_n - x, wrench.sway_n - y, wrench.yaw_nm - n)

    def _saturated(self, wrench: Wrench) -> Wrench:
        limits = self._config.limits
        return Wrench(
            min(limits.surge_n, max(-limits.surge_n, wrench.surge_n)),
            min(limits.sway_n, max(-limits.sway_n, wrench.sway_n)),
            min(limits.yaw_nm, max(-limits.yaw_nm, wrench.yaw_nm)),
        )
