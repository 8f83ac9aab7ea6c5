"""MAV_CMD_DO_ORBIT (34): orbit a point, as COMMAND_LONG or COMMAND_INT (MAVLink, common.xml).

Param 1: radius in m, negative counter-clockwise. Param 2: speed over ground in m/s. Param 3: yaw behaviour; all of
ORBIT_YAW_BEHAVIOUR are accepted, and the boat sails bow first whichever is asked for. Param 4: angle to sweep in
radians, 0 without end. Params 5 and 6: centre. NaN: as it is while the boat orbits, else the parameters CIRC_*, without
end, round where the boat is.
"""

from __future__ import annotations

import math

from companion.core.decision import Outcome
from companion.io.mavlink.commands.request import Answer, CommandRequest, denied, is_place
from companion.modes.circle import OrbitOrder
from companion.supervisor.supervisor import Supervisor

_YAW_BEHAVIOURS = range(6)


def do_orbit(supervisor: Supervisor, request: CommandRequest) -> Outcome | Answer:
    """Orbit a point in Circle.

    param1: Radius in metres, negative counter-clockwise; NaN: as it is, else CIRC_RADIUS and CIRC_DIR.
    param2: Speed over ground in m/s; NaN: as it is, else CIRC_SPEED. Alone, it begins no orbit that is over.
    param3: Yaw behaviour; all are accepted, and the boat sails bow first.
    param4: Angle to sweep in radians; 0: without end.
    param5: Latitude of the centre; NaN: as it is, else where the boat is.
    param6: Longitude of the centre, likewise.
    """
    radius_m, speed_mps, _, sweep_rad = request.params[:4]
    if (reason := _refusal(request)) is not None:
        return denied(f"orbit: {reason}")
    lat_deg, lon_deg = request.place
    order = OrbitOrder(
        centre=None if math.isnan(lat_deg) and math.isnan(lon_deg) else (lat_deg, lon_deg),
        radius_m=None if math.isnan(radius_m) else abs(radius_m),
        clockwise=None if math.isnan(radius_m) else radius_m > 0.0,
        speed_mps=None if math.isnan(speed_mps) else speed_mps,
        total_rad=None if math.isnan(sweep_rad) else sweep_rad or math.inf,
    )
    return supervisor.give_order(order, request.now_s)


def _refusal(request: CommandRequest) -> str | None:
    """What of the params cannot be meant."""
    radius_m, speed_mps, _, sweep_rad = request.params[:4]
    lat_deg, lon_deg = request.place
    if not request.frame_is_global:
        return f"frame {request.frame} is not a global one"
    if radius_m == 0.0 or math.isinf(radius_m):
        return "radius (param 1) should be other than 0 m"
    if not math.isnan(speed_mps) and not 0.0 < speed_mps < math.inf:
        return "speed (param 2) should be above 0 m/s"
    if request.whole_or(3, 0) not in _YAW_BEHAVIOURS:
        return "yaw behaviour (param 3) should be 0 to 5"
    if not math.isnan(sweep_rad) and not 0.0 <= sweep_rad < math.inf:
        return "orbits (param 4) should be 0 rad or more"
    left_out = math.isnan(lat_deg) and math.isnan(lon_deg)
    return None if left_out or is_place(lat_deg, lon_deg) else "no such place (params 5 and 6)"
