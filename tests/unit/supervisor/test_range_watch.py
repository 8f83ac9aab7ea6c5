"""Whether the battery still takes the boat home: by consumption, wind, stream and distance."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.core.decision import Home, ModeId
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.readings import Battery
from companion.params.store import Parameters
from companion.supervisor.range_watch import RangeWatch
from tests.unit.conftest import AT_REST, Boat

REVOLT = load(find("revolt"))
HOME = Home(63.4389, 10.399, 0.0)
SPEED_MPS, ENDURANCE_MIN, CRITICAL = 0.6, 100.0, 0.12


def away(north_m: float, **more: object) -> NavState:
    lat_deg, lon_deg = LocalFrame(HOME.lat_deg, HOME.lon_deg).to_geodetic(north_m, 0.0)
    return replace(AT_REST, lat_deg=lat_deg, lon_deg=lon_deg, **more)  # type: ignore[arg-type]


def watch(**parameters: float) -> RangeWatch:
    values = {"BAT_ENDURANCE": ENDURANCE_MIN, "BAT_CRIT_THR": CRITICAL, "BAT_RET_MARG": 1.0, **parameters}
    return RangeWatch(REVOLT, Parameters(values), lambda: SPEED_MPS)


def need(nav: NavState, remaining: float = 0.9, **parameters: float) -> tuple[float, bool]:
    made = watch(**parameters)
    made.update(nav, Battery(0.0, "pack", 12.0, None, remaining), HOME, True, 0.0)
    assert made.need is not None
    return made.need, made.short


def test_the_way_home_costs_its_share_of_the_endurance() -> None:
    half = 0.5 * ENDURANCE_MIN * 60.0 * SPEED_MPS
    assert need(away(half))[0] == pytest.approx(CRITICAL + 0.5, abs=1e-3)
    assert need(away(half), BAT_RET_MARG=1.3)[0] == pytest.approx(CRITICAL + 0.65, abs=1e-3)
    assert need(away(half), remaining=0.63)[1] is False and need(away(half), remaining=0.61)[1] is True


def test_a_stream_and_wind_against_the_boat_cost_more_and_with_it_nothing_less() -> None:
    place = 600.0
    calm = need(away(place))[0] - CRITICAL
    against = away(place, current_north_mps=0.3, current_east_mps=0.0)
    assert need(against)[0] - CRITICAL == pytest.approx(calm * 1.5 * 1.5, rel=1e-3), "linear resistance"
    assert need(away(place, current_north_mps=-0.3, current_east_mps=0.0))[0] - CRITICAL == pytest.approx(calm)
    windy = away(place, wind_speed_mps=8.0, wind_from_rad=3.14159)
    assert 1.1 * calm < need(windy)[0] - CRITICAL < 2.0 * calm


@pytest.mark.parametrize("missing", ["home", "battery", "endurance", "position"])
def test_what_is_not_known_is_not_told(missing: str) -> None:
    made = watch(BAT_ENDURANCE=0.0 if missing == "endurance" else ENDURANCE_MIN)
    made.update(
        away(5000.0, position_valid=missing != "position"),
        Battery(0.0, "pack", 12.0, None, None if missing == "battery" else 0.2),
        None if missing == "home" else HOME,
        True,
        0.0,
    )
    assert made.need is None and not made.short


def test_consumption_is_measured_under_way_alone() -> None:
    made = watch(BAT_ENDURANCE=0.0)
    nav, share = away(100.0), 0.9
    for second in range(2000):  # at rest: 1 % in 1000 s
        share -= 1e-5
        made.update(nav, Battery(second, "pack", 12.0, None, share), HOME, True, float(second))
    assert made.need is None
    for second in range(2000, 3000):  # under way: 10 % in 1000 s
        share -= 1e-4
        moving = replace(nav, north_mps=SPEED_MPS)
        made.update(moving, Battery(second, "pack", 12.0, None, share), HOME, True, float(second))
    assert made.need == pytest.approx(CRITICAL + 100.0 / SPEED_MPS / 10_000.0, rel=0.01)


def sail_out(boat: Boat) -> None:
    """On a mission, 100 m from home, with a battery of ten minutes."""
    boat.parameters.set("BAT_ENDURANCE", 10.0)
    boat.battery = 0.9
    boat.upload((400.0, 0.0))
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step(5.0)
    boat.nav = replace(boat.nav, north_m=100.0, lat_deg=boat.point(100.0, 0.0)[0])


def test_the_boat_returns_in_time_and_does_not_change_its_mind_on_the_way(boat: Boat) -> None:
    sail_out(boat)
    boat.step(3.0)
    assert boat.status.mode is ModeId.MISSION
    boat.battery = 0.47  # home is 167 s away: 28 % and the margin of 30 %, and 12 %
    boat.step(3.0)
    assert boat.status.mode is ModeId.RTL
    assert any(name == "battery_return" and "Return now: 47 % left, home takes 4" in text for name, text in boat.said)
    boat.until(lambda: boat.nav.north_m < 80.0)
    assert boat.names().count("battery_return") == 1 and "battery_return_over" not in boat.names()


FAR = Home(64.4389, 10.399, 0.0)


@pytest.mark.parametrize("wrong", ["home", "speed", "endurance"])
def test_what_was_short_by_an_operators_mistake_is_not_once_that_is_mended(wrong: str) -> None:
    parameters = Parameters({"BAT_ENDURANCE": ENDURANCE_MIN, "BAT_CRIT_THR": CRITICAL, "BAT_RET_MARG": 1.0})
    speed = [0.05 if wrong == "speed" else SPEED_MPS]
    made = RangeWatch(REVOLT, parameters, lambda: speed[0])
    battery = Battery(0.0, "pack", 12.0, None, 0.99)
    if wrong == "endurance":
        parameters.set("BAT_ENDURANCE", 1.0)
    made.update(away(400.0), battery, FAR if wrong == "home" else HOME, False, 0.0)
    assert made.short
    parameters.set("BAT_ENDURANCE", ENDURANCE_MIN)
    speed[0] = SPEED_MPS
    made.update(away(400.0), battery, HOME, False, 10.0)
    assert made.need == pytest.approx(CRITICAL + 0.111, abs=1e-3) and not made.short


@pytest.mark.parametrize("lost", ["position", "charge"])
def test_what_is_short_stays_so_while_position_or_charge_is_lost(lost: str) -> None:
    made, half = watch(), 0.5 * ENDURANCE_MIN * 60.0 * SPEED_MPS
    short, full = (Battery(0.0, "pack", 12.0, None, left) for left in (0.5, 0.9))
    made.update(away(half), short, HOME, True, 0.0)
    assert made.short
    unknown = replace(short, remaining=None) if lost == "charge" else short
    made.update(away(half, position_valid=lost != "position"), unknown, HOME, True, 10.0)
    assert made.short and made.need == pytest.approx(CRITICAL + 0.5, abs=1e-3)
    made.update(away(half), short, HOME, True, 20.0)
    assert made.short
    made.update(away(half), full, HOME, True, 30.0)
    assert not made.short, "charged"


def test_a_dropout_of_the_position_gives_no_all_clear_and_leaves_the_operators_word(boat: Boat) -> None:
    sail_out(boat)
    boat.battery = 0.47
    boat.step(3.0)
    assert boat.status.mode is ModeId.RTL
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    for valid in (False, True):
        boat.nav = replace(boat.nav, position_valid=valid)
        boat.step(5.0)
    assert boat.status.mode is ModeId.MISSION
    assert boat.names().count("battery_return") == 1 and "battery_return_over" not in boat.names()
