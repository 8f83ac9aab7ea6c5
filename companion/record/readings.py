"""readings.csv: every reading that reached the estimator, exactly, so that a run can be done again from its log.

One line a reading, in the order in which they came: `kind,source,values`, values being base64 of little-endian float64 in the order of
`COLUMNS`; of `time`, a float64 and an int64; of `ais` and `measurement`, texts follow as UTF-8, each ended by a byte 1, or 0 where it was not told. What is not there is NaN. After the readings of a tick comes its line `tick`: the time of the tick, what
the estimator said, the setpoint that was followed and what control and allocation made of it (`TICK_COLUMNS`, then throttle and azimuth of
each thruster where the setpoint sets them). A line `parameter` is a change under way, its source the parameter's name. A line `packet` is a MAVLink packet
that came in, its source the dialect and the name of the endpoint, its values the time at which it was handled and the packet's bytes; a line `health` what a device's
driver said of it from then on (each minute also of one that is well: its rates and counts): one byte for well or not, then its text. Decimal text of
the same digits would cost six times the processor time. A `replay` needs this file and manifest.json, one of the whole tick also `state/` and ticks.csv.
"""

from __future__ import annotations

import binascii
import math
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from companion.core.types import (
    AisTarget,
    Battery,
    Corrections,
    Deployment,
    Depth,
    DeviceHealth,
    FixType,
    GnssFix,
    GroundVelocity,
    Heading,
    HeadingBy,
    Imu,
    Leak,
    MagneticField,
    ManualInput,
    Measurement,
    RcInput,
    Reading,
    Setpoint,
    SetpointKind,
    ThrusterCommand,
    ThrusterFeedback,
    Tick,
    TimeOfDay,
    Wind,
    Wrench,
)

FILE = "readings.csv"
HEADER = b"kind,source,values\n"

COLUMNS: dict[str, tuple[type[Any], tuple[str, ...]]] = {
    "imu": (
        Imu,
        ("t_s", "x_mps2", "y_mps2", "z_mps2", "roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps", "roll_rad", "pitch_rad", "yaw_rad"),
    ),
    "gnss": (GnssFix, ("t_s", "lat_deg", "lon_deg", "altitude_m", "fix", "satellites", "hdop", "position_accuracy_m")),
    "velocity": (GroundVelocity, ("t_s", "north_mps", "east_mps")),
    "heading": (Heading, ("t_s", "yaw_rad", "accuracy_rad", "by")),  # by: its number in the order of HeadingBy
    "field": (MagneticField, ("t_s", "x", "y", "z")),
    "wind": (Wind, ("t_s", "speed_mps", "from_rad")),
    "battery": (Battery, ("t_s", "voltage_v", "current_a", "remaining")),
    "leak": (Leak, ("t_s", "wet")),
    "feedback": (ThrusterFeedback, ("t_s", "index", "throttle", "azimuth_rad", "ok", "deployment")),
    "manual": (ManualInput, ("t_s", "surge", "sway", "yaw", "buttons")),
    "rc": (RcInput, ("t_s", "lost", "channels")),  # channels: one value each
    "time": (TimeOfDay, ("t_s", "time_unix_ns")),
    "depth": (Depth, ("t_s", "below_transducer_m", "offset_m", "range_m")),
    "corrections": (Corrections, ("t_s", "age_s", "station")),
    "measurement": (Measurement, ("t_s", "value", "name")),
    "ais": (
        AisTarget,
        (
            "t_s", "mmsi", "lat_deg", "lon_deg", "course_rad", "speed_mps", "heading_rad", "turn_rate_radps",
            "status", "kind", "bow_m", "stern_m", "port_m", "starboard_m", "callsign", "name",
        ),
    ),
}
_KIND_OF = {kind_type: kind for kind, (kind_type, _) in COLUMNS.items()}
_OPTIONAL = frozenset(
    {"roll_rad", "pitch_rad", "altitude_m", "satellites", "hdop", "position_accuracy_m", "accuracy_rad", "current_a", "remaining"}
)
_OPTIONAL_BY_KIND = {
    "imu": {"yaw_rad"},
    "feedback": {"throttle", "azimuth_rad", "deployment"},
    "manual": {"surge", "sway", "yaw"},
    "depth": {"offset_m", "range_m"},
    "corrections": {"station"},
}
_BY = tuple(HeadingBy)
_NUMBER_OF_BY = {by: number for number, by in enumerate(_BY)}
_WHOLE: dict[str, Callable[[float], Any]] = {
    "fix": lambda value: FixType(int(value)),
    "satellites": int,
    "index": int,
    "station": int,
    "buttons": int,
    "mmsi": int,
    "status": int,
    "kind": int,
    "wet": bool,
    "ok": bool,
    "deployment": lambda value: Deployment(int(value)),
    "by": lambda value: _BY[int(value)],
}

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_SETPOINT = (*_POSE, "surge_mps2", "sway_mps2", "yaw_radps2")
_WRENCH = ("surge_n", "sway_n", "yaw_nm")
TICK_COLUMNS = (
    "t_s",
    *_POSE,
    "armed",
    "setpoint_kind",
    *(f"setpoint_{name}" for name in _SETPOINT),
    *(f"setpoint_{name}" for name in _WRENCH),
    *(f"demanded_{name}" for name in _WRENCH),
    *(f"achieved_{name}" for name in _WRENCH),
)
_KINDS = tuple(SetpointKind)
_NUMBER_OF = {kind: number for number, kind in enumerate(_KINDS)}
_TIME = struct.Struct("<dq")
_TEXTS = {"ais": 2, "measurement": 1}  # columns at the end that are text
_of_nav = attrgetter(*_POSE)
_of_setpoint = attrgetter(*_SETPOINT)
_of_wrench = attrgetter(*_WRENCH)


# --- writing -------------------------------------------------------------------------------------------------------


class ReadingsEncoder:
    """Ticks → lines. Remembers the beginning of the line of each kind and source, and nothing of the readings."""

    def __init__(self) -> None:
        self._heads: dict[tuple[type[Any], str], tuple[bytes, Callable[[Any], bytes]]] = {}

    def tick(self, tick: Tick) -> bytes:
        """The lines of one tick: its readings, then the tick itself."""
        heads, encoded = self._heads, binascii.b2a_base64
        lines = []
        for reading in tick.readings:
            key = (type(reading), reading.source)
            if key not in heads:
                if key[0] not in _KIND_OF:
                    continue  # a recorder never ends a run; a test sees to it that every kind stands in COLUMNS
                heads[key] = (f"{_KIND_OF[key[0]]},{key[1]},".encode(), _packer(key[0]))
            head, packed = heads[key]
            lines.append(head + encoded(packed(reading)))
        lines.append(b"tick,," + encoded(_packed_tick(tick)))
        return b"".join(lines)

    @staticmethod
    def parameter(name: str, value: float) -> bytes:
        """The line of a parameter that was changed under way."""
        return f"parameter,{name},".encode() + binascii.b2a_base64(struct.pack("<d", value))

    @staticmethod
    def packet(dialect: str, endpoint: str, t_s: float, packet: bytes) -> bytes:
        """The line of a packet that came in."""
        source = f"{dialect} {endpoint}".replace(",", ";").replace("\n", " ")
        return f"packet,{source},".encode() + binascii.b2a_base64(struct.pack("<d", t_s) + packet)

    @staticmethod
    def health(device: DeviceHealth) -> bytes:
        """The line of a device that is otherwise than before."""
        return f"health,{device.name},".encode() + binascii.b2a_base64(bytes([device.ok]) + device.text.encode())


def _packer(kind_type: type[Any]) -> Callable[[Any], bytes]:
    """Reading of that type → its packed values."""
    if kind_type is TimeOfDay:
        return lambda reading: _TIME.pack(reading.t_s, reading.time_unix_ns)
    if kind_type is RcInput:
        return lambda reading: _packed((reading.t_s, reading.lost, *reading.channels))
    if kind_type is Heading:
        return lambda reading: _packed((reading.t_s, reading.yaw_rad, reading.accuracy_rad, _NUMBER_OF_BY[reading.by]))
    kind = _KIND_OF[kind_type]
    names = COLUMNS[kind][1]
    if count := _TEXTS.get(kind):
        numbers_of, texts = attrgetter(*names[:-count]), [attrgetter(name) for name in names[-count:]]
        return lambda reading: _packed(numbers_of(reading)) + b"".join(_packed_text(text_of(reading)) for text_of in texts)
    values, pack = attrgetter(*names), struct.Struct(f"<{len(names)}d").pack

    def packed(reading: Any) -> bytes:
        numbers = values(reading)
        return pack(*numbers) if None not in numbers else _packed(numbers)

    return packed


def _packed(numbers: Sequence[float | None]) -> bytes:
    return struct.pack(f"<{len(numbers)}d", *(math.nan if number is None else number for number in numbers))


def _packed_text(text: str | None) -> bytes:
    return b"\x00" if text is None else text.replace("\x00", "").replace("\x01", "").encode() + b"\x01"


def _packed_tick(tick: Tick) -> bytes:
    setpoint = tick.setpoint
    wrench = (None, None, None) if setpoint.wrench is None else _of_wrench(setpoint.wrench)
    thrusters = [] if setpoint.thrusters is None else [part for t in setpoint.thrusters for part in (t.throttle, t.azimuth_rad)]
    return _packed(
        (
            tick.nav.t_s,
            *_of_nav(tick.nav),
            tick.status.armed,
            _NUMBER_OF[setpoint.kind],
            *_of_setpoint(setpoint),
            *wrench,
            *_of_wrench(tick.wrench),
            *_of_wrench(tick.allocation.achieved),
            *thrusters,
        )
    )


# --- reading -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class RecordedPacket:
    """A MAVLink packet that came in: when it was handled, on which endpoint, and how that endpoint's remote takes us."""

    t_s: float
    dialect: str
    endpoint: str
    data: bytes


@dataclass(frozen=True, slots=True)
class RecordedTick:
    """A tick as it was: `pose` is north_m, east_m, yaw_rad, surge_mps, sway_mps, yaw_rate_radps of the estimate."""

    t_s: float
    pose: tuple[float, float, float, float, float, float]
    armed: bool
    setpoint: Setpoint
    demanded: Wrench
    achieved: Wrench
    readings: tuple[Reading, ...]
    parameters: tuple[tuple[str, float], ...]  # changed since the tick before
    packets: tuple[RecordedPacket, ...] = ()  # since the tick before, and those that the tick itself began with
    health: tuple[DeviceHealth, ...] = ()  # of devices that are otherwise than at the tick before


def read_ticks(path: Path, warnings: list[str]) -> Iterator[RecordedTick]:
    """The ticks of a readings.csv. A line that cannot be read is skipped, readings that no tick followed are left out, each with a warning."""
    readings: list[Reading] = []
    changes: list[tuple[str, float]] = []
    packets: list[RecordedPacket] = []
    health: list[DeviceHealth] = []
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if line == HEADER:
                continue
            try:
                if not line.endswith(b"\n"):
                    raise ValueError("cut off")
                kind, source, text = line.decode("ascii").split(",")
                data = binascii.a2b_base64(text, strict_mode=False)
                if kind == "tick":
                    tick = _tick_of(_floats(data), tuple(readings), tuple(changes))
                    yield replace(tick, packets=tuple(packets), health=tuple(health))
                    readings, changes, packets, health = [], [], [], []
                elif kind == "parameter":
                    changes.append((source, _floats(data)[0]))
                elif kind == "packet":
                    dialect, _, endpoint = source.partition(" ")
                    packets.append(RecordedPacket(struct.unpack_from("<d", data)[0], dialect, endpoint, data[8:]))
                elif kind == "health":
                    health.append(DeviceHealth(source, bool(data[0]), None, data[1:].decode()))
                else:
                    readings.append(_reading_of(kind, source, data))
            except (ValueError, KeyError, IndexError, struct.error, TypeError) as error:
                warnings.append(f"{path.name}:{number}: line left out: {error}")
    if readings:
        warnings.append(f"{path.name}: ends within a tick; its {len(readings)} readings are left out")


def read_kind(path: Path, kind: str, warnings: list[str]) -> list[Reading]:
    """The readings of one kind (a key of COLUMNS) alone, which takes a fraction of the time of all. A line that cannot be read is left out."""
    found: list[Reading] = []
    begin = f"{kind},".encode()
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if line.startswith(begin) and line.endswith(b"\n"):
                try:
                    _, source, text = line.decode("ascii").split(",")
                    found.append(_reading_of(kind, source, binascii.a2b_base64(text, strict_mode=False)))
                except (ValueError, struct.error, TypeError) as error:
                    warnings.append(f"{path.name}:{number}: line left out: {error}")
    return found


def _floats(data: bytes) -> tuple[float, ...]:
    return struct.unpack(f"<{len(data) // 8}d", data)


def _reading_of(kind: str, source: str, data: bytes) -> Reading:
    kind_type, names = COLUMNS[kind]
    if kind_type is TimeOfDay:
        return TimeOfDay(_TIME.unpack(data)[0], source, _TIME.unpack(data)[1])
    if kind in _TEXTS:
        with_texts: Reading = _with_texts(kind_type, source, names, _TEXTS[kind], data)
        return with_texts
    numbers = _floats(data)
    if kind_type is RcInput:
        return RcInput(numbers[0], source, numbers[2:], bool(numbers[1]))
    if kind_type is Heading and len(numbers) == len(names) - 1:
        names = names[:-1]  # logs of before did not say what a heading rests on: an antenna baseline
    if len(numbers) != len(names):
        raise ValueError(f"{len(numbers)} values, {kind} has {len(names)}")
    optional = _OPTIONAL_BY_KIND.get(kind, set())
    values = {name: _value(name, number, name in _OPTIONAL or name in optional) for name, number in zip(names, numbers, strict=True)}
    reading: Reading = kind_type(source=source, **values)
    return reading


def _with_texts(kind_type: type[Any], source: str, names: Sequence[str], count: int, data: bytes) -> Any:
    numbers, size = names[:-count], 8 * (len(names) - count)
    texts: list[str | None] = []
    rest = data[size:]
    for _ in range(count):
        if rest[:1] == b"\x00":
            texts.append(None)
            rest = rest[1:]
        else:
            text, end, rest = rest.partition(b"\x01")
            if not end:
                raise ValueError("a text without its end")
            texts.append(text.decode())
    values = {name: _value(name, number, True) for name, number in zip(numbers, _floats(data[:size]), strict=True)}
    return kind_type(source=source, **values, **dict(zip(names[-count:], texts, strict=True)))


def _value(name: str, number: float, optional: bool) -> Any:
    if optional and math.isnan(number):
        return None
    return _WHOLE[name](number) if name in _WHOLE else number


def _tick_of(values: tuple[float, ...], readings: tuple[Reading, ...], changes: tuple[tuple[str, float], ...]) -> RecordedTick:
    fixed = len(TICK_COLUMNS)
    if len(values) < fixed or (len(values) - fixed) % 2:
        raise ValueError(f"{len(values)} values, a tick has {fixed} and two a thruster")
    t_s, n, e, yaw, u, v, r, armed, kind = values[:9]
    sn, se, syaw = (None if math.isnan(value) else value for value in values[9:12])
    wrench = None if math.isnan(values[18]) else Wrench(*values[18:21])
    pairs = values[fixed:]
    thrusters = tuple(
        ThrusterCommand(0.0, throttle, None if math.isnan(azimuth) else azimuth)
        for throttle, azimuth in zip(pairs[::2], pairs[1::2], strict=True)
    )
    su, sv, sr, au, av, ar = values[12:18]
    setpoint = Setpoint(_KINDS[int(kind)], sn, se, syaw, su, sv, sr, au, av, ar, wrench, thrusters or None)
    pose = (n, e, yaw, u, v, r)
    return RecordedTick(t_s, pose, bool(armed), setpoint, Wrench(*values[21:24]), Wrench(*values[24:27]), readings, changes)
