"""Calibrations that a ground station asks for: compass, level, gyro. One runs at a time; its result is parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from companion.config.devices import SensorConfig
from companion.config.vessel import VesselConfig
from companion.core.decision import ACCEPTED, Need, Outcome, Result, TextKind
from companion.core.estimate import NavState
from companion.core.events import SHORT_NAME, EventLog
from companion.core.geomagnetism import decimal_year, field_nt
from companion.core.readings import Reading
from companion.nav.compass_calibration import CompassCalibration
from companion.nav.compass_turns import left_rad, wander_rad
from companion.nav.corrections import inertial_sensors, magnetometers
from companion.nav.field_fit import FieldFit
from companion.nav.lever_arms import Vector, lever_arms, normal_gravity_mps2
from companion.nav.mounting import Mounting
from companion.nav.sources import plausible
from companion.nav.still_calibration import StillMean, between_rad, level_of
from companion.params.store import Parameters
from companion.supervisor.helm import Helm

_LEVEL = ("SENS_BOARD_X_OFF", "SENS_BOARD_Y_OFF")
_LEVEL_S, _LEVEL_SWING_RADPS = 10.0, math.radians(8.0)  # waves average out
_ASKEW_RAD = math.radians(1.0)
_GYRO_S, _GYRO_SWING_RADPS, _GYRO_TURN_RAD = 5.0, math.radians(0.5), math.radians(1.5)


class CalibrationKind(Enum):
    """What is calibrated; the value is for people."""

    COMPASS = "Compass"
    LEVEL = "Level"
    GYRO = "Gyro"


class CalibrationPhase(Enum):
    """How far a calibration is."""

    RUNNING = "running"
    FITTED = "fitted"  # waits to be accepted
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"


@dataclass(frozen=True, slots=True)
class CompassState:
    """One magnetometer, of that number. `direction`: its newest field, of length 1; `fit`: once there is one."""

    number: int
    name: str
    progress: float
    direction: Vector
    failure: str | None
    fit: FieldFit | None


@dataclass(frozen=True, slots=True)
class CalibrationState:
    """The calibration that runs, or ran last. `run` counts them; `progress`: 0…1; `text`: why it failed."""

    run: int
    kind: CalibrationKind
    phase: CalibrationPhase
    progress: float
    text: str = ""
    compasses: tuple[CompassState, ...] = ()


Part = CompassCalibration | StillMean


class CalibrationDuty:
    """`request`, `accept`, `cancel` → Outcome; `take` the readings of each tick, before the estimate does. `state`:
    None before the first calibration.

    Remembers the calibration that runs, and the state of the last one. A result is stored as parameters, which take
    effect at once.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        helm: Helm,
        events: EventLog,
        nav_of: Callable[[], NavState],
    ) -> None:
        """`nav_of()`: the newest estimate, for the place."""
        self.state: CalibrationState | None = None
        self._config = config
        self._parameters = parameters
        self._helm = helm
        self._events = events
        self._nav_of = nav_of
        self._magnetometers = magnetometers(config.sensors)
        self._inertial = inertial_sensors(config.sensors)
        self._mounting = Mounting(config, parameters)
        self._levers = lever_arms(config.sensors)
        self._parts: Mapping[int, Part] = {}  # by the sensors' numbers in the parameters
        self._save = True
        self._runs = 0

    # --- requests --------------------------------------------------------------------------------------------------

    def request(self, kind: CalibrationKind, now_s: float, save: bool = True, bits: int = 0) -> Outcome:
        """Begin a calibration. `save`: store its result at once, without `accept`. `bits`: one for each sensor that is
        meant; 0: all."""
        rows = {number: row for number, row in enumerate(self._rows(kind)) if not bits or bits >> number & 1}
        reason, result = self._running() or self._forbidden(kind), Result.TEMPORARILY_REJECTED
        if reason is None and not rows:
            reason, result = "no such compass" if self._rows(kind) else self._nothing(kind), Result.DENIED
        if reason is not None:
            return self._refused(reason, result, now_s)
        self._parts = {number: self._part(kind, row, now_s) for number, row in rows.items()}
        self._save = save
        self._runs += 1
        self._set(kind, CalibrationPhase.RUNNING)
        how = "turn round twice, slowly" if kind is CalibrationKind.COMPASS else "keep the boat still"
        self._events.say(now_s, TextKind.ROUTINE, "calibration", f"{kind.value} calibration: {how}")
        return ACCEPTED

    def accept(self, now_s: float) -> Outcome:
        """Store a result that waits for it. Where none waits, nothing changes. What a calibration may not begin in may
        not see its result come into force: the heading would jump under the mode that steers by it."""
        if self.state is not None and self.state.phase is CalibrationPhase.FITTED:
            if (reason := self._forbidden(self.state.kind)) is not None:
                return self._refused(reason, Result.TEMPORARILY_REJECTED, now_s)
            self._store(self.state.kind, now_s)
        return ACCEPTED

    def cancel(self, now_s: float) -> Outcome:
        """End the calibration without a result. Where none runs, nothing changes."""
        if self.state is not None and self.state.phase in (CalibrationPhase.RUNNING, CalibrationPhase.FITTED):
            self._set(self.state.kind, CalibrationPhase.CANCELLED)
            text = f"{self.state.kind.value} calibration cancelled"
            self._events.say(now_s, TextKind.ROUTINE, "calibration", text)
        return ACCEPTED

    def _refused(self, reason: str, result: Result, now_s: float) -> Outcome:
        text = f"Calibration refused: {reason}"
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(result, text)

    def _rows(self, kind: CalibrationKind) -> Sequence[SensorConfig]:
        """The sensors to calibrate."""
        return self._magnetometers if kind is CalibrationKind.COMPASS else self._inertial

    def _running(self) -> str | None:
        state = self.state
        return (
            f"{state.kind.value.lower()} calibration runs"
            if state and state.phase is CalibrationPhase.RUNNING
            else None
        )

    def _forbidden(self, kind: CalibrationKind) -> str | None:
        """Why the boat may not be calibrated now. In a mode that steers by no heading it may turn by its own thrust."""
        helm = self._helm
        if not helm.armed:
            return None
        if kind is not CalibrationKind.COMPASS:
            return "disarm first"
        free = helm.mode.by_stick and Need.HEADING not in helm.mode.declaration.needs
        return None if free else "disarm, or choose Manual"

    def _nothing(self, kind: CalibrationKind) -> str:
        if kind is not CalibrationKind.COMPASS:
            return "no inertial sensor"
        return "no sensor has heading = ahrs" if self._inertial else "no magnetometer"

    def _part(self, kind: CalibrationKind, row: SensorConfig, now_s: float) -> Part:
        if kind is CalibrationKind.LEVEL:
            return StillMean(row.name, _LEVEL_S, _LEVEL_SWING_RADPS, now_s)
        if kind is CalibrationKind.GYRO:
            return StillMean(row.name, _GYRO_S, _GYRO_SWING_RADPS, now_s, _GYRO_TURN_RAD)
        nav, home = self._nav_of(), self._config.home
        place = (nav.lat_deg, nav.lon_deg) if nav.position_valid else (home.lat_deg, home.lon_deg)
        north, east, down = field_nt(*place, decimal_year(nav.time_unix_ns))
        dip_rad = math.atan2(down, math.hypot(north, east))
        return CompassCalibration(row, self._mounting, self._levers, normal_gravity_mps2(place[0]), dip_rad, now_s)

    # --- once a tick -----------------------------------------------------------------------------------------------

    def take(self, readings: Sequence[Reading], now_s: float) -> None:
        """The readings of a tick. None of it raises."""
        state = self.state
        if state is None or state.phase is not CalibrationPhase.RUNNING:
            return
        if (reason := self._forbidden(state.kind)) is not None:
            self._fail(state.kind, reason, now_s)
            return
        measured = [reading for reading in readings if plausible(reading, now_s)]
        for part in self._parts.values():
            part.update(measured, now_s)
        self._leave_silent_out(state.kind, now_s)
        failure = next((part.failure for part in self._parts.values() if part.failure is not None), None)
        if failure is not None:
            self._fail(state.kind, failure, now_s)
        elif not all(part.progress >= 1.0 for part in self._parts.values()):
            self._set(state.kind, CalibrationPhase.RUNNING)
        elif self._save:
            self._store(state.kind, now_s)
        else:
            self._set(state.kind, CalibrationPhase.FITTED)
            self._events.say(now_s, TextKind.ROUTINE, "calibration", f"{state.kind.value} fitted: accept or cancel it")

    def _leave_silent_out(self, kind: CalibrationKind, now_s: float) -> None:
        """Of several inertial sensors the silent ones keep their values, and the others go on."""
        silent = {number: part for number, part in self._parts.items() if isinstance(part, StillMean) and part.silent}
        if len(silent) == len(self._parts):
            return
        self._parts = {number: part for number, part in self._parts.items() if number not in silent}
        for part in silent.values():
            self._events.say(now_s, TextKind.ATTENTION, "calibration_silent", f"{kind.value} left out: {part.failure}")

    def _set(self, kind: CalibrationKind, phase: CalibrationPhase, text: str = "") -> None:
        progress = min(part.progress for part in self._parts.values())
        compasses = tuple(
            CompassState(number, part.row.name, part.progress, part.direction, part.failure, part.result)
            for number, part in self._parts.items()
            if isinstance(part, CompassCalibration)
        )
        self.state = CalibrationState(self._runs, kind, phase, progress, text, compasses)

    def _fail(self, kind: CalibrationKind, reason: str, now_s: float) -> None:
        self._set(kind, CalibrationPhase.FAILED, reason)
        text = f"{kind.value} not calibrated: {reason}"
        self._events.say(now_s, TextKind.REFUSAL, "calibration_failed", text)

    # --- the result ------------------------------------------------------------------------------------------------

    def _store(self, kind: CalibrationKind, now_s: float) -> None:
        try:
            values: dict[str, float] = {}
            for number, part in self._measured(kind).items():
                values |= self._values(kind, number, part)
        except ValueError as error:
            self._fail(kind, str(error), now_s)
            return
        if self._parameters.set_all(values) is not None:
            self._fail(kind, "a value is out of range", now_s)
            return
        self._set(kind, CalibrationPhase.DONE)
        text = f"{kind.value} calibrated{self._summary(kind, values)}"
        self._events.say(now_s, TextKind.ROUTINE, "calibration", text)
        for warning in self._askew(kind):
            self._events.say(now_s, TextKind.ATTENTION, "calibration_askew", warning)

    def _measured(self, kind: CalibrationKind) -> Mapping[int, Part]:
        """The parts that give the parameters: all inertial sensors share the level of the first that is heard."""
        return self._parts if kind is not CalibrationKind.LEVEL else dict([next(iter(self._parts.items()))])

    def _askew(self, kind: CalibrationKind) -> list[str]:
        """One line for each inertial sensor that lies otherwise than the one whose level all of them share."""
        still = [part for part in self._parts.values() if isinstance(part, StillMean)]
        if kind is not CalibrationKind.LEVEL:
            return []
        tilts = ((part.name[:SHORT_NAME], between_rad(still[0].force, part.force)) for part in still[1:])
        return [f"{name} lies {math.degrees(rad):.1f} deg off that level" for name, rad in tilts if rad > _ASKEW_RAD]

    def _values(self, kind: CalibrationKind, number: int, part: Part) -> dict[str, float]:
        """The parameters of one sensor. Raises ValueError for a result that cannot be right."""
        if isinstance(part, CompassCalibration):
            assert part.result is not None
            return compass_values(number, part.result)
        if kind is CalibrationKind.LEVEL:
            angles = level_of(self._mounting.unlevelled(part.force))
            return {name: math.degrees(angle) for name, angle in zip(_LEVEL, angles, strict=True)}
        return {f"CAL_GYRO{number}_{axis}OFF": bias for axis, bias in zip("XYZ", part.rates, strict=True)}

    def _summary(self, kind: CalibrationKind, values: Mapping[str, float]) -> str:
        part = next(iter(self._parts.values()))
        if isinstance(part, CompassCalibration) and part.result is not None:
            return f": {math.degrees(left_rad(part.result)):.1f} deg of deviation left"
        if kind is CalibrationKind.LEVEL:
            roll, pitch = (round(values[name], 1) + 0.0 for name in _LEVEL)  # no -0.0
            return f": roll {roll:.1f}, pitch {pitch:.1f} deg"
        return ""


def compass_values(number: int, found: FieldFit) -> dict[str, float]:
    """The parameters that keep a magnetometer's calibration. Raises ValueError for one that turns an axis round."""
    (a, b, c), (_, d, e), (_, _, f) = found.matrix.tolist()
    if min(a, d, f) <= 0.0:
        raise ValueError("the field does not fit")
    prefix = f"CAL_MAG{number}_"
    offset = zip("XYZ", found.offset.tolist(), strict=True)
    return {
        **{f"{prefix}{axis}OFF": value for axis, value in offset},
        **{f"{prefix}{axis}SCALE": value for axis, value in zip("XYZ", (a, d, f), strict=True)},
        **{f"{prefix}{axis}ODIAG": value for axis, value in zip("XYZ", (b, c, e), strict=True)},
        f"{prefix}WANDER": math.degrees(wander_rad(found)),
    }
