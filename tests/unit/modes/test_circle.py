"""Circle, on a boat that does exactly what it is asked."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId, OrbitState, Result
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, PoseSetpoint
from companion.mission.plan import PlanItem, PlanKind
from companion.modes.circle import OrbitOrder

BOX = ((-60.0, -60.0), (60.0, -60.0), (60.0, 60.0), (-60.0, 60.0))
TURN_RAD = 2.0 * math.pi


def armed(boat: Any, mode: ModeId = ModeId.HOLD) -> Any:
    assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step()
    return boat


def order(boat: Any, **asked: Any) -> Any:
    outcome = boat.supervisor.give_order(OrbitOrder(**asked), boat.now_s)
    boat.step()
    return outcome


def off_m(boat: Any, north_m: float, east_m: float, radius_m: float) -> float:
    return float(boat.away_m(north_m, east_m)) - radius_m


def test_chosen_by_itself_it_orbits_the_point_where_the_boat_is(make_boat: Any) -> None:
    boat = armed(make_boat(CIRC_RADIUS=10.0, CIRC_DIR=1.0, CIRC_SPEED=0.5), ModeId.CIRCLE)
    assert boat.status.orbit == OrbitState(0.0, 0.0, -10.0)
    boat.step(90.0)
    errors = []
    for _ in range(600):
        boat.step()
        errors.append(abs(off_m(boat, 0.0, 0.0, 10.0)))
        assert isinstance(boat.setpoint, PathSetpoint)
    assert max(errors) < 0.1
    assert math.hypot(boat.nav.surge_mps, boat.nav.sway_mps) == pytest.approx(0.5, abs=0.02)
    outwards = math.atan2(boat.nav.east_m, boat.nav.north_m)
    assert math.sin(boat.nav.yaw_rad - outwards) == pytest.approx(-1.0, abs=0.05)  # the centre to port
    assert "Circle: radius 10.0 m, counter-clockwise" in boat.texts()


def test_an_order_is_sailed_and_then_the_boat_holds(boat: Any) -> None:
    armed(boat)
    outcome = order(
        boat, centre=boat.point(40.0, 10.0), radius_m=12.0, clockwise=True, speed_mps=0.6, total_rad=1.5 * TURN_RAD
    )
    assert outcome.accepted and boat.status.mode is ModeId.CIRCLE
    assert boat.status.orbit.radius_m == 12.0
    assert (boat.status.orbit.north_m, boat.status.orbit.east_m) == pytest.approx((40.0, 10.0), abs=1e-3)
    boat.until(lambda: "Circle: 1.5 turns done, holding" in boat.texts())
    assert "Circle: radius 12.0 m, clockwise, 1.5 turns" in boat.texts()
    boat.step(30.0)
    assert boat.status.mode is ModeId.CIRCLE and boat.status.orbit is None
    assert isinstance(boat.setpoint, PoseSetpoint) and boat.setpoint.surge_mps == pytest.approx(0.0, abs=1e-3)
    assert abs(off_m(boat, 40.0, 10.0, 12.0)) < 3.0


def test_chosen_again_it_goes_on_and_begins_anew_when_it_is_over(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(25.0, 0.0), radius_m=8.0, clockwise=True, total_rad=0.5 * TURN_RAD)
    boat.step(20.0)
    assert boat.supervisor.request_mode(ModeId.CIRCLE, boat.now_s).accepted
    boat.step()
    assert boat.names().count("circle_begins") == 1
    boat.until(lambda: "circle_done" in boat.names())
    assert boat.supervisor.request_mode(ModeId.CIRCLE, boat.now_s).accepted
    boat.step()
    assert boat.names().count("circle_begins") == 2
    assert boat.status.orbit.radius_m == 8.0 and boat.status.orbit.north_m == pytest.approx(25.0, abs=1e-3)


def test_what_an_order_leaves_out_stays_as_it_is(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(25.0, 0.0), radius_m=8.0, clockwise=False, total_rad=2.0 * TURN_RAD)
    boat.step(5.0)
    order(boat, radius_m=10.0, clockwise=False)
    assert boat.status.orbit.radius_m == -10.0
    assert boat.status.orbit.north_m == pytest.approx(25.0, abs=1e-3)
    assert boat.texts()[-1] == "Circle: radius 10.0 m, counter-clockwise, 2 turns"
    order(boat, centre=boat.point(20.0, 5.0))
    assert boat.status.orbit.radius_m == -10.0
    assert boat.status.orbit.north_m == pytest.approx(20.0, abs=1e-3)


def test_a_speed_alone_changes_the_circle_under_way_and_keeps_its_turns(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(8.0, 0.0), radius_m=8.0, clockwise=True, speed_mps=0.4, total_rad=TURN_RAD)
    boat.step(0.6 * TURN_RAD * 8.0 / 0.4)
    assert order(boat, speed_mps=0.7).accepted
    boat.step(0.3 * TURN_RAD * 8.0 / 0.7)
    assert math.hypot(boat.nav.surge_mps, boat.nav.sway_mps) == pytest.approx(0.7, abs=0.05)
    boat.step(0.3 * TURN_RAD * 8.0 / 0.7)
    assert "Circle: 1.0 turns done, holding" in boat.texts() and boat.names().count("circle_begins") == 1


def test_a_speed_alone_does_not_begin_a_circle_that_is_over(boat: Any) -> None:
    """It was sailed once more, by a boat that people saw at rest."""
    armed(boat)
    order(boat, centre=boat.point(8.0, 0.0), radius_m=8.0, clockwise=True, total_rad=0.5 * TURN_RAD)
    boat.until(lambda: "circle_done" in boat.names())
    outcome = order(boat, speed_mps=0.7)
    assert outcome.result is Result.TEMPORARILY_REJECTED and outcome.reason == "Circle refused: the circle is over"
    boat.step(5.0)
    assert boat.status.orbit is None and boat.names().count("circle_begins") == 1
    assert order(boat, radius_m=8.0, clockwise=True, speed_mps=0.7).accepted and boat.status.orbit is not None


@pytest.mark.parametrize(
    ("asked", "reason"),
    [
        ({"radius_m": 2.0}, "Circle refused: radius 2.0 m: this boat needs 3.0 m"),
        ({"centre": (64.0, 10.4)}, "Circle refused: centre 63 km away"),
    ],
)
def test_refused_with_the_reason_the_boat_does_what_it_did(boat: Any, asked: dict[str, Any], reason: str) -> None:
    armed(boat)
    outcome = order(boat, **asked)
    assert outcome.result is Result.TEMPORARILY_REJECTED and outcome.reason == reason
    assert reason in boat.texts() and boat.status.mode is ModeId.HOLD


def test_refused_while_disarmed(boat: Any) -> None:
    assert order(boat, radius_m=10.0).reason == "Circle refused: arm first"


def test_a_refused_order_does_not_end_the_orbit(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(25.0, 0.0), radius_m=8.0, clockwise=True)
    assert not order(boat, radius_m=1.5).accepted
    boat.step(5.0)
    assert boat.status.mode is ModeId.CIRCLE and boat.status.orbit.radius_m == 8.0


def test_a_circle_that_leaves_the_fence_is_refused(boat: Any) -> None:
    boat.fence(*BOX)
    armed(boat)
    outcome = order(boat, centre=boat.point(45.0, 0.0), radius_m=20.0, clockwise=True)
    assert outcome.reason == "Circle refused: way crosses the fence" and boat.status.mode is ModeId.HOLD
    assert order(boat, centre=boat.point(30.0, 0.0), radius_m=20.0, clockwise=True).accepted


def test_chosen_while_disarmed_it_is_refused_where_it_would_leave_the_fence(make_boat: Any) -> None:
    boat = make_boat(CIRC_RADIUS=70.0)
    boat.fence(*BOX)
    assert not boat.supervisor.request_mode(ModeId.CIRCLE, boat.now_s).accepted
    boat.parameters.set("CIRC_RADIUS", 20.0)
    assert boat.supervisor.request_mode(ModeId.CIRCLE, boat.now_s).accepted


def test_a_new_fence_stops_it(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(45.0, 0.0), radius_m=20.0, clockwise=True)
    boat.step(2.0)
    boat.fence(*BOX)
    boat.step()
    assert boat.status.mode is ModeId.HOLD
    assert "Circle stopped: way crosses the fence" in boat.texts()


def test_the_speed_of_the_order_stands_until_the_operator_changes_it(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(15.0, 0.0), radius_m=15.0, clockwise=True, speed_mps=0.4)
    boat.step(60.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.4, abs=0.02)
    assert boat.supervisor.change_speed(0.7, boat.now_s).accepted
    boat.step(30.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.7, abs=0.02)


def test_the_operators_speed_comes_before_the_parameter(make_boat: Any) -> None:
    boat = armed(make_boat(CIRC_RADIUS=10.0, CIRC_SPEED=0.5), ModeId.CIRCLE)
    boat.step(60.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.5, abs=0.02)
    assert boat.supervisor.change_speed(0.2, boat.now_s).accepted
    boat.step(20.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.2, abs=0.02)
    order(boat, radius_m=12.0)
    boat.step(20.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.2, abs=0.02), "an order that leaves the speed out"
    order(boat, speed_mps=0.4)
    boat.step(20.0)
    assert boat.setpoint.surge_mps == pytest.approx(0.4, abs=0.02)


def test_a_mode_that_refuses_leaves_the_orbit_as_it_is(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(25.0, 0.0), radius_m=8.0, clockwise=False, total_rad=2.0 * TURN_RAD)
    boat.step(60.0)
    orbit = boat.status.orbit
    boat.plans.replace(PlanKind.MISSION, [PlanItem(0, 178, 2, 1.0, 0.5, 0.0, 0.0, 0, 0, 0.0)])
    assert "nothing to sail to" in boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).reason
    boat.step(5.0)
    assert boat.status.mode is ModeId.CIRCLE and boat.status.orbit == orbit
    assert boat.names().count("circle_begins") == 1
    boat.until(lambda: "Circle: 2.0 turns done, holding" in boat.texts())


def test_sticks_change_nothing(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(15.0, 0.0), radius_m=15.0, clockwise=True)
    boat.sticks = (0.0, 0.0, 0.0)
    boat.step(60.0)
    boat.sticks = (-1.0, 1.0, 1.0)
    boat.step(30.0)
    assert boat.status.mode is ModeId.CIRCLE and abs(off_m(boat, 15.0, 0.0, 15.0)) < 0.1


@pytest.mark.parametrize(("missing", "text"), [("position_valid", "Position lost"), ("heading_valid", "Heading lost")])
def test_it_needs_an_estimate(boat: Any, missing: str, text: str) -> None:
    armed(boat)
    order(boat, centre=boat.point(15.0, 0.0), radius_m=15.0, clockwise=True)
    boat.nav = replace(boat.nav, **{missing: False})
    boat.step(1.0)
    assert f"{text}: neutral" in boat.texts() and isinstance(boat.setpoint, NeutralSetpoint)
    boat.nav = replace(boat.nav, **{missing: True})
    boat.step(30.0)
    assert boat.status.mode is ModeId.CIRCLE and isinstance(boat.setpoint, PathSetpoint)


def test_silence_of_the_ground_station_acts_as_in_other_self_steered_modes(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(15.0, 0.0), radius_m=15.0, clockwise=True)
    boat.station = False
    boat.step(12.0)
    assert "No ground station for 10 s: Hold" in boat.texts() and boat.status.mode is ModeId.HOLD


def test_a_boat_that_makes_no_headway_says_so(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(15.0, 0.0), radius_m=15.0, clockwise=True)
    boat.step(20.0)
    boat.pinned = True
    boat.step(60.0)
    assert "Circle: no headway: wind, current or obstacle" in boat.texts()


def test_pause_holds_and_the_circle_is_left(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(15.0, 0.0), radius_m=15.0, clockwise=True)
    assert boat.supervisor.pause(boat.now_s).accepted
    boat.step()
    assert boat.status.mode is ModeId.HOLD and boat.status.orbit is None


def test_its_way_ahead_is_the_circle_for_traffic(boat: Any) -> None:
    armed(boat)
    order(boat, centre=boat.point(40.0, 0.0), radius_m=15.0, clockwise=True)
    boat.step(5.0)
    way = boat.supervisor.parts.helm.mode.way_ahead()
    assert math.dist(way[0], (boat.nav.north_m, boat.nav.east_m)) < 0.5
    assert max(math.dist(point, (40.0, 0.0)) for point in way[-40:]) < 15.3
    assert sum(math.dist(a, b) for a, b in itertools.pairwise(way)) > TURN_RAD * 15.0


def test_a_jet_orbits_too(make_boat: Any) -> None:
    boat = armed(make_boat(load(find("rescuerunner"))))
    assert order(boat, centre=boat.point(60.0, 0.0), radius_m=40.0, clockwise=False, speed_mps=6.0).accepted
    boat.step(60.0)
    assert abs(off_m(boat, 60.0, 0.0, 40.0)) < 1.0
    assert order(boat, radius_m=3.0).reason.startswith("Circle refused: radius 3.0 m: this boat needs")
