"""The transmitter's switches: kill, arm, return, hold, offboard, the mode switch of six positions, and the channels
that have a function of their own (RC5_OPTION to RC16_OPTION).

A switch acts when it is moved, the kill switch by its position. After the start, and after a silence of the
transmitter, switches are read first and act when they are moved after that. While it is silent none acts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from companion.core.decision import ModeId, TextKind
from companion.core.events import EventLog
from companion.core.readings import RcInput
from companion.params.store import Parameters
from companion.params.transmitter import AUX_MODES, OPTIONS, POSITIONS, SWITCH_MODES, AuxFunction
from companion.supervisor.authority import RequestedAction
from companion.supervisor.switch_faults import KILL_CHANNEL, kill_channels, switch_faults

SETTLE_S = 0.2  # for so long a position must last: a switch passes over others on its way
_HYSTERESIS = 0.05  # share of the travel, for a switch that is on
_OPTION_THRESHOLD = 0.75  # of the travel: the upper of three positions
_POSITION_WIDTH = 0.35  # of the mode switch: PX4's slots, whose lamps QGroundControl lights
_FIRST_POSITION = -1.136


@dataclass(frozen=True, slots=True)
class Switch:
    """`channel` and `threshold`: its parameters. `mode`: what it chooses, if it chooses one. `function`: of a channel
    that has one; such a switch has no threshold of its own."""

    name: str
    channel: str
    threshold: str = ""
    mode: ModeId | None = None
    function: AuxFunction = AuxFunction.NOTHING

    @property
    def key(self) -> str:
        """Tells it apart from what was on its channel before."""
        return f"{self.channel}={self.function:d}" if self.function else self.channel


KILL = Switch("kill switch", KILL_CHANNEL, "RC_KILLSWITCH_TH")
ARM = Switch("arm switch", "RC_MAP_ARM_SW", "RC_ARMSWITCH_TH")
MODE_SWITCHES = (  # of several that are on, the first counts when another is moved off
    Switch("return switch", "RC_MAP_RETURN_SW", "RC_RETURN_TH", ModeId.RTL),
    Switch("hold switch", "RC_MAP_LOITER_SW", "RC_LOITER_TH", ModeId.HOLD),
    Switch("offboard switch", "RC_MAP_OFFB_SW", "RC_OFFB_TH", ModeId.OFFBOARD),
)
MODE = Switch("mode switch", "RC_MAP_FLTMODE")


@dataclass(frozen=True, slots=True)
class SwitchOrder:
    """What a switch asks for: ARM, DISARM, CHANGE_MODE to `mode`, or COMMAND: its `function`, `on` or off. A mode may
    come with the function that chooses it."""

    action: RequestedAction
    mode: ModeId | None = None
    function: AuxFunction = AuxFunction.NOTHING
    on: bool = True


@dataclass(slots=True)
class _Position:
    """A position that counts once it has lasted for SETTLE_S. `number`: of its channel."""

    number: int = 0
    settled: int | None = None
    seen: int | None = None
    since_s: float = -math.inf

    def moved(self, seen: int, t_s: float) -> int | None:
        """The position before, where the settled one changes now; None otherwise, and when it settles first."""
        if seen != self.seen:
            self.seen, self.since_s = seen, t_s
        if seen == self.settled or t_s - self.since_s < SETTLE_S - 1e-9:
            return None
        before, self.settled = self.settled, seen
        return before


class Switches:
    """`update(rc, now_s)` once a tick → orders. `killed`: the kill switch is on; it stays so while the transmitter is
    silent. `channels`: how many the transmitter has; None while it is not heard.

    Remembers the position of each switch, when the transmitter was heard, and the faults of its mapping.
    """

    def __init__(self, parameters: Parameters, events: EventLog) -> None:
        self._parameters = parameters
        self._events = events
        self._positions: dict[str, _Position] = {}  # by the parameter of the channel
        self._faults: frozenset[str] = frozenset()
        self._heard_s = -math.inf
        self.killed = False
        self.channels: int | None = None
        parameters.after_change(self._look_up)
        self._look_up()

    def _look_up(self) -> None:
        self._can_kill = bool(kill_channels(self._parameters))

    def update(self, rc: RcInput | None, now_s: float) -> list[SwitchOrder]:
        """Read the transmitter, whose channels are calibrated."""
        if not self._can_kill:
            self.killed = False
        if rc is not None and not rc.lost and rc.t_s > self._heard_s:
            self._heard_s = rc.t_s
            self.channels = len(rc.channels)
            self._announce_faults(now_s)
            self._read_kill_switch(rc, now_s)
            return list(self._read(rc, now_s))
        if now_s - self._heard_s > self._parameters["COM_RC_LOSS_T"]:
            self._positions.clear()
            self.channels = None
        return []

    # --- the kill switch -------------------------------------------------------------------------------------------

    def _read_kill_switch(self, rc: RcInput, now_s: float) -> None:
        """Its position counts at once. Of several, one that is on is enough."""
        switches = (KILL, *(s for s in self._options() if s.function is AuxFunction.EMERGENCY_STOP))
        values = [(switch, self._value(switch, rc)) for switch in switches]
        known = [self._is_on(switch, value, self.killed) for switch, value in values if value is not None]
        if not known:
            return
        on = any(known)
        if on != self.killed:
            text = "Kill switch is on: thrusters stopped" if on else "Kill switch is off: the boat can be armed"
            self._events.say(now_s, TextKind.ALARM if on else TextKind.ROUTINE, "kill_switch", text)
        self.killed = on

    # --- the others ------------------------------------------------------------------------------------------------

    def _read(self, rc: RcInput, now_s: float) -> Iterator[SwitchOrder]:
        for switch in (ARM, *MODE_SWITCHES, *self._options()):
            value = self._value(switch, rc)
            if value is None or switch.function is AuxFunction.EMERGENCY_STOP:
                continue
            position = self._position(switch)
            first = position.settled is None
            before = position.moved(int(self._is_on(switch, value, bool(position.settled))), rc.t_s)
            if before is not None:
                yield from self._on_moved(switch, bool(position.settled), now_s)
            elif first and position.settled:
                text = f"{switch.name.capitalize()} is on: it acts when moved"
                self._events.say(now_s, TextKind.ATTENTION, "switch_on", text)
        yield from self._read_mode_switch(rc, now_s)

    def _on_moved(self, switch: Switch, on: bool, now_s: float) -> Iterator[SwitchOrder]:
        if switch.mode is None:
            yield from _acts(switch.function, on)
        elif on:
            yield SwitchOrder(RequestedAction.CHANGE_MODE, switch.mode, switch.function)
        elif (left := self._mode_left()) is not None:
            yield left
        else:
            text = f"{switch.name.capitalize()} is off: the mode stays"
            self._events.say(now_s, TextKind.ROUTINE, "switch_off", text)

    def _mode_left(self) -> SwitchOrder | None:
        """The mode of another switch that is on, else that of the mode switch."""
        for switch in (*MODE_SWITCHES, *self._options()):
            position = self._positions.get(switch.key)
            if switch.mode is not None and position is not None and position.settled:
                return SwitchOrder(RequestedAction.CHANGE_MODE, switch.mode, switch.function)
        position = self._positions.get(MODE.key)
        mode = None if position is None or position.settled is None else self._mode_at(position.settled)
        return None if mode is None else SwitchOrder(RequestedAction.CHANGE_MODE, mode)

    def _read_mode_switch(self, rc: RcInput, now_s: float) -> Iterator[SwitchOrder]:
        value = self._value(MODE, rc)
        if value is None:
            return
        position = self._position(MODE)
        first = position.settled is None
        before = position.moved(mode_position(value), rc.t_s)
        if position.settled is None or (before is None and not first):
            return
        mode = self._mode_at(position.settled)
        at = position.settled + 1
        place = f"Mode switch at {at}"
        if mode is None:
            text = f"{place}: COM_FLTMODE{at} names no mode"
            self._events.say(now_s, TextKind.ATTENTION, "mode_switch", text)
        elif first:
            self._events.say(now_s, TextKind.ROUTINE, "mode_switch", f"{place}, {mode.value}: it acts when moved")
        else:
            yield SwitchOrder(RequestedAction.CHANGE_MODE, mode)

    # --- parts -----------------------------------------------------------------------------------------------------

    def _mode_at(self, position: int) -> ModeId | None:
        return SWITCH_MODES.get(int(self._parameters[f"COM_FLTMODE{position + 1}"]))

    def _options(self) -> Iterator[Switch]:
        """The channels that have a function."""
        for name, number in OPTIONS.items():
            function = AuxFunction(int(self._parameters[name]))
            if function:
                yield Switch(f"switch {number}", name, mode=AUX_MODES.get(function), function=function)

    def _number(self, switch: Switch) -> int:
        """Its channel; 0 for none."""
        return OPTIONS[switch.channel] if switch.function else int(self._parameters[switch.channel])

    def _value(self, switch: Switch, rc: RcInput) -> float | None:
        """The value of a mapped channel, −1…1; None if it is not mapped, missing, or not a number. A switch that is
        mapped again is read again."""
        number = self._number(switch)
        position = self._positions.get(switch.key)
        if position is not None and position.number != number:
            del self._positions[switch.key]
        if not 1 <= number <= len(rc.channels) or not math.isfinite(rc.channels[number - 1]):
            return None
        return rc.channels[number - 1]

    def _position(self, switch: Switch) -> _Position:
        return self._positions.setdefault(switch.key, _Position(self._number(switch)))

    def _is_on(self, switch: Switch, value: float, was_on: bool) -> bool:
        """Above the threshold, or below a negative one: a share of the channel's travel."""
        threshold = self._parameters[switch.threshold] if switch.threshold else _OPTION_THRESHOLD
        share, slack = 0.5 + 0.5 * value, _HYSTERESIS if was_on else 0.0
        return share > threshold - slack if threshold >= 0.0 else share < -threshold + slack

    def _announce_faults(self, now_s: float) -> None:
        faults = frozenset(switch_faults(self._parameters, self.channels or 0))
        for text in sorted(faults - self._faults):
            self._events.say(now_s, TextKind.ATTENTION, "switch_fault", text)
        self._faults = faults


def _acts(function: AuxFunction, on: bool) -> Iterator[SwitchOrder]:
    """What a switch that chooses no mode asks for when it is moved."""
    if function in (AuxFunction.NOTHING, AuxFunction.ARM_DISARM):  # the arm switch has no function
        yield SwitchOrder(RequestedAction.ARM if on else RequestedAction.DISARM)
    elif function is not AuxFunction.DISARM:
        yield SwitchOrder(RequestedAction.COMMAND, function=function, on=on)
    elif on:
        yield SwitchOrder(RequestedAction.DISARM)


def mode_position(value: float) -> int:
    """The position of the mode switch, 0 to 5, for a channel of −1…1."""
    return min(POSITIONS - 1, max(0, int((value - _FIRST_POSITION) / _POSITION_WIDTH)))
