"""Turns of a boat → the calibration of its magnetometer: the tilt of each sample, then `field_fit`.

The first pass has no heading, so its tilt does without velocities. Each later pass runs the same readings through an
AHRS with the fit of the pass before: a better heading gives a better tilt in turns, and so a better fit. `companion
calibrate` does it with a log, the boat itself with what it has just read (`compass_calibration.py`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.core.readings import GroundVelocity, Imu, MagneticField, Reading
from companion.nav.ahrs import Ahrs
from companion.nav.field_fit import SECTORS, Array, FieldFit, fit, headings, sectors_seen
from companion.nav.lever_arms import ZERO, Vector, relative

PASSES = 3  # after the first
GOOD_RAD = math.radians(1.5)  # residual deviation above which something else is wrong
POINTS = ("north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west")
_SETTLE_S = 5.0
_FEWEST = 3  # fewest samples in a sector that counts as seen
_NAMED = 3  # most directions that a text names
_VELOCITY_SIGMA_MPS = 0.06


class TurnsError(ValueError):
    """Why the samples give no calibration, without the remedy. `brief`: the same in at most 26 characters, for a
    STATUSTEXT."""

    def __init__(self, text: str, brief: str) -> None:
        super().__init__(text)
        self.brief = brief


@dataclass(frozen=True, slots=True)
class Turns:
    """The samples: time, field as measured, and tilt (roll, pitch) of each; and the dip of the Earth's field."""

    t_s: Array
    field: Array
    tilt: Array
    dip_rad: float


class TiltPass:
    """One pass over the readings of one device and all velocities, in order of time: `take` each, then `turns`.

    `rough`: the fit of the pass before. Without one the heading is meaningless, so velocities are not used. `ahrs`: the
    filter, whose tilt it is. Remembers the samples.
    """

    def __init__(
        self, lever_m: Vector, levers_m: Mapping[str, Vector], gravity_mps2: float, rough: FieldFit | None
    ) -> None:
        """`lever_m`: place of the device; `levers_m`: those of all sensors."""
        self._lever_m, self._levers_m = lever_m, levers_m
        self._rough = rough
        self.ahrs = Ahrs(gravity_mps2)
        self.samples: list[tuple[float, ...]] = []

    def take(self, reading: Reading) -> bool:
        """Take one reading; returns whether it gave a sample."""
        ahrs, rough = self.ahrs, self._rough
        if isinstance(reading, Imu):
            r = reading
            ahrs.sample(
                r.t_s, (r.x_mps2, r.y_mps2, r.z_mps2), (r.roll_rate_radps, r.pitch_rate_radps, r.yaw_rate_radps)
            )
        elif isinstance(reading, MagneticField):
            return self._take_field(reading)
        elif isinstance(reading, GroundVelocity) and rough is not None:
            lever_m = relative(self._levers_m.get(reading.source, ZERO), self._lever_m)
            ahrs.velocity(reading.t_s, reading.north_mps, reading.east_mps, _VELOCITY_SIGMA_MPS, lever_m)
        return False

    def _take_field(self, field: MagneticField) -> bool:
        ahrs, measured = self.ahrs, (field.x, field.y, field.z)
        if self._rough is not None:
            x, y, z = (self._rough.matrix @ (np.array(measured) - self._rough.offset)).tolist()
            ahrs.magnetic(field.t_s, (x, y, z), 0.0)
        elif not ahrs.running:
            ahrs.magnetic(field.t_s, (1.0, 0.0, 0.0), 0.0)
        if not ahrs.running:
            return False
        roll, pitch, _ = ahrs.attitude
        self.samples.append((field.t_s, *measured, roll, pitch))
        return True

    def turns(self, dip_rad: float, most: int) -> Turns:
        """At most `most` of the samples. Raises TurnsError where there are none."""
        if not self.samples:
            raise TurnsError("the readings end before the tilt was known", "the tilt was not known")
        table = np.array(self.samples)
        table = table[table[:, 0] > table[0, 0] + _SETTLE_S]
        spread = table[_all_round(table[:, 1:4], most)]
        return Turns(spread[:, 0], spread[:, 1:4], spread[:, 4:], dip_rad)


def _all_round(field: Array, most: int) -> NDArray[np.intp]:
    """Rows, as many of each direction of the field about its middle, evenly in time: where a boat waits tells no more
    than where it turns."""
    if not len(field):
        return np.zeros(0, dtype=np.intp)
    x, y, _ = (field - 0.5 * (field.min(axis=0) + field.max(axis=0))).T
    sector = (np.mod(np.arctan2(y, x), math.tau) * SECTORS / math.tau).astype(int) % SECTORS
    each, rows = max(1, most // SECTORS), [np.flatnonzero(sector == k) for k in range(SECTORS)]
    spread = [row[np.linspace(0, len(row) - 1, min(each, len(row))).astype(int)] for row in rows]
    return np.asarray(np.sort(np.concatenate(spread)), dtype=np.intp)


def fit_turns(turns: Turns) -> FieldFit:
    """The fit of the samples. Raises TurnsError for too few of them, or where headings are missing."""
    try:
        found = fit(turns.field, turns.tilt, turns.dip_rad)
    except ValueError as error:
        raise TurnsError(str(error), "too few samples") from error
    heading, _ = headings((turns.field - found.offset) @ found.matrix, turns.tilt)
    missing = np.flatnonzero(sectors_seen(heading) < _FEWEST)
    if len(missing):
        towards = sorted({round(8 * (k + 0.5) / SECTORS) % 8 for k in missing.tolist()})
        named, further = [POINTS[k] for k in towards[:_NAMED]], len(towards) - _NAMED
        letters = ["".join(word[0].upper() for word in point.split("-")) for point in named]
        raise TurnsError(
            f"no headings to the {', '.join(named)}{f' and {further} more' if further > 0 else ''}",
            f"no headings {', '.join(letters)}{f' +{further}' if further > 0 else ''}",
        )
    return found


def left_rad(found: FieldFit) -> float:
    """RMS of the deviation that the fit leaves."""
    return float(np.sqrt(np.mean(found.deviation_rad**2)))


def wander_rad(found: FieldFit) -> float:
    """The slow error of a heading by that calibration, for the filter (`heading_wander_deg`)."""
    return max(math.radians(1.0), 2.0 * left_rad(found))
