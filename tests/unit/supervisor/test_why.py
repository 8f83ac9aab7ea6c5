"""The answers to "why": each names the reason that holds, and only that."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.core.actuation import ZERO_WRENCH, Allocation, ThrusterCondition
from companion.core.arming import ArmingCheck, ArmingFinding, ArmingReport
from companion.core.decision import FenceState, ModeId
from companion.core.setpoint import PathSetpoint, PoseSetpoint
from companion.supervisor.mode_changes import Cause
from companion.supervisor.why import CAUSES, why
from tests.unit.supervisor.snapshots import NAV, snapshot

PATH = {"setpoint": PathSetpoint(0.0, 0.25)}
ARMED = {"armed": True}


def test_every_reason_for_a_mode_has_its_words() -> None:
    assert set(CAUSES) == set(Cause) and len(set(CAUSES.values())) == len(CAUSES)


def test_a_disarmed_boat_says_what_speaks_against_arming() -> None:
    lines = list(why(snapshot({"arming_refusals": ("imu: no data", "leak")})))
    assert lines[:3] == ["Disarmed; arming would be refused:", "  imu: no data", "  leak"]
    assert lines[3:] == ["Mode Hold: as at the start", "Speed 0.30 m/s: no thrust while disarmed"]


def test_warnings_speak_not_against_arming() -> None:
    finding = ArmingFinding(ArmingCheck.BATTERY_LOW, "battery low", blocks=False)
    lines = list(why(snapshot(report=ArmingReport((finding,), frozenset(), frozenset(), frozenset()))))
    assert lines[:2] == ["Disarmed: nothing speaks against arming", "  warning: battery low"]


def test_a_failsafe_is_the_reason_for_mode_and_speed() -> None:
    status = {**ARMED, "intended_mode": ModeId.MISSION, "failsafes": ("gcs_lost",)}
    assert list(why(snapshot(status, cause=Cause.FAILSAFE))) == [
        "Armed",
        "Mode Hold: a failsafe acted",
        "  asked for: Mission",
        "  failsafe lasts: gcs_lost",
        "Speed 0.30 m/s: no thrust: failsafe gcs_lost",
    ]


@pytest.mark.parametrize(("action", "more"), [(1, "; GF_ACTION 1 only warns"), (2, "")])
def test_a_boat_outside_its_fence_says_so_for_as_long_as_it_is_there(action: int, more: str) -> None:
    boat = snapshot({**ARMED, "failsafes": ("fence",), "fence": FenceState(True, 1, 3.0, slowed=False)})
    boat.parameters.set("GF_ACTION", action)
    assert list(why(boat))[2:4] == ["  failsafe lasts: fence", "  outside the fence" + more]
    boat = snapshot({**ARMED, "fence": FenceState(False, 1, 3.0, slowed=False)})
    assert not any("outside" in line for line in why(boat))


@pytest.mark.parametrize(
    ("status", "tick", "expected"),
    [
        (ARMED, PATH, ["Speed 0.30 m/s; asked now: 0.25 m/s", "  under way: 0.60 m/s, WP_SPEED"]),
        (
            {**ARMED, "speed_override_mps": 0.4},
            {"setpoint": PoseSetpoint(0.0, 0.0, 0.0, surge_mps=0.3, sway_mps=0.4)},
            [
                "Speed 0.30 m/s; asked now: 0.50 m/s",
                "  under way: 0.40 m/s, as asked for",
                "  dynamic positioning: it comes to a place, or holds one",
            ],
        ),
        (
            {**ARMED, "fence": FenceState(False, 0, None, True)},
            PATH,
            [
                "Speed 0.30 m/s; asked now: 0.25 m/s",
                "  under way: 0.60 m/s, WP_SPEED",
                "  slowed so that it can stop inside the fence",
            ],
        ),
        ({**ARMED, "mode": ModeId.MANUAL}, {}, ["Speed 0.30 m/s: no thrust: no sticks heard, or not yet centred"]),
        ({**ARMED, "mode": ModeId.MANUAL}, PATH, ["Speed 0.30 m/s: sticks steer"]),
        (ARMED, {}, ["Speed 0.30 m/s: no thrust: the mode gives none"]),
        (
            {},
            {"nav": replace(NAV, position_valid=False)},
            ["Speed not known: no thrust while disarmed"],
        ),
        (
            ARMED,
            {**PATH, "allocation": Allocation((), ZERO_WRENCH, (True, False, True))},
            [
                "Speed 0.30 m/s; asked now: 0.25 m/s",
                "  under way: 0.60 m/s, WP_SPEED",
                "  thrusters give all they can: surge, yaw",
            ],
        ),
        (
            ARMED,
            {"conditions": (ThrusterCondition.READY, ThrusterCondition.FAILED, ThrusterCondition.RETRACTED)},
            [
                "Speed 0.30 m/s: no thrust: the mode gives none",
                "  stern_starboard: failed",
                "  bow: retracted",
            ],
        ),
    ],
)
def test_why_this_speed(status: dict[str, object], tick: dict[str, object], expected: list[str]) -> None:
    lines = list(why(snapshot(status, tick)))
    begin = next(i for i, line in enumerate(lines) if line.startswith("Speed"))
    assert lines[begin:] == expected


def test_the_cap_on_the_speed_is_named() -> None:
    boat = snapshot(ARMED, PATH)
    boat.parameters.set("MPC_XY_VEL_MAX", 0.5)
    assert "  under way: 0.50 m/s, at most MPC_XY_VEL_MAX" in list(why(boat))


def test_before_the_first_tick_there_is_no_speed() -> None:
    assert list(why(replace(snapshot(), tick=None)))[-1] == "Mode Hold: as at the start"
