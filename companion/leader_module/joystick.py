"""A gamepad at a Linux joystick device (`/dev/input/js0`), read without a library.

Linux, Documentation/input/joydev/joystick-api.rst: `struct js_event {u32 time; s16 value; u8 type; u8 number}`. Type 1
is a button, 2 an axis; 0x80 is added for the initial state after opening. An axis gives −32767 to 32767; pushed away or
to the left is negative.
"""

from __future__ import annotations

import errno
import os
import struct

from companion.core.readings import ManualInput
from companion.core.tick import DeviceHealth
from companion.leader_module.config import JoystickConfig

_EVENT = struct.Struct("<IhBB")
_AXIS, _INITIAL = 0x02, 0x80
_FULL = 32767.0
_CHUNK = 4096
_RETRY_S = 1.0


class JoystickDecoder:
    """Bytes → `axes`: number → −1 to 1, newest values. Buttons are ignored."""

    def __init__(self) -> None:
        self.axes: dict[int, float] = {}
        self._rest = b""

    def feed(self, data: bytes) -> None:
        """Bytes as they come; an event may be cut anywhere."""
        data = self._rest + data
        whole = len(data) - len(data) % _EVENT.size
        self._rest = data[whole:]
        for _, value, kind, number in _EVENT.iter_unpack(data[:whole]):
            if kind & ~_INITIAL == _AXIS:
                self.axes[number] = max(-1.0, value / _FULL)


class Joystick:
    """The gamepad as sticks. It opens the device again when it is plugged in again.

    A stick that does not move sends nothing, so its last value holds for as long as the device is there.
    """

    name = "joystick"

    def __init__(self, config: JoystickConfig) -> None:
        self._config = config
        self._decoder = JoystickDecoder()
        self._fd: int | None = None
        self._next_try_s = 0.0
        self._fault = "not open yet"

    def read(self, now_s: float) -> ManualInput | None:
        """The sticks; None while the device is missing, or not all axes are known."""
        self._open(now_s)
        try:
            while self._fd is not None and (data := os.read(self._fd, _CHUNK)):
                self._decoder.feed(data)
                if len(data) < _CHUNK:
                    break
            else:
                if self._fd is not None:
                    self._lose("unplugged", now_s)
        except BlockingIOError:
            pass
        except OSError as error:
            self._lose("unplugged" if error.errno == errno.ENODEV else error.strerror or str(error), now_s)
        return self._sticks(now_s)

    def fileno(self) -> int | None:
        """The device's descriptor, or None."""
        return self._fd

    def health(self, now_s: float) -> DeviceHealth:
        """Whether the device is open."""
        return DeviceHealth(
            self.name,
            self._fd is not None,
            None,
            "" if self._fd is not None else f"{self._config.device}: {self._fault}",
        )

    def close(self) -> None:
        """Close the device."""
        if self._fd is not None:
            os.close(self._fd)
            self._fd = None

    def _open(self, now_s: float) -> None:
        if self._fd is not None or now_s < self._next_try_s:
            return
        try:
            self._fd = os.open(self._config.device, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
            self._decoder = JoystickDecoder()
        except OSError as error:
            self._fault = (
                "permission denied; `sudo usermod -aG input $USER`"
                if error.errno == errno.EACCES
                else error.strerror or str(error)
            )
            self._next_try_s = now_s + _RETRY_S

    def _lose(self, fault: str, now_s: float) -> None:
        self.close()
        self._fault, self._next_try_s = fault, now_s + _RETRY_S

    def _sticks(self, now_s: float) -> ManualInput | None:
        config, axes = self._config, self._decoder.axes
        if self._fd is None or config.surge_axis not in axes or config.yaw_axis not in axes:
            return None
        turned = {name: -1.0 if name in config.reversed else 1.0 for name in ("surge", "sway", "yaw")}
        sway = (
            None
            if config.sway_axis is None or config.sway_axis not in axes
            else turned["sway"] * axes[config.sway_axis]
        )
        return ManualInput(
            now_s, self.name, -turned["surge"] * axes[config.surge_axis], sway, turned["yaw"] * axes[config.yaw_axis]
        )
