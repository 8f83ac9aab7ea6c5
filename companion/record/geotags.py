"""geotags.csv of a log folder: one row a picture, in the units that photogrammetry programs read."""

from __future__ import annotations

import math

from companion.core.angles import wrap_two_pi
from companion.core.payload import Shot

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
HEADER = (",".join(COLUMNS) + "\n").encode()


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
