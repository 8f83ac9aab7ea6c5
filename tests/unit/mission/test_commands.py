"""The numbers are MAVLink's; what a heading of 0 means."""

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.mission.commands import RULES, Command, heading_rad, must_stay, name_of, stay_s
from companion.mission.plan import PlanItem

_LONGER_NAMES = {
    "FENCE_RETURN_POINT": "NAV_FENCE_RETURN_POINT",
    "FENCE_POLYGON_INCLUSION": "NAV_FENCE_POLYGON_VERTEX_INCLUSION",
    "FENCE_POLYGON_EXCLUSION": "NAV_FENCE_POLYGON_VERTEX_EXCLUSION",
    "FENCE_CIRCLE_INCLUSION": "NAV_FENCE_CIRCLE_INCLUSION",
    "FENCE_CIRCLE_EXCLUSION": "NAV_FENCE_CIRCLE_EXCLUSION",
    "RALLY_POINT": "NAV_RALLY_POINT",
}


@pytest.mark.parametrize("command", Command)
def test_every_number_is_mavlinks_and_has_its_rule(command: Command) -> None:
    assert getattr(mavlink, "MAV_CMD_" + _LONGER_NAMES.get(command.name, command.name)) == command
    assert command in RULES


def _item(command: int, hold: float, yaw: float) -> PlanItem:
    return PlanItem(0, command, 3, hold, 0.0, 0.0, yaw, 634389000, 103990000, 0.0)


@pytest.mark.parametrize(
    ("command", "hold", "yaw", "heading_deg", "stays"),
    [
        (16, 0.0, math.nan, None, False),
        (16, 0.0, 0.0, None, False),  # unused fields of Mission Planner are 0
        (16, 0.0, 999.0, None, False),  # of Cockpit
        (16, 0.0, 360.0, 0.0, True),
        (16, 0.0, 90.0, 90.0, True),
        (16, 5.0, 0.0, None, True),
        (16, 5.0, 360.0, 0.0, True),
        (16, 5.0, 1.0, 1.0, True),
        (16, 5.0, math.nan, None, True),
        (17, 0.0, 270.0, -90.0, True),
        (17, 0.0, 0.0, None, True),  # QGroundControl shows no heading there, and sends 0
        (17, 0.0, 360.0, 0.0, True),
        (19, 9.0, 0.0, None, True),
        (19, 9.0, 1.0, None, True),  # QGroundControl: leave the circle where the boat is
        (19, 9.0, 90.0, 90.0, True),
        (19, 0.0, 360.0, 0.0, True),
        (21, 0.0, 0.0, 0.0, True),  # a berth has a heading
    ],
)
def test_where_the_boat_stays_and_with_what_heading(
    command: int, hold: float, yaw: float, heading_deg: float | None, stays: bool
) -> None:
    item = _item(command, hold, yaw)
    heading = heading_rad(item)
    assert (heading is None) == (heading_deg is None)
    if heading is not None and heading_deg is not None:
        assert math.degrees(heading) == pytest.approx(heading_deg)
    assert must_stay(item) is stays


def test_only_a_loiter_without_limit_stays_for_ever() -> None:
    assert stay_s(_item(Command.NAV_LOITER_UNLIM, 3.0, math.nan)) is None
    assert stay_s(_item(Command.NAV_LOITER_TIME, 3.0, math.nan)) == 3.0
    assert stay_s(_item(Command.NAV_WAYPOINT, 4.0, math.nan)) == 4.0


def test_names_for_people() -> None:
    assert name_of(16) == "NAV_WAYPOINT"
    assert name_of(23) == "command 23"
