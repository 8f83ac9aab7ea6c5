"""An RC receiver's pulses, whatever bridge carries them."""

from __future__ import annotations

from collections.abc import Sequence

_CENTRE_US = 1500
_HALF_RANGE_US = 500.0
_FURTHEST = 1.4  # 800 and 2200 µs: transmitters reach beyond 1000 and 2000 µs, and are calibrated for it


def channels(pulses_us: Sequence[int]) -> tuple[float, ...]:
    """Pulse widths in µs → −1 at 1000 µs, 1 at 2000 µs, at most 1.4 either way; up to the first channel that is missing
    (0)."""
    found: list[float] = []
    for pulse_us in pulses_us:
        if pulse_us == 0:
            break
        found.append(min(max((pulse_us - _CENTRE_US) / _HALF_RANGE_US, -_FURTHEST), _FURTHEST))
    return tuple(found)
