"""One boat over MAVSDK: connect to it, command it, read why it refuses.

    with connected("udpin://0.0.0.0:14550") as boat:
        boat.do("hold")
        boat.do("arm")
        boat.go_to(63.4390, 10.3991, heading_deg=45.0)

MAVSDK's own plug-ins (Action, MissionRaw, Param, …) work on `boat.system` as on any vehicle. The commands here go
through MavlinkDirect, since most of them are particular to this boat.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from mavsdk import ComponentType, Configuration, ConnectionResult, Mavsdk, System, log_subscribe
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkDirectError, MavlinkMessage
from mavsdk.plugins.telemetry import Telemetry

from gcs_plugins.commands import BY_NAME, MODES, MavCmd

DO_REPOSITION = 192
_CHANGE_MODE = 1.0
_ARDUPILOT = 3
_ARMED = 0x80
_WARNING = 3  # of MAVSDK's StatusTextType, which counts upwards in severity
_REASON_S = 1.5
_RESULTS = {1: "not now", 2: "denied", 3: "not supported", 4: "failed", 5: "still in progress", 6: "cancelled"}


class Mistake(Exception):
    """The command cannot be sent; the text gives the remedy."""


class NoVessel(Exception):
    """No boat answers, or no longer."""


class Refused(Exception):
    """The boat refused; the text is its reason."""


@contextmanager
def connected(link: str, timeout_s: float = 10.0) -> Iterator[Boat]:
    """The first boat heard on a MAVSDK connection URL. Raises Mistake for the URL, NoVessel for silence."""
    log_subscribe(lambda *_: True)  # MAVSDK would write to the terminal
    with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        result = sdk.add_any_connection(link)
        if result != ConnectionResult.SUCCESS:
            raise Mistake(
                f"link {link}: {result.name.lower().replace('_', ' ')}; as udpin://0.0.0.0:14550 or tcpout://HOST:5760"
            )
        system = sdk.first_autopilot(timeout_s)
        if system is None:
            raise NoVessel(f"no boat heard on {link} in {timeout_s:g} s (does another ground station hold that port?)")
        yield Boat(system)


class Boat:
    """Remembers the boat's texts, and the newest message of each kind that was subscribed to by `listen`."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.system_id: int = system.get_system_id()
        self._direct = MavlinkDirect(system)
        self._news = threading.Condition()
        self._texts: list[tuple[int, str]] = []
        self._newest: dict[str, Mapping[str, Any]] = {}
        self._telemetry = Telemetry(system)  # unsubscribes when it is collected
        self._telemetry.subscribe_status_text(self._said)
        self.listen("HEARTBEAT")

    # --- commanding ------------------------------------------------------------------------------------------------

    def do(self, name: str) -> None:
        """One action of the table. Raises Refused with the boat's reason."""
        action = BY_NAME[name]
        self.command(action.command, *action.all_params(self.rover_numbers))

    def set_mode(self, name: str) -> None:
        """A mode by its name in the table."""
        numbers = MODES[name]
        self.command(MavCmd.DO_SET_MODE, 1.0, float(numbers.rover if self.rover_numbers else numbers.px4))

    def go_to(self, lat_deg: float, lon_deg: float, heading_deg: float = math.nan, speed_mps: float = math.nan) -> None:
        """Go there and hold. NaN: the boat chooses the heading or the speed."""
        place = {"frame": 0, "x": round(lat_deg * 1e7), "y": round(lon_deg * 1e7), "z": 0.0}
        speed = -1.0 if math.isnan(speed_mps) else speed_mps
        self.command(DO_REPOSITION, speed, _CHANGE_MODE, 0.0, math.radians(heading_deg), place=place)

    def command(self, number: int, *params: float, place: Mapping[str, Any] | None = None) -> None:
        """A COMMAND_LONG, or a COMMAND_INT with a `place`. Waits for the answer; raises Refused, or NoVessel when none
        comes."""
        fields: dict[str, Any] = {
            f"param{n}": None if math.isnan(value) else value for n, value in enumerate(params, start=1)
        }
        fields |= {f"param{n}": 0.0 for n in range(len(params) + 1, 5 if place else 8)}
        fields |= {"target_system": self.system_id, "target_component": 1, "command": int(number), "confirmation": 0}
        if place is not None:
            fields |= {"current": 0, "autocontinue": 0, **place}
        heard = len(self._texts)
        kind = "COMMAND_LONG" if place is None else "COMMAND_INT"
        try:
            answer = self._direct.send_command(MavlinkMessage(kind, 0, 0, self.system_id, 1, json.dumps(fields)))
        except MavlinkDirectError as error:
            raise NoVessel(f"command {int(number)}: {error.result.name.lower().replace('_', ' ')}") from error
        result = json.loads(answer.fields_json)["result"]
        if result != 0:
            raise Refused(self.reason(heard) or _RESULTS.get(result, f"result {result}"))

    def send(self, kind: str, **fields: Any) -> None:
        """Send any message, without waiting for an acknowledgement."""
        fields = {"target_system": self.system_id, "target_component": 1, **fields}
        self._direct.send_message(MavlinkMessage(kind, 0, 0, self.system_id, 1, json.dumps(fields)))

    # --- hearing ---------------------------------------------------------------------------------------------------

    def listen(self, *kinds: str) -> None:
        """Keep the newest message of these kinds for `newest`."""
        for kind in kinds:
            self._direct.subscribe_message(kind, self._heard)

    def newest(self, kind: str) -> Mapping[str, Any] | None:
        """Fields of the newest message; None before the first."""
        return self._newest.get(kind)

    def forget(self, kind: str) -> None:
        """Drop the newest message, so that `newest` gives only a later one."""
        self._newest.pop(kind, None)

    def wait(self, condition: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until a message makes `condition` true; False when none does in that time."""
        with self._news:
            return self._news.wait_for(condition, timeout_s)

    def wait_next(self, kind: str, timeout_s: float) -> None:
        """Wait for the next message of a kind that was subscribed to, at most so long."""
        seen = self._newest.get(kind)
        self.wait(lambda: self._newest.get(kind) is not seen, timeout_s)

    def reason(self, since: int) -> str:
        """The boat's warnings since `texts_heard` was `since`, after a short wait for them; empty when there are
        none."""
        self.wait(lambda: bool(self._warnings(since)), _REASON_S)
        return "; ".join(dict.fromkeys(self._warnings(since)))

    @property
    def texts_heard(self) -> int:
        """How many texts the boat has sent so far."""
        return len(self._texts)

    @property
    def rover_numbers(self) -> bool:
        """The link has the ardupilot persona: Rover's mode numbers, home as mission item 0."""
        return bool(self._heartbeat["autopilot"] == _ARDUPILOT)

    @property
    def armed(self) -> bool:
        """Whether the newest heartbeat says that the boat is armed."""
        return bool(self._heartbeat["base_mode"] & _ARMED)

    @property
    def mode(self) -> str:
        """The mode's name."""
        number = self._heartbeat["custom_mode"]
        names = {numbers.rover if self.rover_numbers else numbers.px4: name for name, numbers in MODES.items()}
        return names.get(number, f"mode {number}")

    @property
    def _heartbeat(self) -> Mapping[str, Any]:
        if not self.wait(lambda: "HEARTBEAT" in self._newest, 5.0):
            raise NoVessel("no heartbeat in 5 s")
        return self._newest["HEARTBEAT"]

    def _warnings(self, since: int) -> list[str]:
        return [text for severity, text in self._texts[since:] if severity >= _WARNING]

    def _said(self, text: Any, _: Any) -> None:
        with self._news:
            self._texts.append((int(text.type), text.text))
            self._news.notify_all()

    def _heard(self, message: MavlinkMessage, _: Any) -> None:
        if message.component_id != 1:
            return
        with self._news:
            self._newest[message.message_name] = {**json.loads(message.fields_json), "heard_s": time.monotonic()}
            self._news.notify_all()
