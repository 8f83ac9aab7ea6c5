"""When thrusters turn away from where they will be needed, while they give little of the demand.

The solver looks one cycle ahead. Two thrusters across the hull that are to push astern and to turn the boat a little
give the moment at once: they stay across for it, on the side from which they cannot push astern. The way to where they
can leads through azimuths that give neither, so the solver does not take it; and a moment that changes sides in waves
sends them to and fro.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.allocation.geometry import Thruster

_LONG_S = 0.3  # turning away from its aim: some cycles of a wave are not yet a fault
_OFF_RAD = 0.35  # from its aim: nearer, the solver finds the way
_PACE = 0.5  # of its rate: a thruster that turns to its aim so fast is on its way
_ASKED_SHARE = 0.02  # of full force: a thruster that is asked for less has no aim


class Astray:
    """`update` every cycle. Remembers how long thrusters have turned away from their aims, how far off they were and
    whether they are being turned there."""

    def __init__(self, thrusters: Sequence[Thruster]) -> None:
        self._thrusters = tuple(thrusters)
        self.reset()

    def reset(self) -> None:
        """Nothing is astray."""
        self._away_s = 0.0
        self._off_rad: list[float] = [0.0] * len(self._thrusters)
        self._turning = False

    def update(
        self, shares: Sequence[float], aims_rad: Sequence[float], azimuths_rad: Sequence[float], dt_s: float
    ) -> bool:
        """Whether the thrusters are to turn to their aims now. Call it while much of the demand is missing, with each
        thruster's share of full force, azimuth in the unconstrained solution and azimuth; otherwise `reset`."""
        off_rad = [
            abs(aim - azimuth) if t.turns and share > _ASKED_SHARE else 0.0
            for t, share, aim, azimuth in zip(self._thrusters, shares, aims_rad, azimuths_rad, strict=True)
        ]
        far = [i for i, off in enumerate(off_rad) if off > _OFF_RAD]
        slow = [i for i in far if self._off_rad[i] - off_rad[i] < _PACE * self._thrusters[i].azimuth_rate_radps * dt_s]
        self._off_rad = off_rad
        if slow:
            self._away_s += dt_s
        self._turning = bool(far) and (self._turning or self._away_s > _LONG_S)
        return self._turning
