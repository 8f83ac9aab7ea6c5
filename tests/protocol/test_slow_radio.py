"""A telemetry radio whose serial port takes more than its air carries, as ExpressLRS at 460,800 baud and RFD900 at long
range: what does not fit into its buffer is lost in the middle of packets. It reports how full that is."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import pytest

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer
from companion.io.mavlink.wire.links import StreamLink
from companion.io.mavlink.wire.personas import PX4
from companion.params.table import TABLE
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests.protocol.desk import Sender

BUFFER = 2048
SLICE_S = 0.02
REPORT_S = 0.5
LEARNT_S, DURATION_S = 10.0, 120.0


class Radio:
    """A stream to the radio on the boat. `far(now_s)`: what has come through the air."""

    name = "radio"

    def __init__(self, air_bytes_per_s: float) -> None:
        self._air = air_bytes_per_s
        self._buffer = bytearray()
        self._in = bytearray()
        self._sender = Sender(51, 68)
        self._reported_s = self._aired_s = 0.0
        self.lost = 0

    def read(self, now_s: float) -> list[tuple[float, bytes]]:
        if now_s - self._reported_s >= REPORT_S:
            self._reported_s = now_s
            free = 100 * (BUFFER - len(self._buffer)) // BUFFER
            self._in += self._sender.packed(mavlink.MAVLink_radio_status_message(200, 200, free, 20, 20, 0, 0))
        data, self._in = bytes(self._in), bytearray()
        return [(now_s, data)] if data else []

    def write(self, data: bytes, now_s: float) -> None:
        room = BUFFER - len(self._buffer)
        self._buffer += data[:room]
        self.lost += max(0, len(data) - room)

    def far(self, now_s: float) -> bytes:
        most = round((now_s - self._aired_s) * self._air)
        self._aired_s += most / self._air
        data, self._buffer = bytes(self._buffer[:most]), self._buffer[most:]
        return data

    def up(self, data: bytes) -> None:
        self._in += data

    def fault(self) -> str | None:
        return None

    def fileno(self) -> int | None:
        return None

    def close(self) -> None:
        pass


class Client:
    """A ground station that reads all parameters, and asks again for those that it misses."""

    def __init__(self, radio: Radio) -> None:
        self._radio, self._framer, self._sender = radio, Framer(), Sender(255)
        self.at: dict[str, list[float]] = {}
        self.values: set[int] = set()
        self.arrived = 0
        self.loaded_s = 0.0
        self._beat_s = self._asked_s = -9.0

    def step(self, now_s: float) -> None:
        data = self._radio.far(now_s)
        self.arrived += len(data)
        for message in self._framer.feed(data):
            self.at.setdefault(message.get_type(), []).append(now_s)
            if message.get_type() == "PARAM_VALUE":
                self.values.add(message.param_index)
                self._asked_s = now_s
        if len(self.values) == len(TABLE) and not self.loaded_s:
            self.loaded_s = now_s
        if now_s - self._beat_s >= 1.0:
            self._beat_s = now_s
            self._radio.up(self._sender.packed(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)))
        if now_s - self._asked_s >= 1.0 and not self.loaded_s:
            self._asked_s = now_s
            for message in self._questions():
                self._radio.up(self._sender.packed(message))

    def _questions(self) -> list[Any]:
        if not self.values:
            return [mavlink.MAVLink_param_request_list_message(1, 1)]
        missing = (index for index in range(len(TABLE)) if index not in self.values)
        return [mavlink.MAVLink_param_request_read_message(1, 1, b"", index) for index in itertools.islice(missing, 10)]


@pytest.mark.parametrize(("line", "air"), [(46_080.0, 1200.0), (5760.0, 1000.0)])
def test_what_the_radio_cannot_pass_on_is_not_sent(tmp_path: Path, line: float, air: float) -> None:
    """All parameters are asked for. Once the boat has learnt what the radio can do, next to nothing is lost."""
    config, clock, radio = load_vessel("revolt"), SimulatedClock(EPOCH_UNIX_NS), Radio(air)
    links = [StreamLink("serial:radio:460800", radio, PX4, line)]
    world = World(config, WorldConditions(seed=6))
    vessel = build(config, Surroundings(clock, world, world, links, None, tmp_path / "log"))
    client = Client(radio)
    learnt: tuple[int, int] | None = None
    for n in range(round(DURATION_S / SLICE_S)):
        clock.wait(n * SLICE_S, ())
        now_s = clock.now_s()
        client.step(now_s)
        if learnt is None and now_s >= LEARNT_S:
            learnt = radio.lost, client.arrived
        if n % 5 == 0:
            vessel.tick(now_s)
        else:
            vessel.serve(now_s)
    vessel.close()
    assert learnt is not None
    lost, arrived = radio.lost - learnt[0], client.arrived - learnt[1]
    longest = {kind: max(b - a for a, b in itertools.pairwise(client.at[kind])) for kind in ("HEARTBEAT", "ATTITUDE")}
    print(
        f"{line:.0f} on the line, {air:.0f} in the air: lost {learnt[0]} bytes in {LEARNT_S:.0f} s, then "
        f"{100.0 * lost / (lost + arrived):.2f} %; {len(client.values)} of {len(TABLE)} parameters in {client.loaded_s:.0f} s; "
        f"{client.arrived / DURATION_S:.0f} bytes/s arrived; longest without heartbeat {longest['HEARTBEAT']:.1f} s, "
        f"without attitude {longest['ATTITUDE']:.1f} s"
    )
    assert lost < 0.01 * (lost + arrived)
    assert client.loaded_s and longest["HEARTBEAT"] < 2.5 and longest["ATTITUDE"] < 4.0
    assert client.arrived / DURATION_S > 0.8 * air, "the air is used"
