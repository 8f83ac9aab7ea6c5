"""Heel, thrust in vain and shallow water: when they are told, what explains them away, and when they are over."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.core.actuation import Wrench
from companion.core.decision import ModeId
from companion.core.estimate import Distrust, NavState
from companion.core.readings import Depth
from companion.core.setpoint import NeutralSetpoint
from companion.params.store import Parameters
from companion.supervisor.hull_watch import HullWatch
from tests.unit.conftest import AT_REST, Boat
from tests.unit.supervisor.test_failsafes import sail

REVOLT = load(find("revolt"))
DT_S = 0.1


class Bench:
    def __init__(self, **parameters: float) -> None:
        self.parameters = Parameters(parameters)
        self.watch = HullWatch(REVOLT, self.parameters)
        self.t_s = 0.0

    def sail(
        self,
        duration_s: float,
        roll_deg: float = 0.0,
        desired_mps: float | None = 0.0,
        made_mps: float = 0.0,
        push_n: float = 0.0,
        depth_m: float | None = None,
        **nav: object,
    ) -> HullWatch:
        state: NavState = replace(
            AT_REST, roll_rad=math.radians(roll_deg), surge_mps=made_mps, imu_age_s=0.0, **nav  # type: ignore[arg-type]
        )  # fmt: skip
        for _ in range(round(duration_s / DT_S)):
            self.t_s += DT_S
            depth = None if depth_m is None else Depth(self.t_s, "sounder", depth_m)
            self.watch.update(state, depth, desired_mps, push_n, self.t_s)
        return self.watch


def test_capsized_after_a_moment_and_upright_again() -> None:
    bench = Bench()
    assert bench.sail(5.0, roll_deg=-59.0).tilt_rad is None
    assert bench.sail(0.3, roll_deg=-80.0).tilt_rad is None
    assert bench.sail(0.2, roll_deg=-80.0).tilt_rad == pytest.approx(math.radians(80.0))
    assert bench.sail(1.0, roll_deg=45.0).tilt_rad is not None, "still heeled"
    assert bench.sail(0.1, roll_deg=40.0).tilt_rad is None


def test_a_wave_does_not_capsize_the_boat_and_zero_turns_the_watch_off() -> None:
    bench = Bench()
    for _ in range(10):
        assert bench.sail(0.2, roll_deg=90.0).tilt_rad is None
        bench.sail(0.2)
    assert Bench(FS_TILT_ANG=0.0).sail(2.0, roll_deg=170.0).tilt_rad is None


@pytest.mark.parametrize(
    "blind",
    [
        {"imu_age_s": 2.0},
        {"distrusted": (Distrust("IMU", "imu", "is upside down", 0.0, True, False),)},
        {"distrusted": (Distrust("accelerometer", "imu", "is upside down", 0.0, True, False),)},
    ],
)
def test_who_sees_nothing_does_not_know_that_the_boat_is_upright(blind: dict[str, object]) -> None:
    bench = Bench()
    bench.sail(1.0, roll_deg=150.0)
    state = {"roll_rad": 0.0, "surge_mps": 0.0, **blind}
    for _ in range(50):
        bench.t_s += DT_S
        bench.watch.update(replace(AT_REST, **state), None, 0.0, 0.0, bench.t_s)  # type: ignore[arg-type]
    assert bench.watch.tilt_rad is not None
    assert bench.sail(0.1).tilt_rad is None


def test_thrust_in_vain() -> None:
    bench = Bench()
    assert not bench.sail(9.8, desired_mps=0.6, push_n=45.0, made_mps=0.02).aground_or_fouled
    assert bench.sail(0.5, desired_mps=0.6, push_n=45.0, made_mps=0.02).aground_or_fouled
    assert bench.sail(30.0, desired_mps=0.0).aground_or_fouled, "only way made ends it"
    assert bench.sail(5.0, desired_mps=0.12, push_n=3.0, made_mps=0.08).aground_or_fouled, "Hold desires little"
    assert not bench.sail(0.2, desired_mps=0.6, push_n=30.0, made_mps=0.4).aground_or_fouled


@pytest.mark.parametrize(
    "explained",
    [
        {"desired_mps": 0.6, "push_n": 45.0, "made_mps": 0.5},  # it makes way
        {"desired_mps": 0.6, "push_n": 25.0, "made_mps": 0.0},  # a stream of 0.3 m/s takes half of that
        {"desired_mps": 0.0, "push_n": 45.0, "made_mps": 0.0},  # it holds against a storm
        {"desired_mps": 0.6, "push_n": -45.0, "made_mps": 0.0},  # it brakes
        {"desired_mps": 0.6, "push_n": 45.0, "made_mps": 0.0, "yaw_rate_radps": 0.15},  # it turns
        {"desired_mps": 0.6, "push_n": 45.0, "made_mps": 0.0, "position_valid": False},
    ],
)
def test_what_is_no_thrust_in_vain(explained: dict[str, float]) -> None:
    assert not Bench().sail(60.0, **explained).aground_or_fouled  # type: ignore[arg-type]


def test_a_slow_turn_is_one_for_a_boat_that_turns_slowly() -> None:
    """A barge of two tonnes, which turns at 4.8°/s at most, was taken to lie aground at its first waypoint."""
    turning = {"desired_mps": 0.6, "push_n": 45.0, "yaw_rate_radps": math.radians(3.0)}
    assert Bench(PATH_YAW_RATE=12.0).sail(30.0, **turning).aground_or_fouled  # type: ignore[arg-type]
    assert not Bench(PATH_YAW_RATE=5.0).sail(30.0, **turning).aground_or_fouled  # type: ignore[arg-type]


def test_a_boat_that_swings_to_and_fro_does_not_turn() -> None:
    """Heron and BlueBoat with one of two propellers fouled swung by 5 to 7°/s on their circle: not told in 18 s."""
    bench, swings = Bench(), 0
    while not bench.watch.aground_or_fouled and swings < 8:
        swings += 1
        for rate_degps in (2.0, 7.0, 2.0, -2.0, -7.0, -2.0):
            bench.sail(0.5, desired_mps=0.6, push_n=45.0, yaw_rate_radps=math.radians(rate_degps))
    assert bench.watch.aground_or_fouled and 3 <= swings <= 5


def test_a_current_explains_that_no_way_is_made_unless_it_is_estimated_from_then_on() -> None:
    stemmed, aground = Bench(), Bench()
    stemmed.sail(1.0, current_north_mps=-0.6, current_east_mps=0.0)
    aground.sail(1.0, current_north_mps=-0.05, current_east_mps=0.0)
    vain = {"desired_mps": 0.6, "push_n": 50.0, "current_north_mps": -0.6, "current_east_mps": 0.0}
    assert not stemmed.sail(60.0, **vain).aground_or_fouled  # type: ignore[arg-type]
    assert aground.sail(10.5, **vain).aground_or_fouled  # type: ignore[arg-type]
    driven_back = Bench()
    driven_back.sail(1.0, current_north_mps=-0.05, current_east_mps=0.0)
    vain |= {"made_mps": -0.2, "north_mps": -0.2, "current_north_mps": -1.2}
    assert not driven_back.sail(60.0, **vain).aground_or_fouled  # type: ignore[arg-type]


def test_pushes_without_a_desired_speed_are_judged_by_the_model() -> None:
    bench = Bench()
    for _ in range(2):
        assert not bench.sail(4.5, desired_mps=None, push_n=50.0).aground_or_fouled
        assert not bench.sail(20.0, desired_mps=None, push_n=0.0).aground_or_fouled
    assert bench.sail(3.0, desired_mps=None, push_n=50.0).aground_or_fouled
    free = Bench()
    for _ in range(30):
        free.sail(2.0, desired_mps=None, push_n=50.0, north_mps=0.2)
        assert not free.sail(2.0, desired_mps=None, push_n=0.0).aground_or_fouled


def test_shallow_water_for_a_second_until_it_is_a_fifth_deeper() -> None:
    bench = Bench(FS_DEPTH_MIN=1.0)
    assert bench.sail(0.9, depth_m=0.8).depth_m is None
    assert bench.sail(0.3, depth_m=0.8).depth_m == 0.8
    assert bench.sail(1.0, depth_m=1.1).depth_m == 1.1
    assert bench.sail(0.1, depth_m=1.3).depth_m is None
    assert Bench().sail(5.0, depth_m=0.0).depth_m is None, "0: never"


def test_one_shallow_reading_of_a_sounder_that_measures_once_a_second_is_no_shallow_water() -> None:
    bench = Bench(FS_DEPTH_MIN=1.0)

    def hear(*depths_m: float, every_s: float = 1.04) -> float | None:
        for depth_m in depths_m:
            reading, until_s = Depth(bench.t_s, "sounder", depth_m), bench.t_s + every_s
            while bench.t_s < until_s:
                bench.watch.update(AT_REST, reading, 0.0, 0.0, bench.t_s)
                bench.t_s += DT_S
        return bench.watch.depth_m

    assert hear(5.0, 0.4) is None, "a fish"
    assert hear(5.0, 0.4, 0.4) == 0.4
    assert hear(5.0, 0.4, every_s=3.0) == 0.4, "the last that the sounder could measure"


def test_a_sounder_that_finds_no_bottom_does_not_say_that_it_is_deep_enough() -> None:
    bench = Bench(FS_DEPTH_MIN=1.0)
    assert bench.sail(2.0, depth_m=0.8).depth_m == 0.8
    assert bench.sail(20.0).depth_m == 0.8
    assert bench.sail(0.1, depth_m=1.3).depth_m is None
    silent = Depth(bench.t_s, "sounder", 0.5)
    for _ in range(100):
        bench.t_s += DT_S
        bench.watch.update(AT_REST, silent, 0.0, 0.0, bench.t_s)
    assert bench.watch.depth_m == 0.5
    bench.parameters.set("FS_DEPTH_MIN", 0.0)
    assert bench.sail(0.1).depth_m is None


def test_a_capsized_boat_has_no_thrust_and_goes_on_when_it_is_upright(boat: Boat) -> None:
    sail(boat)
    boat.nav = replace(boat.nav, roll_rad=math.radians(100.0), imu_age_s=0.0)
    boat.step(1.0)
    assert boat.status.failsafes[0] == "capsized" and isinstance(boat.setpoint, NeutralSetpoint)
    assert ("capsized", "Capsized, 100 deg from upright: neutral") in boat.said
    boat.nav = replace(boat.nav, roll_rad=0.0)
    boat.step(0.2)
    assert boat.status.failsafes == () and not isinstance(boat.setpoint, NeutralSetpoint)


def test_a_boat_aground_holds_and_an_operator_may_go_on(boat: Boat) -> None:
    sail(boat)
    boat.pinned = True
    boat.supervisor.thrust_achieved(Wrench(48.0, 0.0, 0.0))
    boat.step(12.0)
    assert boat.status.mode is ModeId.HOLD and "aground_or_fouled" in boat.status.failsafes
    assert ("aground_or_fouled", "Aground or propeller fouled: thrust makes no way: Hold") in boat.said
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    boat.step(5.0)
    assert boat.status.mode is ModeId.MISSION
    boat.pinned = False
    boat.step(5.0)
    assert "aground_or_fouled_over" in boat.names()
