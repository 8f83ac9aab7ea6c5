"""THE WIRING of the leader module: configuration, ports and clock → the module on a lead boat. It steers nothing: it tells where the lead boat is and what
its crew asks, and shows what the follower reports."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

from companion import config as config_module
from companion.app import parameter_problems, port_problems, program_version
from companion.config import ConfigError
from companion.config.leader import LeaderConfig, find_leader, parse_leader
from companion.core.geodesy import distance_and_bearing
from companion.core.ports import Clock, Sensor, StreamOpener
from companion.core.types import ManualInput, NavState, Reading, Severity, Wish
from companion.io.joystick import Joystick
from companion.io.mavlink.lead_link import Beacon, Follower, LeadLink
from companion.io.mavlink.lead_station import LeadStation
from companion.io.mavlink.links import Link
from companion.io.mavlink.signing import Signing
from companion.io.sensors import open_sensor
from companion.modes.crew_wish import CrewWish
from companion.modes.events import EventLog
from companion.nav.estimator import Estimator
from companion.nav.fix_watch import FixWatch
from companion.params import Parameters
from companion.record.leader_log import LeaderLog

_KEYS = {"m": Wish.MANUAL, "r": Wish.REMOTE, "a": Wish.AUTONOMOUS}
_WISH_TEXTS = {Wish.NONE: "no wish yet", Wish.MANUAL: "Manual", Wish.REMOTE: "Remote", Wish.AUTONOMOUS: "Autonomous"}
_SHOW_S = 0.2
_REPORT_S = 5.0  # after which what the follower reported is no longer shown


def load_leader(leader: str) -> LeaderConfig:
    """Find, read and check a module's file. Raises ConfigError with every problem."""
    path = find_leader(leader)
    tables = config_module.raw(path)
    if "thruster" in tables and "system_id" not in tables:
        raise ConfigError([f"{path}: a vessel's file, not a leader module's: `companion run {path}`"])
    problems: list[str] = []
    settings: Mapping[str, float] = config_module.raw_parameters(path)
    config: LeaderConfig | None = None
    try:
        config = parse_leader(path.read_text(encoding="utf-8"), str(path))
    except ConfigError as error:
        problems += error.problems
    except (OSError, UnicodeDecodeError) as error:
        problems.append(f"{path}: cannot be read: {error}")
    problems += port_problems(path) + parameter_problems(path, settings)
    if config is None or problems:
        raise ConfigError(problems)
    return config


class Display(Protocol):
    """Where the crew reads and types (`io.console.Console`)."""

    def fileno(self) -> int | None: ...

    def typed(self) -> str: ...

    def show(self, line: str, now_s: float) -> None: ...

    def say(self, text: str) -> None: ...


@dataclass(frozen=True, slots=True)
class LeaderSurroundings:
    """What a module is put into. `links`: towards the follower, `local`: for a ground station on the lead boat."""

    clock: Clock
    opener: StreamOpener
    links: Sequence[Link]
    local: Sequence[Link]
    display: Display
    log_folder: Path | None = None
    durable_log: bool = False
    signing: Signing | None = None  # has the key, for links that ask for signatures


def build_leader(config: LeaderConfig, around: LeaderSurroundings) -> LeaderModule:
    """Raises ConfigError for a driver that does not exist, OSError for a log folder that cannot be written."""
    sensors = tuple(open_sensor(row, around.opener.open(row.name, row.port)) for row in config.sensors)
    log = None
    if around.log_folder is not None:
        manifest = {"version": program_version(), "started_unix_ns": around.clock.time_unix_ns(), "configuration": asdict(config)}
        log = LeaderLog(around.log_folder, manifest, lambda text: _warn(text), around.durable_log)
    return LeaderModule(config, around, sensors, log)


def _warn(text: str) -> None:
    sys.stderr.write(f"companion: {text}\n")


class LeaderModule:
    """Sense → estimate → tell → show → record, `rate_hz` times a second; between two ticks the links are answered.

    Remembers the crew's wish, the health of its devices, and what it said last. Nothing that a device or a peer does ends it.
    """

    def __init__(self, config: LeaderConfig, around: LeaderSurroundings, sensors: Sequence[Sensor], log: LeaderLog | None) -> None:
        self.period_s = 1.0 / config.rate_hz
        self.load = 0.0
        self.crew = CrewWish()
        self._events = EventLog()
        self._clock, self._display, self._log = around.clock, around.display, log
        self._sensors = tuple(sensors)
        self._estimator = Estimator(config, Parameters(config.parameters), self._events.say)
        self._fixes = FixWatch()
        self._joystick = Joystick(config.joystick) if config.joystick is not None else None
        self._links = tuple(
            LeadLink(link, config.system_id, config.follower, config.rate_hz, _is_thrifty(config, link), self._follower_says) for link in around.links
        )
        self._stations = tuple(LeadStation(link, config.system_id, self.crew, self._note) for link in around.local)
        self._radios: tuple[LeadLink | LeadStation, ...] = (*self._links, *self._stations)
        self._signing = around.signing
        for number, link in enumerate((*around.links, *around.local)):
            link.guard.signing, link.guard.number = around.signing, number
        self._arrived: list[Reading] = []
        self._ok: dict[str, bool] = {}
        self._shown_s = -math.inf
        self._told_presses = 0

    @property
    def link(self) -> LeadLink:
        """The link on which the follower was heard last."""
        return max(self._links, key=lambda link: -math.inf if link.follower.heard_s is None else link.follower.heard_s)

    def filenos(self) -> Sequence[int]:
        ports = [*(sensor.fileno() for sensor in self._sensors), self._display.fileno()]
        ports.append(None if self._joystick is None else self._joystick.fileno())
        return [*(n for radio in self._radios for n in radio.filenos()), *(n for n in ports if n is not None)]

    def serve(self, now_s: float) -> None:
        """Between two ticks: keep what the sensors sent, obey the crew, answer the links."""
        for sensor in self._sensors:
            self._arrived.extend(sensor.read(now_s))
        if self._joystick is not None:
            self._joystick.read(now_s)
        for key in self._display.typed():
            if key in _KEYS:
                self.crew.press(_KEYS[key])
        for radio in self._radios:
            try:
                radio.serve(now_s)
            except Exception as error:  # noqa: BLE001  the module does not stop for what a peer sent
                self._events.say(now_s, Severity.ERROR, "link_failed", f"message not handled: {type(error).__name__}: {error}")

    def tick(self, now_s: float) -> None:
        """One cycle, whole."""
        self.serve(now_s)
        readings, self._arrived = self._arrived, []
        nav = self._estimator.update(readings, now_s)
        placed = self._fixes.update(readings, nav, now_s)
        beacon = Beacon(nav, placed, self.crew.wish, self.crew.presses, self._sticks(now_s))
        for link in self._links:
            link.publish(beacon)
        for station in self._stations:
            station.publish(nav, placed)
        self._tell_changes(placed, now_s)
        self._show(beacon)
        self._record(beacon)

    def close(self) -> None:
        for radio in self._radios:
            radio.close()
        if self._signing is not None:
            self._signing.close()
        for sensor in self._sensors:
            sensor.close()
        if self._joystick is not None:
            self._joystick.close()
        if self._log is not None:
            self._log.close()

    # --- parts of a tick -------------------------------------------------------------------------------------------

    def _sticks(self, now_s: float) -> ManualInput | None:
        """Those of the gamepad, else of a ground station on board."""
        held = None if self._joystick is None else self._joystick.read(now_s)
        return held or next((lent for station in self._stations if (lent := station.sticks(now_s)) is not None), None)

    def _follower_says(self, now_s: float, text: str) -> None:
        self._events.say(now_s, Severity.INFO, "follower", f"follower: {text}")
        for station in self._stations:
            station.tell(Severity.INFO, f"follower: {text}")

    def _note(self, now_s: float, text: str) -> None:
        self._events.say(now_s, Severity.NOTICE, "station", text)

    def _tell_changes(self, placed: bool, now_s: float) -> None:
        """Devices that went or came back, the fix, a press; all of it on the terminal and in the log."""
        states = [sensor.health(now_s) for sensor in self._sensors] + [radio.health(now_s) for radio in self._radios]
        if self._joystick is not None:
            states.append(self._joystick.health(now_s))
        for health in states:
            name = health.name
            if self._ok.get(name) != health.ok and (name in self._ok or not health.ok):
                text = f"{name}: {'back' if health.ok else health.text.removeprefix(f'{name}: ')}"  # a link's fault names it already
                self._events.say(now_s, Severity.NOTICE if health.ok else Severity.WARNING, f"{name}_health", text)
            self._ok[name] = health.ok
        if self._ok.get("fix") != placed:
            self._ok["fix"] = placed
            self._events.say(now_s, Severity.NOTICE if placed else Severity.WARNING, "fix", "fix" if placed else "no fix: the follower is told so")
        if self._told_presses != self.crew.presses:
            self._told_presses = self.crew.presses
            self._events.say(now_s, Severity.NOTICE, f"press{self.crew.presses}", f"asked for: {_WISH_TEXTS[self.crew.wish]}")
        for event in self._events.drain():
            self._display.say(event.text)
            if self._log is not None:
                self._log.event(event, self._clock.time_unix_ns())

    def _show(self, beacon: Beacon) -> None:
        now_s = beacon.nav.t_s
        if now_s - self._shown_s >= _SHOW_S:
            self._shown_s = now_s
            self._display.show(status_line(beacon, self.link.follower, self.link.counter), now_s)

    def _record(self, beacon: Beacon) -> None:
        if self._log is None:
            return
        nav, sticks, link = beacon.nav, beacon.sticks, self.link
        follower = link.follower
        self._log.row(
            {
                "t_s": round(nav.t_s, 4),
                "time_unix_ns": self._clock.time_unix_ns(),
                "placed": beacon.placed,
                "heading_valid": nav.heading_valid,
                "lat_deg": f"{nav.lat_deg:.8f}" if beacon.placed else None,
                "lon_deg": f"{nav.lon_deg:.8f}" if beacon.placed else None,
                "north_mps": round(nav.north_mps, 3),
                "east_mps": round(nav.east_mps, 3),
                "yaw_rad": round(nav.yaw_rad, 4) if nav.heading_valid else None,
                "yaw_rate_radps": round(nav.yaw_rate_radps, 4),
                "position_accuracy_m": round(nav.position_accuracy_m, 3),
                "wish": beacon.wish.name,
                "presses": beacon.presses,
                "surge": None if sticks is None else sticks.surge,
                "yaw": None if sticks is None else sticks.yaw,
                "link_counter": link.counter,
                "follower_mode": follower.mode,
                "follower_armed": follower.armed,
                "follower_age_s": None if follower.heard_s is None else round(nav.t_s - follower.heard_s, 2),
                "gap_m": gap_m(beacon, follower),
                "throttle": follower.throttle,
                "nozzle_deg": follower.nozzle_deg,
            }
        )


def gap_m(beacon: Beacon, follower: Follower) -> float | None:
    """Distance to the follower, carried on along its velocity since its last report; None where either is not known."""
    nav, age_s = beacon.nav, beacon.nav.t_s - follower.position_s
    if not beacon.placed or follower.lat_deg is None or follower.lon_deg is None or age_s > _REPORT_S:
        return None
    distance_m, bearing_rad = distance_and_bearing(nav.lat_deg, nav.lon_deg, follower.lat_deg, follower.lon_deg)
    north_m = distance_m * math.cos(bearing_rad) + follower.north_mps * age_s
    east_m = distance_m * math.sin(bearing_rad) + follower.east_mps * age_s
    return round(math.hypot(north_m, east_m), 1)


def status_line(beacon: Beacon, follower: Follower, counter: int | None) -> str:
    """One plain line for the crew, what matters most first: a narrow terminal cuts off the end."""
    asked = _WISH_TEXTS[beacon.wish] + (" (no sticks)" if beacon.wish is Wish.REMOTE and beacon.sticks is None else "")
    parts = [_follower_text(beacon, follower), f"link {'--' if counter is None else counter}", f"asks {asked} [m r a]"]
    return " | ".join([*parts, _own_text(beacon.nav)] if beacon.placed else ["NO FIX", *parts])


def _own_text(nav: NavState) -> str:
    heading = f"{round(math.degrees(nav.yaw_rad)) % 360:03d}" if nav.heading_valid else "---"
    return f"{nav.fix.name} {math.hypot(nav.north_mps, nav.east_mps):.1f} m/s {heading} {nav.lat_deg:.5f} {nav.lon_deg:.5f}"


def _follower_text(beacon: Beacon, follower: Follower) -> str:
    if follower.heard_s is None:
        return "follower not heard yet"
    age_s = beacon.nav.t_s - follower.heard_s
    if age_s > _REPORT_S:
        return f"follower silent for {age_s:.0f} s"
    gap = gap_m(beacon, follower)
    parts = [f"follower {follower.mode or '?'} {'armed' if follower.armed else 'disarmed'}", f"gap {'--' if gap is None else f'{gap:.0f}'} m"]
    if follower.throttle is not None and follower.nozzle_deg is not None:
        parts.append(f"throttle {100.0 * follower.throttle:.0f} % nozzle {follower.nozzle_deg:+.0f}")
    return " ".join(parts)


def _is_thrifty(config: LeaderConfig, link: Link) -> bool:
    return link.name.startswith("serial:") if config.thrifty == "auto" else bool(config.thrifty)


