"""Faults that a critical user once found, on a whole vessel in lockstep."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.io.mavlink.wire import messages as mavlink
from sitl.scenarios.rig import Conditions
from tests.laid_paths import followers_started
from tests.protocol.desk import Desk
from tests.protocol.test_qgroundcontrol import ARM, HOLD, MISSION, NAN, RTL, item, square


def desk_in(folder: Path, wind: str | None = None, faults: tuple[str, ...] = ()) -> Desk:
    desk = Desk(folder, LockstepRig(Conditions("revolt", seed=3, wind=wind, faults=faults), folder / "log"))
    desk.tick()
    desk.ready()
    return desk


def sail(desk: Desk, seconds: float) -> None:
    for n in range(round(seconds / desk.vessel.period_s)):
        if n % 10 == 0:
            desk.heartbeat()
        desk.tick()


def test_a_plan_for_another_place_is_not_begun(tmp_path: Path) -> None:
    """It would take the boat 100 km away, and the path there would take a second to lay."""
    desk = desk_in(tmp_path)
    assert desk.upload([item(0, 16, 100_000.0, 0.0), item(1, 16, 100_100.0, 0.0)]) == mavlink.MAV_MISSION_ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    desk.tick(2)
    assert desk.latest("HEARTBEAT").custom_mode != MISSION
    assert any("item 1 is 100 km away" in text for text in desk.texts())
    desk.close()


def test_a_long_leg_is_laid_without_a_pause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the size of what is laid, not the time that it takes."""
    started = followers_started(monkeypatch)
    desk = desk_in(tmp_path)
    assert (
        desk.upload([item(0, 16, 40_000.0, 0.0), item(1, 16, 40_000.0, 100.0), item(2, 16, 0.0, 0.0)])
        == mavlink.MAV_MISSION_ACCEPTED
    )
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    sail(desk, 5.0)
    assert started and all(sum(len(leg) for leg in follower.legs) <= 20_100 for follower, _ in started)
    desk.close()


def test_all_thrusters_dead_is_a_failsafe_that_says_so(tmp_path: Path) -> None:
    faults = tuple(f"thruster_{name}_dead@20" for name in ("stern_port", "stern_starboard", "bow"))
    desk = desk_in(tmp_path, faults=faults)
    desk.upload(square())
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    desk.result(ARM, 1.0)
    sail(desk, 30.0)
    assert any("no thrust left" in text for text in desk.texts())
    assert "thrust_lost" in desk.vessel.supervisor.status(desk.rig.now_s).failsafes
    desk.close()


def test_a_position_that_jumps_is_said(tmp_path: Path) -> None:
    desk = desk_in(tmp_path, faults=("gnss_jump@20",))
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, HOLD))
    desk.result(ARM, 1.0)
    sail(desk, 30.0)
    assert any(text == "gnss position jumped 25 m: not used" for text in desk.texts()), desk.texts()
    desk.close()


def test_rtl_is_at_home_when_the_boat_is(tmp_path: Path) -> None:
    """Wind that it cannot hold against: the reference gets home, the boat does not."""
    desk = desk_in(tmp_path, wind="9@45")
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, HOLD))
    desk.result(ARM, 1.0)
    desk.command(192, -1.0, 1.0, 0.0, NAN, 63.43885, 10.3990, NAN)
    sail(desk, 20.0)
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, RTL))
    for _ in range(60):  # three times as long as the reference takes
        sail(desk, 1.0)
        if any("at home" in text for text in desk.texts()):
            truth = desk.rig.world.truth
            assert math.hypot(truth.north_m, truth.east_m) < 3.0
            break
    desk.close()


def test_a_device_that_never_answers_is_said_once_without_anybody_arming(tmp_path: Path) -> None:
    desk = Desk(tmp_path, LockstepRig(Conditions("revolt", seed=3, faults=("imu_lost@0+15",)), tmp_path / "log"))
    desk.heartbeat()
    sail(desk, 9.0)
    said = [text for text in desk.texts() if text.startswith("imu: ")]
    assert not said
    sail(desk, 10.0)
    said = [text for text in desk.texts() if text.startswith("imu: ")]
    assert len(said) == 2 and said[1] == "imu: back", said
    desk.close()
