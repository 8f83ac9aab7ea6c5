"""Turns that begin early: where the boat slides out of them, and where the water resists them."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.guidance.early_turn import EarlyTurn
from companion.guidance.path_tracking import PathTracker
from companion.guidance.turning import UNKNOWN, Turning, turning_of
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

OTTER = load(find("otter"))
TURNING = turning_of(OTTER, on_the_spot=True)
USUAL_S, SPEED_MPS, WIDE_M = 1.2, 1.2, 50.0
LAG_S = OTTER.hull.sway_lag_s(SPEED_MPS, 0.0)


def begins_s(
    resistance: float = 1.0,
    corner_deg: float = 90.0,
    inside_m: float = WIDE_M,
    turning: Turning = TURNING,
    slides: bool = True,
) -> float:
    """How early before a corner just ahead."""
    early = EarlyTurn(Parameters(OTTER.parameters), turning, slides)
    early.turns_against(resistance)
    course = math.radians(corner_deg)
    nav = nav_state(surge_mps=SPEED_MPS)
    return early.begins_s(nav, USUAL_S, SPEED_MPS, inside_m, lambda ahead_m: course if ahead_m > 0.0 else 0.0)


def test_a_boat_that_waits_for_its_bow_begins_as_usual() -> None:
    """Catamarans in rough water that began early passed their corners 2 m inside."""
    assert begins_s(slides=False) == USUAL_S
    assert begins_s(resistance=3.0, slides=False) == USUAL_S
    assert begins_s(resistance=3.0, turning=UNKNOWN) == USUAL_S, "its moment bounds nothing"


def test_it_begins_earlier_by_its_slide() -> None:
    assert begins_s(corner_deg=0.0) == pytest.approx(USUAL_S + 0.4 * LAG_S)


@pytest.mark.parametrize("corner_deg", [90.0, 40.0])
def test_it_begins_half_of_what_its_moment_takes_longer_than_the_heading_that_is_asked_for(corner_deg: float) -> None:
    """A catamaran of 2 m turns at 25° a second at most, its heading setpoint at 30: it ran 2.4 m wide in corners."""
    assert TURNING.bends is not None
    fastest = math.radians(Parameters(OTTER.parameters)["PATH_YAW_RATE"])
    rate = TURNING.bends.rate_radps(SPEED_MPS)
    assert rate < 0.8 * fastest
    longer_s = math.radians(corner_deg) * (1.0 / rate - 1.0 / fastest)
    assert begins_s(corner_deg=corner_deg) == pytest.approx(USUAL_S + 0.4 * LAG_S + 0.5 * longer_s)


def test_against_more_resistance_it_begins_half_of_what_the_turn_takes_longer_before() -> None:
    """And earlier by its longer slide."""
    fastest = math.radians(Parameters(OTTER.parameters)["PATH_YAW_RATE"])
    assert TURNING.bends is not None
    longer_s = 0.5 * math.pi * (1.0 / TURNING.bends.resisted(3.0).rate_radps(SPEED_MPS) - 1.0 / fastest)
    assert longer_s > 1.0
    slides_s = 0.8 * LAG_S
    assert begins_s(resistance=3.0) == pytest.approx(USUAL_S + slides_s + 0.5 * longer_s)
    assert begins_s(resistance=3.0, corner_deg=30.0) == pytest.approx(USUAL_S + slides_s + longer_s / 6.0)
    assert begins_s(resistance=3.0, corner_deg=0.0) == pytest.approx(USUAL_S + slides_s)


def test_it_passes_the_corner_no_further_inside_than_it_may() -> None:
    assert USUAL_S <= begins_s(3.0, inside_m=0.5) < begins_s(3.0, inside_m=1.0) < begins_s(3.0)
    assert begins_s(3.0, inside_m=0.01) == USUAL_S


def heading_deg(resistance: float, north_m: float) -> float:
    """The heading that is asked for, at that place on the way north to a corner that leads east."""
    guide = PathTracker(Parameters(OTTER.parameters), can_sway=False, turning=replace(TURNING, aside=True))
    guide.turns_against(resistance)
    nav = nav_state(north_m, 0.0, 0.0, SPEED_MPS)
    corner = [Waypoint(0.0, 0.0), Waypoint(50.0, 0.0, radius_m=3.0), Waypoint(50.0, 50.0)]
    guide.start(corner, nav, from_here=False)
    return math.degrees([guide.update(nav, SPEED_MPS, 0.1).setpoint.yaw_rad for _ in range(50)][-1])


def test_the_path_tracker_turns_earlier() -> None:
    places = [42.0, 43.0, 44.0, 45.0, 46.0]
    assert all(heading_deg(3.0, at) >= heading_deg(1.0, at) - 1.0e-6 for at in places)
    assert max(heading_deg(3.0, at) - heading_deg(1.0, at) for at in places) > 5.0


def test_bends_are_slower_against_more_resistance() -> None:
    early = EarlyTurn(Parameters(OTTER.parameters), TURNING, slides=True)
    assert not early.turns_against(1.05), "too little to be worth another profile"
    before = early.bends
    assert early.turns_against(2.0) and before is not None and early.bends is not None
    assert early.bends.at(0.5) < before.at(0.5)


def test_a_turn_that_has_begun_goes_on_although_the_boat_loses_its_way() -> None:
    """A stream of 0.4 m/s stopped a boat with a lone azimuth thruster as it turned at its corner: it pointed back along
    its leg, gathered way, began to turn again, and gave up after 120 s."""
    guide = PathTracker(Parameters(OTTER.parameters), can_sway=False, turning=replace(TURNING, aside=True))
    under_way, stopped = nav_state(47.5, 0.0, 0.0, SPEED_MPS), nav_state(47.5, 0.0, math.radians(60.0), -0.1)
    corner = [Waypoint(0.0, 0.0), Waypoint(50.0, 0.0, radius_m=3.0), Waypoint(50.0, 50.0)]
    guide.start(corner, under_way, from_here=False)
    begun = [guide.update(under_way, SPEED_MPS, 0.1).setpoint.yaw_rad for _ in range(50)][-1]
    later = [guide.update(stopped, SPEED_MPS, 0.1).setpoint.yaw_rad for _ in range(100)][-1]
    assert math.degrees(begun) > 20.0
    assert later >= begun - 0.02
