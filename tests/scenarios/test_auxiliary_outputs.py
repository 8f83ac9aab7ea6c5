"""Servos and relays from a ground station and from a mission, down to the emulated board, byte for byte."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

from companion.cli.rig import LockstepRig
from companion.io.mavlink.wire import messages as mavlink
from companion.mission.plan import PlanItem, PlanKind
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import Desk
from tests.scenarios.test_mission_files import message

OUTPUTS = """
[[servo]]
name = "winch"
rest_us = 1500

[[relay]]
name = "pump"

[[relay]]
name = "lamp"
while_disarmed = true
"""


def with_outputs(folder: Path) -> Desk:
    text = resources.files("companion.vessels").joinpath("revolt.toml").read_text(encoding="utf-8")
    driven = 'thrusters = ["stern_port", "stern_starboard", "bow"]'
    assert driven in text
    file = folder / "revolt_with_outputs.toml"
    file.write_text(
        text.replace(driven, f'{driven}\nservos = ["winch"]\nrelays = ["lamp", "pump"]') + OUTPUTS, encoding="utf-8"
    )
    desk = Desk(folder, LockstepRig(Conditions(str(file), seed=3), folder / "log"))
    desk.tick()
    desk.ready()
    return desk


def board(desk: Desk) -> tuple[float | None, bool, bool]:
    """Winch, pump and lamp as they are; the board has the lamp first."""
    outputs = desk.rig.world.boards[0].outputs
    return outputs.servos_us[0], outputs.relays[1], outputs.relays[0]


def test_from_the_ground_station_to_the_board_and_to_rest_with_disarming(tmp_path: Path) -> None:
    desk = with_outputs(tmp_path)
    desk.tick(20)
    assert board(desk) == (1500.0, False, False) and all(
        device.ok for device in desk.vessel.device_health(desk.rig.now_s)
    )
    assert desk.result(183, 1.0, 1900.0) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    assert desk.result(181, 1.0, 1.0) == mavlink.MAV_RESULT_ACCEPTED, "the lamp may be switched at the quay"
    desk.tick(3)
    assert board(desk) == (1500.0, False, True)
    assert desk.result(400, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick()
    for number, *params in ((183, 1.0, 1900.0), (181, 0.0, 1.0)):
        assert desk.result(number, *params) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(3)
    assert board(desk) == (1900.0, True, True)
    assert desk.result(182, 1.0, 1.0, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(3)
    assert board(desk)[2] is False
    desk.tick(12)
    assert board(desk)[2] is True, "once off and on again"
    assert desk.result(183, 2.0, 1500.0) == mavlink.MAV_RESULT_DENIED
    assert desk.result(400, 0.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(3)
    assert board(desk) == (1500.0, False, True)
    desk.close()


def test_from_a_mission(tmp_path: Path) -> None:
    desk = with_outputs(tmp_path)
    frame = desk.vessel.frame
    north = [tuple(round(v * 1e7) for v in frame.to_geodetic(n, 0.0)) for n in (4.0, 14.0)]
    items = [
        PlanItem(0, 16, 3, 0.0, 0.0, 0.0, float("nan"), *north[0], 0.0),
        PlanItem(1, 183, 2, 1.0, 1100.0, 0.0, 0.0, 0, 0, 0.0),
        PlanItem(2, 114, 2, 5.0, 0.0, 0.0, 0.0, 0, 0, 0.0),
        PlanItem(3, 181, 2, 0.0, 1.0, 0.0, 0.0, 0, 0, 0.0),
        PlanItem(4, 16, 3, 2.0, 0.0, 0.0, float("nan"), *north[1], 0.0),
    ]
    assert desk.upload([message(item, PlanKind.MISSION) for item in items]) == mavlink.MAV_MISSION_ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, 0x04040000))
    assert desk.result(400, 1.0) == mavlink.MAV_RESULT_ACCEPTED

    def until(what: str, index: int, value: float | bool) -> float:
        def seen() -> bool:
            if round(desk.rig.now_s * 10) % 10 == 0:
                desk.heartbeat()
            return board(desk)[index] == value

        desk.until(what, seen, 120.0)
        return desk.rig.world.truth.north_m

    assert abs(until("the winch", 0, 1100.0) - 4.0) < 2.0, "when the first waypoint is passed"
    assert abs(until("the pump", 1, True) - 9.0) < 0.5, "5 m before the second"
    desk.close()
