"""The log folder: ticks.csv, readings.csv, events.csv, telemetry.tlog, manifest.json, state/, and on a boat ticks.ulg.

Each row leaves the process with one `write`, and so do the packets of one exchange: `kill -9` loses at most what is
being written. On a boat a second thread syncs the files to the medium (`fdatasync`) as fast as it can, so a power cut
loses at most what the medium was writing. The control thread never waits for a medium. (The ReVolt thesis lost a
recording at each power cut.)
"""

from __future__ import annotations

import json
import os
import struct
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from companion.core.decision import Event
from companion.core.setpoint import PathSetpoint, PoseSetpoint, desired_motion
from companion.core.tick import DeviceHealth, Tick
from companion.params.spec import ParamSpec, ParamType
from companion.record import readings, ulog

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_WRENCH = ("surge_n", "sway_n", "yaw_nm")
EVENT_COLUMNS = ("t_s", "time_unix_ns", "severity", "name", "text")
STATE_FOLDER = "state"  # in a log folder: copy of the state directory at the start of the run
_COUNTS_PERIOD_S = 60.0


class WrittenThrough:
    """A file without buffer: a reader may open it at any moment, whatever happens to this process."""

    def __init__(self, path: Path, on_warning: Callable[[str], None]) -> None:
        self._path = path
        self._on_warning = on_warning
        self._fd: int | None = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC, 0o644)
        self.dirty = False

    def write(self, data: bytes) -> None:
        """One system call. A full disk ends this file with a warning, never the run."""
        if self._fd is None:
            return
        try:
            os.write(self._fd, data)
            self.dirty = True
        except OSError as error:
            self.close()
            self._on_warning(f"log {self._path.name} ends here: {error.strerror}")

    def sync(self) -> None:
        """Sync to the medium what was written. Called from the sync thread."""
        if self.dirty and self._fd is not None:
            self.dirty = False
            try:
                os.fdatasync(self._fd)
            except OSError:
                return  # closed meanwhile, or the file system cannot: the kernel still has the row

    def close(self) -> None:
        """Close the file; later writes are ignored."""
        fd, self._fd = self._fd, None
        if fd is not None:
            os.close(fd)


class Syncer:
    """The thread that syncs files to the medium."""

    def __init__(self, files: Sequence[WrittenThrough], pause_s: float = 0.02) -> None:
        self._files = files
        self._pause_s = pause_s
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="log-sync", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.wait(self._pause_s):
            for file in self._files:
                file.sync()

    def close(self) -> None:
        """Stop the thread, then sync once more."""
        self._stop.set()
        self._thread.join(timeout=5.0)
        for file in self._files:
            file.sync()


class LogFolder:
    """Recorder of a run. `thrusters` and `devices` name the columns."""

    def __init__(
        self,
        folder: Path,
        thrusters: Sequence[str],
        devices: Sequence[str],
        manifest: Mapping[str, Any],
        on_warning: Callable[[str], None],
        sync: bool,
        parameters: Sequence[ParamSpec] = (),
    ) -> None:
        """`sync`: sync each row to the medium, and also write ticks.ulg, in which `parameters` says which values are
        whole numbers. Raises OSError when the folder cannot be written, which is an error at start."""
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        (folder / "manifest.json").write_text(json.dumps(manifest, indent=1, default=str) + "\n", encoding="utf-8")
        self._ticks = WrittenThrough(folder / "ticks.csv", on_warning)
        self._events = WrittenThrough(folder / "events.csv", on_warning)
        self._packets = WrittenThrough(folder / "telemetry.tlog", on_warning)
        self._readings = WrittenThrough(folder / readings.FILE, on_warning)
        self._encoder = readings.ReadingsEncoder()
        self._devices = tuple(devices)
        self._health: dict[str, tuple[bool, str]] = {}
        self._counted_s = 0.0
        self._ticks.write((",".join(tick_columns(thrusters, devices)) + "\n").encode())
        self._events.write((",".join(EVENT_COLUMNS) + "\n").encode())
        self._readings.write(readings.HEADER)
        self._files: tuple[WrittenThrough, ...] = (self._ticks, self._events, self._packets, self._readings)
        self._whole = frozenset(spec.name for spec in parameters if spec.type is ParamType.INT32)
        self._ulog: tuple[WrittenThrough, ulog.UlogEncoder] | None = None
        if sync:
            self._ulog = self._open_ulog(thrusters, manifest, on_warning)
            self._files = (*self._files, self._ulog[0])
        self._syncer = Syncer(self._files) if sync else None

    def _open_ulog(
        self, thrusters: Sequence[str], manifest: Mapping[str, Any], on_warning: Callable[[str], None]
    ) -> tuple[WrittenThrough, ulog.UlogEncoder]:
        file, encoder = WrittenThrough(self.folder / ulog.FILE, on_warning), ulog.UlogEncoder(thrusters)
        information = {
            "sys_name": "USV companion",
            "ver_sw": str(manifest.get("version", "")),
            "ver_hw": str(manifest.get("vessel", "")),
        }
        file.write(encoder.header(information, manifest.get("parameters", {}), self._whole))
        return file, encoder

    def record(self, tick: Tick) -> None:
        """Write the rows of a tick and its events."""
        self._readings.write(
            b"".join([*map(self._encoder.health, self._changed(tick.health, tick.t_s)), self._encoder.tick(tick)])
        )
        self._ticks.write(tick_row(tick, self._devices).encode())
        for event in tick.events:
            self._events.write(event_row(event, tick.time_unix_ns).encode())
        if self._ulog is not None:
            file, encoder = self._ulog
            file.write(encoder.tick(tick))

    def parameter(self, name: str, value: float) -> None:
        """Record the change of a parameter, among the readings."""
        self._readings.write(self._encoder.parameter(name, value))
        if self._ulog is not None:
            file, encoder = self._ulog
            file.write(encoder.parameter(name, value, name in self._whole))

    def heard(self, persona: str, endpoint: str, t_s: float, packet: bytes) -> None:
        """Record a received MAVLink packet among the readings, with the time at which it is handled."""
        self._readings.write(self._encoder.packet(persona, endpoint, t_s, packet))

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
        self._packets.write(b"".join([stamp + packet for packet in packets]))

    def close(self) -> None:
        """Close all files."""
        if self._syncer is not None:
            self._syncer.close()
        for file in self._files:
            file.close()


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
        f"{tick.t_s:.3f},{tick.time_unix_ns},{status.mode.value},{status.armed:d}"
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
    ok = {device.name: device.ok for device in tick.health}
    cells += [f"{ok.get(name, False):d}" for name in devices]
    cells += [condition.value for condition in tick.conditions]
    return ",".join(cells) + "\n"


def event_row(event: Event, time_unix_ns: int) -> str:
    """One line of events.csv; the text is quoted."""
    text = event.text.replace('"', "'").replace("\n", " ")
    return f'{event.t_s:.3f},{time_unix_ns},{event.severity.name},{event.name},"{text}"\n'


def _optional(value: float | None) -> str:
    return "" if value is None else f"{value:.5f}"
