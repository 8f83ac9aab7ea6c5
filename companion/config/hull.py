"""The controller's model of the hull, as a vessel's file gives it."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import pairwise

from companion.config.fields import STRICT, NonNegative, Positive


@dataclass(frozen=True, slots=True)
class DampingConfig:
    """Hydrodynamic damping in Fossen's derivatives, positive where it resists: X = −(x_u u + x_uu |u|u + x_uuu u³) and so on.

    Y = −(y_v v + y_vv |v|v + y_rv |r|v + y_r r + y_vr |v|r + y_rr |r|r), N likewise with n_. What grows with way ahead: Y −= y_uv |u|v,
    N −= n_uv |u|v + n_ur |u|r.
    """

    __pydantic_config__ = STRICT
    x_u: float = 0.0
    x_uu: float = 0.0
    x_uuu: float = 0.0
    y_v: float = 0.0
    y_vv: float = 0.0
    y_rv: float = 0.0
    y_r: float = 0.0
    y_vr: float = 0.0
    y_rr: float = 0.0
    n_v: float = 0.0
    n_vv: float = 0.0
    n_rv: float = 0.0
    n_r: float = 0.0
    n_vr: float = 0.0
    n_rr: float = 0.0
    y_uv: float = 0.0
    n_uv: float = 0.0
    n_ur: float = 0.0


@dataclass(frozen=True, slots=True)
class HullConfig:
    """Inertia with added mass, and damping: M = [[m11, 0, 0], [0, m22, m23], [0, m32, m33]].

    `resistance`: for hulls that plane, resistance ahead as (speed_mps, force_n) in rising order from (0, 0), linear in between and on from the last
    two; it comes on top of the damping's x_ terms.
    """

    __pydantic_config__ = STRICT
    m11_kg: Positive
    m22_kg: Positive
    m33_kgm2: Positive
    m23_kgm: float = 0.0
    m32_kgm: float | None = None  # None: as m23
    damping: DampingConfig = field(default_factory=DampingConfig)
    resistance: tuple[tuple[float, float], ...] = ()

    def drag_n(self, surge_mps: float) -> float:
        """What the water takes of the surge force at that speed."""
        d, speed = self.damping, abs(surge_mps)
        force_n = (d.x_u + d.x_uu * speed + d.x_uuu * surge_mps * surge_mps) * surge_mps
        if self.resistance:
            return force_n + math.copysign(self._tabled(speed)[0], surge_mps)
        return force_n

    def drag_slope(self, surge_mps: float) -> float:
        """Its change with speed, in N/(m/s)."""
        d, speed = self.damping, abs(surge_mps)
        slope = d.x_u + 2.0 * d.x_uu * speed + 3.0 * d.x_uuu * surge_mps * surge_mps
        return slope + self._tabled(speed)[1] if self.resistance else slope

    def _tabled(self, speed_mps: float) -> tuple[float, float]:
        """(force, slope) of the table."""
        points = self.resistance
        i = min(len(points) - 2, max(0, bisect_right(points, (speed_mps, math.inf)) - 1))
        (low, at_low), (high, at_high) = points[i], points[i + 1]
        slope = (at_high - at_low) / (high - low)
        return at_low + slope * (speed_mps - low), slope


@dataclass(frozen=True, slots=True)
class WindageConfig:
    """Wind areas and coefficients (Fossen 2011, 8.1.3), with (ax, ay) the velocity of the air relative to the boat in body axes:

    X = ½ρ cx A_F V ax, Y = ½ρ cy A_L V ay, N = −ρ cn A_L L ax ay (½ρ cn A_L L V² sin 2γ: the bow turns away from the wind).
    """

    __pydantic_config__ = STRICT
    frontal_m2: NonNegative = 0.0
    lateral_m2: NonNegative = 0.0
    cx: float = 0.7
    cy: float = 0.9
    cn: float = 0.1


@dataclass(frozen=True, slots=True)
class ThesisModelConfig:
    """What the thesis's own feed-forward believes beside `hull`'s inertia: the bare hull's mass, and damping as printed."""

    __pydantic_config__ = STRICT
    mass_kg: Positive
    damping: DampingConfig


def resistance_problems(hull: HullConfig, place: tuple[str | int, ...]) -> list[tuple[tuple[str | int, ...], str]]:
    """What is wrong with the table of resistance of the hull that stands at `place` in the file."""
    speeds = [speed_mps for speed_mps, _ in hull.resistance]
    if not hull.resistance or (
        len(speeds) >= 2 and hull.resistance[0] == (0.0, 0.0) and all(a < b for a, b in pairwise(speeds)) and min(n for _, n in hull.resistance) >= 0.0
    ):
        return []
    return [((*place, "resistance"), "needs two pairs or more of speed and force, from [0, 0] with rising speeds and no negative force")]
