"""From where a boat is to go to what the wind allows: beating against it, tacks and gybes, and what drive is wanted.

A course inside the no-go zone is sailed close-hauled on one tack and the other, inside a corridor either side of the
line between waypoints; the boat tacks for the waypoint where the other tack leads there, at the edge of the corridor,
before the fence, and as asked. With the motors beside the sail the boat goes straight to where it is to go.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.decision import TextKind
from companion.core.estimate import NavState, Rig, through_water
from companion.core.events import Announce
from companion.core.setpoint import (
    HeadingSetpoint,
    NeutralSetpoint,
    PathSetpoint,
    PoseSetpoint,
    Setpoint,
    ThrusterSetpoint,
)
from companion.guidance.sail_motor import SailMotor
from companion.guidance.sail_turn import SailTurn
from companion.guidance.sail_way import SailWay
from companion.guidance.sail_wind import SailWind
from companion.params.store import Parameters

Place = tuple[float, float]

_LEEWAY_RAD = math.radians(8.0)  # close-hauled, until the boat's own is known
_FETCH_RAD = math.radians(3.0)  # by which a goal must lie outside the no-go zone before the boat goes straight there
_OTHER_TACK_RAD = math.radians(15.0)  # by which the other tack must lead nearer to the goal for a beat to begin on it
_RECENT_S = 8.0  # after a tack, in which the boat gathers way
_CRAB_S = 4.0  # time constant of the angle between bow and course
_MOST_CRAB_RAD = math.radians(25.0)
_LEAST_WAY_MPS, _TURNS_RADPS = 0.5, 0.3  # slower, or turning faster, the boat has no course to learn from
_HELM_S, _MOST_HELM_RAD = 6.0, math.radians(25.0)  # time constant and most of the learned weather helm
_TURN_RAD = math.radians(35.0)  # a larger error of the heading is a turn
_LOOK_AHEAD = 6.0  # boat's lengths, to come back to a line
_FASTER_1PS = 0.5  # of the mass: force for each m/s that is missing
_ABEAM_RAD = math.radians(70.0)  # of the goal off the line: a boat that has missed it sails back to it
_FENCE_S = 6.0  # of way ahead that must be clear, and two boat's lengths
_STARBOARD, _PORT = 1.0, -1.0  # side that the wind comes from
_NAMES = {_STARBOARD: "starboard tack", _PORT: "port tack"}


class Sailor:
    """`steer(setpoint, …)` once a tick: the setpoint with a heading that can be sailed, and with drive in place of
    speed.

    Remembers the tack, since when it is on it, whether it beats, the angle between bow and course, the weather helm,
    whether it gathers way, and whether an operator has asked for a tack.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        say: Announce,
        is_open: Callable[[Place, Place], bool],
    ) -> None:
        """`is_open(a, b)`: whether the fence lets the boat go from a to b."""
        self._config, self._parameters = config, parameters
        self._say, self._is_open = say, is_open
        self._wind = SailWind(parameters, say)
        self._motor = SailMotor(config, parameters, say)
        self._turn = SailTurn(parameters, self._wind, say)
        self._way = SailWay()
        self._tack = _STARBOARD
        self._since_s = 0.0
        self._beats = self._asked = False
        self._crab_rad = self._helm_rad = 0.0

    @property
    def rig(self) -> Rig:
        """The last wind over ground, to trim the sail by, and whether sail and motors are used."""
        return Rig(self._wind.air, not self._motor.alone, self._motor.drives)

    @property
    def has_motor(self) -> bool:
        """Whether there is a motor beside the sail."""
        return self._motor.exists

    @property
    def beats(self) -> bool:
        """Whether the boat beats against the wind now."""
        return self._beats

    def ask_tack(self) -> bool:
        """Go about now. Returns whether the boat beats, so that it can."""
        self._asked = self._beats
        return self._beats

    def steer(self, setpoint: Setpoint, nav: NavState, now_s: float, dt_s: float) -> Setpoint:
        """The setpoint that can be sailed. Wrenches stay as they are. Of thruster demands those of the sheet, or of
        motors, become 0 while they are not used."""
        self._wind.update(nav, now_s, dt_s)
        self._motor.update(self._wind, now_s)
        if isinstance(setpoint, PoseSetpoint):
            bearing_rad = math.atan2(setpoint.east_m - nav.east_m, setpoint.north_m - nav.north_m)
            setpoint = PathSetpoint(bearing_rad, setpoint.surge_mps, progress=setpoint.progress)
        if isinstance(setpoint, PathSetpoint) and setpoint.by_rate:
            setpoint = self._at_rate(setpoint, nav)
        if not isinstance(setpoint, PathSetpoint) or self._motor.drives:
            self._beats = self._asked = False
            self._turn.reset()
            self._way.reset()
            if isinstance(setpoint, PathSetpoint):
                return self._by_motor(setpoint, nav, dt_s)
            if isinstance(setpoint, ThrusterSetpoint):
                return self._by_hand(setpoint)
            return self._held(setpoint, nav, dt_s) if isinstance(setpoint, HeadingSetpoint) else setpoint
        if not self._wind.known:
            return NeutralSetpoint(setpoint.progress)
        self._learn_crab(nav, dt_s)
        yaw_rad = self._sailable(setpoint, nav, now_s)
        if not self._turn.turns:
            yaw_rad = self._way.heading(yaw_rad, self._wind.from_rad, nav, dt_s)
        yaw_rad = self._turn.heading(yaw_rad, self._no_go_rad, nav, now_s)
        yaw_rad = self._with_helm(yaw_rad, nav, dt_s)
        gathers = self._way.gathers or self._turn.gathers
        drive_n = self._config.limits.surge_n if gathers else self._drive_n(setpoint.surge_mps, nav)
        wrench = ZERO_WRENCH if self._turn.luffs(nav) else Wrench(drive_n, 0.0, 0.0)
        return HeadingSetpoint(yaw_rad, wrench, progress=setpoint.progress)

    def _at_rate(self, setpoint: PathSetpoint, nav: NavState) -> HeadingSetpoint | NeutralSetpoint:
        """A turn rate of the sticks, with the drive for their speed."""
        if not self._wind.known and not self._motor.drives:
            return NeutralSetpoint(setpoint.progress)
        wrench = Wrench(self._drive_n(setpoint.surge_mps, nav), 0.0, 0.0)
        return HeadingSetpoint(setpoint.yaw_rad, wrench, setpoint.yaw_rate_radps, setpoint.progress)

    def _by_motor(self, setpoint: PathSetpoint, nav: NavState, dt_s: float) -> HeadingSetpoint:
        """Straight to the goal, whatever the wind."""
        self._learn_crab(nav, dt_s)
        yaw_rad = self._with_helm(wrap_pi(self._towards(setpoint, nav) - self._crab_rad), nav, dt_s)
        return HeadingSetpoint(
            yaw_rad, Wrench(self._drive_n(setpoint.surge_mps, nav), 0.0, 0.0), progress=setpoint.progress
        )

    def _by_hand(self, setpoint: ThrusterSetpoint) -> ThrusterSetpoint:
        """The sticks' demands, without those of motors or sheet that are not used now."""
        if not setpoint.thrusters:
            return setpoint
        sheet, *motors = setpoint.thrusters
        if self._motor.alone:
            sheet = replace(sheet, force_n=0.0, throttle=0.0)
        if not self._motor.drives:
            motors = [replace(motor, force_n=0.0, throttle=0.0) for motor in motors]
        return replace(setpoint, thrusters=(sheet, *motors))

    def _with_helm(self, yaw_rad: float, nav: NavState, dt_s: float) -> float:
        """The heading with what the boat steers off by its weather helm. That changes its side with the tack, so it is
        learned here, and the yaw loop of a boat with a sail learns nothing."""
        side = math.copysign(1.0, wrap_pi(self._wind.from_rad - nav.yaw_rad))
        off_rad = wrap_pi(yaw_rad - nav.yaw_rad)
        if abs(off_rad) < _TURN_RAD and nav.surge_mps > _LEAST_WAY_MPS and not self._turn.turns:
            helm_rad = self._helm_rad + dt_s / _HELM_S * side * off_rad
            self._helm_rad = min(_MOST_HELM_RAD, max(-_MOST_HELM_RAD, helm_rad))
        return wrap_pi(yaw_rad + side * self._helm_rad)

    @property
    def _no_go_rad(self) -> float:
        return math.radians(self._parameters["SAIL_NO_GO_ANGLE"])

    def _held(self, setpoint: HeadingSetpoint, nav: NavState, dt_s: float) -> HeadingSetpoint:
        """A heading of the sticks, no closer to the wind than the boat sails."""
        if not self._wind.known or self._motor.drives or setpoint.wrench.surge_n <= 0.0:
            return setpoint
        yaw_rad, rate_radps = setpoint.yaw_rad, setpoint.yaw_rate_radps
        off_rad = wrap_pi(yaw_rad - self._wind.from_rad)
        if abs(off_rad) < self._no_go_rad:
            yaw_rad, rate_radps = wrap_pi(self._wind.from_rad + math.copysign(self._no_go_rad, off_rad)), 0.0
        return HeadingSetpoint(self._with_helm(yaw_rad, nav, dt_s), setpoint.wrench, rate_radps, setpoint.progress)

    def _learn_crab(self, nav: NavState, dt_s: float) -> None:
        """The angle from the bow to the course over ground, by leeway and current."""
        if nav.surge_mps < _LEAST_WAY_MPS or self._turn.tacks or abs(nav.yaw_rate_radps) > _TURNS_RADPS:
            return
        crab_rad = wrap_pi(math.atan2(nav.east_mps, nav.north_mps) - nav.yaw_rad)
        bounded = min(_MOST_CRAB_RAD, max(-_MOST_CRAB_RAD, crab_rad))
        self._crab_rad += dt_s / (dt_s + _CRAB_S) * (bounded - self._crab_rad)

    def _sailable(self, setpoint: PathSetpoint, nav: NavState, now_s: float) -> float:
        """The heading to sail: straight to the goal, or close-hauled."""
        wind_rad, no_go = self._wind.from_rad, self._no_go_rad
        off_rad = wrap_pi(setpoint.yaw_rad - wind_rad)  # of the goal from the wind, positive to its right
        more = max(_LEEWAY_RAD, abs(self._crab_rad)) + _FETCH_RAD if self._beats else 0.0
        if abs(off_rad) >= no_go + more:
            self._beats = self._asked = False
            yaw_rad = wrap_pi(self._towards(setpoint, nav) - self._crab_rad)
            return yaw_rad if self._is_free(yaw_rad) else wrap_pi(wind_rad + math.copysign(no_go, off_rad))
        if not self._beats:
            self._begin_beat(off_rad, setpoint.progress.course_rad is not None, nav, now_s)
        self._mind_tack(setpoint, nav, now_s)
        return wrap_pi(wind_rad - self._tack * no_go)

    def _is_free(self, yaw_rad: float) -> bool:
        return abs(wrap_pi(yaw_rad - self._wind.from_rad)) >= self._no_go_rad

    def _towards(self, setpoint: PathSetpoint, nav: NavState) -> float:
        """The course to the goal, back onto the line between the waypoints where there is one and the goal lies
        ahead."""
        progress = setpoint.progress
        if progress.course_rad is None or progress.cross_track_error_m is None or progress.distance_to_go_m is None:
            return setpoint.yaw_rad
        if abs(wrap_pi(setpoint.yaw_rad - progress.course_rad)) > _ABEAM_RAD:
            return setpoint.yaw_rad
        ahead_m = min(_LOOK_AHEAD * self._config.length_m, max(1.0, progress.distance_to_go_m))
        return wrap_pi(progress.course_rad - math.atan2(progress.cross_track_error_m, ahead_m))

    def _begin_beat(self, off_rad: float, on_leg: bool, nav: NavState, now_s: float) -> None:
        """Beat on the present tack, unless the other leads much nearer to the goal."""
        self._tack = math.copysign(1.0, wrap_pi(self._wind.from_rad - nav.yaw_rad))
        if self._tack * off_rad > _OTHER_TACK_RAD:
            self._tack = -self._tack
        self._beats, self._since_s = True, now_s
        if on_leg:
            self._say(now_s, TextKind.ROUTINE, "beating", f"Beating, {_NAMES[self._tack]}")

    def _mind_tack(self, setpoint: PathSetpoint, nav: NavState, now_s: float) -> None:
        """Go about at the edge of the corridor, before the fence, or as asked."""
        if now_s - self._since_s < _RECENT_S or self._turn.tacks:
            return
        if self._asked or self._leaves_corridor(setpoint) or self._is_stopped_by_fence(nav):
            self._asked = False
            self._tack, self._since_s = -self._tack, now_s
            self._say(now_s, TextKind.ROUTINE, "tacking", f"Tacking: {_NAMES[self._tack]}")

    def _leaves_corridor(self, setpoint: PathSetpoint) -> bool:
        progress = setpoint.progress
        if progress.course_rad is None or progress.cross_track_error_m is None:
            return False
        heading_rad = self._wind.from_rad - self._tack * self._no_go_rad
        leads = math.copysign(1.0, math.sin(heading_rad - progress.course_rad))
        return leads * progress.cross_track_error_m > self._parameters["SAIL_XTRACK"]

    def _is_stopped_by_fence(self, nav: NavState) -> bool:
        """Whether this tack leads out of the fence soon, and the other does not."""
        way_m = _FENCE_S * math.hypot(nav.north_mps, nav.east_mps) + 2.0 * self._config.length_m
        here = (nav.north_m, nav.east_m)
        off_rad = self._no_go_rad + _LEEWAY_RAD
        present, other = (self._wind.from_rad - tack * off_rad for tack in (self._tack, -self._tack))
        ends = [(here[0] + way_m * math.cos(rad), here[1] + way_m * math.sin(rad)) for rad in (present, other)]
        return not self._is_open(here, ends[0]) and self._is_open(here, ends[1])

    def _drive_n(self, wanted_mps: float, nav: NavState) -> float:
        """Force ahead for a speed, through the water where the current is known."""
        if wanted_mps <= 0.0:
            return 0.0
        hull = self._config.hull
        force_n = hull.drag_n(wanted_mps) + _FASTER_1PS * hull.m11_kg * (wanted_mps - through_water(nav)[0])
        return min(self._config.limits.surge_n, max(0.0, force_n))
