"""The controller's model of the hull, as a vessel's file gives it."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated, Literal

from companion.config.fields import STRICT, NonNegative, Positive, derived, means

_GRAVITY_MPS2 = 9.81
_AXES = {"x_u": "surge", "y_v": "sway", "n_r": "yaw"}
AT_HULL_SHARE = 0.8
"""Of the wind's force by the wind at the mast, which is stronger than at the hull."""
AIR_KGPM3 = 1.225  # density at 15 °C and sea level, for which the factors of `WindageConfig` are


@dataclass(frozen=True, slots=True)
class DampingConfig:
    """Hydrodynamic damping in Fossen's derivatives, positive where it resists: X = −(x_u u + x_uu |u|u + x_uuu u³) and
    so on.

    Y = −(y_v v + y_vv |v|v + y_rv |r|v + y_r r + y_vr |v|r + y_rr |r|r), N likewise with n_. What grows with speed
    ahead: Y −= y_uv |u|v, N −= n_uv |u|v + n_ur |u|r.
    """

    __pydantic_config__ = STRICT
    x_u: Annotated[float, means("Damping of the surge force: factor of u, N per (m/s).")] = 0.0
    x_uu: Annotated[float, means("Damping of the surge force: factor of |u|u, N per (m/s)².")] = 0.0
    x_uuu: Annotated[float, means("Damping of the surge force: factor of u³, N per (m/s)³.")] = 0.0
    y_v: Annotated[float, means("Damping of the sway force: factor of v, N per (m/s).")] = 0.0
    y_vv: Annotated[float, means("Damping of the sway force: factor of |v|v, N per (m/s)².")] = 0.0
    y_rv: Annotated[float, means("Damping of the sway force: factor of |r|v, N per (m/s)·(rad/s).")] = 0.0
    y_r: Annotated[float, means("Damping of the sway force: factor of r, N per (rad/s).")] = 0.0
    y_vr: Annotated[float, means("Damping of the sway force: factor of |v|r, N per (m/s)·(rad/s).")] = 0.0
    y_rr: Annotated[float, means("Damping of the sway force: factor of |r|r, N per (rad/s)².")] = 0.0
    n_v: Annotated[float, means("Damping of the yaw moment: factor of v, Nm per (m/s).")] = 0.0
    n_vv: Annotated[float, means("Damping of the yaw moment: factor of |v|v, Nm per (m/s)².")] = 0.0
    n_rv: Annotated[float, means("Damping of the yaw moment: factor of |r|v, Nm per (m/s)·(rad/s).")] = 0.0
    n_r: Annotated[float, means("Damping of the yaw moment: factor of r, Nm per (rad/s).")] = 0.0
    n_vr: Annotated[float, means("Damping of the yaw moment: factor of |v|r, Nm per (m/s)·(rad/s).")] = 0.0
    n_rr: Annotated[float, means("Damping of the yaw moment: factor of |r|r, Nm per (rad/s)².")] = 0.0
    y_uv: Annotated[float, means("Damping of the sway force: factor of |u|v, N per (m/s)².")] = 0.0
    n_uv: Annotated[float, means("Damping of the yaw moment: factor of |u|v, Nm per (m/s)².")] = 0.0
    n_ur: Annotated[float, means("Damping of the yaw moment: factor of |u|r, Nm per (m/s)·(rad/s).")] = 0.0


@dataclass(frozen=True, slots=True)
class HullConfig:
    """Inertia with added mass, and damping: M = [[m11, 0, 0], [0, m22, m23], [0, m32, m33]].

    `resistance` is linear between its pairs, and beyond the last two. With `form` and dimensions the rest may be left
    out: `companion.config.dimensions` fills it in.
    """

    __pydantic_config__ = STRICT
    m11_kg: Annotated[Positive, derived("Mass with added mass in surge.")]
    m22_kg: Annotated[Positive, derived("Mass with added mass in sway.")]
    m33_kgm2: Annotated[Positive, derived("Moment of inertia with added inertia in yaw.")]
    m23_kgm: Annotated[float, means("Coupling of sway and yaw in the inertia matrix.")] = 0.0
    m32_kgm: Annotated[float | None, means("Coupling of yaw and sway. Left out: as `m23_kgm`.")] = None
    damping: Annotated[DampingConfig, means("Damping of the water.")] = field(default_factory=DampingConfig)
    resistance: Annotated[
        tuple[tuple[float, float], ...],
        means(
            "Resistance ahead of a hull that planes, as `[speed_mps, force_n]` pairs from `[0, 0]` with "
            "rising speeds. It comes on top of the x_ terms of the damping."
        ),
    ] = ()
    form: Annotated[
        Literal["monohull", "catamaran", "inflatable", "barge", "planing"] | None,
        means(
            "Form of the hull. With it the model is made of the dimensions below, and each key of the model in the "
            "file overrides one figure."
        ),
    ] = None
    length_m: Annotated[Positive | None, means("Length of the waterline. Left out: that of the boat.")] = None
    beam_m: Annotated[Positive | None, means("Width over all. Left out: that of the boat.")] = None
    mass_kg: Annotated[Positive | None, means("Mass of the boat as it floats.")] = None
    draft_m: Annotated[Positive | None, means("Depth of the hull below the water. Left out: by mass and form.")] = None
    hull_beam_m: Annotated[Positive | None, means("Width of one hull of a catamaran at the waterline.")] = None
    hull_spacing_m: Annotated[
        Positive | None,
        means("Distance between the centre planes of a catamaran's hulls. Left out: `beam_m` less `hull_beam_m`."),
    ] = None
    height_m: Annotated[
        Positive | None,
        means("Mean height of hull and gear above the water, for the wind. Left out: by length and form."),
    ] = None
    top_speed_mps: Annotated[
        Positive | None,
        means("Speed at full thrust, where it is known: it makes the damping ahead more certain."),
    ] = None

    @property
    def yaw_coupling_kgm(self) -> float:
        """M32: that of the file, or M23."""
        return self.m23_kgm if self.m32_kgm is None else self.m32_kgm

    def drag_n(self, surge_mps: float) -> float:
        """Resistance ahead in N at that speed; negative astern."""
        d, speed = self.damping, abs(surge_mps)
        force_n = (d.x_u + d.x_uu * speed + d.x_uuu * surge_mps * surge_mps) * surge_mps
        if self.resistance:
            return force_n + math.copysign(self._tabled(speed)[0], surge_mps)
        return force_n

    def drag_slope(self, surge_mps: float) -> float:
        """Change of `drag_n` with speed, in N/(m/s)."""
        d, speed = self.damping, abs(surge_mps)
        slope = d.x_u + 2.0 * d.x_uu * speed + 3.0 * d.x_uuu * surge_mps * surge_mps
        return slope + self._tabled(speed)[1] if self.resistance else slope

    def sway_lag_s(self, surge_mps: float, sway_mps: float) -> float:
        """The lag of the first-order sway m22 v̇ = −(Y_v + Y_uv u + Y_vv |v|) v, by which the course follows the bow; 0
        where nothing is known of the damping."""
        d = self.damping
        resisting = d.y_v + d.y_uv * abs(surge_mps) + d.y_vv * abs(sway_mps)
        return self.m22_kg / resisting if resisting > 0.0 else 0.0

    def _tabled(self, speed_mps: float) -> tuple[float, float]:
        """(force, slope) of the table."""
        points = self.resistance
        i = min(len(points) - 2, max(0, bisect_right(points, (speed_mps, math.inf)) - 1))
        (low, at_low), (high, at_high) = points[i], points[i + 1]
        slope = (at_high - at_low) / (high - low)
        return at_low + slope * (speed_mps - low), slope


def humps(resistance: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """The points (speed m/s, force N) of a table of resistance from which it falls with speed: a hull planes beyond."""
    return tuple(low for low, high in pairwise(resistance) if high[1] < low[1])


@dataclass(frozen=True, slots=True)
class WindageConfig:
    """Wind areas and coefficients (Fossen 2011, 8.1.3).

    With (ax, ay) the velocity of the air relative to the boat in body axes: X = ½ρ cx A_F V ax, Y = ½ρ cy A_L V ay,
    N = −ρ cn A_L L ax ay (½ρ cn A_L L V² sin 2γ: the bow turns away from the wind).
    """

    __pydantic_config__ = STRICT
    frontal_m2: Annotated[NonNegative, means("Area above the water seen from ahead.")] = 0.0
    lateral_m2: Annotated[NonNegative, means("Area above the water seen from the side.")] = 0.0
    cx: Annotated[float, means("Wind coefficient in surge.")] = 0.7
    cy: Annotated[float, means("Wind coefficient in sway.")] = 0.9
    cn: Annotated[float, means("Wind coefficient in yaw.")] = 0.1

    def force(self, x_mps: float, y_mps: float, length_m: float, share: float = 1.0) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) of the air that passes the hull at (x, y), times `share`."""
        speed_mps, pressure = math.hypot(x_mps, y_mps), 0.5 * AIR_KGPM3 * share
        return (
            pressure * self.cx * self.frontal_m2 * speed_mps * x_mps,
            pressure * self.cy * self.lateral_m2 * speed_mps * y_mps,
            -pressure * self.cn * self.lateral_m2 * length_m * 2.0 * x_mps * y_mps,
        )


@dataclass(frozen=True, slots=True)
class ThesisModelConfig:
    """What the thesis's own law and its feed-forward (DP_FF_KIND 1 and 2) believe beside the inertia of `[hull]`."""

    __pydantic_config__ = STRICT
    mass_kg: Annotated[Positive, means("Mass of the bare hull.")]
    damping: Annotated[DampingConfig, means("Damping as the thesis prints it.")]
    saturation: Annotated[
        tuple[Positive, Positive, Positive] | None,
        means("Most that the thesis's law asks for: surge N, sway N, yaw Nm. Left out: as of all laws, `[limits]`."),
    ] = None


def resistance_problems(hull: HullConfig, place: tuple[str | int, ...]) -> list[tuple[tuple[str | int, ...], str]]:
    """What is wrong with the resistance table of the hull at `place` in the file."""
    if not hull.resistance or _is_curve(hull.resistance):
        return []
    text = "needs two pairs or more of speed and force, from [0, 0] with rising speeds and no negative force"
    return [((*place, "resistance"), text)]


def usual_damping(hull: HullConfig, length_m: float) -> tuple[float, dict[str, float]]:
    """Half the hull speed in m/s, and by key what resists there without the terms with the speed ahead: drag in N; of a
    boat that slides or turns at a usual rate, force and moment over that rate."""
    d = hull.damping
    ahead_mps = 0.5 * math.sqrt(_GRAVITY_MPS2 * length_m / math.tau)
    return ahead_mps, {
        "x_u": hull.drag_n(ahead_mps),
        "y_v": d.y_v + d.y_vv * 0.5 * ahead_mps,
        "n_r": d.n_r + d.n_rr * ahead_mps / length_m,
    }


def damping_problems(hull: HullConfig, length_m: float) -> list[tuple[tuple[str | int, ...], str]]:
    """Damping that drives the boat on in its usual motion: with the signs of Fossen's derivatives, which are
    negative."""
    return [
        (("hull", "damping", key), f"the damping of {_AXES[key]} drives the boat on: positive is what resists")
        for key, value in usual_damping(hull, length_m)[1].items()
        if value < 0.0
    ]


def _is_curve(points: tuple[tuple[float, float], ...]) -> bool:
    """From (0, 0) on, with rising speeds and no negative force."""
    rising = all(slower < faster for (slower, _), (faster, _) in pairwise(points))
    return len(points) >= 2 and points[0] == (0.0, 0.0) and rising and min(force_n for _, force_n in points) >= 0.0
