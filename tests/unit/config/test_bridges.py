"""Faults of bridges and calibrations in a vessel's file, each with its place."""

from __future__ import annotations

import pytest

from companion.config import vessel as config
from companion.config.bridges import OutputConfig
from companion.config.vessel import ConfigError, VesselConfig

ABOAT = config.find("aboat").read_text(encoding="utf-8")
MICROCONTROLLER = 'driver = "microcontroller"\nport = "serial:/dev/usv-mcu:115200"\nthrusters = ["bow", "stern"]\n'
BOARD = 'driver = "mavlink_servo"\nport = "serial:/dev/usv-pixhawk:115200"\nthrusters = ["bow", "stern"]\n[actuator.mavlink]\n'
CHANNELS = "channels = [9, 10]\nazimuth_channels = [11, 12]\n"


def with_bridge(bridge: str, output: str = "") -> VesselConfig:
    """ÅBOAT with that bridge, and that calibration of its bow thruster."""
    assert MICROCONTROLLER in ABOAT
    text = ABOAT.replace(MICROCONTROLLER, bridge)
    at = text.index("[[thruster]]", text.index("[[thruster]]") + 1)
    return config.parse(
        f"{text[:at]}{f'[thruster.output]{chr(10)}{output}{chr(10)}' if output else ''}{text[at:]}", "boat.toml"
    )


def problems(bridge: str, output: str = "") -> list[str]:
    with pytest.raises(ConfigError) as caught:
        with_bridge(bridge, output)
    return list(caught.value.problems)


def test_a_board_and_a_calibration_are_read() -> None:
    vessel = with_bridge(BOARD + CHANNELS, "trim = 1520\nreversed = true\nazimuth_min_us = 2100\nazimuth_max_us = 900")
    board, output = vessel.actuators[0].mavlink, vessel.thrusters[0].output
    assert board is not None and (board.channels, board.azimuth_channels, board.method, board.system) == (
        (9, 10),
        (11, 12),
        "override",
        255,
    )
    assert output == OutputConfig(trim=1520.0, reversed=True, azimuth_min_us=2100.0, azimuth_max_us=900.0)
    assert vessel.thrusters[1].output is None


@pytest.mark.parametrize(
    ("bridge", "text"),
    [
        (BOARD.replace("[actuator.mavlink]\n", ""), "actuator[1].driver: needs a table [actuator.mavlink]"),
        (BOARD + "channels = [9]\nazimuth_channels = [11, 12]\n", "channels: needs 2 channels"),
        (BOARD + "channels = [9, 10]\n", "azimuth_channels: needs one for each"),
        (BOARD + "channels = [9, 10]\nazimuth_channels = [11, 0]\n", "azimuth_channels: needs one for each"),
        (BOARD + "channels = [9, 10]\nazimuth_channels = [11, 9]\n", "channel 9 is used twice"),
        (BOARD + CHANNELS + 'method = "do_set_servo"\n', "method: with DO_SET_SERVO the board holds its last pulses"),
        (BOARD + CHANNELS + "relays = [1]\n", "relays: needs 0, one for each of the bridge's relays"),
        (BOARD + CHANNELS + "servo_channels = [9]\n", "servo_channels: needs 0, one for each of the bridge's servos"),
        (BOARD + CHANNELS + "lamps = [1, 1, 2]\n", "relays: relay 1 is used twice"),
        (BOARD + CHANNELS + "system = 300\n", "system: should be less than or equal to 255"),
        (MICROCONTROLLER + "[actuator.mavlink]\n" + CHANNELS, "only for the driver 'mavlink_servo'"),
    ],
)
def test_a_board_that_cannot_be_is_told_with_its_place(bridge: str, text: str) -> None:
    problem = problems(bridge)[0]
    assert problem.startswith("boat.toml:") and text in problem


def test_a_relay_that_stays_on_in_silence_is_taken_from_an_owner_who_knows() -> None:
    board = BOARD.replace("[actuator.mavlink]", 'relays = ["pump"]\n[actuator.mavlink]') + CHANNELS + "relays = [3]\n"
    relay = '[[relay]]\nname = "pump"\n'
    (problem,) = problems(board + relay)
    assert "mavlink.relays: the board leaves its relays as they are" in problem
    assert with_bridge(f"{board}unguarded = true\n{relay}").actuators[0].relays == ("pump",)


def test_a_servo_on_an_overridden_channel_needs_pulses_at_rest() -> None:
    board = (
        BOARD.replace("[actuator.mavlink]", 'servos = ["winch"]\n[actuator.mavlink]')
        + CHANNELS
        + "servo_channels = [13]\n"
    )
    (problem,) = problems(f'{board}[[servo]]\nname = "winch"\n')
    assert "servo[1].name: an overridden channel cannot be without pulses" in problem
    assert with_bridge(f'{board}[[servo]]\nname = "winch"\nrest_us = 1500\n').servos[0].rest_us == 1500.0


def test_do_set_servo_is_taken_from_an_owner_who_knows() -> None:
    vessel = with_bridge(BOARD + CHANNELS + 'method = "do_set_servo"\nunguarded = true\n')
    assert vessel.actuators[0].mavlink is not None and vessel.actuators[0].mavlink.unguarded


@pytest.mark.parametrize(
    ("bridge", "output", "text"),
    [
        (
            BOARD + CHANNELS,
            "trim = 1900\nahead = 1800",
            "output.trim: standstill should lie between full ahead and full astern",
        ),
        (
            BOARD + CHANNELS,
            "trim = 1000\nastern = 1000",
            "output.trim: standstill should lie between",
        ),  # it goes astern as well
        (BOARD + CHANNELS, "ahead = 300", "output.ahead: should be within 500 to 2500 µs"),
        (BOARD + CHANNELS, "trim = 0.1", "output.trim: should be within 500 to 2500 µs"),
        (BOARD + CHANNELS, "ahead = 1600\ndead_band = 100", "output.dead_band: leaves nothing"),
        (BOARD + CHANNELS, "azimuth_reversed = true", "a servo is calibrated by azimuth_min_us and azimuth_max_us"),
        (BOARD + CHANNELS, "azimuth_min_us = 2000", "output.azimuth_max_us: should differ"),
        (MICROCONTROLLER, "ahead = 1900", "output.ahead: should be within -1 to 1"),
        (MICROCONTROLLER, "trim = 0.1", "output.trim: the neutral of this bridge's board is 0"),
        (MICROCONTROLLER, "dead_band = 1.0", "output.dead_band: leaves nothing"),
    ],
)
def test_a_calibration_that_cannot_be_is_told_with_its_place(bridge: str, output: str, text: str) -> None:
    found = problems(bridge, output)
    assert any(text in problem and problem.startswith("boat.toml:") for problem in found)


def test_pods_that_turn_endlessly_and_thrusters_that_retract_need_another_bridge() -> None:
    text = config.find("revolt").read_text(encoding="utf-8")
    bridge = 'driver = "microcontroller"\nport = "serial:/dev/usv-mcu:115200"\n'
    assert bridge in text
    text = text.replace(bridge, bridge.replace("microcontroller", "mavlink_servo"))
    text = text.replace(
        'thrusters = ["stern_port", "stern_starboard", "bow"]\n',
        'thrusters = ["stern_port", "stern_starboard", "bow"]\n[actuator.mavlink]\nchannels = [1, 2, 3]\nazimuth_channels = [4, 5, 0]\n',
    )
    with pytest.raises(ConfigError) as caught:
        config.parse(text, "boat.toml")
    assert [problem.split(": ", 2)[2] for problem in caught.value.problems] == [
        "a servo turns 'stern_port' between stops: give it azimuth_min_deg and azimuth_max_deg",
        "a servo turns 'stern_starboard' between stops: give it azimuth_min_deg and azimuth_max_deg",
        "'bow' is retractable, which this bridge cannot move",
    ]


def test_a_battery_that_is_fuller_when_empty_is_none() -> None:
    battery = "[battery]\ncapacity_ah = 80\nfull_v = 11.0\nempty_v = 12.8\n"
    with pytest.raises(ConfigError, match=r"boat.toml:\d+: battery.empty_v: should be below full_v, 11"):
        config.parse(ABOAT + battery, "boat.toml")
    vessel = config.parse(ABOAT + battery.replace("11.0", "13.0"), "boat.toml")
    assert vessel.battery is not None and (vessel.battery.capacity_ah, vessel.battery.resistance_ohm) == (80.0, 0.0)
