"""Lengths and times against sums by hand and geographiclib."""

import math
from dataclasses import replace

import pytest
from geographiclib.geodesic import Geodesic

from companion.core.geodesy import LocalFrame
from companion.mission.cursor import Cursor
from companion.mission.plan import PlanItem
from companion.mission.summary import Reckoning, first_leg, format_summary, summarise

HOME = (63.4389, 10.3990, 0.0)
FRAME = LocalFrame(*HOME[:2])


def _at(north_m: float, east_m: float, command: int = 16, p1: float = 0.0, p2: float = 0.0) -> PlanItem:
    lat_deg, lon_deg = FRAME.to_geodetic(north_m, east_m)
    return PlanItem(0, command, 3, p1, p2, 0.0, math.nan, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)


def _do(command: int, p1: float = 0.0, p2: float = 0.0) -> PlanItem:
    return PlanItem(0, command, 2, p1, p2, 0.0, 0.0, 0, 0, 0.0)


def _plan(*items: PlanItem) -> tuple[PlanItem, ...]:
    return tuple(replace(item, seq=seq) for seq, item in enumerate(items))


def test_a_square() -> None:
    summary = summarise(_plan(_at(20, 0), _at(20, 20), _at(0, 20), _at(0, 0)), 0.5, HOME)
    assert summary.length_m == pytest.approx(80.0, abs=0.05)
    assert summary.time_s == pytest.approx(160.0, abs=0.1)
    assert [math.degrees(leg.course_rad or 0.0) for leg in summary.legs] == pytest.approx([0, 90, 180, -90], abs=0.1)
    assert (summary.items, summary.waypoints, summary.notes) == (4, 4, ())


def test_the_same_in_small_steps() -> None:
    items = _plan(_at(20, 0, p1=5.0), _do(178, 1, 2.0), _at(20, 20), _do(177, 0, 300), _do(20))
    whole = summarise(items, 0.5, HOME)
    voyage, steps = Reckoning(Cursor(items, follow_endless=False), 0.5, HOME[:2], HOME[:2]), 0
    while not voyage.advance(7):
        steps += 1
    assert tuple(voyage.legs) == whole.legs and (voyage.length_m, voyage.time_s) == (whole.length_m, whole.time_s)
    assert steps == len(whole.legs) // 7


def test_speeds_of_the_mission_are_capped() -> None:
    items = _plan(_at(100, 0), _do(178, 1, 20.0), _at(200, 0))
    assert summarise(items, 3.0, HOME, most_speed_mps=1.0).time_s == pytest.approx(200.0, abs=0.1)


def test_legs_stern_first_are_sailed_at_the_speed_astern() -> None:
    items = _plan(_at(100, 0), _do(194, 1), _at(200, 0), _do(194, 0), _at(300, 0))
    assert [leg.speed_mps for leg in summarise(items, 2.0, HOME, most_astern_mps=0.5).legs] == [2.0, 0.5, 2.0]


def test_the_first_leg_is_the_way_to_the_first_place() -> None:
    leg = first_leg(summarise(_plan(_do(178, 1, 2.0), _do(93, 8.0), _at(30, 40), _at(0, 0)), 0.5, HOME).legs)
    assert leg is not None and (leg.seq, leg.length_m, leg.sailing_s) == (
        2,
        pytest.approx(50.0, rel=1e-3),
        pytest.approx(25.0, rel=1e-3),
    )
    assert first_leg(summarise(_plan(_at(30, 40)), 0.5).legs) is None, "it is not known where the boat is"
    assert first_leg(summarise(_plan(_do(20)), 0.5, HOME).legs) is None


def test_long_legs_are_geodesics() -> None:
    turku = PlanItem(0, 16, 3, 0.0, 0.0, 0.0, 0.0, 604300000, 221600000, 0.0)
    summary = summarise((turku,), 5.0, HOME)
    assert summary.length_m == pytest.approx(Geodesic.WGS84.Inverse(*HOME[:2], 60.43, 22.16)["s12"], abs=0.01)


def test_speeds_holds_jumps_and_the_way_home() -> None:
    items = _plan(
        _at(100, 0, p1=12.0),
        _do(178, 1, 2.0),
        _at(100, 50, 19, 30.0),
        _do(93, 8.0),
        _do(177, 0, 1),
        _do(178, 1, -2.0),
        _do(206),
        _do(20),
    )
    summary = summarise(items, 1.0, HOME)
    assert [leg.seq for leg in summary.legs] == [0, 2, 3, 0, 2, 3, 7]
    back = math.hypot(100, 50)
    assert summary.length_m == pytest.approx(100 + 50 * 3 + back, abs=0.2)
    assert summary.time_s == pytest.approx(100 + 25 * 3 + 2 * (12 + 30 + 8) + back, abs=0.2)
    assert (summary.waypoints, summary.holds, summary.jumps, summary.ignored) == (2, 2, 1, 0)


def test_without_a_home_the_first_leg_is_not_counted() -> None:
    summary = summarise(_plan(_at(20, 0), _at(20, 20), _do(20)), 0.5)
    assert summary.legs[0].length_m is None
    assert summary.length_m == pytest.approx(20.0, abs=0.02)
    assert any("home" in note for note in summary.notes)


def test_home_moved_on_the_way() -> None:
    here = summarise(_plan(_at(20, 0), _do(179, 1), _at(20, 20), _do(20)), 0.5, HOME)
    assert here.legs[-1].length_m == pytest.approx(20.0, abs=0.02)
    elsewhere = summarise(_plan(replace(_at(50, 20, 179), param1=0.0), _at(20, 20), _do(20)), 0.5, HOME)
    assert elsewhere.legs[-1].length_m == pytest.approx(30.0, abs=0.02)


def test_what_has_no_end_is_noted() -> None:
    laps = summarise(_plan(_at(20, 0), _at(0, 0), _do(177, 0, -1)), 0.5, HOME)
    assert laps.length_m == pytest.approx(40.0, abs=0.02)
    assert any("item 3 jumps to item 1 for ever" in note for note in laps.notes)
    stay = summarise(_plan(_at(20, 0, 17), _at(0, 0)), 0.5, HOME)
    assert len(stay.legs) == 1
    assert any("stays at item 1" in note for note in stay.notes)
    clock = summarise(_plan(_do(93, -1)), 0.5, HOME)
    assert any("time of day" in note for note in clock.notes)


def test_where_the_boat_lands_the_notes_say_whether_it_docks() -> None:
    """As the boat does it: it holds where it has no heading for the berth, or cannot dock."""
    berth = replace(_at(20, 0, 21), param4=90.0)
    assert summarise(_plan(berth), 0.5, HOME).notes == ("item 1 comes alongside: not counted",)
    for landing, docks in ((berth, False), (_at(20, 0, 21), True)):
        assert summarise(_plan(landing), 0.5, HOME, docks=docks).notes == ("item 1 holds there, and does not dock",)


def test_many_laps_have_a_limit() -> None:
    summary = summarise(_plan(_at(20, 0), _at(0, 0), _do(177, 0, 1e6)), 0.5, HOME)
    assert len(summary.legs) == 100_000
    assert any("100000" in note for note in summary.notes)


def test_a_plan_that_the_boat_would_refuse_is_summarised_all_the_same() -> None:
    nan = math.nan
    items = _plan(
        *(
            PlanItem(0, command, 9, nan, nan, nan, nan, 0, 0, nan)
            for command in (16, 19, 93, 177, 178, 179, 31, 5001, 20)
        )
    )
    assert "9 items" in format_summary(summarise(items, 0.5, HOME))


def test_the_table() -> None:
    text = format_summary(summarise(_plan(_at(20, 0, p1=90.0), _at(20, 20), _do(177, 0, 1)), 0.5, HOME)).splitlines()
    assert text[1].split() == ["1", "NAV_WAYPOINT", "20.0", "0", "0.50", "0:40", "1:30"]
    assert text[2].split() == ["2", "NAV_WAYPOINT", "20.0", "90", "0.50", "0:40", "–"]
    assert len({len(line) for line in text[:5]}) == 1
    assert text[5] == "3 items: 2 waypoints, 1 of them with a stay; 1 jumps; 0 without effect"
    assert text[6].startswith("length 80.0 m, time 5:40")
    assert format_summary(summarise((), 0.5)).splitlines()[-1] == "length 0.0 m, time 0:00"


def test_commands_without_effect_are_named_with_their_items() -> None:
    items = _plan(_do(22), _at(20, 0), *[_do(189) for _ in range(7)], _at(0, 0))
    summary = summarise(items, 1.0, HOME)
    assert summary.ignored == 8
    assert summary.notes == (
        "NAV_TAKEOFF does nothing on this boat: item 1",
        "DO_LAND_START does nothing on this boat: items 3, 4, 5, 6, 7 … 9, 7 in all",
    )
