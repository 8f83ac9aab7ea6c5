"""The motors beside a sail: a force ahead, shared by what each can give."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.thrust_curve import ThrustCurve
from companion.config.devices import ThrusterConfig
from companion.core.actuation import ThrusterCommand


class SailMotors:
    """`push`, `direct` or `stop`, then `commands`. Remembers the thrust of each in N, and which have failed."""

    def __init__(self, motors: Sequence[ThrusterConfig]) -> None:
        self._rates_nps = [motor.force_rate_nps for motor in motors]
        self._curves = [ThrustCurve(motor) for motor in motors]
        self._thrusts_n = [0.0] * len(motors)
        self._failed = [False] * len(motors)

    @property
    def thrust_n(self) -> float:
        """Of all together."""
        return sum(self._thrusts_n)

    def set_failed(self, index: int, failed: bool) -> None:
        """Mark a motor as failed or not. A failed one gives no thrust."""
        self._failed[index] = failed

    def push(self, force_n: float, dt_s: float) -> None:
        """Move towards that force ahead; motors do not push astern."""
        most_n = sum(curve.max_n for curve, failed in zip(self._curves, self._failed, strict=True) if not failed)
        share = min(1.0, max(0.0, force_n) / most_n) if most_n > 0.0 else 0.0
        for i, curve in enumerate(self._curves):
            self._move(i, share * curve.max_n, dt_s)

    def direct(self, commands: Sequence[ThrusterCommand], dt_s: float) -> None:
        """Move towards the throttle of each; one that is not finite counts as 0."""
        for i, curve in enumerate(self._curves):
            throttle = commands[i].throttle if i < len(commands) else 0.0
            held = min(1.0, max(-1.0, throttle)) if math.isfinite(throttle) else 0.0
            self._move(i, curve.force_n(held), dt_s)

    def stop(self) -> None:
        """No thrust."""
        self._thrusts_n = [0.0] * len(self._curves)

    def commands(self) -> tuple[ThrusterCommand, ...]:
        """A demand for each."""
        return tuple(
            ThrusterCommand(thrust_n, curve.throttle(thrust_n), None)
            for curve, thrust_n in zip(self._curves, self._thrusts_n, strict=True)
        )

    def _move(self, index: int, wanted_n: float, dt_s: float) -> None:
        reach, now_n = self._rates_nps[index] * max(0.0, dt_s), self._thrusts_n[index]
        moved_n = min(now_n + reach, max(now_n - reach, wanted_n))
        self._thrusts_n[index] = 0.0 if self._failed[index] else moved_n
