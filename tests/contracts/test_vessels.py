"""What every bundled vessel keeps: it loads, its simulation runs, and its controller's demands can be met."""

import math

import pytest

from companion.allocation.allocator import Allocator
from companion.config.dimensions.limits import largest
from companion.config.reversing import can_reverse
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import bundled, find, load
from companion.core.actuation import Wrench
from companion.params.store import Parameters
from companion.params.table import table_of
from sitl.sensors import GRADES
from sitl.world import World, WorldConditions

NAMES = bundled()


@pytest.mark.parametrize("name", NAMES)
def test_its_parameters_are_within_the_table(name: str) -> None:
    boat = load(find(name))
    values = Parameters(boat.parameters, table_of(boat))
    assert values["DP_ALARM_R"] > values["DP_WATCH_R"]
    assert values["WP_SPEED"] <= 1.02 * top_speed_mps(boat)


@pytest.mark.parametrize("name", NAMES)
def test_its_fence_leaves_room_for_what_its_hold_needs(name: str) -> None:
    """A boat without sideways thrust drifts within its watch circle while it turns its bow to the wind."""
    boat = load(find(name))
    values = Parameters(boat.parameters, table_of(boat))
    needed_m = 0.0 if boat.limits.sway_n > 0.0 else values["DP_WATCH_R"]
    assert values["FENCE_MARGIN"] >= needed_m - 1e-3


@pytest.mark.parametrize("name", NAMES)
def test_its_simulated_boat_drifts_with_the_stream_and_stays_finite(name: str) -> None:
    boat = load(find(name))
    assert boat.sitl is not None and boat.sitl.gnss in GRADES
    world = World(boat, WorldConditions(seed=3, wind="5@0", current="0.3@90"))
    world.advance(20.0)
    truth = world.truth
    assert 0.5 < math.hypot(truth.north_m, truth.east_m) < 40.0 and truth.east_m > 0.0


@pytest.mark.parametrize("name", [name for name in NAMES if load(find(name)).thrusters[0].kind not in ("jet", "sail")])
def test_its_thrusters_give_the_limits_one_axis_at_a_time(name: str) -> None:
    boat = load(find(name))
    values = Parameters(boat.parameters, table_of(boat))
    limits = boat.limits
    for wrench in (Wrench(limits.surge_n, 0.0, 0.0), Wrench(0.0, 0.0, limits.yaw_nm)):
        allocator = Allocator(boat, values)
        for _ in range(200):
            achieved = allocator.update(wrench, 0.1).achieved
        assert achieved.surge_n == pytest.approx(wrench.surge_n, abs=0.15 * limits.surge_n)
        assert achieved.yaw_nm == pytest.approx(wrench.yaw_nm, abs=0.15 * limits.yaw_nm)


@pytest.mark.parametrize("name", ["blueboat", "heron", "otter", "wamv16"])
def test_the_published_catamarans_steer_by_the_difference_of_two_fixed_thrusters(name: str) -> None:
    boat = load(find(name))
    assert [thruster.kind for thruster in boat.thrusters] == ["fixed", "fixed"] and can_reverse(boat.thrusters)
    assert boat.limits.sway_n == 0.0 and largest(boat.thrusters, 1) < 1.0
    assert boat.hull.form == "catamaran"
