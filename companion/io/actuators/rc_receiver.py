"""An RC receiver's pulses, whatever bridge carries them."""

from __future__ import annotations

from collections.abc import Sequence

_CENTRE_US = 1500
_HALF_RANGE_US = 500.0


def channels(pulses_us: Sequence[int]) -> tuple[float, ...]:
    """Pulse widths in µs → −1…1 (1000…2000 µs), up to the first channel that is missing (0)."""
    found: list[float] = []
    for pulse_us in pulses_us:
        if pulse_us == 0:
            break
        found.append(min(max((pulse_us - _CENTRE_US) / _HALF_RANGE_US, -1.0), 1.0))
    return tuple(found)
