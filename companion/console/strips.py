"""What the strips show: series of numbers made from ticks, kept for ten minutes, for live pages and for logs alike."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

KEPT_S = 600.0
_PERIOD_S = 0.5  # between two samples that are kept
SENSES = ("position", "velocity", "heading")


@dataclass(frozen=True, slots=True)
class Series:
    """One line of a strip, with the unit of the page."""

    name: str
    strip: str
    unit: str


def series_of(thrusters: Sequence[str]) -> tuple[Series, ...]:
    """All series, in the order of a sample's values."""
    return (
        Series("position error", "Position error", "m"),
        Series("cross-track error", "Position error", "m"),
        Series("heading error", "Heading error", "°"),
        Series("surge", "Speed", "m/s"),
        Series("sway", "Speed", "m/s"),
        Series("surge asked", "Speed", "m/s"),
        *(Series(name, "Throttle", "%") for name in thrusters),
        Series("voltage", "Battery", "V"),
        Series("charge left", "Charge left", "%"),
        *(Series(sense, "Innovation, share of its gate", "") for sense in SENSES),
        Series("silent", "Devices and links that are silent; load", ""),
        Series("load", "Devices and links that are silent; load", ""),
        Series("wind", "Wind", "m/s"),
    )


def sample(message: Mapping[str, Any], thrusters: Sequence[str]) -> list[float | None]:
    """The values of `series_of` in one tick message."""
    row, more = message["row"], message.get("more") or {}
    battery = more.get("battery") or {}
    remaining = battery.get("remaining")
    judged = {one["sense"]: one for one in more.get("judged") or ()}
    health = more.get("health") or ()
    return [
        _position_error_m(row, bool(more.get("pose", True))),
        row.get("cross_track_error_m"),
        _heading_error_deg(row),
        row.get("surge_mps"),
        row.get("sway_mps"),
        row.get("desired_surge_mps"),
        *(_percent(row.get(f"{name}_throttle")) for name in thrusters),
        battery.get("voltage_v"),
        _percent(remaining),
        *(_share(judged.get(sense)) for sense in SENSES),
        float(sum(not one["ok"] for one in health)) if health else None,
        row.get("load"),
        more.get("wind_speed_mps"),
    ]


def _position_error_m(row: Mapping[str, Any], pose: bool) -> float | None:
    north, east = (_difference(row, name) for name in ("north_m", "east_m"))
    return None if north is None or east is None or not pose else math.hypot(north, east)


def _heading_error_deg(row: Mapping[str, Any]) -> float | None:
    yaw_rad = _difference(row, "yaw_rad")
    return None if yaw_rad is None else math.degrees(math.remainder(yaw_rad, math.tau))


def _difference(row: Mapping[str, Any], name: str) -> float | None:
    """What is less what is desired; None where one of them is missing."""
    value, desired = row.get(name), row.get(f"desired_{name}")
    return None if value is None or desired is None else value - desired


def _percent(share: float | None) -> float | None:
    return None if share is None else 100.0 * share


def _share(judged: Mapping[str, Any] | None) -> float | None:
    """The innovation as a share of the largest that its gate accepts; above 1 it was rejected."""
    if judged is None or judged["square"] is None or judged["age_s"] > 2.0:
        return None
    return math.sqrt(max(0.0, judged["square"]) / judged["limit"])


class History:
    """The samples of the last ten minutes, two a second, and the trail of the boat."""

    def __init__(self, thrusters: Sequence[str]) -> None:
        self._thrusters = tuple(thrusters)
        self._samples: deque[tuple[float, list[float | None], float, float]] = deque()

    def take(self, message: Mapping[str, Any]) -> list[float | None]:
        """Keep a tick's sample, where one is due; returns the sample."""
        t_s = message["row"]["t_s"]
        values = sample(message, self._thrusters)
        if self._samples and t_s < self._samples[-1][0]:  # the boat has begun anew
            self._samples.clear()
        if not self._samples or t_s - self._samples[-1][0] >= _PERIOD_S:
            self._samples.append((t_s, values, message["row"]["north_m"], message["row"]["east_m"]))
            while self._samples[0][0] < t_s - KEPT_S:
                self._samples.popleft()
        return values

    def message(self) -> dict[str, Any]:
        """All of it, for a page that has just been opened."""
        return {
            "kind": "history",
            "t_s": [one[0] for one in self._samples],
            "values": [one[1] for one in self._samples],
            "trail": [[one[2], one[3]] for one in self._samples],
        }
