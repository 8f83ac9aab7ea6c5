"""Holding a point with thrust ahead and astern and a turn, but none sideways: the boat lies as at an anchor."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.allocation.astern import stern_first_mps
from companion.config.blades import without_blades
from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState, without_waves
from companion.core.readings import ManualInput
from companion.core.setpoint import PathSetpoint, Point, Progress, Setpoint, WrenchSetpoint
from companion.fence.guard import FenceGuard
from companion.guidance.bend_speed import steady_turn_radps
from companion.guidance.stopping import stopping_point
from companion.params.store import Parameters
from companion.positioning.beam_drift import BeamDrift
from companion.positioning.stop import Stop
from companion.positioning.straight_astern import straight_astern

_REST_MPS = 0.2  # along the hull: slow enough to hold where the boat is
_LEEWAY = 0.03  # share of the wind speed at which wind alone moves a small boat
_LEAST_DRIFT_MPS = 0.06
# Of the least drift that has a direction: so much has one still, once it had. At a receiver's rate, its accuracy goes
# up and down.
_STILL_SHARE = 0.8
_DRIFT_TIME_S = 15.0
_WRONG_RAD, _RIGHT_RAD = math.radians(75.0), math.radians(20.0)  # from the weather: to begin and end a turn
_TURNING_RAD = math.radians(60.0)  # off its heading, a boat first turns
_STEEPEST_RAD = math.radians(46.0)
_TURN_RADPS = math.radians(12.0)
_SWING_SROOT = 4.0  # time in which half of an offset across the bow is swung away, over √length: yaw must be faster
_DAMPING_SHARE = 0.5  # of that time, by which the sideways motion is looked ahead
_SETTLE_SHARE = 8.0  # of that time, in which the heading to lie at learns what is left
# Further from the drift that it has felt, the heading to lie at comes back instead, at a radian over the second times
# that time: a faster turn would push the boat aside.
_ASTRAY_RAD, _ASTRAY_SHARE = math.radians(25.0), 4.0
_LEAD_SHARE = 0.5  # of that time: on its way back it steers from where its sideways motion will have taken it
_RETURN_RATE_1PS = 0.25
_OUT_SHARE, _BACK_SHARE = 0.9, 0.5  # of the watch circle
_CALM_OUT_SHARE, _CALM_BACK_SHARE = 0.5, 0.15  # the same without a drift that would swing the boat back
_STEERAGE_SHARE = 0.3  # of the speed, kept while the bow points elsewhere by a boat that steers by its thrust
_LEAST_LINE_M = 1.0
# A boat that has long gone round its point so fast, and sideways through the water so fast, chases its own bow: it
# stops pushing until one of both is that share of it.
_ROUND_RADPS, _SIDEWAYS_MPS, _ROUND_S, _SETTLED_SHARE = 0.2, 0.3, 3.0, 0.5
_AT_POINT_M = 0.5
_MOMENT_SHARE = 0.7  # of the yaw moment, for a turn in the stream
_LAG_S, _MORE_S = 1.5, 2.0  # of a turn; and for how much more of the drift there must be room before it begins
_TURN_LENGTHS = 3.0  # boat's lengths that a rudder needs ahead to turn the boat round
_PUSHED_LENGTHS = 1.5  # the same for a lone thruster that turns the boat by its direction, and pushes it meanwhile
# Of the watch circle: so far upstream of the point a boat that steers by its flow stops pushing, until it is so far
# downstream. Further off than the last it sails back instead.
_COAST_UP_SHARE, _COAST_DOWN_SHARE, _COAST_OUT_SHARE = 0.15, 0.1, 1.2
_COAST_BESIDE_SHARE = 0.3  # of the watch circle: further aside the drift does not lead past the point


class BowKeeper:
    """A `Keeper` for a boat without sideways thrust that can go ahead and astern.

    The boat lies as if an anchor line a boat's length long led from the hold point upstream: the bow points to the
    anchor, and speed ahead or astern keeps the point. Current and thrust then carry the boat sideways to the point, as
    a pendulum. What offset is left across the bow turns the heading to lie at, slowly: the boat finds the heading at
    which the weather does not push it sideways (weather optimal positioning, Fossen and Strand 2001), with neither
    anemometer nor a measured current. The drift that the estimator knows only says which way is upstream.

    Beyond 0.9 of the watch circle, or where the boat drifts so fast that it would be there before the bow has come
    round (not of a boat with a rudder), the bow points to the hold point itself until the boat is well inside again.

    A lone thruster that steers by its direction pushes the boat as it turns it: the middle goes to one side, then the
    bow leads the boat to the other (nonminimum phase). Its keeper controls the point ahead of the middle that the push
    leaves in place, and lies bow to the drift that it has felt on the beam (`BeamDrift`): where wind and current oppose
    each other, the drift that the estimator knows may point the other way. Near the point a boat without a drift goes
    straight on, past it if need be. Where it goes round the point faster than its bow comes round, the thrust would
    keep it on that circle: it lets the water stop it first.

    A rudder steers only by thrust ahead, which drives the boat past its point. Upstream of the point such a boat stops
    its propeller and lets the drift carry it back; without a drift it lies still until it is far off.

    Under way, it first brakes with all its thrust astern, on its heading, and holds where it has come to rest; near a
    fence, so far inside that its watch circle is. A boat that lies across the stream turns its bow into it meanwhile.
    One whose bow points down the stream goes astern first, where the turn would carry it over a fence, and holds where
    it has room; so does one that moves on as it turns, with a rudder or a lone thruster, before a fence near ahead.

    Remembers the hold point, whether the boat itself chose that, the heading to lie at, the drift, how sure it is and
    whether it has a direction, whether the boat is stopping, coming back or going astern first, how long it has gone
    round the point, and whether it lets itself be carried.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, fence: FenceGuard | None = None) -> None:
        """`fence`: the boat holds so far inside that its watch circle is."""
        self._parameters = parameters
        self._fence = fence
        self._shortest_m = max(_LEAST_LINE_M, config.length_m)
        self._swing_s = _SWING_SROOT * math.sqrt(config.length_m)
        self._steerage = _STEERAGE_SHARE if any(t.turns for t in without_blades(config.thrusters)) else 0.0
        self._needs_flow = config.has_rudder
        most_mps = stern_first_mps(config)
        self._astern_mps = most_mps if math.isfinite(most_mps) else 0.0
        self._hull, self._turning_nm = config.hull, _MOMENT_SHARE * config.limits.yaw_nm
        self._steers_alone = len(config.thrusters) == 1 and not self._needs_flow
        lengths = _TURN_LENGTHS if self._needs_flow else _PUSHED_LENGTHS if self._steers_alone else 0.0
        self._turn_m = lengths * self._shortest_m
        self._point = (0.0, 0.0)
        self._own_point = False
        self._lie_rad = self._heading_rad = 0.0
        self._beam = BeamDrift(config) if self._steers_alone else None
        self._pivot_m = self._beam.pivot_m if self._beam is not None else 0.0
        self._drift = self._stream = (0.0, 0.0)  # where it is carried across, and what the estimator tells of it
        self._least_mps = self._sure_mps = _LEAST_DRIFT_MPS  # that has a direction; of the estimator's
        self._drifts = False
        self._returning = self._nearing = self._turning = self._coasting = self._astern = False
        self._round_s = 0.0
        self._arrived = False
        self._stop = Stop(_REST_MPS)

    @property
    def arrived(self) -> bool:
        """Whether the boat has been inside the watch circle since the point was set."""
        return self._arrived

    @property
    def target(self) -> tuple[float, float, float]:
        """(north_m, east_m, yaw_rad): the hold point and the heading to lie at."""
        return (*self._point, self._lie_rad)

    def start(self, nav: NavState, fitted: NavState | None = None) -> None:
        """Brake, and hold the point where the boat comes to rest."""
        self._point, self._own_point = stopping_point(fitted or nav, self._parameters), True
        self._stop.begin(nav, self._point, math.inf if fitted is None else self._parameters["DP_SPEED_AHEAD"])
        if not self._stop.lasts:  # no thrust brakes a drift aside: it holds where it is
            self._point = self._held((nav.north_m, nav.east_m))
        self._heading_rad = nav.yaw_rad
        self._drift, self._drifts = _drift(nav) or (0.0, 0.0), False
        self._stream = self._drift
        if self._beam is not None:
            self._beam.begin(self._drift)
        self._least_mps = self._sure_mps = _least_drift_mps(nav)
        self._see_direction()
        upstream = self._upstream_rad()
        self._lie_rad = nav.yaw_rad if upstream is None else upstream
        self._returning = self._nearing = self._turning = self._coasting = self._astern = self._arrived = False
        self._round_s = 0.0

    def hold(
        self, north_m: float, east_m: float, yaw_rad: float, speed_mps: float | None, hurries: bool = False
    ) -> None:
        """Hold another point. Heading, speed and hurry are ignored: this boat cannot hold a heading."""
        self._point, self._own_point = (north_m, east_m), False
        self._stop.end()
        self._arrived = False

    def update(self, nav: NavState, stick: ManualInput | None, speed_mps: float, dt_s: float) -> Setpoint:
        """A path setpoint, at `speed_mps` at most; zero thrust while the boat lets itself be carried or stopped."""
        seen, nav = nav, without_waves(nav)
        self._see_drift(nav, dt_s)
        if self._stop.lasts:
            # hard braking is taken for waves for a while: a boat at rest went on braking, and was carried off
            slower = seen if abs(seen.surge_mps) < abs(nav.surge_mps) else nav
            rest = self._stop.place(slower, self._along_mps(nav))
            self._point = self._point if rest is None else self._held(rest)
        north_m, east_m = self._point[0] - nav.north_m, self._point[1] - nav.east_m
        distance_m = math.hypot(north_m, east_m)
        place = Point(*self._point)
        progress = Progress(place=place, target=place, distance_to_go_m=distance_m)
        if self._stop.lasts:
            # a rudder would hold the heading by thrust ahead: it brakes on whatever heading it has
            yaw_rad = nav.yaw_rad if self._needs_flow else self._braking_rad(nav)
            return PathSetpoint(yaw_rad, 0.0, progress=progress)
        if self._goes_astern_first(nav):
            return self._astern_first(nav, progress)
        self._judge(nav, distance_m, self._inward_m2ps(nav, north_m, east_m))
        stands = self._is_carried(north_m, east_m) if self._needs_flow else self._slides(nav, north_m, east_m, dt_s)
        if stands:
            return WrenchSetpoint(ZERO_WRENCH, replace(progress, yaw_rad=self._heading_rad))
        ahead_mps = min(speed_mps, self._parameters["DP_SPEED_AHEAD"])
        if self._returning:
            back_mps = min(ahead_mps, _RETURN_RATE_1PS * distance_m)
            bearing = self._bearing_rad(nav, north_m, east_m)
            upstream = self._upstream_rad()
            self._heading_rad = bearing if upstream is None else self._back_rad(bearing, back_mps)
            self._lie_rad = bearing if upstream is None else upstream
            aligned = 2.0 * math.cos(wrap_pi(self._heading_rad - nav.yaw_rad)) - 1.0
            along = max(0.0, math.cos(wrap_pi(self._heading_rad - bearing)))
            surge_mps = back_mps * max(self._steerage, aligned * along)
            if self._backs(nav, bearing):
                return self._straight_astern(nav, progress)
        else:
            self._heading_rad = self._lie(nav, north_m, east_m, dt_s)
            along_m = north_m * math.cos(nav.yaw_rad) + east_m * math.sin(nav.yaw_rad)
            surge_mps = min(ahead_mps, max(-self._parameters["DP_SPEED_ASTERN"], _RETURN_RATE_1PS * along_m))
        if abs(wrap_pi(self._heading_rad - nav.yaw_rad)) > _TURNING_RAD:
            surge_mps = max(surge_mps, self._carried_mps(nav))
        return PathSetpoint(self._heading_rad, surge_mps, progress=progress, keeps_place=True)

    def _inward_m2ps(self, nav: NavState, north_m: float, east_m: float) -> float:
        """The distance times the speed towards the point, of what the push of a turn leaves in place."""
        turned_mps = self._pivot_m * nav.yaw_rate_radps
        north_mps = nav.north_mps - turned_mps * math.sin(nav.yaw_rad)
        east_mps = nav.east_mps + turned_mps * math.cos(nav.yaw_rad)
        return north_mps * north_m + east_mps * east_m

    def _bearing_rad(self, nav: NavState, north_m: float, east_m: float) -> float:
        """The bearing of the point. A boat that cannot stop its sideways motion looks ahead by it, and without a drift
        it steers straight on where the point is near: its bearing changes faster than the boat can follow it."""
        bearing = math.atan2(east_m, north_m)
        if self._beam is None:
            return bearing
        distance_m = math.hypot(north_m, east_m)
        ahead = math.cos(wrap_pi(bearing - self._heading_rad)) > 0.5
        if ahead and not self._drifts and distance_m < self._shortest_m:
            return self._heading_rad
        c, s = math.cos(nav.yaw_rad), math.sin(nav.yaw_rad)
        sideways_mps = nav.east_mps * c - nav.north_mps * s + self._pivot_m * nav.yaw_rate_radps
        lead_m = min(distance_m, max(-distance_m, _LEAD_SHARE * self._swing_s * sideways_mps))
        return math.atan2(east_m - lead_m * c, north_m + lead_m * s)

    def _back_rad(self, bearing_rad: float, back_mps: float) -> float:
        """The heading on which the boat comes back along a bearing at `back_mps` over ground, against its drift."""
        north, east = self._drift
        return math.atan2(back_mps * math.sin(bearing_rad) - east, back_mps * math.cos(bearing_rad) - north)

    def _held(self, place: tuple[float, float]) -> tuple[float, float]:
        return place if self._fence is None else self._fence.held_place(place)

    def _backs(self, nav: NavState, bearing_rad: float) -> bool:
        """Whether a boat that moves on as it turns first goes astern: the point lies astern, and a fence so near ahead
        that it would be crossed in the turn. Between two lines it keeps to the middle."""
        if self._fence is None or math.cos(wrap_pi(bearing_rad - nav.yaw_rad)) >= 0.0:
            return False
        here = nav.north_m, nav.east_m
        ahead_m, astern_m = (self._fence.room_m(here, yaw_rad) for yaw_rad in (nav.yaw_rad, nav.yaw_rad + math.pi))
        return ahead_m < self._turn_m and ahead_m <= astern_m

    def _straight_astern(self, nav: NavState, progress: Progress) -> Setpoint:
        """Astern on the heading that the boat has; a rudder does not steer, which it would do by thrust ahead."""
        astern_mps = self._parameters["DP_SPEED_ASTERN"]
        if not self._needs_flow:
            return PathSetpoint(nav.yaw_rad, -astern_mps, progress=progress)
        progress = replace(progress, yaw_rad=nav.yaw_rad)
        return straight_astern(self._hull, self._parameters, nav, astern_mps, progress)

    def _goes_astern_first(self, nav: NavState) -> bool:
        """Whether the boat, with its bow down the stream, goes astern for room to turn: in the turn it would be carried
        over a fence."""
        upstream, drift_mps = self._upstream_rad(), math.hypot(*self._drift)
        off = 0.0 if upstream is None else abs(wrap_pi(upstream - nav.yaw_rad))
        if self._fence is None or upstream is None or off < 0.5 * math.pi or drift_mps >= self._astern_mps:
            self._astern = False
            return False
        turns_radps = steady_turn_radps(self._hull, drift_mps, self._turning_nm)  # while it is carried along
        rate_radps = min(turns_radps, math.radians(self._parameters["PATH_YAW_RATE"]))
        turn_s = off / rate_radps + _LAG_S + (_MORE_S if self._astern else 0.0)
        self._astern = self._fence.room_m((nav.north_m, nav.east_m), upstream + math.pi) < drift_mps * turn_s
        return self._astern

    def _astern_first(self, nav: NavState, progress: Progress) -> PathSetpoint:
        """Astern up the stream. A point that the boat itself chose comes along: there it has room."""
        if self._own_point:
            self._point = (nav.north_m, nav.east_m)
        downstream = math.atan2(self._drift[1], self._drift[0])
        return PathSetpoint(downstream, -self._parameters["DP_SPEED_ASTERN"], progress=progress)

    def _braking_rad(self, nav: NavState) -> float:
        """The heading on which the boat brakes: as it came, or into a stream that comes from ahead of the beam."""
        upstream = self._upstream_rad()
        if upstream is not None and abs(wrap_pi(upstream - nav.yaw_rad)) < 0.5 * math.pi:
            self._heading_rad = upstream
        return self._heading_rad

    def _slides(self, nav: NavState, north_m: float, east_m: float, dt_s: float) -> bool:
        """Whether the boat has long gone round its point by its own motion through the water. One that wind and stream
        keep where it is does not."""
        distance_m = max(_AT_POINT_M, math.hypot(north_m, east_m))
        north_mps, east_mps = nav.north_mps - self._stream[0], nav.east_mps - self._stream[1]
        through = north_m * east_mps - east_m * north_mps
        over_ground = north_m * nav.east_mps - east_m * nav.north_mps
        round_mps = min(abs(through), abs(over_ground)) / distance_m if through * over_ground > 0.0 else 0.0
        sideways_mps = abs(east_mps * math.cos(nav.yaw_rad) - north_mps * math.sin(nav.yaw_rad))
        share = _SETTLED_SHARE if self._round_s >= _ROUND_S else 1.0
        fast = round_mps > share * _ROUND_RADPS * distance_m and sideways_mps > share * _SIDEWAYS_MPS
        self._round_s = self._round_s + dt_s if fast else 0.0
        swept = self._returning and self._is_swept()  # it would lose what it has to win back
        return self._steers_alone and self._round_s >= _ROUND_S and not swept

    def _is_swept(self) -> bool:
        """Whether the estimator tells a drift that has a direction; a boat's own slide may be felt as one."""
        if self._beam is None:
            return self._drifts
        return math.hypot(*self._stream) >= self._sure_mps

    def _carried_mps(self, nav: NavState) -> float:
        """Speed at which the drift carries the boat ahead; 0 where it carries it astern. A boat that brakes against it
        lies in a flow from astern, which holds its bow: it would not turn."""
        return min(self._parameters["DP_SPEED_AHEAD"], max(0.0, self._along_mps(nav)))

    def _along_mps(self, nav: NavState) -> float:
        """The drift ahead along the hull."""
        return self._stream[0] * math.cos(nav.yaw_rad) + self._stream[1] * math.sin(nav.yaw_rad)

    def _is_carried(self, north_m: float, east_m: float) -> bool:
        """Whether the propeller stands. `north_m`, `east_m`: from the boat to the point."""
        upstream, circle_m = self._upstream_rad(), self._parameters["DP_WATCH_R"]
        if upstream is None:
            self._coasting = not self._returning
            return self._coasting
        c, s = math.cos(upstream), math.sin(upstream)
        up_m, beside_m = -(north_m * c + east_m * s), east_m * c - north_m * s
        edge = -_COAST_DOWN_SHARE if self._coasting else _COAST_UP_SHARE
        near = math.hypot(up_m, beside_m) < _COAST_OUT_SHARE * circle_m
        self._coasting = up_m > edge * circle_m and abs(beside_m) < _COAST_BESIDE_SHARE * circle_m and near
        return self._coasting

    def _judge(self, nav: NavState, distance_m: float, inward_m2ps: float) -> None:
        """Whether the boat is on its way back. `inward_m2ps`: distance times the speed towards the point."""
        circle_m = self._parameters["DP_WATCH_R"]
        calm = self._upstream_rad() is None
        watches = distance_m > 0.0 and not self._needs_flow  # a rudder lies better in the stream than on its way back
        outward_mps = max(0.0, -inward_m2ps / distance_m) if watches else 0.0
        if calm:  # what is faster is the boat's own way, which ends
            outward_mps = min(outward_mps, self._least_mps)
        soon_m = distance_m + self._swing_s * outward_mps
        if soon_m > (_CALM_OUT_SHARE if calm else _OUT_SHARE) * circle_m:
            self._returning = True
        elif soon_m < (_CALM_BACK_SHARE if calm else _BACK_SHARE) * circle_m or (calm and self._passed(inward_m2ps)):
            self._rest(nav, calm)
        self._nearing = self._returning and (self._nearing or inward_m2ps > 0.0)
        self._arrived = self._arrived or not self._returning

    def _passed(self, inward_m2ps: float) -> bool:
        """Whether the boat, on its way back, has begun to go away from the point: it passes beside it, and would go
        round it for ever."""
        return self._nearing and inward_m2ps < 0.0

    def _rest(self, nav: NavState, calm: bool) -> None:
        """End the way back. Without a drift it lies as it came: a near point's bearing would turn it for nothing."""
        if self._returning and calm:
            self._lie_rad = nav.yaw_rad
        self._returning = False

    def _lie(self, nav: NavState, north_m: float, east_m: float, dt_s: float) -> float:
        """The heading to the anchor. Learns the heading to lie at. Without a drift nothing would carry the boat
        sideways: it keeps its heading."""
        upstream = self._upstream_rad()
        if upstream is None:
            return self._lie_rad
        wrong = wrap_pi(upstream - self._lie_rad)
        c, s = math.cos(self._lie_rad), math.sin(self._lie_rad)
        across_m, across_mps = east_m * c - north_m * s, nav.east_mps * c - nav.north_mps * s
        turned = wrap_pi(nav.yaw_rad - self._lie_rad)
        across_m -= self._pivot_m * math.sin(turned)
        across_mps += self._pivot_m * nav.yaw_rate_radps * math.cos(turned)
        line_m = max(self._shortest_m, math.hypot(*self._drift) * self._swing_s)
        slant = (across_m - _DAMPING_SHARE * self._swing_s * across_mps) / line_m
        self._turning = abs(wrong) > (_RIGHT_RAD if self._turning else _WRONG_RAD)
        if self._turning:
            turn_radps = math.copysign(_TURN_RADPS, wrong)
        elif self._beam is not None and abs(wrong) > _ASTRAY_RAD:
            turn_radps = math.copysign(1.0 / (_ASTRAY_SHARE * self._swing_s), wrong)
        else:
            turn_radps = min(1.0, max(-1.0, across_m / line_m)) / (_SETTLE_SHARE * self._swing_s)
        self._lie_rad = wrap_pi(self._lie_rad + turn_radps * dt_s)
        return wrap_pi(self._lie_rad + min(_STEEPEST_RAD, max(-_STEEPEST_RAD, math.atan(slant))))

    def _upstream_rad(self) -> float | None:
        """Heading against the drift; None where it is too small to have a direction."""
        return math.atan2(-self._drift[1], -self._drift[0]) if self._drifts else None

    def _see_direction(self) -> None:
        self._drifts = math.hypot(*self._drift) >= (_STILL_SHARE if self._drifts else 1.0) * self._least_mps

    def _see_drift(self, nav: NavState, dt_s: float) -> None:
        seen = _drift(nav)
        share = dt_s / (dt_s + _DRIFT_TIME_S)
        if seen is not None:
            north, east = self._stream
            self._stream = north + share * (seen[0] - north), east + share * (seen[1] - east)
            # by its mean, too: each answer to a drift is thrust, which makes the current less sure
            self._sure_mps += share * (_least_drift_mps(nav) - self._sure_mps)
        if self._beam is None:
            self._drift, self._least_mps = self._stream, self._sure_mps
        else:
            self._feel_drift(self._beam, nav, dt_s)
        self._see_direction()

    def _feel_drift(self, beam: BeamDrift, nav: NavState, dt_s: float) -> None:
        if dt_s > 0.0:
            beam.see(nav, nav.surge_mps - self._along_mps(nav), dt_s)
        self._drift = beam.north_mps, beam.east_mps
        self._least_mps = max(_LEAST_DRIFT_MPS, beam.sigma_mps)


def _least_drift_mps(nav: NavState) -> float:
    """The least drift that has a direction."""
    return max(_LEAST_DRIFT_MPS, nav.current_accuracy_mps or 0.0)


def _drift(nav: NavState) -> tuple[float, float] | None:
    """(north, east) in m/s: the estimated current, which includes the wind's push where no wind is measured, and 3 % of
    a measured wind. None where neither is known."""
    known = nav.current_north_mps is not None and nav.current_east_mps is not None
    north, east = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
    if nav.wind_speed_mps is not None and nav.wind_from_rad is not None:
        north -= _LEEWAY * nav.wind_speed_mps * math.cos(nav.wind_from_rad)
        east -= _LEEWAY * nav.wind_speed_mps * math.sin(nav.wind_from_rad)
        known = True
    return (north, east) if known else None
