"""readings.csv: every reading that reached the estimator, exactly, so that a run can be done again from its log.

One line a reading, in the order of arrival: `kind,source,values`. The values are base64 of the bytes that
`reading_codec` makes of the reading's fields. Decimal text of the same digits would cost six times the processor time.
Lines of other kinds:

    tick       the end of a tick, after its readings: TICK_COLUMNS as float64, then throttle and azimuth of each
               thruster where the setpoint sets them
    parameter  a parameter that changed during the run: its name as source, its value
    packet     a MAVLink packet that came in: persona and endpoint as source; when it was handled, then its bytes
    health     what a device's driver reports from then on: one byte for well or not, then its text. A device that is
               well has such a line once a minute, for its rates and counts

A replay of the estimate needs this file and manifest.json; one of the whole tick needs `state/` and ticks.csv too.
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

from companion.core.actuation import ZERO_WRENCH, ThrusterCommand, Wrench
from companion.core.readings import KINDS, Reading
from companion.core.setpoint import (
    NO_PROGRESS,
    HeadingSetpoint,
    NeutralSetpoint,
    PathSetpoint,
    Point,
    PoseSetpoint,
    Progress,
    Setpoint,
    ThrusterSetpoint,
    WrenchSetpoint,
    desired_motion,
)
from companion.core.tick import DeviceHealth, Tick
from companion.record.reading_codec import CODECS, floats, pack_floats

FILE = "readings.csv"
HEADER = b"kind,source,values\n"

COLUMNS = {kind: (KINDS[kind], codec.names) for kind, codec in CODECS.items()}
"""Each kind's dataclass and its fields in the order of their values."""

_KIND_OF = {kind_type: kind for kind, kind_type in KINDS.items()}

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
_KINDS = (NeutralSetpoint, PoseSetpoint, PathSetpoint, HeadingSetpoint, WrenchSetpoint, ThrusterSetpoint)
_NUMBER_OF = {kind: number for number, kind in enumerate(_KINDS)}
_NO_WRENCH = (None, None, None)
_of_nav = attrgetter(*_POSE)
_of_motion = attrgetter(*_SETPOINT[2:])
_of_wrench = attrgetter(*_WRENCH)


# --- writing -------------------------------------------------------------------------------------------------------


class ReadingsEncoder:
    """Ticks → lines. Remembers the beginning of the line for each kind and source; of the readings nothing."""

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
                    continue  # a recorder never ends a run; a test sees to it that every kind has its row
                heads[key] = (f"{_KIND_OF[key[0]]},{key[1]},".encode(), CODECS[_KIND_OF[key[0]]].packed)
            head, packed = heads[key]
            lines.append(head + encoded(packed(reading)))
        lines.append(b"tick,," + encoded(_packed_tick(tick)))
        return b"".join(lines)

    @staticmethod
    def parameter(name: str, value: float) -> bytes:
        """The line of a parameter that was changed under way."""
        return f"parameter,{name},".encode() + binascii.b2a_base64(struct.pack("<d", value))

    @staticmethod
    def packet(persona: str, endpoint: str, t_s: float, packet: bytes) -> bytes:
        """The line of a packet that came in."""
        source = f"{persona} {endpoint}".replace(",", ";").replace("\n", " ")
        return f"packet,{source},".encode() + binascii.b2a_base64(struct.pack("<d", t_s) + packet)

    @staticmethod
    def health(device: DeviceHealth) -> bytes:
        """The line of a device that is otherwise than before."""
        return f"health,{device.name},".encode() + binascii.b2a_base64(bytes([device.ok]) + device.text.encode())


def _packed_tick(tick: Tick) -> bytes:
    setpoint = tick.setpoint
    desired = desired_motion(setpoint)
    place = (None, None) if desired.place is None else (desired.place.north_m, desired.place.east_m)
    wrench = _of_wrench(setpoint.wrench) if isinstance(setpoint, HeadingSetpoint | WrenchSetpoint) else _NO_WRENCH
    commands = setpoint.thrusters if isinstance(setpoint, ThrusterSetpoint) else ()
    thrusters = [part for t in commands for part in (t.throttle, t.azimuth_rad)]
    return pack_floats(
        (
            tick.nav.t_s,
            *_of_nav(tick.nav),
            tick.status.armed,
            _NUMBER_OF[type(setpoint)],
            *place,
            *_of_motion(desired),
            *wrench,
            *_of_wrench(tick.wrench),
            *_of_wrench(tick.allocation.achieved),
            *thrusters,
        )
    )


# --- reading -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class RecordedPacket:
    """A MAVLink packet that came in: when it was handled, its endpoint, and the persona of that endpoint
    (`persona`)."""

    t_s: float
    persona: str
    endpoint: str
    data: bytes


@dataclass(frozen=True, slots=True)
class RecordedTick:
    """A tick from the log. `pose` is north_m, east_m, yaw_rad, surge_mps, sway_mps, yaw_rate_radps of the estimate."""

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


class _Gathered:
    """The lines of one tick. `take` returns the tick when its last line has come."""

    def __init__(self) -> None:
        self.readings: list[Reading] = []
        self._parameters: list[tuple[str, float]] = []
        self._packets: list[RecordedPacket] = []
        self._health: list[DeviceHealth] = []

    def take(self, line: bytes) -> RecordedTick | None:
        """Raises ValueError, KeyError, IndexError, TypeError or struct.error for a line that is damaged."""
        if not line.endswith(b"\n"):
            raise ValueError("cut off")
        kind, source, data = _parts(line)
        match kind:
            case "tick":
                tick = _tick_of(floats(data), tuple(self.readings), tuple(self._parameters))
                return replace(tick, packets=tuple(self._packets), health=tuple(self._health))
            case "parameter":
                self._parameters.append((source, floats(data)[0]))
            case "packet":
                persona, _, endpoint = source.partition(" ")
                self._packets.append(RecordedPacket(struct.unpack_from("<d", data)[0], persona, endpoint, data[8:]))
            case "health":
                self._health.append(DeviceHealth(source, bool(data[0]), None, data[1:].decode()))
            case _:
                self.readings.append(CODECS[kind].reading(source, data))
        return None


def read_ticks(path: Path, warnings: list[str]) -> Iterator[RecordedTick]:
    """The ticks of a readings.csv. A damaged line is left out, and so are readings that no tick follows, each with a
    warning. Raises OSError for a file that cannot be read."""
    gathered = _Gathered()
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if line == HEADER:
                continue
            try:
                tick = gathered.take(line)
            except (ValueError, KeyError, IndexError, struct.error, TypeError) as error:
                warnings.append(f"{path.name}:{number}: line left out: {error}")
                continue
            if tick is not None:
                yield tick
                gathered = _Gathered()
    if gathered.readings:
        warnings.append(f"{path.name}: ends within a tick; its {len(gathered.readings)} readings are left out")


def read_kind(path: Path, kind: str, warnings: list[str]) -> list[Reading]:
    """The readings of one kind (a key of KINDS), which takes a fraction of the time of all. A damaged line is left out
    with a warning. Raises OSError for a file that cannot be read."""
    codec = CODECS[kind]
    found: list[Reading] = []
    begin = f"{kind},".encode()
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if line.startswith(begin) and line.endswith(b"\n"):
                try:
                    _, source, data = _parts(line)
                    found.append(codec.reading(source, data))
                except (ValueError, IndexError, struct.error, TypeError) as error:
                    warnings.append(f"{path.name}:{number}: line left out: {error}")
    return found


def _parts(line: bytes) -> tuple[str, str, bytes]:
    """A line's kind, source and values."""
    kind, source, text = line.decode("ascii").split(",")
    return kind, source, binascii.a2b_base64(text, strict_mode=False)


def _tick_of(
    values: tuple[float, ...], readings: tuple[Reading, ...], changes: tuple[tuple[str, float], ...]
) -> RecordedTick:
    fixed = len(TICK_COLUMNS)
    if len(values) < fixed or (len(values) - fixed) % 2:
        raise ValueError(f"{len(values)} values, a tick has {fixed} and two a thruster")
    t_s, n, e, yaw, u, v, r, armed, kind = values[:9]
    pairs = values[fixed:]
    thrusters = tuple(
        ThrusterCommand(0.0, throttle, None if math.isnan(azimuth) else azimuth)
        for throttle, azimuth in zip(pairs[::2], pairs[1::2], strict=True)
    )
    setpoint = _setpoint_of(int(kind), values[9:21], thrusters)
    pose = (n, e, yaw, u, v, r)
    return RecordedTick(
        t_s, pose, bool(armed), setpoint, Wrench(*values[21:24]), Wrench(*values[24:27]), readings, changes
    )


def _setpoint_of(kind: int, values: Sequence[float], thrusters: tuple[ThrusterCommand, ...]) -> Setpoint:
    kind_type = _KINDS[kind]
    sn, se, syaw = (None if math.isnan(value) else value for value in values[:3])
    su, sv, sr, au, av, ar = values[3:9]
    wrench = ZERO_WRENCH if math.isnan(values[9]) else Wrench(*values[9:12])
    progress = NO_PROGRESS if sn is None or se is None else Progress(place=Point(sn, se))
    if kind_type is PoseSetpoint:
        return PoseSetpoint(sn or 0.0, se or 0.0, syaw or 0.0, su, sv, sr, au, av, ar)
    if kind_type is PathSetpoint:
        return PathSetpoint(syaw or 0.0, su, sv, sr, au, progress)
    if kind_type is HeadingSetpoint:
        return HeadingSetpoint(syaw or 0.0, wrench, sr, progress)
    if kind_type is WrenchSetpoint:
        return WrenchSetpoint(wrench, replace(progress, yaw_rad=syaw))
    if kind_type is ThrusterSetpoint:
        return ThrusterSetpoint(thrusters, progress)
    return NeutralSetpoint(progress)
