"""Rows of the table of parameters: the transmitter's sticks, switches and channels.

Names and ranges are PX4's, so that QGroundControl's pages Radio and Flight Modes set them. So are the numbers of
COM_FLTMODE1 to 6, where PX4 has such a mode; what each number chooses here is `SWITCH_MODES`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from companion.core.decision import ModeId
from companion.params.spec import ParamSpec, choice, real

CHANNELS = 8  # that bridges pass on
POSITIONS = 6  # of the mode switch

NO_MODE = -1
SWITCH_MODES: Mapping[int, ModeId] = {
    0: ModeId.MANUAL,
    1: ModeId.FORCES,  # Altitude
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

_CALIBRATION = "Transmitter channels"
_SWITCHES = "Transmitter"
_CHANNEL_NAMES = {0: "None"} | {n: f"Channel {n}" for n in range(1, CHANNELS + 1)}
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
    *(spec for n in range(1, CHANNELS + 1) for spec in _calibration(n)),
)
