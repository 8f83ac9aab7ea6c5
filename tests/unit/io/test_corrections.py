"""Corrections from their sources to the receivers' ports: whole, unchanged, of one base station at a time; and what
people are told."""

from __future__ import annotations

import base64
import itertools
import os
import socket
import tty
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import pynmea2
import pytest

from companion.config.streams import CorrectionsConfig, stream_problems
from companion.config.vessel import ConfigError, as_dict, find, load, parse
from companion.core.decision import TextKind
from companion.core.readings import Measurement
from companion.io.corrections import Caster, CorrectionsRelay, CorrectionsSource
from companion.io.transport.opener import TransportOpener
from tests.unit.io.test_rtcm import STATION, frame
from tests.unit.record.ticks import tick
from tests.waiting import CAP_S
from tests.wires import Listening

REVOLT = find("revolt").read_text(encoding="utf-8")


class Desk:
    """A relay with two receivers, and what it says."""

    def __init__(self, *sources: str) -> None:
        self.ports = {"gnss": Listening(), "spare": Listening()}
        self.said: list[tuple[Any, ...]] = []
        self.relay = CorrectionsRelay(self.ports, sources, lambda *event: self.said.append(event))

    def got(self, name: str = "gnss") -> bytes:
        data = b"".join(sent for _, sent in self.ports[name].sent)
        self.ports[name].sent.clear()
        return data


def test_to_all_receivers_or_to_one() -> None:
    desk = Desk()
    desk.relay.take("mavlink:255", [STATION, frame(200)], 1.0)
    assert desk.got("gnss") == desk.got("spare") == STATION + frame(200)
    desk.relay.take("mavlink:255", [frame(100)], 2.0, to="spare")
    assert (desk.got("gnss"), desk.got("spare")) == (b"", frame(100))


def test_two_base_stations_are_not_mixed() -> None:
    """The vessel's own radio before ground stations; another takes over after ten seconds of silence, the better one at
    once."""
    desk = Desk("corrections_1", "corrections_2")
    desk.relay.take("mavlink:255", [frame(50, 1)], 0.0)
    desk.relay.take("mavlink:254", [frame(50, 2)], 0.5)
    assert desk.got() == frame(50, 1)
    desk.relay.take("corrections_2", [frame(50, 3)], 1.0)
    desk.relay.take("mavlink:255", [frame(50, 4)], 1.5)
    desk.relay.take("corrections_1", [frame(50, 5)], 2.0)
    desk.relay.take("corrections_2", [frame(50, 6)], 2.5)
    assert desk.got() == frame(50, 3) + frame(50, 5)
    desk.relay.take("mavlink:255", [frame(50, 7)], 11.9)
    desk.relay.take("mavlink:255", [frame(50, 8)], 12.1)
    assert desk.got() == frame(50, 8)


def test_the_next_source_takes_over_after_the_silence_that_the_file_says() -> None:
    desk = Desk("corrections_1", "corrections_2")
    configs = (CorrectionsConfig("tcpout:10.0.0.1:1", timeout_s=3.0), CorrectionsConfig("tcpout:10.0.0.2:1"))
    lines = [Listening() for _ in configs]
    first, second = (
        CorrectionsSource(config, f"corrections_{n}", line, desk.relay)
        for n, (config, line) in enumerate(zip(configs, lines, strict=True), 1)
    )
    lines[0].chunks = [(0.0, frame(50, 1))]
    first.read(0.0)
    for number, now_s in enumerate((2.9, 3.1), 2):
        lines[1].chunks = [(now_s, frame(50, number))]
        second.read(now_s)
    assert desk.got() == frame(50, 1) + frame(50, 3)


def test_what_one_station_sends_over_two_links_goes_out_once() -> None:
    desk = Desk()
    for k in range(5):
        desk.relay.take("mavlink:255", [frame(60, k), STATION], float(k), way="udp")
        desk.relay.take("mavlink:255", [frame(60, k), STATION], k + 0.3, way="radio")
    assert desk.got() == b"".join(frame(60, k) + STATION for k in range(5))
    desk.relay.take("mavlink:255", [STATION, STATION], 20.0, way="radio")
    assert desk.got() == STATION + STATION, "what it repeats by the same way is meant"


def test_loss_and_return_are_said() -> None:
    desk = Desk("corrections_1")
    for k in range(100):
        readings = (Measurement(float(k), "corrections_1", 4.0, "rtcm_hz"),) if k < 20 or k >= 60 else ()
        desk.relay.record(replace(tick(float(k)), readings=readings))
    assert [(event[0], event[2]) for event in desk.said] == [(30.0, "corrections_lost"), (60.0, "corrections_back")]
    never = Desk("corrections_1")
    for k in range(100):
        never.relay.record(tick(float(k)))
    assert [(event[0], event[3]) for event in never.said] == [(31.0, "RTK corrections: none yet")]
    unasked = Desk()
    for k in range(100):
        unasked.relay.record(tick(float(k)))
    assert unasked.said == [], "a boat whose station sends none is not told so"


def test_corrections_that_nobody_wants_are_said_once() -> None:
    said: list[tuple[Any, ...]] = []
    relay = CorrectionsRelay({}, (), lambda *event: said.append(event))
    for k in range(5):
        relay.take("mavlink:255", [STATION], float(k))
    assert [event[1] for event in said] == [TextKind.ATTENTION] and "rtcm = true" in said[0][3]


# --- on real descriptors ----------------------------------------------------------------------------------------------


@pytest.fixture
def radio() -> Iterator[tuple[int, str]]:
    """A pty: the radio's end, and the name of ours."""
    far, near = os.openpty()
    tty.setraw(far)
    tty.setraw(near)
    yield far, os.ttyname(near)
    os.close(far)
    os.close(near)


def test_from_a_serial_radio_to_a_receiver(radio: tuple[int, str]) -> None:
    far, name = radio
    desk = Desk("corrections_1")
    config = CorrectionsConfig(f"serial:{name}:57600", to="gnss")
    source = CorrectionsSource(
        config, "corrections_1", TransportOpener().open("corrections_1", config.port), desk.relay
    )
    sent = [frame(size, size) for size in (179, 180, 181, 360, 720, 800, 1029)]
    stream = b"\xd3\x01noise" + b"".join(one + b"\r\n\xd3" for one in sent)
    readings: list[Any] = []
    for k in range(0, len(stream), 61):
        os.write(far, stream[k : k + 61])
        readings += source.read(0.01 * k)
    for k in range(20):
        readings += source.read(40.0 + k)
    assert desk.got("gnss") == b"".join(sent) and desk.got("spare") == b""
    assert (
        {reading.name for reading in readings} == {"rtcm_hz"}
        and "7 RTCM frames" in source.health(41.0).text
        and source.health(99.0).ok
    )
    os.write(far, b"U" * 10)
    source.close()


def test_at_a_wrong_baud_rate_it_says_so() -> None:
    line, desk = Listening(), Desk("corrections_1")
    source = CorrectionsSource(CorrectionsConfig("serial:/dev/x:57600"), "corrections_1", line, desk.relay)
    line.chunks = [(1.0, b"\x00\xfe" * 400)]
    source.read(1.0)
    assert "wrong baud rate in 'serial:/dev/x:57600'" in source.health(1.0).text
    line.broken = "serial:/dev/x:57600: no such device"
    assert source.health(1.0).ok and "no such device" in source.health(1.0).text


class FakeCaster:
    """A caster on a TCP socket of this machine."""

    def __init__(self, **more: Any) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.listener.settimeout(CAP_S)
        self.desk = Desk("corrections_1")
        port = self.listener.getsockname()[1]
        config = CorrectionsConfig(f"tcpout:127.0.0.1:{port}", **more)
        self.source = CorrectionsSource(
            config, "corrections_1", TransportOpener().open("corrections_1", config.port), self.desk.relay
        )
        self.now_s = 0.0

    def accept(self) -> socket.socket:
        self.source.read(self.now_s)
        connection, _ = self.listener.accept()
        connection.settimeout(CAP_S)
        self.pump()
        return connection

    def pump(self, count: int = 50) -> None:
        for _ in range(count):
            self.now_s += 0.01
            self.source.read(self.now_s)

    def close(self, *connections: socket.socket) -> None:
        self.source.close()
        for one in (self.listener, *connections):
            one.close()


def test_from_a_caster() -> None:
    caster = FakeCaster(mountpoint="BASE", user="boat", password="sea")
    connection = caster.accept()
    asked = connection.recv(4096).decode("ascii").split("\r\n")
    assert asked[0] == "GET /BASE HTTP/1.0" and asked[1].startswith("User-Agent: NTRIP ") and asked[-2:] == ["", ""]
    assert f"Authorization: Basic {base64.b64encode(b'boat:sea').decode()}" in asked
    connection.sendall(b"ICY 200")
    caster.pump()
    connection.sendall(b" OK\r\n\r\n" + frame(180) + STATION[:9])
    caster.pump()
    connection.sendall(STATION[9:])
    caster.pump()
    assert caster.desk.got() == frame(180) + STATION
    caster.desk.relay.record(tick(caster.now_s))
    position = pynmea2.parse(connection.recv(4096).decode("ascii").strip(), check=True)
    assert position.sentence_type == "GGA" and position.latitude == pytest.approx(63.4)
    caster.close(connection)


@pytest.mark.parametrize(
    ("reply", "said"),
    [
        (b"HTTP/1.0 401 Unauthorized\r\n\r\n", "the caster refuses: HTTP/1.0 401 Unauthorized"),
        (b"ERROR - Bad Password\r\n", "the caster refuses: ERROR - Bad Password"),
        (b"SOURCETABLE 200 OK\r\nSTR;OTHER;\r\n", "the caster has no mountpoint BASE"),
    ],
)
def test_a_caster_that_refuses_is_asked_again_only_after_a_while(reply: bytes, said: str) -> None:
    caster = FakeCaster(mountpoint="BASE")
    connection = caster.accept()
    connection.recv(4096)
    connection.sendall(reply)
    connection.close()
    caster.pump()
    assert said in caster.source.health(caster.now_s).text and caster.source.health(caster.now_s).ok
    caster.now_s += 6.0
    caster.pump(2)
    again, _ = caster.listener.accept()
    again.setblocking(False)
    caster.pump()
    with pytest.raises(BlockingIOError):
        again.recv(100)
    caster.now_s += 30.0
    caster.pump()
    again.settimeout(CAP_S)
    assert again.recv(100).startswith(b"GET /BASE")
    caster.close(again)


@pytest.mark.parametrize(
    ("pieces", "said"),
    [
        ((b"SOURCETABLE 200 OK\r\n", b"\r\nSTR;OTHER;\r\n"), "the caster has no mountpoint BASE"),
        ((b"HTTP/1.1 200 OK\r\n", b"Content-Type: gnss/sourcetable\r\n\r\nSTR;"), "the caster has no mountpoint BASE"),
        ((b"HTTP/1.1 200 OK\r\nServer: x\r\nContent-Type: GNSS/source", b"table\r\n"), "the caster has no mountpoint"),
        ((b"HTTP/1.0 403 Forbidden\r\n", b"the limit of 200 users\r\n"), "the caster refuses: HTTP/1.0 403 Forbidden"),
    ],
)
def test_a_refusal_that_comes_in_pieces_is_told_by_its_first_line(pieces: Sequence[bytes], said: str) -> None:
    caster = FakeCaster(mountpoint="BASE")
    connection = caster.accept()
    for piece in pieces:
        connection.sendall(piece)
        caster.pump()
    assert caster.source.health(caster.now_s).text.startswith(said)
    caster.close(connection)


@pytest.mark.parametrize("head", [b"HTTP/1.1 200 OK\r\n\r\n", b"HTTP/1.1 200 OK\r\nContent-Type: gnss/data\r\n\r\n"])
def test_an_answer_by_http_with_data_is_good(head: bytes) -> None:
    caster = FakeCaster(mountpoint="BASE")
    connection = caster.accept()
    for piece in (head, STATION):
        connection.sendall(piece)
        caster.pump()
    assert caster.desk.got() == STATION and not caster.source.health(caster.now_s).text.startswith("the caster")
    caster.close(connection)


@pytest.mark.parametrize("answer", [b"", b"ICY 200 OK\r\n\r\n"])
def test_a_caster_that_hangs_up_at_once_is_asked_less_and_less_often(answer: bytes) -> None:
    """It was asked again every half second, all day long."""
    caster = Caster(CorrectionsConfig("tcpout:127.0.0.1:1", mountpoint="BASE"))
    asked: list[float] = []
    for tenth in range(1200):
        is_open, now_s = tenth % 6 != 0, 0.1 * tenth  # closed for a tick in six, where it would be opened again
        if caster.request(is_open, now_s):
            asked.append(now_s)
            caster.stream(answer, now_s)
    waits = [late - soon for soon, late in itertools.pairwise(asked)]
    assert 5 <= len(asked) <= 9 and waits == sorted(waits) and waits[0] < 3.0 and waits[-1] > 25.0


def test_a_caster_that_hangs_up_after_long_service_is_asked_at_once() -> None:
    caster = Caster(CorrectionsConfig("tcpout:127.0.0.1:1", mountpoint="BASE"))
    assert caster.request(True, 0.0)
    assert not caster.request(False, 60.0) and caster.request(True, 60.5)


def test_a_caster_that_refuses_and_does_not_hang_up_is_asked_again() -> None:
    caster = FakeCaster(mountpoint="BASE")
    connection = caster.accept()
    connection.recv(4096)
    connection.sendall(b"ERROR - Mountpoint Taken\r\n")
    caster.pump()
    caster.now_s += 30.0
    caster.pump()
    assert connection.recv(100).startswith(b"GET /BASE")
    connection.sendall(b"ICY 200 OK\r\n\r\n" + STATION)
    caster.pump()
    assert caster.desk.got() == STATION
    caster.close(connection)


# --- in a vessel's file -----------------------------------------------------------------------------------------------


def in_file(text: str, receiver: bool = False) -> Any:
    whole = REVOLT.replace('driver = "nmea0183"', 'driver = "nmea0183"\nrtcm = true') if receiver else REVOLT
    return parse(whole.replace("[parameters]", f"{text}\n[parameters]"), "x")


def test_the_file() -> None:
    config = in_file('[[corrections]]\nport = "serial:/dev/usv-radio:57600"', receiver=True)
    assert config.sensors[0].rtcm and config.corrections == (CorrectionsConfig("serial:/dev/usv-radio:57600"),)
    caster = in_file(
        '[[corrections]]\nport = "tcpout:10.0.0.1:2101"\nto = "gnss"\nmountpoint = "BASE"\nuser = "me"\npassword = "secret"'
    )
    assert "secret" not in repr(as_dict(caster)), "a log is shown to others"


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ('[[corrections]]\nport = "tcpout:10.0.0.1:2101"', "give a sensor rtcm = true"),
        ('[[corrections]]\nport = "tcpout:10.0.0.1:2101"\nto = "gps"', "no sensor named 'gps'; there is gnss, imu"),
        ('[[corrections]]\nport = "tcpout:10.0.0.1:2101"\nto = "gnss"\nuser = "me"', "give its mountpoint too"),
        ('[[corrections]]\nport = "serial:/dev/x"\nto = "gnss"\nmountpoint = "M"', "reached by tcpout"),
    ],
)
def test_mistakes_in_the_file(text: str, remedy: str) -> None:
    with pytest.raises(ConfigError, match=remedy):
        in_file(text)


def test_the_bundled_vessels_need_none() -> None:
    assert load(find("aboat")).corrections == ()


def test_a_bridge_shares_its_port_with_none_but_its_own_autopilot() -> None:
    shared = REVOLT.replace("serial:/dev/usv-mcu:115200", "serial:/dev/usv-imu:115200")
    with pytest.raises(ConfigError, match="'imu' has it too: only sensors, and what speaks MAVLink, can share a port"):
        parse(shared, "x")
    own = parse(REVOLT, "x")
    port = own.sensors[1].port
    sensors = (own.sensors[0], replace(own.sensors[1], driver="mavlink_imu"))
    assert stream_problems(sensors, (replace(own.actuators[0], driver="mavlink_servo", port=port),), ()) == []
    assert stream_problems(sensors, (replace(own.actuators[0], port=port),), ()) != []
    speaks_the_same = (own.sensors[0], replace(own.sensors[1], driver="nmea0183", port=own.sensors[0].port))
    assert stream_problems(speaks_the_same, (), ()) == []
