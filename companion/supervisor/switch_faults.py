"""What is wrong with the channels that the transmitter's sticks and switches are mapped to."""

from __future__ import annotations

from collections.abc import Iterator

from companion.params.store import Parameters
from companion.params.transmitter import OPTIONS, AuxFunction

KILL_CHANNEL = "RC_MAP_KILL_SW"
_SWITCHES = (
    KILL_CHANNEL,
    "RC_MAP_ARM_SW",
    "RC_MAP_RETURN_SW",
    "RC_MAP_LOITER_SW",
    "RC_MAP_OFFB_SW",
    "RC_MAP_FLTMODE",
    "MAN_RC_LOWER_CH",
)
_STICKS = ("RC_MAP_ROLL", "RC_MAP_PITCH", "RC_MAP_THROTTLE", "RC_MAP_YAW")


def kill_channels(parameters: Parameters) -> list[int]:
    """The channels whose position alone stops the boat."""
    mapped = [int(parameters[KILL_CHANNEL])]
    mapped += [number for name, number in OPTIONS.items() if parameters[name] == AuxFunction.EMERGENCY_STOP]
    return [number for number in mapped if number]


def switch_faults(parameters: Parameters, channels: int) -> Iterator[str]:
    """Each fault in words: a channel that the transmitter does not have, or one that a switch shares. `channels`: how
    many the transmitter has. The safe switch may be missing: it is mapped by default. So may the surge stick that does
    not count."""
    may_be_missing = ("MAN_RC_SAFE_CH", "RC_MAP_PITCH" if parameters["MAN_AXIS_SURGE"] else "RC_MAP_THROTTLE")
    by_channel: dict[int, list[str]] = {}
    for name in ("MAN_RC_SAFE_CH", *_SWITCHES, *_STICKS):
        if number := int(parameters[name]):
            by_channel.setdefault(number, []).append(name)
    for name, number in OPTIONS.items():
        if parameters[name]:
            by_channel.setdefault(number, []).append(name)
    for number, names in sorted(by_channel.items()):
        missing = [name for name in names if name not in may_be_missing and number > channels]
        yield from (f"Transmitter has no channel {number}: {name}" for name in missing)
        if len(names) > 1 and any(name not in _STICKS for name in names):
            yield f"Channel {number} twice: {', '.join(names)}"


def kill_switch_fault(parameters: Parameters, channels: int | None) -> str | None:
    """Why a kill switch that is mapped would not work; None if it would, if none is mapped, or while no transmitter is
    heard (`channels` None)."""
    if channels is None:
        return None
    for number in kill_channels(parameters):
        if number > channels:
            return f"transmitter has no channel {number} for its kill switch"
    return None
