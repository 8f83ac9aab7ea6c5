"""Whole vessels on other boards than the bundled files have: an autopilot board's outputs, and a board that does not
count its battery."""

from __future__ import annotations

import math
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import pytest

from companion.analysis.log_reader import open_log
from companion.cli.rig import LockstepRig
from companion.config.vessel import as_dict
from companion.io.mavlink.wire import messages as mavlink
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import Desk

MICROCONTROLLER = 'driver = "microcontroller"\nport = "serial:/dev/usv-mcu:115200"\nthrusters = ["bow", "stern"]\n'
PIXHAWK = """driver = "mavlink_servo"
port = "serial:/dev/usv-pixhawk:115200"
thrusters = ["bow", "stern"]
[actuator.mavlink]
channels = [9, 10]
azimuth_channels = [11, 12]
"""
BATTERY = "[battery]\ncapacity_ah = 80\nfull_v = 12.8\nempty_v = 11.2\nresistance_ohm = 0.02\n"


def aboat(folder: Path, bridge: str, more: str = "") -> Desk:
    text = resources.files("companion.vessels").joinpath("aboat.toml").read_text(encoding="utf-8")
    assert MICROCONTROLLER in text
    file = folder / "aboat.toml"
    file.write_text(text.replace(MICROCONTROLLER, bridge) + more, encoding="utf-8")
    desk = Desk(folder, LockstepRig(Conditions(str(file), seed=3), folder / "log"))
    desk.tick()
    desk.ready()
    return desk


def test_a_boat_holds_on_an_autopilot_boards_outputs_and_stops_when_the_board_is_gone(tmp_path: Path) -> None:
    desk = aboat(tmp_path, PIXHAWK)
    assert desk.result(mavlink.MAV_CMD_DO_SET_MODE, 1, 4, 3) == mavlink.MAV_RESULT_ACCEPTED
    assert desk.result(400, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    start = desk.rig.world.truth
    for _ in range(60):
        desk.tick(10)
        desk.heartbeat()
    truth = desk.rig.world.truth
    assert math.hypot(truth.north_m - start.north_m, truth.east_m - start.east_m) < 3.0
    assert all(device.ok for device in desk.vessel.device_health(desk.rig.now_s))
    desk.rig.world.add_fault("microcontroller_unplugged")
    desk.tick(20)
    assert any(text.startswith("microcontroller: ") for text in desk.texts())
    assert [throttle.throttle() for throttle in desk.rig.world.thrusters] == pytest.approx([0.0, 0.0], abs=0.05)
    desk.close()
    assert as_dict(open_log(tmp_path / "log").config) == as_dict(desk.rig.config)


def test_a_board_that_does_not_count_leaves_the_counting_to_the_companion(tmp_path: Path) -> None:
    desk = aboat(tmp_path, MICROCONTROLLER, BATTERY)
    board: Any = desk.rig.world.boards[0]
    report = board.status
    board.status = lambda: replace(report(), remaining=None)
    desk.tick(300)
    tick = desk.vessel.last_tick
    assert tick is not None and tick.inputs.battery is not None
    assert tick.inputs.battery.remaining == pytest.approx(desk.rig.world.battery.remaining, abs=0.02)
    assert desk.latest("SYS_STATUS").battery_remaining == pytest.approx(100, abs=2)
    desk.close()
