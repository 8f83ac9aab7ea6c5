"""A rudder behind a propeller, as a vessel's file describes it, and the coefficients of its blade."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import STRICT, Positive, derived, means

_SLOPE = 1.8 * math.pi  # of the lift of a wing of no sweep: Whicker and Fehlner 1958
_CROSS_FLOW = 0.8  # drag coefficient of the flow round the tip, for a blade with a square tip
_PROFILE_DRAG = 0.0065  # of a NACA 0015 section
_OSWALD = 0.9  # efficiency of the span


@dataclass(frozen=True, slots=True)
class RudderConfig:
    """A blade behind its propeller. It gives force only in flow: that of the boat's speed, and the propeller's race.

    Lift and drag by Whicker and Fehlner (1958), with Λ the span over the chord:
    C_L = 1.8 π Λ / (√(Λ² + 4) + 1.8) · δ + (0.8 / Λ) δ|δ|, C_D = 0.0065 + C_L² / (0.9 π Λ).
    Inflow as in the MMG method (Yasukawa and Yoshimura 2015):
    U² = η (U_A + κ (√(U_A² + 2T/(ρ A_P)) − U_A))² + (1 − η) U_A² with U_A = (1 − w) u,
    η = `race_share`, κ = `race_gain`, w = `wake_share`. A propeller that runs astern takes speed from the flow over the
    share η, down to none: there U² = U_A² + 2T/(ρ A_P).
    """

    __pydantic_config__ = STRICT
    span_m: Annotated[Positive, derived("Height of the blade.")]
    chord_m: Annotated[Positive, derived("Width of the blade, from its leading to its trailing edge.")]
    x_m: Annotated[float, derived("Position of the blade ahead of the middle of the boat; negative behind it.")]
    race_share: Annotated[
        float,
        Field(ge=0.0, le=1.0),
        derived("Share of the blade's height that stands in the race of its propeller. 0: it stands beside the race."),
    ]
    race_gain: Annotated[
        float,
        Field(gt=0.0, le=1.0),
        means("Share of the race's extra speed that the blade feels."),
    ] = 0.6
    wake_share: Annotated[
        float,
        Field(ge=0.0, lt=1.0),
        means("Share of the boat's speed that the hull takes from the flow at the stern."),
    ] = 0.1
    lift_scale: Annotated[
        Positive,
        means("Side force of this blade over what the formula says. A sea trial finds it."),
    ] = 1.0

    @property
    def area_m2(self) -> float:
        """Area of the blade."""
        return self.span_m * self.chord_m

    @property
    def aspect(self) -> float:
        """Λ: span over chord."""
        return self.span_m / self.chord_m

    @property
    def slope(self) -> float:
        """Slope of the lift coefficient at small angles, per rad."""
        return _SLOPE * self.aspect / (math.sqrt(self.aspect * self.aspect + 4.0) + 1.8)

    @property
    def cross_flow(self) -> float:
        """Factor of δ|δ| in the lift coefficient."""
        return _CROSS_FLOW / self.aspect

    def inflow(self, thrust_n: float, surge_mps: float, disc_kgpm: float) -> float:
        """U² at the blade, in m²/s². `disc_kgpm`: ½ ρ A_P. With the propeller hard astern only what stands beside the
        race has flow."""
        ahead, free = (1.0 - self.wake_share) * max(0.0, surge_mps), 1.0 - self.race_share
        if thrust_n < 0.0:
            return self.race_share * max(0.0, ahead * ahead + thrust_n / disc_kgpm) + free * ahead * ahead
        race = ahead + self.race_gain * (math.sqrt(ahead * ahead + thrust_n / disc_kgpm) - ahead)
        return self.race_share * race * race + free * ahead * ahead

    def lift(self, angle_rad: float) -> float:
        """C_L at an angle to the flow, without stall."""
        return (self.slope + self.cross_flow * abs(angle_rad)) * angle_rad

    def drag(self, lift: float) -> float:
        """C_D at a lift coefficient."""
        return _PROFILE_DRAG + lift * lift / (_OSWALD * math.pi * self.aspect)

    def side_share(self, angle_rad: float, propeller_m: float) -> float:
        """Side force at that angle over the thrust ahead, with the boat at rest."""
        disc_m2 = 0.25 * math.pi * propeller_m * propeller_m
        gain = self.race_share * self.race_gain * self.race_gain
        return self.lift_scale * self.area_m2 / disc_m2 * gain * self.lift(angle_rad)
