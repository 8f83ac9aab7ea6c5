"""What a ground station says to ArduRover and has heard of it: MAVLink in and out as bytes, without a socket."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from companion.config.vessel import HomeConfig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.measure import Point

LOITER, AUTO, GUIDED = 5, 10, 15
_EKF_NEEDS = mavlink.EKF_ATTITUDE | mavlink.EKF_VELOCITY_HORIZ | mavlink.EKF_POS_HORIZ_ABS
_POSITION_ALONE = 0b110111111000  # type mask of SET_POSITION_TARGET

_KINDS = {
    mavlink.FIRMWARE_VERSION_TYPE_DEV: "-dev",
    mavlink.FIRMWARE_VERSION_TYPE_ALPHA: "-alpha",
    mavlink.FIRMWARE_VERSION_TYPE_BETA: "-beta",
    mavlink.FIRMWARE_VERSION_TYPE_RC: "-rc",
}


class RoverStation:
    """Remembers the newest of what ArduRover said.

    `at`, `target`: where it believes to be and where it goes, north and east of home in m. `asked`: numbers of mission
    items that it waits for. `verdict`: its last word on a mission, MAV_MISSION_RESULT. `version`: as 4.7.0-dev, and its
    commit.
    """

    def __init__(self, home: HomeConfig) -> None:
        self._frame = LocalFrame(home.lat_deg, home.lon_deg)
        self._wire = mavlink.MAVLink(None, srcSystem=255, srcComponent=mavlink.MAV_COMP_ID_MISSIONPLANNER)
        self._wire.robust_parsing = True
        self.mode: int | None = None
        self.armed = self.knows_place = False
        self.at: Point | None = None
        self.target: Point | None = None
        self.current_item, self.reached_item = 0, -1
        self.asked: list[int] = []
        self.verdict: int | None = None
        self.texts: list[str] = []
        self.version = ""
        self._heard: dict[str, Callable[[Any], None]] = {
            "HEARTBEAT": self._on_heartbeat,
            "EKF_STATUS_REPORT": self._on_estimate,
            "GLOBAL_POSITION_INT": self._on_place,
            "POSITION_TARGET_GLOBAL_INT": self._on_target,
            "MISSION_CURRENT": self._on_current,
            "MISSION_ITEM_REACHED": self._on_reached,
            "MISSION_REQUEST": self._on_request,
            "MISSION_REQUEST_INT": self._on_request,
            "MISSION_ACK": self._on_verdict,
            "STATUSTEXT": self._on_text,
            "AUTOPILOT_VERSION": self._on_version,
        }

    # --- heard -----------------------------------------------------------------------------------------------------

    def hear(self, data: bytes) -> None:
        """Take in what ArduRover sent."""
        for message in self._wire.parse_buffer(data) or ():
            if message.get_srcComponent() == mavlink.MAV_COMP_ID_AUTOPILOT1:
                self._heard.get(message.get_type(), _ignore)(message)

    def _on_heartbeat(self, message: Any) -> None:
        self.mode, self.armed = message.custom_mode, bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)

    def _on_estimate(self, message: Any) -> None:
        self.knows_place = message.flags & _EKF_NEEDS == _EKF_NEEDS and not message.flags & mavlink.EKF_CONST_POS_MODE

    def _on_place(self, message: Any) -> None:
        self.at = self._frame.to_ned(message.lat * 1.0e-7, message.lon * 1.0e-7)

    def _on_target(self, message: Any) -> None:
        self.target = self._frame.to_ned(message.lat_int * 1.0e-7, message.lon_int * 1.0e-7)

    def _on_current(self, message: Any) -> None:
        self.current_item = message.seq

    def _on_reached(self, message: Any) -> None:
        self.reached_item = max(self.reached_item, message.seq)

    def _on_request(self, message: Any) -> None:
        self.asked.append(message.seq)

    def _on_verdict(self, message: Any) -> None:
        self.verdict = message.type

    def _on_text(self, message: Any) -> None:
        self.texts.append(message.text)

    def _on_version(self, message: Any) -> None:
        number, build = message.flight_sw_version, bytes(message.flight_custom_version).split(b"\0")[0]
        kind = _KINDS.get(number & 0xFF, "")
        self.version = (
            f"{number >> 24}.{number >> 16 & 0xFF}.{number >> 8 & 0xFF}{kind} {build.decode(errors='replace')}"
        )

    # --- said ------------------------------------------------------------------------------------------------------

    def command(self, number: int, *values: float) -> bytes:
        """A command; values that are left out are 0."""
        filled = [*values, *[0.0] * (7 - len(values))]
        return self._pack(mavlink.MAVLink_command_long_message(1, 1, number, 0, *filled))

    def go_to(self, point: Point) -> bytes:
        """A point for mode Guided."""
        lat_e7, lon_e7 = self._degrees_e7(point)
        frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
        return self._pack(
            mavlink.MAVLink_set_position_target_global_int_message(
                0, 1, 1, frame, _POSITION_ALONE, lat_e7, lon_e7, *[0.0] * 9
            )
        )

    def count(self, items: Sequence[Point]) -> bytes:
        """Announces a mission of so many items."""
        return self._pack(mavlink.MAVLink_mission_count_message(1, 1, len(items)))

    def item(self, number: int, point: Point) -> bytes:
        """A waypoint of a mission."""
        lat_e7, lon_e7 = self._degrees_e7(point)
        frame, waypoint = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_CMD_NAV_WAYPOINT
        return self._pack(
            mavlink.MAVLink_mission_item_int_message(
                1, 1, number, frame, waypoint, 0, 1, 0.0, 0.0, 0.0, 0.0, lat_e7, lon_e7, 0.0
            )
        )

    def _degrees_e7(self, point: Point) -> tuple[int, int]:
        lat_deg, lon_deg = self._frame.to_geodetic(*point)
        return round(lat_deg * 1.0e7), round(lon_deg * 1.0e7)

    def _pack(self, message: Any) -> bytes:
        data: bytes = message.pack(self._wire)
        return data


def _ignore(message: Any) -> None:
    """Everything that nobody asks for."""
