"""The table of the actions that a button can send to the boat. Every plug-in here is made from it.

It is pure data and imports nothing of the companion, because ground stations load it. Tests check each row against a
running vessel, and the numbers against MAVLink and the companion's declarations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum

LONGEST_LABEL = 20


class MavCmd(IntEnum):
    """The commands of the table; numbers and names of MAVLink's MAV_CMD."""

    NAV_RETURN_TO_LAUNCH = 20
    DO_FOLLOW = 32
    DO_SET_MODE = 176
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_PAUSE_CONTINUE = 193
    DO_SET_MISSION_CURRENT = 224
    MISSION_START = 300
    COMPONENT_ARM_DISARM = 400
    RUN_PREARM_CHECKS = 401
    USER_1 = 31010
    USER_2 = 31011
    USER_3 = 31012
    USER_4 = 31013
    USER_5 = 31014


class Where(Enum):
    """When the boat accepts a command; else it refuses it with the reason."""

    ALWAYS = "always"
    DISARMED = "disarmed"
    UNLESS_NEEDED = "disarmed or in Manual"
    HOLD = "in Hold, armed"
    MISSION = "with a mission aboard"
    PAUSED = "with the mission paused"
    SELF_STEERED = "in a mode that steers itself"
    BERTH = "with a berth in the mission or the vessel's file"
    LEADER = "with a leader heard"
    ASKED = "while the boat asks whether a sensor is right"
    TRIAL = "with the result of a sea trial, disarmed or in Hold"
    ACCEPTED = "with an accepted result of a sea trial, disarmed or in Hold"


@dataclass(frozen=True, slots=True)
class ModeNumbers:
    """`custom_mode` of one mode, by the link's persona."""

    px4: int
    rover: int  # on a link with ?dialect=ardupilot


MODES: Mapping[str, ModeNumbers] = {
    "Manual": ModeNumbers(0x00010000, 0),
    "Forces": ModeNumbers(0x00020000, 31),
    "Rate": ModeNumbers(0x00050000, 1),
    "Heading": ModeNumbers(0x00070000, 3),
    "Hold": ModeNumbers(0x03040000, 4),
    "Mission": ModeNumbers(0x04040000, 10),
    "RTL": ModeNumbers(0x05040000, 11),
    "Dock": ModeNumbers(0x06040000, 8),
    "Follow": ModeNumbers(0x08040000, 6),
    "Offboard": ModeNumbers(0x00060000, 15),
    "Circle": ModeNumbers(0x01030000, 9),
    "Trial": ModeNumbers(0x040C0000, 30),
}


@dataclass(frozen=True, slots=True)
class OperatorAction:
    """One row. A row with a `mode` sends DO_SET_MODE with that mode's number; `params` are 1, 2, …, those left out are
    0.

    `joystick`: among the actions that a button of a stick can be given; `button`: which one is suggested, as Cockpit
    numbers a standard gamepad, with `shift` held where that is set. No number is NaN: JSON has none.

    `asks`: what a slip would do, for a ground station that asks before it sends; empty: the action is safe at one
    click, because the boat stays where it is, or the next click takes it back. Only such actions go to ground stations
    whose buttons fire at once (QGroundControl's action files, Cockpit's MAVLink message actions). An emergency stop is
    among them: it must not ask.
    """

    name: str
    label: str
    text: str
    command: MavCmd
    params: tuple[float, ...] = ()
    mode: str | None = None
    where: Where = Where.ALWAYS
    joystick: bool = False
    button: int | None = None
    shift: bool = False
    asks: str = ""

    @property
    def at_once(self) -> bool:
        """Whether it is safe at one click."""
        return not self.asks

    def all_params(self, rover_numbers: bool = False) -> tuple[float, ...]:
        """Params 1 to 7 as COMMAND_LONG has them. `rover_numbers`: for a link with the ardupilot persona."""
        params = self.params
        if self.mode is not None:
            numbers = MODES[self.mode]
            params = (1.0, float(numbers.rover if rover_numbers else numbers.px4))
        return (*params, *(0.0 for _ in range(7 - len(params))))


_SAILS = "the boat sails off"


def _mode(
    name: str, label: str, mode: str, text: str, where: Where = Where.ALWAYS, button: int | None = None, asks: str = ""
) -> OperatorAction:
    joystick = button is not None
    return OperatorAction(
        name, label, text, MavCmd.DO_SET_MODE, mode=mode, where=where, joystick=joystick, button=button, asks=asks
    )


def _nudge(
    name: str, label: str, text: str, params: tuple[float, ...], button: int, shift: bool = False
) -> OperatorAction:
    return OperatorAction(
        name, label, text, MavCmd.USER_1, (1.0, *params), where=Where.HOLD, joystick=True, button=button, shift=shift
    )


def _bow(name: str, label: str, heading_deg: float) -> OperatorAction:
    return OperatorAction(
        name,
        label,
        f"Turn the bow to {heading_deg:g} degrees at the point held",
        MavCmd.USER_1,
        (2.0, heading_deg),
        where=Where.HOLD,
    )


def _station(name: str, label: str, where: str, bearing_deg: float) -> OperatorAction:
    text = f"Follow 20 m from the leader, {where}, until another follow position is set or the boat is disarmed"
    return OperatorAction(name, label, text, MavCmd.USER_3, (bearing_deg, 20.0))


# Buttons: 0 to 3 the lower, right, left and upper face button, 4 and 5 the shoulders, 12 to 15 the cross up, down,
# left, right.
ACTIONS: tuple[OperatorAction, ...] = (
    _mode("hold", "Hold here", "Hold", "Dynamic positioning: hold this point and heading", button=0),
    OperatorAction(
        "stop",
        "STOP thrusters",
        "Disarm at once, whatever the boat does: every thruster at neutral",
        MavCmd.COMPONENT_ARM_DISARM,
        (0.0, 21196.0),
        joystick=True,
        button=1,
        shift=True,
    ),
    OperatorAction(
        "arm",
        "Arm thrusters",
        "Arm: the thrusters give thrust from now on",
        MavCmd.COMPONENT_ARM_DISARM,
        (1.0,),
        asks="propellers may turn from now on",
    ),
    OperatorAction(
        "disarm",
        "Disarm thrusters",
        "Disarm: every thruster at neutral",
        MavCmd.COMPONENT_ARM_DISARM,
        (0.0,),
        asks="a boat under way drifts",
    ),
    OperatorAction(
        "checks",
        "Why not armed?",
        "Report every reason against arming",
        MavCmd.RUN_PREARM_CHECKS,
        where=Where.DISARMED,
    ),
    # missions and ways
    OperatorAction(
        "start",
        "Start the mission",
        "Sail the mission from its current item; the boat must be armed to move",
        MavCmd.MISSION_START,
        where=Where.MISSION,
        asks=_SAILS,
    ),
    OperatorAction(
        "pause",
        "Pause and hold",
        "Hold here; the mission keeps its place",
        MavCmd.DO_PAUSE_CONTINUE,
        (0.0,),
        where=Where.SELF_STEERED,
        joystick=True,
    ),
    OperatorAction(
        "continue",
        "Go on with mission",
        "Go on with the mission that was paused",
        MavCmd.DO_PAUSE_CONTINUE,
        (1.0,),
        where=Where.PAUSED,
        asks=_SAILS,
    ),
    OperatorAction(
        "restart",
        "Mission from item 1",
        "Make the first item current and forget the jumps taken",
        MavCmd.DO_SET_MISSION_CURRENT,
        (0.0, 1.0),
        where=Where.MISSION,
        asks="a boat on its mission turns back to the first item",
    ),
    OperatorAction(
        "return",
        "Return home",
        "Back to home or the nearest rally point, then hold",
        MavCmd.NAV_RETURN_TO_LAUNCH,
        asks=_SAILS,
    ),
    _mode(
        "dock",
        "Go alongside",
        "Dock",
        "Dock: to the standoff point, then alongside the berth, pushing until disarmed",
        where=Where.BERTH,
        asks="the boat sails to the berth and pushes against it",
    ),
    _mode(
        "circle",
        "Circle here",
        "Circle",
        "Orbit the point where the boat is, at CIRC_RADIUS, until another mode",
        asks=_SAILS,
    ),
    OperatorAction(
        "set-home",
        "Home is here",
        "Home becomes where the boat is now",
        MavCmd.DO_SET_HOME,
        (1.0,),
        asks="RTL and failsafes go here from now on",
    ),
    OperatorAction(
        "slow",
        "Slow, 0.3 m/s",
        "At most 0.3 m/s in self-steered modes, until the mission changes it",
        MavCmd.DO_CHANGE_SPEED,
        (1.0, 0.3, -1.0),
    ),
    OperatorAction(
        "usual-speed", "Usual speed", "Back to the speed of the parameters", MavCmd.DO_CHANGE_SPEED, (1.0, -2.0, -1.0)
    ),
    # by hand
    _mode("manual", "Steer by hand", "Manual", "The sticks drive the thrusters", button=1),
    _mode("forces", "Steer by forces", "Forces", "The sticks demand surge force, sway force and yaw moment"),
    _mode("rate", "Steer by rate", "Rate", "The sticks demand speed and turn rate, which the boat keeps"),
    _mode(
        "heading",
        "Steer by heading",
        "Heading",
        "The boat holds its heading; the sticks give thrust and turn that heading",
    ),
    # small corrections of the pose held
    _nudge("nudge-ahead", "Nudge ahead 1 m", "Move the point held 1 m ahead", (1.0, 0.0, 0.0), 12),
    _nudge("nudge-astern", "Nudge astern 1 m", "Move the point held 1 m astern", (-1.0, 0.0, 0.0), 13),
    _nudge("nudge-port", "Nudge to port 1 m", "Move the point held 1 m to port", (0.0, -1.0, 0.0), 14),
    _nudge("nudge-starboard", "Nudge to stbd 1 m", "Move the point held 1 m to starboard", (0.0, 1.0, 0.0), 15),
    _nudge(
        "turn-port",
        "Turn 10 deg to port",
        "Turn the heading held 10 degrees to port",
        (0.0, 0.0, -10.0),
        14,
        shift=True,
    ),
    _nudge(
        "turn-starboard",
        "Turn 10 deg to stbd",
        "Turn the heading held 10 degrees to starboard",
        (0.0, 0.0, 10.0),
        15,
        shift=True,
    ),
    _bow("bow-north", "Bow to north", 0.0),
    _bow("bow-east", "Bow to east", 90.0),
    _bow("bow-south", "Bow to south", 180.0),
    _bow("bow-west", "Bow to west", 270.0),
    # sensors that seem to lie
    OperatorAction(
        "accept",
        "Accept the sensor",
        "The sensor that the boat asks about is right: the estimate follows it",
        MavCmd.USER_4,
        (1.0,),
        where=Where.ASKED,
    ),
    OperatorAction(
        "reject",
        "Reject the sensor",
        "The sensor that the boat asks about is wrong: it is not used until it agrees with the others",
        MavCmd.USER_4,
        (2.0,),
        where=Where.ASKED,
    ),
    # sea trials
    _mode(
        "trial",
        "Sea trial here",
        "Trial",
        "Sail manoeuvres inside a circle of TRIAL_RADIUS around the boat, and identify its model from them",
        asks="the boat sails manoeuvres, at up to full thrust",
    ),
    OperatorAction(
        "trial-accept",
        "Accept trial model",
        "Accept what the last sea trial found: it counts after a reboot",
        MavCmd.USER_5,
        (0.0, 1.0),
        where=Where.TRIAL,
    ),
    OperatorAction(
        "trial-undo",
        "Undo trial model",
        "Take back the model that was accepted: the one before counts after a reboot",
        MavCmd.USER_5,
        (0.0, 2.0),
        where=Where.ACCEPTED,
    ),
    # following
    OperatorAction(
        "follow",
        "Follow the leader",
        "Follow the leader of FOLL_SYSID",
        MavCmd.DO_FOLLOW,
        (-1.0,),
        where=Where.LEADER,
        asks="the boat sails after the leader",
    ),
    OperatorAction(
        "follow-end", "Stop following", "Stop following and hold here", MavCmd.DO_FOLLOW, (0.0,), joystick=True
    ),
    _station("station-astern", "Keep astern 20 m", "astern", 180.0),
    _station("station-port-quarter", "Keep port qtr 20 m", "on its port quarter", -135.0),
    _station("station-stbd-quarter", "Keep stbd qtr 20 m", "on its starboard quarter", 135.0),
    _station("station-port", "Keep to port 20 m", "abeam to port", -90.0),
    _station("station-starboard", "Keep to stbd 20 m", "abeam to starboard", 90.0),
    # thrusters
    OperatorAction(
        "lower",
        "Lower bow thruster",
        "Lower the retractable thruster",
        MavCmd.USER_2,
        (1.0,),
        asks="the thruster moves out: hands off, and water below it",
    ),
    OperatorAction(
        "retract",
        "Retract bow thruster",
        "Retract the retractable thruster",
        MavCmd.USER_2,
        (2.0,),
        where=Where.UNLESS_NEEDED,
        asks="the thruster moves in: hands off",
    ),
)

BY_NAME: Mapping[str, OperatorAction] = {action.name: action for action in ACTIONS}

TUNING: Mapping[str, tuple[str, ...]] = {
    "dp": ("DP_BW_SURGE", "DP_BW_SWAY", "DP_BW_YAW"),
    "dp-surge": ("DP_BW_SURGE",),
    "dp-sway": ("DP_BW_SWAY",),
    "dp-yaw": ("DP_BW_YAW",),
    "path": ("PATH_BW_SURGE", "PATH_BW_YAW"),
    "path-speed": ("PATH_BW_SURGE",),
    "path-heading": ("PATH_BW_YAW",),
}
"""Loops and the parameters that are their bandwidths, rad/s."""

TUNING_STEP = 1.1
"""One step up; a step down is its inverse."""
