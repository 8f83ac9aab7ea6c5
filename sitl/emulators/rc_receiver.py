"""RC receivers on a serial port, SBUS and CRSF, as their transmitter's channels say; written apart from the drivers.

`rc_us`: pulses of the transmitter's channels; None while the transmitter is off.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.config.devices import SensorConfig
from sitl.emulators.device import SensedWorld
from sitl.faults import Faults
from sitl.memory import MemoryDevice

_CENTRED = (1500,) * 8
_SAFE = (1500, 1500, 1500, 1500, 2000, 1500, 1500, 1500)
_COUNT = 16


class _Receiver:
    """What both have: the channels as the faults of the run leave them."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        self.name = config.name
        self.rate_hz = min(config.rate_hz, around.step_hz)
        self.rc_us: Sequence[int] | None = _CENTRED if around.faults.planned("rc_") else None
        self._config, self._port = config, port
        self._faults: Faults = around.faults
        self._steps = [992] * _COUNT  # of the last frame that the radio brought

    def _heard(self) -> bool:
        """Whether the transmitter is heard; then its channels are the newest."""
        if self.rc_us is None or "rc_lost" in self._faults.active:
            return False
        pulses = _SAFE if "rc_safe" in self._faults.active else self.rc_us
        for n, pulse_us in enumerate(pulses[:_COUNT]):
            self._steps[n] = min(2047, max(0, round((pulse_us - 1500) * 8 / 5) + 992))
        return True

    def _packed(self) -> bytes:
        bits = "".join(f"{step:011b}"[::-1] for step in self._steps)
        return bytes(int(bits[at : at + 8][::-1], 2) for at in range(0, len(bits), 8))


class SbusEmulator(_Receiver):
    """Sends a frame whether or not the transmitter is heard, with the failsafe flag where it is not."""

    def speak(self, t_s: float) -> None:
        """Send now."""
        flags = 0x00 if self._heard() else 0x0C
        self._port.send(b"\x0f" + self._packed() + bytes((flags, 0x00)), t_s + self._config.latency_s)


class CrsfEmulator(_Receiver):
    """Sends channels while the transmitter is heard, and link statistics; `telemetry` holds the frames that came back,
    by type."""

    def __init__(self, config: SensorConfig, port: MemoryDevice, around: SensedWorld) -> None:
        super().__init__(config, port, around)
        self.telemetry: dict[int, bytes] = {}
        self._sent = 0

    def speak(self, t_s: float) -> None:
        """Send now, and take in what came."""
        self._listen(t_s)
        heard = self._heard()
        at_s = t_s + self._config.latency_s
        self._sent += 1
        if heard:
            self._port.send(_frame(0x16, self._packed()), at_s)
        if self._sent % 5 == 1:
            quality = 100 if heard else 0
            self._port.send(_frame(0x14, bytes((60, 60, quality, 10, 0, 4, 3, 60, quality, 10))), at_s)

    def _listen(self, t_s: float) -> None:
        self.telemetry.update(shown(b"".join(chunk for _, chunk in self._port.receive(t_s))))


def shown(data: bytes) -> dict[int, bytes]:
    """The payloads of whole frames for the transmitter's screen, by type."""
    found: dict[int, bytes] = {}
    while len(data) > 3 and data[0] == 0xC8 and len(data) >= 2 + data[1]:
        body, crc = data[2 : 1 + data[1]], data[1 + data[1]]
        if _crc(body) == crc:
            found[body[0]] = body[1:]
        data = data[2 + data[1] :]
    return found


def _frame(kind: int, payload: bytes) -> bytes:
    body = bytes((kind,)) + payload
    return bytes((0xC8, len(body) + 1)) + body + bytes((_crc(body),))


def _crc(data: bytes) -> int:
    crc = 0
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0xD5 if crc & 0x80 else 0)) & 0xFF
    return crc
