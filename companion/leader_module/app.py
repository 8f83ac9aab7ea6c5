"""The leader module: configuration, ports and clock → the program on a lead boat.

It steers nothing. It sends the lead boat's motion and what its crew asks for, and shows what the follower reports.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

from companion.app import parameter_problems, port_problems, program_version
from companion.baselines.ahrs import ThesisAhrs
from companion.config import vessel as config_module
from companion.config.vessel import ConfigError
from companion.containment import Containment
from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.geodesy import distance_and_bearing
from companion.core.ports import ByteStream, Clock, Sensor, StreamOpener
from companion.core.readings import ManualInput, Reading, Wish
from companion.core.tick import DeviceHealth
from companion.io.mavlink.wire.links import Link
from companion.io.mavlink.wire.signing import Signing
from companion.io.sensors import open_sensor, plugin_problems
from companion.leader_module.config import LeaderConfig, find_leader, parse_leader
from companion.leader_module.crew_wish import CrewWish
from companion.leader_module.fix_watch import FixWatch
from companion.leader_module.ground_station import LeadGroundStation
from companion.leader_module.joystick import Joystick
from companion.leader_module.link import Broadcast, Follower, LeadLink
from companion.leader_module.log import LeaderLog
from companion.leader_module.moving_base import RtcmTap
from companion.nav.estimator import Estimator
from companion.params.store import Parameters
from companion.params.table import table_of
from companion.record.disk import REAL_DISK, Disk
from companion.record.storage import log_health

_KEYS = {"m": Wish.MANUAL, "r": Wish.REMOTE, "a": Wish.AUTONOMOUS}
_WISH_TEXTS = {Wish.NONE: "no wish yet", Wish.MANUAL: "Manual", Wish.REMOTE: "Remote", Wish.AUTONOMOUS: "Autonomous"}
_SHOW_S = 0.2
_REPORT_S = 5.0  # age at which the follower's report is no longer shown


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
        config = parse_leader(config_module.text_of(path), str(path))
        problems += [config_module.placed(path, place, text) for place, text in plugin_problems(config.sensors)]
    except ConfigError as error:
        problems += error.problems
    except OSError as error:
        problems.append(f"{path}: cannot be read: {error.strerror or error}")
    problems += port_problems(path) + parameter_problems(path, settings)
    if config is None or problems:
        raise ConfigError(problems)
    return config


class Display(Protocol):
    """The crew's screen and keyboard (`leader_module.console.Console`)."""

    def fileno(self) -> int | None:
        """A descriptor that becomes readable when keys are pressed, or None."""
        ...

    def typed(self) -> str:
        """Keys pressed since the last call."""
        ...

    def show(self, line: str, now_s: float) -> None:
        """Replace the status line."""
        ...

    def say(self, text: str) -> None:
        """Print a line that stays."""
        ...


@dataclass(frozen=True, slots=True)
class LeaderSurroundings:
    """Where a module runs. `links`: towards the follower; `local`: for a ground station on the lead boat."""

    clock: Clock
    opener: StreamOpener
    links: Sequence[Link]
    local: Sequence[Link]
    display: Display
    log_folder: Path | None = None
    durable_log: bool = False
    disk: Disk = REAL_DISK
    signing: Signing | None = None  # has the key, for links that use signatures


def build_leader(config: LeaderConfig, around: LeaderSurroundings) -> LeaderModule:
    """The module of `config`. Raises ConfigError for an unknown driver, OSError for a log folder that cannot be
    written, unless its medium is full or fails."""
    ports = {row.name: around.opener.open(row.name, row.port) for row in config.sensors}
    bases = {row.name: RtcmTap(ports[row.name]) for row in config.sensors if row.moving_base}
    lines: dict[str, ByteStream] = {name: bases.get(name) or port for name, port in ports.items()}
    sensors = tuple(open_sensor(row, lines[row.name]) for row in config.sensors)
    parameters = Parameters(config.parameters, table_of(config))
    log = None
    if around.log_folder is not None:
        manifest = {
            "version": program_version(),
            "started_unix_ns": around.clock.time_unix_ns(),
            "parameters": {spec.name: parameters[spec.name] for spec in parameters.specs},
            "configuration": asdict(config),
        }
        log = LeaderLog(around.log_folder, manifest, around.durable_log, around.disk)
    return LeaderModule(config, around, sensors, parameters, log, tuple(bases.values()))


class LeaderModule:
    """Sense → estimate → send → show → record, `rate_hz` times a second. Between two ticks it answers its links.

    Remembers the crew's wish, the health of its devices, and what it announced last. Nothing that a device or a peer
    does ends it.
    """

    def __init__(
        self,
        config: LeaderConfig,
        around: LeaderSurroundings,
        sensors: Sequence[Sensor],
        parameters: Parameters,
        log: LeaderLog | None,
        bases: Sequence[RtcmTap] = (),
    ) -> None:
        """`bases`: ports of the receivers that are moving bases."""
        self.period_s = 1.0 / config.rate_hz
        self.load = 0.0
        self.crew = CrewWish()
        self._events = EventLog()
        self.containment = Containment(self._events.say)
        self._clock, self._display, self._log = around.clock, around.display, log
        self._sensors, self._bases = tuple(sensors), tuple(bases)
        self._estimator = Estimator(config, parameters, self._events.say, ThesisAhrs)
        self._fixes = FixWatch()
        self._joystick = Joystick(config.joystick) if config.joystick is not None else None
        self._links = tuple(
            LeadLink(
                link, config.system_id, config.follower, config.rate_hz, _is_thrifty(config, link), self._follower_says
            )
            for link in around.links
        )
        self._ground_stations = tuple(
            LeadGroundStation(link, config.system_id, self.crew, self._note) for link in around.local
        )
        self._radios: tuple[LeadLink | LeadGroundStation, ...] = (*self._links, *self._ground_stations)
        self._signing = around.signing
        for number, link in enumerate((*around.links, *around.local)):
            link.guard.signing, link.guard.number = around.signing, number
        self._arrived: list[Reading] = []
        self._ok: dict[str, bool] = {}
        self._shown_s = -math.inf
        self._announced_presses = 0

    @property
    def link(self) -> LeadLink:
        """The link on which the follower was last received."""
        return max(self._links, key=lambda link: -math.inf if link.follower.heard_s is None else link.follower.heard_s)

    def filenos(self) -> Sequence[int]:
        """Descriptors that become readable when there is something to serve."""
        ports = [*(sensor.fileno() for sensor in self._sensors), self._display.fileno()]
        ports.append(None if self._joystick is None else self._joystick.fileno())
        return [*(n for radio in self._radios for n in radio.filenos()), *(n for n in ports if n is not None)]

    def serve(self, now_s: float) -> None:
        """Between two ticks: read the sensors and keys, answer the links."""
        for sensor in self._sensors:
            self._arrived.extend(self.containment.driver(sensor.name, partial(sensor.read, now_s), (), now_s))
        if self._joystick is not None:
            self._joystick.read(now_s)
        for key in self._display.typed():
            if key in _KEYS:
                self.crew.press(_KEYS[key])
        for radio in self._radios:
            try:
                radio.serve(now_s)
            except Exception as error:  # noqa: BLE001  a peer's message must not stop the module
                self._events.say(
                    now_s, TextKind.FAULT, "link_failed", f"message not handled: {type(error).__name__}: {error}"
                )

    def tick(self, now_s: float) -> None:
        """One cycle; one that fails is left out and announced, as `Containment` has it."""
        try:
            self.cycle(now_s)
        except Exception as error:  # noqa: BLE001  it is raised again where it should be
            self.containment.tick_failed(error, now_s)
        else:
            self.containment.tick_done()

    def cycle(self, now_s: float) -> None:
        """All steps in their order."""
        self.serve(now_s)
        readings, self._arrived = self._arrived, []
        nav = self._estimator.update(readings, now_s)
        placed = self._fixes.update(readings, nav, now_s)
        broadcast = Broadcast(nav, placed, self.crew.wish, self.crew.presses, self._sticks(now_s))
        frames = [frame for base in self._bases for frame in base.frames()]
        for link in self._links:
            link.publish(broadcast)
            link.send_corrections(frames, now_s)
        for ground_station in self._ground_stations:
            ground_station.publish(nav, placed)
        self._announce_changes(placed, now_s)
        self._show(broadcast)
        self._record(broadcast, readings)

    def close(self) -> None:
        """Close links, devices and log."""
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
        """Those of the gamepad, else of a ground station aboard."""
        held = None if self._joystick is None else self._joystick.read(now_s)
        return held or next(
            (lent for ground_station in self._ground_stations if (lent := ground_station.sticks(now_s)) is not None),
            None,
        )

    def _follower_says(self, now_s: float, text: str) -> None:
        self._events.say(now_s, TextKind.ROUTINE, "follower", f"follower: {text}")
        for ground_station in self._ground_stations:
            ground_station.tell(TextKind.ROUTINE, f"follower: {text}")

    def _note(self, now_s: float, text: str) -> None:
        self._events.say(now_s, TextKind.ROUTINE, "station", text)

    def _announce_changes(self, placed: bool, now_s: float) -> None:
        """Announce changes of device health, of the fix, and of the crew's wish: on the terminal and in the log."""
        for health in self._states(now_s):
            name = health.name
            if self._ok.get(name) != health.ok and (name in self._ok or not health.ok):
                # a link's fault already has its name
                text = f"{name}: {'back' if health.ok else health.text.removeprefix(f'{name}: ')}"
                self._events.say(now_s, TextKind.ROUTINE if health.ok else TextKind.ATTENTION, f"{name}_health", text)
            self._ok[name] = health.ok
        if self._ok.get("fix") != placed:
            self._ok["fix"] = placed
            self._events.say(
                now_s,
                TextKind.ROUTINE if placed else TextKind.ATTENTION,
                "fix",
                "fix" if placed else "no fix: reported to the follower",
            )
        if self._announced_presses != self.crew.presses:
            self._announced_presses = self.crew.presses
            self._events.say(
                now_s, TextKind.ROUTINE, f"press{self.crew.presses}", f"asked for: {_WISH_TEXTS[self.crew.wish]}"
            )
        for event in self._events.drain():
            self._display.say(event.text)
            if self._log is not None:
                self._log.event(event, self._clock.time_unix_ns())

    def _states(self, now_s: float) -> list[DeviceHealth]:
        states = [self.containment.health(sensor, now_s) for sensor in self._sensors]
        states += [radio.health(now_s) for radio in self._radios]
        if self._joystick is not None:
            states.append(self._joystick.health(now_s))
        if self._log is not None:
            states.append(log_health(self._log.output))
        return states

    def _show(self, broadcast: Broadcast) -> None:
        now_s = broadcast.nav.t_s
        if now_s - self._shown_s >= _SHOW_S:
            self._shown_s = now_s
            self._display.show(status_line(broadcast, self.link.follower, self.link.counter), now_s)

    def _record(self, broadcast: Broadcast, readings: Sequence[Reading]) -> None:
        if self._log is None:
            return
        self._log.readings(readings, broadcast.nav.t_s, self._clock.time_unix_ns())
        nav, sticks, link = broadcast.nav, broadcast.sticks, self.link
        follower = link.follower
        self._log.row(
            {
                "t_s": round(nav.t_s, 4),
                "time_unix_ns": self._clock.time_unix_ns(),
                "placed": broadcast.placed,
                "heading_valid": nav.heading_valid,
                "lat_deg": f"{nav.lat_deg:.8f}" if broadcast.placed else None,
                "lon_deg": f"{nav.lon_deg:.8f}" if broadcast.placed else None,
                "north_mps": round(nav.north_mps, 3),
                "east_mps": round(nav.east_mps, 3),
                "yaw_rad": round(nav.yaw_rad, 4) if nav.heading_valid else None,
                "yaw_rate_radps": round(nav.yaw_rate_radps, 4),
                "position_accuracy_m": round(nav.position_accuracy_m, 3),
                "wish": broadcast.wish.name,
                "presses": broadcast.presses,
                "surge": None if sticks is None else sticks.surge,
                "yaw": None if sticks is None else sticks.yaw,
                "link_counter": link.counter,
                "follower_mode": follower.mode,
                "follower_armed": follower.armed,
                "follower_age_s": None if follower.heard_s is None else round(nav.t_s - follower.heard_s, 2),
                "gap_m": gap_m(broadcast, follower),
                "throttle": follower.throttle,
                "nozzle_deg": follower.nozzle_deg,
            }
        )


def gap_m(broadcast: Broadcast, follower: Follower) -> float | None:
    """Distance to the follower, moved on with its velocity since its report; None where either place is unknown."""
    nav, age_s = broadcast.nav, broadcast.nav.t_s - follower.position_s
    if not broadcast.placed or follower.lat_deg is None or follower.lon_deg is None or age_s > _REPORT_S:
        return None
    distance_m, bearing_rad = distance_and_bearing(nav.lat_deg, nav.lon_deg, follower.lat_deg, follower.lon_deg)
    north_m = distance_m * math.cos(bearing_rad) + follower.north_mps * age_s
    east_m = distance_m * math.sin(bearing_rad) + follower.east_mps * age_s
    return round(math.hypot(north_m, east_m), 1)


def status_line(broadcast: Broadcast, follower: Follower, counter: int | None) -> str:
    """The status as one plain line, the most important first: a narrow terminal cuts off its end."""
    asked = _WISH_TEXTS[broadcast.wish] + (
        " (no sticks)" if broadcast.wish is Wish.REMOTE and broadcast.sticks is None else ""
    )
    parts = [
        _follower_text(broadcast, follower),
        f"link {'--' if counter is None else counter}",
        f"asks {asked} [m r a]",
    ]
    return " | ".join([*parts, _own_text(broadcast.nav)] if broadcast.placed else ["NO FIX", *parts])


def _own_text(nav: NavState) -> str:
    heading = f"{round(math.degrees(nav.yaw_rad)) % 360:03d}" if nav.heading_valid else "---"
    place = f"{nav.lat_deg:.5f} {nav.lon_deg:.5f}"
    return f"{nav.fix.name} {math.hypot(nav.north_mps, nav.east_mps):.1f} m/s {heading} {place}"


def _follower_text(broadcast: Broadcast, follower: Follower) -> str:
    if follower.heard_s is None:
        return "follower not heard yet"
    age_s = broadcast.nav.t_s - follower.heard_s
    if age_s > _REPORT_S:
        return f"follower silent for {age_s:.0f} s"
    gap = gap_m(broadcast, follower)
    parts = [
        f"follower {follower.mode or '?'} {'armed' if follower.armed else 'disarmed'}",
        f"gap {'--' if gap is None else f'{gap:.0f}'} m",
    ]
    if follower.throttle is not None and follower.nozzle_deg is not None:
        parts.append(f"throttle {100.0 * follower.throttle:.0f} % nozzle {follower.nozzle_deg:+.0f}")
    return " ".join(parts)


def _is_thrifty(config: LeaderConfig, link: Link) -> bool:
    return link.name.startswith("serial:") if config.thrifty == "auto" else bool(config.thrifty)
