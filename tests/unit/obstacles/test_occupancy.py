"""The map of what ranging sensors see: it keeps what they see, loses what they look through, and forgets."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.core.readings import Ranges
from companion.obstacles.occupancy import Occupancy

STEP_RAD = math.radians(5.0)
HERE = (0.0, 0.0)


def scan(t_s: float, distances: dict[int, float], rest: float = math.inf) -> Ranges:
    """All around from the bow on; `distances` by sector."""
    values = tuple(distances.get(i, rest) for i in range(72))
    return Ranges(t_s, "lidar", 0.0, STEP_RAD, 0.5, 40.0, False, 0.0, 0.0, values)


@given(st.integers(0, 71), st.floats(1.0, 39.0), st.floats(-math.pi, math.pi))
def test_a_hit_lies_where_it_was_measured(sector: int, off_m: float, yaw_rad: float) -> None:
    around = Occupancy()
    around.take(scan(0.0, {sector: off_m}), HERE, yaw_rad)
    [(north_m, east_m, radius_m)] = around.circles.tolist()
    bearing = yaw_rad + sector * STEP_RAD
    place = off_m * math.cos(bearing), off_m * math.sin(bearing)
    assert math.dist((north_m, east_m), place) <= radius_m <= max(0.25, 0.5 * STEP_RAD * off_m) + 1e-9


def test_what_is_seen_again_is_one_thing() -> None:
    around = Occupancy()
    for k in range(20):
        around.take(scan(0.2 * k, {3: 10.0 + 0.05 * (-1) ** k}), HERE, 0.0)
    assert len(around.circles) == 1


def test_what_is_looked_through_is_gone_after_three_looks() -> None:
    around = Occupancy()
    around.take(scan(0.0, {3: 10.0}), HERE, 0.0)
    for k in range(2):
        around.take(scan(0.2 + 0.2 * k, {}), HERE, 0.0)
        assert len(around.circles) == 1
    around.take(scan(0.6, {}), HERE, 0.0)
    assert len(around.circles) == 0


def test_what_something_nearer_hides_stays() -> None:
    around = Occupancy()
    around.take(scan(0.0, {3: 30.0}), HERE, 0.0)
    for k in range(10):
        around.take(scan(0.2 + 0.2 * k, {2: 10.0, 3: 10.0, 4: 10.0}), HERE, 0.0)
    assert np.hypot(*around.circles[:, :2].T).max() == pytest.approx(30.0, abs=1.5)


def test_sectors_without_knowledge_take_nothing_away() -> None:
    around = Occupancy()
    around.take(scan(0.0, {3: 10.0}), HERE, 0.0)
    for k in range(10):
        around.take(scan(0.2 + 0.2 * k, {}, rest=math.nan), HERE, 0.0)
    assert len(around.circles) == 1


def test_a_finer_look_replaces_a_coarse_one() -> None:
    around = Occupancy()
    around.take(scan(0.0, {0: 36.0}), HERE, 0.0)
    coarse = around.circles[0, 2]
    around.take(scan(1.0, {0: 8.0}), (28.5, 0.0), 0.0)
    assert len(around.circles) == 1 and around.circles[0, 2] < 0.3 * coarse


def test_old_and_far_things_are_forgotten() -> None:
    around = Occupancy()
    around.take(scan(0.0, {3: 10.0}), HERE, 0.0)
    around.forget(59.0, 60.0, HERE, 100.0)
    assert len(around.circles) == 1
    around.forget(61.0, 60.0, HERE, 100.0)
    assert len(around.circles) == 0
    around.take(scan(62.0, {3: 10.0}), HERE, 0.0)
    around.forget(62.0, 60.0, (200.0, 0.0), 100.0)
    assert len(around.circles) == 0


def test_the_age_of_a_place_goes_over_to_a_finer_look() -> None:
    around = Occupancy()
    around.take(scan(0.0, {0: 36.0}), HERE, 0.0)
    nearer = scan(5.0, {0: 8.0})
    around.take(nearer, (28.5, 0.0), 0.0)
    assert around.ages_s(around.hits(nearer, (28.5, 0.0), 0.0), 9.0).tolist() == [9.0]


def test_what_a_single_scan_sees_is_not_confirmed() -> None:
    around = Occupancy()
    around.take(scan(0.0, {3: 10.0, 20: 10.0}), HERE, 0.0)
    assert len(around.circles) == 2 and not len(around.confirmed)
    around.take(scan(0.2, {3: 10.0}), HERE, 0.0)
    [(north_m, east_m, _)] = around.confirmed.tolist()
    assert math.hypot(north_m, east_m) == pytest.approx(10.0, abs=0.5) and len(around.circles) == 2


def test_a_finer_look_at_what_is_confirmed_is_confirmed_at_once() -> None:
    around = Occupancy()
    for t_s in (0.0, 1.0):
        around.take(scan(t_s, {0: 36.0}), HERE, 0.0)
    around.take(scan(2.0, {0: 8.0}), (28.5, 0.0), 0.0)
    assert len(around.confirmed) == 1
