"""Close along one line of the fence, the action comes in time for the next one."""

from __future__ import annotations

import math

import pytest

from companion.core.decision import ModeId
from tests.unit.conftest import Boat
from tests.unit.fence.test_guard import armed_in, at, fence

HALF_M = 1.5  # of ReVolt's length


@pytest.mark.parametrize(("from_m", "speed_mps", "mode"), [(-30.0, 1.0, ModeId.HOLD), (-30.0, 0.0, ModeId.MANUAL)])
def test_a_boat_armed_close_along_a_quay_is_stopped_before_the_line_at_its_end(
    boat: Boat, from_m: float, speed_mps: float, mode: ModeId
) -> None:
    """Armed nearer to a line than FENCE_MARGIN, it was left to the operator until another line was the nearest: in
    Manual it sailed over that at full speed."""
    fence(boat)
    beside_m = 50.0 - HALF_M - 0.1
    at(boat, from_m, beside_m)
    armed_in(boat, ModeId.MANUAL)
    north_m = from_m
    for _ in range(160):
        north_m += 0.5 * speed_mps
        at(boat, north_m, beside_m, north_mps=speed_mps)
        boat.step()
        if boat.status.mode is not ModeId.MANUAL:
            break
    assert boat.status.mode is mode
    assert speed_mps == 0.0 or 38.0 <= north_m <= 42.0, "a stop from 1 m/s takes some 7 m"
    if speed_mps > 0.0:
        assert f"Fence {50.0 - north_m:.0f} m ahead: Hold" in boat.texts(), "not how far the quay is"


def test_away_from_the_near_line_it_is_left_to_the_operator(boat: Boat) -> None:
    fence(boat)
    at(boat, 0.0, 50.0 - HALF_M - 0.1)
    armed_in(boat, ModeId.MANUAL)
    at(boat, 0.0, 50.0 - HALF_M - 0.1, north_mps=0.3, east_mps=-0.8)
    boat.step()
    assert boat.status.mode is ModeId.MANUAL and not boat.status.failsafes


@pytest.mark.parametrize("beside_m", [0.0, 5.0])
def test_what_is_steered_from_elsewhere_stops_before_the_next_line(boat: Boat, beside_m: float) -> None:
    """Off a line by less than plans keep, a velocity a little inwards counted as one that leads in, without a limit."""
    fence(boat)
    east_m = 50.0 - HALF_M - 0.1 - beside_m
    speeds = [boat.fence_guard.reach_mps((north_m, east_m), (1.0, -0.02), 0.1) for north_m in (0.0, 38.0, 47.9)]
    assert speeds == pytest.approx([math.sqrt(0.2 * way_m) for way_m in (48.0, 10.0, 0.1)], abs=0.01)
    assert boat.fence_guard.reach_mps((0.0, 49.0), (1.0, 0.02), 0.1) == 0.0
