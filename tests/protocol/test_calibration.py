"""Compass, level and gyro calibrated by what ground stations send, on a simulated boat that somebody turns."""

from __future__ import annotations

import math
import socket
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.plugins.calibration import Calibration, CalibrationResult

from companion.analysis.log_reader import open_log
from companion.analysis.replay import replay
from companion.analysis.rerun import rerun
from companion.cli.rig import LockstepRig
from companion.config import vessel as config_module
from companion.config.vessel import VesselConfig
from companion.io.mavlink.wire import messages as mavlink
from sitl.magnetometer import with_magnetometer
from sitl.scenarios.rig import Conditions
from sitl.tow import TowLeg
from tests.protocol.afloat import Afloat
from tests.protocol.desk import Desk
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import free_port
from tests.waiting import CAP_S, wait_until

CALIBRATE = 241
MANUAL, HOLD = 0x00010000, 0x03040000
TURNS = (TowLeg(5.0, 0.0), TowLeg(300.0, 0.3, 0.044))  # 25°/s
STILL = (TowLeg(1000.0, 0.0),)


def boat(folder: Path, tow: Sequence[TowLeg] = TURNS, magnetometer: str = "raw", **more: object) -> Desk:
    """A ReVolt whose only heading is that of a magnetometer amid iron that its file does not know."""
    conditions = Conditions("revolt", seed=3, magnetometer=magnetometer, tow=tuple(tow), **more)  # type: ignore[arg-type]
    desk = Desk(folder, LockstepRig(conditions, folder / "log"))
    desk.heartbeat()
    desk.tick(20)
    return desk


def lines(desk: Desk) -> list[str]:
    return [text.removeprefix("[cal] ") for text in desk.texts() if text.startswith("[cal] ")]


def steps(desk: Desk) -> list[str]:
    """Of the calibration, without its progress."""
    return [line for line in lines(desk) if not line.startswith("progress")]


def ended(desk: Desk) -> bool:
    return any(
        line.startswith(("calibration done", "calibration failed", "calibration cancelled")) for line in lines(desk)
    )


def heading_errors_deg(desk: Desk, ticks: int) -> list[float]:
    found = []
    for _ in range(ticks):
        desk.tick()
        tick = desk.vessel.last_tick
        assert tick is not None
        found.append(abs(math.degrees(math.remainder(tick.nav.yaw_rad - desk.rig.world.truth.yaw_rad, math.tau))))
    return found


@pytest.fixture(scope="module")
def compass(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of a boat whose compass is calibrated under way."""
    folder = tmp_path_factory.mktemp("compass")
    desk = boat(folder)
    before = heading_errors_deg(desk, 20)
    assert max(before) > 8.0
    assert desk.result(CALIBRATE, 0, 1) == 0
    desk.until("the end", lambda: ended(desk), 120.0)
    assert steps(desk) == [
        "calibration started: 2 mag",
        "down orientation detected",
        "down side done, rotate to a different side",
        "calibration done: mag",
    ]
    progress = [int(line.partition("<")[2][:-1]) for line in lines(desk) if line.startswith("progress")]
    assert progress == sorted(progress) and len(progress) > 10 and progress[-1] == 100
    assert any("Compass calibrated: 0." in text for text in desk.texts())
    desk.tick(40)
    assert max(heading_errors_deg(desk, 60)) < 3.0, "it takes effect at once"
    assert desk.vessel.parameters["CAL_MAG0_XSCALE"] > 0.0
    told = {m.param_id for m in desk.received if m.get_type() == "PARAM_VALUE"}
    assert {"CAL_MAG0_XOFF", "CAL_MAG0_WANDER"} <= told
    desk.close()
    return folder / "log"


def test_a_calibration_is_part_of_the_run(compass: Path, tmp_path: Path) -> None:
    log = open_log(compass)
    assert replay(log, tmp_path / "replay.csv").largest_in_log() == 0.0
    assert rerun(log, tmp_path / "again").same


def test_level_and_gyro_of_a_boat_that_lies_still(tmp_path: Path) -> None:
    desk = boat(tmp_path, STILL, magnetometer="calibrated")
    for params, word in (((0, 0, 0, 0, 2), "level"), ((1,), "gyro"), ((0, 0, 0, 0, 1), "level")):
        desk.received.clear()
        assert desk.result(CALIBRATE, *params) == 0
        desk.until("the end", lambda: ended(desk), 20.0)
        assert steps(desk) == [f"calibration started: 2 {word}", f"calibration done: {word}"]
    assert "Accelerometer: a boat takes its level only" in desk.texts()
    desk.close()


def test_a_boat_that_turns_gives_no_gyro_bias(tmp_path: Path) -> None:
    desk = boat(tmp_path, magnetometer="calibrated")
    desk.tick(80)
    assert desk.result(CALIBRATE, 1) == 0
    desk.until("the end", lambda: ended(desk), 20.0)
    assert steps(desk)[-1] == "calibration failed: the boat moves"
    assert "Gyro not calibrated: the boat moves" in desk.texts()
    desk.close()


def test_it_can_be_cancelled_and_begun_again(tmp_path: Path) -> None:
    desk = boat(tmp_path, STILL)
    said: list[str] = []
    assert desk.result(CALIBRATE) == 0, "nothing runs: nothing to cancel"
    for _ in range(2):
        desk.received.clear()
        assert desk.result(CALIBRATE, 0, 1) == 0
        desk.tick(3)
        assert desk.result(CALIBRATE, 1) == 1
        assert desk.result(CALIBRATE) == 0
        said += desk.texts()
        desk.tick()
        said += desk.texts()
        assert steps(desk) == [
            "calibration started: 2 mag",
            "down orientation detected",
            "calibration cancelled",
        ]
    assert "Calibration refused: compass calibration runs" in said
    desk.tick(30)
    assert steps(desk)[-1] == "calibration cancelled"
    desk.close()


def test_what_cannot_be_calibrated_is_refused(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    desk.ready()
    assert desk.result(CALIBRATE, 0, 1) == 2
    assert desk.result(CALIBRATE, 0, 0, 1) == 2 and "a boat calibrates compass, gyro and level" in desk.texts()
    assert desk.result(CALIBRATE, 0, 0, 0, 1) == 0, "the ground station calibrates the transmitter"
    assert desk.result(400, 1) == 0
    assert desk.result(CALIBRATE, 0, 0, 0, 0, 2) == 1
    desk.tick()
    assert "Calibration refused: disarm first" in desk.texts()
    assert "Calibration refused: no sensor has heading = ahrs" in desk.texts()
    desk.close()


def test_armed_only_in_a_mode_that_needs_no_heading(tmp_path: Path) -> None:
    desk = boat(tmp_path, STILL, magnetometer="calibrated")
    desk.ready()
    desk.tell(set_mode(HOLD))
    assert desk.result(400, 1) == 0 and desk.result(CALIBRATE, 0, 1) == 1
    desk.tick()
    assert "Calibration refused: disarm, or choose Manual" in desk.texts(), "in one message"
    desk.tell(set_mode(MANUAL))
    assert desk.result(CALIBRATE, 0, 1) == 0
    desk.tick(3)
    desk.tell(set_mode(HOLD))
    desk.tick(3)
    assert "calibration failed: disarm, or choose Manual" in steps(desk)
    desk.close()


def set_mode(number: int) -> object:
    return mavlink.MAVLink_set_mode_message(1, 1, number)


# --- clients that are not ours -------------------------------------------------------------------------------------


def raw_magnetometer(config: VesselConfig) -> tuple[VesselConfig, VesselConfig]:
    """(what the controller knows, the truth)."""
    real = with_magnetometer(config)
    return config_module.without_calibration(real), real


@pytest.mark.process
def test_mavsdk_calibrates_and_the_result_outlives_a_restart(tmp_path: Path) -> None:
    known, real = raw_magnetometer(config_module.load(config_module.find("revolt")))
    port = free_port()
    tow = (TowLeg(5.0, 0.0), TowLeg(45.0, 0.3, 0.044), *STILL)
    afloat = Afloat(tmp_path, known, [f"udpout:127.0.0.1:{port}"], real=real, speed=20.0, seed=3, tow=tow)
    with afloat, Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
        system = sdk.first_autopilot(CAP_S)
        assert system is not None
        calibration, told = Calibration(system), []

        def callback(result: CalibrationResult, progress: Any, _user: Any) -> None:
            told.append((result, progress.progress if progress.has_progress else progress.status_text))

        for begin in (
            calibration.calibrate_magnetometer_async,
            calibration.calibrate_level_horizon_async,
            calibration.calibrate_accelerometer_async,
            calibration.calibrate_gyro_async,
        ):
            told.clear()
            if begin != calibration.calibrate_magnetometer_async:
                wait_until(lambda: afloat.world.t_s > 60.0, "the boat lies still")
            begin(callback)
            wait_until(lambda: told and told[-1][0] is not CalibrationResult.NEXT, "the end")
            assert told[-1][0] is CalibrationResult.SUCCESS, (begin.__name__, told[-3:])
        # cancelling is tested by its frames: MAVSDK's call was seen not to return, and then blocks its own end
        values = {
            name: value
            for name, value in afloat.vessel.parameters.changed().items()
            if name.startswith(("CAL_", "SENS_BOARD_"))
        }
        assert values["CAL_MAG0_XSCALE"] > 0.0 and len(values) > 10
    with afloat:
        assert {name: afloat.vessel.parameters[name] for name in values} == values


@pytest.mark.process
def test_mavproxy_calibrates_on_an_ardupilot_link(tmp_path: Path) -> None:
    known, real = raw_magnetometer(config_module.load(config_module.find("revolt")))
    port = free_port(socket.SOCK_STREAM)
    tow = (TowLeg(5.0, 0.0), TowLeg(1e6, 0.3, 0.044))
    link = f"tcpin:127.0.0.1:{port}?dialect=ardupilot"
    with Afloat(tmp_path, known, [link], real=real, speed=20.0, seed=3, tow=tow) as afloat:
        with MavProxy(f"tcp:127.0.0.1:{port}", tmp_path / "mavproxy") as station:
            station.expect("online system 1")
            station.say("magcal start")
            station.expect(r"Compass calibration: turn round twice, slowly")
            station.say("magcal cancel")
            station.expect("Compass calibration cancelled")
            station.say("gyrocal")
            station.expect("Gyro not calibrated: the boat moves")
            station.say("magcal start")
            station.expect(r"Compass calibrated: 0\.\d deg of deviation left")
            station.expect(r"Calibration of compass 0 SUCCESS: fitness \d")
        assert afloat.vessel.parameters["CAL_MAG0_XSCALE"] > 0.0
