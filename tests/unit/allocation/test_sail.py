"""Sail trim and the allocation of sheet and rudder."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.allocation.sail import SailAllocator
from companion.allocation.sail_trim import SailTrim
from companion.config.vessel import find, load, parse
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.estimate import Rig
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.config.test_sail import with_motor
from tests.unit.estimates import AT_REST

BOAT = load(find("sailbot"))
SAIL = BOAT.thrusters[0].sail
assert SAIL is not None
TRIM = SailTrim(SAIL)
EVERYTHING, ANY_HEEL = math.inf, math.radians(90.0)
UNDER_WAY = replace(AT_REST, surge_mps=1.0)
FROM_STARBOARD = (0.0, -5.0)  # blows to the west, with the bow north


def allocator() -> SailAllocator:
    return SailAllocator(BOAT, Parameters(dict(BOAT.parameters), table_of(BOAT)))


def served(wrench: Wrench, air: tuple[float, float] | None, surge_mps: float = 1.0, ticks: int = 40) -> SailAllocator:
    found = allocator()
    found.feel(Rig(air), UNDER_WAY)
    for _ in range(ticks):
        found.update(wrench, 0.1, surge_mps)
    return found


@pytest.mark.parametrize(("off_deg", "low_deg", "high_deg"), [(35, 10, 30), (90, 55, 85), (180, 80, 90)])
def test_the_boom_goes_out_as_the_wind_comes_aft(off_deg: float, low_deg: float, high_deg: float) -> None:
    boom = math.degrees(TRIM.best(EVERYTHING, math.radians(off_deg), 5.0, ANY_HEEL))
    assert low_deg <= boom <= high_deg


def test_no_boom_gives_more_drive_than_the_best() -> None:
    for off_deg in range(25, 181, 15):
        off = math.radians(off_deg)
        best = TRIM.force(TRIM.best(EVERYTHING, off, 5.0, ANY_HEEL), off, 5.0).drive_n
        assert all(TRIM.force(math.radians(b), off, 5.0).drive_n <= best * 1.03 + 0.05 for b in range(5, 86))


def test_less_drive_is_given_by_easing_the_sheet() -> None:
    off = math.radians(70.0)
    full, half = (TRIM.best(n, off, 5.0, ANY_HEEL) for n in (EVERYTHING, 2.0))
    assert half > full
    assert TRIM.force(half, off, 5.0).drive_n <= 2.0


def test_the_sheet_is_eased_where_the_boat_heels_too_much() -> None:
    off, most = math.radians(45.0), math.radians(20.0)
    assert TRIM.force(TRIM.best(EVERYTHING, off, 9.0, ANY_HEEL), off, 9.0).heel_rad > most
    assert TRIM.force(TRIM.best(EVERYTHING, off, 9.0, most), off, 9.0).heel_rad <= most


def test_no_drive_is_a_free_sheet() -> None:
    allocation = served(Wrench(0.0, 0.0, 0.0), FROM_STARBOARD).update(Wrench(0.0, 0.0, 0.0), 0.1, 1.0)
    assert allocation.thrusters[0].throttle == 0.0


def test_neutral_is_a_free_sheet_and_the_rudder_amidships() -> None:
    found = served(Wrench(8.0, 0.0, -2.0), FROM_STARBOARD)
    for _ in range(10):
        allocation = found.neutral()
    assert (allocation.thrusters[0].throttle, allocation.thrusters[0].azimuth_rad) == (0.0, 0.0)


def test_what_is_achieved_has_the_side_force_to_leeward() -> None:
    close = (-4.0, -4.0)
    achieved = served(Wrench(8.0, 0.0, 0.0), close).update(Wrench(8.0, 0.0, 0.0), 0.1, 1.0).achieved
    assert achieved.surge_n > 2.0
    assert achieved.sway_n < -2.0


def test_the_rudder_gives_the_moment() -> None:
    allocation = served(Wrench(8.0, 0.0, 0.5), FROM_STARBOARD).update(Wrench(8.0, 0.0, 0.5), 0.1, 1.0)
    assert allocation.achieved.yaw_nm == pytest.approx(0.5, abs=0.05)


def test_with_sternway_the_rudder_is_put_over_the_other_way() -> None:
    def angle(surge_mps: float) -> float:
        wrench = Wrench(0.0, 0.0, 1.0)
        command = served(wrench, None, surge_mps).update(wrench, 0.1, surge_mps).thrusters[0]
        assert command.azimuth_rad is not None
        return command.azimuth_rad

    assert angle(0.5) < 0.0 < angle(-0.5)


def test_in_a_turn_the_rudder_s_angle_counts_from_the_flow_at_the_stern() -> None:
    """Turning to starboard the stern swings to port: for no moment the blade lies in that flow."""
    found = allocator()
    found.feel(Rig(FROM_STARBOARD), replace(UNDER_WAY, yaw_rate_radps=0.5))
    for _ in range(10):
        allocation = found.update(Wrench(0.0, 0.0, 0.0), 0.1, 1.0)
    assert allocation.thrusters[0].azimuth_rad == pytest.approx(0.7 * math.atan2(-0.653 * 0.5, 1.0), abs=0.02)
    assert allocation.achieved.yaw_nm == pytest.approx(0.0, abs=0.05)


def test_sticks_haul_the_sheet_at_the_rate_of_the_winch() -> None:
    found = allocator()
    command = ThrusterCommand(8.0, 1.0, 0.2)
    throttles = [found.direct((command,), 0.5).thrusters[0].throttle for _ in range(5)]
    assert throttles == pytest.approx([0.25, 0.5, 0.75, 1.0, 1.0])


def test_without_a_new_wind_it_trims_by_the_last() -> None:
    found = served(Wrench(8.0, 0.0, 0.0), FROM_STARBOARD)
    before = found.update(Wrench(8.0, 0.0, 0.0), 0.1, 1.0).thrusters[0].throttle
    found.feel(Rig(None), UNDER_WAY)
    assert found.update(Wrench(8.0, 0.0, 0.0), 0.1, 1.0).thrusters[0].throttle == before


# --- motors beside the sail ----------------------------------------------------------------------------------------

FOR_MOTOR = parse(with_motor(), "boat.toml")
ASKED = Wrench(5.0, 0.0, 0.0)


def driven(air: tuple[float, float], sails: bool = True, motors: bool = True, failed: int | None = None) -> Allocation:
    found = SailAllocator(FOR_MOTOR, Parameters(dict(FOR_MOTOR.parameters), table_of(FOR_MOTOR)))
    if failed is not None:
        found.set_failed(failed, True)
    found.feel(Rig(air, sails, motors), UNDER_WAY)
    for _ in range(40):
        allocation = found.update(ASKED, 0.1, 1.0)
    return allocation


def test_the_motor_gives_what_the_sail_does_not() -> None:
    light = driven((0.0, -1.5))
    sheet, motor = light.thrusters
    assert sheet.throttle > 0.0
    assert 4.0 < motor.force_n < 5.0
    assert light.achieved.surge_n == pytest.approx(5.0, abs=0.1)
    assert not light.limited[0]


def test_a_motor_that_is_not_used_stands_and_one_that_is_used_alone_pushes_with_a_free_sheet() -> None:
    under_sail, alone = driven(FROM_STARBOARD, motors=False), driven(FROM_STARBOARD, sails=False)
    assert under_sail.thrusters[1].throttle == 0.0
    assert alone.thrusters[0].throttle == 0.0
    assert alone.thrusters[1].force_n > 5.0, "more than is asked for: the free sail has drag"


def test_a_failed_motor_gives_nothing_and_a_failed_sail_leaves_the_motor() -> None:
    still = (0.0, 0.0)
    assert driven(still, failed=1).thrusters[1].force_n == 0.0
    assert driven(still, failed=0).thrusters[1].force_n == pytest.approx(5.0, abs=0.1)


def test_by_hand_the_motor_takes_its_throttle_and_disarmed_it_stops() -> None:
    found = SailAllocator(FOR_MOTOR, Parameters(dict(FOR_MOTOR.parameters), table_of(FOR_MOTOR)))
    demands = (ThrusterCommand(0.0, 0.0, 0.0), ThrusterCommand(-3.0, -1.0, None))
    for _ in range(5):
        motor = found.direct(demands, 0.1).thrusters[1]
    assert motor.force_n == pytest.approx(-3.0)
    assert found.neutral().thrusters[1].throttle == 0.0
