"""Other vessels: each follows its script and ignores the boat."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class VesselMotion:
    """Motion of the middle of a hull, north and east of home. The heading equals the course."""

    north_m: float
    east_m: float
    course_rad: float
    speed_mps: float


@dataclass(frozen=True, slots=True)
class ScriptedVessel:
    """A vessel on straight lines between `points`, (t_s, north_m, east_m) in order of time; it goes on along the last.

    Its AIS transponder sends every `report_s`. Raises ValueError for fewer than two points, or times that do not grow.
    """

    mmsi: int
    name: str
    points: tuple[tuple[float, float, float], ...]
    length_m: float = 8.0
    beam_m: float = 3.0
    report_s: float = 10.0  # class A below 14 knots; ITU-R M.1371-5, table 1
    status: int = 0
    class_a: bool = True

    def __post_init__(self) -> None:
        times = [point[0] for point in self.points]
        if len(times) < 2 or any(b <= a for a, b in itertools.pairwise(times)):
            raise ValueError(f"{self.name}: a script needs two points or more, their times growing")

    def at(self, t_s: float) -> VesselMotion:
        """Its motion at `t_s`; before the first point it is on the first line extended backwards."""
        legs = list(itertools.pairwise(self.points))
        (t0, n0, e0), (t1, n1, e1) = next((leg for leg in legs if t_s < leg[1][0]), legs[-1])
        north_mps, east_mps = (n1 - n0) / (t1 - t0), (e1 - e0) / (t1 - t0)
        course = math.atan2(east_mps, north_mps)
        return VesselMotion(
            n0 + north_mps * (t_s - t0), e0 + east_mps * (t_s - t0), course, math.hypot(north_mps, east_mps)
        )


class Traffic:
    """The other vessels; scenarios add to them."""

    def __init__(self, vessels: Sequence[ScriptedVessel] = ()) -> None:
        self.vessels: list[ScriptedVessel] = list(vessels)
