"""MAV_CMD_NAV_TAKEOFF (22) and MAV_CMD_NAV_LAND (21), as programs written for aircraft send them."""

from __future__ import annotations

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied, is_place
from companion.supervisor.supervisor import Supervisor


def take_off(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Nothing: a boat is afloat already. An armed boat in a mode that sticks steer holds from then on. COM_TAKEOFF_OK 0
    refuses it. The params are ignored."""
    return supervisor.landing.take_off(request.now_s)


def land(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Hold, or dock, as COM_LAND_ACT says.

    param5: Latitude of the place to hold at. NaN or 0 in params 5 and 6: here.
    param6: Longitude.
    """
    lat_deg, lon_deg = request.place
    if not request.frame_is_global or request.names_no_place:
        return supervisor.landing.land(None, request.now_s)
    if not is_place(lat_deg, lon_deg):
        return denied("land: no such place (params 5 and 6)")
    return supervisor.landing.land((lat_deg, lon_deg), request.now_s)
