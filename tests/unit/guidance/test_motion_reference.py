"""The reference of velocities: consistent with itself, inside its limits, without jerks, and stopped inside what bounds
it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from companion.core.estimate import NavState
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.setpoint import Setpoint
from companion.guidance.motion_reference import MotionReference
from companion.guidance.motion_request import MotionRequest
from companion.guidance.stopping import SMOOTHING_S
from companion.guidance.velocity_course import VelocityCourse
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST

DT = 0.1
PARAMETERS = Parameters({"DP_SPEED_SWAY": 0.2})


class Sailed:
    """An ideal boat that does what the reference says; `rows` are its setpoints, with positions and velocities in
    NED."""

    def __init__(
        self, nav: NavState = AT_REST, reach: Any = lambda place, velocity, braking: math.inf, follows: bool = True
    ) -> None:
        self.reference = MotionReference(3.0, PARAMETERS, reach)
        self.nav, self.follows = nav, follows
        self.reference.start(nav)
        self.rows: list[Setpoint] = []

    def sail(self, wanted: MotionRequest, duration_s: float) -> Setpoint:
        for _ in range(round(duration_s / DT)):
            s = self.reference.update(wanted, self.nav, DT)
            self.rows.append(s)
            if self.follows:
                self.nav = replace(
                    self.nav,
                    north_m=s.north_m,
                    east_m=s.east_m,
                    yaw_rad=s.yaw_rad,
                    surge_mps=s.surge_mps,
                    sway_mps=s.sway_mps,
                )
        return s

    def ned(self) -> list[tuple[float, float]]:
        return [body_to_ned(s.surge_mps, s.sway_mps, s.yaw_rad or 0.0) for s in self.rows]


def test_a_step_of_velocity_is_reached_without_a_jerk_and_inside_the_limits() -> None:
    boat = Sailed()
    last = boat.sail(MotionRequest(velocity=(0.3, 0.1), yaw_rad=0.0), 40.0)
    assert (last.surge_mps, last.sway_mps, last.yaw_rad) == pytest.approx((0.3, 0.1, 0.0), abs=1e-9)
    ax, ay = PARAMETERS["DP_ACC_SURGE"], PARAMETERS["DP_ACC_SWAY"]
    for before, now in zip(boat.rows, boat.rows[1:], strict=False):
        assert abs(now.surge_mps2) <= ax * (1 + 1e-9) and abs(now.sway_mps2) <= ay * (1 + 1e-9)
        assert abs(now.surge_mps2 - before.surge_mps2) <= ax * DT / SMOOTHING_S * (1 + 1e-6)
        assert abs(now.sway_mps2 - before.sway_mps2) <= ay * DT / SMOOTHING_S * (1 + 1e-6)


@pytest.mark.parametrize(
    "wanted",
    [
        MotionRequest(velocity=(0.4, -0.3), yaw_rad=2.0),
        MotionRequest(velocity=(0.4, 0.1), body=True, yaw_rate_radps=0.05),
        MotionRequest(velocity=(-0.3, 0.3), along=True),
        MotionRequest(acceleration=(0.02, -0.01)),
        MotionRequest(point=(3.0, -4.0), yaw_rad=-1.0),
        MotionRequest(yaw_rate_radps=-0.1),
    ],
)
def test_position_velocity_and_acceleration_are_consistent(wanted: MotionRequest) -> None:
    boat = Sailed(replace(AT_REST, surge_mps=0.2, yaw_rate_radps=0.02))
    boat.sail(wanted, 60.0)
    velocity = boat.ned()
    for i in range(1, len(boat.rows)):
        a, b = boat.rows[i - 1], boat.rows[i]
        moved = (b.north_m - a.north_m, b.east_m - a.east_m)  # type: ignore[operator]
        mean = tuple(0.5 * (velocity[i - 1][k] + velocity[i][k]) * DT for k in (0, 1))
        assert moved == pytest.approx(
            mean, abs=1e-3
        )  # the mean of a body's velocities is taken along north and east, its heading apart
        turned = math.remainder(b.yaw_rad - a.yaw_rad, math.tau)  # type: ignore[operator]
        assert turned == pytest.approx(0.5 * (a.yaw_rate_radps + b.yaw_rate_radps) * DT, abs=1e-9)
        assert abs(b.yaw_rate_radps) <= math.radians(PARAMETERS["DP_YAW_RATE"]) + 1e-9


def test_along_the_hull_with_a_yaw_rate_is_a_circle() -> None:
    boat = Sailed()
    rate = math.radians(2.0)
    boat.sail(MotionRequest(velocity=(0.3, 0.0), body=True, yaw_rate_radps=rate), 240.0)
    points = [(s.north_m or 0.0, s.east_m or 0.0) for s in boat.rows[600:]]
    middle = tuple(0.5 * (max(p[k] for p in points) + min(p[k] for p in points)) for k in (0, 1))
    assert all(math.dist(p, middle) == pytest.approx(0.3 / rate, rel=0.01) for p in points)


def test_bow_on_the_course_and_slow_until_it_points_there() -> None:
    boat = Sailed()
    last = boat.sail(MotionRequest(velocity=(0.0, 0.4), along=True), 90.0)
    assert last.yaw_rad == pytest.approx(math.pi / 2, abs=1e-3) and last.surge_mps == pytest.approx(0.4, abs=1e-3)
    assert all(abs(s.sway_mps) <= 1.1 * PARAMETERS["DP_SPEED_SWAY"] for s in boat.rows)  # the axes turn meanwhile


def test_speed_is_capped_and_keeps_its_direction() -> None:
    boat = Sailed()
    last = boat.sail(MotionRequest(velocity=(30.0, 40.0), yaw_rad=math.atan2(4.0, 3.0)), 90.0)
    north, east = boat.ned()[-1]
    assert math.hypot(north, east) == pytest.approx(PARAMETERS["MPC_XY_VEL_MAX"], abs=1e-6)
    assert math.atan2(east, north) == pytest.approx(math.atan2(4.0, 3.0), abs=1e-3)
    assert last.sway_mps == pytest.approx(0.0, abs=1e-3)
    boat.sail(MotionRequest(velocity=(-1.0, 0.0), body=True), 90.0)
    assert boat.rows[-1].surge_mps == pytest.approx(-PARAMETERS["DP_SPEED_ASTERN"], abs=1e-6)


def test_the_boat_reaches_a_point_exactly_and_stays() -> None:
    boat = Sailed(replace(AT_REST, surge_mps=0.4))
    last = boat.sail(MotionRequest(point=(10.0, 6.0), yaw_rad=1.0), 300.0)
    assert (last.north_m, last.east_m, last.yaw_rad) == pytest.approx((10.0, 6.0, 1.0), abs=1e-3)


def test_a_moving_point_is_followed() -> None:
    boat = Sailed()
    for i in range(1500):
        wanted = MotionRequest(velocity=(0.2, 0.1), point=(5.0 + 0.2 * i * DT, 0.1 * i * DT), yaw_rad=0.0)
        boat.sail(wanted, DT)
    last = boat.rows[-1]
    assert (last.north_m, last.east_m) == pytest.approx(
        (5.0 + 0.2 * 149.9, 0.1 * 149.9), abs=0.4
    )  # the mean lags by half of SMOOTHING_S


def test_the_reference_waits_for_a_boat_that_does_not_follow() -> None:
    boat = Sailed(follows=False)
    last = boat.sail(MotionRequest(velocity=(0.5, 0.0), yaw_rate_radps=0.2), 120.0)
    assert math.hypot(last.north_m or 0.0, last.east_m or 0.0) == pytest.approx(0.75 * 3.0, abs=0.06)
    assert last.yaw_rad is not None and abs(last.yaw_rad) <= math.radians(45.0) + 0.02


@pytest.mark.parametrize("speed", [0.2, 0.5, 1.0])
def test_it_stops_before_a_line_from_any_speed(speed: float) -> None:
    """The line lies 20 m north; v²/2a within the way that is left."""

    def reach(place: Any, velocity: Any, braking: float) -> float:
        return math.sqrt(2.0 * braking * max(0.0, 20.0 - place[0])) if velocity[0] > 0.0 else math.inf

    boat = Sailed(reach=reach)
    last = boat.sail(MotionRequest(velocity=(speed, 0.0), yaw_rad=0.0), 400.0)
    assert (last.north_m or 0.0) > 18.0 and max(s.north_m or 0.0 for s in boat.rows) <= 20.02
    boat.sail(MotionRequest(velocity=(-speed, 0.0), yaw_rad=0.0), 60.0)
    assert (boat.rows[-1].north_m or 0.0) < 15.0


def test_course_and_speed_of_a_boat_without_sideways_thrust() -> None:
    course = VelocityCourse(PARAMETERS, 2.0, can_reverse=True)
    course.start(AT_REST)
    nav = AT_REST
    for _ in range(400):
        s = course.update(MotionRequest(velocity=(0.3, -0.4), yaw_rad=1.0), nav, DT)
        assert s.yaw_rad is not None and abs(s.surge_mps2) <= PARAMETERS["PATH_ACC"] + 1e-9
        nav = replace(nav, yaw_rad=s.yaw_rad, surge_mps=s.surge_mps)
    north, east = body_to_ned(s.surge_mps, 0.0, nav.yaw_rad)
    assert (north, east) == pytest.approx((0.3, -0.4), abs=1e-6)
    assert ned_to_body(0.3, -0.4, nav.yaw_rad)[1] == pytest.approx(0.0, abs=1e-6)
