"""Trolling motors on an NMEA 2000 network, their turn-angle sensors and a battery monitor.

Written byte by byte from the frames' definition, apart from the driver, so that each checks the other. Each motor has
an address of its own (20 + its instance). It obeys 126208 commands of its 128006, and stops when they pause for longer
than the time-out they carry. It sends 128006 four times a second and 128008 every two seconds. The sensors, at one
address, send 127245 ten times a second; the monitor sends 127508 and 127506 every 1.5 s.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence

from companion.config.actuators.nmea2000 import Nmea2000Config
from companion.core.angles import TWO_PI
from sitl.battery import LOW_REMAINING, LOW_VOLTAGE_V, BatteryModel
from sitl.drives import DriveModel
from sitl.faults import Faults
from sitl.memory import MemoryDevice
from sitl.thrusters import ThrusterModel

_SENSORS, _MONITOR = 60, 61
_NOBODY = 0x3FF
_DEFAULT_TIMEOUT_S = 0.35
_FIELD_BYTES = {1: 1, 2: 1, 3: 1, 4: 1, 5: 1, 6: 1, 7: 1, 8: 1, 9: 2}
_OFF, _READY, _PORT, _STARBOARD = 0, 1, 2, 3


class Nmea2000Emulator:
    """The network's other devices. While the fault `drive_<thruster>_lost` is active a motor neither receives nor
    sends, and has stopped."""

    def __init__(
        self,
        config: Nmea2000Config,
        port: MemoryDevice,
        thrusters: Sequence[ThrusterModel],
        battery: BatteryModel,
        faults: Faults,
    ) -> None:
        self.name = config.name
        self.rate_hz = 20.0
        self.rc_us: Sequence[int] | None = None  # this network carries no RC channels
        self._port = port
        self._battery = battery
        self._faults = faults
        names = tuple(dict.fromkeys((*config.thrusters, *config.azimuths)))
        by_name = dict(zip(names, thrusters, strict=True))
        self.motors = [
            EmulatedMotor(
                row.thruster, row.instance, row.sensor_instance, by_name[row.thruster], row.thruster in config.thrusters
            )
            for row in config.motors
        ]
        self._fast: dict[tuple[int, int], bytearray] = {}
        self._next: dict[tuple[int, int], int] = {}
        self._turn = 0
        self._sequence = 0
        self._introduced = False
        self._rest = b""

    def listen(self, t_s: float) -> None:
        """Handle the frames that have arrived by `t_s`, then the commands' time-outs."""
        for _, chunk in self._port.receive(t_s):
            for at in range(0, len(chunk) - 15, 16):
                word, length = struct.unpack_from("<IB", chunk, at)
                if word >> 29 == 4 and length <= 8:  # extended, neither remote nor error
                    self._hear(word & 0x1FFFFFFF, chunk[at + 8 : at + 8 + length], t_s)
        for motor in self.motors:
            motor.mind(t_s, self._lost(motor))

    def speak(self, t_s: float) -> None:
        """Send what is due."""
        self._turn += 1
        if not self._introduced:
            self._introduced = True
            self._claim(t_s)
        active = self._faults.active
        for motor in self.motors:
            if self._lost(motor):
                continue
            if self._turn % 5 == 0:
                self._send(2, 128006, motor.address, motor.status(), t_s)
            if self._turn % 10 == 0:
                self._send(
                    2, 128008, motor.address, struct.pack("<BBBBHH", 255, motor.instance, 0, 255, 0xFFFF, 0xFFFF), t_s
                )
            if self._turn % 2 == 0 and motor.steerable:
                angle = round(math.remainder(motor.angle_rad, TWO_PI) * 1e4)
                self._send(2, 127245, _SENSORS, struct.pack("<BBhhH", motor.sensor, 0xF8, 0x7FFF, angle, 0xFFFF), t_s)
        if self._turn % 30 == 0:
            low = "battery_low" in active
            volts = LOW_VOLTAGE_V if low else self._battery.voltage_v
            amps = -(self._battery.current_a or 0.0)  # NMEA 2000 counts discharge as negative
            self._send(
                6,
                127508,
                _MONITOR,
                struct.pack("<BHhHB", 0, round(volts * 100.0), round(amps * 10.0), 0xFFFF, 255),
                t_s,
            )
            share = LOW_REMAINING if low else self._battery.remaining
            self._send_fast(
                6,
                127506,
                _MONITOR,
                struct.pack("<BBBBBHHH", 255, 0, 0, round(share * 100.0), 255, 0xFFFF, 0xFFFF, 0xFFFF),
                t_s,
            )

    def _lost(self, motor: EmulatedMotor) -> bool:
        return not self._faults.active.isdisjoint((f"drive_{motor.thruster_name}_lost", "mcu_silent"))

    def _hear(self, identifier: int, data: bytes, t_s: float) -> None:
        group, destination, source = identifier >> 16 & 0x1FF, identifier >> 8 & 0xFF, identifier & 0xFF
        if group == 0xEA and len(data) >= 3:  # 59904, a request
            self._answer(data[0] | data[1] << 8 | data[2] << 16, destination, t_s)
        elif group == 0x1ED and data:  # 126208, in parts
            payload = self._collect((source, destination), data)
            for motor in () if payload is None or "mcu_deaf" in self._faults.active else self.motors:
                if motor.address == destination and payload is not None and not self._lost(motor):
                    self._obey(motor, payload, source, t_s)

    def _answer(self, pgn: int, destination: int, t_s: float) -> None:
        """Send the group that was requested."""
        if pgn == 60928:
            self._claim(t_s)
        elif pgn == 128006:
            for motor in self.motors:
                if not self._lost(motor) and destination in (255, motor.address):
                    self._send(2, 128006, motor.address, motor.status(), t_s)

    def _collect(self, key: tuple[int, int], data: bytes) -> bytes | None:
        """Collect a fast packet: sequence and part number in the first byte, the length in the second byte of the first
        part. Returns the whole payload, or None until then."""
        part = data[0] & 31
        if part == 0 and len(data) == 8:
            self._fast[key] = bytearray((data[0] >> 5, data[1])) + data[2:]
            self._next[key] = 1
        elif key in self._fast and part == self._next[key] and data[0] >> 5 == self._fast[key][0]:
            self._fast[key] += data[1:]
            self._next[key] += 1
        else:
            self._fast.pop(key, None)
            return None
        if len(self._fast[key]) - 2 < self._fast[key][1]:
            return None
        whole = self._fast.pop(key)
        return bytes(whole[2 : 2 + whole[1]])

    def _obey(self, motor: EmulatedMotor, payload: bytes, source: int, t_s: float) -> None:
        if len(payload) < 6 or payload[0] != 1 or payload[1:4] != (128006).to_bytes(3, "little"):
            return
        fields: dict[int, int] = {}
        at = 6
        for _ in range(payload[5]):
            size = _FIELD_BYTES.get(payload[at]) if at < len(payload) else None
            if size is None or at + 1 + size > len(payload):
                return
            fields[payload[at]] = int.from_bytes(payload[at + 1 : at + 1 + size], "little")
            at += 1 + size
        understood = motor.command(fields, t_s)
        answer = bytes((2, *payload[1:4], 0 if understood else 3, payload[5])) + bytes((payload[5] + 1) // 2)
        self._send_fast(3, 126208, motor.address, answer, t_s, source)

    def _claim(self, t_s: float) -> None:
        for number, address in enumerate([*(motor.address for motor in self.motors), _SENSORS, _MONITOR]):
            name = (1000 + number) | _NOBODY << 21 | 130 << 40 | 50 << 49 | 4 << 60 | 1 << 63
            self._send(6, 60928, address, name.to_bytes(8, "little"), t_s, 255)

    def _send(self, priority: int, pgn: int, source: int, data: bytes, t_s: float, destination: int = 255) -> None:
        group = pgn >> 8
        identifier = priority << 26 | (pgn << 8 if group & 0xFF >= 240 else (pgn | destination) << 8) | source
        self._port.send(struct.pack("<IB3x8s", 0x80000000 | identifier, len(data), data), t_s)

    def _send_fast(
        self, priority: int, pgn: int, source: int, payload: bytes, t_s: float, destination: int = 255
    ) -> None:
        self._sequence = (self._sequence + 1) % 8
        rest = bytes((len(payload),)) + payload
        for part, at in enumerate(range(0, len(rest), 7)):
            self._send(
                priority,
                pgn,
                source,
                bytes((self._sequence << 5 | part,)) + rest[at : at + 7].ljust(7, b"\xff"),
                t_s,
                destination,
            )


class EmulatedMotor:
    """One motor. Remembers its last command, and when it came."""

    def __init__(
        self, thruster_name: str, instance: int, sensor: int | None, thruster: ThrusterModel, propels: bool
    ) -> None:
        self.thruster_name = thruster_name
        self.instance = instance
        self.sensor = instance if sensor is None else sensor
        self.address = 20 + instance
        self._thruster = thruster
        self._drive = DriveModel(thruster.config, pulses=False)
        self._propels = propels
        self._told_s: float | None = None
        self._way = _OFF
        self._speed = 0
        self._timeout_s = _DEFAULT_TIMEOUT_S

    @property
    def steerable(self) -> bool:
        """Whether it turns its thruster."""
        return self._thruster.steerable

    @property
    def angle_rad(self) -> float:
        """The angle that it reports."""
        return self._drive.shown_rad(self._thruster.azimuth_rad)

    def command(self, fields: dict[int, int], t_s: float) -> bool:
        """Carry out a command's fields. Returns False for fields that it does not accept."""
        if fields.get(2) != self.instance or fields.get(3, _OFF) > _STARBOARD or fields.get(6, 0) > 100:
            return False
        self._told_s = t_s
        self._way = fields.get(3, _OFF) if fields.get(4) == 1 else _OFF
        self._speed = fields.get(6, 0)
        self._timeout_s = fields[8] * 0.005 if 8 in fields else self._timeout_s
        push = self._speed / 100.0 * (1 if self._way == _STARBOARD else -1 if self._way == _PORT else 0)
        if self._propels:
            self._thruster.drive(self._drive.throttle(push))
        azimuth_rad = self._drive.azimuth_rad(fields[9] * 1e-4) if 9 in fields and self._way != _OFF else None
        if azimuth_rad is not None:
            self._thruster.aim(azimuth_rad)
        return True

    def mind(self, t_s: float, lost: bool) -> None:
        """Stop after the time-out, or while `lost`."""
        if self._told_s is not None and (lost or t_s - self._told_s > self._timeout_s):
            self._told_s = None
            self._way, self._speed = _OFF, 0
            if self._propels:
                self._thruster.drive(0.0)

    def status(self) -> bytes:
        """Payload of 128006: what it does now."""
        push = self._drive.level(self._thruster.throttle())
        percent = min(100, round(abs(push) * 100.0))
        way = (
            _OFF
            if self._way == _OFF and percent == 0
            else _READY
            if percent == 0
            else _STARBOARD
            if push > 0.0
            else _PORT
        )
        azimuth = round(self.angle_rad % TWO_PI * 1e4) if self.steerable else 0xFFFF
        return struct.pack(
            "<BBBBBBH",
            255,
            self.instance,
            way | (self._way != _OFF) << 4,
            percent,
            0,
            round(self._timeout_s / 0.005),
            azimuth,
        )
