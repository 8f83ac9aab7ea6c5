"""Trim of a wing, and the allocation of its angle."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.allocation.sail import SailAllocator
from companion.allocation.wing_trim import WingTrim
from companion.config.vessel import parse
from companion.core.actuation import ThrusterCommand, Wrench
from companion.core.estimate import Rig
from companion.params.store import Parameters
from companion.params.table import table_of
from sitl.foil import Foil
from tests.unit.config.test_sail import wing
from tests.unit.estimates import AT_REST

BOAT = parse(wing(), "wing.toml")
SAIL = BOAT.thrusters[0].sail
assert SAIL is not None
MOST_RAD = math.radians(14.0)
TRIM = WingTrim(SAIL, MOST_RAD)
EVERYTHING, ANY_HEEL = math.inf, math.radians(90.0)
UNDER_WAY = replace(AT_REST, surge_mps=1.0)
FROM_STARBOARD, FROM_PORT = (0.0, -5.0), (0.0, 5.0)  # with the bow north


def served(wrench: Wrench, air: tuple[float, float] | None, ticks: int = 40) -> SailAllocator:
    found = SailAllocator(BOAT, Parameters(dict(BOAT.parameters), table_of(BOAT)))
    found.feel(Rig(air), UNDER_WAY)
    for _ in range(ticks):
        found.update(wrench, 0.1, 1.0)
    return found


def throttle(found: SailAllocator, wrench: Wrench) -> float:
    return found.update(wrench, 0.1, 1.0).thrusters[0].throttle


@pytest.mark.parametrize("off_deg", [30, 60, 90, 120, 150])
def test_no_angle_gives_more_drive_than_the_best(off_deg: float) -> None:
    off = math.radians(off_deg)
    best = TRIM.force(TRIM.best(EVERYTHING, off, 5.0, ANY_HEEL), off, 5.0).drive_n
    assert best > 0.0
    assert all(TRIM.force(MOST_RAD * k / 100, off, 5.0).drive_n <= best + 0.02 for k in range(-100, 101))


def test_less_drive_is_a_smaller_angle_and_none_is_no_angle() -> None:
    off = math.radians(90.0)
    full, some, none = (TRIM.best(n, off, 5.0, ANY_HEEL) for n in (EVERYTHING, 2.0, 0.0))
    assert full == pytest.approx(MOST_RAD)
    assert none == 0.0 < some < full
    assert 1.5 < TRIM.force(some, off, 5.0).drive_n <= 2.0


def test_the_angle_is_smaller_where_the_boat_heels_too_much() -> None:
    off, most = math.radians(45.0), math.radians(15.0)
    assert TRIM.force(TRIM.best(EVERYTHING, off, 9.0, ANY_HEEL), off, 9.0).heel_rad > most
    held = TRIM.force(TRIM.best(EVERYTHING, off, 9.0, most), off, 9.0)
    assert held.heel_rad <= most
    assert held.drive_n > 0.5


@pytest.mark.parametrize("off_deg", [40, 90, 140])
@pytest.mark.parametrize("angle_deg", [0, 5, 10, 14])
def test_it_agrees_with_the_wing_of_the_simulator(off_deg: float, angle_deg: float) -> None:
    """Two polars of different writers, below the stall."""
    off, angle = math.radians(off_deg), math.radians(angle_deg)
    lift, drag = Foil(5.0, math.radians(15.0), 0.04).coefficients(angle)
    pressure = 0.5 * 1.225 * SAIL.area_m2 * 25.0  # type: ignore[union-attr]
    force = TRIM.force(angle, off, 5.0)
    assert force.drive_n == pytest.approx(pressure * (lift * math.sin(off) - drag * math.cos(off)), abs=0.15)


@pytest.mark.parametrize(("air", "side"), [(FROM_PORT, 1.0), (FROM_STARBOARD, -1.0)])
def test_the_wing_turns_to_the_side_of_the_wind(air: tuple[float, float], side: float) -> None:
    wrench = Wrench(20.0, 0.0, 0.0)
    found = served(wrench, air)
    assert throttle(found, wrench) == pytest.approx(side)
    achieved = found.update(wrench, 0.1, 1.0).achieved
    assert achieved.surge_n > 3.0
    assert achieved.sway_n * side > 0.3


def test_after_a_tack_the_wing_goes_over_at_its_rate() -> None:
    wrench = Wrench(20.0, 0.0, 0.0)
    found = served(wrench, FROM_PORT)
    found.feel(Rig(FROM_STARBOARD), UNDER_WAY)
    throttles = [found.update(wrench, 0.5, 1.0) for _ in range(9)]
    assert throttles[0].achieved.surge_n < 0.0, "the wing still stands on the old side"
    assert [each.thrusters[0].throttle for each in throttles][-1] == pytest.approx(-1.0)
    assert throttles[0].thrusters[0].throttle == pytest.approx(0.75)


def test_neutral_and_no_drive_lay_the_wing_in_the_wind() -> None:
    found = served(Wrench(8.0, 0.0, 0.0), FROM_STARBOARD)
    assert found.neutral().thrusters[0].throttle == 0.0
    assert served(Wrench(0.0, 0.0, 0.0), FROM_STARBOARD).update(Wrench(0.0, 0.0, 0.0), 0.1).thrusters[0].throttle == 0.0


def test_the_stick_is_the_angle_and_the_wind_says_to_which_side() -> None:
    for air, side in ((FROM_PORT, 1.0), (FROM_STARBOARD, -1.0)):
        found = served(Wrench(0.0, 0.0, 0.0), air)
        command = ThrusterCommand(8.0, 1.0, 0.0)
        throttles = [found.direct((command,), 1.0).thrusters[0].throttle for _ in range(3)]
        assert throttles == pytest.approx([0.5 * side, side, side])
        backwards = ThrusterCommand(-8.0, -1.0, 0.0)
        assert [found.direct((backwards,), 1.0).thrusters[0].throttle for _ in range(3)][-1] == 0.0
