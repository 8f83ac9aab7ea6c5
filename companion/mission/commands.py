"""The commands that a plan may hold, and the table of rules for each of them.

Numbers, parameters and ranges are those of MAV_CMD in MAVLink's common.xml. Commands for a camera or a gimbal are
accepted without one too, with a word about it, so that the boat can sail survey plans of ground stations for its other
instruments. Those of aircraft that do not apply to a boat (take-off) are accepted without effect. All others are
refused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum, IntEnum

from companion.mission.plan import PlanItem, PlanKind


class Command(IntEnum):
    """The numbers are those of MAV_CMD."""

    NAV_WAYPOINT = 16
    NAV_LOITER_UNLIM = 17
    NAV_LOITER_TURNS = 18
    NAV_LOITER_TIME = 19
    NAV_RETURN_TO_LAUNCH = 20
    NAV_LAND = 21  # at a berth, or where the boat then holds
    NAV_TAKEOFF = 22
    NAV_LOITER_TO_ALT = 31
    DO_FOLLOW = 32
    NAV_SPLINE_WAYPOINT = 82
    NAV_DELAY = 93
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    CONDITION_YAW = 115
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_SET_RELAY = 181
    DO_REPEAT_RELAY = 182
    DO_SET_SERVO = 183
    DO_REPEAT_SERVO = 184
    DO_SET_ACTUATOR = 187
    DO_LAND_START = 189
    DO_SET_REVERSE = 194
    DO_SET_ROI_LOCATION = 195
    DO_SET_ROI_WPNEXT_OFFSET = 196
    DO_SET_ROI_NONE = 197
    DO_SET_ROI_SYSID = 198
    DO_CONTROL_VIDEO = 200
    DO_SET_ROI = 201
    DO_DIGICAM_CONTROL = 203
    DO_MOUNT_CONFIGURE = 204
    DO_MOUNT_CONTROL = 205
    DO_SET_CAM_TRIGG_DIST = 206
    DO_FENCE_ENABLE = 207
    DO_SET_CAM_TRIGG_INTERVAL = 214
    DO_MOUNT_CONTROL_QUAT = 220
    SET_CAMERA_MODE = 530
    SET_CAMERA_ZOOM = 531
    SET_CAMERA_FOCUS = 532
    SET_CAMERA_SOURCE = 534
    JUMP_TAG = 600  # a mark
    DO_JUMP_TAG = 601
    DO_GIMBAL_MANAGER_PITCHYAW = 1000
    DO_GIMBAL_MANAGER_CONFIGURE = 1001
    IMAGE_START_CAPTURE = 2000
    IMAGE_STOP_CAPTURE = 2001
    DO_TRIGGER_CONTROL = 2003
    VIDEO_START_CAPTURE = 2500
    VIDEO_STOP_CAPTURE = 2501
    FENCE_RETURN_POINT = 5000
    FENCE_POLYGON_INCLUSION = 5001
    FENCE_POLYGON_EXCLUSION = 5002
    FENCE_CIRCLE_INCLUSION = 5003
    FENCE_CIRCLE_EXCLUSION = 5004
    RALLY_POINT = 5100
    USER_3 = 31012  # follow position
    USER_5 = 31014  # a sea trial


class Role(Enum):
    """How the executor treats an item."""

    NAVIGATION = "navigation"  # a task of the boat, until it is done
    CONDITION = "condition"  # a task between two navigation items
    DO = "do"  # takes effect at once, on the way
    # delays the "do" items after it until it is met, at the latest to the end of the leg, while the boat sails on
    GATE = "gate"
    PAYLOAD = "payload"  # for a camera or a gimbal, at once, on the way
    IGNORED = "ignored"  # accepted, without effect
    ZONE = "zone"  # part of a fence, or a rally point


@dataclass(frozen=True, slots=True)
class Range:
    """Allowed values of parameter `number` (1…4): `low`…`high` (finite), one of `also`, or NaN if `nan`. `whole`: whole
    numbers only."""

    number: int
    label: str
    remedy: str
    low: float
    high: float = 3.4e38  # any finite float32
    whole: bool = False
    nan: bool = False
    also: tuple[float, ...] = ()

    def allows(self, value: float) -> bool:
        """Whether the parameter may have this value."""
        if self.low <= value <= self.high:
            return not self.whole or value == int(value)
        return (self.nan and value != value) or value in self.also


@dataclass(frozen=True, slots=True)
class Rule:
    """The rule of one command. `position`: x, y must be a latitude and a longitude."""

    role: Role
    kind: PlanKind = PlanKind.MISSION
    position: bool = False
    ranges: tuple[Range, ...] = ()


_HEADING = Range(4, "heading", "give −360 to 360 degrees, or NaN for none", -360.0, 360.0, nan=True)
_NO_HEADING = 999.0  # which Cockpit sends with every waypoint
_NO_HEADINGS: dict[int, tuple[float, ...]] = {
    Command.NAV_WAYPOINT: (0.0,),
    Command.NAV_LOITER_UNLIM: (0.0,),
    Command.NAV_LOITER_TIME: (0.0, 1.0),
}
_WAYPOINT_HEADING = replace(_HEADING, also=(_NO_HEADING,))
_SERVO = Range(1, "servo", "give the number of a servo output, 1 or more", 1, 16, whole=True)
_RELAY = Range(1, "relay", "give the number of a relay, 0 or more", 0, 15, whole=True)
_MARK = Range(1, "mark", "give a whole number, 0 to 65535", 0, 65535, whole=True)
_PULSE = Range(2, "pulse width", "give 500 to 2500 µs", 500, 2500)


def _count(number: int) -> Range:
    return Range(number, "count", "give a whole number, 1 to 1000", 1, 1000, whole=True)


def _cycle(number: int) -> Range:
    return Range(number, "cycle time", "give 0.2 to 3600 s", 0.2, 3600)


_IGNORED = Rule(Role.IGNORED)
_PAYLOAD = Rule(Role.PAYLOAD)


def _cameras(number: int) -> Range:
    return Range(number, "camera", "give its number from 1, or 0 for all", 0, 255, whole=True, nan=True)


def _switch(number: int, label: str) -> Range:
    return Range(number, label, "give 1 or 0, or −1 to leave it", -1, 1, whole=True, nan=True)


_POLYGON = Rule(
    Role.ZONE,
    PlanKind.FENCE,
    position=True,
    ranges=(
        Range(1, "vertex count", "a polygon has 3 vertices or more", 3, whole=True),
        Range(2, "inclusion group", "give a whole number, 0 or more", 0, whole=True),
    ),
)
_CIRCLE = Rule(
    Role.ZONE,
    PlanKind.FENCE,
    position=True,
    ranges=(
        Range(1, "radius", "give a radius above 0 m, up to 20000 km", 1e-3, 2.0e7),  # half round the Earth
        Range(2, "inclusion group", "give a whole number, 0 or more", 0, whole=True),
    ),
)

RULES: dict[int, Rule] = {
    Command.NAV_WAYPOINT: Rule(
        Role.NAVIGATION,
        position=True,
        ranges=(
            Range(1, "hold time", "give 0 s or more", 0),
            Range(2, "acceptance radius", "give 0 m or more; 0 means the vessel's own", 0, nan=True),
            _WAYPOINT_HEADING,
        ),
    ),
    Command.NAV_LOITER_UNLIM: Rule(Role.NAVIGATION, position=True, ranges=(_HEADING,)),
    Command.NAV_LOITER_TURNS: Rule(
        Role.NAVIGATION,
        position=True,
        ranges=(
            Range(1, "turns", "give 0 to 1000", 0, 1000),
            Range(2, "heading required", "give 0, or 1 to leave towards the next item", 0, 1, whole=True, nan=True),
            Range(
                3, "radius", "give metres, negative counter-clockwise; 0 means CIRC_RADIUS", -5000.0, 5000.0, nan=True
            ),
        ),
    ),
    Command.NAV_LOITER_TIME: Rule(
        Role.NAVIGATION, position=True, ranges=(Range(1, "time", "give 0 s or more", 0), _HEADING)
    ),
    Command.NAV_LOITER_TO_ALT: Rule(Role.NAVIGATION, position=True),  # a boat is at its altitude: a point to pass
    Command.NAV_SPLINE_WAYPOINT: Rule(
        Role.NAVIGATION, position=True, ranges=(Range(1, "hold time", "give 0 s or more", 0),)
    ),
    Command.NAV_TAKEOFF: _IGNORED,
    Command.NAV_RETURN_TO_LAUNCH: Rule(Role.NAVIGATION),
    Command.NAV_LAND: Rule(
        Role.NAVIGATION,
        position=True,
        ranges=(
            Range(
                4,
                "heading",
                "give the heading at which the boat lies at the berth, 0 to 360 degrees, or NaN to hold there",
                -360.0,
                360.0,
                nan=True,
            ),
        ),
    ),
    Command.NAV_DELAY: Rule(
        Role.NAVIGATION,
        ranges=(
            Range(1, "delay", "give 0 s or more, or −1 to wait for the time of day in params 2 to 4", 0, also=(-1.0,)),
        ),
    ),
    Command.USER_5: Rule(
        Role.NAVIGATION,
        ranges=(
            Range(1, "radius", "give the circle's radius in metres, or 0 for TRIAL_RADIUS", 0, 5000.0, nan=True),
            Range(
                2, "action", "give 0: a mission begins a trial; to accept its result is the operator's", 0, 0, nan=True
            ),
        ),
    ),
    Command.CONDITION_YAW: Rule(
        Role.CONDITION,
        ranges=(
            Range(1, "angle", "give 0 to 360 degrees; param3 gives the direction", 0, 360),
            Range(2, "angular speed", "give 0 deg/s or more; 0 means the vessel's own", 0, nan=True),
            Range(3, "direction", "give −1, 0 or 1", -1, 1, whole=True),
            Range(4, "relative", "give 0 or 1", 0, 1, whole=True),
        ),
    ),
    Command.CONDITION_DELAY: Rule(Role.GATE, ranges=(Range(1, "delay", "give 0 s or more", 0),)),
    Command.CONDITION_DISTANCE: Rule(Role.GATE, ranges=(Range(1, "distance", "give 0 m or more", 0),)),
    Command.DO_JUMP: Rule(
        Role.DO,
        ranges=(
            Range(1, "target", "give the number of an item of this plan", 0, whole=True),
            Range(2, "repeat count", "give a whole number, 0 or more, or −1 for ever", -1, whole=True),
        ),
    ),
    Command.JUMP_TAG: Rule(Role.DO, ranges=(_MARK,)),
    Command.DO_JUMP_TAG: Rule(
        Role.DO,
        ranges=(_MARK, Range(2, "repeat count", "give a whole number, 0 or more, or −1 for ever", -1, whole=True)),
    ),
    Command.DO_CHANGE_SPEED: Rule(
        Role.DO,
        ranges=(
            Range(1, "speed type", "give 1 (ground speed) or 0", 0, 1, whole=True),
            Range(
                2, "speed", "give more than 0 m/s, −1 for no change or −2 for the vessel's own", 1e-3, also=(-1.0, -2.0)
            ),
        ),
    ),
    Command.DO_SET_HOME: Rule(
        Role.DO, ranges=(Range(1, "use current position", "give 1 (here) or 0 (the position given)", 0, 1, whole=True),)
    ),
    Command.DO_SET_REVERSE: Rule(
        Role.DO,
        ranges=(Range(1, "reverse", "give 1 for stern first, or 0 for bow first", 0, 1, whole=True),),
    ),
    Command.DO_FENCE_ENABLE: Rule(
        Role.DO,
        ranges=(Range(1, "enable", "give 0 off, 1 on, or 2 for a floor, which there is not", 0, 2, whole=True),),
    ),
    Command.DO_FOLLOW: Rule(
        Role.DO,
        ranges=(
            Range(
                1,
                "leader",
                "give a system id, 1 to 255, or −1 for the one that FOLL_SYSID has",
                1,
                255,
                whole=True,
                nan=True,
                also=(-1.0,),
            ),
        ),
    ),
    Command.USER_3: Rule(
        Role.DO,
        ranges=(
            Range(
                1,
                "bearing",
                "give −360 to 360 degrees in the leader's frame, 180 astern, or NaN to keep it",
                -360,
                360,
                nan=True,
            ),
            Range(2, "distance", "give 1 to 500 m, not less than FOLL_MIN_DIST, or NaN to keep it", 1, 500, nan=True),
        ),
    ),
    Command.DO_SET_RELAY: Rule(Role.DO, ranges=(_RELAY, Range(2, "state", "give 1 (on) or 0 (off)", 0, 1, whole=True))),
    Command.DO_REPEAT_RELAY: Rule(Role.DO, ranges=(_RELAY, _count(2), _cycle(3))),
    Command.DO_SET_SERVO: Rule(Role.DO, ranges=(_SERVO, _PULSE)),
    Command.DO_REPEAT_SERVO: Rule(Role.DO, ranges=(_SERVO, _PULSE, _count(3), _cycle(4))),
    Command.DO_SET_ACTUATOR: Rule(
        Role.DO,
        ranges=tuple(
            Range(n, f"actuator {n}", "give −1 to 1, or NaN to leave it", -1, 1, nan=True) for n in range(1, 5)
        ),
    ),
    Command.DO_LAND_START: _IGNORED,
    Command.DO_SET_ROI_LOCATION: _PAYLOAD,
    Command.DO_SET_ROI_WPNEXT_OFFSET: _PAYLOAD,
    Command.DO_SET_ROI_NONE: _PAYLOAD,
    Command.DO_SET_ROI_SYSID: _PAYLOAD,
    Command.DO_CONTROL_VIDEO: _PAYLOAD,
    Command.DO_SET_ROI: _PAYLOAD,
    Command.DO_DIGICAM_CONTROL: _PAYLOAD,
    Command.DO_MOUNT_CONFIGURE: _PAYLOAD,
    Command.DO_MOUNT_CONTROL: _PAYLOAD,
    Command.DO_SET_CAM_TRIGG_DIST: Rule(
        Role.PAYLOAD,
        ranges=(
            Range(1, "distance", "give 0.1 m or more, or 0 to stop", 0.1, also=(0.0,)),
            _switch(3, "picture at once"),
            _cameras(4),
        ),
    ),
    Command.DO_SET_CAM_TRIGG_INTERVAL: Rule(
        Role.PAYLOAD,
        ranges=(Range(1, "cycle time", "give milliseconds, or 0 or −1 for no change", 0, also=(-1.0,)), _cameras(3)),
    ),
    Command.DO_MOUNT_CONTROL_QUAT: _PAYLOAD,
    Command.SET_CAMERA_MODE: _PAYLOAD,
    Command.SET_CAMERA_ZOOM: _PAYLOAD,
    Command.SET_CAMERA_FOCUS: _PAYLOAD,
    Command.SET_CAMERA_SOURCE: _PAYLOAD,
    Command.DO_GIMBAL_MANAGER_PITCHYAW: _PAYLOAD,
    Command.DO_GIMBAL_MANAGER_CONFIGURE: _PAYLOAD,
    Command.IMAGE_START_CAPTURE: Rule(
        Role.PAYLOAD,
        ranges=(
            _cameras(1),
            Range(2, "interval", "give 0 s or more", 0, nan=True),
            Range(3, "count", "give a whole number, or 0 for no end", 0, whole=True, nan=True),
            Range(4, "sequence", "give a whole number, or 0 for none", 0, whole=True, nan=True),
        ),
    ),
    Command.IMAGE_STOP_CAPTURE: Rule(Role.PAYLOAD, ranges=(_cameras(1),)),
    Command.DO_TRIGGER_CONTROL: Rule(
        Role.PAYLOAD, ranges=(_switch(1, "enable"), _switch(2, "reset"), _switch(3, "pause"))
    ),
    Command.VIDEO_START_CAPTURE: _PAYLOAD,
    Command.VIDEO_STOP_CAPTURE: _PAYLOAD,
    Command.FENCE_RETURN_POINT: Rule(Role.ZONE, PlanKind.FENCE, position=True),
    Command.FENCE_POLYGON_INCLUSION: _POLYGON,
    Command.FENCE_POLYGON_EXCLUSION: _POLYGON,
    Command.FENCE_CIRCLE_INCLUSION: _CIRCLE,
    Command.FENCE_CIRCLE_EXCLUSION: _CIRCLE,
    Command.RALLY_POINT: Rule(Role.ZONE, PlanKind.RALLY, position=True),
}

TASKS = frozenset(command for command, rule in RULES.items() if rule.role in (Role.NAVIGATION, Role.CONDITION))
PLACES = frozenset(command for command, rule in RULES.items() if rule.role is Role.NAVIGATION and rule.position)
DESTINATIONS = PLACES - {Command.NAV_LAND, Command.NAV_LOITER_TURNS}  # points that the boat is steered to
GATES = frozenset(command for command, rule in RULES.items() if rule.role is Role.GATE)
# Destinations at which the boat need not stay.
PASSED = frozenset({Command.NAV_WAYPOINT, Command.NAV_LOITER_TO_ALT, Command.NAV_SPLINE_WAYPOINT})
SERVOS = frozenset({Command.DO_SET_SERVO, Command.DO_REPEAT_SERVO})
RELAYS = frozenset({Command.DO_SET_RELAY, Command.DO_REPEAT_RELAY})
POLYGONS = frozenset({Command.FENCE_POLYGON_INCLUSION, Command.FENCE_POLYGON_EXCLUSION})
CIRCLES = frozenset({Command.FENCE_CIRCLE_INCLUSION, Command.FENCE_CIRCLE_EXCLUSION})


def is_no_circle(item: PlanItem) -> bool:
    """Whether it is a circle of a fence with radius 0, which clients send for none: MAVSDK's fences always hold one."""
    return item.command in CIRCLES and item.param1 == 0.0


def name_of(command: int) -> str:
    """The name of a command number, for people."""
    return Command(command).name if command in RULES else f"command {command}"


def heading_rad(item: PlanItem) -> float | None:
    """The heading that a waypoint or loiter item asks for; None for none.

    A param4 of exactly 0 is none: ground stations fill parameters that they do not show with 0 (Mission Planner in all
    three items, QGroundControl in NAV_LOITER_UNLIM), and the boat would turn north. 360 means north. In NAV_LOITER_TIME
    a 0 or 1 is MAVLink's "Xtrack Location", which QGroundControl sends; older programs have the heading there.
    """
    if (
        not math.isfinite(item.param4)
        or item.param4 == _NO_HEADING
        or item.command in (Command.NAV_LOITER_TO_ALT, Command.NAV_SPLINE_WAYPOINT)
    ):
        return None
    if item.param4 in _NO_HEADINGS.get(item.command, ()):
        return None
    return math.radians(math.remainder(item.param4, 360.0))


def must_stay(item: PlanItem) -> bool:
    """Whether the boat comes to rest at this destination, to stay for a while or to take up a heading."""
    return item.command not in PASSED or stay_s(item) != 0.0 or heading_rad(item) is not None


def stay_s(item: PlanItem) -> float | None:
    """How long the boat stays at this destination, in s; None: for ever."""
    if item.command == Command.NAV_LOITER_UNLIM:
        return None
    return 0.0 if item.command == Command.NAV_LOITER_TO_ALT or not item.param1 > 0.0 else item.param1
