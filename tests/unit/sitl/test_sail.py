"""The simulated rig: signs of its forces, heel, and the polar of the whole boat against what such boats do."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import pytest

from companion.config.vessel import find, load, parse
from sitl.hull_flow import hull_of
from sitl.sail import SailRig, rig_of
from sitl.world import chosen_plant
from tests.unit.config.test_sail import wing

BOAT = load(find("sailbot"))


def rig(sheet: float = 0.5) -> SailRig:
    found = rig_of(BOAT.thrusters[0], 0.0, None)
    assert found is not None
    found.drive(sheet)
    return found


def settled(model: SailRig, ahead_mps: float, starboard_mps: float) -> tuple[float, float, float]:
    for _ in range(1000):
        model.feel(ahead_mps, starboard_mps)
        model.step(0.01, 1.0)
    return model.wrench()


def test_wind_from_port_pushes_ahead_and_to_starboard_heels_to_starboard_and_turns_to_the_wind() -> None:
    model = rig()
    surge_n, sway_n, yaw_nm = settled(model, 0.0, 6.0)
    assert surge_n > 3.0
    assert sway_n > 0.5
    assert yaw_nm < 0.0
    assert 0.02 < model.heel_rad < 0.6


def test_the_other_tack_is_its_mirror() -> None:
    port, starboard = settled(rig(), -3.0, 5.0), settled(rig(), -3.0, -5.0)
    assert starboard == pytest.approx((port[0], -port[1], -port[2]))


def test_a_free_sheet_gives_no_drive_with_the_wind_ahead_of_the_beam() -> None:
    assert settled(rig(0.0), -3.0, 5.0)[0] < 0.0


def test_the_rudder_turns_the_boat_the_way_of_its_sign() -> None:
    model = rig(0.0)
    model.aim(0.3)  # pushes the stern to starboard
    assert settled(model, 0.0, 0.0)[2] < 0.0


def test_a_thruster_of_another_kind_is_no_rig() -> None:
    assert rig_of(load(find("revolt")).thrusters[0], 0.0, None) is None


@cache
def speed(wind_mps: float, off_deg: float) -> tuple[float, float]:
    """(speed through the water, speed made good against the wind) at the best of a few sheets, with the heading held by
    a plain law on the rudder: hull and rig of the plant alone."""
    return max(_sailed(wind_mps, off_deg, boom) for boom in (5.0, 10.0, 15.0, 25.0, 40.0, 60.0, 80.0))


def _sailed(wind_mps: float, off_deg: float, boom_deg: float) -> tuple[float, float]:
    wanted, sail = math.radians(off_deg), BOAT.thrusters[0].sail
    plant = chosen_plant(BOAT, None)
    hull, model = hull_of(BOAT, plant), rig_of(BOAT.thrusters[0], plant.thruster_lag_s, plant.keel)
    assert model is not None and sail is not None
    hull.place(0.0, 0.0, wanted, 0.5)
    model.drive(sail.sheet(math.radians(boom_deg)))
    integral = 0.0
    for _ in range(3000):
        error = math.remainder(hull.yaw_rad - wanted, math.tau)
        integral += 0.01 * error
        model.aim(max(-0.4, min(0.4, 2.0 * error + 0.8 * hull.yaw_rate_radps + 0.5 * integral)))
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        north, east = -wind_mps - hull.north_mps, -hull.east_mps
        model.feel(c * north + s * east, c * east - s * north)
        model.step(0.01, hull.water_surge_mps, hull.water_sway_mps, hull.yaw_rate_radps)
        hull.step(*model.wrench(), 0.01)
    on_course = abs(math.remainder(hull.yaw_rad - wanted, math.tau)) < 0.1
    return (hull.water_surge_mps, hull.north_mps) if on_course else (0.0, 0.0)


def test_its_polar_has_a_no_go_zone_and_is_fastest_on_a_reach() -> None:
    """A boat of 1.2 m reaches 1.2 m/s with a small rig and 1.5 m/s with a large one (Miller et al. 2013)."""
    speeds = {off: speed(5.0, off)[0] for off in (20.0, 45.0, 90.0, 180.0)}
    assert speeds[20.0] < 0.6 * speeds[45.0] < speeds[90.0]
    assert 1.0 < speeds[90.0] < 1.8
    assert speeds[180.0] < speeds[90.0]


def test_it_makes_most_good_against_the_wind_at_about_45_degrees() -> None:
    good = {off: speed(5.0, off)[1] for off in (25.0, 45.0, 65.0)}
    assert good[45.0] > good[25.0]
    assert good[45.0] > good[65.0]
    assert 0.5 < good[45.0] < 1.0


def test_more_wind_heels_it_more() -> None:
    heels = []
    for wind_mps in (4.0, 8.0):
        model = rig(1.0)
        settled(model, -0.7 * wind_mps, 0.7 * wind_mps)
        heels.append(model.heel_rad)
    assert 0.1 < heels[0] < heels[1] < 1.2


def test_a_stronger_sail_is_stronger() -> None:
    config = BOAT.thrusters[0]
    assert config.sail is not None
    stronger = rig_of(replace(config, sail=replace(config.sail, force_scale=1.2)), 0.0, None)
    assert stronger is not None
    stronger.drive(0.5)
    assert settled(stronger, 0.0, 3.0)[0] > 1.1 * settled(rig(), 0.0, 3.0)[0]


# --- wing ----------------------------------------------------------------------------------------------------------


def wing_rig(throttle: float) -> SailRig:
    found = rig_of(parse(wing(), "wing.toml").thrusters[0], 0.0, None)
    assert found is not None
    found.drive(throttle)
    return found


@pytest.mark.parametrize("wind", [(-5.0, 0.0), (-3.0, 4.0), (-3.0, -4.0), (0.0, 5.0), (3.0, 4.0), (5.0, 0.0)])
def test_a_wing_amidships_has_drag_alone_in_every_wind(wind: tuple[float, float]) -> None:
    surge_n, sway_n, _ = settled(wing_rig(0.0), *wind)
    surge_n -= settled(wing_rig(0.0), 0.0, 0.0)[0]  # the rudder's drag
    assert math.hypot(surge_n, sway_n) == pytest.approx(0.5 * 1.225 * 0.512 * 25.0 * 0.04, rel=0.05)
    assert surge_n * wind[0] >= 0.0
    assert sway_n * wind[1] >= 0.0


def test_a_wing_drives_with_the_wind_on_either_side_and_its_tacks_are_mirrors() -> None:
    port, starboard = settled(wing_rig(1.0), -3.0, 4.0), settled(wing_rig(-1.0), -3.0, -4.0)
    assert port[0] > 2.0
    assert port[1] > 2.0
    assert starboard == pytest.approx((port[0], -port[1], -port[2]))
    assert settled(wing_rig(-1.0), -3.0, 4.0)[0] < 0.0


def test_a_wing_heels_to_leeward() -> None:
    model = wing_rig(1.0)
    settled(model, -3.0, 4.0)
    assert 0.05 < model.heel_rad < 0.6
