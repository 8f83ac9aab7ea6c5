"""The boat's state in a few lines, from the fields of its messages, whichever library has parsed them."""

from __future__ import annotations

import math
from typing import Any

from gcs_plugins.commands import MODES

_ARMED = 0x80  # MAV_MODE_FLAG_SAFETY_ARMED
_ARDUPILOT = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
_GROUND_STATION = 6  # MAV_TYPE_GCS
_METRES_PER_DEGREE = 111_195.0
_IGNORE_POSITION, _IGNORE_YAW = 0b011, 1 << 10  # of POSITION_TARGET_TYPEMASK; north and east
_SILENT_S = 3.0
KINDS = (
    "HEARTBEAT",
    "GLOBAL_POSITION_INT",
    "POSITION_TARGET_GLOBAL_INT",
    "VFR_HUD",
    "NAV_CONTROLLER_OUTPUT",
    "MISSION_CURRENT",
    "NAMED_VALUE_FLOAT",
    "SYS_STATUS",
)


class Readout:
    """Remembers the newest message of each kind, and when it came (any clock, in seconds)."""

    def __init__(self) -> None:
        self._newest: dict[str, tuple[Any, float]] = {}

    def hear(self, kind: str, message: Any, now_s: float) -> None:
        """One message of the vehicle: its MAVLink name, and anything that has its fields."""
        if kind in KINDS and not (kind == "HEARTBEAT" and message.type == _GROUND_STATION):
            self._newest[kind] = (message, now_s)

    @property
    def rover_numbers(self) -> bool:
        """The link has the ardupilot persona, with Rover's mode numbers."""
        beat = self._message("HEARTBEAT")
        return beat is not None and beat.autopilot == _ARDUPILOT

    @property
    def mode(self) -> str | None:
        """The mode's name; None before the first heartbeat."""
        beat = self._message("HEARTBEAT")
        if beat is None:
            return None
        for name, numbers in MODES.items():
            if beat.custom_mode == (numbers.rover if self.rover_numbers else numbers.px4):
                return name
        return f"mode {beat.custom_mode}"

    def lines(self, now_s: float) -> list[str]:
        """The state, then the progress of the mode, then the retractable thruster."""
        beat = self._message("HEARTBEAT")
        if beat is None:
            return ["no heartbeat of the boat yet"]
        silent_s = now_s - self._newest["HEARTBEAT"][1]
        state = f"{self.mode}, {'armed' if beat.base_mode & _ARMED else 'disarmed'}"
        if silent_s > _SILENT_S:
            state += f" (silent for {silent_s:.0f} s)"
        said = [", ".join([state, *self._motion()])]
        about = {
            "Hold": self._held,
            "Dock": self._held,
            "Mission": self._path,
            "RTL": self._path,
            "Circle": self._path,
            "Follow": self._followed,
        }.get(self.mode or "")
        said += about() if about is not None else []
        return said + self._retraction()

    def _message(self, kind: str) -> Any:
        return self._newest[kind][0] if kind in self._newest else None

    def _motion(self) -> list[str]:
        parts, position, hud, power = (
            [],
            self._message("GLOBAL_POSITION_INT"),
            self._message("VFR_HUD"),
            self._message("SYS_STATUS"),
        )
        if position is not None:
            parts.append(f"{position.lat * 1e-7:.7f} {position.lon * 1e-7:.7f}")
        if hud is not None:
            parts.append(f"heading {hud.heading} deg, {hud.groundspeed:.2f} m/s")
        if power is not None and power.battery_remaining >= 0:
            parts.append(f"battery {power.battery_remaining} %")
        return parts

    def _held(self) -> list[str]:
        """Distance from the setpoint of dynamic positioning, and the heading error."""
        target, position = self._message("POSITION_TARGET_GLOBAL_INT"), self._message("GLOBAL_POSITION_INT")
        if target is None or position is None or target.type_mask & _IGNORE_POSITION:
            return []
        north_m = (target.lat_int - position.lat) * 1e-7 * _METRES_PER_DEGREE
        east_m = (
            (target.lon_int - position.lon) * 1e-7 * _METRES_PER_DEGREE * math.cos(math.radians(position.lat * 1e-7))
        )
        text = f"DP: {math.hypot(north_m, east_m):.2f} m off the setpoint"
        if not target.type_mask & _IGNORE_YAW and position.hdg != 0xFFFF:
            error_deg = (position.hdg * 0.01 - math.degrees(target.yaw) + 180.0) % 360.0 - 180.0
            text += f", heading {error_deg:+.1f} deg off {math.degrees(target.yaw) % 360.0:.1f}"
        output = self._message("NAV_CONTROLLER_OUTPUT")
        return [text + (f", {output.wp_dist} m to go" if output is not None and output.wp_dist > 0 else "")]

    def _path(self) -> list[str]:
        output, mission = self._message("NAV_CONTROLLER_OUTPUT"), self._message("MISSION_CURRENT")
        if output is None:
            return []
        side = "starboard" if output.xtrack_error >= 0.0 else "port"
        text = f"path: {abs(output.xtrack_error):.2f} m to {side} of it, {output.wp_dist} m to go"
        if self.mode == "Mission" and mission is not None:
            text += f", item {mission.seq + (not self.rover_numbers)}" + (
                f" of {mission.total}" if getattr(mission, "total", 0) not in (0, 0xFFFF) else ""
            )
        return [text]

    def _followed(self) -> list[str]:
        output = self._message("NAV_CONTROLLER_OUTPUT")
        return [] if output is None else [f"follow: {output.wp_dist} m to go, towards {output.target_bearing} deg"]

    def _retraction(self) -> list[str]:
        """NAMED_VALUE_FLOAT `NAME_down`: 0 up, 0.5 on its way, 1 down, not a number where it has failed."""
        named = self._message("NAMED_VALUE_FLOAT")
        name = (
            ""
            if named is None
            else named.name
            if isinstance(named.name, str)
            else bytes(named.name).decode("ascii", "replace")
        )
        thruster, _, rest = name.rstrip("\0").rpartition("_")
        if rest != "down":
            return []
        where = (
            "failed"
            if math.isnan(named.value)
            else "up"
            if named.value == 0.0
            else "down"
            if named.value == 1.0
            else "on its way"
        )
        return [f"{thruster} thruster: {where}"]
