"""Scripts in lockstep: what the interface asks of the boat, and the examples of the documentation as they stand there."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from companion.config.devices import SensorConfig
from companion.config.vessel import find, load
from companion.scripting import Boat, ScriptError, item, waypoint
from companion.scripting.runner import run_file
from sitl.scenarios.rig import Conditions
from tests.docs.pages import blocks
from tests.lockstep_door import LockstepDoor

REVOLT = load(find("revolt"))
SOUNDER = SensorConfig(name="sounder", driver="nmea0183", port="memory:sounder", rate_hz=5.0, z_m=0.2)
EXAMPLES = [block.text for block in blocks("python") if "use/scripting.md" in block.place]


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[LockstepRig]:
    known = replace(REVOLT, sensors=(*REVOLT.sensors, SOUNDER))
    rig = LockstepRig(Conditions("revolt", known=known), tmp_path / "log")
    yield rig
    rig.close()


@pytest.fixture
def door(rig: LockstepRig) -> LockstepDoor:
    return LockstepDoor(rig, limit_s=120.0)


@pytest.fixture
def boat(door: LockstepDoor) -> Boat:
    boat = Boat(door, 231)
    boat.connect()
    boat.sleep(5.0)
    return boat


def line_of(boat: Boat, *metres: float) -> list[tuple[float, float]]:
    """Places so far north of the boat."""
    lat_deg, lon_deg = boat.state.lat_deg, boat.state.lon_deg
    assert lat_deg is not None and lon_deg is not None
    return [boat.moved(lat_deg, lon_deg, north_m, 0.0) for north_m in metres]


def test_a_mission_comes_back_as_it_was_sent_and_is_sailed(boat: Boat, rig: LockstepRig) -> None:
    plan = [item(178, 1.0, 0.75, -1.0), *(waypoint(*place) for place in line_of(boat, 4.0, 12.0))]
    boat.upload(plan)
    assert [(one.command, one.param2, one.x, one.y) for one in boat.mission()] == [
        (one.command, one.param2, one.x, one.y) for one in plan
    ]
    boat.set_mode("Hold")
    boat.arm()
    boat.start_mission()
    assert boat.wait_until(lambda state: state.mission_item == 2, 40.0)
    assert rig.world.truth.north_m > 2.0 and boat.state.mode == "Mission"
    assert any(name == "armed" for name, _ in boat.events())


def test_a_command_jumps_to_a_mark(boat: Boat) -> None:
    first, second = (waypoint(*place) for place in line_of(boat, 4.0, 30.0))
    boat.upload([first, item(600, 7.0), second])
    boat.set_mode("Hold")
    boat.arm()
    boat.start_mission()
    boat.sleep(0.5)
    assert boat.state.mission_item == 0
    boat.command(601, 7.0)
    assert boat.wait_until(lambda state: state.mission_item == 2, 1.0)
    with pytest.raises(ScriptError, match="no JUMP_TAG 8 in the mission"):
        boat.command(601, 8.0)


def test_what_the_boat_refuses_is_raised_with_its_words(boat: Boat) -> None:
    with pytest.raises(ScriptError, match=r"WP_SPEED stays 0\.6: it takes 0.05 to 20 m/s"):
        boat.set_parameter("WP_SPEED", -1.0)
    with pytest.raises(ScriptError, match="command 5555 is not supported; remove it"):
        boat.upload([item(5555)])
    with pytest.raises(ScriptError, match="no mode 'Fly'; there is Manual, Forces"):
        boat.set_mode("Fly")
    for name in ("WP_SPED", "WP_SPEED_THAT_IS_LONG", "", "Größe"):
        with pytest.raises(ScriptError, match=f"^no parameter {name}$"):
            boat.parameter(name)
        with pytest.raises(ScriptError, match=f"^no parameter {name}$"):
            boat.set_parameter(name, 1.0)
    for value in (math.nan, math.inf, 1e12):
        with pytest.raises(ScriptError, match="NAV_DLL_ACT takes whole numbers"):
            boat.set_parameter("NAV_DLL_ACT", value)
    with pytest.raises(ScriptError, match="NAV_DLL_ACT takes whole numbers"):
        boat.set_parameter("NAV_DLL_ACT", 0.5)
    with pytest.raises(ScriptError, match="not supported"):
        boat.command(42000)
    begun_s = boat.state.t_s
    with pytest.raises(ScriptError, match=r"^no parameter NO_SUCH_NAME$"):
        boat.parameter("NO_SUCH_NAME")
    assert boat.state.t_s - begun_s < 1.0, "it does not wait for an answer that has come"


def test_a_number_can_be_told(boat: Boat, door: LockstepDoor) -> None:
    boat.say(7.5)
    assert door.told == [("say", "7.5")]


def test_parameters_of_both_kinds_are_set(boat: Boat) -> None:
    boat.set_parameter("NAV_DLL_ACT", 2)
    boat.set_parameter("WP_SPEED", 0.7)
    assert boat.parameter("NAV_DLL_ACT") == 2.0 and boat.parameter("WP_SPEED") == 0.7


def test_offboard_follows_what_is_proposed_and_ends_with_it(boat: Boat, rig: LockstepRig) -> None:
    boat.propose_velocity(0.3, 0.0)
    boat.set_mode("Hold")
    boat.arm()
    boat.set_mode("Offboard")
    boat.sleep(12.0)
    assert boat.state.mode == "Offboard"
    assert rig.world.truth.surge_mps * math.cos(rig.world.truth.yaw_rad) == pytest.approx(0.3, abs=0.1)
    boat.stop_proposing()
    assert boat.wait_until(lambda state: state.mode == "Hold", 3.0)


def test_a_script_never_stands_for_a_ground_station(boat: Boat, rig: LockstepRig) -> None:
    """Ten seconds after the last ground station, the boat acts, though a script talks to it all the time."""
    station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    rig.send(mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3).pack(station))
    boat.set_mode("Hold")
    boat.arm()
    boat.set_parameter("NAV_DLL_ACT", 3)
    assert boat.wait_until(lambda state: "station_lost" in state.failsafes, 15.0)


def test_the_example_sails_a_line_again_where_the_bottom_changes(
    boat: Boat, door: LockstepDoor, rig: LockstepRig, tmp_path: Path
) -> None:
    file = tmp_path / "repeat_line.py"
    file.write_text(EXAMPLES[0], encoding="utf-8")
    boat.upload([waypoint(*place) for place in line_of(boat, 2.0, 10.0)])
    boat.set_mode("Hold")
    boat.arm()
    boat.start_mission()
    assert boat.wait_until(lambda state: state.mission_item == 1 and state.north_m > 6.0, 40.0)
    rig.world.add_fault("shallow", 1.0)
    items: list[int] = []

    class Watched(Boat):
        def states(self):  # type: ignore[no-untyped-def]
            for state in Boat.states(self):
                items.append(state.mission_item)
                if items[-2:] == [0, 1]:
                    return
                yield state

    door.greet()
    assert run_file(str(file), door, Watched(door, 231)) == 0
    assert [text for kind, text in door.told if kind == "say" and "line 1 again" in text]
    assert items.count(1) > 1 and items[-2:] == [0, 1], "back to the beginning of the line, then along it again"


def test_the_example_in_offboard_ends_when_somebody_chooses_another_mode(
    boat: Boat, door: LockstepDoor, rig: LockstepRig, tmp_path: Path
) -> None:
    file = tmp_path / "contour.py"
    file.write_text(EXAMPLES[1], encoding="utf-8")
    boat.set_mode("Hold")
    boat.arm()

    class Watched(Boat):
        def states(self):  # type: ignore[no-untyped-def]
            for count, state in enumerate(Boat.states(self)):
                if count == 100:
                    self.hold()
                yield state

    door.greet()
    assert run_file(str(file), door, Watched(door, 231)) == 0
    assert boat.next_state().mode == "Hold"
    assert rig.world.truth.surge_mps > 0.1


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("def other(boat): pass\n", "the file has no main(boat)"),
        ("def main(boat):\n    boat.go_to(1 / 0)\n", "line 2: ZeroDivisionError: division by zero"),
        ("def main(boat):\n    boat.set_mode('Fly')\n", "line 2: no mode 'Fly'"),
        ("def main(boat)\n", "SyntaxError"),
        ("raise SystemExit('not today')\n", "not today"),
        ("def main(boat):\n    raise MemoryError\n", "out of memory (memory_mb)"),
    ],
)
def test_a_failure_is_told_in_one_line(door: LockstepDoor, tmp_path: Path, text: str, reason: str) -> None:
    file = tmp_path / "broken.py"
    file.write_text(text, encoding="utf-8")
    assert run_file(str(file), door, Boat(door, 231)) == 1
    ((kind, told),) = door.told
    assert kind == "failed" and told.startswith(reason) and "\n" not in told
