"""Hold with a free heading: the bow turns to the heading of least thrust.

Wind and current push a hull sideways many times harder than from ahead. Where the mean force to give lies along the
hull, ahead, the thrust is about the least (weather optimal positioning, Fossen and Strand 2001). The bow turns slowly
towards that force, which is known by the thrust itself: neither anemometer nor a measured current is needed.

A boat that is driven off its point with all its sideways thrust, or whose thrusters give less than half of what it asks
sideways, as those that are left after a failure, gives up any heading: bow on it holds several times as much. The bow
then turns to where the weather comes from, by the force that it takes at rest; after a failure, to the force that the
boat asks for, which leads it back to its point. A boat that knows of a failed thruster does not wait until it has
drifted out of its watch circle, where it would leave that during the turn. Near a fence half of the room there
counts in place of the watch circle.
"""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.core.decision import ModeInputs, TextKind
from companion.core.estimate import NavState, without_waves
from companion.core.events import EventLog
from companion.core.frames import body_to_ned, ned_to_body
from companion.fence.guard import FenceGuard
from companion.params.store import Parameters
from companion.positioning.weather_force import WeatherForce

_MEAN_S = 15.0
_SETTLE_S = 30.0  # after the start, before the mean counts
_TURN_S = 120.0  # in which the bow would turn by the angle of the force; this one changes several times as fast
_BEGIN_RAD, _END_RAD = math.radians(6.0), math.radians(2.0)  # of the force off the bow, to begin and end a turn
# The same while driven off: what is known of the weather leads the bow to it from the near side.
_DRIVEN_BEGIN_RAD, _DRIVEN_END_RAD = math.radians(2.0), math.radians(1.0)
# Driven off: share of the sideways limit in the mean; _MEAN_S, which the turn must not outrun; _SETTLE_S.
_DRIVEN_SHARE, _DRIVEN_MEAN_S, _DRIVEN_SETTLE_S = 0.7, 10.0, 5.0
_LEAVES_MPS = 0.05  # away from its point, outside the watch circle
_FENCE_SHARE = 0.5  # of the room between its point and the fence: further off, it is driven off
_FAST_S = 60.0  # that the bow turns directly, after the heading was given up and outside the watch circle
_MISSING_SHARE, _MISSING_LEAST = 0.5, 0.1  # too little thrust: missing of the mean demand; of the sideways limit
_CALM_SHARE = 0.005  # of the limits: a smaller force has no direction


class Weathervane:
    """`update` every tick while a point is held. Remembers whether the operator gave a heading, the mean force (north,
    east), whether the bow turns, the means of the sideways demand and of what is missing of it, both without their
    sign, the force of the weather, whether the boat is driven off, whether it lacks thrust, with which thrusters failed
    and from which heading, until when it turns back to that, when it was last outside its watch circle, and what was
    announced."""

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        events: EventLog,
        mode: str = "Hold",
        fence: FenceGuard | None = None,
    ) -> None:
        """`mode`: the one that holds, for the texts."""
        self._mode, self._fence = mode, fence
        self._surge_n, self._sway_n = config.limits.surge_n, config.limits.sway_n
        self._parameters = parameters
        self._events = events
        self._given = False
        self._weather = WeatherForce(config.hull)
        self._announced = self._driven = self._lacked = False
        self._out_s = self._turns_back_s = -math.inf
        self._sideways_n = self._missing_n = 0.0
        self._asked = 0.0, 0.0
        self._without: frozenset[int] = frozenset()
        self._kept_rad: float | None = None
        self._taken_back = False
        self.restart()

    @property
    def driven_off(self) -> bool:
        """Whether a heading was given up since the boat was driven off its point."""
        return self._driven

    @property
    def turning(self) -> bool:
        """Whether the bow turns to the weather."""
        return self._turning

    def free(self) -> None:
        """Hold begins: nobody has given a heading."""
        self._given = self._driven = self._taken_back = False
        self._sideways_n = self._missing_n = 0.0
        self.restart()

    def give(self, now_s: float | None = None) -> None:
        """The operator has given a heading. `now_s`: announce that the bow no longer turns; None: the command's own
        answer tells it."""
        self._given, self._driven, self._taken_back = True, False, False
        if self._announced and now_s is not None:
            self._events.say(
                now_s, TextKind.ROUTINE, "weathervane", f"{self._mode}: heading held, as the operator gave one"
            )
        self._announced = False

    def restart(self) -> None:
        """Another point is held: take the mean anew."""
        self._mean = (0.0, 0.0)
        self._taken_s = 0.0
        self._turning = False

    def see(self, inputs: ModeInputs, place: tuple[float, float], left: bool, alarmed: bool) -> None:
        """Every tick while a point is held or led to. `place`: where the boat should be (north_m, east_m); `left`: it
        is outside the watch circle about that; `alarmed`: it is outside the alarm circle, or does not come to the
        point."""
        self._weather.see(inputs.nav, inputs.achieved, inputs.dt_s)
        share, asked_n = inputs.dt_s / (inputs.dt_s + _DRIVEN_MEAN_S), abs(inputs.demanded.sway_n)
        given_n = math.copysign(inputs.achieved.sway_n, inputs.achieved.sway_n * inputs.demanded.sway_n)
        self._sideways_n += share * (asked_n - self._sideways_n)
        self._missing_n += share * (max(0.0, asked_n - given_n) - self._missing_n)
        self._asked = _nearer(self._asked, inputs.demanded, inputs.nav.yaw_rad, share)
        if left:
            self._out_s = inputs.now_s
        if self._driven:
            self._see_thrusters(inputs)
        elif self._lacks(inputs.now_s) and (left or (inputs.failed and self._will_leave(inputs.nav, place))):
            self._give_up(inputs, "too little sway thrust: bow to weather", True)
        elif self._pushes_hard and (alarmed or self._is_driven(inputs.nav, place, left)):
            self._give_up(inputs, "driven off sideways: bow turns to weather", False)

    @property
    def _pushes_hard(self) -> bool:
        """Whether it has nearly no sideways thrust left."""
        return self._sideways_n > _DRIVEN_SHARE * self._sway_n > 0.0

    def _is_driven(self, nav: NavState, place: tuple[float, float], left: bool) -> bool:
        """Whether the boat leaves its watch circle, or near a fence its share of the room there."""
        if not _leaves(nav, place):
            return False
        off_m = math.hypot(nav.north_m - place[0], nav.east_m - place[1])
        return left or (self._fence is not None and off_m > _FENCE_SHARE * self._fence.room_about_m(place))

    def see_way(self, inputs: ModeInputs, reference: tuple[float, float]) -> None:
        """As `see`, on the way to a point: the boat should be where its reference is."""
        off_m = math.dist((inputs.nav.north_m, inputs.nav.east_m), reference)
        self.see(inputs, reference, off_m > self._parameters["DP_WATCH_R"], False)

    def _lacks(self, now_s: float) -> bool:
        """Whether the thrusters give far less sideways than is asked; not known while the heading is taken back."""
        if now_s <= self._turns_back_s:
            return False
        return self._missing_n > max(_MISSING_SHARE * self._sideways_n, _MISSING_LEAST * self._sway_n) > 0.0

    def _will_leave(self, nav: NavState, place: tuple[float, float]) -> bool:
        """Whether the boat drifts out of its watch circle while its bow comes round by a right angle, unhurried."""
        turn_s = 0.5 * math.pi / math.radians(self._parameters["DP_YAW_RATE"])
        off_m = math.dist((nav.north_m, nav.east_m), place)
        return off_m + turn_s * _leaving_mps(nav, place) > self._parameters["DP_WATCH_R"]

    def _give_up(self, inputs: ModeInputs, why: str, lacked: bool) -> None:
        self._driven, self._lacked, self._out_s, self._without = True, lacked, inputs.now_s, inputs.failed
        self.restart()
        if lacked and inputs.failed:  # what it asks for has been known since before
            self._mean, self._taken_s = self._asked, _DRIVEN_MEAN_S
        self._events.say(inputs.now_s, TextKind.ALARM, "driven_off", f"{self._mode}: {why}")

    def _see_thrusters(self, inputs: ModeInputs) -> None:
        """With the thrusters that it lacked the boat takes its heading back. They are needed for the turn, and turn
        themselves: until that is over, what they do not give sideways tells nothing."""
        if self._without and not inputs.failed:
            self._driven, self._taken_back = False, True
            turn_rad = 0.0 if self._kept_rad is None else abs(wrap_pi(self._kept_rad - inputs.nav.yaw_rad))
            turn_s = turn_rad / math.radians(self._parameters["DP_YAW_RATE"])
            self._turns_back_s = inputs.now_s + turn_s + _DRIVEN_MEAN_S
            self._sideways_n = self._missing_n = 0.0
            text = f"{self._mode}: all thrusters work: holds heading again"
            self._events.say(inputs.now_s, TextKind.ROUTINE, "heading_taken_back", text)

    def update(self, inputs: ModeInputs, held_rad: float) -> float | None:
        """The heading to hold from now on; None: `held_rad` stays."""
        if self._taken_back:
            self._taken_back = False
            return self._kept_rad
        if not self._driven:
            self._kept_rad = held_rad
        if not self._active(inputs.now_s):
            return None
        if not self._is_mean_known(inputs):
            return None
        off_rad = self._off_rad(inputs.nav.yaw_rad)
        by_weather = self._driven and not self._lacked
        begin_rad, end_rad = (_DRIVEN_BEGIN_RAD, _DRIVEN_END_RAD) if by_weather else (_BEGIN_RAD, _END_RAD)
        self._turning = abs(off_rad) > (end_rad if self._turning else begin_rad)
        if not self._turning:
            return None
        fast = self._driven and inputs.now_s - self._out_s < _FAST_S
        return wrap_pi(inputs.nav.yaw_rad + off_rad if fast else held_rad + off_rad * inputs.dt_s / _TURN_S)

    def _active(self, now_s: float) -> bool:
        """Whether the heading is free; announces it."""
        if self._driven:
            return True
        if self._given or self._sway_n <= 0.0 or not self._parameters["DP_WEATHERVANE"]:
            self._announced = False
            self.restart()
            return False
        if not self._announced:
            self._announced = True
            self._events.say(
                now_s, TextKind.ROUTINE, "weathervane", f"{self._mode}: heading free, bow turns to the weather"
            )
        return True

    def _is_mean_known(self, inputs: ModeInputs) -> bool:
        """Whether there is a mean force after this tick."""
        weather = self._weather.into
        if self._driven and weather is not None and self._suffices(weather):
            self._mean = weather
            return True
        self._take_mean(inputs)
        return self._taken_s >= (_DRIVEN_SETTLE_S if self._driven else _SETTLE_S)

    def _suffices(self, weather: tuple[float, float]) -> bool:
        """Whether the boat comes back to its point with its bow to that force: not without the thrusters that failed,
        nor where there is hardly any force."""
        if not self._lacked:
            return True
        return not self._without and math.hypot(*weather) > _CALM_SHARE * self._surge_n

    def _take_mean(self, inputs: ModeInputs) -> None:
        self._taken_s += inputs.dt_s
        mean_s = _DRIVEN_MEAN_S if self._driven else _MEAN_S
        share = inputs.dt_s / min(mean_s, max(self._taken_s, inputs.dt_s)) if inputs.dt_s > 0.0 else 0.0
        force = inputs.demanded if self._driven else inputs.achieved  # driven off, the thrusters do not give it
        self._mean = _nearer(self._mean, force, inputs.nav.yaw_rad, share)

    def _off_rad(self, yaw_rad: float) -> float:
        """Direction of the mean force from the bow; 0 in calm."""
        x, y = ned_to_body(*self._mean, yaw_rad)
        if abs(y) < _CALM_SHARE * self._sway_n and x > -_CALM_SHARE * self._surge_n:
            return 0.0
        return math.atan2(y, x)


def _nearer(mean: tuple[float, float], force: Wrench, yaw_rad: float, share: float) -> tuple[float, float]:
    """A mean force (north, east), by that share nearer to another one."""
    north, east = body_to_ned(force.surge_n, force.sway_n, yaw_rad)
    return mean[0] + share * (north - mean[0]), mean[1] + share * (east - mean[1])


def _leaves(nav: NavState, place: tuple[float, float]) -> bool:
    """Whether the boat moves away from the place."""
    return _leaving_mps(nav, place) > _LEAVES_MPS


def _leaving_mps(nav: NavState, place: tuple[float, float]) -> float:
    """Speed away from the place; 0 at it."""
    nav = without_waves(nav)
    north_m, east_m = nav.north_m - place[0], nav.east_m - place[1]
    off_m = math.hypot(north_m, east_m)
    return (nav.north_mps * north_m + nav.east_mps * east_m) / off_m if off_m > 0.0 else 0.0
