"""The boat's shell: a line of a person → the lines of the answer, from a snapshot of the boat.

`answer(line, snapshot)` changes nothing: a value to set is in its reply. Who carries it out asks whether the person may
set it.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from companion.core.geodesy import distance_and_bearing
from companion.core.tick import DeviceHealth, Tick
from companion.mission.plan import item_number
from companion.params.spec import ParamRefusal, ParamSpec, ParamType
from companion.supervisor.snapshot import BoatSnapshot
from companion.supervisor.why import why

WIDTH = 80
MOST_LINES = 80  # of one answer
_EVENTS, _MOST_EVENTS = 10, 50


@dataclass(frozen=True, slots=True)
class Setting:
    """A parameter's new value, which the table accepts."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class Reply:
    """The lines of an answer, ASCII, at most WIDTH long. `setting`: to carry out before the lines are said."""

    lines: tuple[str, ...]
    setting: Setting | None = None


Words = Sequence[str]


@dataclass(frozen=True, slots=True)
class ShellCommand:
    """One command: its name, the words that may follow, and what it tells."""

    name: str
    words: str
    text: str
    tell: Callable[[Words, BoatSnapshot], Iterator[str]]


def answer(line: str, boat: BoatSnapshot) -> Reply:
    """The answer to one line. An empty line has none. Raises nothing."""
    words = line.split()
    if not words:
        return Reply(())
    command = COMMANDS.get(words[0].lower())
    if command is None:
        return _reply([f"{words[0]}: no such command; say help"])
    if command.name == "param" and len(words) == 3:
        return _set(words[1], words[2], boat)
    most = len(command.words.split())
    if len(words) - 1 > most:
        return _reply([f"Say: {command.name} {command.words}".rstrip()])
    return _reply(command.tell(words[1:], boat))


def _reply(lines: Iterable[str], setting: Setting | None = None) -> Reply:
    told: list[str] = []
    for line in lines:
        if len(told) >= MOST_LINES:
            told[MOST_LINES - 1 :] = ["... and more"]
            break
        plain = "".join(letter if " " <= letter <= "~" else "?" for letter in line)
        told += textwrap.wrap(plain, WIDTH, subsequent_indent="    ")
    return Reply(tuple(told), setting)


# --- status --------------------------------------------------------------------------------------------------------


def _help(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    for command in COMMANDS.values():
        yield f"{command.name + ' ' + command.words:<22} {command.text}"


def _status(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    status = boat.status
    asked = "" if status.intended_mode is status.mode else f" (asked for: {status.intended_mode.value})"
    yield f"{boat.config.title}: {'armed' if status.armed else 'disarmed'}, {status.mode.value}{asked}"
    if boat.tick is None:
        return
    yield from _motion(boat, boat.tick)
    battery = boat.tick.inputs.battery
    if battery is not None:
        left = "" if battery.remaining is None else f", {battery.remaining:.0%}"
        yield f"Battery: {battery.voltage_v:.1f} V{left}"
    mission = status.mission
    if mission.count:
        place = f"item {item_number(mission.seq)} of {mission.count}"
        yield f"Mission: {mission.state.name.lower().replace('_', ' ')}, {place}"
    yield f"Failsafes: {', '.join(status.failsafes) or 'none'}"
    yield f"Operator control: {f'system {boat.in_control}' if boat.in_control else 'nobody'}"
    yield f"Load: {boat.tick.load:.0%}"


def _motion(boat: BoatSnapshot, tick: Tick) -> Iterator[str]:
    nav, home = tick.nav, boat.status.home
    if nav.position_valid:
        fix = nav.fix.name.lower().replace("_", " ")
        yield f"Position: {nav.lat_deg:.6f} {nav.lon_deg:.6f}, {nav.position_accuracy_m:.2f} m, {fix}"
        speed_mps = math.hypot(nav.north_mps, nav.east_mps)
        yield f"Speed: {speed_mps:.2f} m/s, course {_bearing(math.atan2(nav.east_mps, nav.north_mps))}"
        if home is not None:
            far_m, _ = distance_and_bearing(nav.lat_deg, nav.lon_deg, home.lat_deg, home.lon_deg)
            yield f"Home: {far_m:.0f} m away"
    else:
        yield "Position: not valid"
    accuracy = math.degrees(nav.heading_accuracy_rad)
    yield f"Heading: {_bearing(nav.yaw_rad)}, {accuracy:.1f} deg" if nav.heading_valid else "Heading: not valid"


def _bearing(angle_rad: float) -> str:
    return f"{round(math.degrees(angle_rad)) % 360} deg"


def _devices(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    if boat.tick is None:
        return
    for device in boat.tick.health:
        yield f"{device.name:<20} {_health(device)}"
    thrusters = zip(boat.config.thrusters, boat.tick.conditions, boat.tick.command.thrusters, strict=False)
    for thruster, condition, command in thrusters:
        yield f"{thruster.name:<20} {condition.value}, {command.throttle:+.0%}"


def _health(device: DeviceHealth) -> str:
    age = "" if device.age_s is None else f", {max(0.0, device.age_s):.1f} s"
    return f"ok{age}" if device.ok else f"FAULT: {device.text or 'no data'}{age}"


def _sources(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    if boat.tick is None or boat.sources is None:
        return
    nav = boat.tick.nav
    ages_s = {"position": nav.position_age_s, "heading": nav.heading_age_s, "inertial": nav.imu_age_s}
    for kind, source in boat.sources.items():
        age_s = ages_s.get(kind, math.inf)
        age = f", {age_s:.1f} s old" if source is not None and math.isfinite(age_s) else ""
        yield f"{kind:<10} {source or 'none'}{age}"


def _why(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    return why(boat)


def _modes(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    refusals = boat.refusals or {}
    for mode in boat.modes:
        mark = "*" if mode.id is boat.status.mode else " "
        reason = refusals.get(mode.id)
        yield f"{mark} {mode.id.value:<10} {'ready' if reason is None else f'refused: {reason}'}"


def _events(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    number = words[0] if words else str(_EVENTS)
    if not number.isdigit() or not 1 <= int(number) <= _MOST_EVENTS:
        yield f"events takes a number from 1 to {_MOST_EVENTS}"
        return
    for event in boat.events[-int(number) :]:
        yield f"{event.t_s:9.1f} s  {event.severity.name:<8} {event.text}"


# --- parameters ----------------------------------------------------------------------------------------------------


def _param(words: Words, boat: BoatSnapshot) -> Iterator[str]:
    if not words:
        changed = boat.parameters.changed()
        yield f"{len(changed)} of {len(boat.parameters.specs)} parameters differ from their defaults"
        yield from (_value(boat, name) for name in changed)
        return
    name = words[0].upper()
    spec = boat.parameters.spec(name)
    if spec is not None:
        yield from _described(boat, spec)
        return
    found = [spec.name for spec in boat.parameters.specs if fnmatchcase(spec.name, name)]
    if not found:
        yield f"{name}: no such parameter; say param {name[:4].rstrip('*')}*"
    yield from (_value(boat, name) for name in found)


def _value(boat: BoatSnapshot, name: str) -> str:
    spec = boat.parameters.spec(name)
    assert spec is not None
    return f"{name:<17} {_shown(spec, boat.parameters[name])}"


def _described(boat: BoatSnapshot, spec: ParamSpec) -> Iterator[str]:
    yield f"{spec.name} = {_shown(spec, boat.parameters[spec.name])}"
    yield f"  {spec.text}"
    takes = "read-only" if spec.read_only else f"takes {spec.takes}"
    yield f"  {takes}; default {_shown(spec, boat.parameters.defaults[spec.name])}"
    if spec.choices:
        yield from (f"  {number}: {text}" for number, text in spec.choices.items())


def _shown(spec: ParamSpec, value: float) -> str:
    meaning = spec.choices.get(int(value)) if spec.choices else None
    return f"{value:.7g} {spec.unit}".rstrip() if meaning is None else f"{value:.7g} ({meaning})"


def _set(word: str, value: str, boat: BoatSnapshot) -> Reply:
    name = word.upper()
    spec = boat.parameters.spec(name)
    if spec is None:
        return _reply([f"{name}: no such parameter"])
    try:
        number = float(value)
    except ValueError:
        return _reply([f"{name} takes a number: {spec.takes}"])
    refusal = boat.parameters.refusal(name, number)
    if refusal is ParamRefusal.READ_ONLY:
        return _reply([f"{name} is read-only"])
    if refusal is not None or (spec.type is ParamType.INT32 and number != round(number)):
        return _reply([f"{name} takes {spec.takes}"])
    before, after = _shown(spec, boat.parameters[name]), _shown(spec, number)
    later = ", from the next start" if spec.reboot else ""
    return _reply([f"{name} = {after} (was {before}){later}"], Setting(name, number))


COMMANDS: Mapping[str, ShellCommand] = {
    command.name: command
    for command in (
        ShellCommand("help", "", "this list", _help),
        ShellCommand("status", "", "mode, place, battery, mission", _status),
        ShellCommand("why", "", "why armed or not, why this mode, why this speed", _why),
        ShellCommand("modes", "", "all modes, and why some are refused", _modes),
        ShellCommand("devices", "", "sensors, bridges, links and thrusters", _devices),
        ShellCommand("sources", "", "the sensor in use for each kind of reading", _sources),
        ShellCommand("events", "[N]", "the newest events", _events),
        ShellCommand("param", "[NAME [VALUE]]", "what differs from its default; one; NAME* lists; set one", _param),
    )
}
"""Every command, in the order in which help lists them."""
