"""What `companion check` says a boat holds: by the same balance as the polar, and by a sea that the simulator agrees with."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.analysis.polar import wrench_against
from companion.analysis.rudder_turn import room_m
from companion.analysis.static_limits import Limit, drift, lines, static_limits, weakness, wind_sea
from companion.cli.new_file import Answers, file_text
from companion.config.vessel import VesselConfig, find, load, parse
from companion.control.heading import held_nm_per_rad
from companion.params.store import Parameters
from companion.params.table import table_of
from docs.generate.wave_balance import mean_drift

KAYAK = Answers(
    "kayak", "Kayak", "monohull", 3.0, 0.7, 60.0, None, None, None, "twin-bow", "65", None, 0.5,
    "microcontroller", "two", 63.4, 10.4,
)  # fmt: skip


def kayak(**changes: object) -> VesselConfig:
    return parse(file_text(replace(KAYAK, **changes)), "kayak.toml")


def weakened(bow_n: float) -> VesselConfig:
    """A kayak whose tunnel at the bow is the weakest of its thrusters."""
    boat = file_text(KAYAK)
    last = boat.rindex("max_n = 65")
    return parse(boat[:last] + f"max_n = {bow_n:g}" + boat[last + len("max_n = 65") :], "kayak.toml")


def test_the_limit_is_where_the_force_of_wind_meets_that_of_the_thrusters() -> None:
    boat = weakened(10.0)
    found = static_limits(boat)
    assert found is not None and found.held_sideways and found.wind.side is not None
    abeam = wrench_against(boat, found.wind.side, 0.5 * math.pi)
    assert abs(abeam.sway_n) <= 1.01 * boat.limits.sway_n
    assert found.wind.side < found.wind.ahead and found.with_waves.side is not None
    assert found.with_waves.side < found.wind.side, "waves take their part"


def test_a_weak_tunnel_is_told_with_its_remedy() -> None:
    boat = weakened(10.0)
    found = static_limits(boat)
    assert found is not None and found.with_waves.side is not None
    (said,) = weakness(boat, found)
    assert f"wind above {found.with_waves.side:.1f} m/s from the side" in said and "DP_WEATHERVANE" in said
    strong = kayak(layout="two-azimuths", motor="300")
    enough = static_limits(strong)
    assert enough is not None and not list(weakness(strong, enough))


def test_a_boat_without_sideways_thrust_is_told_in_which_wind_its_bow_comes_round() -> None:
    found = static_limits(kayak(layout="twin"))
    assert found is not None and not found.held_sideways
    assert found.current.side is None and found.wind.side is not None
    assert any("the bow comes round in up to" in line for line in lines(found))
    narrow = kayak(layout="twin", spread_m=0.02)
    poor = static_limits(narrow)
    assert poor is not None and any("does not come round" in text for text in weakness(narrow, poor))


def test_wind_that_the_heading_loop_cannot_hold_counts() -> None:
    """A boat of 4 kg has moment enough, but not bandwidth: in 8 m/s its bow swung from beam to beam."""
    light = kayak(layout="twin", length_m=0.9, beam_m=0.34, mass_kg=3.7, motor="7", spread_m=0.24)
    found = static_limits(light)
    assert found is not None and found.wind.side is not None
    pushed = wrench_against(light, found.wind.side, math.radians(20.0))
    assert abs(pushed.yaw_nm) == pytest.approx(held_nm_per_rad(light) * math.radians(20.0), rel=0.05)
    assert abs(pushed.yaw_nm) < 0.5 * light.limits.yaw_nm


def test_a_file_without_windage_has_no_limits() -> None:
    assert static_limits(load(find("cybership2"))) is None


@pytest.mark.parametrize("height_m", [0.15, 0.29])
@pytest.mark.parametrize("from_deg", [60, 90])
def test_waves_push_as_in_the_simulator(height_m: float, from_deg: int) -> None:
    boat = load(find("revolt"))
    from_rad = math.radians(from_deg)
    seen = [mean_drift(boat, f"{height_m}", from_rad, seed)[1] for seed in range(4)]
    known = drift(boat, height_m, 4.2 * math.sqrt(height_m), from_rad).sway_n
    assert known == pytest.approx(-sum(seen) / 4.0, rel=0.3)


def test_the_waves_of_a_wind_are_those_of_rough_water() -> None:
    """ReVolt's 3 m/s are 4.6 m/s at 10 m and raise 0.07 m with a period of 1.0 s (docs/inside/sea.md)."""
    height_m, period_s = wind_sea(3.0)
    assert height_m == pytest.approx(0.07, abs=0.01) and period_s == pytest.approx(1.0, abs=0.1)


def test_a_rudder_has_room_in_its_watch_circle_to_bring_the_bow_round() -> None:
    """`check` promised a yacht of 1.7 m 15 m/s; in 9 m/s it was 43 to 138 m off its hold point."""
    boat = kayak(layout="rudder")
    found = static_limits(boat)
    assert found is not None and found.wind.side is not None and found.with_waves.side is not None
    assert found.with_waves.side < found.wind.side < found.wind.ahead
    assert any("within the watch circle in up to" in line for line in lines(found))

    def room(wind_mps: float) -> float:
        return room_m(boat, lambda from_rad: wrench_against(boat, wind_mps, from_rad))

    watched_m = Parameters(boat.parameters, table_of(boat))["DP_WATCH_R"]
    assert room(found.wind.side) == pytest.approx(0.25 * watched_m, rel=0.05)
    assert room(0.5 * found.wind.side) < room(found.wind.side) < room(1.5 * found.wind.side)


def test_a_boat_that_its_rudder_brings_round_too_late_is_told_so() -> None:
    high = kayak(layout="rudder", motor="20")
    found = static_limits(high)
    assert found is not None and found.with_waves.side is not None
    (said,) = (text for text in weakness(high, found) if "rudder" in text)
    assert f"wind above {found.with_waves.side:.1f} m/s" in said and "DP_WATCH_R" in said


def test_what_is_held_is_the_weaker_side_unless_the_search_ended_there() -> None:
    assert Limit(ahead=40.0, side=20.5, most=40.0).held == 20.5
    assert Limit(30.0, None, 40.0).held == 30.0
    assert Limit(40.0, None, 40.0).held == Limit(40.0, 40.0, 40.0).held == math.inf
