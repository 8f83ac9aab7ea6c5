"""Bends that a boat can sail which needs way to turn, and its turn to a way."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.guidance.bend_speed import steady_turn_radps
from companion.obstacles.circling import Circling, circling_at
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST

BEGIN = (0.0, 0.0)


def test_a_boat_that_turns_in_circles_is_led_by_bends_that_it_can_sail() -> None:
    boat = Circling(10.0, 2.0, BEGIN, 0.0)
    for corner_deg, radius_m, follows in (
        (90.0, 10.0, True),
        (90.0, 2.0, False),
        (20.0, 2.0, True),
        (120.0, 10.0, False),
    ):
        turn = math.radians(corner_deg)
        points = (BEGIN, (40.0, 0.0), (40.0 + 40.0 * math.cos(turn), 40.0 * math.sin(turn)))
        assert boat.follows(points, radius_m) == follows


@pytest.mark.parametrize("bearing_deg", range(-170, 180, 20))
def test_its_turn_to_a_way_is_an_arc(bearing_deg: int) -> None:
    boat, bearing = Circling(10.0, 2.0, BEGIN, 1.0), 1.0 + math.radians(bearing_deg)
    arc = boat.arc_to((60.0 * math.cos(bearing), 60.0 * math.sin(bearing)))
    assert arc is not None and arc[0] == BEGIN
    side = math.copysign(1.0, bearing_deg)
    middle = -10.0 * side * math.sin(1.0), 10.0 * side * math.cos(1.0)
    assert all(math.dist(place, middle) == pytest.approx(10.0, abs=0.3) for place in arc)
    assert len(arc) == pytest.approx(1 + abs(bearing_deg) / 15.0, abs=2.0)
    assert boat.arc_to((middle[0] + 2.0, middle[1])) is None, "within its turn"


def test_the_radius_is_that_of_a_turn_at_the_speed_sailed() -> None:
    jet, nav = load(find("rescuerunner")), replace(AT_REST, north_m=3.0, east_m=4.0, yaw_rad=0.5)
    parameters = Parameters(jet.parameters)
    slow, fast = (circling_at(jet, parameters, nav, speed_mps) for speed_mps in (0.8, 8.0))
    assert slow is not None and fast is not None
    assert slow.radius_m == pytest.approx(1.5 * 0.8 / steady_turn_radps(jet.hull, 0.8, 0.7 * jet.limits.yaw_nm))
    assert fast.radius_m == parameters["NAV_ACC_RAD"]
    assert (slow.here, slow.yaw_rad) == ((3.0, 4.0), 0.5)
    assert slow.keep_m == pytest.approx(0.5 * jet.length_m + 0.3 * parameters["CP_DIST"])
    otter = load(find("otter"))
    assert circling_at(otter, Parameters(otter.parameters), nav, 1.0) is None, "turns on the spot"
