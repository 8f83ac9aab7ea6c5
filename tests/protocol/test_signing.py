"""Signatures on a whole vessel: what a stranger sends changes not one byte of what it does, and real clients set keys
and keep them."""

from __future__ import annotations

import contextlib
import hashlib
import random
import time
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, frame, pack
from companion.io.mavlink.wire.links import MemoryLink
from companion.io.mavlink.wire.signing import SignatureVerdict, Signing, SigningState
from companion.record.signing_file import read_signing, write_signing
from companion.record.state_file import StateFile
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import Companion
from tests.waiting import CAP_S, wait_until

KEY, OTHER_KEY = bytes(range(32)), bytes(range(1, 33))
EACH = 10_000
LOGS = ("ticks.csv", "log.mcap", "events.csv", "telemetry.tlog")


class Signer:
    """A station that signs by a clock of its own."""

    def __init__(self, clock: SimulatedClock, key: bytes | None, ahead_ns: int = 0) -> None:
        self._signing = Signing(lambda: clock.time_unix_ns() + ahead_ns, SigningState(key, 0), lambda state: None)
        self._sequence = 0

    def packed(self, message: Any, link: int = 0) -> bytes:
        packed = pack(message)
        self._sequence = self._sequence + 1 & 0xFF
        return self._signing.sign(frame(packed, self._sequence, 255, 190), packed.crc_extra, link)


class Guarded:
    """A ReVolt in lockstep whose one link asks for signatures, its station, and a stranger who hears all and may say
    anything."""

    def __init__(self, folder: Path) -> None:
        self.folder, config = folder, load_vessel("revolt")
        world, self.clock = World(config, WorldConditions(seed=5)), SimulatedClock(EPOCH_UNIX_NS)
        write_signing(folder, KEY, 0)
        self.state = StateFile(folder)
        self.link = MemoryLink("memory:air?signing=require")
        self.vessel = build(config, Surroundings(self.clock, world, world, [self.link], self.state, folder / "log"))
        self.station = Signer(self.clock, KEY)
        self.heard: list[bytes] = []  # what the stranger overheard of the station
        self.acks: list[tuple[int, int]] = []
        self._framer, self._ticks = Framer(), 0

    def say(self, *messages: Any) -> None:
        for message in messages:
            self.heard.append(self.station.packed(message))
            self.link.to_vessel(self.heard[-1])

    def tick(self, count: int) -> None:
        for _ in range(count):
            self.clock.wait(self._ticks * self.vessel.period_s, ())
            self.vessel.tick(self.clock.now_s())
            self._ticks += 1
            if self._ticks % 10 == 0:
                self.say(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
            sent = self._framer.feed(self.link.from_vessel())
            self.acks += [(m.command, m.result) for m in sent if m.get_type() == "COMMAND_ACK"]

    def close(self) -> dict[str, bytes]:
        self.vessel.close()
        self.state.close()
        return {name: (self.folder / "log" / name).read_bytes() for name in LOGS}


def harm(draws: random.Random) -> Any:
    """Something that would change the vessel."""
    return draws.choice(
        (
            mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3),
            mavlink.MAVLink_command_long_message(1, 1, 400, 0, draws.randrange(2), 21196, 0, 0, 0, 0, 0),
            mavlink.MAVLink_set_mode_message(1, 1, draws.choice((0x00010000, 0x05040000))),
            mavlink.MAVLink_param_set_message(1, 1, b"PATH_BW_SURGE", draws.uniform(0.2, 0.6), 9),
            mavlink.MAVLink_mission_clear_all_message(1, 1, 255),
            mavlink.MAVLink_manual_control_message(1, 1000, 1000, 1000, 1000, 0),
            mavlink.MAVLink_setup_signing_message(1, 1, list(OTHER_KEY), 2**47),
            mavlink.MAVLink_ping_message(1, draws.randrange(1000), 0, 0),
        )
    )


def attack(boat: Guarded, draws: random.Random, count: int) -> int:
    """`count` packets of each of five kinds."""
    nobody, stranger = Signer(boat.clock, None), Signer(boat.clock, OTHER_KEY)
    packets = []
    for _ in range(count):
        packets.append(nobody.packed(harm(draws)))
        packets.append(stranger.packed(harm(draws), draws.randrange(256)))
        packets.append(draws.choice(boat.heard))
        future = bytearray(draws.choice(boat.heard))
        future[-13], future[-12:-6] = draws.randrange(256), draws.randrange(2**47, 2**48).to_bytes(6, "little")
        packets.append(bytes(future))
        flipped = bytearray(draws.choice(boat.heard))
        flipped[draws.randrange(3, len(flipped))] ^= 1 << draws.randrange(
            8
        )  # the length and the flag would hide the neighbours, on any link
        packets.append(bytes(flipped))
    for packet in packets:
        boat.link.to_vessel(packet)
    return len(packets)


def sail(folder: Path, attacked: int) -> tuple[Guarded, dict[str, bytes]]:
    boat, draws = Guarded(folder), random.Random(11)
    boat.tick(100)
    boat.say(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    boat.tick(2)
    boat.say(mavlink.MAVLink_command_long_message(1, 1, 176, 0, 1, 4, 3, 0, 0, 0, 0))
    for _ in range(20):
        if attacked:
            attack(boat, draws, attacked // 20)
        boat.tick(2)
    boat.say(mavlink.MAVLink_param_set_message(1, 1, b"PATH_BW_SURGE", 0.5, 9))
    boat.say(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 0, 0, 0, 0, 0, 0, 0))
    boat.tick(5)
    return boat, boat.close()


def test_fifty_thousand_bad_packets_change_not_a_byte_and_lock_nobody_out(tmp_path: Path) -> None:
    """The same day twice, with and without them: all logs are the same, tick by tick and packet by packet."""
    (tmp_path / "calm").mkdir()
    (tmp_path / "attacked").mkdir()
    calm, quiet = sail(tmp_path / "calm", 0)
    boat, loud = sail(tmp_path / "attacked", EACH)
    assert [ack for ack in calm.acks if ack[0] in (400, 176)] == [
        (400, 0),
        (176, 0),
        (400, 0),
    ] and calm.acks == boat.acks
    refused = boat.link.guard.refused
    print(refused)
    assert (
        refused[SignatureVerdict.UNSIGNED] >= EACH
        and refused[SignatureVerdict.STALE] >= EACH
        and refused[SignatureVerdict.FORGED] >= 2 * EACH
    )
    assert calm.link.guard.refused == {}
    for name in LOGS:
        assert quiet[name] == loud[name], name
    assert KEY not in loud["telemetry.tlog"] and len(quiet["ticks.csv"].splitlines()) > 140


def test_a_station_from_the_future_locks_nobody_out_of_a_boat_with_satellite_time(tmp_path: Path) -> None:
    boat = Guarded(tmp_path)
    boat.tick(50)
    wrong = Signer(boat.clock, KEY, ahead_ns=10 * 366 * 86_400 * 10**9)
    boat.link.to_vessel(wrong.packed(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0), 7))
    boat.tick(5)
    newcomer = Signer(boat.clock, KEY)
    boat.link.to_vessel(newcomer.packed(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0), 8))
    boat.tick(2)
    assert boat.link.guard.refused == {SignatureVerdict.AHEAD: 1}
    assert boat.acks == [(400, 0)]
    boat.close()


def stamp_now() -> int:
    return int((time.time() - 1_420_070_400) * 1e5)


def station(port: int, key: bytes | None) -> Any:
    """pymavlink as a ground station; with a key it signs, and takes nothing else."""
    made = mavutil.mavlink_connection(f"tcp:127.0.0.1:{port}", source_system=254, dialect="common")
    assert made.wait_heartbeat(timeout=CAP_S) is not None  # by which it learns that this is MAVLink 2
    if key is not None:
        made.setup_signing(key, sign_outgoing=True, initial_timestamp=stamp_now())
    return made


def asked(by: Any) -> int:
    """A ping of the vessel; its number."""
    number = random.randrange(1, 2**31)
    by.mav.ping_send(0, number, 0, 0)
    return number


def answers(by: Any) -> list[int]:
    """The numbers of all pings that have been answered by now."""
    return [message.seq for message in iter(lambda: by.recv_match(type="PING", blocking=False), None)]


def answered(by: Any) -> None:
    """Waits until the vessel answers a ping."""
    numbers: list[int] = []
    wait_until(
        lambda: set(answers(by)) & set(numbers),
        "the vessel answers a ping",
        again=lambda: numbers.append(asked(by)),
    )


def unheard(companion: Companion, *those: Any) -> None:
    """None of them gets an answer, while the boat goes on for three seconds of its time."""
    numbers = [asked(one) for one in those]
    companion.sail(3.0)
    assert all(number not in answers(one) for one, number in zip(those, numbers, strict=True))


@pytest.mark.process
def test_mavproxy_sets_the_key_and_it_stands_after_a_restart(tmp_path: Path) -> None:
    """`signing setup` on a trusted link; after a restart a link that asks for signatures hears who knows the
    passphrase, and nobody else."""
    key = hashlib.sha256(b"harbour").digest()
    companion = Companion(tmp_path, speed=5.0)
    port = companion.tcp_port
    companion.links = (f"tcpin:127.0.0.1:{port}?signing=accept&trusted=yes",)
    with companion, MavProxy(f"tcp:127.0.0.1:{port}", tmp_path / "mavproxy") as proxy:
        proxy.expect("online system 1")
        proxy.say("signing setup harbour")
        proxy.expect("signing key set by system 255")
        proxy.expect(r"Received \d+ parameters")
        proxy.say("param set PATH_BW_SURGE 0.5")  # signed now
        proxy.ask("param show PATH_BW_SURGE", r"PATH_BW_SURGE\s+0\.5")
    assert read_signing(tmp_path / "state")[0] == key
    logs = b"".join(path.read_bytes() for path in companion.log_folder.rglob("*") if path.is_file())
    assert key not in logs and key.hex().encode() not in logs and len(logs) > 1000
    stations: list[Any] = []
    again = Companion(tmp_path, speed=5.0, links=(f"tcpin:127.0.0.1:{port}?signing=require&trusted=yes",))
    with again, contextlib.ExitStack() as closing:
        for known in (key, OTHER_KEY, None):
            stations.append(station(port, known))
            closing.callback(stations[-1].close)
        ours, stranger, unsigned = stations
        answered(ours)
        unheard(again, unsigned, stranger)
        answered(ours)
        with MavProxy(f"tcp:127.0.0.1:{port}", tmp_path / "mavproxy") as proxy:
            proxy.say("signing key harbour")
            proxy.ask("param show PATH_BW_SURGE", r"PATH_BW_SURGE\s+0\.5", again_s=2.0)
            proxy.say("signing remove harbour")
            proxy.expect("Removed signing")
        unheard(again, ours)
    assert read_signing(tmp_path / "state")[0] is None
