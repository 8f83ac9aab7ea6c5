"""Hold with a free heading: the bow turns to where the thrust is least, unless the operator gives a heading."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import pytest

from companion.config.vessel import find, load
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.core.decision import ModeId
from companion.core.frames import ned_to_body
from companion.core.setpoint import PoseSetpoint
from companion.modes.hold import HoldMode
from tests.unit.conftest import Boat

FREE = "Hold: heading free, bow turns to the weather"
HELD = "Hold: heading held, as the operator gave one"


@dataclass
class Weather:
    """A wind whose force on the hull is four times as large from abeam as from ahead, at the same strength."""

    from_rad: float
    force_n: float

    def needed(self, yaw_rad: float) -> Wrench:
        ahead, across = ned_to_body(math.cos(self.from_rad), math.sin(self.from_rad), yaw_rad)
        return Wrench(self.force_n * ahead, 4.0 * self.force_n * across, 0.0)


def sail(boat: Boat, weather: Weather, seconds: float) -> None:
    for _ in range(round(seconds / 0.1)):
        boat.supervisor.thrust_achieved(weather.needed(boat.nav.yaw_rad))
        boat.tick()


@pytest.fixture
def free() -> Callable[..., Boat]:
    def make(vessel: str = "revolt", **parameters: float) -> Boat:
        boat = Boat(load(find(vessel)), **{"DP_WEATHERVANE": 1.0, "DP_CONSEQ": 0.0, **parameters})
        boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
        boat.supervisor.arm(boat.now_s)
        boat.step(1.0)
        return boat

    return make


def hold_of(boat: Boat) -> HoldMode:
    mode = boat.helm.modes[ModeId.HOLD]
    assert isinstance(mode, HoldMode)
    return mode


def off_deg(boat: Boat, weather: Weather) -> float:
    return math.degrees(abs(wrap_pi(boat.nav.yaw_rad - weather.from_rad)))


@pytest.mark.parametrize("from_deg", [0.0, 40.0, 90.0, 170.0, -60.0, -135.0])
def test_the_bow_comes_to_lie_in_the_weather(free: Callable[..., Boat], from_deg: float) -> None:
    boat, weather = free(), Weather(math.radians(from_deg), 2.0)
    sail(boat, weather, 320.0)
    assert off_deg(boat, weather) < 3.0
    assert [text for _, text in boat.said].count(FREE) == 1
    assert boat.away_m(0.0, 0.0) < 0.01  # it turns on the spot


def test_stern_on_it_turns_round_as_soon_as_the_weather_leaves_the_middle(free: Callable[..., Boat]) -> None:
    boat, weather = free(), Weather(math.radians(179.0), 2.0)
    sail(boat, weather, 400.0)
    assert off_deg(boat, weather) < 3.0


def test_in_calm_and_without_the_parameter_it_lies_still(free: Callable[..., Boat]) -> None:
    calm = free()
    sail(calm, Weather(1.0, 0.02), 120.0)
    off = free(DP_WEATHERVANE=0.0)
    sail(off, Weather(1.0, 2.0), 120.0)
    assert calm.nav.yaw_rad == off.nav.yaw_rad == 0.0
    assert FREE not in [text for _, text in off.said]


def test_a_heading_of_the_operator_is_held(free: Callable[..., Boat]) -> None:
    weather = Weather(1.5, 2.0)
    by_command, by_go_to, by_stick, by_nudge = free(), free(), free(), free()
    sail(by_command, weather, 60.0)
    hold_of(by_command).head(0.5)
    by_go_to.supervisor.go_to(*by_go_to.point(1.0, 0.0), 0.5, None, by_go_to.now_s)
    for yaw in (0.0, 0.5, 0.0):
        by_stick.sticks = (0.0, 0.0, yaw)
        sail(by_stick, weather, 2.0)
    hold_of(by_nudge).nudge(0.0, 0.0, 0.3)
    for boat in (by_command, by_go_to, by_stick, by_nudge):
        sail(boat, weather, 60.0)
        held = boat.nav.yaw_rad
        sail(boat, weather, 60.0)
        assert boat.nav.yaw_rad == pytest.approx(held, abs=1e-9)
    assert by_command.nav.yaw_rad == pytest.approx(0.5)
    assert HELD in [text for _, text in by_stick.said]


def test_a_go_to_without_a_heading_and_hold_entered_anew_leave_it_free(free: Callable[..., Boat]) -> None:
    boat, weather = free(), Weather(1.0, 2.0)
    hold_of(boat).head(0.2)
    sail(boat, weather, 5.0)
    boat.supervisor.request_mode(ModeId.FORCES, boat.now_s)
    boat.step(1.0)
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.go_to(*boat.point(1.0, 0.0), None, None, boat.now_s)
    sail(boat, weather, 320.0)
    assert off_deg(boat, weather) < 3.0
    assert boat.away_m(1.0, 0.0) < 0.05


def test_a_boat_without_sideways_thrust_is_not_concerned(free: Callable[..., Boat]) -> None:
    boat = free("otter")
    sail(boat, Weather(1.0, 2.0), 60.0)
    assert FREE not in [text for _, text in boat.said]


DRIVEN = "Hold: driven off sideways: bow turns to weather"


def yaw_asked(boat: Boat) -> float:
    setpoint = boat.setpoint
    assert isinstance(setpoint, PoseSetpoint)
    return setpoint.yaw_rad


def blown_off(
    boat: Boat, sway_n: float, circles: float = 1.5, seconds: float = 60.0, demanded_n: float | None = None
) -> None:
    """Put the boat beyond its alarm circle, `circles` times that off, and let it push sideways with `sway_n` of
    `demanded_n`; None: of as much."""
    demanded = Wrench(0.0, sway_n if demanded_n is None else demanded_n, 0.0)
    north_m = circles * boat.parameters["DP_ALARM_R"]
    lat_deg, lon_deg = boat.point(north_m, 0.0)
    boat.pinned = True
    boat.nav = replace(boat.nav, north_m=north_m, lat_deg=lat_deg, lon_deg=lon_deg)
    for _ in range(round(seconds / 0.1)):
        boat.supervisor.thrust_achieved(Wrench(0.0, sway_n, 0.0), demanded)
        boat.tick()


def test_driven_off_with_all_its_sideways_thrust_the_boat_gives_up_its_heading(free: Callable[..., Boat]) -> None:
    boat = free(DP_WEATHERVANE=0.0)
    limit_n = boat.config.limits.sway_n
    blown_off(boat, limit_n)
    assert boat.texts().count(DRIVEN) == 1
    assert yaw_asked(boat) > math.radians(30.0), "towards the force that it gives"


@pytest.mark.parametrize("east_mps", [0.2, -0.2, 0.0])
def test_driven_out_of_its_watch_circle_it_does_not_wait_for_the_alarm(
    free: Callable[..., Boat], east_mps: float
) -> None:
    """ReVolt was 12 m off before its bow began to turn. One that comes back keeps its heading."""
    boat = free(DP_WEATHERVANE=0.0)
    limit_n, east_m = boat.config.limits.sway_n, 1.2 * boat.parameters["DP_WATCH_R"]
    boat.pinned = True
    for _ in range(200):
        boat.nav = replace(boat.nav, east_m=east_m, east_mps=east_mps, sway_mps=east_mps)
        boat.supervisor.thrust_achieved(Wrench(0.0, -limit_n, 0.0), Wrench(0.0, -limit_n, 0.0))
        boat.tick()
    assert "watch_alarm" not in boat.names()
    assert boat.texts().count(DRIVEN) == (1 if east_mps > 0.0 else 0)


@pytest.mark.parametrize("fence_m", [0.0, 6.0])
def test_driven_towards_a_fence_it_does_not_wait_for_its_watch_circle(
    free: Callable[..., Boat], fence_m: float
) -> None:
    """A model ship crossed a fence 1 m off, 2 m inside its watch circle."""
    boat = free(DP_WEATHERVANE=0.0, GF_MAX_HOR_DIST=fence_m)
    limit_n, east_m = boat.config.limits.sway_n, 0.9 * boat.parameters["DP_WATCH_R"]
    boat.pinned = True
    for _ in range(200):
        boat.nav = replace(boat.nav, east_m=east_m, east_mps=0.2, sway_mps=0.2)
        boat.supervisor.thrust_achieved(Wrench(0.0, -limit_n, 0.0), Wrench(0.0, -limit_n, 0.0))
        boat.tick()
    assert "watch_circle_left" not in boat.names() and "fence_breached" not in boat.names()
    assert boat.texts().count(DRIVEN) == (1 if fence_m else 0)


def test_driven_off_to_the_side_where_its_thrusters_push_less_it_gives_up_its_heading_too(
    free: Callable[..., Boat],
) -> None:
    """It lay 7 m from its point and 49 m from another for good: a bow thruster is weak in reverse."""
    boat = free(DP_WEATHERVANE=0.0)
    limit_n = boat.config.limits.sway_n
    blown_off(boat, -0.6 * limit_n, demanded_n=-limit_n)
    assert boat.texts().count(DRIVEN) == 1
    assert yaw_asked(boat) < math.radians(-30.0)


def test_a_boat_that_cannot_reach_its_hold_point_from_the_side_turns_its_bow_to_the_weather(
    free: Callable[..., Boat],
) -> None:
    boat = free(DP_WEATHERVANE=0.0)
    boat.supervisor.go_to(*boat.point(0.0, 0.0), None, None, boat.now_s)
    blown_off(boat, boat.config.limits.sway_n, circles=0.7, seconds=100.0)
    assert "watch_alarm" not in boat.names()
    assert boat.texts().count(DRIVEN) == 1


def test_driven_off_the_bow_turns_within_a_minute_and_does_not_pass_the_weather(free: Callable[..., Boat]) -> None:
    """A mean in the axes of the boat lags behind the turn; turned faster by that, the bow went round and round."""
    boat, weather = free(DP_WEATHERVANE=0.0), Weather(math.radians(120.0), 10.0)
    blown_off(boat, boat.config.limits.sway_n, seconds=40.0)
    boat.pinned = False
    off = []
    for _ in range(100):
        sail(boat, weather, 1.0)
        off.append(math.degrees(wrap_pi(boat.nav.yaw_rad - weather.from_rad)))
    assert max(off) < 20.0
    assert max(map(abs, off[60:])) < 5.0


def test_driven_off_the_bow_turns_faster_than_usual(free: Callable[..., Boat]) -> None:
    """With a failed thruster it was carried 16 m away beam on, in 40 s of a turn at DP_YAW_RATE."""
    boat, rates = free(DP_WEATHERVANE=0.0), []
    for _ in range(400):
        blown_off(boat, boat.config.limits.sway_n, seconds=0.1)
        assert isinstance(boat.setpoint, PoseSetpoint)
        rates.append(math.degrees(boat.setpoint.yaw_rate_radps))
    assert 2.0 * boat.parameters["DP_YAW_RATE"] < max(rates) <= 8.0 + 1e-6


def test_at_home_after_rtl_too(free: Callable[..., Boat]) -> None:
    boat = free(DP_WEATHERVANE=0.0)
    boat.supervisor.request_mode(ModeId.RTL, boat.now_s)
    boat.until(lambda: "rtl_arrived" in boat.names())
    blown_off(boat, boat.config.limits.sway_n)
    assert boat.texts().count(DRIVEN.replace("Hold", "RTL")) == 1
    assert yaw_asked(boat) > math.radians(30.0)


def test_a_boat_that_does_not_come_home_against_weather_from_the_side_turns_its_bow_to_it(
    free: Callable[..., Boat],
) -> None:
    """It lay 6 m from home on the heading of its arrival, for good."""
    boat = free(DP_WEATHERVANE=0.0)
    blown_off(boat, 0.0, circles=0.7, seconds=1.0)
    boat.supervisor.request_mode(ModeId.RTL, boat.now_s)
    blown_off(boat, boat.config.limits.sway_n, circles=0.7, seconds=120.0)
    assert "rtl_arrived" not in boat.names() and "watch_alarm" not in boat.names()
    assert boat.texts().count(DRIVEN.replace("Hold", "RTL")) == 1


def test_a_boat_that_is_off_its_point_with_thrust_to_spare_keeps_its_heading(free: Callable[..., Boat]) -> None:
    boat = free(DP_WEATHERVANE=0.0)
    blown_off(boat, 0.4 * boat.config.limits.sway_n)
    assert DRIVEN not in boat.texts() and yaw_asked(boat) == pytest.approx(0.0)


LACKING = "Hold: too little sway thrust: bow to weather"


def test_thrusters_that_give_less_than_half_of_what_it_asks_are_not_waited_for(free: Callable[..., Boat]) -> None:
    """ÅBOAT with its stern thruster alone was 12 and 17 m off, and still on its heading."""
    boat = free(DP_WEATHERVANE=0.0)
    blown_off(boat, 0.05, circles=0.7, seconds=30.0, demanded_n=0.3 * boat.config.limits.sway_n)
    assert "watch_alarm" not in boat.names() and boat.texts().count(LACKING) == 1
    assert yaw_asked(boat) > math.radians(20.0), "towards the force that it asks for"


def test_a_thruster_that_answers_late_lets_it_keep_its_heading(free: Callable[..., Boat]) -> None:
    boat = free(DP_WEATHERVANE=0.0)
    limit_n = boat.config.limits.sway_n
    blown_off(boat, 0.2 * limit_n, circles=0.7, demanded_n=0.3 * limit_n)
    blown_off(boat, 0.0, circles=0.7, seconds=30.0, demanded_n=0.05 * limit_n)
    assert "driven_off" not in boat.names() and yaw_asked(boat) == pytest.approx(0.0)


def test_with_its_thruster_back_the_boat_takes_its_heading_back(free: Callable[..., Boat]) -> None:
    """It swung by 90° to and fro for as long as nobody gave it a heading."""
    boat = free(DP_WEATHERVANE=0.0)
    hold_of(boat).head(0.3)
    boat.step(20.0)
    boat.supervisor.thruster_failed(0, True)
    asked_n = 0.3 * boat.config.limits.sway_n
    blown_off(boat, 0.0, circles=0.3, seconds=30.0, demanded_n=asked_n)
    assert "driven_off" not in boat.names(), "inside its watch circle it may stay as it is"
    blown_off(boat, 0.0, circles=0.7, seconds=15.0, demanded_n=asked_n)
    assert boat.texts().count(LACKING) == 1
    assert yaw_asked(boat) > 0.5
    boat.supervisor.thruster_failed(0, False)
    boat.pinned = False
    sail(boat, Weather(0.0, 0.0), 60.0)
    assert boat.nav.yaw_rad == pytest.approx(0.3) and "heading_taken_back" in boat.names()


def drifting(boat: Boat, sway_mps: float, seconds: float, asked_n: float) -> None:
    """Let the boat drift to the east with its thrusters giving nothing of `asked_n` sideways."""
    boat.pinned = True
    for _ in range(round(10.0 * seconds)):
        east_m = boat.nav.east_m + 0.1 * sway_mps
        boat.nav = replace(boat.nav, east_m=east_m, east_mps=sway_mps, sway_mps=sway_mps)
        boat.supervisor.thrust_achieved(Wrench(0.0, 0.0, 0.0), Wrench(0.0, -asked_n, 0.0))
        boat.tick()


@pytest.mark.parametrize("sway_mps", [0.3, 0.02])
def test_a_boat_that_knows_of_a_failed_thruster_turns_before_it_has_left_its_watch_circle(
    free: Callable[..., Boat], sway_mps: float
) -> None:
    """ÅBOAT without its bow thruster was 12 m off: it drifted 5 m to where it began to turn. Hardly drifting, it may
    stay as it is."""
    boat = free(DP_WEATHERVANE=0.0)
    boat.supervisor.thruster_failed(0, True)
    drifting(boat, sway_mps, 8.0, 0.3 * boat.config.limits.sway_n)
    assert "watch_circle_left" not in boat.names()
    assert boat.texts().count(LACKING) == (1 if sway_mps > 0.1 else 0)
    if sway_mps > 0.1:
        assert yaw_asked(boat) < 0.0, "towards the force that it asks for, at once"


def test_without_a_failed_thruster_it_waits_for_its_watch_circle(free: Callable[..., Boat]) -> None:
    boat = free(DP_WEATHERVANE=0.0)
    drifting(boat, 0.3, 8.0, 0.3 * boat.config.limits.sway_n)
    assert "driven_off" not in boat.names()


def test_while_it_takes_its_heading_back_it_is_not_driven_off_again(free: Callable[..., Boat]) -> None:
    """Outside its watch circle, the thrusters that worked again turned for 7 s: it gave its heading up for good."""
    boat = free(DP_WEATHERVANE=0.0)
    boat.supervisor.thruster_failed(0, True)
    asked_n = 0.3 * boat.config.limits.sway_n
    blown_off(boat, 0.0, circles=0.7, seconds=40.0, demanded_n=asked_n)
    boat.supervisor.thruster_failed(0, False)
    blown_off(boat, 0.0, circles=0.7, seconds=8.0, demanded_n=asked_n)
    blown_off(boat, asked_n, circles=0.3, seconds=60.0, demanded_n=asked_n)
    assert boat.texts().count(LACKING) == 1 and "heading_taken_back" in boat.names()
    assert yaw_asked(boat) == pytest.approx(0.0, abs=0.01)
