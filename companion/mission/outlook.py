"""What a person should know of a mission before it is sailed: a long first leg, a battery that does not last."""

from __future__ import annotations

from companion.mission.plan import item_number
from companion.mission.summary import Leg

_S_PER_MIN = 60.0
_LONG_H = 100.0


def length_text(length_m: float, time_s: float) -> str:
    """Length and duration of a mission."""
    return f"Mission: {distance(length_m)}, {duration(time_s)}"


def battery_warning(length_m: float, time_s: float, lasts_s: float | None) -> str | None:
    """The warning of a mission that takes longer than the battery lasts; None if it lasts, or if that is not known."""
    if lasts_s is None or time_s <= lasts_s:
        return None
    return f"{length_text(length_m, time_s)}; battery lasts {duration(lasts_s)}"


def first_leg_warning(leg: Leg | None, most_m: float) -> str | None:
    """The warning of a way to the first place that is longer than `most_m` (0: never)."""
    if leg is None or leg.length_m is None or not 0.0 < most_m < leg.length_m:
        return None
    way = f"{distance(leg.length_m)} away, {duration(leg.sailing_s)}"
    return f"Item {item_number(leg.seq)} is {way} (MIS_DIST_1WP)"


def battery_lasts_s(full_s: float | None, remaining: float | None, reserve: float) -> float | None:
    """How long the battery lasts, s, until the share `reserve` is left; None if not known. `full_s`: the full battery;
    `remaining` None: taken as full."""
    if full_s is None:
        return None
    return full_s * max(0.0, (1.0 if remaining is None else remaining) - reserve)


def full_battery_s(endurance_min: float, measured_s: float | None = None) -> float | None:
    """How long the full battery lasts, s: as BAT_ENDURANCE says, or as measured where that is 0; None if not known."""
    return endurance_min * _S_PER_MIN if endurance_min > 0.0 else measured_s


def distance(length_m: float) -> str:
    """A distance for people."""
    if length_m < 1000.0:
        return f"{length_m:.0f} m"
    return f"{length_m / 1000.0:.{1 if length_m < 100_000.0 else 0}f} km"


def duration(time_s: float) -> str:
    """A duration for people: minutes, or hours and minutes."""
    minutes = round(time_s / _S_PER_MIN)
    if minutes < 60:
        return f"{minutes} min"
    return f"{minutes // 60}:{minutes % 60:02d} h" if minutes < _LONG_H * 60 else f"{minutes / 60:.0f} h"
