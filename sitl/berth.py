"""A berth: a straight line of fenders that push back where a corner of the hull presses into it.

A berth has fenders for its boats: the same stiffness and damping for each kilogram, so that a ship model of 3 kg and a
ship of 35 t come to rest at them in the same way.
"""

from __future__ import annotations

import math

from companion.config.vessel import DockConfig, HomeConfig
from companion.core.geodesy import LocalFrame
from sitl.hull import Hull

_STIFFNESS_NPM, _DAMPING_NSPM = 4000.0, 500.0  # of the fenders at one corner of a boat of _FOR_KG
_FOR_KG = 306.44  # ReVolt with added mass in sway
_LENGTH_M, _LENGTHS = 10.0, 2.0  # least length of the line of fenders, and in lengths of the boat
_DEPTH_M = 1.0  # a corner further in than this is on another side of the quay
_SIDE_RAD = {"port": -0.5 * math.pi, "starboard": 0.5 * math.pi, "bow": 0.0, "stern": math.pi}


def fender(inertia_kg: float) -> tuple[float, float]:
    """(stiffness in N/m, damping in N·s/m) at one corner of a boat with this mass with added mass in sway."""
    share = inertia_kg / _FOR_KG
    return share * _STIFFNESS_NPM, share * _DAMPING_NSPM


class BerthModel:
    """Force of the fenders on the hull: spring and damper at each of the four corners, no friction. `inertia_kg`: mass
    of the boat with added mass in sway.

    Remembers the last contact. `force_n`: now. `gap_m`: from hull to line, negative while fenders are compressed.
    `touch_…`: speeds in body axes at the last touch, NaN before the first. North and east are from home.
    """

    __slots__ = (
        "_corners", "_damping_nspm", "_face", "_line_m", "_normal", "_point", "_stiffness_npm",
        "force_n", "gap_m", "touch_surge_mps", "touch_sway_mps",
    )  # fmt: skip

    def __init__(self, dock: DockConfig, home: HomeConfig, length_m: float, beam_m: float, inertia_kg: float) -> None:
        bearing = dock.yaw_rad + _SIDE_RAD[dock.side]
        self._normal = (-math.cos(bearing), -math.sin(bearing))  # pointing out of the quay
        self._face = (-math.sin(bearing), math.cos(bearing))
        north_m, east_m = LocalFrame(home.lat_deg, home.lon_deg).to_ned(dock.lat_deg, dock.lon_deg)
        self._point = (north_m + dock.clearance_m * self._normal[0], east_m + dock.clearance_m * self._normal[1])
        self._line_m = max(_LENGTH_M, _LENGTHS * length_m)
        self._stiffness_npm, self._damping_nspm = fender(inertia_kg)
        self._corners = tuple((x * length_m, y * beam_m) for x in (0.5, -0.5) for y in (0.5, -0.5))
        self.force_n = 0.0
        self.gap_m = math.inf
        self.touch_surge_mps = self.touch_sway_mps = math.nan

    def push(self, hull: Hull) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) on the hull at its present place and velocity."""
        (point_north, point_east), (nn, ne), (fn, fe) = self._point, self._normal, self._face
        off_north, off_east = hull.north_m - point_north, hull.east_m - point_east
        touching, self.force_n, self.gap_m = self.force_n > 0.0, 0.0, math.inf
        if math.hypot(off_north, off_east) > self._line_m:
            return 0.0, 0.0, 0.0
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        normal_x, normal_y = c * nn + s * ne, c * ne - s * nn
        force_n = moment_nm = 0.0
        for x, y in self._corners:
            north, east = off_north + c * x - s * y, off_east + s * x + c * y
            gap_m = north * nn + east * ne
            if abs(north * fn + east * fe) > 0.5 * self._line_m or gap_m < -_DEPTH_M:
                continue
            self.gap_m = min(self.gap_m, gap_m)
            if gap_m >= 0.0:
                continue
            arm_m = x * normal_y - y * normal_x
            opening_mps = hull.north_mps * nn + hull.east_mps * ne + arm_m * hull.yaw_rate_radps
            corner_n = max(0.0, -self._stiffness_npm * gap_m - self._damping_nspm * opening_mps)
            force_n += corner_n
            moment_nm += arm_m * corner_n
        self.force_n = force_n
        if force_n > 0.0 and not touching:
            self.touch_surge_mps, self.touch_sway_mps = hull.surge_mps, hull.sway_mps
        return force_n * normal_x, force_n * normal_y, moment_nm
