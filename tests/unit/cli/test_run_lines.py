"""The lines that `companion run` shows, from ticks."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.cli.run_lines import FirstLook, Line, RunSummary, clock_text, event_line, status_text
from companion.core.decision import Event, ModeId, Severity, TextKind
from companion.core.readings import Battery, FixType
from companion.core.setpoint import NEUTRAL_SETPOINT, PathSetpoint, Progress
from companion.core.tick import DeviceHealth, Inputs, Tick
from companion.loop import Punctuality
from tests.unit.record.ticks import tick

LINKS = ("udpin:0.0.0.0:14550", "tcpin:127.0.0.1:5760")


@pytest.mark.parametrize(
    ("t_s", "text"), [(0.0, "0:00:00.0"), (59.96, "0:01:00.0"), (83.44, "0:01:23.4"), (36_000.0, "10:00:00.0")]
)
def test_time_since_the_start(t_s: float, text: str) -> None:
    assert clock_text(t_s) == text


def test_an_event_has_time_severity_and_text() -> None:
    line = event_line(Event(83.44, TextKind.ATTENTION, "gnss_lost", "gnss: no bytes"))
    assert line.plain == "0:01:23.4  WARNING    gnss: no bytes"


def test_devices_that_do_not_work_are_told_once_and_soon() -> None:
    look = FirstLook()
    told = [line for n in range(100) for line in look.take(tick(0.1 * n))]
    assert [line.plain for line in told] == ["0:00:01.5  WARNING    imu: no bytes yet"]


def test_that_all_work_is_told_too() -> None:
    well = (DeviceHealth("gnss", True, 0.1),)
    look = FirstLook()
    told = [line for n in range(100) for line in look.take(replace(tick(0.1 * n), health=well))]
    assert told == [Line(1.5, Severity.INFO, "All devices and links are open")]


def status(changed: Tick, late: int = 0, source: str | None = "gnss") -> str:
    return status_text(changed, LINKS, source, late)


def test_the_state_in_one_line() -> None:
    heard = (DeviceHealth(LINKS[0], True, 0.4), DeviceHealth(LINKS[1], True, None), DeviceHealth("gnss", True, 0.1))
    battery = Inputs(battery=Battery(1.0, "board", 24.12, 3.0, 0.78))
    assert status(replace(tick(5.0), health=heard, inputs=battery), late=2) == (
        "Hold armed | RTK fixed 0.02 m | heading 17° (gnss) | 0.50 m off | battery 78 % 24.1 V | heard on 1 of 2 links"
        " | 2 late"
    )


def test_what_is_missing_is_said() -> None:
    base = tick(5.0)
    nav = replace(base.nav, position_valid=False, heading_valid=False, fix=FixType.NONE)
    state = replace(
        base.status, mode=ModeId.MANUAL, armed=False, arming_refusals=("no position",), failsafes=("position_lost",)
    )
    assert status(replace(base, nav=nav, status=state)) == (
        "Manual disarmed, cannot arm (position_lost) | no fix, no position | no heading"
    )


def test_on_a_path_speed_and_cross_track_error() -> None:
    under_way = PathSetpoint(0.0, 1.0, progress=Progress(cross_track_error_m=-0.123))
    assert "0.4 m/s, 0.12 m off track" in status(replace(tick(5.0), setpoint=under_way))
    assert "| 0.4 m/s" in status(replace(tick(5.0), setpoint=NEUTRAL_SETPOINT))


@pytest.mark.parametrize("yaw_deg", [-0.2, 359.7, 0.3])
def test_north_is_zero(yaw_deg: float) -> None:
    base = tick(5.0)
    assert "heading 0° " in status(replace(base, nav=replace(base.nav, yaw_rad=math.radians(yaw_deg))))


def test_the_summary_counts_distance_modes_and_failsafes() -> None:
    summary = RunSummary()
    for n in range(1001):  # 100 s: 20 s disarmed, 50 s Hold, 30 s Mission
        now = tick(0.1 * n)
        mode = ModeId.HOLD if n <= 700 else ModeId.MISSION
        failsafes = ("gcs_lost",) if 300 < n <= 350 or 400 < n <= 420 else ()
        state = replace(now.status, armed=n > 200, mode=mode, failsafes=failsafes)
        nav = replace(now.nav, north_mps=3.0, east_mps=4.0)
        summary.take(replace(now, status=state, nav=nav))
    assert summary.lines(Punctuality(ticks=1001)) == [
        "armed 1 min 20 s of 1 min 40 s, sailed 400 m",
        "modes: Hold 50 s, Mission 30 s",
        "failsafes: gcs_lost 2 times, 7 s",
        "1001 ticks: latest start 0.0 ms late (at 0.0 s), 0 over 5 ms late, 0 skipped",
    ]


def test_a_process_that_was_stopped_has_not_sailed() -> None:
    summary = RunSummary()
    summary.take(tick(0.0))
    summary.take(tick(3600.0))
    assert summary.lines(None)[0] == "armed 5 s of 5 s, sailed 2 m"
