"""Throttle by one bridge and azimuth by another: what a file may say, and where it is wrong."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.config import vessel as config
from companion.config.driving import azimuths_of
from companion.config.toml_places import line_of
from companion.config.vessel import ConfigError

BOARD = 'thrusters = ["stern_port", "stern_starboard", "bow"]\n'
DRIVES = """[[actuator]]
name = "azimuths"
driver = "nanotec"
port = "serial:/dev/usv-azimuths:115200"
azimuths = ["stern_port", "stern_starboard"]
[[actuator.drive]]
thruster = "stern_port"
address = 1
steps_per_turn = 4800
[[actuator.drive]]
thruster = "stern_starboard"
address = 2
steps_per_turn = 4800
ramp_dps2 = 900
homing = "switch"
"""
STEPS = "steps a second, the drive takes 1 to 1000000: check it, and steps_per_turn"
LIGHT = '[[relay]]\nname = "light"\n'
NETWORK = """[[actuator]]
name = "network"
driver = "nmea2000"
port = "can:can0"
thrusters = ["bow"]
[[actuator.motor]]
thruster = "bow"
instance = 0
"""
SECOND_BOARD = """[[actuator]]
name = "second"
driver = "microcontroller"
port = "serial:/dev/usv-second:115200"
thrusters = ["stern_port"]
azimuths = ["stern_starboard"]
"""


def text(board: str = BOARD, drives: str = DRIVES) -> str:
    revolt = config.find("revolt").read_text(encoding="utf-8")
    assert BOARD in revolt
    return revolt.replace(BOARD, board, 1).replace("[dock]", f"{drives}\n[dock]", 1)


def problems(board: str = BOARD, drives: str = DRIVES) -> list[str]:
    try:
        config.parse(text(board, drives), "boat.toml")
    except ConfigError as error:
        return [problem.partition(": ")[2] for problem in error.problems]
    return []


def test_each_throttle_and_each_azimuth_has_one_bridge() -> None:
    vessel = config.parse(text(), "boat.toml")
    board, drives = vessel.actuators
    assert azimuths_of(board, vessel.thrusters, vessel.actuators) == ()
    assert azimuths_of(drives, vessel.thrusters, vessel.actuators) == (0, 1)
    assert drives.drives[1].ramp_radps2 == pytest.approx(15.70796) and drives.drives[0].homing == "here"
    alone = replace(vessel, actuators=(board,))
    assert azimuths_of(board, alone.thrusters, alone.actuators) == (0, 1), (
        "with its throttle, unless another names it; the bow does not turn"
    )
    one = problems(
        drives=DRIVES.replace(', "stern_starboard"]', "]").partition(
            '[[actuator.drive]]\nthruster = "stern_starboard"'
        )[0]
    )
    assert one == []


@pytest.mark.parametrize(
    ("board", "drives", "problem"),
    [
        (
            'thrusters = ["stern_port", "bow"]\n',
            DRIVES,
            "thruster: the throttle of 'stern_starboard' is driven by no bridge: add it to the list of an [[actuator]]",
        ),
        (
            BOARD,
            DRIVES
            + '[[actuator]]\nname = "x"\ndriver = "nanotec"\nport = "serial:/dev/x"\nazimuths = ["stern_port"]\n',
            "actuator[3].azimuths: the azimuth of 'stern_port' is driven by two bridges",
        ),
        (
            BOARD,
            DRIVES.replace("azimuths = [", 'thrusters = ["bow"]\nazimuths = ['),
            "actuator[2].thrusters: the throttle of 'bow' is driven by two bridges",
        ),
        (
            BOARD,
            DRIVES.replace('["stern_port", ', '["bow", "stern_port", '),
            "actuator[2].azimuths: 'bow' does not turn",
        ),
        (
            BOARD,
            DRIVES.replace('["stern_port", ', '["keel", "stern_port", '),
            "actuator[2].azimuths: no thruster named 'keel'; there is stern_port, stern_starboard, bow",
        ),
        (BOARD, DRIVES.replace("address = 2", "address = 1"), "actuator[2].drive[2].address: 1 is used twice"),
        (BOARD, DRIVES.replace("4800", "5e6", 1), f"actuator[2].drive[1].speed_dps: makes 2083333 {STEPS}"),
        (BOARD, DRIVES.replace("4800", "20\nhoming_dps = 1", 1), f"actuator[2].drive[1].homing_dps: makes 0 {STEPS}"),
        (
            BOARD,
            DRIVES.replace("ramp_dps2 = 900", "ramp_dps2 = 900000"),
            f"actuator[2].drive[2].ramp_dps2: makes 12000000 {STEPS.replace('1000000', '3000000')}",
        ),
        (
            BOARD,
            DRIVES.replace("azimuths = [", 'relays = ["light"]\nazimuths = [') + LIGHT,
            "actuator[2].relays: this bridge drives no relays: name them in those of another",
        ),
        (
            BOARD.replace(', "bow"]', "]"),
            NETWORK,
            "actuator[2].thrusters: 'bow' is retractable, which this bridge cannot move",
        ),
        (
            BOARD.replace('"stern_port", ', ""),
            DRIVES + SECOND_BOARD,
            "actuator[3].azimuths: a board that turns 'stern_starboard' drives its throttle too: add it to 'thrusters'",
        ),
        (
            f"thrusters = [{', '.join(repr(f't{i}') for i in range(17))}]\n",
            DRIVES,
            "actuator[1].thrusters: 17 thrusters; a board drives up to 16: give it a second board",
        ),
        (
            BOARD,
            DRIVES.replace('thruster = "stern_starboard"', 'thruster = "stern_port"'),
            "actuator[2].drive[2].thruster: 'stern_port' has two",
        ),
        (
            BOARD,
            DRIVES.replace('thruster = "stern_starboard"', 'thruster = "bow"'),
            "actuator[2].drive[2].thruster: 'bow' is not among the thrusters or azimuths of this bridge",
        ),
        (
            BOARD,
            DRIVES.partition('[[actuator.drive]]\nthruster = "stern_starboard"')[0],
            "actuator[2].driver: needs an [[actuator.drive]] for 'stern_starboard'",
        ),
        (
            BOARD.replace(', "bow"]', "]"),
            DRIVES.replace("azimuths = [", 'thrusters = ["bow"]\nazimuths = ['),
            "actuator[2].thrusters: this bridge drives azimuths alone: name them in 'azimuths', and another bridge for the propellers",
        ),
        (
            BOARD,
            DRIVES.replace("nanotec", "nmea2000"),
            "actuator[2].drive: only for the driver 'nanotec', not 'nmea2000'",
        ),
        (
            BOARD,
            DRIVES.replace("nanotec", "nmea2000"),
            "actuator[2].driver: needs an [[actuator.motor]] for 'stern_port'",
        ),
        (
            BOARD,
            '[[actuator]]\nname = "x"\ndriver = "nanotec"\nport = "serial:/dev/x"\n',
            "actuator[2].driver: drives nothing: name thrusters, or azimuths",
        ),
    ],
)
def test_what_is_driven_by_none_or_two_is_told(board: str, drives: str, problem: str) -> None:
    assert problem in problems(board, drives), problems(board, drives)


def test_a_fault_in_a_table_within_a_table_is_told_with_its_line() -> None:
    with pytest.raises(ConfigError) as caught:
        config.parse(text(drives=DRIVES.replace("address = 2", "address = 300")), "boat.toml")
    lines = text(drives=DRIVES.replace("address = 2", "address = 300")).splitlines()
    (problem,) = caught.value.problems
    assert problem.startswith(f"boat.toml:{lines.index('address = 300') + 1}: actuator[2].drive[2].address: ")


def test_tables_within_tables_are_found_below_their_own_parent() -> None:
    lines = ["[[a]]", "[[a.b]]", "x = 1", "[[a]]", "x = 2", "[[a.b]]", "x = 3", "[[a.b]]", "x = 4", "[a.c]", "x = 5"]
    places = (
        ("a", 0, "b", 0, "x"),
        ("a", 1, "x"),
        ("a", 1, "b", 0, "x"),
        ("a", 1, "b", 1, "x"),
        ("a", 1, "c", "x"),
        ("a", 1, "b", 2, "x"),
    )
    assert [line_of(lines, place) for place in places] == [3, 5, 7, 9, 11, 4]
