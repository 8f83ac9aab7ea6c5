"""The plant's ends of a companion's ports, met by the companion's own transport."""

from __future__ import annotations

import contextlib
import os
import socket
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.app import Surroundings, build
from companion.clock import SimulatedClock
from companion.config.vessel import ConfigError, VesselConfig, find, load, parse
from companion.io.transport.line import Line
from companion.io.transport.opener import TransportOpener, device_endpoint
from companion.io.transport.urls import PortUrl
from sitl.device_ports import DevicePort, PtyPort, device_port
from sitl.plant_process import PlantProcess, parse_leader, serve_devices
from sitl.shared_sea import build_shared_sea
from sitl.world import EPOCH_UNIX_NS, World
from tests.waiting import wait_until


def free_port(kind: socket.SocketKind) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def met(url: str, folder: Path) -> Iterator[tuple[DevicePort, Line]]:
    end = device_port(device_endpoint(url), folder)
    end.plug()
    line = TransportOpener(folder).open("device", url)
    try:
        yield end, line
    finally:
        line.close()
        end.unplug()


def test_each_kind_of_port_carries_bytes_both_ways(tmp_path: Path) -> None:
    urls = ["serial:/dev/usv-x:115200", "serial:/dev/serial/by-id/usb-x-if00:9600"]
    urls += [f"{scheme}:127.0.0.1:{free_port(socket.SOCK_DGRAM)}" for scheme in ("udpin", "udpout")]
    urls += [f"{scheme}:127.0.0.1:{free_port(socket.SOCK_STREAM)}" for scheme in ("tcpin", "tcpout")]
    urls += [f"udpin:0.0.0.0:{free_port(socket.SOCK_DGRAM)}", f"tcpin:0.0.0.0:{free_port(socket.SOCK_STREAM)}"]
    for url in urls:
        with met(url, tmp_path) as (end, line):
            heard, told = bytearray(), bytearray()
            now_s = 0.0

            def talk(
                end: DevicePort = end, line: Line = line, heard: bytearray = heard, told: bytearray = told
            ) -> bool:
                nonlocal now_s
                now_s += 0.1
                line.write(b"go", now_s)
                told.extend(end.take())
                end.give(b"\r\x00\x11$ok")
                heard.extend(b"".join(data for _, data in line.read(now_s)))
                return b"\r\x00\x11$ok" in heard and b"gogo" in told

            wait_until(talk, f"bytes both ways over {url}")
            assert line.fault() is None, url


def test_what_is_unplugged_is_gone_and_comes_back(tmp_path: Path) -> None:
    for url in ("serial:/dev/usv-x:115200", f"tcpout:127.0.0.1:{free_port(socket.SOCK_STREAM)}"):
        with met(url, tmp_path) as (end, line):
            now_s = 0.0

            def fault(end: DevicePort = end, line: Line = line) -> str | None:
                nonlocal now_s
                now_s += 0.05
                end.take()
                end.give(b"x")
                line.read(now_s)
                return line.fault()

            wait_until(lambda: fault() is None, f"{url} is well")
            end.unplug()
            wait_until(lambda: fault() is not None, f"{url} is gone")
            end.plug()
            wait_until(lambda: fault() is None, f"{url} is well")


def test_nobody_who_listens_finds_what_was_said_before(tmp_path: Path) -> None:
    """As on a wire: bytes that nobody read are lost."""
    end = PtyPort(PortUrl("serial", path="/dev/x"), tmp_path)
    end.plug()
    for _ in range(3):
        end.give(b"stale")
        port = os.open(tmp_path / "x", os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
        end.give(b"fresh")
        assert os.read(port, 100) == b"fresh"
        os.close(port)
    end.unplug()


def test_a_companion_that_was_killed_leaves_a_fresh_port(tmp_path: Path) -> None:
    """Whatever it had done to the old one: an exclusive mode would last."""
    end = PtyPort(PortUrl("serial", path="/dev/x"), tmp_path)
    end.plug()
    first = (tmp_path / "x").resolve()
    port = os.open(tmp_path / "x", os.O_RDONLY | os.O_NOCTTY)
    end.give(b"x")
    settings = termios.tcgetattr(port)
    settings[3] |= termios.ECHO
    termios.tcsetattr(port, termios.TCSANOW, settings)
    assert (tmp_path / "x").resolve() == first
    os.close(port)
    end.give(b"x")
    port = os.open(tmp_path / "x", os.O_RDONLY | os.O_NOCTTY)
    assert not termios.tcgetattr(port)[3] & termios.ECHO
    os.close(port)
    end.unplug()


def test_what_cannot_be_simulated_is_said(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="only replace a port below /dev"):
        device_port(PortUrl("serial", path="/srv/x"), tmp_path)
    with pytest.raises(ConfigError, match="no simulated device can use such a port"):
        device_port(PortUrl("carrier-pigeon"), tmp_path)
    elsewhere = device_port(PortUrl("udpout", host="192.0.2.7", port=5000), tmp_path)
    with pytest.raises(OSError, match="must be at this computer's own address") as caught:
        elsewhere.plug()
    assert caught.value.filename == "192.0.2.7:5000"


def plant(config: VesselConfig, folder: Path, world: World) -> PlantProcess:
    urls = {row.name: row.port for row in config.sensors} | {row.name: row.port for row in config.actuators}
    return PlantProcess(
        world, serve_devices(world, config, {name: device_endpoint(url) for name, url in urls.items()}, folder)
    )


def test_what_is_typed_happens(tmp_path: Path) -> None:
    config = load(find("rescuerunner"))
    shared_sea = build_shared_sea([parse_leader("straight@5+100", config.home.yaw_rad)], config.home, 0)
    world = World(config, shared_sea=shared_sea)
    process = plant(config, tmp_path, world)
    assert sorted(path.name for path in tmp_path.glob("usv-*")) == ["usv-gnss", "usv-imu", "usv-mcu"]
    process.advance(1.0)
    assert process.obey("imu_unplugged+2") == "1.0 s: imu_unplugged+2"
    process.advance(1.1)
    assert not (tmp_path / "usv-imu").is_symlink()
    process.advance(3.2)
    assert (tmp_path / "usv-imu").is_symlink()
    assert process.obey("depart") == "3.2 s: the lead boat departs"
    process.advance(33.2)
    (boat,) = shared_sea.boats
    assert boat.hull.surge_mps == pytest.approx(5.0, abs=0.3)
    for text, says in (
        ("kraken", "no fault named 'kraken'"),
        ("leak+soon", "NAME\\+SECONDS"),
        ("leak+0", "NAME\\+SECONDS"),
    ):
        with pytest.raises(ConfigError, match=says):
            process.obey(text)
    process.close()
    assert not list(tmp_path.glob("usv-*"))


SHARED = """[[sensor]]
name = "wind"
driver = "nmea0183"
port = "serial:/dev/usv-gnss:115200"
rate_hz = 2.0
"""


def test_devices_that_share_a_port_are_all_heard(tmp_path: Path) -> None:
    """The last one had the port to itself, and a Pixhawk was two autopilots on one wire."""
    text = find("blueboat").read_text(encoding="utf-8").replace("[[actuator]]", f"{SHARED}\n[[actuator]]", 1)
    config = parse(text, "boat.toml")
    clock, process = SimulatedClock(EPOCH_UNIX_NS), plant(config, tmp_path, World(config))
    vessel = build(config, Surroundings(clock, TransportOpener(tmp_path), process, []))

    def all_are_well() -> bool:
        clock.wait(clock.now_s() + vessel.period_s, ())
        tick = vessel.tick(clock.now_s())
        healths = {device.name: device.ok for device in tick.health}
        return all(healths[name] for name in ("gnss", "imu", "wind", "pixhawk"))

    wait_until(all_are_well, "all four devices")
    vessel.close()
    process.close()
    assert not list(tmp_path.glob("usv-*"))


def test_a_lead_boat_lies_ahead_until_its_time(tmp_path: Path) -> None:
    boat = parse_leader("thesis@8.2+60", 0.0)
    assert (boat.script, boat.start, boat.depart_s) == ("thesis@8.2", (20.0, 0.0, 0.0), 60.0)
    assert parse_leader("thesis", 0.0).depart_s == 30.0
    with pytest.raises(ConfigError, match="SCRIPT@MPS"):
        parse_leader("thesis@8.2+soon", 0.0)
    for never in ("nan", "inf", "-5"):
        with pytest.raises(ConfigError, match="SECONDS"):
            parse_leader(f"thesis@8.2+{never}", 0.0)
