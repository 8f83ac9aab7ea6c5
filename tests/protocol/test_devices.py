"""`companion devices` and `companion check --listen` on pseudo-terminals with the bytes of real devices; what
`companion check` leaves alone."""

from __future__ import annotations

import fcntl
import subprocess
import sys
import termios
import threading
import time
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import count
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.app import load_vessel
from companion.cli.devices import described, listen_to
from companion.config.devices import SensorConfig
from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.io.listening import PortListener, listen
from companion.io.transport.port_names import named
from companion.io.transport.urls import PortUrl
from sitl.device_ports import PtyPort, device_port
from sitl.plant_process import PlantProcess, serve_devices
from sitl.world import World, WorldConditions
from tests.copies import run_to_end as companion
from tests.waiting import run_to_end

AIS = b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C\r\n"
RTCM_1005 = bytes.fromhex("d300133ed7d30202980edeef34b4bd62ac0941986f33360b98")
HEARTBEAT = mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 4, 3).pack(
    mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
)
SPOKEN = {
    "usv-ais": (AIS, 0.2),
    "usv-radio": (RTCM_1005, 0.25),
    "usv-pixhawk": (HEARTBEAT, 1.0),
    "usv-lidar": (b"\x5a\xa5\x10\x7f\x93" * 16, 0.02),
    "usv-stepper": (b"", 9.0),
}


def vessel() -> VesselConfig:
    revolt = load(find("revolt"))
    wind = SensorConfig(name="wind", driver="nmea0183", port="serial:/dev/usv-wind:4800", rate_hz=4.0)
    return replace(revolt, sensors=(*revolt.sensors, wind))


@contextmanager
def plugged_in(folder: Path) -> Iterator[Callable[[float], None]]:
    """The ReVolt's devices with a wind sensor, and others that say what `SPOKEN` has. Gives what advances them to a
    time, s."""
    config = vessel()
    world = World(config, WorldConditions(seed=1, wind="4@45"))
    rows = [(row.name, row.port.split(":")[1]) for row in (*config.sensors, *config.actuators)]  # type: ignore[attr-defined]
    plant = PlantProcess(
        world, serve_devices(world, config, {name: PortUrl("serial", path=path) for name, path in rows}, folder)
    )
    others = {name: device_port(PortUrl("serial", path=f"/dev/{name}"), folder) for name in SPOKEN}
    for end in others.values():
        end.plug()
    due_s = dict.fromkeys(SPOKEN, 0.0)
    written = bytearray()

    def advance(now_s: float) -> None:
        plant.advance(now_s)
        for name, end in others.items():
            if now_s >= due_s[name]:
                due_s[name] += SPOKEN[name][1]
                end.give(SPOKEN[name][0])
            written.extend(end.take())

    try:
        yield advance
    finally:
        plant.close()
        for end in others.values():
            end.unplug()
    assert not written and all(board.last_command is None for board in world.boards), (
        "nothing was written to any device"
    )


@contextmanager
def in_real_time(advance: Callable[[float], None]) -> Iterator[None]:
    """Advance with the clock, in a thread."""
    stop = threading.Event()
    begin_s = time.monotonic()

    def speak() -> None:
        while not stop.wait(0.01):
            advance(time.monotonic() - begin_s)

    speaker = threading.Thread(target=speak)
    speaker.start()
    try:
        yield
    finally:
        stop.set()
        speaker.join()


@pytest.mark.process
def test_devices_names_all_and_check_listens(tmp_path: Path) -> None:
    ports = ["usv-gnss", "usv-imu", "usv-wind", "usv-mcu", *SPOKEN]
    with plugged_in(tmp_path) as advance, in_real_time(advance):
        done = companion(
            "devices", "--seconds", "2.5", *(word for name in ports for word in ("--port", str(tmp_path / name)))
        )
        well = companion("check", "--listen", str(boat_file(tmp_path)))
    assert done.returncode == 0 and not done.stderr, done.stderr
    blocks = {block.split(" ", 1)[0].split("\n", 1)[0]: block for block in done.stdout.split("\n\n")[1:]}
    heard = {name: blocks[str(tmp_path / name)] for name in ports}
    expected = {
        "usv-gnss": "the GNSS receiver: NMEA 0183 at 115200 baud: G",
        "usv-imu": "the inertial sensor: MTData2 at 115200 baud: attitude, acceleration, rate of turn ",
        "usv-wind": "the wind sensor: NMEA 0183 at 115200 baud: ",
        "usv-mcu": "the thruster board: frames of a thruster board at 115200 baud: status ",
        "usv-ais": "the AIS receiver: AIS at 115200 baud: AIVDM",
        "usv-radio": "the radio with the corrections: RTCM 3 at 115200 baud: 1005 ",
        "usv-pixhawk": "system 1, component 1: an autopilot",
        "usv-lidar": "no known format at any usual speed",
        "usv-stepper": "silent: without power, or it only answers when asked, as stepper drives on RS485 (Nanotec)",
    }
    for name, says in expected.items():
        assert says in heard[name], heard[name]
    lines = [
        line[2:]
        for block in heard.values()
        for line in block.splitlines()
        if line.startswith(("  [[", "  name", "  driver", "  port", "  ant", "  rate", "  thr"))
    ]
    tables = tomllib.loads("\n".join(lines))
    assert [(row["name"], row["driver"]) for row in tables["sensor"]] == [
        ("gnss", "nmea0183"),
        ("imu", "mtdata2"),
        ("wind", "nmea0183"),
        ("ais", "ais"),
    ]
    assert tables["sensor"][0]["antennas"] == 2 and tables["sensor"][0]["port"] == f"serial:{tmp_path}/usv-gnss:115200"
    for row, rate_hz in zip(tables["sensor"], (20.0, 100.0, 4.0), strict=False):
        assert row["rate_hz"] == pytest.approx(rate_hz, rel=0.3)
        assert SensorConfig(**row)
    assert len(tables["actuator"][0]["thrusters"]) == 3

    assert well.returncode == 0, well.stdout
    assert "gnss: " in well.stdout and "NMEA 0183 (G" in well.stdout and "MTData2 (attitude" in well.stdout


def test_check_listen_names_devices_on_each_others_ports(tmp_path: Path) -> None:
    file = boat_file(tmp_path)
    text = file.read_text(encoding="utf-8")
    file.write_text(
        text.replace("usv-imu", "usv-x").replace("usv-gnss", "usv-imu").replace("usv-x", "usv-gnss"),
        encoding="utf-8",
    )
    with plugged_in(tmp_path) as advance:
        swapped = listen_to(load_vessel(str(file)), 1.0, turns(advance))
    (gnss_well, gnss), (imu_well, imu), (board_well, _) = swapped
    assert (
        not gnss_well
        and "looks like MTData2 (attitude, acceleration, rate of turn): is the inertial sensor plugged in here?" in gnss
    )
    assert (
        not imu_well
        and "looks like NMEA 0183 (" in imu
        and "is the GNSS receiver plugged in here?" in imu
        and board_well
    )


def boat_file(folder: Path) -> Path:
    """The ReVolt's file with its ports in `folder`."""
    file = folder / "boat.toml"
    text = find("revolt").read_text(encoding="utf-8").replace("serial:/dev/", f"serial:{folder}/")
    file.write_text(text, encoding="utf-8")
    return file


def turns(advance: Callable[[float], None]) -> Callable[[], float]:
    """A clock for `hear_out` that advances the devices itself, 0.02 s a turn."""
    times_s = (0.02 * k for k in count(1))

    def wait() -> float:
        now_s = next(times_s)
        advance(now_s)
        return now_s

    return wait


def terminal(folder: Path) -> tuple[PtyPort, Path]:
    end = PtyPort(PortUrl("serial", path="/dev/port"), folder)
    end.plug()
    return end, folder / "port"


def test_a_port_that_another_program_has_is_skipped(tmp_path: Path) -> None:
    end, path = terminal(tmp_path)
    script = "import os, sys; fd = os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY); print('has it', flush=True); sys.stdin.read()"
    with subprocess.Popen(
        [sys.executable, "-c", script, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None and other.stdout.readline()
        (listener,) = listen([path], 0.5)
        other.communicate()
    assert f"skipped: process {other.pid} (" in (listener.fault or "")
    assert "has it open" in described(named(path), listener, set())[0]
    end.unplug()
    (listener,) = listen([path], 0.5)
    assert listener.fault == "no such device"
    (listener,) = listen([tmp_path], 0.5)
    assert listener.fault == "no serial port"


def test_a_device_heard_once_is_not_silent(tmp_path: Path) -> None:
    """A sentence a minute, say: none comes in after the one that was recognised."""
    end, path = terminal(tmp_path)
    listener = PortListener(path, 1.0)
    listener.update(0.0)
    end.give(b"$WIMWV,214.8,R,0.1,K,A*28\r\n")
    now_s = 0.0
    while not listener.done:
        now_s += 0.1
        listener.update(now_s)
    assert listener.recogniser.verdict is not None and listener.recogniser.verdict.device == "the wind sensor"
    assert listener.heard_s == pytest.approx(1.1)
    end.unplug()


def test_speeds_are_tried_until_bytes_make_sense(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pseudo-terminal has no speed: what is heard at the wrong one is made up. The port's own settings come back."""
    end, path = terminal(tmp_path)
    with path.open("rb") as port:
        fcntl.fcntl(port, fcntl.F_GETFL)
        before = termios.tcgetattr(port)
        tried: list[int] = []
        monkeypatch.setattr("companion.io.listening.holder_of", lambda path: None)
        listener = PortListener(path, 1.0)
        now_s = 0.0
        while not listener.done:
            now_s += 0.05
            if tried[-1:] != [listener.baud]:
                tried.append(listener.baud)
            good = listener.baud == 4800
            end.give(b"$WIMWV,214.8,R,0.1,K,A*28\r\n" if good else b"\xf8\x00\x98\xfe" * 10)
            listener.update(now_s)
        assert tried == [115200, 38400, 4800] and listener.baud == 4800
        assert listener.recogniser.verdict is not None and listener.recogniser.verdict.device == "the wind sensor"
        assert termios.tcgetattr(port) == before
    end.unplug()


@pytest.mark.parametrize(
    ("links", "twin", "name", "note"),
    [
        (
            ("serial/by-id/usb-FTDI_A1-if00-port0", "serial/by-path/pci-0:1.0-port0", "usv-gnss"),
            False,
            "serial/by-id/usb-FTDI_A1-if00-port0",
            "",
        ),
        (
            ("serial/by-id/usb-1a86_USB_Serial-if00-port0", "serial/by-path/pci-0:1.0-port0"),
            True,
            "serial/by-path/pci-0:1.0-port0",
            "call themselves the same",
        ),
        (("usv-gnss", "serial/by-path/platform-x"), False, "usv-gnss", ""),
        (("serial/by-path/platform-x",), False, "serial/by-path/platform-x", "no name of its own"),
        ((), False, "ttyUSB0", ""),
    ],
)
def test_the_name_that_lasts(tmp_path: Path, links: tuple[str, ...], twin: bool, name: str, note: str) -> None:
    device = tmp_path / "ttyUSB0"
    device.touch()
    (tmp_path / "ttyUSB1").touch()
    for link in (*links, "serial/by-id/usb-other"):
        (tmp_path / link).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / link).symlink_to(tmp_path / "ttyUSB1" if link.endswith("other") else device)
    found = named(device, "", twin, tmp_path)
    assert found.name == tmp_path / name and note in found.note and bool(found.note) == bool(note)


AUDIT = """
import sys
seen = []
sys.addaudithook(lambda event, args: seen.append((event, str(args[0]))) if event in ("open", "socket.__new__", "socket.bind", "socket.connect") else None)
from companion.cli.main import main

def opened(*arguments):
    seen.clear()
    assert main(arguments) == 0
    return [(event, what) for event, what in seen if event != "open" or what.startswith(("/dev/", sys.argv[1]))]

from companion.config.vessel import bundled
for vessel in bundled():
    assert not opened("check", vessel), seen
run = opened("run", "revolt", "--duration", "0.3", "--link", "udpout:127.0.0.1:9", "--state", sys.argv[1] + "/s", "--log", sys.argv[1] + "/l")
assert any(event == "socket.__new__" for event, _ in run), "the hook sees what is opened"
"""


@pytest.mark.process
def test_check_opens_no_port_at_all(tmp_path: Path) -> None:
    done = run_to_end([sys.executable, "-c", AUDIT, str(tmp_path)])
    assert done.returncode == 0, done.stderr


def test_what_is_neither_an_address_nor_a_name_is_refused(tmp_path: Path) -> None:
    text = find("aboat").read_text(encoding="utf-8").replace("serial:/dev/usv-wind:4800", "udpin:boat local:5000")
    file = tmp_path / "boat.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"boat.toml:\d+: sensor\[3\].port: .*'boat local' should be an IP address"):
        load_vessel(str(file))
