"""What lies and drifts in the simulated water beside vessels, and the bottom: round obstacles, shoals, walls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DEPTH_M = 6.0  # of the water where there is no shoal


@dataclass(frozen=True, slots=True)
class RoundObstacle:
    """A round thing, north and east of home at time 0, with its velocity over ground."""

    north_m: float
    east_m: float
    radius_m: float
    north_mps: float = 0.0
    east_mps: float = 0.0

    def at(self, t_s: float) -> tuple[float, float]:
        """(north_m, east_m) of its middle."""
        return self.north_m + t_s * self.north_mps, self.east_m + t_s * self.east_mps


@dataclass(frozen=True, slots=True)
class Wall:
    """A straight quay or pier between two points, (north_m, east_m) from home."""

    begin: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Shoal:
    """A round bank: `top_m` of water over its middle, and from `radius_m` on the depth around it. The bottom rises
    evenly."""

    north_m: float
    east_m: float
    radius_m: float
    top_m: float

    def depth_m(self, north_m: float, east_m: float) -> float:
        """Depth of water at a place."""
        share = math.hypot(north_m - self.north_m, east_m - self.east_m) / self.radius_m
        return DEPTH_M if share >= 1.0 else self.top_m + share * (DEPTH_M - self.top_m)


class Obstacles:
    """All of them; scenarios add to them."""

    def __init__(self) -> None:
        self.round: list[RoundObstacle] = []
        self.walls: list[Wall] = []
        self.shoals: list[Shoal] = []

    def depth_m(self, north_m: float, east_m: float) -> float:
        """Depth of water at a place."""
        return min((shoal.depth_m(north_m, east_m) for shoal in self.shoals), default=DEPTH_M)

    def distances_m(
        self, place: tuple[float, float], bearings_rad: Floats, t_s: float, others: Sequence[RoundObstacle] = ()
    ) -> Floats:
        """Distance to the nearest thing along each bearing, infinite where there is none; shape as `bearings_rad`.
        `others`: things that are there too."""
        north, east = np.cos(bearings_rad), np.sin(bearings_rad)
        nearest = np.full(bearings_rad.shape, np.inf)
        for thing in (*self.round, *others):
            middle = thing.at(t_s)
            off_n, off_e = middle[0] - place[0], middle[1] - place[1]
            ahead = north * off_n + east * off_e
            inside = thing.radius_m**2 - (off_n * off_n + off_e * off_e - ahead * ahead)
            hit = (inside >= 0.0) & (ahead > 0.0)
            nearest[hit] = np.minimum(nearest[hit], np.maximum(0.0, ahead[hit] - np.sqrt(inside[hit])))
        for wall in self.walls:
            nearest = np.minimum(nearest, _to_wall(wall, place, north, east))
        return nearest


def _to_wall(wall: Wall, place: tuple[float, float], north: Floats, east: Floats) -> Floats:
    along_n, along_e = wall.end[0] - wall.begin[0], wall.end[1] - wall.begin[1]
    off_n, off_e = wall.begin[0] - place[0], wall.begin[1] - place[1]
    cross = north * along_e - east * along_n
    with np.errstate(divide="ignore", invalid="ignore"):
        way = (off_n * along_e - off_e * along_n) / cross
        share = (off_n * east - off_e * north) / cross
    meets = (np.abs(cross) > 1e-9) & (way >= 0.0) & (share >= 0.0) & (share <= 1.0)
    found: Floats = np.where(meets, way, np.inf)
    return found


def between_m(corners: Sequence[tuple[float, float]], obstacles: Obstacles, t_s: float) -> float:
    """Distance between a hull, by its corners, and the nearest round obstacle or wall; 0 where they touch."""
    from shapely import LineString, Point, Polygon

    hull = Polygon(corners)
    gaps = [max(0.0, float(hull.distance(Point(*one.at(t_s)))) - one.radius_m) for one in obstacles.round]
    gaps += [float(hull.distance(LineString([wall.begin, wall.end]))) for wall in obstacles.walls]
    return min(gaps, default=math.inf)
