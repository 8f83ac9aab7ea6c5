"""How a boat without sideways thrust turns: on the spot, or by a rudder along an arc, on which its hull slides
outwards."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.config.blades import without_blades
from companion.config.hull import HullConfig
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.config.yaw_limit import YawLimit
from companion.guidance.bend_speed import BendSpeeds
from companion.guidance.sideslip import SteeredHull, steered_hull_of

PLANNED_TURN = 0.7  # share of the yaw rate that bends are planned for; the rest is for corrections
TURN_PREVIEW_S = 1.2  # lag of the heading loop
_LATEST_S = 6.0


@dataclass(frozen=True, slots=True)
class Turning:
    """`arc`: the hull of a boat that a rudder turns; None for others. `bends`: the speeds in bends of a boat that the
    moment of its thrusters turns; None for others, and for one with sideways thrust. `aside`: what turns it pushes it
    out of the turn, as a thruster does that turns itself. `steered`: None for a boat with sideways thrust."""

    on_the_spot: bool = False
    arc: HullConfig | None = None
    bends: BendSpeeds | None = None
    aside: bool = False
    steered: SteeredHull | None = None

    def late_s(self, surge_mps: float, sway_mps: float) -> float:
        """How much later than its bow the boat turns its course, in an arc."""
        return 0.0 if self.arc is None else min(_LATEST_S, self.arc.sway_lag_s(surge_mps, sway_mps))

    def steepest_back_rad(self, off_m: float, speed_mps: float, yaw_rate_radps: float) -> float:
        """`steepest_rad` at that speed, for a boat that turns at `yaw_rate_radps` at most."""
        return self.steepest_rad(off_m, speed_mps / (PLANNED_TURN * yaw_rate_radps), TURN_PREVIEW_S * speed_mps)

    def steepest_rad(self, off_m: float, radius_m: float, late_m: float) -> float:
        """The steepest course to a line that is `off_m` away, from which a boat in an arc of `radius_m` still turns
        into it without crossing it, if it sails `late_m` before it turns: R (1 − cos χ) + L sin χ = the distance. A
        right angle for other boats."""
        far_m = math.hypot(radius_m, late_m)
        if self.arc is None or off_m >= radius_m + late_m or far_m <= 0.0:
            return 0.5 * math.pi
        return math.atan2(radius_m, late_m) + math.asin((off_m - radius_m) / far_m)


UNKNOWN = Turning()


def turning_of(config: VesselConfig, on_the_spot: bool) -> Turning:
    """How the vessel turns; `on_the_spot`: it needs no way for it."""
    rudder = config.has_rudder
    aside = any(thruster.kind != "fixed" for thruster in config.thrusters)
    return Turning(on_the_spot, config.hull if rudder else None, bends_of(config), aside, steered_hull_of(config))


def bends_of(config: VesselConfig, steady: bool = False) -> BendSpeeds | None:
    """The speeds in bends of a boat whose moment its thrust gives, with rudders beside other thrusters or without.
    `steady`: on a circle, with the sideways force of what steers it; on a path the boat learns how much harder a turn
    is (`BendSpeeds.resisted`)."""
    steered = steered_hull_of(config)
    if steered is None or any(t.kind not in ("fixed", "azimuth") for t in without_blades(config.thrusters)):
        return None
    return BendSpeeds(steered if steady else SteeredHull(config.hull), YawLimit(config), top_speed_mps(config))
