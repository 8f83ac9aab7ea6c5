"""`companion sitl --physics` as an autopilot that is not this one meets it: pulses by UDP, the truth on file."""

from __future__ import annotations

import csv
import json
import math
import socket
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from companion.cli.main import main
from tests.protocol.process import free_port
from tests.waiting import wait_until

pytestmark = pytest.mark.process

RATE_HZ = 50


class Autopilot:
    """Steers north by heading alone, a frame at a time."""

    def __init__(self, port: int) -> None:
        self._link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._link.connect(("127.0.0.1", port))
        self._link.settimeout(0.5)
        self._count = 0
        self.state: dict[str, Any] = {}

    def frame(self, left_us: int, right_us: int) -> bool:
        """Whether the frame was answered. One that was not is sent again, as ArduPilot does."""
        data = struct.pack("<HHI16H", 18458, RATE_HZ, self._count, left_us, 0, right_us, *[0] * 13)
        try:
            self._link.send(data)
            self.state = json.loads(self._link.recv(2048))
        except OSError:
            return False
        self._count += 1
        return True

    def sail(self, frames: int) -> None:
        for _ in range(frames):
            turn = max(-150.0, min(150.0, 300.0 * self.state["attitude"][2] + 300.0 * self.state["imu"]["gyro"][2]))
            assert self.frame(round(1750 - turn), round(1750 + turn))

    def close(self) -> None:
        self._link.close()


def test_a_stranger_steers_the_plant_and_its_track_is_judged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port = free_port()
    command = [sys.executable, "-m", "companion", "sitl", "blueboat", "--physics", f"json:{port}"]
    command += ["--outputs", "port=1,starboard=3", "--wind", "3@270", "--log", str(tmp_path), "--duration", "20"]
    autopilot = Autopilot(port)
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, **streams) as plant:
        wait_until(lambda: autopilot.frame(1500, 1500), "the plant answers")
        autopilot.sail(200)
        assert plant.stdin is not None and plant.stdout is not None
        plant.stdin.write("gnss_lots\n")
        plant.stdin.flush()
        autopilot.sail(799)
        said, complaints = plant.communicate()
    autopilot.close()
    assert plant.returncode == 0 and "throttle on channel 3" in said and "--model JSON:127.0.0.1" in said
    assert "did you mean 'gnss_lost'?" in complaints
    north_m, east_m, _ = autopilot.state["position"]
    assert north_m > 15.0 and abs(math.degrees(autopilot.state["attitude"][2])) < 30.0
    (folder,) = [path.parent for path in tmp_path.glob("*/truth.csv")]
    last = list(csv.DictReader((folder / "truth.csv").read_text(encoding="utf-8").splitlines()))[-1]
    assert float(last["north_m"]) == pytest.approx(north_m, abs=0.2)
    assert float(last["east_m"]) == pytest.approx(east_m, abs=0.2)
    assert main(["evaluate", "hold", "blueboat", f"theirs={folder}", "--heading", "0"]) == 0
    assert "| heading, RMS, deg |" in capsys.readouterr().out
