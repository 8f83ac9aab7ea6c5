"""The links that a simulated boat has where none is given: who is told what on which, and what a taken port does.

Their port numbers are fixed, and other programs of this machine may have them. So the process gets the same links on
free ports, or the very links on a network of its own.
"""

from __future__ import annotations

import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from companion.cli.composition import SITL_LINKS
from companion.io.mavlink.services.introduction import place_to_connect
from companion.io.transport.urls import parse_url
from tests.island import Island, NoIsland
from tests.protocol.mavproxy import MavProxy
from tests.protocol.process import Companion, free_port
from tests.protocol.test_mavproxy import CORNERS, row, write
from tests.waiting import CAP_S, Every, wait_until

GROUND_STATION, PROGRAM, TCP, ROVER = range(4)
BANNER = 42428
HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)


def test_they_are_those_of_px4s_and_ardupilots_simulators() -> None:
    links = [parse_url(url) for url in SITL_LINKS]
    assert [(link.scheme, link.port) for link in links] == [
        ("udpout", 14550),
        ("udpout", 14540),
        ("tcpin", 5760),
        ("tcpin", 5762),
    ]
    assert {link.host for link in links} == {"127.0.0.1"}, "a simulated boat is nobody else's"
    assert [link.options.get("dialect", "px4") for link in links] == ["px4", "px4", "px4", "ardupilot"]
    assert place_to_connect(SITL_LINKS) == "TCP port 5762"


def test_the_pages_name_every_one() -> None:
    docs = Path(__file__).parents[2] / "docs"
    index = (docs / "ground-stations" / "index.md").read_text(encoding="utf-8")
    first_sail = (docs / "start" / "first-sail.md").read_text(encoding="utf-8")
    assert all(f"`{url}`" in index for url in SITL_LINKS)
    assert all(str(parse_url(url).port) in first_sail for url in SITL_LINKS)


def elsewhere(url: str) -> tuple[str, int]:
    """The same link on a free port."""
    link = parse_url(url)
    port = free_port(socket.SOCK_STREAM if link.scheme == "tcpin" else socket.SOCK_DGRAM)
    return url.replace(f":{link.port}", f":{port}"), port


@contextmanager
def client(address: str) -> Iterator[Any]:
    link = mavutil.mavlink_connection(address, source_system=255, source_component=190)
    try:
        yield link
    finally:
        link.close()


def heard(link: Any, kind: str, pattern: str = "") -> Any:
    """The next such message; of texts one that fits."""
    beat = Every(0.5)

    def found() -> Any:
        if link.target_system and beat.due():
            link.mav.send(HEARTBEAT)
        message = link.recv_match(type=kind, blocking=False)
        return message if message is not None and re.search(pattern, getattr(message, "text", "")) else None

    return wait_until(found, f"{kind} {pattern}")


@pytest.mark.process
def test_who_is_told_what_where(tmp_path: Path) -> None:
    """Every client gets the banner, unasked and by command."""
    urls, ports = zip(*(elsewhere(url) for url in SITL_LINKS), strict=True)
    with Companion(tmp_path, speed=5.0, links=urls):
        for address, autopilot in (
            (f"udpin:127.0.0.1:{ports[GROUND_STATION]}", mavlink.MAV_AUTOPILOT_PX4),
            (f"udpin:127.0.0.1:{ports[PROGRAM]}", mavlink.MAV_AUTOPILOT_PX4),
            (f"tcp:127.0.0.1:{ports[TCP]}", mavlink.MAV_AUTOPILOT_PX4),
            (f"tcp:127.0.0.1:{ports[ROVER]}", mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA),
        ):
            with client(address) as link:
                beat = heard(link, "HEARTBEAT")
                assert (beat.type, beat.autopilot) == (mavlink.MAV_TYPE_SURFACE_BOAT, autopilot), address
                heard(link, "STATUSTEXT", "^USV companion [0-9.]+$")
                link.mav.command_long_send(1, 1, BANNER, 0, 0, 0, 0, 0, 0, 0, 0)
                heard(link, "STATUSTEXT", "^Frame: boat")


@pytest.mark.process
def test_mavproxy_is_told_where_its_mode_command_works_and_it_works_there(tmp_path: Path) -> None:
    urls, ports = zip(*(elsewhere(url) for url in SITL_LINKS), strict=True)
    with Companion(tmp_path, speed=5.0, links=urls):
        with MavProxy(f"tcp:127.0.0.1:{ports[TCP]}", tmp_path / "px4") as station:
            station.expect(f"MAVProxy's mode command works on TCP port {ports[ROVER]}")
        with MavProxy(f"tcp:127.0.0.1:{ports[ROVER]}", tmp_path / "rover") as station:
            station.expect("online system 1")
            for name in ("HOLD", "LOITER", "MANUAL", "GUIDED"):
                station.ask(f"mode {name}", f"Mode {name}", again_s=5.0)
            rows = [row(n, 16, corner) for n, corner in enumerate(CORNERS)]
            station.say(f"wp load {write(tmp_path / 'plan.txt', rows)}")
            station.expect("Got MISSION_ACK: TYPE_MISSION: ACCEPTED")
            station.ask("mode AUTO", "Mode AUTO", again_s=5.0)


@contextmanager
def island() -> Iterator[Island]:
    try:
        made = Island()
    except NoIsland as error:
        pytest.skip(f"the default ports may be others' here, and there is no network of its own: {error}")
    with made:
        yield made


@contextmanager
def taken(port: int, alone: Island) -> Iterator[None]:
    """Another program has the TCP port."""
    serve = f"import socket, sys; s = socket.create_server(('127.0.0.1', {port})); print('ready', flush=True); sys.stdin.read()"
    command = [*alone.within, sys.executable, "-c", serve]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None and other.stdout.readline() == "ready\n"
        yield
        other.communicate(timeout=CAP_S)


@pytest.mark.process
def test_a_port_that_is_taken_is_named_and_the_others_work(tmp_path: Path) -> None:
    with island() as alone, taken(5760, alone):
        boat = Companion(tmp_path, speed=5.0, links=(), within=alone.within).start()
        try:
            assert boat.hello[1] == "links: " + ", ".join(url for url in SITL_LINKS if ":5760" not in url)
            with MavProxy("tcp:127.0.0.1:5762", tmp_path / "rover", within=alone.within) as station:
                station.expect("online system 1")
        finally:
            code, errors = boat.stop()
        assert code == 0
        assert re.search(r"tcpin:127.0.0.1:5760.*port in use; .*going on without it", errors)


@pytest.mark.process
def test_a_second_boat_on_the_same_ports_does_not_start(tmp_path: Path) -> None:
    with (
        island() as alone,
        Companion(tmp_path / "first", links=(), within=alone.within),
        pytest.raises(RuntimeError, match="port in use; stop the program"),
    ):
        Companion(tmp_path / "second", links=(), within=alone.within).start()
