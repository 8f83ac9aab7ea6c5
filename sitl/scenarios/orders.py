"""What a ground station may order at any moment, with what the seed draws for it: modes, points, missions, circles,
speeds, sticks, setpoints."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from random import Random

from pymavlink.dialects.v20 import common as mavlink

from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.boat import stopping_room_m
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Point
from sitl.scenarios.offboard import POSITION, VELOCITY, VELOCITY_BODY, setpoint

ACCEPTED: int = mavlink.MAV_RESULT_ACCEPTED

Given = tuple[str, int]
"""An order in words, and the command's result."""

_MODES = {  # main mode and sub-mode, as PX4 numbers them
    "manual": (1, 0),
    "circle": (1, 3),
    "forces": (2, 0),
    "hold": (4, 3),
    "mission": (4, 4),
    "rtl": (4, 5),
    "rate": (5, 0),
    "offboard": (6, 0),
    "heading": (7, 0),
}
_LEAST_HALF_M, _HALF_S, _HALF_LENGTHS = 40.0, 30.0, 10.0  # of the water for points: at least, by speed, by length
_SHIFT = 0.85  # of that, by which its middle lies off home where a berth is near
_STREAM_S = 0.5  # setpoints before the mode


class Orders:
    """Gives an order to a boat and returns it in words, with the command's result.

    The water is a square with home in it, inside a fence. A berth near home lies outside.
    """

    def __init__(self, gcs: GroundStation, draws: Random) -> None:
        self.gcs = gcs
        self._draws = draws
        config = gcs.rig.config
        self._speed_mps = gcs.parameter("WP_SPEED")
        self._half_m = max(_LEAST_HALF_M, _HALF_S * self._speed_mps, _HALF_LENGTHS * config.length_m)
        self._line_m = self._half_m + 0.5 * config.length_m + gcs.parameter("FENCE_MARGIN") + 1.0
        self._room_m = stopping_room_m(config, min(top_speed_mps(config), gcs.parameter("MPC_XY_VEL_MAX")))
        self._home = LocalFrame(config.home.lat_deg, config.home.lon_deg)
        self._middle = self._away_from_berth(config)
        self._length_m = config.length_m

    # --- the water -----------------------------------------------------------------------------------------------

    def fence(self) -> list[Item]:
        """The corners of the square that the boat must not leave."""
        vertex, frame = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, mavlink.MAV_FRAME_GLOBAL
        sides = ((1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0))
        north_m, east_m = self._middle
        corners = [self._geodetic(north_m + a * self._line_m, east_m + b * self._line_m) for a, b in sides]
        return [Item(vertex, *corner, params=(4.0, 0.0, 0.0, 0.0), frame=frame) for corner in corners]

    def point(self, draws: Random | None = None) -> Point:
        """Somewhere in the water that the fence leaves to plans, north and east of home in m. `draws`: from another
        stream than the orders'."""
        draws = draws or self._draws
        north_m, east_m = (middle + draws.uniform(-self._half_m, self._half_m) for middle in self._middle)
        return north_m, east_m

    def _away_from_berth(self, config: VesselConfig) -> Point:
        if config.dock is None:
            return 0.0, 0.0
        berth = self._home.to_ned(config.dock.lat_deg, config.dock.lon_deg)
        north_m, east_m = (-math.copysign(_SHIFT * self._half_m, off_m) for off_m in berth)
        return north_m, east_m

    def _geodetic(self, north_m: float, east_m: float) -> Point:
        return self._home.to_geodetic(north_m, east_m)

    def _has_room(self) -> bool:
        truth, (north_m, east_m) = self.gcs.rig.world.truth, self._middle
        off_m = max(abs(truth.north_m - north_m), abs(truth.east_m - east_m))
        return off_m < self._line_m - 2.0 * self._room_m

    # --- modes and sticks ----------------------------------------------------------------------------------------

    def arm(self) -> Given:
        """Arm."""
        return "arm", self.gcs.ask(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)

    def disarm(self) -> Given:
        """Disarm for some seconds, and arm again."""
        result = self.gcs.ask(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)
        self.gcs.sail(self._draws.uniform(1.0, 5.0))
        return "disarm and arm", max(result, self.arm()[1])

    def mode(self, name: str) -> Given:
        """Change the mode."""
        return name, self.gcs.ask(mavlink.MAV_CMD_DO_SET_MODE, 1.0, *map(float, _MODES[name]))

    def sticks(self, name: str) -> Given:
        """Centre the sticks, change to a mode that they steer, and deflect them. Hold near the fence: a mode that is
        chosen at the line leads out."""
        if name != "hold" and not self._has_room():
            return self.mode("hold")
        self._stick(0, 0, 0)
        self.gcs.sail(0.5)
        asked, result = self.mode(name)
        deflected = [self._draws.randint(-1000, 1000) for _ in range(3)]
        self._stick(*deflected)
        return f"{asked} with sticks {deflected}", result

    def let_go(self) -> Given:
        """Centre the sticks; then send neither sticks nor setpoints."""
        self._stick(0, 0, 0)
        self.gcs.sail(1.0)
        self.gcs.streamed = tuple
        return "let go", ACCEPTED

    def _stick(self, surge: int, sway: int, yaw: int) -> None:
        message = mavlink.MAVLink_manual_control_message(self.gcs.vessel, surge, sway, 500, yaw, 0)
        self.gcs.streamed = lambda: (message,)

    def offboard(self) -> Given:
        """Stream setpoints of one kind, and choose Offboard."""
        speed_mps, course_rad = self._speed_mps * self._draws.uniform(0.2, 1.0), self._draws.uniform(-math.pi, math.pi)
        velocity = speed_mps * math.cos(course_rad), speed_mps * math.sin(course_rad)
        turn_radps = math.radians(self._draws.uniform(-5.0, 5.0))
        kind, message = self._draws.choice(
            (
                ("a point", setpoint(1, POSITION, *self.point(), course_rad)),
                ("a velocity", setpoint(1, VELOCITY, *velocity, course_rad)),
                ("a velocity along the hull", setpoint(8, VELOCITY_BODY, speed_mps, 0.0, 0.0, turn_radps)),
            )
        )
        self.gcs.streamed = lambda: (message,)
        self.gcs.sail(_STREAM_S)
        return f"offboard with {kind}", self.mode("offboard")[1]

    # --- points and circles --------------------------------------------------------------------------------------

    def go_to(self) -> Given:
        """A point, with a heading or without."""
        point, yaw_rad = self.point(), self._draws.choice((math.nan, self._draws.uniform(-math.pi, math.pi)))
        return f"go to {point[0]:.1f}, {point[1]:.1f} m, {math.degrees(yaw_rad):.0f} deg", self._reposition(
            point, yaw_rad
        )

    def outside(self) -> Given:
        """A point outside the fence."""
        return "go to a point outside", self._reposition(
            (self._middle[0] + 2.0 * self._line_m, self.point()[1]), math.nan
        )

    def _reposition(self, point: Point, yaw_rad: float) -> int:
        return self.gcs.ask_int(mavlink.MAV_CMD_DO_REPOSITION, *self._geodetic(*point), -1.0, 1.0, 0.0, yaw_rad)

    def orbit(self) -> Given:
        """A circle of a radius that the boat may or may not turn in."""
        radius_m, turns_rad = self._radius_m(), self._draws.choice((0.0, math.tau))
        place = self._geodetic(*self.point())
        return f"orbit {radius_m:.1f} m", self.gcs.ask_int(
            mavlink.MAV_CMD_DO_ORBIT, *place, radius_m, math.nan, 0.0, turns_rad
        )

    def _radius_m(self) -> float:
        return self._draws.uniform(1.0, 8.0) * self._length_m * self._draws.choice((-1.0, 1.0))

    # --- missions ------------------------------------------------------------------------------------------------

    def mission(self) -> Given:
        """Upload another mission, and sail it from its begin."""
        items = [item for _ in range(self._draws.randint(1, 6)) for item in self._part()]
        if self._draws.random() < 0.2:
            items.append(Item(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH))
        result = self.gcs.offer(items)
        if result != mavlink.MAV_MISSION_ACCEPTED:
            return f"mission of {len(items)}", result
        self.gcs.ask(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, 0.0)
        return f"mission of {len(items)}", self.mode("mission")[1]

    def _part(self) -> tuple[Item, ...]:
        """A waypoint, now and then with something to do there or on the way to the next."""
        draws = self._draws
        radius_m, yaw_deg = draws.choice((0.0, self._length_m)), draws.choice((math.nan, draws.uniform(-180.0, 180.0)))
        at = self._geodetic(*self.point())
        plain = Item(mavlink.MAV_CMD_NAV_WAYPOINT, *at, params=(0.0, radius_m, 0.0, math.nan))
        speed_mps = self._speed_mps * draws.uniform(0.4, 1.3)
        return draws.choice(
            (
                (plain,),
                (plain,),
                (plain,),
                (Item(mavlink.MAV_CMD_NAV_WAYPOINT, *at, params=(draws.uniform(1.0, 9.0), radius_m, 0.0, yaw_deg)),),
                (Item(mavlink.MAV_CMD_NAV_LOITER_TIME, *at, params=(draws.uniform(1.0, 15.0), 0.0, 0.0, yaw_deg)),),
                (Item(mavlink.MAV_CMD_NAV_LOITER_TURNS, *at, params=(1.0, 0.0, self._radius_m(), 0.0)),),
                (plain, Item(mavlink.MAV_CMD_DO_CHANGE_SPEED, params=(1.0, speed_mps, -1.0, 0.0))),
                (plain, Item(mavlink.MAV_CMD_NAV_DELAY, params=(draws.uniform(1.0, 9.0), -1.0, -1.0, -1.0))),
                (plain, Item(mavlink.MAV_CMD_CONDITION_YAW, params=(draws.uniform(0.0, 359.0), 0.0, 0.0, 0.0))),
                (plain, Item(mavlink.MAV_CMD_DO_JUMP, params=(0.0, 1.0, 0.0, 0.0))),
            )
        )

    def item(self) -> Given:
        """Another item of the mission."""
        sequence = self._draws.randint(0, 4)
        return f"item {sequence}", self.gcs.ask(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, float(sequence))

    def pause(self) -> Given:
        """Pause, or go on."""
        goes_on = self._draws.choice((0.0, 1.0))
        return ("continue" if goes_on else "pause"), self.gcs.ask(mavlink.MAV_CMD_DO_PAUSE_CONTINUE, goes_on)

    def speed(self) -> Given:
        """Another speed."""
        speed_mps = self._speed_mps * self._draws.uniform(0.4, 1.5)
        return f"{speed_mps:.2f} m/s", self.gcs.ask(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1.0, speed_mps, -1.0)

    def reverse(self) -> Given:
        """Stern first, or bow first again."""
        astern = self._draws.choice((0.0, 1.0))
        return ("stern first" if astern else "bow first"), self.gcs.ask(mavlink.MAV_CMD_DO_SET_REVERSE, astern)


def _mode(name: str) -> Callable[[Orders], Given]:
    return lambda orders: orders.mode(name)


def _sticks(name: str) -> Callable[[Orders], Given]:
    return lambda orders: orders.sticks(name)


CHOICES: Mapping[str, Callable[[Orders], Given]] = {
    "hold": _mode("hold"),
    "rtl": _mode("rtl"),
    "circle": _mode("circle"),
    "go_on": _mode("mission"),
    "manual": _sticks("manual"),
    "forces": _sticks("forces"),
    "rate": _sticks("rate"),
    "heading": _sticks("heading"),
    "nudge": _sticks("hold"),
    "let_go": Orders.let_go,
    "offboard": Orders.offboard,
    "go_to": Orders.go_to,
    "outside": Orders.outside,
    "orbit": Orders.orbit,
    "mission": Orders.mission,
    "item": Orders.item,
    "pause": Orders.pause,
    "speed": Orders.speed,
    "reverse": Orders.reverse,
    "disarm": Orders.disarm,
}
"""What can be ordered, by name."""

UNGUARDED = ("manual", "forces", "disarm")
"""Orders under which nothing keeps the boat off obstacles."""

DRIFTING = ("rate", "heading")
"""Orders under which a boat without sideways thrust stops for obstacles, and is then left to the wind."""
