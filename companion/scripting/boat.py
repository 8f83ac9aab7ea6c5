"""The interface of a script: `main(boat)` gets one `Boat`.

Angles are in radians, but for `_deg`; all else is SI. Whatever the boat refuses raises ScriptError with its words.
While a script waits in `sleep` or `next_state` its heartbeats and its proposed setpoint go on. A script that asks
nothing of this interface for `watchdog_s` counts as hung.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.scripting.client import BOAT_COMPONENT, Client, ScriptError
from companion.scripting.door import Door
from companion.scripting.parameters import decoded, encoded
from companion.scripting.plans import download, upload
from companion.scripting.values import Item, State, moved

_WORDS = {1: "not now", 2: "denied", 3: "not supported", 4: "failed", 6: "cancelled"}
_CHANGE_MODE = 1.0
_LONGEST_NAME = 16  # of a parameter, by MAVLink
# bits of a setpoint's mask that say what to leave out
_NO_PLACE, _NO_VELOCITY, _NO_ACCELERATION = 0b111, 0b111 << 3, 0b111 << 6
_NO_YAW, _NO_RATE = 1 << 10, 1 << 11
_LOCAL_NED, _BODY_FRD, _GLOBAL_INT = 1, 12, 6


class Boat:
    """The boat, as a script has it."""

    def __init__(self, door: Door, system: int, arguments: Sequence[str] = ()) -> None:
        """`system`: MAVLink system id of the script. `arguments`: its words."""
        self.arguments = tuple(arguments)
        self._client = Client(door, system)

    # --- reading ---------------------------------------------------------------------------------------------------

    def connect(self, timeout_s: float = 30.0) -> None:
        """Wait until the boat is heard. Raises ScriptError. The runner does it before `main`."""
        if not self._client.wait_for(lambda: bool(self._client.hello) and self._client.state is not None, timeout_s):
            raise ScriptError(f"no state of the boat within {timeout_s:g} s: its feed is not offered")

    @property
    def state(self) -> State:
        """The newest state."""
        if self._client.state is None:
            raise ScriptError("no state of the boat yet")
        return self._client.state

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the modes."""
        return tuple(str(row["name"]) for row in self._client.hello.get("modes", ()))

    def next_state(self, timeout_s: float = 5.0) -> State:
        """Wait for the next state. Raises ScriptError where none comes."""
        before = self._client.state
        if not self._client.wait_for(lambda: self._client.state is not before, timeout_s):
            raise ScriptError(f"no state of the boat for {timeout_s:g} s")
        return self.state

    def states(self) -> Iterator[State]:
        """Each new state, for ever."""
        while True:
            yield self.next_state()

    def wait_until(self, condition: Callable[[State], bool], timeout_s: float = math.inf) -> bool:
        """Wait until a state fulfils the condition, at most `timeout_s` of the boat's time. Whether one did."""
        end_s = self.state.t_s + timeout_s
        while not condition(self.state):
            if self.next_state().t_s > end_s:
                return False
        return True

    def sleep(self, seconds: float) -> None:
        """Wait so long of the boat's time."""
        end_s = self.state.t_s + seconds
        while self.state.t_s < end_s:
            self.next_state()

    def events(self) -> list[tuple[str, str]]:
        """(name, text) of the events since the last call, the oldest first; at most 200 are kept."""
        events = list(self._client.events)
        self._client.events.clear()
        return events

    def say(self, text: object) -> None:
        """Tell people, as a text (or number) of the boat. One a second, of 100 characters; the rest is left out."""
        self._client.door.tell("say", str(text))

    # --- commands --------------------------------------------------------------------------------------------------

    def command(self, number: int, *params: float, place: tuple[float, float] | None = None) -> None:
        """Any MAV_CMD. `place`: (lat_deg, lon_deg) in params 5 and 6, sent as COMMAND_INT. Raises ScriptError where it
        is not accepted."""
        system = self._client.boat_system
        if place is None:
            seven = (*params, *(0.0,) * 7)[:7]
            message = mavlink.MAVLink_command_long_message(system, BOAT_COMPONENT, number, 0, *seven)
        else:
            four, (x, y) = (*params, *(0.0,) * 4)[:4], (round(degrees * 1e7) for degrees in place)
            message = mavlink.MAVLink_command_int_message(
                system, BOAT_COMPONENT, _GLOBAL_INT, number, 0, 0, *four, x, y, 0.0
            )
        what = f"command {number}"
        answer = self._client.ask(message, lambda m: m.get_type() == "COMMAND_ACK" and m.command == number, what)
        if answer.result != mavlink.MAV_RESULT_ACCEPTED:
            otherwise = _WORDS.get(answer.result, f"result {answer.result}")
            raise ScriptError(f"{what}: {self._client.reason(otherwise)}")

    def set_mode(self, name: str) -> None:
        """Choose a mode by its name."""
        numbers = {str(row["name"]): int(row["px4"]) for row in self._client.hello.get("modes", ())}
        if name not in numbers:
            raise ScriptError(f"no mode {name!r}; there is {', '.join(numbers)}")
        self.command(mavlink.MAV_CMD_DO_SET_MODE, _CHANGE_MODE, float(numbers[name]))

    def arm(self) -> None:
        """Arm, if the checks pass. A script cannot arm by force."""
        self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)

    def disarm(self) -> None:
        """Disarm."""
        self.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)

    def hold(self) -> None:
        """Hold here."""
        self.command(mavlink.MAV_CMD_DO_REPOSITION, -1.0, 1.0, 0.0, math.nan, math.nan, math.nan)

    def go_to(
        self, lat_deg: float, lon_deg: float, yaw_rad: float | None = None, speed_mps: float | None = None
    ) -> None:
        """Go to a place and hold there."""
        yaw, speed = math.nan if yaw_rad is None else yaw_rad, -1.0 if speed_mps is None else speed_mps
        self.command(mavlink.MAV_CMD_DO_REPOSITION, speed, 1.0, 0.0, yaw, place=(lat_deg, lon_deg))

    def change_speed(self, speed_mps: float | None) -> None:
        """Speed of modes that steer by themselves; None: the vessel's own."""
        self.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1.0, -2.0 if speed_mps is None else speed_mps, -1.0)

    # --- missions --------------------------------------------------------------------------------------------------

    def mission(self) -> list[Item]:
        """The mission that is aboard."""
        return download(self._client)

    def upload(self, items: Sequence[Item]) -> None:
        """Replace the mission. Raises ScriptError with the boat's words where it refuses it."""
        upload(self._client, items)

    def start_mission(self, item: int | None = None) -> None:
        """Mission mode, at an item (from 0) where given."""
        if item is not None:
            self.set_current(item)
        self.command(mavlink.MAV_CMD_MISSION_START, 0.0, 0.0)

    def set_current(self, item: int) -> None:
        """Make an item (from 0) the current one."""
        self.command(mavlink.MAV_CMD_DO_SET_MISSION_CURRENT, float(item), 0.0)

    # --- parameters ------------------------------------------------------------------------------------------------

    def parameter(self, name: str) -> float:
        """The value of a parameter. Raises ScriptError where there is none of that name."""
        return decoded(self._known(name))

    def set_parameter(self, name: str, value: float) -> None:
        """Set a parameter. Raises ScriptError where the boat keeps another value, or has none of that name."""
        client = self._client
        known = self._known(name)
        if known.param_type != mavlink.MAV_PARAM_TYPE_REAL32 and not _is_whole(value):
            raise ScriptError(f"{name} takes whole numbers, not {value:g}")
        raw = encoded(known.param_type, value)
        setting = mavlink.MAVLink_param_set_message(
            client.boat_system, BOAT_COMPONENT, name.encode(), raw, known.param_type
        )
        answer = client.ask(setting, lambda m: _is_of(m, name), f"parameter {name}")
        kept = decoded(answer) if answer.get_type() == "PARAM_VALUE" else math.nan
        if not math.isclose(kept, value, rel_tol=1e-6, abs_tol=1e-9):
            raise ScriptError(client.reason(f"{name} is not set to {value:g}"))

    def _known(self, name: str) -> Any:
        """The PARAM_VALUE of a parameter."""
        client, unknown = self._client, ScriptError(f"no parameter {name}")
        if not name.isascii() or not 0 < len(name) <= _LONGEST_NAME:
            raise unknown
        message = mavlink.MAVLink_param_request_read_message(client.boat_system, BOAT_COMPONENT, name.encode(), -1)
        answer = client.ask(message, lambda m: _is_of(m, name), f"parameter {name}")
        if answer.get_type() == "PARAM_ERROR":
            raise unknown
        return answer

    # --- Offboard --------------------------------------------------------------------------------------------------

    def propose_velocity(self, north_mps: float, east_mps: float, yaw_rad: float | None = None) -> None:
        """Propose a velocity over ground for Offboard. It is repeated while the script waits."""
        mask = _NO_PLACE | _NO_ACCELERATION | _NO_RATE | (_NO_YAW if yaw_rad is None else 0)
        self._propose_local(_LOCAL_NED, mask, (north_mps, east_mps), yaw_rad or 0.0, 0.0)

    def propose_motion(self, surge_mps: float, sway_mps: float, yaw_rate_radps: float) -> None:
        """Propose a velocity along the hull and a rate of turn for Offboard. It is repeated while the script waits."""
        mask = _NO_PLACE | _NO_ACCELERATION | _NO_YAW
        self._propose_local(_BODY_FRD, mask, (surge_mps, sway_mps), 0.0, yaw_rate_radps)

    def propose_place(self, lat_deg: float, lon_deg: float, yaw_rad: float | None = None) -> None:
        """Propose a place for Offboard. It is repeated while the script waits."""
        mask = _NO_VELOCITY | _NO_ACCELERATION | _NO_RATE | (_NO_YAW if yaw_rad is None else 0)
        x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)

        def make() -> Any:
            place = (x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, yaw_rad or 0.0, 0.0)
            return mavlink.MAVLink_set_position_target_global_int_message(
                self._boot_ms(), self._client.boat_system, BOAT_COMPONENT, _GLOBAL_INT, mask, *place
            )

        self._client.propose(make)

    def stop_proposing(self) -> None:
        """Propose nothing any more. A boat in Offboard then does what OFFB_LOSS_ACT says."""
        self._client.propose(None)

    def _propose_local(self, frame: int, mask: int, velocity: tuple[float, float], yaw: float, rate: float) -> None:
        def make() -> Any:
            values = (0.0, 0.0, 0.0, *velocity, 0.0, 0.0, 0.0, 0.0, yaw, rate)
            return mavlink.MAVLink_set_position_target_local_ned_message(
                self._boot_ms(), self._client.boat_system, BOAT_COMPONENT, frame, mask, *values
            )

        self._client.propose(make)

    def _boot_ms(self) -> int:
        return int(self.state.t_s * 1000.0) & 0xFFFFFFFF

    # --- geometry --------------------------------------------------------------------------------------------------

    @staticmethod
    def moved(lat_deg: float, lon_deg: float, north_m: float, east_m: float) -> tuple[float, float]:
        """The place so many metres north and east of another, (lat_deg, lon_deg)."""
        return moved(lat_deg, lon_deg, north_m, east_m)


def _is_of(message: Any, name: str) -> bool:
    """Whether a message tells of that parameter: its value, or why there is none."""
    return message.get_type() in ("PARAM_VALUE", "PARAM_ERROR") and bool(message.param_id == name)


def _is_whole(value: float) -> bool:
    """Whether a parameter of MAVLink's INT32 holds it."""
    return abs(value) < 2.0**31 and value == round(value)
