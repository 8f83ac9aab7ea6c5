"""To which side a thruster that steers the boat alone pushes."""

import itertools
import math
from dataclasses import replace

from companion.allocation.geometry import Thruster
from companion.allocation.lone_side import LoneSide
from companion.config.vessel import find, load

OUTBOARD = replace(
    load(find("revolt")).thrusters[0],
    kind="azimuth",
    x_m=-2.0,
    y_m=0.0,
    azimuth_rad=0.0,
    azimuth_min_rad=-math.radians(35.0),
    azimuth_max_rad=math.radians(35.0),
    azimuth_rate_radps=1.0,
    forbidden_rad=(),
    max_n=2200.0,
    min_n=-1300.0,
    ahead_n=2200.0,
    astern_n=1300.0,
    force_rate_nps=4000.0,
)
LIMITS = (1980.0, 1.0, 2300.0)
DT_S = 0.1


def sides(surge_n: list[float], yaw_nm: float) -> list[bool]:
    """Whether it pushes ahead, cycle by cycle, as the boat makes way: the thruster goes where it is to go."""
    thruster = Thruster(OUTBOARD)
    side, azimuth_rad, force_n, found = LoneSide(thruster, LIMITS), math.radians(-35.0), 600.0, []
    for x_n in surge_n:
        side.update((x_n, yaw_nm), (x_n, yaw_nm / thruster.x_m), force_n, azimuth_rad, True, DT_S)
        if side.aim_rad is not None:
            step_rad = thruster.azimuth_rate_radps * DT_S
            azimuth_rad += min(step_rad, max(-step_rad, side.aim_rad - azimuth_rad))
        force_n = 600.0 if side.ahead else -600.0
        found.append(side.ahead)
    return found


def changes(found: list[bool]) -> int:
    return sum(before is not after for before, after in itertools.pairwise(found))


def test_a_demand_about_the_limit_of_braking_does_not_turn_it_to_and_fro() -> None:
    """In waves it did for half a minute, between ahead and astern, without thrust, and the boat went on."""
    about = [-198.0 + 15.0 * math.sin(1.7 * i * DT_S) for i in range(400)]
    found = sides(about, 1300.0)
    assert changes(found) <= 1 and not found[-1]


def test_it_pushes_ahead_again_when_the_boat_is_no_longer_to_brake() -> None:
    found = sides([-400.0] * 100 + [20.0] * 100, 1300.0)
    assert found[0] and not found[99] and found[-1]


def test_a_boat_that_makes_way_and_hardly_brakes_is_pushed_ahead() -> None:
    assert all(sides([-150.0] * 200, 1300.0))
