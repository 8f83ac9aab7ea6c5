"""Making no headway is said in time, never falsely, and acted on as WP_STUCK_ACT says."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from companion.core.decision import ModeId
from companion.core.events import EventLog
from companion.modes.parts.headway import Headway
from tests.unit.conftest import Boat

DT_S = 0.1


class Watch:
    """A headway on which way is made at a given speed, with a position that is not quite known."""

    def __init__(self, noise_m: float = 0.0) -> None:
        self.events = EventLog()
        self.headway = Headway("Mission", self.events)
        self.now_s = self.way_m = 0.0
        self._noise_m, self._random = noise_m, random.Random(3)

    def sail(self, seconds: float, speed_mps: float) -> list[tuple[float, str]]:
        for _ in range(round(seconds / DT_S)):
            self.now_s += DT_S
            self.way_m += speed_mps * DT_S
            self.headway.update(self.way_m + self._random.gauss(0.0, self._noise_m), 0.6, self.now_s)
        return [(event.t_s, event.name) for event in self.events.drain()]


@pytest.mark.parametrize("noise_m", [0.0, 0.3])
@pytest.mark.parametrize("speed_mps", [0.0, -0.3, 0.005])
def test_no_headway_is_said_once_and_within_a_minute(speed_mps: float, noise_m: float) -> None:
    watch = Watch(noise_m)
    watch.sail(60.0, 0.5)
    said = watch.sail(120.0, speed_mps)
    assert [name for _, name in said] == ["no_headway"]
    assert said[0][0] - 60.0 < 60.0
    assert 112.0 < (watch.headway.stuck_s(watch.now_s) or 0.0) < 140.0
    assert [name for _, name in watch.sail(80.0, 0.2)] == ["headway_again"]
    assert watch.headway.stuck_s(watch.now_s) == 0.0


@pytest.mark.parametrize("speed_mps", [0.03, 0.05, 0.6])
def test_slow_way_is_way(speed_mps: float) -> None:
    assert Watch(0.05).sail(600.0, speed_mps) == []


def test_set_off_first_and_then_under_way_is_way() -> None:
    """As a boat that a strong current carries off while it turns to its course."""
    watch = Watch()
    assert watch.sail(15.0, -0.3) + watch.sail(60.0, 0.15) == []


def test_a_short_standstill_is_none() -> None:
    watch = Watch()
    assert watch.sail(60.0, 0.5) + watch.sail(30.0, 0.0) + watch.sail(60.0, 0.5) == []


def test_a_route_replaced_again_and_again_does_not_hide_it() -> None:
    watch = Watch()
    said = []
    for n in range(12):
        watch.headway.rebase()
        watch.way_m = -100.0 * n
        said += watch.sail(5.0, 0.0)
    assert [name for _, name in said] == ["no_headway"]


def test_a_pause_begins_anew() -> None:
    watch = Watch()
    watch.sail(35.0, 0.0)
    watch.now_s += 5.0
    assert watch.headway.stuck_s(watch.now_s) is None
    assert watch.sail(35.0, 0.0) == []


def under_way(boat: Boat, mode: ModeId) -> None:
    """100 m off, on the way for half a minute, and then held fast."""
    boat.upload((100.0, 0.0), (100.0, 50.0))
    assert boat.supervisor.request_mode(ModeId.MISSION, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.step(60.0)
    if mode is ModeId.RTL:
        assert boat.supervisor.request_mode(mode, boat.now_s).accepted
    elif mode is ModeId.HOLD:
        assert boat.supervisor.go_to(*boat.point(80.0, 80.0), None, None, boat.now_s).accepted
    boat.step(5.0)
    boat.pinned = True


@pytest.mark.parametrize("mode", [ModeId.MISSION, ModeId.RTL, ModeId.HOLD])
def test_it_is_said_within_a_minute_in_every_mode_that_goes_somewhere(boat: Boat, mode: ModeId) -> None:
    under_way(boat, mode)
    boat.until(lambda: "no_headway" in boat.names(), 60.0)
    assert f"{mode.value}: no headway: wind, current or obstacle" in boat.texts()
    assert boat.status.mode is mode
    boat.pinned = False
    boat.until(lambda: "headway_again" in boat.names(), 60.0)


@pytest.mark.parametrize(("action", "mode"), [(0, ModeId.MISSION), (1, ModeId.HOLD), (2, ModeId.RTL)])
def test_a_mission_that_makes_no_headway_ends_as_the_parameter_says(
    make_boat: Callable[..., Boat], action: int, mode: ModeId
) -> None:
    boat = make_boat(WP_STUCK_ACT=action, WP_STUCK_T=60.0)
    under_way(boat, ModeId.MISSION)
    boat.until(lambda: "stuck" in boat.names(), 80.0)
    boat.step(5.0)
    assert boat.status.mode is mode
    assert "stuck_over" not in boat.names(), "given up is not way made"


def test_what_the_operator_asks_for_again_stands(make_boat: Callable[..., Boat]) -> None:
    boat = make_boat(WP_STUCK_T=60.0)
    under_way(boat, ModeId.MISSION)
    boat.until(lambda: boat.status.mode is ModeId.HOLD, 80.0)
    assert boat.supervisor.resume(boat.now_s).accepted
    boat.step(30.0)
    assert boat.status.mode is ModeId.MISSION
    boat.until(lambda: boat.status.mode is ModeId.HOLD, 80.0)


def test_holding_is_not_being_stuck(boat: Boat) -> None:
    assert boat.supervisor.request_mode(ModeId.HOLD, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    boat.pinned = True
    boat.step(200.0)
    assert "no_headway" not in boat.names() and boat.status.mode is ModeId.HOLD
