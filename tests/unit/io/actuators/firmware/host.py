"""Compiles the firmware's core for the host, and mirrors its structs so that tests can step a board in their own
time."""

from __future__ import annotations

import ctypes
import os
import subprocess
from ctypes import (
    POINTER,
    Structure,
    c_bool,
    c_char,
    c_char_p,
    c_int8,
    c_int16,
    c_int32,
    c_size_t,
    c_uint8,
    c_uint16,
    c_uint32,
)
from pathlib import Path

from companion.core.microcontroller_auxiliary import AuxiliaryState
from companion.core.microcontroller_frame import BoardStatus, FrameDecoder, Ident, Message, encode
from tests.waiting import CAP_S

CORE = Path(__file__).parents[5] / "companion/io/actuators/firmware/usv_board"
HERE = Path(__file__).parent
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
ENVIRONMENT = {
    **os.environ,
    "ASAN_OPTIONS": "detect_leaks=0",
}  # nothing is allocated; and looking for leaks needs rights that a container may lack
NO_VOLTAGE, NO_AZIMUTH = 0xFFFF, -32768


def compiler() -> str:
    return os.environ.get("CC", "cc")


def build(name: str, folder: Path) -> Path:
    """A program, or for host_library a shared library, of the core and `name`.c."""
    made = folder / name
    flags = ["-shared", "-fPIC"] if name == "host_library" else _sanitizers(folder)
    sources = [HERE / f"{name}.c", *sorted(CORE.glob("*.c"))]
    subprocess.run(
        [compiler(), *STRICT, "-O1", *flags, f"-I{CORE}", *map(str, sources), "-o", str(made)],
        check=True,
        timeout=CAP_S,
    )
    return made


def _sanitizers(folder: Path) -> list[str]:
    """Bounds and undefined behaviour watched, as far as this machine brings what that needs."""
    source, probe = folder / "probe.c", folder / "probe"
    source.write_text("int main(void) { return 0; }\n", encoding="ascii")
    full = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    for command in ([compiler(), *full, str(source), "-o", str(probe)], [str(probe)]):
        if subprocess.run(command, check=False, capture_output=True, timeout=CAP_S, env=ENVIRONMENT).returncode != 0:
            return ["-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"]
    return full


class DriveConfig(Structure):
    _fields_ = (
        ("trim_us", c_uint16), ("ahead_us", c_uint16), ("astern_us", c_uint16), ("dead_us", c_uint16),
        ("reversed", c_bool), ("rate_per_s", c_uint16),
        ("azimuth", c_uint8), ("azimuth_rest", c_int32), ("azimuth_min", c_int32), ("azimuth_max", c_int32),
        ("azimuth_min_us", c_uint16), ("azimuth_max_us", c_uint16), ("azimuth_rate", c_int32),
        ("travel_ms", c_uint32), ("end_switches", c_bool),
        ("mix_surge", c_int8), ("mix_sway", c_int8), ("mix_yaw", c_int8), ("mix_azimuth", c_int16),
    )  # fmt: skip


class DriveInput(Structure):
    _fields_ = (
        ("works", c_bool), ("throttle_measured", c_bool), ("azimuth_measured", c_bool),
        ("throttle", c_int16), ("azimuth", c_int16), ("switch_up", c_bool), ("switch_down", c_bool),
    )  # fmt: skip


class DriveOutput(Structure):
    _fields_ = (("pulse_us", c_uint16), ("azimuth_us", c_uint16), ("azimuth", c_int32), ("travel", c_int8))


class BoardConfig(Structure):
    _fields_ = (
        ("name", c_char_p),
        ("thrusters", c_uint8),
        ("relays", c_uint8),
        ("servos", c_uint8),
        ("thruster", POINTER(DriveConfig)),
        ("safe_action", c_uint8),
        ("safe_channel", c_uint8),
        ("surge_channel", c_uint8),
        ("sway_channel", c_uint8),
        ("yaw_channel", c_uint8),
    )


class BoardIn(Structure):
    _fields_ = (
        ("leak_wet", c_bool), ("battery_mv", c_uint16), ("current_ma", c_int32), ("remaining", c_uint8),
        ("rc_present", c_bool), ("rc_fresh", c_bool), ("takes_radio", c_bool), ("rc_us", c_uint16 * 8), ("thruster", DriveInput * 16),
    )  # fmt: skip


class Outputs(Structure):
    _fields_ = (
        ("sequence", c_uint8),
        ("relays", c_uint16),
        ("relay_count", c_uint8),
        ("servo_count", c_uint8),
        ("servo_us", c_uint16 * 16),
    )


class Radio(Structure):
    _fields_ = (("length", c_uint8), ("data", c_uint8 * 64))


class BoardOut(Structure):
    _fields_ = (
        ("thruster", DriveOutput * 16),
        ("red", c_bool),
        ("yellow", c_bool),
        ("green", c_bool),
        ("auxiliary", Outputs),
        ("radio", Radio),
    )


_core: ctypes.CDLL | None = None


def load(path: Path) -> None:
    """The library at `path`, once it agrees with the mirrors above about every size."""
    global _core
    core = ctypes.CDLL(str(path))
    sizes = (c_size_t * 6).in_dll(core, "host_sizes")
    mirrored = [ctypes.sizeof(kind) for kind in (DriveConfig, BoardConfig, BoardIn, BoardOut)]
    assert list(sizes)[:4] == mirrored
    core.usv_throttle_us.restype = c_uint16
    core.usv_throttle_us.argtypes = (POINTER(DriveConfig), c_int16)
    core.usv_board_speak.restype = c_size_t
    core.board_size, core.receiver_size = sizes[4:]  # type: ignore[attr-defined]
    core.usv_rc_hear.restype = c_bool
    _core = core


def throttle_us(config: DriveConfig, throttle: int) -> int:
    assert _core is not None
    return int(_core.usv_throttle_us(ctypes.byref(config), throttle))


class Board:
    """A board whose clock is the test's. `now_ms` may begin anywhere; `inputs` and `outputs` are its own."""

    def __init__(self, thrusters: list[DriveConfig], now_ms: int = 0, name: bytes = b"bench", **options: int) -> None:
        assert _core is not None
        self._memory = ctypes.create_string_buffer(_core.board_size)  # type: ignore[arg-type]
        self._configs = (DriveConfig * max(1, len(thrusters)))(*thrusters)
        self._config = BoardConfig(name=name, thrusters=len(thrusters), thruster=self._configs, **options)
        self.now_ms = now_ms
        self._call("usv_board_start", ctypes.byref(self._config), c_uint32(now_ms))
        self.inputs = BoardIn.from_buffer(self._memory)
        self.outputs = BoardOut.from_buffer(self._memory, ctypes.sizeof(BoardIn))
        self._decoder = FrameDecoder()

    def _call(self, name: str, *arguments: object) -> int:
        return int(getattr(_core, name)(self._memory, *arguments))

    def hear(self, *messages: Message | bytes) -> None:
        for message in messages:
            for byte in message if isinstance(message, bytes) else encode(message):
                self._call("usv_board_hear", c_uint8(byte), c_uint32(self.now_ms & 0xFFFFFFFF))

    def step(self, elapsed_ms: int = 1, rc_us: tuple[int, ...] | None = None) -> None:
        """One turn of its loop, `elapsed_ms` after the last. `rc_us`: pulses that came in."""
        self.now_ms += elapsed_ms
        if rc_us is not None:
            self.inputs.rc_present = self.inputs.rc_fresh = True
            self.inputs.rc_us[:] = rc_us
        self._call("usv_board_step", c_uint32(self.now_ms & 0xFFFFFFFF))

    def run(self, duration_ms: int, step_ms: int = 5, rc_us: tuple[int, ...] | None = None) -> None:
        for _ in range(duration_ms // step_ms):
            self.step(step_ms, rc_us)

    def said(self) -> list[Message]:
        """What it has to say now."""
        frame = (c_char * 256)()
        messages: list[Message] = []
        for _ in range(8):
            length = self._call("usv_board_speak", c_uint32(self.now_ms & 0xFFFFFFFF), frame)
            if not length:
                return messages
            messages += self._decoder.feed(frame.raw[:length])
        raise AssertionError("the board talks without end")

    def status(self) -> BoardStatus:
        """Its next STATUS."""
        self.step(50)
        return next(message for message in self.said() if isinstance(message, BoardStatus))

    def ident(self) -> Ident:
        return next(message for message in self.said() if isinstance(message, Ident))

    def auxiliary(self) -> list[AuxiliaryState]:
        self.step(50)
        return [message for message in self.said() if isinstance(message, AuxiliaryState)]

    @property
    def pulses(self) -> list[int]:
        return [self.outputs.thruster[i].pulse_us for i in range(self._config.thrusters)]


class RcReceiver:
    """A serial RC receiver as the board reads it: `protocol` 2 is SBUS, 3 CRSF."""

    def __init__(self, protocol: int) -> None:
        assert _core is not None
        self._memory = ctypes.create_string_buffer(_core.receiver_size)  # type: ignore[arg-type]
        _core.usv_rc_start(self._memory, c_uint8(protocol))

    def hear(self, data: bytes, now_ms: int) -> list[tuple[int, ...]]:
        """The eight pulses of each frame that counts."""
        assert _core is not None
        found, us = [], (c_uint16 * 8)()
        for byte in data:
            if _core.usv_rc_hear(self._memory, c_uint8(byte), c_uint32(now_ms & 0xFFFFFFFF), us):
                found.append(tuple(us))
        return found
