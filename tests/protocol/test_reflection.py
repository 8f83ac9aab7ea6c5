"""Nobody floods somebody else by way of the boat, and an honest ground station notices nothing of it.

The stations of these tests are on this computer, which needs no proof; the tests say that it does.
"""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.io.mavlink.wire import links, proof
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, frame, pack
from companion.io.mavlink.wire.proof import ANSWER_FACTOR
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions

HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
LISTS = (
    HEARTBEAT,
    mavlink.MAVLink_param_request_list_message(1, 1),
    mavlink.MAVLink_mission_request_list_message(1, 1, 0),
    mavlink.MAVLink_request_data_stream_message(1, 1, 0, 50, 1),
    mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF),
)


class Far:
    """A program at an address of its own. `answers`: the questions that it sends back, as most ground stations do."""

    def __init__(self, boat: tuple[str, int], answers: tuple[str, ...] = (), system: int = 255) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self._boat, self._answers, self._system = boat, answers, system
        self._framer, self._sequence = Framer(), 0
        self.sent = self.got = 0
        self.messages: list[Any] = []

    def say(self, *messages: Any) -> None:
        for message in messages:
            self._sequence = self._sequence + 1 & 0xFF
            data = frame(pack(message), self._sequence, self._system, 190)
            self.sent += len(data)
            self._socket.sendto(data, self._boat)

    def hear(self) -> None:
        while True:
            try:
                data = self._socket.recv(4096)
            except BlockingIOError:
                return
            self.got += len(data)
            for message in self._framer.feed(data):
                self.messages.append(message)
                self._reply(message)

    def _reply(self, message: Any) -> None:
        if message.get_type() not in self._answers:
            return
        if message.get_type() == "PING":
            self.say(mavlink.MAVLink_ping_message(message.time_usec, message.seq, 1, 1))
        else:
            self.say(mavlink.MAVLink_timesync_message(1_000_000, message.ts1, 1, 1))

    def kinds(self) -> set[str]:
        return {message.get_type() for message in self.messages}

    def parameters(self) -> int:
        return len({m.param_index for m in self.messages if m.get_type() == "PARAM_VALUE"} - {65535})

    def close(self) -> None:
        self._socket.close()


class Boat:
    """A ReVolt in lockstep that listens on UDP."""

    def __init__(self, folder: Path, options: str = "", operators: tuple[int, ...] = ()) -> None:
        config = load_vessel("revolt")
        if operators:
            object.__setattr__(config, "operators", operators)
        world, self._clock = World(config, WorldConditions(seed=5)), SimulatedClock(EPOCH_UNIX_NS)
        self.link: Any = links.open_link(f"udpin:127.0.0.1:0{options}")
        self.vessel = build(config, Surroundings(self._clock, world, world, [self.link], None, folder / "log"))
        self._ticks = 0

    def sail(self, seconds: float, *stations: Far) -> None:
        for _ in range(round(seconds / self.vessel.period_s)):
            self._clock.wait(self._ticks * self.vessel.period_s, ())
            self.vessel.tick(self._clock.now_s())
            self._ticks += 1
            for station in stations:
                station.hear()

    def close(self) -> None:
        self.vessel.close()


@pytest.fixture(autouse=True)
def from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(links, "needs_proof", lambda host: True)


@pytest.fixture
def boat(tmp_path: Path) -> Iterator[Boat]:
    made = Boat(tmp_path)
    yield made
    made.close()


def test_an_address_that_proved_nothing_gets_little_for_what_it_sends(boat: Boat) -> None:
    """For its one heartbeat, for all lists at once, and for guesses of the answer."""
    quiet, greedy, guessing = (Far(boat.link.address) for _ in range(3))
    quiet.say(HEARTBEAT)
    greedy.say(*LISTS)
    guesses = (mavlink.MAVLink_ping_message(n, n, 1, 1) for n in range(50))
    guessing.say(HEARTBEAT, *guesses, mavlink.MAVLink_timesync_message(1, 0, 1, 1), *LISTS)
    boat.sail(8.0, quiet, greedy, guessing)
    for one in (quiet, greedy, guessing):
        assert {"PING", "TIMESYNC"} <= one.kinds()
        assert one.got <= ANSWER_FACTOR * one.sent
        one.close()
    assert "127.0.0.1 has not proved that it hears us" in boat.link.health(8.0).text


@pytest.mark.parametrize("answer", ["PING", "TIMESYNC"])
def test_an_honest_station_gets_everything_as_fast_as_without_the_limit(tmp_path: Path, answer: str) -> None:
    """It waits one round trip, which here is a tick."""
    limited, free = Boat(tmp_path / "limited"), Boat(tmp_path / "free", "?proof=no")
    ours, theirs = Far(limited.link.address, (answer,)), Far(free.link.address)
    for boat, station in ((limited, ours), (free, theirs)):
        station.say(*LISTS)
        boat.sail(1.5, station)
        assert "MISSION_COUNT" in station.kinds() and "ATTITUDE" in station.kinds()
    count = len(limited.vessel.parameters.specs)
    assert ours.parameters() == theirs.parameters() == count
    ours.say(HEARTBEAT)
    limited.sail(0.2, ours)
    texts = [m.text for m in ours.messages if m.get_type() == "STATUSTEXT"]
    assert sum(text.startswith("USV companion") for text in texts) == 1
    assert "PING" not in theirs.kinds()
    assert "proved" not in limited.link.health(1.5).text
    for boat, station in ((limited, ours), (free, theirs)):
        boat.close()
        station.close()


def test_an_operator_and_this_computer_prove_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    boat = Boat(tmp_path / "operators", operators=(250,))
    operator = Far(boat.link.address, system=250)
    operator.say(*LISTS)
    boat.sail(1.5, operator)
    assert operator.parameters() == len(boat.vessel.parameters.specs)
    boat.close()
    operator.close()
    monkeypatch.setattr(links, "needs_proof", proof.needs_proof)
    boat = Boat(tmp_path / "local")
    local = Far(boat.link.address)
    local.say(*LISTS)
    boat.sail(1.5, local)
    assert local.parameters() == len(boat.vessel.parameters.specs)
    boat.close()
    local.close()


@pytest.mark.parametrize(
    ("host", "needs"),
    [
        ("127.0.0.1", False),
        ("127.3.2.1", False),
        ("::1", False),
        ("10.0.0.2", True),
        ("fe80::1%eth0", True),
        ("x", True),
    ],
)
def test_only_this_computer_needs_no_proof(host: str, needs: bool) -> None:
    assert proof.needs_proof(host) is needs
