"""The transmitter's channels as its calibration gives them: RCn_MIN, TRIM, MAX, REV and DZ, with PX4's meaning."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.core.readings import RcInput
from companion.params.store import Parameters
from companion.params.transmitter import CALIBRATED

_CENTRE_US, _HALF_RANGE_US = 1500.0, 500.0
_PARTS = ("MIN", "TRIM", "MAX", "REV", "DZ")
_NAMES = tuple(tuple(f"RC{n}_{part}" for part in _PARTS) for n in range(1, CALIBRATED + 1))


def calibrated(rc: RcInput | None, parameters: Parameters) -> RcInput | None:
    """The same reading with calibrated channels, each −1…1. Channels beyond the eighth stay as they are."""
    if rc is None:
        return None
    known = (_calibrated(value, names, parameters) for value, names in zip(rc.channels, _NAMES, strict=False))
    return replace(rc, channels=(*known, *rc.channels[CALIBRATED:]))


def _calibrated(value: float, names: tuple[str, ...], parameters: Parameters) -> float:
    """0 within the dead zone around the trim, ±1 at the ends. A side without travel gives 0: with the trim at the low
    end the stick gives ahead only."""
    if not math.isfinite(value):
        return value
    low_us, trim_us, high_us, direction, dead_us = (parameters[name] for name in names)
    off_us = _CENTRE_US + _HALF_RANGE_US * value - trim_us
    travel_us = (high_us - trim_us if off_us > 0.0 else trim_us - low_us) - dead_us
    beyond_us = abs(off_us) - dead_us
    if beyond_us <= 0.0 or travel_us <= 0.0:
        return 0.0
    share = direction * min(1.0, beyond_us / travel_us)
    return share if off_us > 0.0 else -share
