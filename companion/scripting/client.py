"""A script as a MAVLink client: requests with their answers, heartbeats, and the setpoint that it keeps proposing.

One thread, no time of its own: all that goes on while a script waits goes on in `Client.pump`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.scripting.door import Door
from companion.scripting.values import State, state_of

COMPONENT = 191  # MAV_COMP_ID_ONBOARD_COMPUTER
BOAT_COMPONENT = 1
_HEARTBEAT_S, _PROPOSE_S = 1.0, 0.2
_ANSWER_S, _TRIES = 1.0, 4
_REASON_S = 0.3  # in which the boat's words follow its answer
_ERROR = 3  # MAV_SEVERITY_ERROR: refusals
_IN_PROGRESS = 5
_MOST_EVENTS = 200
_LONGEST_WAIT_S = 0.2

Answers = Callable[[Any], bool]


class ScriptError(Exception):
    """What the boat refuses or does not answer; one line with its words."""


class Client:
    """`state`: the newest of the feed. `hello`: what the feed says of the boat at first. `events`: names and texts of
    the newest events that nobody has taken yet."""

    def __init__(self, door: Door, system: int) -> None:
        """`system`: MAVLink system id of the script."""
        self.door = door
        self.state: State | None = None
        self.hello: Mapping[str, Any] = {}
        self.boat: Mapping[str, Any] = {}
        self.events: deque[tuple[str, str]] = deque(maxlen=_MOST_EVENTS)
        self.proposal: Callable[[], Any] | None = None
        self._out = mavlink.MAVLink(None, srcSystem=system, srcComponent=COMPONENT)
        self._in = mavlink.MAVLink(None)
        self._in.robust_parsing = True
        self._heard: list[Any] = []
        self._words: list[str] = []
        self._beat_s = self._proposed_s = float("-inf")

    @property
    def boat_system(self) -> int:
        """MAVLink system id of the boat."""
        return int(self.hello.get("system", 1))

    def propose(self, make: Callable[[], Any] | None) -> None:
        """Send the message of `make()` now and 5 times a second while the script waits; None: no more."""
        self.proposal = make
        self._proposed_s = float("-inf")
        self._repeat(self.door.now_s())

    def send(self, message: Any) -> None:
        """Send a message to the boat."""
        packet = bytes(message.pack(self._out))
        self._out.seq = (self._out.seq + 1) % 256
        self.door.send(packet)

    def pump(self, timeout_s: float) -> None:
        """Take in what comes within `timeout_s`, at most once; send what is due."""
        self._repeat(self.door.now_s())
        arrived = self.door.wait(min(timeout_s, _LONGEST_WAIT_S))
        for message in self._in.parse_buffer(arrived.packets) or () if arrived.packets else ():
            self._take(message)
        for line in arrived.lines:
            self._read(line)
        self._repeat(self.door.now_s())

    def wait_for(self, done: Callable[[], bool], timeout_s: float) -> bool:
        """Wait until `done()`, at most so long. Whether it came."""
        end_s = self.door.now_s() + timeout_s
        while not done():
            left_s = end_s - self.door.now_s()
            if left_s <= 0.0:
                return False
            self.pump(left_s)
        return True

    def ask(self, message: Any, answers: Answers, what: str) -> Any:
        """Send a message until the boat answers. Raises ScriptError where it does not. An answer "in progress" counts
        as a sign of life."""
        for _ in range(_TRIES):
            self._heard.clear()
            self._words.clear()
            self.send(message)
            if (found := self._answer(answers)) is not None:
                return found
        raise ScriptError(f"{what}: the boat does not answer")

    def _answer(self, answers: Answers) -> Any:
        end_s = self.door.now_s() + _ANSWER_S
        while (left_s := end_s - self.door.now_s()) > 0.0:
            self.pump(left_s)
            for message in self._heard:
                if answers(message):
                    if getattr(message, "result", None) != _IN_PROGRESS:
                        return message
                    end_s = self.door.now_s() + _ANSWER_S
            self._heard.clear()
        return None

    def reason(self, otherwise: str) -> str:
        """What the boat says beside its answer."""
        end_s = self.door.now_s() + _REASON_S
        while not self._words and (left_s := end_s - self.door.now_s()) > 0.0:
            self.pump(left_s)
        return "; ".join(dict.fromkeys(self._words)) or otherwise

    def _take(self, message: Any) -> None:
        if message.get_type() == "BAD_DATA" or message.get_srcSystem() != self.boat_system:
            return
        if message.get_type() == "STATUSTEXT":
            self._read_text(message)
        elif getattr(message, "target_system", self._out.srcSystem) == self._out.srcSystem:
            self._heard.append(message)

    def _read_text(self, message: Any) -> None:
        """A refusal's words; a long text comes in several messages."""
        if message.severity > _ERROR:
            return
        if getattr(message, "id", 0) and message.chunk_seq > 0 and self._words:
            self._words[-1] += message.text
        else:
            self._words.append(message.text)

    def _read(self, line: Mapping[str, Any]) -> None:
        match line.get("kind"):
            case "tick":
                self.state = state_of(line)
            case "hello":
                self.hello = line
            case "boat":
                self.boat = line
            case "event":
                self.events.append((str(line["name"]), str(line["text"])))

    def _repeat(self, now_s: float) -> None:
        """Heartbeat and proposal, where they are due."""
        if now_s - self._beat_s >= _HEARTBEAT_S:
            self._beat_s = now_s
            self.send(
                mavlink.MAVLink_heartbeat_message(
                    mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
                    mavlink.MAV_AUTOPILOT_INVALID,
                    0,
                    0,
                    mavlink.MAV_STATE_ACTIVE,
                    3,
                )
            )
        if self.proposal is not None and now_s - self._proposed_s >= _PROPOSE_S:
            self._proposed_s = now_s
            self.send(self.proposal())
