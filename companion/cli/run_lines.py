"""What `companion run` shows: events and devices that do not answer as lines, the state of the boat as one line, and
the summary at the end. Everything here is text from ticks; `terminal` writes it."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from companion.core.decision import Event, ModeId, Severity, Status, TextKind
from companion.core.readings import Battery, FixType
from companion.core.setpoint import PoseSetpoint, Setpoint
from companion.core.tick import DeviceHealth, Tick
from companion.loop import Punctuality

_FIRST_LOOK_S = 1.5  # after the first tick: by then a device that is there has answered, or its port tells why not
_HEARD_S = 5.0  # a link on which something was heard within this time has a station
_LONGEST_STEP_S = 5.0  # between two ticks; a longer one is a boat that stood still in a stopped process
_FIXES: Mapping[FixType, str] = {
    FixType.NONE: "no fix",
    FixType.FIX_2D: "2D fix",
    FixType.FIX_3D: "3D fix",
    FixType.DGPS: "DGNSS",
    FixType.RTK_FLOAT: "RTK float",
    FixType.RTK_FIXED: "RTK fixed",
}


@dataclass(frozen=True, slots=True)
class Line:
    """One line for people, with the boat's time and a severity for its colour or its priority in the journal."""

    t_s: float
    severity: Severity
    text: str

    @property
    def plain(self) -> str:
        """`0:01:23.4  WARNING   gnss: no bytes for 2 s`."""
        return f"{clock_text(self.t_s)}  {self.severity.name:<9}  {self.text}"


def clock_text(t_s: float) -> str:
    """Time since the start, as `0:01:23.4`."""
    tenths = round(10.0 * t_s)
    return f"{tenths // 36000}:{tenths // 600 % 60:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"


class FirstLook:
    """Tells once, soon after the start, which devices, bridges and links do not work: the loop itself gives them 10 s.

    Remembers when the look is due.
    """

    def __init__(self) -> None:
        self._due_s: float | None = None
        self._done = False

    def take(self, tick: Tick) -> tuple[Line, ...]:
        """The lines to show with this tick: one for each that is not well, or one that says that all are."""
        self._due_s = tick.t_s + _FIRST_LOOK_S if self._due_s is None else self._due_s
        if self._done or tick.t_s < self._due_s:
            return ()
        self._done = True
        ill = [device for device in tick.health if not device.ok]
        if not ill:
            return (Line(tick.t_s, TextKind.ROUTINE.severity, "All devices and links are open"),)
        return tuple(Line(tick.t_s, TextKind.ATTENTION.severity, f"{device.name}: {device.text}") for device in ill)


def event_line(event: Event) -> Line:
    """The line of an event."""
    return Line(event.t_s, event.severity, event.text)


def status_text(tick: Tick, links: Sequence[str], heading_source: str | None, late: int) -> str:
    """The boat's state in one line, the most important first: a narrow terminal cuts its end.

    `links`: names under which links have their health. `late`: ticks so far that began late.
    """
    parts = (
        _mode_text(tick.status),
        _position_text(tick),
        _heading_text(tick, heading_source),
        _motion_text(tick.setpoint, tick),
        _battery_text(tick.inputs.battery),
        _links_text(tick.health, links),
        f"{late} late" if late else "",
    )
    return " | ".join(part for part in parts if part)


def _mode_text(status: Status) -> str:
    armed = "armed" if status.armed else "disarmed, cannot arm" if status.arming_refusals else "disarmed"
    failsafes = f" ({', '.join(status.failsafes)})" if status.failsafes else ""
    return f"{status.mode.value} {armed}{failsafes}"


def _position_text(tick: Tick) -> str:
    nav = tick.nav
    fix = _FIXES[nav.fix]
    return f"{fix} {_length(nav.position_accuracy_m)}" if nav.position_valid else f"{fix}, no position"


def _heading_text(tick: Tick, source: str | None) -> str:
    if not tick.nav.heading_valid:
        return "no heading"
    degrees = round(math.degrees(tick.nav.yaw_rad)) % 360
    return f"heading {degrees}°" + (f" ({source})" if source else "")


def _motion_text(setpoint: Setpoint, tick: Tick) -> str:
    """The error that the mode works on, else the speed over ground."""
    nav = tick.nav
    if not nav.position_valid:
        return ""
    if isinstance(setpoint, PoseSetpoint):
        return f"{_length(math.hypot(nav.north_m - setpoint.north_m, nav.east_m - setpoint.east_m))} off"
    speed = f"{math.hypot(nav.north_mps, nav.east_mps):.1f} m/s"
    across_m = setpoint.progress.cross_track_error_m
    return speed if across_m is None else f"{speed}, {_length(abs(across_m))} off track"


def _length(value_m: float) -> str:
    return f"{value_m:.2f} m" if abs(value_m) < 10.0 else f"{value_m:.0f} m"


def _battery_text(battery: Battery | None) -> str:
    if battery is None:
        return ""
    share = "" if battery.remaining is None else f"{100.0 * battery.remaining:.0f} % "
    return f"battery {share}{battery.voltage_v:.1f} V"


def _links_text(health: Sequence[DeviceHealth], links: Sequence[str]) -> str:
    rows = [device for device in health if device.name in links]
    heard = sum(device.age_s is not None and device.age_s < _HEARD_S for device in rows)
    return f"heard on {heard} of {len(rows)} links" if rows else ""


class RunSummary:
    """Counts over a run: distance, time in each mode, failsafes. Remembers the last tick's time and failsafes."""

    def __init__(self) -> None:
        self._last_s: float | None = None
        self._distance_m = 0.0
        self._armed_s: Counter[ModeId] = Counter()
        self._disarmed_s = 0.0
        self._failsafe_s: Counter[str] = Counter()
        self._failsafe_count: Counter[str] = Counter()
        self._active: frozenset[str] = frozenset()

    def take(self, tick: Tick) -> None:
        """Count one tick."""
        dt_s = 0.0 if self._last_s is None else min(tick.t_s - self._last_s, _LONGEST_STEP_S)
        self._last_s = tick.t_s
        active = frozenset(tick.status.failsafes)
        for name in active:
            self._failsafe_s[name] += dt_s  # type: ignore[assignment]  # a Counter may count seconds
            self._failsafe_count[name] += name not in self._active
        self._active = active
        if not tick.status.armed:
            self._disarmed_s += dt_s
            return
        self._armed_s[tick.status.mode] += dt_s  # type: ignore[assignment]
        if tick.nav.position_valid:
            self._distance_m += dt_s * math.hypot(tick.nav.north_mps, tick.nav.east_mps)

    @property
    def modes(self) -> Collection[ModeId]:
        """Those that the boat was armed in."""
        return self._armed_s.keys()

    def lines(self, punctuality: Punctuality | None) -> list[str]:
        """The summary. `punctuality`: of the run; None where no clock sets the pace."""
        armed_s = sum(self._armed_s.values())
        modes = ", ".join(f"{mode.value} {_span(s)}" for mode, s in self._armed_s.most_common())
        failsafes = ", ".join(
            f"{name} {count} time{'s' * (count != 1)}, {_span(self._failsafe_s[name])}"
            for name, count in sorted(self._failsafe_count.items())
        )
        told = [
            f"armed {_span(armed_s)} of {_span(armed_s + self._disarmed_s)}, sailed {self._distance_m:.0f} m",
            f"modes: {modes}" if modes else "",
            f"failsafes: {failsafes or 'none'}",
            "" if punctuality is None else punctuality.text,
        ]
        return [line for line in told if line]


def _span(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    if hours:
        return f"{hours} h {minutes} min"
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"
