"""Nudges of what Hold holds, and the circles around it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import VesselConfig
from companion.core.decision import ModeId, Result, Severity
from tests.unit.conftest import Boat


@pytest.fixture
def holding(boat: Boat) -> Any:
    boat.nav = replace(boat.nav, yaw_rad=math.pi / 2.0)
    boat.step()
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.step(5.0)
    return boat


def test_ahead_and_to_starboard_as_the_held_heading_has_it(holding: Any) -> None:
    assert holding.supervisor.nudge(1.0, 0.5, math.radians(10.0), holding.now_s).accepted
    assert holding.supervisor.nudge(
        0.0, 0.0, math.radians(-30.0), holding.now_s
    ).accepted  # adds to what was asked, under way or not
    holding.step(60.0)
    assert holding.away_m(-0.5, 1.0) < 1e-3 and math.degrees(holding.nav.yaw_rad) == pytest.approx(70.0, abs=0.01)
    assert "Nudge +1.00 m ahead, +0.50 m to starboard, +10 deg" in holding.texts()


def test_a_heading_at_the_same_point(holding: Any) -> None:
    assert holding.supervisor.set_heading(math.radians(350.0), holding.now_s).accepted
    holding.step(90.0)
    assert holding.away_m(0.0, 0.0) < 1e-3 and math.degrees(holding.nav.yaw_rad) == pytest.approx(-10.0, abs=0.01)


@pytest.mark.parametrize(
    ("nudge", "reason"),
    [
        ((3.1, 0.0, 0.0), "DP_NUDGE_MAX"),
        ((2.5, -2.5, 0.0), "DP_NUDGE_MAX"),
        ((0.0, 0.0, math.radians(46.0)), "DP_NUDGE_YAW"),
        ((math.nan, 0.0, 0.0), "not a number"),
        ((0.0, math.inf, 0.0), "not a number"),
    ],
)
def test_too_much_is_denied_and_nothing_moves(holding: Any, nudge: tuple[float, float, float], reason: str) -> None:
    outcome = holding.supervisor.nudge(*nudge, holding.now_s)
    assert outcome.result is Result.DENIED and reason in outcome.reason
    holding.step(5.0)
    assert holding.away_m(0.0, 0.0) < 1e-6 and outcome.reason in holding.texts()


@pytest.mark.parametrize("mode", [ModeId.MANUAL, ModeId.HEADING, ModeId.DOCK, ModeId.RTL])
def test_only_in_hold(holding: Any, mode: ModeId) -> None:
    assert holding.supervisor.request_mode(mode, holding.now_s).accepted
    for outcome in (
        holding.supervisor.nudge(1.0, 0.0, 0.0, holding.now_s),
        holding.supervisor.set_heading(1.0, holding.now_s),
    ):
        assert outcome.result is Result.TEMPORARILY_REJECTED and "is not Hold" in outcome.reason


def test_not_disarmed_not_in_transit_not_without_position(holding: Any) -> None:
    holding.supervisor.go_to(*holding.point(40.0, 0.0), None, None, holding.now_s)
    holding.step(2.0)
    assert "on its way" in holding.supervisor.nudge(1.0, 0.0, 0.0, holding.now_s).reason
    holding.nav = replace(holding.nav, position_valid=False)
    holding.step()
    assert not holding.supervisor.set_heading(1.0, holding.now_s).accepted
    holding.nav = replace(holding.nav, position_valid=True)
    holding.supervisor.disarm(holding.now_s)
    holding.step()
    assert "arm first" in holding.supervisor.nudge(1.0, 0.0, 0.0, holding.now_s).reason


def test_a_boat_that_cannot_push_itself_sideways(make_boat: Callable[..., Boat], revolt: VesselConfig) -> None:
    jet = make_boat(replace(revolt, limits=replace(revolt.limits, sway_n=0.0)))
    jet.supervisor.request_mode(ModeId.HOLD, jet.now_s)
    jet.supervisor.arm(jet.now_s)
    assert jet.supervisor.nudge(1.0, 0.0, 0.0, jet.now_s).result is Result.DENIED


def test_warning_and_alarm_begin_and_end_once_each(holding: Any) -> None:
    holding.obey = lambda setpoint: None
    seen = []
    for north_m in (2.9, 3.5, 5.9, 6.5, 8.0, 5.5, 4.7, 2.0, 7.0):
        before = len(holding.said)
        holding.nav = replace(holding.nav, north_m=north_m)
        holding.step(11.0)
        seen.append([name.removeprefix("watch_") for name, _ in holding.said[before:] if name.startswith("watch_")])
    assert seen == [
        [],
        ["circle_left"],
        [],
        ["alarm"],
        [],
        [],
        ["alarm_over"],
        ["circle_back"],
        ["circle_left", "alarm"],
    ]
    assert (
        holding.severities["watch_alarm"] is Severity.CRITICAL
        and holding.severities["watch_circle_left"] is Severity.WARNING
    )
