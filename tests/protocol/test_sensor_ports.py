"""A boat on its own ports, without a plant: receiver and inertial sensor on ptys, a sounder on UDP, corrections by
MAVSDK, sentences out by UDP."""

from __future__ import annotations

import base64
import contextlib
import os
import select
import socket
import threading
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pynmea2
import pytest
from mavsdk.plugins.rtk import RtcmData, Rtk, RtkError
from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import find
from tests.protocol.driver import raw_pty
from tests.protocol.process import Companion, free_port
from tests.protocol.test_mavsdk import connected
from tests.unit.io.sensors.test_nmea0183 import sentence
from tests.unit.io.sensors.test_vectornav import VNYMR
from tests.unit.io.test_rtcm import frame
from tests.waiting import CAP_S, wait_until

pytestmark = pytest.mark.process

LENGTHS = (179, 180, 181, 360, 540, 719, 720)


class Bench:
    """The boat's devices: what they print goes out by a thread of its own, what is written to the receiver is kept."""

    def __init__(self, folder: Path) -> None:
        self.receiver, self._receiver_near = raw_pty()
        self._link = folder / "usv-imu"
        self.inertial: int | None = None
        self.commands: list[bytes] = []
        self._heard = b""
        self._lock = threading.Lock()
        self.plug()
        self.ports = os.ttyname(self._receiver_near), str(self._link)
        self.sounder_port = free_port()
        self.written = b""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        turn = 0
        while not self._stop.wait(0.02):
            turn += 1
            with self._lock:
                if self.inertial is not None:
                    self._inertial_turn(self.inertial)
            if turn % 5 == 0:
                clock = datetime.now(UTC).strftime("%H%M%S.%f")[:9]
                os.write(
                    self.receiver, sentence(f"GNGGA,{clock},6326.33401,N,01023.94001,E,4,17,0.6,10.4,M,40.0,M,1.2,0033")
                )
                os.write(self.receiver, b"\xd3\x00\x04binary" + sentence("GNHDT,100.9,T"))
            if turn % 10 == 0:
                out.sendto(sentence("SDDPT,7.4,0.3,100.0"), ("127.0.0.1", self.sounder_port))
            if select.select([self.receiver], [], [], 0)[0]:
                self.written += os.read(self.receiver, 65536)
        out.close()

    def _inertial_turn(self, port: int) -> None:
        """A VN-100: answers the commands, and talks when it has had both."""
        if select.select([port], [], [], 0)[0]:
            *lines, self._heard = (self._heard + os.read(port, 4096)).split(b"\n")
            for line in lines:
                self.commands.append(line)
                os.write(port, line + b"\n")
        if len(self.commands) >= 2:
            os.write(port, VNYMR)

    def plug(self) -> None:
        with self._lock:
            self.inertial, self._inertial_near = raw_pty()
            self.commands.clear()
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(os.ttyname(self._inertial_near))

    def unplug(self) -> None:
        with self._lock:
            assert self.inertial is not None
            os.close(self.inertial)
            os.close(self._inertial_near)
            self.inertial = None
            self._link.unlink()

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        for end in (self.receiver, self._receiver_near, self.inertial, self._inertial_near):
            if end is not None:
                os.close(end)


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    made = Bench(tmp_path)
    yield made
    made.close()


def vessel_file(folder: Path, bench: Bench, plotter: int) -> Path:
    text = find("revolt").read_text(encoding="utf-8")
    text = text.replace('"serial:/dev/usv-gnss:115200"', f'"serial:{bench.ports[0]}:115200"\nrtcm = true')
    text = text.replace(
        '"mtdata2"\nport = "serial:/dev/usv-imu:115200"',
        f'"vectornav"\nconfigure = true\nport = "serial:{bench.ports[1]}:115200"',
    )
    text = text.replace(
        "[dock]",
        f'[[sensor]]\nname = "sounder"\ndriver = "nmea0183"\nport = "udpin:127.0.0.1:{bench.sounder_port}"\nrate_hz = 5\n[dock]',
    )
    text = text.replace("[parameters]", f'[[nmea_out]]\nport = "udpout:127.0.0.1:{plotter}"\nrate_hz = 5\n[parameters]')
    file = folder / "boat.toml"
    file.write_text(text, encoding="utf-8")
    return file


class Listener:
    """A second ground station, by pymavlink."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=CAP_S)
        self._codec: Any = mavlink.MAVLink(None, srcSystem=250)
        self._codec.robust_parsing = True

    def until(self, kind: str, condition: Any = lambda message: True) -> Any:
        return wait_until(lambda: self._heard(kind, condition), f"a second ground station hears such a {kind}")

    def _heard(self, kind: str, condition: Any) -> Any:
        """The next such message that has come in; those after it in the same packet are passed over."""
        while select.select([self._socket], [], [], 0.0)[0]:
            for message in self._codec.parse_buffer(self._socket.recv(65536)) or ():
                if message.get_type() == kind and condition(message):
                    return message
        return None

    def close(self) -> None:
        self._socket.close()


def test_a_boat_on_its_own_ports(tmp_path: Path, bench: Bench) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plotter:
        plotter.bind(("127.0.0.1", 0))
        plotter.settimeout(CAP_S)
        boat = Companion(tmp_path, vessel=vessel_file(tmp_path, bench, plotter.getsockname()[1]))
        with boat, connected(boat) as system, contextlib.closing(Listener(boat.tcp_port)) as station:
            fix = station.until("GPS_RAW_INT", lambda m: m.fix_type == 6)
            assert (fix.satellites_visible, fix.lat / 1e7) == (17, pytest.approx(63.0 + 26.33401 / 60.0, abs=1e-5))
            rtk = station.until("GPS_RTK")
            assert (
                rtk.rtk_health == 1
                and 0 <= station.until("SYSTEM_TIME").time_boot_ms - rtk.time_last_baseline_ms < 5000
            )
            sonar = station.until("DISTANCE_SENSOR")
            assert (sonar.current_distance, sonar.max_distance, sonar.orientation) == (740, 10000, 25)
            attitude = station.until("ATTITUDE", lambda m: abs(m.pitch) > 0.05)
            assert attitude.pitch == pytest.approx(-0.128, abs=0.03), "VNYMR's −7.3°"

            messages = [frame(size, size) for size in LENGTHS]
            rtk_plugin = Rtk(system)
            for message in messages:
                rtk_plugin.send_rtcm_data(RtcmData(base64.b64encode(message).decode("ascii")))
            wait_until(lambda: len(bench.written) >= sum(LENGTHS), "corrections at the receiver")
            assert bench.written == b"".join(messages)
            stream = b"".join(frame(size, size) for size in (800, 1029, 25, 180, 719))
            for size in (179, 180, 181, 360, 720):
                bench.written = b""
                for k in range(0, len(stream), size):
                    rtk_plugin.send_rtcm_data(RtcmData(base64.b64encode(stream[k : k + size]).decode("ascii")))
                wait_until(lambda: len(bench.written) >= len(stream), f"a stream cut every {size} bytes")
                assert bench.written == stream
            with pytest.raises(RtkError, match="TOO_LONG"):  # MAVSDK's own limit: four fragments
                rtk_plugin.send_rtcm_data(RtcmData(base64.b64encode(frame(800)).decode("ascii")))

            said: dict[str, Any] = {}
            while "HDT" not in said or said["GGA"].gps_qual != 4:
                said = {
                    line[3:6]: pynmea2.parse(line, check=True)
                    for line in plotter.recv(65536).decode("ascii").splitlines()
                }
            assert said["GGA"].latitude == pytest.approx(63.0 + 26.33401 / 60.0, abs=1e-5) and float(
                said["HDT"].heading
            ) == pytest.approx(100.9, abs=1.0)

            assert bench.commands == [b"$VNWRG,06,14*59\r", b"$VNWRG,07,100*6C\r"]
            bench.unplug()
            lost = station.until("STATUSTEXT", lambda m: "imu: serial:" in m.text)
            assert lost.severity == 4
            bench.plug()
            station.until("STATUSTEXT", lambda m: "imu: back" in m.text)
            assert len(bench.commands) == 2, "told again what to send"
