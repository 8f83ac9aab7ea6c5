"""Rows of the table of parameters: the transmitter's sticks, switches and channels.

Names and ranges are PX4's, so that QGroundControl's pages Radio and Flight Modes set them. So are the numbers of
COM_FLTMODE1 to 6, where PX4 has such a mode; what each number chooses here is `SWITCH_MODES`. RC5_OPTION to
RC16_OPTION are ArduPilot's, with its numbers (`AuxFunction`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import IntEnum

from companion.core.decision import ModeId
from companion.params.spec import ParamSpec, choice, real

CHANNELS = 16  # that switches may be on
CALIBRATED = 8  # of them; the others are taken as they are
SWITCH_CHANNELS = range(5, CHANNELS + 1)  # before them are a transmitter's sticks
POSITIONS = 6  # of the mode switch

NO_MODE = -1
SWITCH_MODES: Mapping[int, ModeId] = {
    0: ModeId.MANUAL,
    1: ModeId.FORCES,  # Altitude
    6: ModeId.RATE,  # Acro
    8: ModeId.HEADING,  # Stabilized
    4: ModeId.HOLD,
    3: ModeId.MISSION,
    5: ModeId.RTL,
    11: ModeId.DOCK,  # Land
    100: ModeId.CIRCLE,  # External Mode 1
    101: ModeId.TRIAL,  # External Mode 2
    12: ModeId.FOLLOW,
    7: ModeId.OFFBOARD,
}
"""The mode that each number of COM_FLTMODE1 to 6 chooses; the comments are PX4's names where they differ."""


class AuxFunction(IntEnum):
    """What a switch can do; the numbers are ArduPilot's (RCn_OPTION), the names are for people."""

    def __new__(cls, number: int, label: str = "") -> AuxFunction:
        """`label`: for people."""
        member = int.__new__(cls, number)
        member._value_ = number
        return member

    def __init__(self, _number: int, label: str = "") -> None:
        self.label = label

    NOTHING = 0, "Nothing"
    RTL = 4, "RTL"
    SAVE_WAYPOINT = 7, "Save waypoint"
    CAMERA = 9, "Take picture"
    FENCE = 11, "Fence on or off"
    MISSION = 16, "Mission (Auto)"
    MISSION_RESET = 24, "Mission to its first item"
    RELAY_1 = 28, "Relay 0 (ArduPilot's Relay 1)"
    EMERGENCY_STOP = 31, "Emergency stop"
    RELAY_2 = 34, "Relay 1 (ArduPilot's Relay 2)"
    RELAY_3 = 35, "Relay 2 (ArduPilot's Relay 3)"
    RELAY_4 = 36, "Relay 3 (ArduPilot's Relay 4)"
    SMART_RTL = 42, "SmartRTL"
    LEARN_CRUISE = 50, "Learn cruise speed"
    MANUAL = 51, "Manual"
    ACRO = 52, "Rate (Acro)"
    STEERING = 53, "Heading (Steering)"
    HOLD = 54, "Hold"
    GUIDED = 55, "Offboard (Guided)"
    LOITER = 56, "Hold (Loiter)"
    FOLLOW = 57, "Follow"
    CLEAR_MISSION = 58, "Clear mission"
    SAILBOAT_TACK = 63, "Tack"
    RELAY_5 = 66, "Relay 4 (ArduPilot's Relay 5)"
    RELAY_6 = 67, "Relay 5 (ArduPilot's Relay 6)"
    CIRCLE = 72, "Circle"
    SAILBOAT_MOTOR = 74, "Motor beside the sail"
    DISARM = 81, "Disarm"
    ARM_DISARM = 153, "Arm or disarm"


AUX_MODES: Mapping[AuxFunction, ModeId] = {
    AuxFunction.RTL: ModeId.RTL,
    AuxFunction.MISSION: ModeId.MISSION,
    AuxFunction.SMART_RTL: ModeId.RTL,
    AuxFunction.MANUAL: ModeId.MANUAL,
    AuxFunction.ACRO: ModeId.RATE,
    AuxFunction.STEERING: ModeId.HEADING,
    AuxFunction.HOLD: ModeId.HOLD,
    AuxFunction.GUIDED: ModeId.OFFBOARD,
    AuxFunction.LOITER: ModeId.HOLD,
    AuxFunction.FOLLOW: ModeId.FOLLOW,
    AuxFunction.CIRCLE: ModeId.CIRCLE,
}
"""The functions that choose a mode."""

RELAYS: Mapping[AuxFunction, int] = {
    AuxFunction.RELAY_1: 0,
    AuxFunction.RELAY_2: 1,
    AuxFunction.RELAY_3: 2,
    AuxFunction.RELAY_4: 3,
    AuxFunction.RELAY_5: 4,
    AuxFunction.RELAY_6: 5,
}
"""The functions that switch a relay, with its number (from 0, as in MAVLink)."""

OPTIONS: Mapping[str, int] = {f"RC{n}_OPTION": n for n in SWITCH_CHANNELS}
"""The parameters that give a channel a function: parameter → channel."""

RUDDER_OFF, RUDDER_ARMS, RUDDER_BOTH = 0, 1, 2  # of ARMING_RUDDER, as ArduPilot's

_CALIBRATION = "Transmitter channels"
_SWITCHES = "Transmitter"
_CHANNEL_NAMES = {0: "None"} | {n: f"Channel {n}" for n in range(1, CHANNELS + 1)}
_FUNCTION_NAMES = {int(function): function.label for function in AuxFunction}
_MODE_NAMES = {NO_MODE: "None"} | {number: mode.value for number, mode in SWITCH_MODES.items()}


def _channel(name: str, default: int, text: str) -> ParamSpec:
    return choice(name, default, _CHANNEL_NAMES, _SWITCHES, text)


def _switch(part: str, threshold: str, what: str, does: str) -> Iterator[ParamSpec]:
    """A switch: its channel, and where it counts as on."""
    yield _channel(f"RC_MAP_{part}_SW", 0, f"Channel of the {what} switch: {does}")
    text = f"Share of its channel's travel above which the {what} switch is on; negative: below which"
    yield real(f"RC_{threshold}_TH", 0.75, -1.0, 1.0, "norm", _SWITCHES, text)


def _calibration(n: int) -> Iterator[ParamSpec]:
    """One channel: its pulses, direction and dead zone."""
    yield real(f"RC{n}_MIN", 1000.0, 800.0, 1500.0, "us", _CALIBRATION, f"Channel {n}: shortest pulse", decimals=0)
    text = f"Channel {n}: pulse at the centre; at the low end for a stick that gives ahead only"
    yield real(f"RC{n}_TRIM", 1500.0, 800.0, 2200.0, "us", _CALIBRATION, text, decimals=0)
    yield real(f"RC{n}_MAX", 2000.0, 1500.0, 2200.0, "us", _CALIBRATION, f"Channel {n}: longest pulse", decimals=0)
    turned = {-1: "Reversed", 1: "Normal"}
    yield real(f"RC{n}_REV", 1.0, -1.0, 1.0, "", _CALIBRATION, f"Channel {n}: direction", decimals=0, choices=turned)
    text = f"Channel {n}: pulses this near to the centre count as centred, beside MAN_DEADBAND"
    yield real(f"RC{n}_DZ", 0.0, 0.0, 100.0, "us", _CALIBRATION, text, decimals=0)


ROWS: tuple[ParamSpec, ...] = (
    _channel("RC_MAP_ROLL", 1, "Channel of the stick that gives sway, to starboard"),
    _channel("RC_MAP_PITCH", 2, "Channel of the stick that gives surge with MAN_AXIS_SURGE 0"),
    _channel("RC_MAP_THROTTLE", 3, "Channel of the stick that gives surge with MAN_AXIS_SURGE 1"),
    _channel("RC_MAP_YAW", 4, "Channel of the stick that turns the boat"),
    *_switch("KILL", "KILLSWITCH", "kill", "while it is on, the boat is disarmed and cannot be armed"),
    *_switch("ARM", "ARMSWITCH", "arm", "moved on it arms, moved off it disarms"),
    *_switch("RETURN", "RETURN", "return", "moved on it chooses RTL"),
    *_switch("LOITER", "LOITER", "hold", "moved on it chooses Hold"),
    *_switch("OFFB", "OFFB", "offboard", "moved on it chooses Offboard"),
    _channel("RC_MAP_FLTMODE", 0, "Channel of the mode switch, whose six positions choose COM_FLTMODE1 to 6"),
    *(
        choice(f"COM_FLTMODE{n}", NO_MODE, _MODE_NAMES, _SWITCHES, f"Mode at position {n} of the mode switch")
        for n in range(1, POSITIONS + 1)
    ),
    *(
        choice(name, 0, _FUNCTION_NAMES, _SWITCHES, f"What the switch on channel {n} does, with ArduPilot's numbers")
        for name, n in OPTIONS.items()
    ),
    choice(
        "ARMING_RUDDER",
        RUDDER_OFF,
        {RUDDER_OFF: "No", RUDDER_ARMS: "Arms", RUDDER_BOTH: "Arms and disarms"},
        _SWITCHES,
        "Yaw stick of the transmitter held over for 2 s with the surge stick centred: starboard arms, port disarms",
    ),
    *(spec for n in range(1, CALIBRATED + 1) for spec in _calibration(n)),
)
