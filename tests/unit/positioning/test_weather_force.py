"""Where the weather comes from, told from the boat's motion: a hull on paper drifts and speeds up."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.control.model import damping
from companion.core.actuation import Wrench
from companion.core.frames import body_to_ned, ned_to_body
from companion.positioning.weather_force import ON_THE_SIDE, WeatherForce
from tests.unit.estimates import AT_REST

HULL = load(find("revolt")).hull
DT_S = 0.1


@pytest.mark.parametrize("yaw_rad", [0.0, 2.0])
@pytest.mark.parametrize("thrust_n", [0.0, 25.0])
def test_a_boat_that_is_driven_off_knows_the_force_that_would_hold_it(yaw_rad: float, thrust_n: float) -> None:
    """In a current across the hull that it knows, and a wind that it does not."""
    current = (0.1, -0.25)
    wind_x, wind_y = -6.0, -20.0  # on the hull
    x, y = ned_to_body(*current, yaw_rad)
    force, u, v = WeatherForce(HULL), 0.0, 0.0
    for tick in range(600):
        north_mps, east_mps = body_to_ned(u, v, yaw_rad)
        nav = replace(
            AT_REST, t_s=tick * DT_S, yaw_rad=yaw_rad, surge_mps=u, sway_mps=v, north_mps=north_mps, east_mps=east_mps,
            current_north_mps=current[0], current_east_mps=current[1],
        )  # fmt: skip
        force.see(nav, Wrench(0.0, thrust_n, 0.0), DT_S)
        drag_x, drag_y, _ = damping(HULL, u - x, v - y, 0.0)
        u += (wind_x - drag_x) / HULL.m11_kg * DT_S
        v += (thrust_n + wind_y - drag_y) / HULL.m22_kg * DT_S
    rest_x, rest_y, _ = damping(HULL, -x, -y, 0.0)
    assert force.into is not None
    told_x, told_y = ned_to_body(*force.into, yaw_rad)
    assert (told_x, ON_THE_SIDE * told_y) == pytest.approx((rest_x - wind_x, rest_y - wind_y), abs=1.0)


def test_a_turn_of_the_bow_to_waves_does_not_move_their_direction() -> None:
    """A mean of the force itself, most of which is sideways until the bow is there, lagged behind the turn: the bow
    swung 40° to either side of the weather for good."""
    force, yaw_rad, off_deg = WeatherForce(HULL), 0.0, []
    for tick in range(900):
        yaw_rad = min(math.radians(90.0), math.radians(3.0) * max(0.0, tick * DT_S - 15.0))
        ahead, across = ned_to_body(0.0, 1.0, yaw_rad)  # from the east
        force.see(
            replace(AT_REST, t_s=tick * DT_S, yaw_rad=yaw_rad),
            Wrench(2.0 * ahead, 2.0 * ON_THE_SIDE * across, 0.0),
            DT_S,
        )
        if force.into is not None:
            off_deg.append(abs(math.degrees(math.atan2(force.into[1], force.into[0])) - 90.0))
    assert max(off_deg) < 1.0


def test_after_a_gap_the_mean_begins_anew() -> None:
    force = WeatherForce(HULL)
    for tick in range(100):
        force.see(replace(AT_REST, t_s=tick * DT_S), Wrench(0.0, 20.0, 0.0), DT_S)
    assert force.into is not None and math.hypot(*force.into) == pytest.approx(20.0 / ON_THE_SIDE)
    force.see(replace(AT_REST, t_s=100.0, sway_mps=1.0), Wrench(0.0, 0.0, 0.0), DT_S)
    assert force.into is None
