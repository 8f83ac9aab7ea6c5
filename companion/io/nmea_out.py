"""NMEA 0183 sentences of the boat for chart plotters and survey software (OpenCPN, Hypack, QINSy): position, motion,
heading, track, rudder.

pynmea2 puts fields and checksum together. Source of the fields: NMEA 0183 version 4.11.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

import pynmea2

from companion.config.devices import ThrusterConfig
from companion.config.streams import NmeaOutConfig
from companion.core.angles import wrap_pi
from companion.core.decision import TextKind
from companion.core.ports import ByteStream
from companion.core.readings import FixType
from companion.core.setpoint import PathSetpoint, PoseSetpoint, desired_motion
from companion.core.tick import Tick

Say = Callable[[float, TextKind, str, str], None]
Fields = tuple[str, ...]

_KNOTS, _KMPH, _NM = 3600.0 / 1852.0, 3.6, 1.0 / 1852.0
_QUALITY = {FixType.FIX_2D: 1, FixType.FIX_3D: 1, FixType.DGPS: 2, FixType.RTK_FLOAT: 5, FixType.RTK_FIXED: 4}
_ESTIMATED = 6
_MODES = {1: "A", 2: "D", 4: "R", 5: "F", _ESTIMATED: "E"}
_STANDSTILL_MPS = 0.1  # below it a course over ground is noise
_EARLY_S = 1e-3
_NO_NUMBERS = frozenset({"nan", "inf", "-inf"})
_REMINDER_S = 60.0


@dataclass(frozen=True, slots=True)
class Boat:
    """What sentences are made of: the tick, UTC, and the thrusters that are shown as starboard and port rudder."""

    tick: Tick
    utc: datetime
    rudders: tuple[int | None, int | None]


class NmeaOut:
    """A recorder that writes sentences to a stream at a fixed rate. Remembers when the next are due, and whether the
    stream was well."""

    def __init__(
        self, config: NmeaOutConfig, thrusters: Sequence[ThrusterConfig], stream: ByteStream, say: Say
    ) -> None:
        self._config = config
        self._stream = stream
        self._say = say
        self._rudders = rudders(thrusters)
        self._due_s: float | None = None
        self._announced: str | None = None
        self._announced_s = -math.inf

    def record(self, tick: Tick) -> None:
        """See `Recorder`. Writes the sentences that are due."""
        now_s = tick.t_s
        self._stream.read(now_s)  # a plotter's bytes are ignored, but must not pile up
        self._mind_stream(now_s)
        if self._due_s is not None and now_s < self._due_s - _EARLY_S:
            return
        period_s = 1.0 / self._config.rate_hz
        self._due_s = now_s + period_s if self._due_s is None else max(self._due_s + period_s, now_s)
        try:
            self._stream.write(self.sentences(tick), now_s)
        except (ValueError, OverflowError) as error:  # numbers that no sentence can carry must not stop the boat
            self._announce(f"no sentence: {error}", now_s)

    def sentences(self, tick: Tick) -> bytes:
        """All sentences of a tick, in the order of the vessel's file. A sentence whose values are unknown is left
        out."""
        boat = Boat(tick, _utc(tick), self._rudders)
        return b"".join(_printed(self._config.talker, kind, boat) for kind in self._config.sentences)

    def close(self) -> None:
        """Close the stream."""
        self._stream.close()

    def _mind_stream(self, now_s: float) -> None:
        """A fault is announced once; another one after a minute."""
        fault = self._stream.fault()
        if fault is None:
            self._announced = None
        else:
            self._announce(fault, now_s)

    def _announce(self, fault: str, now_s: float) -> None:
        if fault != self._announced and now_s - self._announced_s >= _REMINDER_S:
            self._announced, self._announced_s = fault, now_s
            self._say(now_s, TextKind.ATTENTION, "nmea_out", f"NMEA out: {fault}")


def gga(tick: Tick) -> bytes:
    """The position alone, for casters of corrections."""
    return _printed("GP", "GGA", Boat(tick, _utc(tick), (None, None)))


def _printed(talker: str, kind: str, boat: Boat) -> bytes:
    fields = MAKERS[kind](boat)
    if fields is None or not _NO_NUMBERS.isdisjoint(fields):
        return b""
    text: str = getattr(pynmea2, kind)(talker, kind, fields).render(newline=True)
    return text.encode("ascii")


def _utc(tick: Tick) -> datetime:
    """In whole hundredths of a second: a float would lose one now and then."""
    seconds, hundredths = divmod((tick.nav.time_unix_ns or tick.time_unix_ns) // 10_000_000, 100)
    return datetime.fromtimestamp(seconds, UTC).replace(microsecond=10_000 * hundredths)


def rudders(thrusters: Sequence[ThrusterConfig]) -> tuple[int | None, int | None]:
    """Which of the thrusters astern that turn are shown as (starboard or single rudder, port rudder)."""
    astern = sorted((t.y_m, i) for i, t in enumerate(thrusters) if t.turns and t.x_m < 0.0)
    if not astern:
        return None, None
    return astern[-1][1], astern[0][1] if len(astern) > 1 else None


def _clock(boat: Boat) -> str:
    return f"{boat.utc:%H%M%S}.{boat.utc.microsecond // 10_000:02d}"


def _place(boat: Boat) -> Fields:
    """Latitude and longitude in degrees and minutes to 2 mm."""
    parts: list[str] = []
    for angle_deg, digits, sides in ((boat.tick.nav.lat_deg, 2, "NS"), (boat.tick.nav.lon_deg, 3, "EW")):
        degrees, minutes = divmod(round(abs(angle_deg) * 60e6), 60_000_000)
        parts += [f"{degrees:0{digits}d}{minutes // 1_000_000:02d}.{minutes % 1_000_000:06d}", sides[angle_deg < 0.0]]
    return tuple(parts)


def _quality(boat: Boat) -> int:
    """As GGA has it: 0 while the position is not valid, estimated where it is and the receiver has no fix."""
    nav = boat.tick.nav
    return _QUALITY.get(nav.fix, _ESTIMATED) if nav.position_valid else 0


def _degrees(angle_rad: float) -> str:
    return f"{round(math.degrees(angle_rad) % 360.0, 2) % 360.0:.2f}"


def _course_and_speed(boat: Boat) -> tuple[str, float]:
    """(degrees, empty at rest; m/s)."""
    nav = boat.tick.nav
    speed_mps = math.hypot(nav.north_mps, nav.east_mps)
    return (_degrees(math.atan2(nav.east_mps, nav.north_mps)) if speed_mps > _STANDSTILL_MPS else ""), speed_mps


def _gga(boat: Boat) -> Fields:
    nav, quality = boat.tick.nav, _quality(boat)
    satellites = "" if nav.satellites is None else f"{min(99, nav.satellites):02d}"
    hdop = "" if nav.hdop is None else f"{nav.hdop:.1f}"
    place = _place(boat) if quality else ("", "", "", "")
    corrections = boat.tick.inputs.corrections
    age = (
        ""
        if corrections is None or quality not in (2, 4, 5)
        else f"{corrections.age_s + nav.t_s - corrections.t_s:.1f}"
    )
    station = "" if not age or corrections is None or corrections.station is None else f"{corrections.station:04d}"
    altitude = f"{nav.altitude_m:.2f}" if quality else ""
    return (_clock(boat), *place, str(quality), satellites, hdop, altitude, "M", "", "M", age, station)


def _rmc(boat: Boat) -> Fields:
    quality = _quality(boat)
    date = f"{boat.utc:%d%m%y}"
    if not quality:
        return (_clock(boat), "V", "", "", "", "", "", "", date, "", "", "N")
    course, speed_mps = _course_and_speed(boat)
    return (_clock(boat), "A", *_place(boat), f"{speed_mps * _KNOTS:.2f}", course, date, "", "", _MODES[quality])


def _vtg(boat: Boat) -> Fields:
    quality = _quality(boat)
    if not quality:
        return ("", "T", "", "M", "", "N", "", "K", "N")
    course, speed_mps = _course_and_speed(boat)
    return (course, "T", "", "M", f"{speed_mps * _KNOTS:.2f}", "N", f"{speed_mps * _KMPH:.2f}", "K", _MODES[quality])


def _hdt(boat: Boat) -> Fields | None:
    nav = boat.tick.nav
    return (_degrees(nav.yaw_rad), "T") if nav.heading_valid else None


def _zda(boat: Boat) -> Fields:
    return (_clock(boat), f"{boat.utc:%d}", f"{boat.utc:%m}", f"{boat.utc:%Y}", "00", "00")


def _steer(boat: Boat) -> tuple[str, str, str] | None:
    """(nautical miles, side to steer to, unit); None off any track."""
    setpoint = boat.tick.setpoint
    error_m = setpoint.progress.cross_track_error_m
    if not isinstance(setpoint, PathSetpoint | PoseSetpoint) or error_m is None:
        return None
    return f"{abs(error_m) * _NM:.5f}", "L" if error_m > 0.0 else "R", "N"  # to starboard of the track: steer left


def _xte(boat: Boat) -> Fields | None:
    steer = _steer(boat)
    status = "A" if boat.tick.nav.position_valid else "V"
    return None if steer is None else (status, status, *steer)


def _apb(boat: Boat) -> Fields | None:
    """To the point that the boat steers for; the bearing of the track is that of the path where the boat is."""
    setpoint, nav, steer = boat.tick.setpoint, boat.tick.nav, _steer(boat)
    target = setpoint.progress.target
    if steer is None or target is None:
        return None
    status = "A" if nav.position_valid else "V"
    bearing = math.atan2(target.east_m - nav.east_m, target.north_m - nav.north_m)
    course = bearing if setpoint.progress.course_rad is None else setpoint.progress.course_rad
    yaw_rad = desired_motion(setpoint).yaw_rad
    desired = course if yaw_rad is None else yaw_rad
    name = f"{boat.tick.status.mission.seq:03d}"
    return (
        status,
        status,
        *steer,
        "V",
        "V",
        _degrees(course),
        "T",
        name,
        _degrees(bearing),
        "T",
        _degrees(desired),
        "T",
    )


def _rsa(boat: Boat) -> Fields | None:
    """A thruster astern that pushes to starboard (azimuth to starboard) turns the bow to port, which a rudder's angle
    counts as negative."""
    starboard, port = (_rudder(boat, index) for index in boat.rudders)
    return None if starboard is None else (*starboard, *(port or ("", "V")))


def _rudder(boat: Boat, index: int | None) -> tuple[str, str] | None:
    if index is None:
        return None
    feedback = boat.tick.feedback[index] if index < len(boat.tick.feedback) else None
    azimuth = feedback.azimuth_rad if feedback is not None else None
    if azimuth is None:
        azimuth = boat.tick.command.thrusters[index].azimuth_rad
    return None if azimuth is None else (f"{-math.degrees(wrap_pi(azimuth)):.1f}", "A")


MAKERS: Mapping[str, Callable[[Boat], Fields | None]] = {
    "GGA": _gga,
    "RMC": _rmc,
    "VTG": _vtg,
    "HDT": _hdt,
    "ZDA": _zda,
    "XTE": _xte,
    "APB": _apb,
    "RSA": _rsa,
}
