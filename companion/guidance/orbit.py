"""Orbiting a point: line of sight on a circle, entered along its tangent from outside and inside.

Course to sail χ = φ ± (π/2 + ξ), with φ the bearing from the centre, + for clockwise, and ξ = atan((e + κ z)/Δ), with e
the distance outside the circle, Δ the look-ahead distance and z the integral of path tracking (Børhaug, Pavlov &
Pettersen 2008; Beard & McLain 2012, 10.2 for the orbit). Far outside ξ is acos(R/d), which is the straight
tangent from the boat to the circle; near the centre it is −acos(d/R), which is the circle of half the radius that
touches this one from inside. The heading keeps that course in the current by `CrabCompensation`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, Point, Progress
from companion.guidance.bend_speed import BendSpeeds
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.sideslip import SteeredHull, steady_slip_mps
from companion.params.store import Parameters

Place = tuple[float, float]

_PLANNED_TURN = 0.7  # share of the yaw rate that the circle is planned for; the rest is for corrections
_SLOWEST_SHARE = 0.25  # of WP_SPEED: below it a boat loses its steerage
_LOWEST_MPS = 0.05
_LOOKAHEAD_SHARE = 0.5  # of the radius: the most that the look-ahead distance may be
_CENTRE_SHARE = 0.05  # of the radius: nearer to the centre the bearing from it means nothing
_SPIRAL = (0.3, 0.6)  # shares of the radius between which the way out from the centre becomes the line of sight
_ON_CIRCLE_SHARE = 0.15  # of the radius: so near to the circle the boat is on it, and turns count
_NEAR_SHARE = 2.0  # of the radius, from the centre: further off a boat is on its way to the circle, whatever its course
_STEP_SHARE = 0.02  # of the radius, either way: for rates of the course field
_STEP_RAD = 0.02  # likewise of the heading over the course
_ALONG_RAD = math.radians(10.0)  # between course made and circle, within which the integral learns
_SLIP_TIME_S = 6.0
_SLIP_LAGS = 3.0  # times the lag of the course behind the bow: learnt faster, the slip makes the bow swing to and fro
_TURNED_RAD = math.radians(20.0)  # off the heading asked for, up to which the bow has turned there
_SLIP_SHARE = 0.3  # of the speed asked for: slower, the course made tells nothing
_LARGEST_SLIP_RAD = math.radians(40.0)
_SWAY_TIME_S = 2.0
_BEND_TIME_S = 1.0  # of the mean: places come in steps, at the receiver's rate, and so would the speed
_SURGE_SHARE = 3.0  # of PATH_ACC: how fast the speed asked for changes as the bow turns to the course
_TURN_IN_PLACE_SHARE = 0.3  # of the speed, kept while the bow points elsewhere by a boat that steers by its way
_LEAVING_RAD = 0.1  # between the course and the way to the next point, at which the circle is left
_PARTS = 24  # of half a turn, as a polyline
_MOST_STEPS = 400  # of the way in


@dataclass(frozen=True, slots=True)
class Circle:
    """What is orbited: centre in the local plane, radius above 0."""

    north_m: float
    east_m: float
    radius_m: float
    clockwise: bool

    @property
    def sign(self) -> float:
        """1 clockwise, −1 counter-clockwise."""
        return 1.0 if self.clockwise else -1.0

    def polar(self, north_m: float, east_m: float) -> tuple[float, float]:
        """(distance from the centre in m, bearing from it in rad)."""
        x, y = north_m - self.north_m, east_m - self.east_m
        return math.hypot(x, y), math.atan2(y, x)

    def at(self, bearing_rad: float) -> Place:
        """(north_m, east_m) of the circle at that bearing from the centre."""
        return (
            self.north_m + self.radius_m * math.cos(bearing_rad),
            self.east_m + self.radius_m * math.sin(bearing_rad),
        )

    def course_rad(self, distance_m: float, bearing_rad: float, lookahead_m: float, lean_m: float = 0.0) -> float:
        """Course over ground to sail at that distance from the centre and that bearing from it, not wrapped. `lean_m`:
        steered so much further towards the centre."""
        inward = _inward_rad(distance_m, self.radius_m, lookahead_m)
        inward = math.atan(math.tan(inward) + lean_m / lookahead_m) if lean_m else inward
        return bearing_rad + self.sign * (0.5 * math.pi + inward)


def _inward_rad(distance_m: float, radius_m: float, lookahead_m: float) -> float:
    """ξ: how far the course points from the direction of the circle towards the centre."""
    sight = math.atan((distance_m - radius_m) / lookahead_m)
    if distance_m >= radius_m:
        return min(sight, math.acos(radius_m / distance_m))
    share = distance_m / radius_m
    spiral = -math.acos(share)
    low, high = _SPIRAL
    weight = min(1.0, max(0.0, (high - share) / (high - low)))
    return weight * spiral + (1.0 - weight) * max(sight, spiral)


def orbit_speed_mps(curvature_1pm: float, parameters: Parameters, bends: BendSpeeds | None = None) -> float:
    """Most speed on a bend of that curvature, by PATH_ACC_LAT, PATH_YAW_RATE and `bends`."""
    if curvature_1pm < 1.0e-6:
        return math.inf
    turn_radps = _PLANNED_TURN * math.radians(parameters["PATH_YAW_RATE"])
    most_mps = min(math.sqrt(parameters["PATH_ACC_LAT"] / curvature_1pm), turn_radps / curvature_1pm)
    return most_mps if bends is None else min(most_mps, bends.at(curvature_1pm))


def least_radius_m(parameters: Parameters, length_m: float) -> float:
    """Radius of the tightest circle that the boat can sail at its slowest steady speed; not less than its length."""
    slowest = slowest_mps(parameters)
    turn_radps = _PLANNED_TURN * math.radians(parameters["PATH_YAW_RATE"])
    return max(length_m, slowest * slowest / parameters["PATH_ACC_LAT"], slowest / turn_radps)


def slowest_mps(parameters: Parameters) -> float:
    """Speed below which a bend does not slow the boat down: it must keep its steerage."""
    return max(_LOWEST_MPS, _SLOWEST_SHARE * parameters["WP_SPEED"])


def radius_refusal(radius_m: float, least_m: float) -> str | None:
    """Why the boat cannot orbit at that radius, or None."""
    if not math.isfinite(radius_m) or radius_m <= 0.0:
        return "the radius should be above 0 m"
    return None if radius_m >= least_m else f"radius {radius_m:.1f} m: this boat needs {least_m:.1f} m"


def chosen_circle(centre: Place, radius_m: float | None, clockwise: bool | None, parameters: Parameters) -> Circle:
    """The circle round `centre`; None: as CIRC_RADIUS and CIRC_DIR have it."""
    radius_m = parameters["CIRC_RADIUS"] if radius_m is None else radius_m
    return Circle(*centre, radius_m, not parameters["CIRC_DIR"] if clockwise is None else clockwise)


def whole_line(circle: Circle, place: Place, total_rad: float | None, parameters: Parameters) -> list[Place]:
    """The way from `place` to the circle and round it, as far as it is sailed."""
    lookahead_m = min(parameters["PATH_LOOKAHEAD"], _LOOKAHEAD_SHARE * circle.radius_m)
    way = approach(circle, place, lookahead_m)
    sweep_rad = 2.0 * math.pi if total_rad is None else min(2.0 * math.pi, total_rad)
    return way if sweep_rad <= 0.0 else [*way, *round_line(circle, circle.polar(*way[-1])[1], sweep_rad)]


def approach(circle: Circle, place: Place, lookahead_m: float) -> list[Place]:
    """The way from `place` to the circle as the course field leads, both ends included."""
    line = [place]
    north_m, east_m = place
    distance_m, bearing_rad = circle.polar(*place)
    far_m = circle.radius_m + 3.0 * lookahead_m
    if distance_m > far_m:  # straight along the tangent first
        along_m = math.sqrt(distance_m**2 - circle.radius_m**2) - math.sqrt(far_m**2 - circle.radius_m**2)
        course_rad = circle.course_rad(distance_m, bearing_rad, 1.0e-6)
        north_m, east_m = north_m + along_m * math.cos(course_rad), east_m + along_m * math.sin(course_rad)
        line.append((north_m, east_m))
    step_m = circle.radius_m / _PARTS
    for _ in range(_MOST_STEPS):
        distance_m, bearing_rad = circle.polar(north_m, east_m)
        if abs(distance_m - circle.radius_m) <= 0.5 * step_m:
            break
        course_rad = circle.course_rad(distance_m, bearing_rad, lookahead_m)
        north_m, east_m = north_m + step_m * math.cos(course_rad), east_m + step_m * math.sin(course_rad)
        line.append((north_m, east_m))
    return line


def round_line(circle: Circle, bearing_rad: float, sweep_rad: float) -> list[Place]:
    """The circle from that bearing on, for `sweep_rad` of it, as a polyline that does not cut inside it."""
    parts = max(2, math.ceil(sweep_rad * _PARTS / math.pi))
    step_rad = sweep_rad / parts
    outer = Circle(circle.north_m, circle.east_m, circle.radius_m / math.cos(0.5 * step_rad), circle.clockwise)
    return [outer.at(bearing_rad + circle.sign * step_rad * i) for i in range(parts + 1)]


@dataclass(frozen=True, slots=True)
class OrbitProgress:
    """What to do now, and how far the orbit is. `swept_rad`: on the circle, since it was reached; None before that.
    `error_m`: distance outside the circle. `way_m` grows as the boat gets on."""

    setpoint: PathSetpoint
    swept_rad: float | None
    error_m: float
    finished: bool
    way_m: float


class OrbitGuidance:
    """`start(circle, nav, …)`, then `update(nav, speed_mps, dt_s)` → OrbitProgress with a setpoint of kind PATH.

    Remembers the circle, the angle swept, the integral of the line of sight, the drift seen, the mean bend, and the
    speed and heading last asked for. `can_sway`: the boat can push itself sideways. `top_mps`: the most that it makes
    through the water. `bends`: the speeds at which the moment of its thrusters turns it; None: it does not bound them.
    `steered`: how late its course follows its bow, and what it slips in a turn; None: at once, and nothing.
    """

    def __init__(
        self,
        parameters: Parameters,
        can_sway: bool,
        top_mps: float = math.inf,
        bends: BendSpeeds | None = None,
        steered: SteeredHull | None = None,
    ) -> None:
        self._parameters = parameters
        self._can_sway = can_sway
        self._steered = None if can_sway else steered
        self._bends = bends
        self._crab = CrabCompensation(top_mps, self._steered)
        self._circle: Circle | None = None
        self._total_rad: float | None = None
        self._leave_to: Place | None = None
        self._place = (0.0, 0.0)
        self._bearing_rad: float | None = None
        self._angle_rad = 0.0  # swept since the start
        self._swept_rad: float | None = None
        self._integral = self._slip = self._sway = self._speed = self._surge = self._bend_1pm = 0.0
        self._turn_radps = self._into_bend_rad = 0.0
        self._yaw: float | None = None

    def start(
        self, circle: Circle, nav: NavState, total_rad: float | None = None, leave_to: Place | None = None
    ) -> None:
        """Begin from the boat's motion. `total_rad`: to sweep on the circle; None: without end. `leave_to`: the orbit
        goes on after that until the boat points to this place."""
        self._circle, self._total_rad = circle, total_rad
        outside = leave_to is not None and circle.polar(*leave_to)[0] > circle.radius_m
        self._leave_to = leave_to if outside else None
        self._swept_rad = None
        self._angle_rad = 0.0
        self.rejoin(nav)

    @property
    def circle(self) -> Circle:
        """What is orbited. Raises RuntimeError before `start`."""
        if self._circle is None:
            raise RuntimeError("OrbitGuidance before start")
        return self._circle

    def rejoin(self, nav: NavState) -> None:
        """Go on from the boat's present motion; the angle swept so far counts."""
        self._place = (nav.north_m, nav.east_m)
        self._bearing_rad = self._yaw = None
        self._integral = self._slip = self._sway = self._bend_1pm = 0.0
        self._turn_radps = self._into_bend_rad = 0.0
        self._crab.reset()
        self._surge = nav.surge_mps
        self._speed = max(0.0, nav.surge_mps)

    def line(self) -> list[Place]:
        """(north_m, east_m) of what is left to sail, one turn of it at most, from where the boat is."""
        left_rad = None
        if self._total_rad is not None and self._leave_to is None:
            left_rad = self._total_rad - (self._swept_rad or 0.0)
        return whole_line(self.circle, self._place, left_rad, self._parameters)

    def update(self, nav: NavState, speed_mps: float, dt_s: float) -> OrbitProgress:
        """One step: course, speed and heading. `speed_mps`: asked for. Raises RuntimeError before `start`."""
        circle = self.circle
        self._place = (nav.north_m, nav.east_m)
        distance_m, bearing_rad = circle.polar(*self._place)
        error_m = distance_m - circle.radius_m
        self._count(distance_m, bearing_rad)
        self._learn_drift(nav, dt_s)
        course_rad = self._course_at(nav, 0.0, 0.0)
        if self._can_sway:
            self._learn_offset(nav, bearing_rad, error_m, dt_s)
        else:
            self._learn_slip(nav, course_rad, dt_s)
        bend_1pm = abs(self._change(nav, math.cos(course_rad), math.sin(course_rad)))
        self._bend_1pm += (bend_1pm - self._bend_1pm) * min(1.0, dt_s / _BEND_TIME_S)
        last_mps = self._speed
        before_m = self._before_m(nav, distance_m, bearing_rad)
        self._speed = self._next_speed(before_m, self._bend_1pm, speed_mps, dt_s)
        last_rad = nav.yaw_rad if self._yaw is None else self._yaw
        triangle_rad = self._crab.heading_rad(nav, course_rad, self._speed, last_rad)
        yaw_rad = self._turn_to(last_rad, triangle_rad + self._slip + self._into_bend_rad, dt_s)
        rate_radps = self._turn_rate(nav, course_rad) * self._heading_share(nav, course_rad, triangle_rad)
        against = math.cos(triangle_rad - course_rad) < 0.0
        surge_mps, sway_mps = self._along_hull(nav, wrap_pi(course_rad - nav.yaw_rad), against, dt_s)
        north_m, east_m = circle.at(bearing_rad)
        progress = Progress(
            place=Point(north_m, east_m),
            target=Point(circle.north_m, circle.east_m),
            cross_track_error_m=-circle.sign * error_m,
            course_rad=wrap_pi(bearing_rad + circle.sign * 0.5 * math.pi),
            distance_to_go_m=self._to_go_m,
        )
        acceleration_mps2 = (self._speed - last_mps) / dt_s
        setpoint = PathSetpoint(yaw_rad, surge_mps, sway_mps, rate_radps, acceleration_mps2, progress)
        way_m = circle.radius_m * self._angle_rad - abs(error_m)
        return OrbitProgress(setpoint, self._swept_rad, error_m, self._is_over(nav, bearing_rad), way_m)

    # --- where ---

    @property
    def _lookahead_m(self) -> float:
        parameters = self._parameters
        wanted_m = max(parameters["PATH_LOOKAHEAD"], parameters["PATH_LOOK_TIME"] * self._speed)
        return min(wanted_m, _LOOKAHEAD_SHARE * self.circle.radius_m)

    @property
    def _to_go_m(self) -> float | None:
        """Along the circle; None where it has no end."""
        if self._total_rad is None:
            return None
        return max(0.0, self._total_rad - (self._swept_rad or 0.0)) * self.circle.radius_m

    def _count(self, distance_m: float, bearing_rad: float) -> None:
        """Add up the angle swept, from the start and on the circle."""
        radius_m = self.circle.radius_m
        if distance_m < _CENTRE_SHARE * radius_m:
            self._bearing_rad = None
            return
        step_rad = 0.0 if self._bearing_rad is None else self.circle.sign * wrap_pi(bearing_rad - self._bearing_rad)
        self._bearing_rad = bearing_rad
        self._angle_rad += step_rad
        if self._swept_rad is not None:
            self._swept_rad += step_rad
            return
        if abs(distance_m - radius_m) <= _ON_CIRCLE_SHARE * radius_m:
            self._swept_rad = 0.0

    def _is_over(self, nav: NavState, bearing_rad: float) -> bool:
        if self._total_rad is None or self._swept_rad is None or self._swept_rad < self._total_rad:
            return False
        if self._leave_to is None:
            return True
        course_rad = bearing_rad + self.circle.sign * 0.5 * math.pi
        north_m, east_m = self._leave_to
        return abs(wrap_pi(math.atan2(east_m - nav.east_m, north_m - nav.north_m) - course_rad)) <= _LEAVING_RAD

    # --- which way ---

    def _learn_drift(self, nav: NavState, dt_s: float) -> None:
        straight = max(0.0, 1.0 - 2.0 * abs(nav.yaw_rate_radps) / math.radians(self._parameters["PATH_YAW_RATE"]))
        self._crab.update(nav, self._speed, straight, dt_s)

    def _learn_offset(self, nav: NavState, bearing_rad: float, error_m: float, dt_s: float) -> None:
        """The integral of the line of sight, while the boat sails along the circle."""
        lookahead_m, gain = self._lookahead_m, self._parameters["PATH_INTEGRAL"]
        along_rad = bearing_rad + self.circle.sign * 0.5 * math.pi
        made_rad = math.atan2(nav.east_mps, nav.north_mps)
        if abs(error_m) < lookahead_m and abs(wrap_pi(made_rad - along_rad)) < _ALONG_RAD:
            leaning_m = error_m + gain * self._integral
            self._integral += self._speed * lookahead_m * error_m / (lookahead_m**2 + leaning_m**2) * dt_s
            bound = 0.6 * lookahead_m / gain if gain > 0.0 else 0.0
            self._integral = _within(self._integral, bound)

    def _learn_slip(self, nav: NavState, course_rad: float, dt_s: float) -> None:
        """How far from the heading of the wind triangle the bow must be asked to point. Into the bend for the sideslip
        of a steady turn, and besides by the integral of the course error, while the bow is where it was asked to be: it
        learns what else the hull slips, and what of the current is not known. What the boat's own turns give it now is
        left out: learnt as if it stayed, it makes the bow swing to and fro. A boat that pushes itself sideways makes
        its course whatever its heading is, so it learns nothing from that."""
        self._turn_radps += (self._steady_turn(nav) - self._turn_radps) * min(1.0, dt_s / _BEND_TIME_S)
        slip_mps = steady_slip_mps(self._steered, nav.surge_mps, self._turn_radps)
        self._into_bend_rad = -math.atan2(slip_mps, max(self._speed, _LOWEST_MPS))
        if self._yaw is None or abs(wrap_pi(nav.yaw_rad - self._yaw)) > _TURNED_RAD:
            return
        more_mps = slip_mps - self._crab.slip_mps
        north_mps = nav.north_mps - more_mps * math.sin(nav.yaw_rad)
        east_mps = nav.east_mps + more_mps * math.cos(nav.yaw_rad)
        off_rad = wrap_pi(course_rad - math.atan2(east_mps, north_mps))
        if math.hypot(north_mps, east_mps) > _SLIP_SHARE * self._speed and abs(off_rad) < _LARGEST_SLIP_RAD:
            time_s = max(_SLIP_TIME_S, _SLIP_LAGS * self._late_s(nav))
            self._slip = _within(self._slip + off_rad * dt_s / time_s, _LARGEST_SLIP_RAD)

    def _late_s(self, nav: NavState) -> float:
        """How much later than its bow a boat that cannot push itself sideways turns its course."""
        return 0.0 if self._steered is None else self._steered.hull.sway_lag_s(nav.surge_mps, nav.sway_mps)

    def _course_at(self, nav: NavState, north_m: float, east_m: float) -> float:
        """Course to sail so far from where the boat is. At the centre: straight on."""
        circle = self.circle
        distance_m, bearing_rad = circle.polar(nav.north_m + north_m, nav.east_m + east_m)
        if distance_m < _CENTRE_SHARE * circle.radius_m:
            bearing_rad = nav.yaw_rad
        lean_m = self._parameters["PATH_INTEGRAL"] * self._integral
        return circle.course_rad(distance_m, bearing_rad, self._lookahead_m, lean_m)

    def _change(self, nav: NavState, north: float, east: float) -> float:
        """How fast the course to sail changes along a velocity, rad/s; along a unit vector, rad/m."""
        size = math.hypot(north, east)
        if size < 1.0e-6:
            return 0.0
        step = _STEP_SHARE * self.circle.radius_m / size
        after = self._course_at(nav, step * north, step * east)
        before = self._course_at(nav, -step * north, -step * east)
        return wrap_pi(after - before) / (2.0 * step)

    def _turn_rate(self, nav: NavState, course_rad: float) -> float:
        """How fast the course to sail turns, as the boat really moves: ahead no faster than it should."""
        c, s = math.cos(course_rad), math.sin(course_rad)
        along = min(self._speed, max(0.0, nav.north_mps * c + nav.east_mps * s))
        across = nav.east_mps * c - nav.north_mps * s
        rate = self._change(nav, along * c - across * s, along * s + across * c)
        limit = math.radians(self._parameters["PATH_YAW_RATE"])
        return min(limit, max(-limit, rate))

    def _steady_turn(self, nav: NavState) -> float:
        """How fast the boat turns on the circle, and the less the further off that it is: 0 on the way to it."""
        circle = self.circle
        distance_m, bearing_rad = circle.polar(nav.north_m, nav.east_m)
        off = abs(distance_m - circle.radius_m) / self._lookahead_m
        around_mps = nav.east_mps * math.cos(bearing_rad) - nav.north_mps * math.sin(bearing_rad)
        return max(0.0, 1.0 - off) * around_mps / circle.radius_m

    def _heading_share(self, nav: NavState, course_rad: float, heading_rad: float) -> float:
        """How fast the heading turns beside the course: in a current the crab angle changes round the circle."""
        after = self._crab.heading_rad(nav, course_rad + _STEP_RAD, self._speed, heading_rad)
        before = self._crab.heading_rad(nav, course_rad - _STEP_RAD, self._speed, heading_rad)
        return min(2.0, max(0.0, wrap_pi(after - before) / (2.0 * _STEP_RAD)))

    def _turn_to(self, last_rad: float, heading_rad: float, dt_s: float) -> float:
        """The heading to ask for: towards that one, no faster than the boat may turn."""
        most_rad = math.radians(self._parameters["PATH_YAW_RATE"]) * dt_s
        self._yaw = wrap_pi(last_rad + _within(wrap_pi(heading_rad - last_rad), most_rad))
        return self._yaw

    # --- how fast ---

    def _before_m(self, nav: NavState, distance_m: float, bearing_rad: float) -> float:
        """Way left before the circle. A boat that runs a little wide is on the circle, and so is one near by that does
        not come nearer: at the speed of the way in it could not turn in."""
        radius_m = self.circle.radius_m
        tangent_m = math.sqrt(max(0.0, distance_m**2 - ((1.0 + _ON_CIRCLE_SHARE) * radius_m) ** 2))
        tangent_m = max(0.0, tangent_m - self._late_s(nav) * self._speed)
        ground_mps = math.hypot(nav.north_mps, nav.east_mps)
        if distance_m > _NEAR_SHARE * radius_m or ground_mps < slowest_mps(self._parameters):
            return tangent_m
        inward_mps = -(nav.north_mps * math.cos(bearing_rad) + nav.east_mps * math.sin(bearing_rad))
        return min(tangent_m, max(0.0, distance_m * inward_mps / ground_mps))

    def _next_speed(self, before_m: float, bend_1pm: float, speed_mps: float, dt_s: float) -> float:
        """The speed asked for, or as much as the bend here and the circle ahead allow. `before_m`: way left before the
        circle."""
        parameters = self._parameters
        wanted = min(max(0.0, speed_mps), parameters["MPC_XY_VEL_MAX"])
        lowest = min(wanted, slowest_mps(parameters))
        on_circle = orbit_speed_mps(1.0 / self.circle.radius_m, parameters, self._bends)
        ahead = math.sqrt(on_circle**2 + 2.0 * parameters["PATH_ACC"] * before_m)
        wanted = max(lowest, min(wanted, ahead, orbit_speed_mps(bend_1pm, parameters, self._bends)))
        step = 1.25 * parameters["PATH_ACC"] * dt_s
        return min(self._speed + step, max(self._speed - 1.5 * step, wanted))

    def _along_hull(self, nav: NavState, off_rad: float, against: bool, dt_s: float) -> tuple[float, float]:
        """(surge, sway) m/s that make the speed on a course `off_rad` from the bow. `against`: the bow points into a
        current that sets the boat along. The speed loop holds no sideways speed against a steady force, so what is
        missing of it is integrated here."""
        lowest = -1.0 if against else 0.0 if self._can_sway else _TURN_IN_PLACE_SHARE
        most = _SURGE_SHARE * self._parameters["PATH_ACC"] * dt_s
        self._surge += _within(self._speed * max(lowest, math.cos(off_rad)) - self._surge, most)
        if not self._can_sway:
            return self._surge, 0.0
        bound = self._parameters["DP_SPEED_SWAY"]
        wanted_mps = self._crab.sway_mps(nav, self._speed * math.sin(off_rad), bound)
        self._sway = _within(self._sway + (wanted_mps - nav.sway_mps) * dt_s / _SWAY_TIME_S, bound)
        return self._surge, wanted_mps + self._sway


def _within(value: float, most: float) -> float:
    return min(most, max(-most, value))
