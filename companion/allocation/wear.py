"""What wears the thrusters: hours of thrust, starts, reversals and turns of the azimuth, counted by their commands."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from companion.core.actuation import ActuatorCommand, ThrusterCommand

_PUSHES = 0.02  # of full throttle: less is no thrust


@dataclass(frozen=True, slots=True)
class Wear:
    """Of one thruster, since it was first counted. `starts`: from rest; `reversals`: from ahead to astern or back, with
    or without a rest between; `azimuth_turns`: whole turns that the azimuth has travelled, to and fro."""

    thrust_s: float = 0.0
    starts: int = 0
    reversals: int = 0
    azimuth_turns: float = 0.0


class WearCount:
    """`update` every tick. Remembers each thruster's wear and what it last did."""

    def __init__(self, names: Sequence[str], kept: Mapping[str, Wear]) -> None:
        """`kept`: the wear so far, by name; one that is missing begins at zero."""
        self._names = tuple(names)
        self._wear = [kept.get(name, Wear()) for name in names]
        self._last: list[tuple[ThrusterCommand, int] | None] = [None] * len(names)
        self._sides = [0] * len(names)  # to which each last pushed: 1 ahead, −1 astern

    @property
    def by_name(self) -> dict[str, Wear]:
        """The wear of every thruster."""
        return dict(zip(self._names, self._wear, strict=True))

    def update(self, command: ActuatorCommand, dt_s: float) -> None:
        """One tick, `dt_s` after the last. What is disarmed stands still."""
        for i, thruster in enumerate(command.thrusters):
            side = _side(thruster) if command.armed else 0
            self._wear[i] = self._worn(i, thruster, side, dt_s)
            self._last[i] = (thruster, side)
            self._sides[i] = side or self._sides[i]

    def _worn(self, i: int, now: ThrusterCommand, side: int, dt_s: float) -> Wear:
        wear, last = self._wear[i], self._last[i]
        before, side_before = (now, 0) if last is None else last
        turned_rad = 0.0
        if now.azimuth_rad is not None and before.azimuth_rad is not None:
            turned_rad = abs(math.remainder(now.azimuth_rad - before.azimuth_rad, math.tau))
        if side == 0 and turned_rad == 0.0:
            return wear
        return replace(
            wear,
            thrust_s=wear.thrust_s + (dt_s if side != 0 else 0.0),
            starts=wear.starts + (side != 0 and side_before == 0),
            reversals=wear.reversals + (side != 0 and side == -self._sides[i]),
            azimuth_turns=wear.azimuth_turns + turned_rad / math.tau,
        )


def _side(thruster: ThrusterCommand) -> int:
    if abs(thruster.throttle) < _PUSHES:
        return 0
    return 1 if thruster.throttle > 0.0 else -1
