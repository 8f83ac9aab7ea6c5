"""Stepper drives on one RS485 line, each turning a thruster, as Nanotec's SMCI firmware answers.

Written from the programming manual, apart from the driver, so that each checks the other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.actuators.nanotec import NanotecConfig, StepperConfig
from companion.core.angles import TWO_PI, wrap_pi
from sitl.battery import BatteryModel
from sitl.drives import DriveModel
from sitl.faults import Faults
from sitl.memory import MemoryDevice
from sitl.thrusters import ThrusterModel

_FACTORY = {
    "g": 8,
    "p": 1,
    "s": 0,
    "u": 400,
    "o": 1000,
    "W": 1,
    "J": 0,
    "|": 1,
    ":accel": 100_000,
    ":decel": 100_000,
    ":ramp_mode": 0,
}
_RANGES = {
    "p": (1, 19),
    "s": (-100_000_000, 100_000_000),
    "u": (1, 160_000),
    "o": (1, 1_000_000),
    "W": (0, 254),
    "J": (0, 1),
    "|": (0, 1),
}
_RANGES |= {":accel": (1, 3_000_000), ":decel": (1, 3_000_000), ":ramp_mode": (0, 2)}
_STEP_MODES = (1, 2, 4, 5, 8, 10, 16, 32, 64, 254, 255)
_FOLLOWING_ERROR_RAD = math.radians(10.0)
_BLOCKED = 16  # error number of a following error


class NanotecEmulator:
    """The line with its drives. While the fault `drive_<thruster>_lost` is active a drive neither receives nor answers,
    and holds its angle.

    Answers are sent at once when a command comes; a real drive takes a millisecond or two.
    """

    def __init__(
        self,
        config: NanotecConfig,
        port: MemoryDevice,
        thrusters: Sequence[ThrusterModel],
        battery: BatteryModel,
        faults: Faults,
    ) -> None:
        self.name = config.name
        self.rate_hz = 1.0
        self.rc_us: Sequence[int] | None = None  # this line carries no RC channels
        self._port = port
        self._faults = faults
        by_name = dict(zip((*config.thrusters, *config.azimuths), thrusters, strict=True))
        self.drives = {row.address: EmulatedDrive(row, by_name[row.thruster]) for row in config.drives}
        self._heard = b""
        port.wake = self._hear

    def listen(self, t_s: float) -> None:
        """Handle the commands that have arrived by `t_s`, and turn the drives."""
        self._hear(t_s)
        for drive in self.drives.values():
            drive.turn(t_s)

    def speak(self, t_s: float) -> None:
        """Nothing: a drive only answers."""

    def _hear(self, t_s: float) -> None:
        for arrival_s, data in self._port.receive(t_s):
            *lines, self._heard = (self._heard + data).split(b"\r")
            for line in lines:
                self._obey(line, max(arrival_s, 0.0))
            self._heard = self._heard[-128:]

    def _obey(self, line: bytes, t_s: float) -> None:
        start = line.rfind(b"#")  # bytes before a start character are noise
        text = line[start + 1 :].decode("ascii", "replace") if start >= 0 else ""
        digits = len(text) - len(text.lstrip("0123456789"))
        everybody = text.startswith("*")
        command = text[1:] if everybody else text[digits:]
        for address, drive in self.drives.items():
            if not everybody and (digits == 0 or digits > 3 or int(text[:digits]) != address):
                continue
            if not command or not self._faults.active.isdisjoint(
                (f"drive_{drive.thruster_name}_lost", "mcu_silent", "mcu_deaf")
            ):
                continue
            answer = drive.obey(command)
            if not everybody:  # all would answer at once, so none does
                shown = f"{address:03d}" if command in ("$", "v") else str(address)
                self._port.send(f"{shown}{answer}\r".encode("ascii", "replace"), t_s)


class EmulatedDrive:
    """One drive with its motor. Remembers its settings, its motion, and the offset from counter to thruster angle."""

    def __init__(self, row: StepperConfig, thruster: ThrusterModel) -> None:
        self.thruster_name = row.thruster
        self._row = row
        self._thruster = thruster
        self._belt = DriveModel(thruster.config, pulses=False)
        self._steps_per_rad = row.steps_per_turn / TWO_PI
        self._turned_rad = thruster.azimuth_rad  # the thruster's angle, with whole turns
        self._t_s: float | None = None
        self.power_up()
        if row.homing == "here":
            self._offset = 0.0  # a person has set the zero by hand

    def power_up(self) -> None:
        """Reset as after a loss of power: factory settings, counter 0 wherever the thruster stands."""
        self.settings = dict(_FACTORY)
        self._offset = self._shaft()  # counter = steps of the shaft minus this
        self._commanded = self._target = self._speed = 0.0
        self._running = self._homing = self.referenced = self._failed = False
        self.errors: list[int] = []

    @property
    def counter(self) -> float:
        """Steps, as its encoder counts them."""
        return self._shaft() - self._offset

    def obey(self, command: str) -> str:
        """The answer to a command, without the address."""
        if (value := self._read(command)) is not None:
            return value
        return command if self._act(command) or self._set(command) else f"{command}?"

    def _read(self, command: str) -> str | None:
        """The answer to a command that reads a value; None for any other."""
        match command:
            case "$":
                at_zero = self.referenced and abs(self.counter) < 1.0
                return f"${int(0xA0 | (not self._running) | at_zero << 1 | self._failed << 2)}"
            case "C" | "I":
                return f"{command}{round(self.counter):+d}"
            case ":is_referenced":
                return f"{command}{int(self.referenced):+d}"
            case "v":
                return "v PD2-N_RS485_17-05-2011-rev3711"
            case "E":
                return f"E{min(len(self.errors), 32)}"
            case _:
                return command + self._shown(command[1:]) if command[0] == "Z" else None

    def _act(self, command: str) -> bool:
        """Start, stop or reset the counter. Returns False for any other command."""
        if command == "A":
            self._start()
            return True
        if command in ("S", "S0", "S1"):
            self._stop()
            return True
        return command[0] == "D" and self._reset(command[1:])

    def turn(self, t_s: float) -> None:
        """Follow the speed ramp up to `t_s`."""
        dt_s = 0.0 if self._t_s is None else t_s - self._t_s
        self._t_s = t_s
        self._turned_rad += wrap_pi(self._thruster.azimuth_rad - self._turned_rad)
        if not self._running or dt_s <= 0.0:
            return
        if abs(self._commanded - self.counter) > _FOLLOWING_ERROR_RAD * self._steps_per_rad:
            self._stop()
            self._failed = True
            self.errors.append(_BLOCKED)
            return
        left = self._target - self._commanded
        ramp = min(self.settings[":accel"], self.settings[":decel"])
        wanted = math.copysign(min(self.settings["o"], math.sqrt(2.0 * ramp * abs(left))), left)
        self._speed += min(max(wanted - self._speed, -ramp * dt_s), ramp * dt_s)
        if abs(left) <= max(1.0, abs(self._speed) * dt_s):
            self._commanded, self._speed = self._target, 0.0
            self._running = abs(self.counter - self._target) > 2.0
            if self._homing and not self._running:
                self._offset, self._commanded, self._target = self._shaft(), 0.0, 0.0
                self._homing, self.referenced = False, True
        else:
            self._commanded += self._speed * dt_s
        self._aim()

    def _shaft(self) -> float:
        return self._belt.shown_rad(self._turned_rad) * self._steps_per_rad

    def _aim(self) -> None:
        azimuth_rad = self._belt.azimuth_rad((self._commanded + self._offset) / self._steps_per_rad)
        if azimuth_rad is not None:
            self._thruster.aim(azimuth_rad)

    def _start(self) -> None:
        if self._failed:
            return
        if not self._running:
            self._commanded, self._speed = self.counter, 0.0
        self._running, self._homing = True, self.settings["p"] == 4
        if self._homing:  # clockwise to the switch, which is at zero
            turns = math.ceil((self._shaft() - 1.0) / self._row.steps_per_turn)
            self._target = turns * self._row.steps_per_turn - self._offset
        else:
            self._target = self.settings["s"] + (self._commanded if self.settings["p"] == 1 else 0.0)

    def _stop(self) -> None:
        self._commanded = self._target = self.counter
        self._speed = 0.0
        self._running = self._homing = False
        self._aim()

    def _reset(self, text: str) -> bool:
        steps = self.counter if not text else _number(text)
        if steps is None:
            return False
        self._stop()
        self._failed = False
        self._offset = self._shaft() - steps
        self._commanded = self._target = steps
        return True

    def _shown(self, name: str) -> str:
        if name.endswith("E") and name[:-1].isdigit():
            place = int(name[:-1])
            return str(self.errors[place - 1] if 1 <= place <= len(self.errors) else 0)
        return f"{self.settings[name]:+d}" if name in self.settings else "?"

    def _set(self, command: str) -> bool:
        name, equals, text = command.partition("=") if command[0] == ":" else (command[0], "", command[1:])
        value = _number(text)
        if name not in self.settings or value is None or (name[0] == ":") != bool(equals):
            return False
        low, high = _RANGES.get(name, (0, 0))
        if not (value in _STEP_MODES if name == "g" else low <= value <= high):
            return False
        self.settings[name] = value
        return True


def _number(text: str) -> int | None:
    return (
        int(text)
        if text.lstrip("+-").isdigit() and text.isascii() and len(text) < 12 and len(text) - len(text.lstrip("+-")) < 2
        else None
    )
