"""What moves among what ranging sensors see, with a simulated lidar's geometry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.core.estimate import Contact
from companion.core.readings import Ranges
from companion.obstacles.movers import Movers
from companion.obstacles.occupancy import Occupancy
from sitl.obstacles import Obstacles, RoundObstacle, Wall

STEP_RAD = math.radians(5.0)


def watched(world: Obstacles, duration_s: float, speed_mps: float = 0.0, stops_s: float = math.inf) -> list[Contact]:
    """What counts as moving at the end, for a boat that goes north. `stops_s`: from then on all things lie."""
    around, movers = Occupancy(), Movers()
    rays = (np.arange(72)[:, None] + (np.arange(5)[None, :] + 0.5) / 5.0 - 0.5) * STEP_RAD
    noise = np.random.default_rng(7)
    t_s = 0.0
    for k in range(round(5.0 * duration_s)):
        t_s = 0.2 * k
        place = (speed_mps * t_s, 0.0)
        distances = world.distances_m(place, rays, min(t_s, stops_s)).min(axis=1) + noise.normal(0.0, 0.05, 72)
        seen = tuple(np.where(distances <= 40.0, distances, math.inf).tolist())
        scan = Ranges(t_s, "lidar", 0.0, STEP_RAD, 0.5, 40.0, False, 0.0, 0.0, seen)
        hits = around.hits(scan, place, 0.0)
        movers.take(hits, around.ages_s(hits, t_s), place, 40.0, t_s)
        around.take(scan, place, 0.0)
    return movers.contacts(t_s)


@pytest.mark.parametrize("north_mps, east_mps", [(0.0, 0.8), (-1.0, 0.0), (-0.5, 0.6)])
def test_a_drifting_thing_moves_as_it_does(north_mps: float, east_mps: float) -> None:
    world = Obstacles()
    world.round.append(RoundObstacle(22.0, -6.0, 1.5, north_mps, east_mps))
    [one] = watched(world, 10.0)
    assert (one.north_mps, one.east_mps) == pytest.approx((north_mps, east_mps), abs=0.2)
    assert math.dist((one.north_m, one.east_m), world.round[0].at(9.8)) < 1.5 and one.mmsi < 0


def test_things_that_lie_do_not_move_when_the_boat_does() -> None:
    world = Obstacles()
    world.round += [RoundObstacle(15.0, 6.0, 2.0), RoundObstacle(20.0, -5.0, 1.0), RoundObstacle(25.0, 9.0, 0.5)]
    assert watched(world, 16.0, speed_mps=1.0) == []


def test_a_quay_does_not_move_when_the_boat_passes_it() -> None:
    world = Obstacles()
    world.walls += [Wall((-50.0, 8.0), (10.0, 8.0)), Wall((22.0, 8.0), (90.0, 8.0))]
    assert watched(world, 16.0, speed_mps=1.0) == []


@pytest.mark.parametrize("duration_s", [6.0, 8.0, 9.0, 12.0, 14.0])
def test_what_passes_a_thing_that_lies_goes_on(duration_s: float) -> None:
    """Seen as one with it, it counted as lying, and was noticed again too late."""
    world = Obstacles()
    world.round += [RoundObstacle(8.0, -6.0, 1.9), RoundObstacle(4.6, -12.0, 1.0, 0.0, 0.6)]
    where = world.round[1].at(duration_s)
    assert min(math.dist((one.north_m, one.east_m), where) for one in watched(world, duration_s)) < 1.0


def test_what_comes_to_lie_beside_another_thing_lies() -> None:
    world = Obstacles()
    world.round += [RoundObstacle(8.0, -6.0, 1.9), RoundObstacle(4.6, -12.0, 1.0, 0.0, 0.6)]
    assert watched(world, 8.0, stops_s=8.0)
    assert watched(world, 22.0, stops_s=8.0) == []


@pytest.mark.parametrize("corner_m, speed_mps, duration_s", [((18.0, 7.0), 1.3, 10.0), ((20.0, 9.0), 1.0, 14.0)])
def test_a_quay_does_not_move_when_the_boat_comes_round_its_corner(
    corner_m: tuple[float, float], speed_mps: float, duration_s: float
) -> None:
    """Of one side less and less was seen, of the other more and more. A boat fled from that mover onto the quay."""
    north_m, east_m = corner_m
    world = Obstacles()
    world.walls += [Wall(corner_m, (north_m, east_m + 30.0)), Wall(corner_m, (north_m + 80.0, east_m))]
    assert watched(world, duration_s, speed_mps=speed_mps) == []


@pytest.mark.parametrize("duration_s", [10.0, 12.0, 14.0, 16.0, 18.0])
def test_what_goes_behind_a_thing_that_lies_comes_out_as_it_went_in(duration_s: float) -> None:
    """Hidden for 10 s, it was forgotten, and had no velocity when it came out again."""
    world = Obstacles()
    world.round += [RoundObstacle(8.0, 0.0, 2.5), RoundObstacle(14.0, -11.0, 1.0, 0.0, 0.9)]
    where = world.round[1].at(duration_s)
    [one] = [one for one in watched(world, duration_s) if math.dist((one.north_m, one.east_m), where) < 2.0]
    assert (one.north_mps, one.east_mps) == pytest.approx((0.0, 0.9), abs=0.2)


def test_what_is_seen_as_one_with_a_thing_that_lies_keeps_its_place_and_velocity() -> None:
    """After 4 s it counted as lying, a mover again when it was alone 3 s later, and as one with the thing for a while."""
    world = Obstacles()
    world.round += [RoundObstacle(6.0, 4.0, 2.3), RoundObstacle(1.5, 15.5, 1.3, 0.15, -0.77)]
    for duration_s in (9.0, 12.0, 14.0, 15.0, 16.0):
        where = world.round[1].at(duration_s)
        found = [one for one in watched(world, duration_s) if math.dist((one.north_m, one.east_m), where) < 1.0]
        assert any(math.hypot(one.north_mps - 0.15, one.east_mps + 0.77) < 0.25 for one in found), duration_s


def test_a_thing_lost_before_does_not_take_the_place_of_what_passes() -> None:
    """A false hit or a stone that is not seen any more took the looks at what came on near it, whose velocity was wrong
    then, or none."""
    movers = Movers()
    for k in range(20):
        t_s = 0.2 * k
        gull = [(8.0, -7.5, 0.3)]  # seen once
        seen = np.array([(8.0, -4.0 + 0.7 * t_s, 0.3)] if k else gull)
        movers.take(seen, np.zeros(len(seen)), (0.0, 0.0), 40.0, t_s)
    [one] = movers.contacts(3.8)
    assert (one.north_mps, one.east_mps) == pytest.approx((0.0, 0.7), abs=0.05)


@pytest.mark.parametrize("duration_s", [11.0, 12.0, 13.0])
def test_a_round_thing_is_no_quay_though_another_lies_in_line_with_it(duration_s: float) -> None:
    """Nothing hid it, but as a piece of a quay it did not count as moving until an Otter had sailed into it."""
    world = Obstacles()
    world.round += [RoundObstacle(5.8, -8.3, 1.63), RoundObstacle(-2.4, -6.8, 1.33)]
    world.round.append(RoundObstacle(9.7, -12.3, 1.85, 0.24, 0.7))
    where = world.round[-1].at(duration_s - 0.2)
    [one] = watched(world, duration_s, speed_mps=1.0)
    assert math.dist((one.north_m, one.east_m), where) < 1.0
    assert (one.north_mps, one.east_mps) == pytest.approx((0.24, 0.7), abs=0.2)
