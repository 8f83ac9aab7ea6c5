"""Between two manoeuvres of a trial: the boat brakes as long as that slows it down, and then comes in."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.vessel import find, load
from companion.core.estimate import NavState
from companion.core.setpoint import HeadingSetpoint, Setpoint, ThrusterSetpoint
from companion.modes.trial.approach import Approach
from companion.modes.trial.circle import TrialCircle
from companion.modes.trial.expectation import expected
from companion.modes.trial.manoeuvres.manoeuvre import Begin
from tests.unit.conftest import AT_REST
from tests.unit.rudder_boat import SKIFF

REVOLT = load(find("revolt"))
EXPECTED = expected(REVOLT)
PERIOD_S = 0.1
RUDDER = expected(SKIFF)
STREAM_MPS = 0.4 * RUDDER.top_mps


def carried(east_m: float, east_mps: float) -> NavState:
    """Heading north, carried east."""
    return replace(AT_REST, east_m=east_m, sway_mps=east_mps, east_mps=east_mps)


def braked_for_s(slowing_mps2: float) -> float:
    """Until the bow is turned to the centre. The boat is carried out at a fifth of its top speed, and slows down."""
    radius_m = EXPECTED.radius_m
    approach = Approach(TrialCircle((0.0, 0.0), radius_m, EXPECTED), EXPECTED, REVOLT)
    speed_mps, east_m, t_s = 0.2 * EXPECTED.top_mps, 0.8 * radius_m, 0.0
    approach.begin(carried(east_m, speed_mps), Begin.CENTRE, True, t_s)
    while t_s < 60.0:
        asked = approach.update(carried(east_m, max(0.0, speed_mps)), t_s)
        if asked is None or (isinstance(asked, HeadingSetpoint) and abs(asked.yaw_rad) > math.radians(45.0)):
            return t_s
        speed_mps -= slowing_mps2 * PERIOD_S
        east_m, t_s = east_m + max(0.0, speed_mps) * PERIOD_S, t_s + PERIOD_S
    return math.inf


def test_a_boat_that_a_stream_holds_up_does_not_brake_for_ever() -> None:
    assert braked_for_s(0.0) < 3.0


def test_a_boat_that_slows_down_brakes_until_it_is_slow() -> None:
    needed_s = 6.0 * EXPECTED.speeding_s
    slowing_mps2 = 0.12 * EXPECTED.top_mps / (0.5 * needed_s)  # from a fifth of the top speed to 0.08 of it
    assert 0.4 * needed_s < braked_for_s(slowing_mps2) < 0.6 * needed_s


# --- a rudder boat that a stream carries out of its circle, north ---------------------------------------------------


def downstream(through_water_mps: float, yaw_rad: float = 0.0, rate_radps: float = 0.0) -> NavState:
    """Well out, with this speed ahead through a stream that sets north."""
    north_mps = through_water_mps * math.cos(yaw_rad) + STREAM_MPS
    east_mps = through_water_mps * math.sin(yaw_rad)
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    return replace(
        AT_REST,
        north_m=0.6 * RUDDER.radius_m,
        yaw_rad=yaw_rad,
        yaw_rate_radps=rate_radps,
        north_mps=north_mps,
        east_mps=east_mps,
        surge_mps=north_mps * c + east_mps * s,
        sway_mps=east_mps * c - north_mps * s,
        current_north_mps=STREAM_MPS,
        current_east_mps=0.0,
    )


def coming_in() -> tuple[Approach, TrialCircle]:
    circle = TrialCircle((0.0, 0.0), RUDDER.radius_m, RUDDER)
    approach = Approach(circle, RUDDER, SKIFF)
    approach.begin(downstream(0.2), Begin.CENTRE, True, 0.0)
    return approach, circle


def helm(asked: Setpoint | None) -> float:
    """1 or −1 with the rudder at its stop, to starboard or port; 0 where the heading law steers."""
    if not isinstance(asked, ThrusterSetpoint):
        assert isinstance(asked, HeadingSetpoint)
        return 0.0
    (command,), thruster = asked.thrusters, SKIFF.thrusters[0]
    assert command.azimuth_rad in (thruster.azimuth_min_rad, thruster.azimuth_max_rad)
    return -math.copysign(1.0, command.azimuth_rad or 0.0)  # the stern goes to the other side


def throttle(asked: Setpoint | None) -> float:
    assert isinstance(asked, ThrusterSetpoint)
    return asked.thrusters[0].throttle


def test_a_rudder_boat_comes_round_with_full_thrust_however_fast_it_is_over_ground() -> None:
    """With the stream from astern there is no flow over its blade but that of its propeller, and braking takes that."""
    approach, _ = coming_in()
    for through_water_mps in (-0.2, 0.3, 0.9 * RUDDER.top_mps):
        asked = approach.update(downstream(through_water_mps, math.radians(-30.0)), 0.1)
        assert helm(asked) == -1.0 and throttle(asked) > 0.9


def test_what_is_left_of_a_turn_is_sailed_with_way_through_the_water() -> None:
    approach, _ = coming_in()
    nearly_round = math.radians(-155.0)
    asked = approach.update(downstream(0.3 * RUDDER.top_mps, nearly_round), 0.1)
    assert isinstance(asked, HeadingSetpoint) and asked.wrench.surge_n > 0.0


def test_a_turn_goes_on_to_its_side_until_the_bow_is_nearly_round() -> None:
    approach, _ = coming_in()
    assert helm(approach.update(downstream(0.5, math.radians(-20.0)), 0.1)) == -1.0
    assert helm(approach.update(downstream(0.5, math.radians(20.0)), 0.2)) == -1.0  # a gust blew it across
    assert helm(approach.update(downstream(0.5, math.radians(-130.0)), 9.0)) == -1.0
    assert helm(approach.update(downstream(0.5, math.radians(-160.0)), 11.0)) == 0.0
    approach, _ = coming_in()
    swinging = downstream(0.5, math.radians(-10.0), math.radians(10.0))
    assert helm(approach.update(swinging, 0.1)) == 1.0


def test_the_circle_learns_how_long_it_turns() -> None:
    approach, circle = coming_in()
    believed_s, rate = circle.turning_s, 0.3 * RUDDER.turn_radps
    for tick in range(round(math.radians(170.0) / rate / PERIOD_S)):
        t_s = tick * PERIOD_S
        approach.update(downstream(0.5, 0.1 + rate * t_s, rate), t_s)
    assert circle.turning_s > 1.3 * believed_s
    assert math.pi / rate < 1.1 * circle.turning_s
