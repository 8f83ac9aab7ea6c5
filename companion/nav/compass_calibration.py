"""A magnetometer calibrated aboard, while the boat turns round twice, slowly."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from companion.config.devices import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.events import SHORT_NAME
from companion.core.readings import GroundVelocity, Imu, MagneticField, Reading
from companion.nav.compass_turns import PASSES, TiltPass, TurnsError, fit_turns, left_rad
from companion.nav.field_fit import SECTORS, FieldFit
from companion.nav.lever_arms import Vector
from companion.nav.mounting import Mounting

_SAMPLES = 600  # for one fit within a tick
_PATH_RAD = 2.0 * math.tau
_STEP_RAD = math.tau / SECTORS  # smaller swings are waves
_FASTEST_RADPS = math.radians(30.0)  # a faster turn gives too few samples
_COLLECTED = 0.9  # of the progress; the fit is the rest
_AT_ONCE = 400  # readings of a later pass in one tick
_SILENT_S = 3.0
_STANDS_S = 60.0
_LONGEST_S = 900.0
_MOST_LEFT_RAD = math.radians(5.0)


class CompassCalibration:
    """Call `update` with the readings of each tick until `result` or `failure` is set.

    First it collects, until the gyro has seen two turns and every direction; then it fits, some readings a tick.
    `progress`: 0…1; `sectors`: directions seen, by the gyro. `result` is for the magnetometer's own axes. Remembers the
    readings.
    """

    def __init__(
        self,
        row: SensorConfig,
        mounting: Mounting,
        levers_m: Mapping[str, Vector],
        gravity_mps2: float,
        dip_rad: float,
        now_s: float,
    ) -> None:
        self.row = row
        self._mounting = mounting
        self.progress = 0.0
        self.sectors: frozenset[int] = frozenset()
        self.result: FieldFit | None = None
        self.failure: str | None = None
        self._levers_m, self._gravity_mps2, self._dip_rad = levers_m, gravity_mps2, dip_rad
        self._readings: list[Reading] = []
        self._path_rad = 0.0
        self._marked_rad: float | None = None  # heading up to which the way turned is counted
        self._imu_s = self._field_s = self._turned_s = self._begin_s = now_s
        self._passes = 0
        self._at = 0  # reading that the later pass has come to
        self._tilts = self._pass(None)

    @property
    def direction(self) -> Vector:
        """The newest field in the boat's axes, not calibrated, of length 1; zero before the first."""
        if not self._tilts.samples:
            return 0.0, 0.0, 0.0
        x, y, z = self._tilts.samples[-1][1:4]
        length = math.hypot(x, y, z) or 1.0
        return x / length, y / length, z / length

    def update(self, readings: Sequence[Reading], now_s: float) -> None:
        """Take the readings of a tick, in any order. Does nothing after the end."""
        if self.result is not None or self.failure is not None:
            return
        try:
            if self._passes == 0:
                self._collect(readings, now_s)
            else:
                self._go_on()
        except TurnsError as error:
            self.failure = error.brief

    def _pass(self, rough: FieldFit | None) -> TiltPass:
        lever_m = self.row.x_m, self.row.y_m, self.row.z_m
        return TiltPass(lever_m, self._levers_m, self._gravity_mps2, rough)

    # --- collecting ------------------------------------------------------------------------------------------------

    def _collect(self, readings: Sequence[Reading], now_s: float) -> None:
        own = [self._turned(reading) for reading in readings if self._is_mine(reading)]
        own.sort(key=lambda reading: reading.t_s)
        for reading in own:
            self._readings.append(reading)
            if isinstance(reading, Imu):
                self._imu_s = now_s
            elif isinstance(reading, MagneticField):
                self._field_s = now_s
            if self._tilts.take(reading):
                self._follow(now_s)
        self.failure = self._failure(now_s)
        turned = min(1.0, self._path_rad / _PATH_RAD)
        self.progress = _COLLECTED * min(turned, len(self.sectors) / SECTORS)
        if self.progress >= _COLLECTED and self.failure is None:
            self._finish_pass()

    def _is_mine(self, reading: Reading) -> bool:
        if isinstance(reading, Imu | MagneticField):
            return reading.source == self.row.name
        return isinstance(reading, GroundVelocity)

    def _turned(self, reading: Reading) -> Reading:
        if isinstance(reading, Imu):
            return self._mounting.turned(reading)
        return self._mounting.field(reading) if isinstance(reading, MagneticField) else reading

    def _follow(self, now_s: float) -> None:
        """Count the way turned, by the gyro."""
        ahrs = self._tilts.ahrs
        yaw_rad = ahrs.attitude[2]
        if self._marked_rad is None or abs(ahrs.rates[2]) > _FASTEST_RADPS:
            self._marked_rad = yaw_rad
            return
        step_rad = abs(wrap_pi(yaw_rad - self._marked_rad))
        if step_rad >= _STEP_RAD:
            self._path_rad += step_rad
            self._marked_rad, self._turned_s = yaw_rad, now_s
        self.sectors |= {int(yaw_rad % math.tau * SECTORS / math.tau) % SECTORS}

    def _failure(self, now_s: float) -> str | None:
        if now_s - self._imu_s > _SILENT_S:
            return f"{self.row.name[:SHORT_NAME]} is silent"
        if now_s - self._field_s > _SILENT_S:
            return f"no field from {self.row.name[: SHORT_NAME - 4]}"
        if now_s - self._turned_s > _STANDS_S:
            return f"no turn for {_STANDS_S:.0f} s"
        return f"no end after {_LONGEST_S:.0f} s" if now_s - self._begin_s > _LONGEST_S else None

    # --- fitting ---------------------------------------------------------------------------------------------------

    def _go_on(self) -> None:
        """The next readings of a later pass."""
        for reading in self._readings[self._at : self._at + _AT_ONCE]:
            self._tilts.take(reading)
        self._at += _AT_ONCE
        share = min(1.0, self._at / len(self._readings))
        self.progress = _COLLECTED + (1.0 - _COLLECTED) * (self._passes - 1 + share) / PASSES
        if self._at >= len(self._readings):
            self._finish_pass()

    def _finish_pass(self) -> None:
        """Fit the pass that is complete, and begin the next, if there is one."""
        found = fit_turns(self._tilts.turns(self._dip_rad, _SAMPLES))
        if self._passes == PASSES:
            self._judge(found)
            return
        self._passes += 1
        self._at = 0
        self._tilts = self._pass(found)

    def _judge(self, found: FieldFit) -> None:
        if left_rad(found) > _MOST_LEFT_RAD:
            self.failure = f"{math.degrees(left_rad(found)):.0f} deg left: iron moves?"
            return
        turn = self._mounting.compass(self.row.name)
        self.progress = 1.0
        self.result = found if turn is None else found.before_turn(turn)
