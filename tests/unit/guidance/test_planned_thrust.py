"""Thrust that a plan counts on, and the speeds that it can follow."""

from __future__ import annotations

import numpy as np
import pytest

from companion.config.vessel import find, load
from companion.guidance.agility import Agility, Weather, agility_of
from companion.guidance.planned_thrust import Floats, PlannedThrust

SHARE, LEG_MPS = 0.2, 1.2


def agility() -> Agility:
    found = agility_of(load(find("aboat")))
    assert found is not None
    return found


def followed(limit_mps: Floats, weather: Weather | None = None, stop: bool = False) -> tuple[PlannedThrust, Floats]:
    """A straight track to the north, a sample each 0.1 m, with a speed limit at each."""
    s_m = 0.1 * np.arange(len(limit_mps))
    thrust = PlannedThrust(s_m, 0.0 * s_m, 0.0 * s_m + LEG_MPS, agility(), weather or Weather())
    return thrust, thrust.followed(limit_mps, SHARE, stop)


def slow_place() -> Floats:
    """Slow at 20 m of 40 m."""
    limit = np.full(400, LEG_MPS)
    limit[200] = 0.6
    return limit


def test_a_straight_leg_is_sailed_at_its_limit() -> None:
    thrust, speed = followed(np.full(400, LEG_MPS))
    assert speed == pytest.approx(np.full(400, LEG_MPS))
    assert float(np.max(thrust.high_n)) < agility().most_n


def test_ahead_of_a_slow_place_the_drag_brakes_and_no_thruster_reverses() -> None:
    thrust, speed = followed(slow_place())
    assert float(speed[200]) == pytest.approx(0.6)
    assert float(np.min(thrust.low_n)) >= 0.0
    early = int(np.argmax(speed < LEG_MPS - 1.0e-3))
    assert 170 < early < 195, "it begins to slow down a metre or two before"
    assert float(speed[20]) == pytest.approx(LEG_MPS) == pytest.approx(float(speed[-1]))


def test_a_stop_may_reverse() -> None:
    thrust, speed = followed(np.full(400, LEG_MPS), stop=True)
    assert float(speed[-1]) == 0.0
    assert float(thrust.low_n[-1]) < 0.0


def test_against_a_strong_stream_it_takes_longer_to_speed_up() -> None:
    _, calm = followed(slow_place())
    _, against = followed(slow_place(), Weather(water_north_mps=-1.0))
    regained = [int(np.argmax(speed[200:] > 1.15)) for speed in (calm, against)]
    assert regained[1] > 1.2 * regained[0] > 0
    assert float(against[195]) > float(calm[195]), "and brakes the better"
