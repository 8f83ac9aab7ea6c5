"""A ground station's desk in lockstep: messages in, the vessel serves its links, messages out, and time moves only when
told to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from companion.cli.rig import LockstepRig
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, UnknownMessage, frame, pack
from sitl.scenarios.rig import Conditions

ITEM_FIELDS = (
    "seq",
    "frame",
    "command",
    "autocontinue",
    "param1",
    "param2",
    "param3",
    "param4",
    "x",
    "y",
    "z",
    "mission_type",
)
"""Of a mission item: what comes back as it was sent."""


class Sender:
    """Packs with a sequence number of its own, as another system."""

    def __init__(self, system: int = 255, component: int = 190) -> None:
        self.system, self.component, self._seq = system, component, 0

    def packed(self, message: Any) -> bytes:
        self._seq = (self._seq + 1) % 256
        return frame(pack(message), self._seq, self.system, self.component)


class Desk:
    """One ground station over the memory link of a whole vessel. Every byte passes through framing, both ways."""

    def __init__(
        self, folder: Path, rig: LockstepRig | None = None, system: int = 255, link: str = "memory:desk"
    ) -> None:
        """`link`: the URL of the memory link, where the desk makes the vessel itself."""
        self.rig = rig or LockstepRig(Conditions("revolt", seed=3), folder / "log", link=link)
        self.vessel = self.rig.vessel
        self._framer = Framer()
        self._sender = Sender(system)
        self.received: list[Any] = []

    def tell(self, *messages: Any) -> list[Any]:
        """Send, let the vessel serve its links without any time passing, return what it answered."""
        for message in messages:
            self.rig.send(self._sender.packed(message))
        self.vessel.serve(self.rig.now_s)
        return self._take()

    def tick(self, count: int = 1) -> list[Any]:
        """Ticks of the vessel, and what it sent in them."""
        messages: list[Any] = []
        for _ in range(count):
            self.rig.step()
            messages += self._take()
        return messages

    def until(self, what: str, condition: Callable[[], bool], timeout_s: float = 60.0) -> None:
        end_s = self.rig.now_s + timeout_s
        while not condition():
            assert self.rig.now_s < end_s, f"{what}: not within {timeout_s:g} s of the boat's time"
            self.tick()

    def latest(self, kind: str) -> Any:
        return next((message for message in reversed(self.received) if message.get_type() == kind), None)

    def texts(self) -> list[str]:
        return [message.text for message in self.received if message.get_type() == "STATUSTEXT"]

    def ready(self) -> None:
        self.heartbeat()
        self.until("ready to arm", lambda: not self.vessel.supervisor.status(self.rig.now_s).arming_refusals)

    def heartbeat(self) -> list[Any]:
        return self.tell(mavlink.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3))

    def command(self, number: int, *params: float) -> list[Any]:
        padded = (*params, *(0.0 for _ in range(7 - len(params))))
        return self.tell(mavlink.MAVLink_command_long_message(1, 1, number, 0, *padded))

    def result(self, number: int, *params: float) -> int:
        """Of a COMMAND_LONG; there must be exactly one acknowledgement."""
        acks = of(self.command(number, *params), "COMMAND_ACK")
        assert [ack.command for ack in acks] == [number]
        return int(acks[0].result)

    def upload(self, items: Sequence[Any], kind: int = 0) -> int:
        """MAV_MISSION_RESULT of the vessel."""
        answers = self.tell(mavlink.MAVLink_mission_count_message(1, 1, len(items), kind))
        while True:
            for answer in answers:
                if answer.get_type() == "MISSION_ACK":
                    return int(answer.type)
                if answer.get_type() == "MISSION_REQUEST_INT":
                    answers = self.tell(items[answer.seq])
                    break
            else:
                raise AssertionError("the vessel neither asks nor acknowledges")

    def close(self) -> None:
        self.rig.close()

    def _take(self) -> list[Any]:
        messages = [m for m in self._framer.feed(self.rig.receive()) if not isinstance(m, UnknownMessage)]
        self.received += messages
        return messages


def of(messages: Sequence[Any], kind: str) -> list[Any]:
    return [message for message in messages if message.get_type() == kind]


@contextmanager
def rover_desk(folder: Path) -> Iterator[Desk]:
    """The desk of a ground station that takes the boat for ArduPilot's Rover, after the first tick."""
    desk = Desk(folder, link="memory:desk?dialect=ardupilot")
    desk.tick()
    yield desk
    desk.close()
