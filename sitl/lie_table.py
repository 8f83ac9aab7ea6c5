"""The faults of sensors that have a device and a size: lies, and honest troubles of receivers. Names, what each does,
and the size that it has where none is given."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

IMU_AXES = ("x", "y", "z", "roll", "pitch", "yaw")  # of specific force, and of angular rate
LATEST_S = 10.0  # of a receiver's solutions
_BIASES = (0.5, 0.5, 0.5, 3.0, 3.0, 3.0)
_UNITS = ("m/s²",) * 3 + ("deg/s",) * 3


@dataclass(frozen=True, slots=True)
class Lie:
    """What a lying sensor does, for people. `size`: what NAME=SIZE replaces, in `unit`; None: the lie has no size.
    `limits`: the least and the largest that mean something."""

    text: str
    size: float | None = None
    unit: str = ""
    limits: tuple[float, float] = (-math.inf, math.inf)


LIES: Mapping[str, Lie] = {
    "gnss_frozen": Lie("receivers repeat their last position, velocity and heading"),
    "position_frozen": Lie("receivers repeat their last position; velocity and heading go on"),
    "velocity_frozen": Lie("receivers repeat their last velocity"),
    "heading_frozen": Lie("headings repeat: of receivers, compasses and inertial sensors"),
    "gnss_jump": Lie("positions are off to the north-east", 25.0, "m"),
    "position_creep": Lie("positions creep to the north-east, which the velocities do not show", 0.5, "m/s"),
    "gnss_spoof": Lie("positions creep to the north-east, and velocities show it from the first moment", 0.5, "m/s"),
    "gnss_pull": Lie("positions and velocities are pulled to the north-east ever faster", 0.05, "m/s²"),
    "velocity_off": Lie("velocities are off to the north-east", 0.5, "m/s"),
    "heading_turned": Lie("headings are turned: of receivers, compasses and inertial sensors", 180.0, "deg"),
    "heading_creep": Lie("headings creep to starboard", 1.0, "deg/s"),
    "heading_noise": Lie("headings have this much noise, of which nothing is reported", 20.0, "deg"),
    "gnss_stale": Lie("receivers repeat their last sentences, with the time that these have"),
    "gnss_mirrored": Lie("positions have the wrong one of N and S"),
    "altitude_off": Lie("altitudes are off", 1000.0, "m"),
    "accuracy_lie": Lie("positions have this much noise, of which accuracy and kind of fix show nothing", 0.15, "m"),
    "time_jump": Lie("the receivers' absolute time is ahead", 60.0, "s"),
    "time_fast": Lie("the receivers' absolute time runs fast by this share", 0.02),
    "imu_repeats": Lie("inertial sensors repeat their last sample"),
    **{f"imu_{axis}_stuck": Lie(f"the {axis} axis of inertial sensors repeats its last value") for axis in IMU_AXES},
    **{f"imu_{axis}_reversed": Lie(f"the {axis} axis of inertial sensors has the wrong sign") for axis in IMU_AXES},
    **{
        f"imu_{axis}_biased": Lie(f"the {axis} axis of inertial sensors is off", size, unit)
        for axis, size, unit in zip(IMU_AXES, _BIASES, _UNITS, strict=True)
    },
    **{
        f"imu_{axis}_scaled": Lie(f"the {axis} axis of inertial sensors is off by this factor", 1.2)
        for axis in IMU_AXES
    },
    "imu_clipped": Lie("forces of inertial sensors end at this size on each axis", 10.5, "m/s²", (0.0, math.inf)),
    "imu_clock_jump": Lie("the inertial sensors' own clock is ahead", 1.0, "s"),
    "imu_clock_fast": Lie("the inertial sensors' own clock runs fast by this share", 0.01, "", (-0.5, math.inf)),
    "imu_doubled": Lie("inertial sensors send each sample twice"),
    "imu_swapped": Lie("of two samples of inertial sensors the later one comes first"),
    "wind_frozen": Lie("wind sensors repeat their last wind"),
    "wind_turned": Lie("winds come from another side", 180.0, "deg"),
    "wind_scaled": Lie("wind speeds are off by this factor", 10.0, "", (0.0, math.inf)),
    "depth_frozen": Lie("sounders repeat their last depth"),
    "depth_scaled": Lie(
        "depths are off by this factor, as feet are that are told as metres", 3.28, "", (0.0, math.inf)
    ),
}

TROUBLES: Mapping[str, Lie] = {
    "gnss_late": Lie(
        "receivers' values are that old when they are sent, and bear the time of sending", 0.3, "s", (0.0, LATEST_S)
    ),
    "gnss_jitter": Lie("solutions arrive later by up to that, each by another time", 0.1, "s", (0.0, LATEST_S)),
    "gnss_dropped": Lie("that share of the solutions is left out", 0.3, "", (0.0, 1.0)),
    "gnss_multipath": Lie("positions have a further error of that size, another one every 20 s", 0.5, "m"),
}
SIZED: Mapping[str, Lie] = {**LIES, **TROUBLES}


def text_of(lie: Lie) -> str:
    """What it does, with the size that it has where none is given."""
    return lie.text if lie.size is None else f"{lie.text}; {lie.size:g} {lie.unit}".rstrip()
