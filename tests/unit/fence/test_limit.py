"""The speed limit before the fence: where a boat comes to rest that goes as fast as it may, and lags behind."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.fence.area import FenceArea
from companion.fence.areas import FenceAreas
from companion.fence.limit import closing_limits, speed_limit
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST

DT_S = 0.1
LINE_M, HALF_M, MARGIN_M = 40.0, 1.5, 0.5
FENCE = FenceArea({0: [[(LINE_M, -50.0), (LINE_M, 50.0), (-50.0, 50.0), (-50.0, -50.0)]]}, [])
AREAS = FenceAreas(FENCE, FENCE.shrunk(HALF_M), FENCE.shrunk(HALF_M + MARGIN_M))


def rest_m(from_m: float, speed_mps: float, accuracy_m: float) -> tuple[float, float]:
    """Where the boat is after ten minutes at the limit, and how fast."""
    parameters = Parameters()
    lag_s = 1.0 / parameters["PATH_BW_SURGE"]
    north_m = from_m
    for _ in range(6000):
        nav = replace(AT_REST, north_m=north_m, north_mps=speed_mps, position_accuracy_m=accuracy_m)
        limit = speed_limit(AREAS, nav, (1.0, 0.0), parameters)
        speed_mps += ((min(1.0, limit.speed_mps) - speed_mps) / lag_s - limit.braking_mps2) * DT_S
        north_m += speed_mps * DT_S
    return north_m, speed_mps


@pytest.mark.parametrize("accuracy_m", [0.02, 0.5, 1.5])
@pytest.mark.parametrize(("from_m", "speed_mps"), [(0.0, 0.0), (37.0, 0.05), (38.2, 0.0)])
def test_a_boat_that_creeps_on_stays_with_its_bow_inside(from_m: float, speed_mps: float, accuracy_m: float) -> None:
    north_m, speed_mps = rest_m(from_m, speed_mps, accuracy_m)
    assert LINE_M - HALF_M - 0.1 <= north_m <= LINE_M - HALF_M + 0.02  # it gets there, however inaccurate its position
    assert speed_mps < 0.005


def test_a_boat_over_the_edge_may_move_along_the_line_and_inwards_but_not_outwards() -> None:
    over = replace(AT_REST, north_m=LINE_M - HALF_M + 0.3, position_accuracy_m=0.02)
    assert speed_limit(AREAS, over, (0.0, 1.0), Parameters()).speed_mps > 1.0
    assert speed_limit(AREAS, over, (-1.0, 0.0), Parameters()).speed_mps > 1.0
    assert speed_limit(AREAS, over, (1.0, 0.0), Parameters()).speed_mps == 0.0


@pytest.mark.parametrize("beside_m", [0.9, 0.4, 0.0, -0.3])
@pytest.mark.parametrize("accuracy_m", [0.02, 0.5])
@pytest.mark.parametrize("turn_deg", [0.0, 20.0, -20.0])
def test_close_along_one_line_it_stops_before_the_next(beside_m: float, accuracy_m: float, turn_deg: float) -> None:
    """Along a quay, nearer to its line than twice the position's accuracy, the line at its end did not count until it
    was the nearest: ÅBOAT sailed 2.6 m over it at full stick. `turn_deg`: of its course, away from the near line."""
    parameters, turn = Parameters(), math.radians(turn_deg)
    lag_s, speed_mps, north_m, east_m = 1.0 / parameters["PATH_BW_SURGE"], 0.0, 0.0, 50.0 - HALF_M - beside_m
    for _ in range(900):
        north_mps, east_mps = speed_mps * math.cos(turn), -speed_mps * math.sin(turn)
        nav = replace(AT_REST, north_m=north_m, east_m=east_m, north_mps=north_mps, east_mps=east_mps)
        nav = replace(nav, position_accuracy_m=accuracy_m)
        limit = speed_limit(AREAS, nav, (math.cos(turn), -math.sin(turn)), parameters)
        speed_mps += ((min(2.0, limit.speed_mps) - speed_mps) / lag_s - limit.braking_mps2) * DT_S
        north_m, east_m = north_m + north_mps * DT_S, east_m + east_mps * DT_S
        assert speed_mps < 2.1
    assert north_m < LINE_M - HALF_M + 0.03 and abs(speed_mps) < 0.06
    assert turn_deg < 0.0 or north_m > LINE_M - HALF_M - 2.0 * accuracy_m - 0.3, "and it gets there"


@pytest.mark.parametrize(("edge_m", "least_mps", "most_mps"), [(5.0, 0.3, 2.0), (0.1, 0.0, 0.06), (-0.2, 0.0, 0.0)])
def test_what_pushes_aside_out_is_limited_where_the_boat_goes_along_the_line(
    edge_m: float, least_mps: float, most_mps: float
) -> None:
    """A light boat with 100 N of stick gathered 0.3 m/s out of its fence in 0.3 s, before its course had turned."""
    along, out = (0.0, 1.0), (1.0, 0.2)
    nav = replace(AT_REST, north_m=LINE_M - HALF_M - edge_m, east_mps=1.0, position_accuracy_m=0.02)
    (limit,) = closing_limits(AREAS, nav, out, along, Parameters())
    assert limit.way == pytest.approx((1.0, 0.0)) and least_mps <= limit.speed_mps <= most_mps
    assert closing_limits(AREAS, nav, (-1.0, 0.2), along, Parameters()) == []
    assert closing_limits(AREAS, nav, out, (1.0, 0.0), Parameters()) == [], "the limit along the course does that"
    outside = replace(nav, north_m=LINE_M + 1.0)
    assert closing_limits(AREAS, outside, (-1.0, 0.2), along, Parameters()) == [], "it may come back"
