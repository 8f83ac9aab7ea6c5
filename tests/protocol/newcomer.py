"""A newcomer's path, timed: `companion new` by its questions, `check`, `run --sitl`, a sea trial asked for by a ground
station (pymavlink), its model accepted, a reboot, and Hold. No file is edited by hand.

    python -m tests.protocol.newcomer FOLDER [SPEED]
"""

from __future__ import annotations

import os
import pty
import select
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import VesselConfig, load, parse
from tests.copies import run_to_end
from tests.protocol.process import Companion
from tests.waiting import CAP_S

ANSWERS: tuple[tuple[str, str], ...] = (
    ("Short name", "my_cat"),
    ("Name for people", ""),
    ("Form of the hull", "catamaran"),
    ("Length of the waterline", "1,2"),
    ("Width over all", "0.9 m"),
    ("Mass afloat", "30"),
    ("Width of one of the two hulls", "0.2"),
    ("Depth below the water", ""),
    ("Top speed", ""),
    ("Thrusters", ""),
    ("Motor of each thruster", "T200"),
    ("Voltage at the motor", ""),
    ("Distance from the port to the starboard thrusters", ""),
    ("What drives the motors", ""),
    ("Satellite receiver", "two"),
    ("Latitude", ""),
    ("Longitude", ""),
    ("Write ", ""),
)
"""What is asked, and what the newcomer types; an empty line takes what is proposed."""
MANUAL, HOLD = 0x00010000, 0x03040000
TRIAL, MODE, ARM, REBOOT = 31014, 176, 400, 246
_LONGEST_S = 3000.0  # of the boat's time
_QUIET_S = 120.0  # of wall time, without anything heard


def answered(file: Path) -> str:
    """`companion new FILE` in a terminal of its own; returns what stood there at the end."""
    process, terminal = pty.fork()
    if process == 0:
        os.execv(sys.executable, [sys.executable, "-m", "companion", "new", str(file)])
    shown, questions = "", list(ANSWERS)
    while True:
        if not select.select([terminal], [], [], CAP_S)[0]:
            raise AssertionError(f"nothing more is asked: {shown[-300:]}")
        try:
            data = os.read(terminal, 65536)
        except OSError:  # Linux: the terminal is gone with its last process
            break
        if not data:
            break
        shown += data.decode("utf-8", "replace")
        if questions and _asks(shown, questions[0][0]):
            os.write(terminal, (questions.pop(0)[1] + "\n").encode())
            shown += "\n"
    _, status = os.waitpid(process, 0)
    os.close(terminal)
    assert os.waitstatus_to_exitcode(status) == 0 and not questions, shown
    return shown


def _asks(shown: str, question: str) -> bool:
    """Whether the last paragraph is that question, with the cursor behind it."""
    last = shown.rpartition("\n\n")[2] if "\n\n" in shown else shown
    return question in last and last.endswith(": ")


@dataclass
class Station:
    """A ground station on the boat's TCP link."""

    port: int
    speed: float
    texts: list[str] = field(default_factory=list)
    now_s: float = 0.0
    mode: int = -1
    armed: bool = False
    ready: bool = False
    _acks: list[tuple[int, int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._link: Any = mavutil.mavlink_connection(f"tcp:127.0.0.1:{self.port}", source_system=255, retries=30)
        self._beat_s = 0.0

    def listen(self, until: Callable[[], Any], what: str, within_s: float = _LONGEST_S) -> None:
        """Until `until()`. Raises AssertionError after so much of the boat's time."""
        begun_s, heard = self.now_s, time.monotonic()
        while not until():
            assert self.now_s < begun_s + within_s, f"{what}: not within {within_s:g} s; {self.texts[-5:]}"
            assert time.monotonic() < heard + _QUIET_S, f"{what}: nothing is heard; {self.texts[-5:]}"
            if time.monotonic() > self._beat_s:
                self._link.mav.heartbeat_send(6, 8, 0, 0, 4)
                self._beat_s = time.monotonic() + 0.2
            message = self._link.recv_match(blocking=True, timeout=0.1)
            if message is not None:
                heard = time.monotonic()
                self._take(message)

    def _take(self, message: Any) -> None:
        match message.get_type():
            case "HEARTBEAT":
                self.mode = message.custom_mode
                self.armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
            case "STATUSTEXT":
                self.texts.append(message.text)
            case "ATTITUDE":
                self.now_s = message.time_boot_ms / 1000.0
            case "SYS_STATUS":
                self.ready = bool(message.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_PREARM_CHECK)
            case "COMMAND_ACK" if message.result != mavlink.MAV_RESULT_IN_PROGRESS:
                self._acks.append((message.command, message.result))

    def command(self, number: int, *params: float) -> int:
        """Send a command; returns its result."""
        self._acks.clear()
        self._link.mav.command_long_send(1, 1, number, 0, *(*params, *(0.0,) * 7)[:7])
        self.listen(lambda: any(command == number for command, _ in self._acks), f"answer to {number}", 60.0)
        return next(result for command, result in self._acks if command == number)

    def begin(self, mode: int) -> None:
        """Armed in that mode, as soon as the boat can."""
        self.listen(lambda: self.ready, "ready to arm", 300.0)
        assert self.command(MODE, 1.0, float(mode)) == 0, self.texts[-3:]
        assert self.command(ARM, 1.0) == 0, self.texts[-3:]

    def close(self) -> None:
        """Hang up."""
        self._link.close()


@dataclass(frozen=True)
class Sailed:
    """What it took: minutes of the boat's time for the trial with what came before, and for all; how far off the point
    the boat was at last; the boat's texts."""

    trial_min: float
    whole_min: float
    worst_m: float
    length_m: float
    texts: tuple[str, ...]


def sail(folder: Path, speed: float, tell: Callable[[str], None] = print) -> Sailed:
    """The whole path, below `folder`."""
    file = folder / "my_cat.toml"
    answered(file)
    written = file.read_bytes()
    check = run_to_end("check", str(file))
    assert check.returncode == 0, check.stdout + check.stderr
    tell(check.stdout.strip())
    with Companion(folder, speed, ("--wind=3@200", "--current=0.1@70"), vessel=str(file)) as companion:
        station = Station(companion.tcp_port, speed)
        station.begin(MANUAL)
        assert station.command(TRIAL, 0.0, 1.0) != 0  # nothing to accept yet
        assert station.command(TRIAL) == 0, station.texts[-3:]
        station.listen(lambda: _said(station, "Trial: complete"), "the trial")
        tell(f"{_said(station, 'Trial: complete')} (at {station.now_s / 60.0:.1f} min)")
        trial_s = station.now_s
        station.listen(lambda: any(text.endswith("?") for text in station.texts), "the model")
        tell(f"{station.texts[-1]} (at {station.now_s / 60.0:.1f} min)")
        assert station.command(TRIAL, 0.0, 1.0) == 0, station.texts[-3:]
        assert station.command(ARM, 0.0) == 0
        assert station.command(REBOOT, 1.0) == 0, station.texts[-3:]
        before_s = station.now_s
        station.close()
        companion.hello = companion.read_hello()
        assert load(file) != alone(file)
        again = Station(companion.tcp_port, speed)
        again.begin(HOLD)
        again.listen(lambda: again.mode == HOLD and again.armed, "Hold", 60.0)
        held_s = again.now_s + 60.0
        again.listen(lambda: again.now_s > held_s + 60.0, "holding", 300.0)
        worst_m = _off_m(companion, held_s)
        again.close()
        texts = (*station.texts, *again.texts)
        whole_min = (before_s + again.now_s) / 60.0
    assert file.read_bytes() == written
    return Sailed(trial_s / 60.0, whole_min, worst_m, load(file).length_m, texts)


def alone(file: Path) -> VesselConfig:
    """The vessel without its overlays."""
    return parse(file.read_text(encoding="utf-8"), str(file))


def _said(station: Station, start: str) -> str:
    return next((text for text in station.texts if text.startswith(start)), "")


def _off_m(companion: Companion, from_s: float) -> float:
    """How far the boat was from the mean of its places, by the truth."""
    rows = [row for row in companion.rows("truth.csv") if float(row["t_s"]) >= from_s]
    north, east = ([float(row[name]) for row in rows] for name in ("north_m", "east_m"))
    centre = sum(north) / len(rows), sum(east) / len(rows)
    return max(((n - centre[0]) ** 2 + (e - centre[1]) ** 2) ** 0.5 for n, e in zip(north, east, strict=True))


if __name__ == "__main__":
    made = sail(Path(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 10.0)
    print(f"trial complete after {made.trial_min:.1f} min, all after {made.whole_min:.1f} min of the boat's time")
    print(f"Hold: at most {made.worst_m:.2f} m from the mean place, {made.worst_m / made.length_m:.1f} lengths")
