"""Bridge to Nanotec stepper drives on one RS485 line, which turn the azimuths of thrusters whose propellers another
bridge drives.

`#<address><command>\\r` goes out; `<address><command>[<value>]\\r` comes back, with a `?` behind it for what the drive
does not know. The line is half duplex: the next command waits for the answer to the last one, or for its time-out. The
drives take turns.

A stepper has no watchdog: without commands it ends its run, at most half a turn, and holds that angle with its torque.
Disarmed, it stops where it is and stays; the other bridge stops the propeller, and with it the push. With
`homing = "switch"` a drive that does not know its angle turns slowly to its reference switch as soon as it answers,
armed or not: keep hands off.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from companion.config.actuators.nanotec import NanotecConfig
from companion.config.vessel import ConfigError, VesselConfig
from companion.core.actuation import ActuatorCommand, ThrusterFeedback
from companion.core.ports import ByteStream
from companion.core.readings import Reading
from companion.core.tick import DeviceHealth
from companion.io.actuators.nanotec_drive import Drive, DrivePhase

_ANSWER_S = 0.1  # a drive answers in some milliseconds, a USB adapter may hold that back for 16
_LONGEST_LINE = 80
_MOST_EXCHANGES = 40  # in one call, of a line that answers at once
_SILENT_BYTES = 100  # that many bytes without one answer: not the language or not the speed
_REPORT_PERIOD_S = 0.5  # of a drive that does not run
_LINE = re.compile(rb"0{0,2}(\d{1,3})(\D.*)", re.DOTALL)
_VALUE = re.compile(rb"[+=]?(-?\d{1,10})")


class NanotecBridge:
    """`ActuatorCommand` → positions of the drives; their positions → `ThrusterFeedback` of azimuths.

    Remembers the request that waits for its answer, the unfinished line, and whose turn it is.
    """

    def __init__(self, config: NanotecConfig, vessel: VesselConfig, stream: ByteStream) -> None:
        """Raises ConfigError for throttles to drive, for azimuths without a drive, and for speeds and ramps that a
        drive does not have."""
        self.name = config.name
        self._config = config
        self._stream = stream
        if config.thrusters:
            text = f"drives azimuths only: name '{config.thrusters[0]}' in 'azimuths', and another bridge for it"
            raise ConfigError([f"actuator '{config.name}': {text}"])
        names = [thruster.name for thruster in vessel.thrusters]
        by_thruster = {drive.thruster: drive for drive in config.drives}
        missing = [name for name in config.azimuths if name not in by_thruster]
        if missing or not config.azimuths:
            lacking = missing or ["each azimuth"]
            raise ConfigError(
                [f"actuator '{config.name}': needs an [[actuator.drive]] for '{name}'" for name in lacking]
            )
        self.drives = tuple(
            Drive(names.index(name), vessel.thrusters[names.index(name)], by_thruster[name]) for name in config.azimuths
        )
        self._by_address = {drive.address: drive for drive in self.drives}
        self._turn = 0
        self._pending: tuple[Drive, str, float] | None = None
        self._buffer = b""
        self._readings: list[Reading] = []
        self._reported_s = {drive.index: 0.0 for drive in self.drives}
        self._heard_s: float | None = None
        self._bytes_since_answer = 0
        self._answers = self._bad = self._unanswered = 0

    def read(self, now_s: float) -> Sequence[Reading]:
        """Azimuths measured since the last call, each at the time of arrival. An answer lets the next request go
        out."""
        self._exchange(now_s)
        readings, self._readings = self._readings, []
        return readings

    def write(self, command: ActuatorCommand, now_s: float) -> None:
        """New targets for all drives, each in its turn; armed only."""
        for drive in self.drives:
            azimuth_rad = command.thrusters[drive.index].azimuth_rad
            if command.armed and azimuth_rad is not None:
                drive.demand(azimuth_rad)
            else:
                drive.halt()
            if (
                drive.known
                and not drive.ok
                and not self._silent()
                and now_s - self._reported_s[drive.index] >= _REPORT_PERIOD_S
            ):
                self._report(drive, now_s)
        self._exchange(now_s)

    def health(self, now_s: float) -> DeviceHealth:
        """Ok while one drive answers and none is on its way to its first angle. A single drive that fails is a thruster
        that fails."""
        age_s = None if self._heard_s is None else now_s - self._heard_s
        fault = self._stream.fault()
        trouble = [drive.trouble for drive in self.drives if drive.trouble]
        unknown = not all(drive.known for drive in self.drives)
        silent = self._silent() or age_s is None or age_s > self._config.timeout_s
        counts = f"{self._answers} answers, {self._unanswered} missing, {self._bad} bad"
        text = fault or (self._silence(age_s) if silent else "; ".join(trouble))
        return DeviceHealth(
            self.name, fault is None and not silent and not unknown, age_s, f"{text} ({counts})" if text else counts
        )

    def fileno(self) -> int | None:
        """See `Actuator`."""
        return self._stream.fileno()

    def close(self) -> None:
        """All drives stop. Their answers are not awaited."""
        if self._heard_s is not None:
            self._stream.write(b"#*S1\r", self._heard_s)
        self._stream.close()

    def _silent(self) -> bool:
        """Whether no drive answers at all. The bridge reports that once, not each thruster."""
        return all(drive.phase is DrivePhase.ABSENT for drive in self.drives)

    def _silence(self, age_s: float | None) -> str:
        if self._bytes_since_answer >= _SILENT_BYTES:
            return f"bytes arrive but no answers: wrong baud rate in '{self._config.port}', or no Nanotec drive there"
        if age_s is None:
            return "no drive has answered yet: check their power, their addresses, and A and B of the RS485 line"
        return f"no drive has answered for {age_s:.1f} s: check their power and the RS485 line; they hold their angle"

    def _exchange(self, now_s: float) -> None:
        """Take what has come in; send the next request while answers come."""
        if self._stream.fault() is not None:
            self._pending, self._buffer = None, b""
        for _ in range(_MOST_EXCHANGES):
            self._take(now_s)
            if self._pending is not None:
                drive, _, sent_s = self._pending
                if now_s - sent_s < _ANSWER_S:
                    return
                self._pending = None
                self._unanswered += 1
                if drive.unanswered(now_s) and not self._silent():
                    self._report(drive, now_s)
            if not self._ask(now_s):
                return

    def _ask(self, now_s: float) -> bool:
        """Send the next request of the drive whose turn it is. Returns whether there was one."""
        for _ in self.drives:
            drive = self.drives[self._turn]
            self._turn = (self._turn + 1) % len(self.drives)
            command = drive.request(now_s)
            if command is not None:
                self._pending = drive, command, now_s
                self._stream.write(f"#{drive.address}{command}\r".encode("ascii"), now_s)
                return True
        return False

    def _take(self, now_s: float) -> None:
        for arrival_s, data in self._stream.read(now_s):
            self._bytes_since_answer += len(data)
            *lines, self._buffer = (self._buffer + data).split(b"\r")
            for line in lines:
                self._line(line, arrival_s)
            if len(self._buffer) > _LONGEST_LINE:
                self._buffer = b""
                self._bad += 1

    def _line(self, line: bytes, arrival_s: float) -> None:
        """One line: the answer to the pending request, or something to ignore (an adapter's echo, a late answer,
        noise)."""
        found = _LINE.fullmatch(line) if self._pending is not None and len(line) <= _LONGEST_LINE else None
        if found is None or self._pending is None:
            self._bad += not line.startswith(b"#")
            return
        drive, command, _ = self._pending
        asked, said = command.encode("ascii"), found[2]
        value = _VALUE.fullmatch(said, len(asked)) if _asks(command) else None
        rest = said[len(asked) :]
        fits = rest == b"?" or (value is not None if _asks(command) else rest == b"")
        if int(found[1]) != drive.address or not said.startswith(asked) or not fits:
            self._bad += 1
            return
        self._pending = None
        self._heard_s, self._bytes_since_answer = arrival_s, 0
        self._answers += 1
        if rest == b"?":
            drive.refused(command, arrival_s)
            return
        was_ok = drive.ok
        measured = drive.answered(command, int(value[1]) if value else None, arrival_s)
        if measured or drive.ok != was_ok:
            self._report(drive, arrival_s)

    def _report(self, drive: Drive, t_s: float) -> None:
        self._reported_s[drive.index] = t_s
        self._readings.append(ThrusterFeedback(t_s, self.name, drive.index, None, drive.azimuth_rad, drive.ok))


def _asks(command: str) -> bool:
    """Whether its answer holds a number behind it; others come back as they are."""
    return command[0] in "C$EZ" or command == ":is_referenced"
