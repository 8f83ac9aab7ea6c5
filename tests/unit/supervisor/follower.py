"""A boat that follows, and what is asked of it."""

from __future__ import annotations

import math
from typing import Any

from companion.core.decision import ModeId
from companion.core.setpoint import PathSetpoint
from companion.supervisor.authority import AuthorityRequest, RequestedAction
from tests.unit.following.lead_boat import LeadBoat


def following(boat: Any, lead: LeadBoat) -> None:
    """Armed and in Follow, 5 s under way."""
    lead.run(2.0)
    assert boat.supervisor.request_mode(ModeId.FOLLOW, boat.now_s).accepted
    assert boat.supervisor.arm(boat.now_s).accepted
    lead.run(5.0)
    assert boat.status.mode is ModeId.FOLLOW and isinstance(boat.setpoint, PathSetpoint)
    boat.said.clear()


def remote_system(boat: Any) -> int | None:
    return boat.supervisor.facts(boat.now_s).remote_system


def stick_refusal(boat: Any, system: int) -> str | None:
    return boat.supervisor.refusal(AuthorityRequest(RequestedAction.GROUND_STICKS, system=system), boat.now_s)


def modes_said(boat: Any) -> list[str]:
    return [text for name, text in boat.said if name == "mode_changed"]


def station(boat: Any) -> tuple[float, float]:
    distance_m, bearing_rad = boat.supervisor.following.follow_position
    return distance_m, math.degrees(bearing_rad)
