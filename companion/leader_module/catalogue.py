"""What a ground station requests when it connects to a leader module: three modes, read-only parameters, no plans.

QGroundControl needs this to finish its connection.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Any

from companion.core.decision import ModeId
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import PX4
from companion.params.spec import ParamSpec
from companion.params.table import TABLE

MODES: tuple[tuple[ModeId, str], ...] = (
    (ModeId.MANUAL, "Manual"),
    (ModeId.OFFBOARD, "Remote"),
    (ModeId.FOLLOW, "Follow"),
)
"""What the crew can ask for, as modes: Remote has PX4's number of Offboard."""

_ALL = -1


class Catalogue:
    """Answers a ground station's requests for modes, parameters and plans."""

    def __init__(self, system: int) -> None:
        self._system = system
        looked_up = [spec for spec in TABLE if spec.group == "Compatibility"]
        self._parameters: list[tuple[ParamSpec, int]] = [(spec, int(spec.default)) for spec in looked_up]
        self._parameters += [(spec, system) for spec in TABLE if spec.name == "MAV_SYS_ID"]

    def modes(self, index: int) -> Sequence[Any]:
        """AVAILABLE_MODES of `index`, or of all for 0; nothing for an unknown index."""
        wanted = range(1, len(MODES) + 1) if index == 0 else (index,)
        return [self._mode(number) for number in wanted if 1 <= number <= len(MODES)]

    def answers(self, message: Any) -> Sequence[Any]:
        """Answers to a request that is addressed to the module."""
        if getattr(message, "target_system", 0) not in (0, self._system):
            return ()
        match message.get_type():
            case "PARAM_REQUEST_LIST":
                return self._values(_ALL)
            case "PARAM_REQUEST_READ":
                return (
                    self._values(message.param_index) if message.param_index != _ALL else self._named(message.param_id)
                )
            case "PARAM_SET":
                return self._named(message.param_id)  # the unchanged value: none can be set
            case "MISSION_REQUEST_LIST":
                return [
                    mavlink.MAVLink_mission_count_message(
                        message.get_srcSystem(), message.get_srcComponent(), 0, message.mission_type
                    )
                ]
            case "MISSION_COUNT":
                refused, source = mavlink.MAV_MISSION_UNSUPPORTED, (message.get_srcSystem(), message.get_srcComponent())
                return [mavlink.MAVLink_mission_ack_message(*source, refused, message.mission_type)]
        return ()

    def _mode(self, number: int) -> Any:
        mode, name = MODES[number - 1]
        return mavlink.MAVLink_available_modes_message(
            len(MODES), number, 0, PX4.custom_mode(mode), 0, name.encode("ascii")
        )

    def _named(self, name: str) -> Sequence[Any]:
        found = next((i for i, (spec, _) in enumerate(self._parameters) if spec.name == name), None)
        return () if found is None else self._values(found)

    def _values(self, index: int) -> Sequence[Any]:
        """PARAM_VALUE, with integers bytewise in the float field, as PX4 sends them."""
        wanted = (
            range(len(self._parameters)) if index == _ALL else (index,) if 0 <= index < len(self._parameters) else ()
        )
        kind, count = mavlink.MAV_PARAM_TYPE_INT32, len(self._parameters)
        return [
            mavlink.MAVLink_param_value_message(
                spec.name.encode("ascii"), struct.unpack("<f", struct.pack("<i", value))[0], kind, count, i
            )
            for i, (spec, value) in ((i, self._parameters[i]) for i in wanted)
        ]
