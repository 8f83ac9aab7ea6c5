"""The log folder: ticks.csv, log.mcap, events.csv, telemetry.tlog, manifest.json, state/, and on a boat ticks.ulg.

On a boat one thread writes the rows at once (`log_writer.py`), and another syncs the files to the medium
(`fdatasync`) as fast as it can: `kill -9` and a power cut lose at most what the medium was writing, and of log.mcap the
last two seconds (its chunks). The control thread never waits for a medium. (The ReVolt thesis lost a recording at each
power cut.)
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from companion.core.decision import Event
from companion.core.setpoint import PathSetpoint, PoseSetpoint, desired_motion
from companion.core.tick import DeviceHealth, Tick
from companion.params.spec import ParamSpec, ParamType
from companion.record import geotags, mcap_log, ulog
from companion.record.disk import REAL_DISK, Disk
from companion.record.log_writer import DirectLog, LogOutput, LogSet, ThreadLog

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_WRENCH = ("surge_n", "sway_n", "yaw_nm")
SLOW_COLUMNS = (
    "lat_deg",
    "lon_deg",
    "fix",
    "satellites",
    "corrections_age_s",
    "battery_v",
    "battery_a",
    "battery_remaining",
    "wind_speed_mps",
    "wind_from_rad",
    "current_north_mps",
    "current_east_mps",
)
EVENT_COLUMNS = ("t_s", "time_unix_ns", "severity", "name", "text")
STATE_FOLDER = "state"  # in a log folder: copy of the state directory at the start of the run
TICKS, EVENTS, PACKETS = "ticks.csv", "events.csv", "telemetry.tlog"
_COUNTS_PERIOD_S = 60.0


@dataclass(frozen=True, slots=True)
class Medium:
    """How a log is written. `durable`: with ticks.ulg, for a log that people read later. `beside`: by threads, which
    sync it too. `patient`: it begins later where the medium is full or fails at the start."""

    durable: bool = False
    beside: bool = False
    disk: Disk = REAL_DISK
    patient: bool = False


LOCKSTEP = Medium()


class LogFolder:
    """Recorder of a run. `thrusters` and `devices` name the columns.

    Remembers the health of the devices as last recorded, and the parameters as they are now, for a folder that begins
    later.
    """

    def __init__(
        self,
        folder: Path,
        thrusters: Sequence[str],
        devices: Sequence[str],
        manifest: Mapping[str, Any],
        parameters: Sequence[ParamSpec] = (),
        medium: Medium = LOCKSTEP,
        furnish: Callable[[Path], None] = lambda folder: None,
        cameras: bool = False,
    ) -> None:
        """`parameters` says which values are whole numbers. `furnish`: puts more into each new folder.
        `cameras`: with geotags.csv. Raises OSError when the folder cannot be written, which is an error at start."""
        self._manifest = dict(manifest)
        self._furnish = furnish
        self._cameras = cameras
        self._thrusters = tuple(thrusters)
        self._devices = tuple(devices)
        self._parameters: dict[str, float] = dict(manifest.get("parameters", {}))
        self._whole = frozenset(spec.name for spec in parameters if spec.type is ParamType.INT32)
        self._closed = False
        self._encoder = mcap_log.McapEncoder()
        self._ulog = ulog.UlogEncoder(thrusters) if medium.durable else None
        self._health: dict[str, tuple[bool, str]] = {}
        self._counted_s = self._now_s = 0.0
        files = LogSet(folder, self, medium.disk, medium.patient)
        self._out: LogOutput = ThreadLog(files) if medium.beside else DirectLog(files)
        self._number = self._out.number

    @property
    def output(self) -> LogOutput:
        """Where the rows go."""
        return self._out

    def headers(self) -> Mapping[str, bytes]:
        """As `LogContent.headers`."""
        headers = {
            TICKS: (",".join(tick_columns(self._thrusters, self._devices)) + "\n").encode(),
            EVENTS: (",".join(EVENT_COLUMNS) + "\n").encode(),
            PACKETS: b"",
            mcap_log.FILE: self._encoder.header(),
        }
        if self._cameras:
            headers[geotags.FILE] = geotags.HEADER
        if self._ulog is not None:
            information = {
                "sys_name": "USV companion",
                "ver_sw": str(self._manifest.get("version", "")),
                "ver_hw": str(self._manifest.get("vessel", "")),
            }
            headers[ulog.FILE] = self._ulog.header(information, self._parameters.copy(), self._whole)
        return headers

    def furnish(self, folder: Path) -> None:
        """As `LogContent.furnish`."""
        manifest = {**self._manifest}
        if "parameters" in manifest:
            manifest["parameters"] = self._parameters.copy()
        (folder / "manifest.json").write_text(json.dumps(manifest, indent=1, default=str) + "\n", encoding="utf-8")
        self._furnish(folder)

    def record(self, tick: Tick) -> None:
        """Write the rows of a tick and its events."""
        self._now_s = tick.t_s
        if self._out.number != self._number:
            self._number = self._out.number
            self._health.clear()
        if self._out.stopped is not None:
            self._encoder.drop()
        self._encoder.tick(tick, self._changed(tick.health, tick.t_s))
        self._write(mcap_log.FILE, self._encoder.due())
        self._write(TICKS, tick_row(tick, self._devices).encode())
        if tick.events:
            self._write(EVENTS, "".join([event_row(event, tick.time_unix_ns) for event in tick.events]).encode())
        if self._cameras and tick.shots:
            time_unix_ns = tick.nav.time_unix_ns or tick.time_unix_ns
            self._write(geotags.FILE, b"".join([geotags.geotag_row(shot, time_unix_ns) for shot in tick.shots]))
        if self._ulog is not None:
            self._write(ulog.FILE, self._ulog.tick(tick))

    def parameter(self, name: str, value: float) -> None:
        """Record the change of a parameter, among the readings."""
        self._parameters[name] = value
        self._encoder.parameter(name, value)
        if self._ulog is not None:
            self._write(ulog.FILE, self._ulog.parameter(name, value, name in self._whole))

    def heard(self, persona: str, endpoint: str, t_s: float, packet: bytes) -> None:
        """Record a received MAVLink packet among the readings, with the time at which it is handled."""
        self._encoder.packet(persona, endpoint, t_s, packet)

    def _write(self, name: str, data: bytes) -> None:
        if data:
            self._out.put(name, data, self._now_s)

    def _changed(self, health: Sequence[DeviceHealth], now_s: float) -> list[DeviceHealth]:
        """Devices whose health changed; once a minute all of them, for their counts and rates."""
        changed = []
        counts = now_s - self._counted_s >= _COUNTS_PERIOD_S
        if counts:
            self._counted_s = now_s
        for device in health:
            now = device.ok, "" if device.ok else device.text
            if device.name in self._devices and (counts or self._health.get(device.name) != now):
                self._health[device.name] = now
                changed.append(device)
        return changed

    def packets(self, packets: Sequence[bytes], time_unix_ns: int) -> None:
        """Record whole MAVLink packets, sent or received, in .tlog form: before each, microseconds since 1970,
        big-endian."""
        stamp = struct.pack(">Q", time_unix_ns // 1000)
        self._write(PACKETS, b"".join([stamp + packet for packet in packets]))

    def close(self) -> None:
        """Write what waits, and close all files. Once closed, it does nothing."""
        if not self._closed:
            self._closed = True
            self._write(mcap_log.FILE, self._encoder.end())
            self._out.close()


def tick_columns(thrusters: Sequence[str], devices: Sequence[str]) -> list[str]:
    """Header of ticks.csv."""
    return [
        "t_s",
        "time_unix_ns",
        "mode",
        "armed",
        *_POSE,
        *(f"desired_{name}" for name in _POSE),
        *(f"demanded_{name}" for name in _WRENCH),
        *(f"achieved_{name}" for name in _WRENCH),
        *(f"{name}_{part}" for name in thrusters for part in ("throttle", "azimuth_rad", "force_n")),
        "position_accuracy_m",
        "heading_accuracy_rad",
        "position_valid",
        "heading_valid",
        "cross_track_error_m",
        "mission_seq",
        "failsafes",
        "load",
        *SLOW_COLUMNS,
        *(f"{name}_ok" for name in devices),
        *(f"{name}_condition" for name in thrusters),
    ]


def tick_row(tick: Tick, devices: Sequence[str]) -> str:
    """One line of ticks.csv, with its newline. A missing value is empty."""
    nav, status, setpoint = tick.nav, tick.status, tick.setpoint
    desired = desired_motion(setpoint)
    moves = isinstance(setpoint, PoseSetpoint | PathSetpoint)
    demanded, achieved = tick.wrench, tick.allocation.achieved
    cells = [
        f"{tick.t_s:.3f},{tick.time_unix_ns},{status.mode.word},{status.armed:d}"
        f",{nav.north_m:.4f},{nav.east_m:.4f},{nav.yaw_rad:.5f},{nav.surge_mps:.4f},{nav.sway_mps:.4f},{nav.yaw_rate_radps:.5f}",
        _optional(None if desired.place is None else desired.place.north_m),
        _optional(None if desired.place is None else desired.place.east_m),
        _optional(desired.yaw_rad),
        f"{desired.surge_mps:.4f},{desired.sway_mps:.4f},{desired.yaw_rate_radps:.5f}" if moves else ",,",
        f"{demanded.surge_n:.3f},{demanded.sway_n:.3f},{demanded.yaw_nm:.3f}"
        f",{achieved.surge_n:.3f},{achieved.sway_n:.3f},{achieved.yaw_nm:.3f}",
    ]
    cells += [f"{t.throttle:.4f},{_optional(t.azimuth_rad)},{t.force_n:.3f}" for t in tick.command.thrusters]
    cells.append(
        f"{nav.position_accuracy_m:.4f},{nav.heading_accuracy_rad:.5f},{nav.position_valid:d},{nav.heading_valid:d}"
        f",{_optional(setpoint.progress.cross_track_error_m)},{status.mission.seq},{';'.join(status.failsafes)},{tick.load:.3f}"
    )
    cells.append(_slow(tick))
    ok = {device.name: device.ok for device in tick.health}
    cells += [f"{ok.get(name, False):d}" for name in devices]
    cells += [condition.word for condition in tick.conditions]
    return ",".join(cells) + "\n"


def _slow(tick: Tick) -> str:
    """The cells of SLOW_COLUMNS."""
    nav, battery, corrections = tick.nav, tick.inputs.battery, tick.inputs.corrections
    place = f"{nav.lat_deg:.9f},{nav.lon_deg:.9f}" if nav.position_valid else ","
    fix = f"{int(nav.fix)},{'' if nav.satellites is None else nav.satellites}"
    power = (
        ",," if battery is None else f"{battery.voltage_v:.3f},{_short(battery.current_a)},{_short(battery.remaining)}"
    )
    return (
        f"{place},{fix},{_short(None if corrections is None else corrections.age_s)},{power}"
        f",{_short(nav.wind_speed_mps)},{_short(nav.wind_from_rad)}"
        f",{_short(nav.current_north_mps)},{_short(nav.current_east_mps)}"
    )


def _short(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def event_row(event: Event, time_unix_ns: int) -> str:
    """One line of events.csv; the text is quoted."""
    text = event.text.replace('"', "'").replace("\n", " ")
    return f'{event.t_s:.3f},{time_unix_ns},{event.severity.name},{event.name},"{text}"\n'


def _optional(value: float | None) -> str:
    return "" if value is None else f"{value:.5f}"
