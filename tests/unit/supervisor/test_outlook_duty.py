"""What is told at the upload and at the start of a mission: its length, a long first leg, a battery too small."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.core.decision import ModeId, Severity
from companion.core.readings import Battery
from companion.mission.plan import PlanKind
from companion.supervisor.outlook_duty import BatteryUse
from tests.unit.conftest import Boat

MakeBoat = Callable[..., Boat]


def started(boat: Boat) -> None:
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step(1.0)


def test_an_upload_is_told_with_its_length_and_time(boat: Boat) -> None:
    boat.upload((300.0, 0.0), (300.0, 300.0))
    boat.step()
    assert "Mission: 600 m, 17 min" in boat.texts() and boat.severities["mission_length"] is Severity.INFO
    assert "first_leg" not in boat.names()
    started(boat)
    assert boat.texts().count("Mission: 600 m, 17 min") == 1


def test_a_long_first_leg_is_told_at_upload_and_at_the_start(boat: Boat) -> None:
    boat.upload((1500.0, 0.0), (1500.0, 20.0))
    boat.step()
    text = "Item 1 is 1.5 km away, 42 min (MIS_DIST_1WP)"
    assert boat.texts().count(text) == 1 and boat.severities["first_leg"] is Severity.WARNING
    boat.step(11.0)
    started(boat)
    assert boat.texts().count(text) == 2


def test_the_parameter_sets_the_length_and_switches_it_off(make_boat: MakeBoat) -> None:
    near, off = make_boat(MIS_DIST_1WP=100.0), make_boat(MIS_DIST_1WP=0.0)
    for boat in (near, off):
        boat.upload((150.0, 0.0))
        boat.step()
    assert "first_leg" in near.names() and "first_leg" not in off.names()


def test_another_continent_is_told_at_upload_and_refused_at_the_start(boat: Boat) -> None:
    boat.upload((0.0, 0.0))
    (item,) = boat.plans.items(PlanKind.MISSION)
    boat.plans.replace(PlanKind.MISSION, [replace(item, x=-339_000_000, y=184_000_000)])
    boat.step(1.0)
    (told,) = [text for text in boat.texts() if text.endswith("(MIS_DIST_1WP)")]
    assert told.startswith("Item 1 is 108") and " km away, 5" in told and len(told) <= 50
    assert not boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted


def test_a_battery_that_does_not_last_is_told_at_upload_and_at_the_start(make_boat: MakeBoat) -> None:
    boat = make_boat(BAT_ENDURANCE=60.0)
    boat.battery = 0.37
    boat.step()
    boat.upload((500.0, 0.0), (0.0, 0.0))
    boat.step()
    text = "Mission: 1.0 km, 28 min; battery lasts 15 min"
    assert boat.texts().count(text) == 1 and boat.severities["mission_outlasts"] is Severity.WARNING
    assert "mission_length" not in boat.names()
    boat.step(11.0)
    started(boat)
    assert boat.texts().count(text) == 2


def test_a_battery_that_lasts_or_is_not_known_is_no_warning(make_boat: MakeBoat) -> None:
    lasts, unknown = make_boat(BAT_ENDURANCE=60.0), make_boat()
    for boat in (lasts, unknown):
        boat.battery = 0.9
        boat.upload((500.0, 0.0), (0.0, 0.0))
        boat.step()
        assert "mission_length" in boat.names() and "mission_outlasts" not in boat.names()


def test_a_mission_from_before_a_restart_is_told_when_it_begins(make_boat: MakeBoat) -> None:
    boat = make_boat(ready=False, MIS_DIST_1WP=100.0)
    boat.upload((150.0, 0.0))
    boat.step(5.0)
    assert "mission_length" not in boat.names() and "first_leg" not in boat.names()
    started(boat)
    assert boat.names().count("first_leg") == 1


def test_without_a_position_it_waits(boat: Boat) -> None:
    boat.nav = replace(boat.nav, position_valid=False)
    boat.upload((300.0, 0.0))
    boat.step(5.0)
    assert "mission_length" not in boat.names()
    boat.nav = replace(boat.nav, position_valid=True)
    boat.step()
    assert "mission_length" in boat.names()


def test_a_mission_of_thousands_of_legs_is_reckoned_over_many_ticks(boat: Boat) -> None:
    boat.upload(*((float(n % 2), 0.1 * n) for n in range(2000)))
    boat.step(1.0)
    assert "mission_length" not in boat.names()
    boat.step(20.0)
    assert boat.names().count("mission_length") == 1


def test_the_use_of_the_battery_is_measured_under_way() -> None:
    use, share = BatteryUse(), 0.8
    for second in range(400):
        moving = second >= 100
        share -= 1e-4 if moving else 1e-3  # what is used at the quay does not count
        use.update(Battery(float(second), "b", 12.0, None, share), moving, float(second))
        if second == 300:
            assert use.full_s is None, "too little of it is used to tell"
    use.update(Battery(400.0, "b", 12.0, None, 1.0), True, 400.0)  # charged
    use.update(None, True, 401.0)
    assert use.full_s is None
    for second in range(402, 602):
        use.update(Battery(float(second), "b", 12.0, None, 1.0 - 1e-4 * second), True, float(second))
    assert use.full_s == pytest.approx(1e4, rel=0.01)
