"""Failsafes: one table, and the monitor that watches it. A new failsafe is one row.

A failsafe begins when its cause lasts and it applies to what the boat does. It acts once, at its onset. What an
operator asks for afterwards stands until the failsafe has ended and begins again. While a more severe one that acted
lasts (higher in the table), the others wait; they act when it ends, if they still last. With the action Neutral the
boat stays armed in its mode without thrust, and goes on afterwards. A boat that pushes against its berth stays there:
Hold and RTL leave it, Neutral ends the push.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from companion.core.decision import LossFailsafe, ModeId, TextKind
from companion.modes.table import DECLARATIONS
from companion.supervisor.situation import Situation

_BATTERY_HYSTERESIS = 0.03
_RESTED = 0.3  # by which the charge that is judged by voltage may rise at rest: that is no charge


class FailsafeAction(IntEnum):
    """The numbers are those of the failsafe parameters."""

    IGNORE = 0
    HOLD = 1
    RTL = 2
    NEUTRAL = 3
    MANUAL = 4  # of FOLL_LOSS_ACT alone


_SAME = {int(action): action for action in FailsafeAction}
_FENCE_ACTIONS = {
    0: FailsafeAction.IGNORE,
    1: FailsafeAction.IGNORE,
    2: FailsafeAction.HOLD,
    3: FailsafeAction.RTL,
}  # GF_ACTION counts as PX4 does


@dataclass(frozen=True, slots=True)
class Failsafe:
    """One row. `cause(situation, active)` and `applies(situation, active)`: `active` where the failsafe lasts already.
    `action`: what to do, or the parameter that says it, whose numbers are `actions`. `stays`: why the boat does not
    return to its mode by itself afterwards; None for a failsafe after which it never does. `in_the_way`: what the
    danger is lies on the way home too, where Hold stops the boat."""

    name: str
    kind: TextKind
    cause: Callable[[Situation, bool], bool]
    applies: Callable[[Situation, bool], bool]
    action: str | FailsafeAction
    starts: Callable[[Situation], str]
    ends: str
    actions: Mapping[int, FailsafeAction] = field(default_factory=lambda: _SAME)
    stays: Callable[[Situation], str | None] | None = None
    in_the_way: bool = False


def _silent_bridges(s: Situation) -> list[str]:
    return [bridge.name for bridge in s.bridges.values() if not bridge.ok]


def _battery_below(name: str) -> Callable[[Situation, bool], bool]:
    def below(s: Situation, active: bool) -> bool:
        battery = s.inputs.battery
        if battery is None or battery.remaining is None:
            return active
        slack = _RESTED if s.armed else _BATTERY_HYSTERESIS
        return battery.remaining < s.parameters[name] + (slack if active else 0.0)

    return below


def _battery_text(s: Situation) -> str:
    battery = s.inputs.battery
    return "" if battery is None or battery.remaining is None else f"{100.0 * battery.remaining:.0f} % left"


def _armed(s: Situation, _active: bool) -> bool:
    return s.armed


def _always(_s: Situation, _active: bool) -> bool:
    return True


def _self_steered(s: Situation, _active: bool) -> bool:
    return s.armed and not s.mode.by_stick and not s.rests


def _by_stick(s: Situation, active: bool) -> bool:
    return s.armed and (s.mode.by_stick or (active and s.intended.by_stick))


def _by_safe_switch(s: Situation, active: bool) -> bool:
    return s.authority.safe_switch and _by_stick(s, active)


def _by_other_sticks(s: Situation, active: bool) -> bool:
    return not s.authority.safe_switch and _by_stick(s, active)


def _sticks_silent(s: Situation, _active: bool) -> bool:
    return s.sticks_age_s is not None and s.sticks_age_s > s.parameters["COM_RC_LOSS_T"]


def _ground_stations_silent(s: Situation, _active: bool) -> bool:
    return s.ground_station_age_s is not None and s.ground_station_age_s > s.parameters["COM_DL_LOSS_T"]


def _stuck(s: Situation, active: bool) -> bool:
    """A mode that is no longer under way has not ended the failsafe: only headway does."""
    stuck_s = s.mode.stuck_s(s.now_s)
    return active if stuck_s is None else stuck_s >= s.parameters["WP_STUCK_T"]


def _under_way(s: Situation, _active: bool) -> bool:
    return s.armed and s.mode.stuck_s(s.now_s) is not None


def _row_of(mode: ModeId, declared: LossFailsafe) -> Failsafe:
    """The failsafe that a mode declares for the loss of what it steers by."""

    def lost(s: Situation, active: bool) -> bool:
        """Once lost, the source must have been good for a while."""
        source, back_after = s.sources[mode], declared.back_after
        waits = active and back_after is not None and source.good_s < s.parameters[back_after]
        return source.fault is not None or waits

    def applies(s: Situation, active: bool) -> bool:
        """The boat is in the mode, or would be without the failsafe."""
        return s.armed and (s.mode.id is mode or (active and s.intended.id is mode))

    def starts(s: Situation) -> str:
        text = declared.prefix + (s.sources[mode].fault or f"{mode.value} lost")
        return text[0].upper() + text[1:]

    return Failsafe(
        declared.name,
        declared.kind,
        lost,
        applies,
        declared.action,
        starts,
        declared.ends,
        stays=None if declared.back_after is None else lambda s: s.sources[mode].stays,
    )


FAILSAFES: tuple[Failsafe, ...] = (  # most severe first
    Failsafe(
        "capsized",
        TextKind.ALARM,
        lambda s, _: s.tilt_rad is not None,
        _armed,
        FailsafeAction.NEUTRAL,
        lambda s: f"Capsized, {math.degrees(s.tilt_rad or 0.0):.0f} deg from upright",
        "Upright again",
    ),
    Failsafe(
        "bridge_silent",
        TextKind.ALARM,
        lambda s, _: bool(_silent_bridges(s)),
        _armed,
        "FS_ACT_ACT",
        lambda s: f"Thruster bridge silent: {', '.join(_silent_bridges(s))}",
        "Thruster bridges answer again",
    ),
    Failsafe(
        "thrust_lost",
        TextKind.ALARM,
        lambda s, _: bool(s.lost_motions),
        _armed,
        "FS_ACT_ACT",
        lambda s: f"Thrusters failed: no {' and no '.join(s.lost_motions)} left",
        "Thrusters are enough again",
    ),
    Failsafe(
        "one_sided_thrust",  # by sticks, a person may still use the thruster that is left
        TextKind.ALARM,
        lambda s, _: not s.keeps_straight,
        _self_steered,
        "FS_ACT_ACT",
        lambda _: "Thrusters failed: no straight course left",
        "Thrusters keep a straight course again",
    ),
    Failsafe(
        "ticks_late",
        TextKind.ALARM,
        lambda s, _: s.ticks_late,
        _armed,
        "FS_TICK_ACT",
        lambda s: f"Computer too slow: ticks {s.worst_late_s:.2g} s late",
        "Computer keeps up again",
    ),
    Failsafe(
        "position_lost",
        TextKind.ALARM,
        lambda s, _: not s.nav.position_valid,
        lambda s, _: s.armed and s.mode.needs_position,
        "FS_POS_ACT",
        lambda _: "Position lost",
        "Position is back",
    ),
    Failsafe(
        "heading_lost",
        TextKind.ALARM,
        lambda s, _: not s.nav.heading_valid,
        lambda s, _: s.armed and s.mode.needs_heading,
        "FS_POS_ACT",
        lambda _: "Heading lost",
        "Heading is back",
    ),
    Failsafe(
        "leak",
        TextKind.ALARM,
        lambda s, active: s.inputs.leak.wet if s.inputs.leak is not None else active,
        _always,
        "FS_LEAK_ACT",
        lambda _: "Water in the hull",
        "Leak sensor is dry again",
    ),
    Failsafe(
        "battery_critical",
        TextKind.ALARM,
        _battery_below("BAT_CRIT_THR"),
        _always,
        "COM_LOW_BAT_ACT",
        lambda s: f"Battery critical, {_battery_text(s)}",
        "Battery no longer critical",
    ),
    Failsafe(
        "battery_return",
        TextKind.ALARM,
        lambda s, _: s.range_short,
        _self_steered,
        "BAT_RET_ACT",
        lambda s: f"Return now: {_battery_text(s)}, home takes {100.0 * (s.home_share or 0.0):.0f} %",
        "Battery is enough for the way home",
    ),
    Failsafe(
        "battery_low",
        TextKind.ATTENTION,
        _battery_below("BAT_LOW_THR"),
        _always,
        FailsafeAction.IGNORE,
        lambda s: f"Battery low, {_battery_text(s)}",
        "Battery no longer low",
    ),
    Failsafe(
        "shallow",
        TextKind.ALARM,
        lambda s, _: s.depth_m is not None,
        _self_steered,
        "FS_DEPTH_ACT",
        lambda s: f"Shallow: {s.depth_m or 0.0:.1f} m of water",
        "Deep enough again",
        in_the_way=True,
    ),
    Failsafe(
        "ranges_lost",
        TextKind.ALARM,
        lambda s, _: bool(s.silent_ranges),
        _self_steered,
        "FS_RANGE_ACT",
        lambda s: f"No ranges from {', '.join(s.silent_ranges)}"[:50],
        "Ranges are back",
    ),
    Failsafe(
        "aground_or_fouled",
        TextKind.ALARM,
        lambda s, _: s.aground_or_fouled,
        _self_steered,
        "FS_WAY_ACT",
        lambda _: "Aground or propeller fouled: thrust makes no way",
        "Thrust makes way again",
    ),
    Failsafe(
        "fence",
        TextKind.ALARM,
        lambda s, _: s.fence is not None,
        _armed,
        "GF_ACTION",
        lambda s: s.fence or "",
        "Inside the fence and clear of it",
        _FENCE_ACTIONS,
    ),
    Failsafe(
        "transmitter_lost",  # by its safe switch a person has taken the boat in hand: it must not sail off by itself
        TextKind.ALARM,
        _sticks_silent,
        _by_safe_switch,
        FailsafeAction.NEUTRAL,
        lambda _: "Transmitter silent with its safe switch on",
        "Transmitter is back",
    ),
    Failsafe(
        "station_lost",  # above sticks_lost: the boat that holds for want of sticks still does this
        TextKind.ALARM,
        _ground_stations_silent,
        _self_steered,
        "NAV_DLL_ACT",
        lambda s: f"No ground station for {s.parameters['COM_DL_LOSS_T']:.0f} s",
        "Ground station is back",
    ),
    Failsafe(
        "sticks_lost",
        TextKind.ALARM,
        _sticks_silent,
        _by_other_sticks,
        "NAV_RCL_ACT",
        lambda _: "Sticks silent",
        "Sticks are back",
    ),
    *(_row_of(mode, declared.failsafe) for mode, declared in DECLARATIONS.items() if declared.failsafe is not None),
    Failsafe(
        "stuck",
        TextKind.ATTENTION,
        _stuck,
        _under_way,
        "WP_STUCK_ACT",
        lambda s: f"No headway for {s.parameters['WP_STUCK_T']:.0f} s",
        "Making headway",
    ),
)


@dataclass(slots=True)
class Active:
    """A failsafe that lasts. `acted`: it has had its turn. `released`: an operator has taken over since. `neutral`: it
    keeps the thrusters in neutral."""

    failsafe: Failsafe
    action: FailsafeAction
    acted: bool = False
    released: bool = False
    neutral: bool = False


@dataclass(frozen=True, slots=True)
class Changes:
    """What changed in a tick: failsafes that began, those that ended (and whether the cause ended, not just the mode),
    and the one that must act now."""

    begun: tuple[Active, ...]
    over: tuple[tuple[Failsafe, bool], ...]
    demand: Active | None


class FailsafeMonitor:
    """`update(situation)` once a tick → Changes. Remembers which failsafes last and which have acted."""

    def __init__(self, table: tuple[Failsafe, ...] = FAILSAFES) -> None:
        self._table = table
        self._active: dict[str, Active] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Those that last, most severe first."""
        return tuple(row.name for row in self._table if row.name in self._active)

    @property
    def neutral(self) -> bool:
        """Whether one of them keeps the thrusters in neutral."""
        return any(active.neutral for active in self._active.values())

    def update(self, situation: Situation) -> Changes:
        """Judge every failsafe in this situation; returns those that begin and those that are over."""
        begun: list[Active] = []
        over: list[tuple[Failsafe, bool]] = []
        for row in self._table:
            was = row.name in self._active
            cause = row.cause(situation, was)
            lasts = cause and row.applies(situation, was)
            if lasts and not was:
                action = (
                    row.action
                    if isinstance(row.action, FailsafeAction)
                    else row.actions[int(situation.parameters[row.action])]
                )
                active = Active(row, action, released=not situation.armed)
                self._active[row.name] = active
                begun.append(active)
            elif was and not lasts:
                del self._active[row.name]
                over.append((row, not cause))
        return Changes(tuple(begun), tuple(over), self._demand())

    def _demand(self) -> Active | None:
        """The most severe one with an action that was not released; None if it has acted already."""
        if not self._active:
            return None
        for row in self._table:
            active = self._active.get(row.name)
            if active is not None and active.action is not FailsafeAction.IGNORE and not active.released:
                return None if active.acted else active
        return None

    @property
    def in_force(self) -> bool:
        """Whether one of them has acted and no operator has taken over since."""
        return any(active.acted and not active.released for active in self._active.values())

    def arming(self, situation: Situation) -> None:
        """The boat is being armed: what lasts has had its turn. What would not begin now, and lasts by its hysteresis
        alone, begins anew: a battery that passed the check is critical once it falls again."""
        lasting = {name: active for name, active in self._active.items() if active.failsafe.cause(situation, False)}
        self._active = lasting
        self.override()

    def override(self) -> None:
        """An operator has taken over: the failsafes that last have had their turn, and release the thrusters. Those
        after which the boat would return are ended: they begin anew."""
        self._active = {name: active for name, active in self._active.items() if active.failsafe.stays is None}
        for active in self._active.values():
            active.released = True
            active.neutral = False
