"""Encounters of two vessels by the collision regulations (COLREG 1972, rules 13 to 18), and their closest approach.

Rule 13: a vessel overtakes when it comes up from more than 22.5° abaft the other's beam. Rule 14: head-on, on nearly
reciprocal courses. Rule 15: crossing; the vessel that has the other on its starboard side gives way. Rule 17: the other
vessel stands on, and acts when that alone does not suffice. Rule 18: a power-driven vessel gives way to vessels that
cannot manoeuvre as freely.
"""

from __future__ import annotations

import math
from enum import Enum

from companion.core.angles import wrap_pi
from companion.core.estimate import Contact

Velocity = tuple[float, float]  # north, east in m/s
Place = tuple[float, float]

STARBOARD, PORT = 1, -1
_ABAFT_RAD = math.radians(112.5)  # 22.5° abaft the beam
# Courses that differ by more are nearly reciprocal; in doubt the encounter is head-on (rule 14c).
_RECIPROCAL_RAD = math.radians(157.5)
_STANDING_MPS = 0.25
# AIS status: not under command, restricted, constrained by draught, fishing, under sail.
_PRIVILEGED = frozenset({2, 3, 4, 7, 8})


class Encounter(Enum):
    """What the other vessel is to this boat; the values are the words for people."""

    HEAD_ON = "head-on"
    CROSSING_STARBOARD = "crossing from starboard"
    CROSSING_PORT = "crossing from port"
    OVERTAKING = "being overtaken by us"
    OVERTAKEN = "overtaking us"
    STANDING = "lying in the way"


def encounter(here: Place, velocity: Velocity, other: Contact) -> Encounter:
    """Classify an encounter. `here` (north_m, east_m) and `velocity` (north, east, in m/s) are of this boat, which must
    make way."""
    if other.speed_mps < _STANDING_MPS:
        return Encounter.STANDING
    own_course, course = math.atan2(velocity[1], velocity[0]), math.atan2(other.east_mps, other.north_mps)
    bearing = math.atan2(other.east_m - here[1], other.north_m - here[0])
    seen, seen_from = wrap_pi(bearing - own_course), wrap_pi(bearing + math.pi - course)
    if abs(seen_from) > _ABAFT_RAD:
        return Encounter.OVERTAKING
    if abs(seen) > _ABAFT_RAD:
        return Encounter.OVERTAKEN
    if abs(wrap_pi(course - own_course)) > _RECIPROCAL_RAD:
        return Encounter.HEAD_ON
    return Encounter.CROSSING_STARBOARD if seen >= 0.0 else Encounter.CROSSING_PORT


def gives_way(met: Encounter, status: int | None) -> bool:
    """Whether this boat has to give way. `status`: AIS navigational status of the other, None where not known."""
    if met is Encounter.OVERTAKEN:
        return False
    return met is not Encounter.CROSSING_PORT or status in _PRIVILEGED


def sides(met: Encounter) -> tuple[int, ...]:
    """To which sides the course may be altered, the better one first. Never to port for a vessel that is head-on or
    crossing."""
    free = met in (Encounter.OVERTAKING, Encounter.OVERTAKEN, Encounter.STANDING)
    return (STARBOARD, PORT) if free else (STARBOARD,)


def keeps_astern(met: Encounter, status: int | None) -> bool:
    """Whether the boat must not cross ahead of the other (rule 15)."""
    return met is Encounter.CROSSING_STARBOARD or (met is Encounter.CROSSING_PORT and status in _PRIVILEGED)


def closest_approach(here: Place, velocity: Velocity, other: Contact) -> tuple[float, float]:
    """(distance between the middles in m, time until then in s) at the closest point of approach, if both keep course
    and speed. Time 0 where they move apart."""
    north, east = other.north_m - here[0], other.east_m - here[1]
    north_mps, east_mps = other.north_mps - velocity[0], other.east_mps - velocity[1]
    square = north_mps * north_mps + east_mps * east_mps
    t_s = 0.0 if square < 1e-12 else max(0.0, -(north * north_mps + east * east_mps) / square)
    return math.hypot(north + t_s * north_mps, east + t_s * east_mps), t_s
