"""geotags.csv: one row a picture, in the units that photogrammetry programs read."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

from companion.core.angles import wrap_two_pi
from companion.core.payload import Shot
from companion.core.tick import Tick
from companion.record.recorder import Syncer, WrittenThrough

FILE = "geotags.csv"
COLUMNS = (
    "t_s",
    "time_unix_ns",
    "camera",
    "image",
    "lat_deg",
    "lon_deg",
    "altitude_m",
    "heading_deg",
    "roll_deg",
    "pitch_deg",
    "speed_mps",
    "position_accuracy_m",
    "heading_accuracy_deg",
)


class GeotagFile:
    """Recorder of the pictures, beside the log."""

    def __init__(self, folder: Path, on_warning: Callable[[str], None], sync: bool) -> None:
        """`sync`: sync each row to the medium. Raises OSError when the file cannot be written."""
        folder.mkdir(parents=True, exist_ok=True)
        self._file = WrittenThrough(folder / FILE, on_warning)
        self._file.write((",".join(COLUMNS) + "\n").encode())
        self._syncer = Syncer([self._file]) if sync else None

    def record(self, tick: Tick) -> None:
        """Write the rows of the pictures of a tick."""
        if tick.shots:
            time_unix_ns = tick.nav.time_unix_ns or tick.time_unix_ns
            self._file.write(b"".join(geotag_row(shot, time_unix_ns) for shot in tick.shots))

    def close(self) -> None:
        """Close the file."""
        if self._syncer is not None:
            self._syncer.close()
        self._file.close()


def geotag_row(shot: Shot, time_unix_ns: int) -> bytes:
    """The line of a picture; empty where a value is not known."""
    return (
        f"{shot.t_s:.3f},{time_unix_ns},{shot.name},{shot.number}"
        f",{_known(shot.lat_deg, 9)},{_known(shot.lon_deg, 9)},{_known(shot.altitude_m, 3)}"
        f",{_known(math.degrees(wrap_two_pi(shot.yaw_rad)), 3)}"
        f",{_known(math.degrees(shot.roll_rad), 3)},{_known(math.degrees(shot.pitch_rad), 3)}"
        f",{_known(shot.speed_mps, 3)},{_known(shot.position_accuracy_m, 3)}"
        f",{_known(math.degrees(shot.heading_accuracy_rad), 3)}\n"
    ).encode()


def _known(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if math.isfinite(value) else ""
