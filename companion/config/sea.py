"""A sea state as settings name it: `HS[@FROM_DEG][/TP_S]`."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.angles import wrap_two_pi

_GRAVITY_MPS2 = 9.81
_PERIOD_PER_ROOT = 4.2  # peak period of a wind sea over the root of its height, in s/√m: one in 28 is its steepness
_MOST_M, _SHORTEST_S, _LONGEST_S = 10.0, 0.3, 25.0
_STEEPEST = 1.0 / 7.0  # height over length at which a wave breaks (Michell 1893)
_FORM = "write HS[@FROM_DEG][/TP_S], as 0.2, 0.2@45 or 0.2@45/2.5"


@dataclass(frozen=True, slots=True)
class SeaState:
    """Significant height, the direction that the waves come from (None: that of the wind), period of the spectrum's
    peak."""

    height_m: float
    from_rad: float | None
    peak_s: float


def parse_waves(text: str) -> SeaState | None:
    """`0.2@45/2.5` → 0.2 m from 45° with a peak period of 2.5 s. None for flat water: no text, or a height of 0.

    Without a period it is that of a young wind sea, 4.2 √HS s. Raises ValueError that says what is wrong.
    """
    if not text.strip():
        return None
    rest, slash, period = text.partition("/")
    height, at, direction = rest.partition("@")
    try:
        height_m = float(height)
        from_deg = float(direction) if at else None
        peak_s = float(period) if slash else _PERIOD_PER_ROOT * math.sqrt(max(height_m, 0.0))
    except ValueError as error:
        raise ValueError(f"waves '{text}': {_FORM}") from error
    _check(text, height_m, from_deg, peak_s if slash else None)
    if height_m == 0.0:
        return None
    return SeaState(height_m, None if from_deg is None else wrap_two_pi(math.radians(from_deg)), peak_s)


def checked_waves(text: str) -> str:
    """The text, for a key of a file. Raises ValueError as `parse_waves`."""
    parse_waves(text)
    return text


def _check(text: str, height_m: float, from_deg: float | None, peak_s: float | None) -> None:
    """Raise ValueError for what no sea has. `peak_s` None: not given."""
    if not 0.0 <= height_m <= _MOST_M:
        raise ValueError(f"waves '{text}': the height must be 0 to {_MOST_M:g} m; {_FORM}")
    if from_deg is not None and not abs(from_deg) <= 720.0:
        raise ValueError(f"waves '{text}': the direction must be in degrees; {_FORM}")
    if peak_s is None:
        return
    if not _SHORTEST_S <= peak_s <= _LONGEST_S:
        raise ValueError(f"waves '{text}': the period must be {_SHORTEST_S:g} to {_LONGEST_S:g} s; {_FORM}")
    length_m = _GRAVITY_MPS2 * peak_s * peak_s / math.tau
    if height_m > _STEEPEST * length_m:
        least_s = math.sqrt(height_m / _STEEPEST * math.tau / _GRAVITY_MPS2)
        raise ValueError(f"waves '{text}': so steep they break; {height_m:g} m needs a period above {least_s:.2g} s")
