"""FTP on a desk: a client of our own asks, over loss, for files in memory and on the disk."""

from __future__ import annotations

import lzma
import os
import random
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.transfer.component_metadata import Descriptions
from companion.io.mavlink.transfer.disk_files import LogStore
from companion.io.mavlink.transfer.file_tree import FileTree
from companion.io.mavlink.transfer.ftp_codec import parse
from companion.io.mavlink.transfer.ftp_service import FtpService
from companion.io.mavlink.wire.hub import Peer
from tests.unit.io.mavlink.conftest import Desk
from tests.waiting import wait_until

HEADER = struct.Struct("<HBBBBBBI")
NONE, TERMINATE, RESET, LIST, OPEN, READ, CREATE, WRITE, CRC, BURST = 0, 1, 2, 3, 4, 5, 6, 7, 14, 15
EOF, NOT_FOUND, INVALID_SESSION, NO_SESSIONS, PROTECTED, UNKNOWN, BAD_SIZE = 6, 10, 4, 5, 9, 7, 3


class Reply:
    def __init__(self, payload: bytes) -> None:
        self.seq, self.session, opcode, size, self.asked, self.complete, _, self.offset = HEADER.unpack_from(payload)
        self.data = payload[12 : 12 + size]
        self.error = self.data[0] if opcode == 129 else None


class Client:
    """Asks as `who`; time goes on by 0.1 s with each update of the service."""

    def __init__(self, desk: Desk, service: FtpService, who: str = "qgc") -> None:
        self.desk, self.service, self.who = desk, service, who
        self.seq = 0
        self.now_s = 0.0

    def ask(
        self,
        opcode: int,
        data: bytes = b"",
        session: int = 0,
        offset: int = 0,
        size: int | None = None,
        seq: int | None = None,
    ) -> list[Reply]:
        self.seq = (self.seq + 1) & 0xFFFF if seq is None else seq
        payload = (
            HEADER.pack(self.seq, session, opcode, len(data) if size is None else size, 0, 0, 0, offset) + data
        ).ljust(251, b"\0")
        self.desk.tell(
            self.desk.messages.MAVLink_file_transfer_protocol_message(0, 1, 1, payload), self.desk.peer(self.who)
        )
        return self.heard()

    def heard(self) -> list[Reply]:
        peer = self.desk.peer(self.who)
        return [Reply(bytes(message.payload)) for to, message in self.desk.heard() if to == peer]

    def later(self) -> list[Reply]:
        self.now_s += 0.1
        self.service.update(self.now_s)
        return self.heard()

    def one(self, *arguments: Any, **more: Any) -> Reply:
        """The one answer to a request, which may need the disk."""
        (reply,) = self.ask(*arguments, **more) or wait_until(self.later, "an answer; the disk is read by a thread")
        return reply

    def fetch(self, path: str, chunk: int = 239, lose: Callable[[], bool] = lambda: False) -> bytes:
        """Open, burst, fill the holes, as QGroundControl does."""
        opened = self.one(OPEN, path.encode())
        assert opened.error is None, opened.error
        (size,) = struct.unpack("<I", opened.data)
        got: dict[int, bytes] = {}
        at = 0
        while at < size:
            replies, complete = self.ask(BURST, session=opened.session, offset=at, size=chunk), False
            while not complete:
                for reply in replies or wait_until(self.later, "the burst goes on; the disk is read by a thread"):
                    assert reply.error is None and reply.asked == BURST
                    if not lose():
                        got[reply.offset] = reply.data
                    at = max(at, reply.offset + len(reply.data))
                    complete = reply.complete
                replies = []
        end = self.ask(BURST, session=opened.session, offset=size, size=chunk)
        assert [reply.error for reply in end] == [EOF]
        for hole in range(0, size, chunk):
            while hole not in got:
                reply = self.one(READ, session=opened.session, offset=hole, size=chunk)
                if not lose():
                    got[hole] = reply.data
        self.one(TERMINATE, session=opened.session)
        return b"".join(got[at] for at in sorted(got))[:size]

    def names(self, path: str) -> list[str]:
        rows: list[str] = []
        while True:
            reply = self.one(LIST, path.encode(), offset=len(rows))
            if reply.error == EOF:
                return rows
            assert reply.error is None, reply.error
            rows += [row.decode() for row in reply.data.split(b"\0") if row]


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    draws = random.Random(3)
    for n in range(12):
        folder = tmp_path / f"revolt-20260601-1200{n:02}"
        folder.mkdir()
        (folder / "telemetry.tlog").write_bytes(draws.randbytes(1000 * n))
        (folder / "manifest.json").write_bytes(b"{}")
    (tmp_path / "big").mkdir()
    (tmp_path / "big" / "ticks.csv").write_bytes(draws.randbytes(700_001))
    (tmp_path / "secret.txt").write_bytes(b"not a log")
    (tmp_path / "big" / "link").symlink_to("/etc/passwd")
    (tmp_path / "way_out").symlink_to("/etc")
    return tmp_path


@pytest.fixture
def service(desk: Desk, logs: Path) -> Any:
    desk.vessel.last_tick = None
    store = LogStore(logs)
    made = FtpService(desk.hub, FileTree(desk.vessel, 1, 1, Descriptions(desk.parameters, ArmingEvents((), ())), store))
    desk.serve(made)
    yield made
    made.close()
    store.close()


@pytest.fixture
def client(desk: Desk, service: FtpService) -> Client:
    return Client(desk, service)


def test_the_tree_is_listed(client: Client) -> None:
    root = client.names("/")
    assert [row.split("\t")[0] for row in root] == [
        "Fgeneral.json",
        "Fparameters.json.xz",
        "Factuators.json.xz",
        "Fevents.json.xz",
        "D@PARAM",
        "Dplans",
        "Dlogs",
    ]
    assert client.names("") == client.names("/.") == root
    assert [row.split("\t")[0] for row in client.names("@PARAM")] == ["Fparam.pck", "Fusv.params"]
    runs = client.names("/logs/")
    assert len(runs) == 13 and runs[0] == "Dbig" and "Dway_out" not in runs and not any("secret" in row for row in runs)
    assert client.names("@MAV_LOG") == runs
    assert client.names("logs/big") == ["Fticks.csv\t700001"]


def test_a_name_that_cannot_be_told_hides_no_others(client: Client, logs: Path) -> None:
    """A long one ended the listing, and one that is not UTF-8 made it fail."""
    for name in (b"a" * 245, b"b\xe9"):
        (logs / os.fsdecode(name)).mkdir()
    runs = client.names("/logs/")
    assert len(runs) == 13 and runs[0] == "Dbig"


def test_files_come_whole(client: Client, logs: Path) -> None:
    assert b'"metadataTypes"' in client.fetch("/general.json")
    assert b"DP_BW_SURGE" in lzma.decompress(client.fetch("//parameters.json.xz"))
    assert client.fetch("logs/big/ticks.csv") == (logs / "big" / "ticks.csv").read_bytes()
    name = "revolt-20260601-120007"
    assert client.fetch(f"@MAV_LOG/{name}/telemetry.tlog", chunk=80) == (logs / name / "telemetry.tlog").read_bytes()


def test_a_file_comes_whole_over_loss(client: Client, logs: Path) -> None:
    draws = random.Random(5)
    assert (
        client.fetch("logs/big/ticks.csv", lose=lambda: draws.random() < 0.1)
        == (logs / "big" / "ticks.csv").read_bytes()
    )


@pytest.mark.parametrize(
    "path",
    [
        "../secret.txt",
        "logs/../../etc/passwd",
        "logs/..",
        "/etc/passwd",
        "logs/secret.txt",
        "logs/big/link",
        "logs/way_out/passwd",
        "logs/big",
        "logs",
        "@PARAM",
        "@PARAM/../general.json",
        "general.json/x",
        "logs/big/none",
        "logs/none/ticks.csv",
        "logs\\big",
        "\xff",
        "logs/big/ticks.csv\0x",
    ],
)
def test_files_that_do_not_exist_or_are_not_offered_are_not_found(client: Client, path: str) -> None:
    data = path.encode("latin-1")
    assert client.one(OPEN, data).error == NOT_FOUND
    assert client.one(CRC, data).error == NOT_FOUND


def test_directories_above_are_not_listed(client: Client) -> None:
    for path in ("..", "logs/..", "logs/../..", "logs/way_out", "etc", "logs/big/link"):
        assert client.one(LIST, path.encode()).error == NOT_FOUND


@pytest.mark.parametrize("opcode", [6, 7, 8, 9, 10, 11, 12, 13])
def test_nothing_is_written(client: Client, opcode: int, logs: Path) -> None:
    assert client.one(opcode, b"logs/big/ticks.csv").error == PROTECTED
    assert (logs / "big" / "ticks.csv").stat().st_size == 700_001


def test_invalid_requests_are_refused(client: Client) -> None:
    assert client.one(77).error == UNKNOWN
    assert client.one(16, b"/").error == UNKNOWN
    assert client.one(OPEN, b"").error == BAD_SIZE
    assert client.one(OPEN, b"a", size=240).error == BAD_SIZE
    assert client.one(READ, session=9, size=10).error == INVALID_SESSION
    assert client.one(BURST, session=9, size=10).error == INVALID_SESSION
    assert client.one(NONE).error is None


def test_the_sequence_number_wraps_and_the_session_is_the_clients(client: Client) -> None:
    reply = client.one(OPEN, b"general.json", session=37, seq=0xFFFF)
    assert (reply.seq, reply.session, reply.error) == (0, 37, None)


def test_a_request_that_comes_again_gets_the_same_answer(client: Client) -> None:
    first = client.one(OPEN, b"general.json", seq=5)
    again = client.one(OPEN, b"general.json", seq=5)
    assert (first.seq, first.data) == (again.seq, again.data)
    chunk = client.one(READ, size=20, seq=6)
    assert client.one(READ, size=20, seq=6).data == chunk.data


def test_a_repeated_open_with_another_number_opens_again(client: Client) -> None:
    client.one(OPEN, b"general.json")
    assert client.one(OPEN, b"parameters.json.xz").error is None
    assert client.one(READ, size=6).data == b"\xfd7zXZ\0"


def test_reading_behind_the_end(client: Client) -> None:
    size = struct.unpack("<I", client.one(OPEN, b"general.json").data)[0]
    assert client.one(READ, offset=size, size=10).error == EOF
    assert len(client.one(READ, offset=size - 3, size=10).data) == 3
    assert client.one(READ, offset=0xFFFFFFF0, size=239).error == EOF


def test_a_new_request_stops_a_burst(client: Client) -> None:
    client.one(OPEN, b"logs/big/ticks.csv")
    client.ask(BURST, size=239)
    client.one(TERMINATE)
    assert client.later() == [] == client.later()


def test_a_client_has_four_files_and_others_have_theirs(desk: Desk, client: Client, service: FtpService) -> None:
    for n in range(4):
        assert client.one(OPEN, b"general.json", session=n).error is None
    assert client.one(OPEN, b"general.json", session=9).error == NO_SESSIONS
    other = Client(desk, service, "other")
    assert other.one(OPEN, b"general.json").error is None
    client.one(RESET)
    assert client.one(OPEN, b"general.json", session=9).error is None
    assert other.one(READ, size=10).error is None


def test_a_client_that_falls_silent_is_forgotten(client: Client) -> None:
    client.one(OPEN, b"general.json")
    client.now_s = 100.0
    client.later()
    assert client.one(READ, size=10).error == INVALID_SESSION


def test_a_slow_line_keeps_half_for_telemetry(desk: Desk, client: Client) -> None:
    desk.peer("qgc").endpoint.bytes_per_s = 5760.0
    client.one(OPEN, b"parameters.json.xz")
    sent = len(client.ask(BURST, size=239))
    for _ in range(20):
        sent += len(client.later())
    assert 0.35 * 5760.0 * 2.0 < sent * 263 < 0.75 * 5760.0 * 2.0


def test_checksums_are_mavlinks(client: Client, logs: Path) -> None:
    for path, data in (
        ("general.json", client.fetch("general.json")),
        ("logs/big/ticks.csv", (logs / "big" / "ticks.csv").read_bytes()),
    ):
        (crc,) = struct.unpack("<I", client.one(CRC, path.encode()).data)
        assert crc == zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def test_plans_and_parameters_are_files_too(client: Client) -> None:
    magic, kind, _, _, count = struct.unpack_from("<HHHHH", client.fetch("@MISSION/mission.dat"))
    assert (magic, kind, count) == (0x763D, 0, 0)
    assert b"DP_BW_SURGE" in client.fetch("@PARAM/usv.params")
    assert b'"fileType": "Plan"' in client.fetch("plans/current.plan")


def test_any_bytes_are_answered_or_are_an_answer(desk: Desk, client: Client) -> None:
    stream = random.Random(1)
    for _ in range(1500):
        payload = bytearray(stream.randbytes(251))
        payload[3] = stream.choice([*range(18), payload[3]])
        request = parse(bytes(payload))
        desk.tell(desk.messages.MAVLink_file_transfer_protocol_message(0, 1, 1, bytes(payload)), desk.peer("qgc"))
        replies = client.heard()
        assert (request is None) == (payload[3] in (128, 129))
        assert len(replies) <= 1 or all(reply.asked == BURST for reply in replies)


def test_a_disk_that_fails_is_answered_with_fail(logs: Path) -> None:
    store = LogStore(logs)
    file = store.open(["big", "ticks.csv"]).result()
    assert file is not None
    file.close()
    store.close()
    with pytest.raises((OSError, RuntimeError)):
        file.read(600_000, 10)


def test_the_answer_goes_to_the_client_that_asked(desk: Desk, service: FtpService) -> None:
    payload = (HEADER.pack(7, 3, OPEN, 12, 0, 0, 0, 0) + b"general.json").ljust(251, b"\0")
    desk.tell(desk.messages.MAVLink_file_transfer_protocol_message(0, 1, 1, payload), desk.peer("qgc"))
    ((peer, reply),) = desk.heard()
    assert peer == desk.peer("qgc")
    assert (reply.target_network, reply.target_system, reply.target_component) == (0, 255, 190)


def test_open_files_that_nobody_reads_make_room_for_who_reads(desk: Desk, service: FtpService) -> None:
    """One link with many system ids takes all sessions, and then asks for nothing but signs of life."""
    first = desk.peer("qgc")
    for number in range(4):
        desk.add_peer(f"crowd {number}", Peer(first.endpoint, 10 + number, 190))
        crowd = Client(desk, service, f"crowd {number}")
        for session in range(4):
            assert crowd.one(OPEN, b"general.json", session=session).error is None
    other = Client(desk, service, "other")
    assert other.one(OPEN, b"general.json").error is None, "a link of its own comes before the seventeenth file of one"
    assert other.one(READ, size=10).error is None
    assert crowd.one(OPEN, b"general.json", session=9).error == NO_SESSIONS
    desk.add_peer("late", Peer(first.endpoint, 99, 190))
    late = Client(desk, service, "late")
    assert late.one(OPEN, b"general.json").error == NO_SESSIONS
    desk.now_s += 6.0
    assert late.one(NONE).error is None
    assert late.one(OPEN, b"general.json").error is None
