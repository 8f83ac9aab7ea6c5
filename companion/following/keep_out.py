"""The keep-out circle around the lead boat: the way round it, seen from the leader."""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.params.store import Parameters

PORT, EITHER, STARBOARD = -1, 0, 1
_SWITCH_RAD = math.radians(25.0)  # the side changes only where the other way round is shorter by this
_ROUND_SHARE = 1.4  # of FOLL_MARGIN


def round_m(parameters: Parameters) -> float:
    """Radius in m at which the leader is passed, and no follow position is nearer: outside the keep-out circle, so that
    `Clearance` rarely has to act."""
    return parameters["FOLL_MIN_DIST"] + _ROUND_SHARE * parameters["FOLL_MARGIN"]


def way_round(
    here: tuple[float, float], goal: tuple[float, float], radius_m: float, side: int = EITHER
) -> tuple[tuple[float, float], float, int]:
    """The shortest way from `here` to `goal` that keeps out of a circle around the origin: (unit direction in which it
    begins, its length in m, side on which it passes the circle). Places are (north_m, east_m) from the leader.

    The way is straight, or a tangent to the circle, an arc, and a tangent off it. `side` as last time is kept unless
    the other way is clearly shorter: STARBOARD is clockwise as seen from above, EITHER a straight way. A boat inside
    the circle first goes outward. A goal inside counts as its nearest point on the circle.
    """
    hx, hy = here
    distance = math.hypot(hx, hy)
    gx, gy = goal
    far = math.hypot(gx, gy)
    if far < radius_m:
        gx, gy = (gx * radius_m / far, gy * radius_m / far) if far > 1e-9 else (radius_m, 0.0)
        far = radius_m
    dx, dy = gx - hx, gy - hy
    length = math.hypot(dx, dy)
    if length < 1e-9:
        return (1.0, 0.0), 0.0, EITHER
    if distance < 1e-9:
        return (dx / length, dy / length), length, EITHER
    nearest = max(0.0, min(1.0, -(hx * dx + hy * dy) / (length * length)))
    if math.hypot(hx + nearest * dx, hy + nearest * dy) >= min(radius_m, distance, far) - 1e-9:
        return (dx / length, dy / length), length, EITHER
    between = wrap_pi(math.atan2(gy, gx) - math.atan2(hy, hx))
    if side == EITHER or abs(between) < math.pi - _SWITCH_RAD:
        side = STARBOARD if between >= 0.0 else PORT
    turn = between * side if between * side >= 0.0 else between * side + math.tau  # how far round on that side
    leave = math.acos(min(1.0, radius_m / distance)) if distance > radius_m else 0.0
    join = math.acos(min(1.0, radius_m / far)) if far > radius_m else 0.0
    arc = max(0.0, turn - leave - join)
    way = (
        math.sqrt(max(0.0, distance * distance - radius_m * radius_m))
        + radius_m * arc
        + math.sqrt(max(0.0, far * far - radius_m * radius_m))
    )
    out_x, out_y = hx / distance, hy / distance
    if distance < radius_m:  # along the circle and outward
        share = min(1.0, (radius_m - distance) / (0.25 * radius_m))
        x, y = share * out_x - (1.0 - share) * side * out_y, share * out_y + (1.0 - share) * side * out_x
        norm = math.hypot(x, y)
        return (x / norm, y / norm), way, side
    angle = math.asin(min(1.0, radius_m / distance))  # between the line to the origin and the tangent
    c, s = math.cos(angle), -side * math.sin(angle)
    return (-(c * out_x - s * out_y), -(s * out_x + c * out_y)), way, side
