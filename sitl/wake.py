"""The wake of a boat under way: calm water straight astern, a crest on either side."""

from __future__ import annotations

import math
from collections import deque

CALM_HALF_M = 4.0  # half width of the calm water astern (8 m wide at 20 m in the RescueRunner thesis)
_LENGTH_M = 150.0
_STEP_M = 2.0
_EDGE_M = 1.0  # width in which the first crest rises
_ACROSS_M = 5.0  # e-folding outside the crest
_ALONG_M = 60.0  # e-folding astern
_WAVE_M = 7.0
_HEIGHT_M = 0.25  # amplitude at _FULL_MPS, just astern
_FULL_MPS = 8.0
_GRADIENT_M = 0.25  # half width of the differences that give the slope


class Wake:
    """Call `leave` as the boat moves, then `elevation_m` and `slope` anywhere. Remembers the last 150 m of its track.

    Amplitude A = 0.25 m (U/8)², at most 0.25 m, with an e-folding of 60 m astern. Across: 0 within 4 m, then A
    e^(−(|y|−4)/5) sin 2π(|y|−4)/7. The amplitude is an estimate; its purpose is a border that a follower feels.
    """

    def __init__(self) -> None:
        self._trail: deque[tuple[float, float, float, float, float]] = deque(
            maxlen=int(_LENGTH_M / _STEP_M) + 1
        )  # north, east, cos, sin, U
        self._here = (0.0, 0.0, 1.0, 0.0, 0.0)
        self._since_m = 0.0

    def leave(self, north_m: float, east_m: float, north_mps: float, east_mps: float, dt_s: float) -> None:
        """The boat is here now, and has moved with this velocity for `dt_s`."""
        speed = math.hypot(north_mps, east_mps)
        if speed < 0.5:
            self._here = (north_m, east_m, self._here[2], self._here[3], speed)
            return
        self._here = (north_m, east_m, north_mps / speed, east_mps / speed, speed)
        self._since_m += speed * dt_s
        if self._since_m >= _STEP_M:
            self._since_m = 0.0
            self._trail.append(self._here)

    def across_m(self, north_m: float, east_m: float) -> tuple[float, float, float] | None:
        """(offset to starboard of the track, distance astern along it, the boat's speed there); None where it has not
        passed."""
        return self._from(self._nearest(north_m, east_m), north_m, east_m)

    def elevation_m(self, north_m: float, east_m: float) -> float:
        """Height of the surface at a place."""
        return self._elevation_m(self._nearest(north_m, east_m), north_m, east_m)

    def slope(self, north_m: float, east_m: float) -> tuple[float, float]:
        """Slope of the surface at a place, (towards north, towards east)."""
        h, at = _GRADIENT_M, self._nearest(north_m, east_m)
        return (
            0.5 / h * (self._elevation_m(at, north_m + h, east_m) - self._elevation_m(at, north_m - h, east_m)),
            0.5 / h * (self._elevation_m(at, north_m, east_m + h) - self._elevation_m(at, north_m, east_m - h)),
        )

    def _nearest(self, north_m: float, east_m: float) -> int:
        """Index of the nearest place on the track; −1 while there is none."""
        best, at = math.inf, -1
        for i, (north, east, _, _, _) in enumerate(self._trail):
            d = (north - north_m) ** 2 + (east - east_m) ** 2
            if d < best:
                best, at = d, i
        return at

    def _from(self, at: int, north_m: float, east_m: float) -> tuple[float, float, float] | None:
        if at < 0:
            return None
        north, east, c, s, speed = self._trail[at]
        dn, de = north_m - north, east_m - east
        along = dn * c + de * s
        astern = (len(self._trail) - 1 - at) * _STEP_M + self._since_m - along
        if astern < 0.0 or abs(along) > 2.0 * _STEP_M:
            return None
        return de * c - dn * s, astern, speed

    def _elevation_m(self, at: int, north_m: float, east_m: float) -> float:
        place = self._from(at, north_m, east_m)
        if place is None:
            return 0.0
        offset, astern, speed = place
        beyond = abs(offset) - CALM_HALF_M
        if beyond <= 0.0:
            return 0.0
        amplitude = _HEIGHT_M * min(1.0, speed / _FULL_MPS) ** 2 * math.exp(-astern / _ALONG_M - beyond / _ACROSS_M)
        return amplitude * min(1.0, beyond / _EDGE_M) * math.sin(math.tau * beyond / _WAVE_M)

    def reaches(self, north_m: float, east_m: float) -> bool:
        """Whether the wake can be felt at a place."""
        return bool(self._trail) and math.hypot(self._here[0] - north_m, self._here[1] - east_m) < _LENGTH_M
