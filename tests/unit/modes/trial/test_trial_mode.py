"""Trial as others see it; what the boat does in it is sailed in tests/scenarios/test_trial.py."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.decision import ModeId
from companion.core.readings import AisTarget
from companion.core.setpoint import HeadingSetpoint, NeutralSetpoint, ThrusterSetpoint
from companion.mission.plan import PlanKind
from companion.modes.trial.mode import TrialOrder
from tests.unit.modes.test_circle import BOX, armed


def begun(boat: Any, radius_m: float | None = None) -> Any:
    armed(boat)
    outcome = boat.supervisor.give_order(TrialOrder(radius_m), boat.now_s)
    assert outcome.accepted, outcome.reason
    boat.step()
    return boat


def trial_of(boat: Any) -> Any:
    return boat.supervisor.parts.trial


def test_it_begins_with_the_motor_check_inside_a_circle_that_is_shown(make_boat: Any) -> None:
    boat = begun(make_boat(), 25.0)
    assert boat.status.mode is ModeId.TRIAL and boat.status.orbit.radius_m == 25.0
    assert any(text.startswith("Trial: circle of 25 m, ") for text in boat.texts())
    assert any("motor check" in text for text in boat.texts())
    assert 600.0 < boat.status.trial_left_s < 1102.3
    boat.step(3.0)
    assert isinstance(boat.setpoint, ThrusterSetpoint)
    assert [bool(command.throttle) for command in boat.setpoint.thrusters] == [True, False, False]


def test_a_boat_that_does_not_answer_is_named_and_gets_no_thrust(make_boat: Any) -> None:
    boat = begun(make_boat())
    boat.until(lambda: "Trial: no thrust: correct the file or the wires" in boat.texts())
    assert "Trial: stern_port does not push" in boat.texts() and boat.now_s < 60.0
    boat.step(1.0)
    assert boat.status.mode is ModeId.TRIAL and isinstance(boat.setpoint, NeutralSetpoint)


@pytest.mark.parametrize(
    ("radius_m", "reason"), [(5.0, "Trial refused: circle of 5 m: this boat needs 12 m"), (25.0, "")]
)
def test_the_circle_must_have_room(make_boat: Any, radius_m: float, reason: str) -> None:
    boat = armed(make_boat())
    assert boat.supervisor.give_order(TrialOrder(radius_m), boat.now_s).reason == reason


def test_the_circle_must_lie_inside_the_fence(make_boat: Any) -> None:
    boat = make_boat()
    boat.fence(*BOX)
    armed(boat)
    refused = boat.supervisor.give_order(TrialOrder(70.0), boat.now_s)
    assert refused.reason == "Trial refused: way crosses the fence"
    assert boat.supervisor.give_order(TrialOrder(50.0), boat.now_s).accepted


def test_a_new_fence_through_the_circle_ends_it(make_boat: Any) -> None:
    boat = begun(make_boat(), 50.0)
    boat.fence((-20.0, -20.0), (20.0, -20.0), (20.0, 20.0), (-20.0, 20.0))
    boat.step(1.0)
    assert boat.plans.plan_id(PlanKind.FENCE) and boat.status.mode is ModeId.HOLD


def test_it_pauses_for_traffic_and_goes_on(make_boat: Any) -> None:
    boat = begun(make_boat(), 25.0)
    lat_deg, lon_deg = boat.point(40.0, 0.0)
    near = AisTarget(boat.now_s, "ais", 257000001, lat_deg=lat_deg, lon_deg=lon_deg, speed_mps=0.0, name="SAGA")
    boat.supervisor.traffic_heard(near, boat.now_s)
    boat.step(1.0)
    assert "Trial: paused: SAGA comes near" in boat.texts() and isinstance(boat.setpoint, HeadingSetpoint)
    lat_deg, lon_deg = boat.point(2000.0, 0.0)
    boat.supervisor.traffic_heard(replace(near, t_s=boat.now_s, lat_deg=lat_deg, lon_deg=lon_deg), boat.now_s)
    boat.step(12.0)
    assert any(text.startswith("Trial: goes on") for text in boat.texts())
    assert trial_of(boat).time_left_s > 60.0


def test_a_jet_is_refused(make_boat: Any) -> None:
    boat = armed(make_boat(load(find("rescuerunner"))))
    refused = boat.supervisor.request_mode(ModeId.TRIAL, boat.now_s)
    assert refused.reason == "Trial refused: a jet has no way astern"
