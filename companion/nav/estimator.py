"""Readings → `NavState`: sorts readings in time, chooses sources, and passes them to the solution in use."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from operator import attrgetter

from companion.config.vessel import NavigatedBoat, VesselConfig
from companion.core.actuation import Wrench
from companion.core.decision import Severity
from companion.core.estimate import NavState
from companion.core.events import Announce
from companion.core.frames import ned_to_body
from companion.core.geodesy import LocalFrame, distance_and_bearing
from companion.core.readings import (
    FixType,
    GnssFix,
    GroundVelocity,
    Heading,
    Imu,
    MagneticField,
    Reading,
    TimeOfDay,
    Wind,
)
from companion.nav.ahrs_heading import AttitudeFilter, ahrs_headings
from companion.nav.current import CurrentObserver, GroundMotion
from companion.nav.error_state import FilterNoise
from companion.nav.headings import HeadingSources, TrueHeading
from companion.nav.inertial import InertialSolution
from companion.nav.lever_arms import ZERO, Vector, normal_gravity_mps2
from companion.nav.no_imu import PoseSolution
from companion.nav.outliers import FirstPosition, ThesisOutlierRule, Verdict
from companion.nav.solution import Motion
from companion.nav.sources import AbsoluteTime, GradeWatch, SourceSelector, TrueWind, plausible
from companion.nav.velocity_aid import VelocityAid
from companion.params.store import Parameters

_FAR_FROM_HOME_M = 50_000.0
_UNKNOWN_ACCURACY_M = 3.0
_UNKNOWN_ACCURACY_MPS = 0.1
_CORRELATED_FACTOR = 3.0  # errors of fixes without carrier phase are correlated: each counts as that much noisier
_CORRELATED_SHARE = 0.7  # the share of their sigma that averaging does not remove
_CARRIER_WANDER_M = 0.008  # slow error of fixes with carrier phase
_VELOCITY_SHARES = {
    FixType.DGPS: 0.5,
    FixType.RTK_FLOAT: 0.3,
    FixType.RTK_FIXED: 0.3,
}  # of the velocity error of a plain fix
_HEADING_USABLE_RAD = math.radians(20.0)
_HEADING_COAST_RAD = math.radians(5.0)  # largest sigma at which the gyro alone may carry the heading
_ALTITUDE_SHARE = 0.05
_IMU_TIMEOUT_S = 0.5
_WIND_TIMEOUT_S = 2.0
_CURRENT_AGE_S = 1.0  # age of the position up to which the velocity counts as measured
_AID_AGE_S = 0.2  # age of position and velocity above which neither counts as measured for the aid
_THESIS_RULE = 1
_NAVIGATION = (GnssFix, GroundVelocity, Heading, Imu, MagneticField)


class Estimator:
    """Readings of a tick, in any order → motion of the boat's origin at `now_s`, in NED around `frame`.

    The filter runs behind the present by the longest configured latency, so that delayed measurements meet the state of
    their own time. The later inertial samples carry its result to the present. Without inertial sensors, while they are
    silent, or before there is a heading, the low-pass filter of `no_imu` takes over. A boat without a hull model (a
    lead boat) has no estimate of the current. Remembers the filters, the sources in use, and when a reading of each
    kind was last accepted.
    """

    def __init__(
        self,
        config: NavigatedBoat,
        parameters: Parameters,
        say: Announce = lambda *_: None,
        baseline_ahrs: Callable[[float], AttitudeFilter] | None = None,
    ) -> None:
        """`say`: announces changes of source and position resets. `baseline_ahrs`: makes the thesis's attitude filter,
        which AHRS_LAW 1 chooses, from the gravity in m/s²."""
        self._parameters = parameters
        self._home = config.home
        self.frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
        self._levers: dict[str, Vector] = {row.name: (row.x_m, row.y_m, row.z_m) for row in config.sensors}
        timeouts_s = {row.name: row.timeout_s for row in config.sensors}
        self._sensors = {row.name: row for row in config.sensors}
        self._say = say
        self._positions, self._headings = SourceSelector(timeouts_s), HeadingSources(config, say)
        self._ahrs = ahrs_headings(config, parameters, baseline_ahrs)
        self._velocities, self._imus, self._winds = (
            SourceSelector(timeouts_s),
            SourceSelector(timeouts_s),
            SourceSelector(timeouts_s),
        )
        self._timeouts_s = timeouts_s
        self._lag_s = max(row.latency_s for row in config.sensors)
        self._last_place = ZERO
        self._pending: list[Reading] = []
        self._inertial: InertialSolution | None = None
        self._pose = PoseSolution()
        self._first = FirstPosition()
        self._thesis = ThesisOutlierRule()
        self._current = CurrentObserver(config) if isinstance(config, VesselConfig) else None
        self._aid = None if self._current is None else VelocityAid(self._current)
        self._grade = GradeWatch()
        self._time = AbsoluteTime()
        self._wind = TrueWind(_WIND_TIMEOUT_S)
        self._fix: GnssFix | None = None
        self._altitude_m = config.home.altitude_m
        self._altitude_known = False
        self._slow_sigma_m = self._slow_sigma_rad = 0.0
        self._position_s = self._velocity_s = self._heading_s = self._imu_s = 0.0
        self._position_source: str | None = None

    @property
    def inertial(self) -> InertialSolution | None:
        """The solution that the inertial sensor carries; None before its first reading."""
        return self._inertial

    def update(self, readings: Sequence[Reading], now_s: float, thrust: Wrench | None = None) -> NavState:
        """Take the readings since the last call and return the state at `now_s`, which must not go back. `thrust`: the
        wrench that the thrusters gave since then; None if unknown (while disarmed, mooring lines may hold the boat, or
        others may drive its thrusters)."""
        readings = [reading for reading in readings if plausible(reading, now_s)]
        self._pending.extend(reading for reading in readings if isinstance(reading, _NAVIGATION))
        self._pending.sort(key=attrgetter("t_s"))
        horizon_s = now_s - self._lag_s
        due = 0
        for reading in self._pending:
            if reading.t_s > horizon_s:
                break
            due += 1
            self._take(reading)
        del self._pending[:due]
        self._check_imu(horizon_s)
        motion = self._motion(now_s)
        self._last_place = motion.position
        self._side_readings(readings, motion)
        self._update_current(motion, thrust, now_s)
        return self._state(motion, now_s)

    def _take(self, reading: Reading) -> None:
        kind = type(reading)
        if kind is Imu:
            self._take_imu(reading)  # type: ignore[arg-type]
            self._turn_ahrs(reading)  # type: ignore[arg-type]
        elif kind is GnssFix:
            self._take_fix(reading)  # type: ignore[arg-type]
        elif kind is Heading:
            self._take_heading(reading)  # type: ignore[arg-type]
        elif kind is MagneticField:
            self._take_field(reading)  # type: ignore[arg-type]
        else:
            self._take_velocity(reading)  # type: ignore[arg-type]

    def _solution(self) -> InertialSolution | PoseSolution:
        inertial = self._inertial
        return inertial if inertial is not None and inertial.running else self._pose

    def _take_imu(self, imu: Imu) -> None:
        if not self._imus.offer(imu.source, imu.t_s):
            return
        if self._inertial is None:
            lever, noise = self._levers.get(imu.source, ZERO), self._imu_noise(imu.source)
            self._inertial = InertialSolution(normal_gravity_mps2(self.frame.lat_deg), lever, noise)
        inertial = self._inertial
        if inertial.running and imu.t_s - inertial.t_s > _IMU_TIMEOUT_S:
            self._leave_inertial(inertial.t_s)
        inertial.sample(imu)
        self._imu_s = max(self._imu_s, imu.t_s)
        if not inertial.running and self._pose.started and self._pose.oriented:
            tilt = inertial.levelling.tilt()
            if tilt is not None:
                inertial.start(self._pose.motion(imu.t_s), tilt)

    def _turn_ahrs(self, imu: Imu) -> None:
        ahrs = self._ahrs.get(imu.source)
        heading = ahrs.imu(imu) if ahrs is not None else None
        if heading is not None:
            self._take_heading(heading)

    def _take_field(self, field: MagneticField) -> None:
        ahrs = self._ahrs.get(field.source)
        declination = (
            self._headings.declination(*self._place(), self._time.at_ns(field.t_s)) if ahrs is not None else None
        )
        if ahrs is not None and declination is not None:
            ahrs.field(field, declination)

    def _imu_noise(self, source: str) -> FilterNoise:
        row = self._sensors.get(source)
        if row is None:
            return FilterNoise()
        return FilterNoise(row.accelerometer_noise_mps2_rthz, row.gyro_noise_radps_rthz)

    def _check_imu(self, horizon_s: float) -> None:
        """Stop the inertial filter when its samples have stopped."""
        inertial = self._inertial
        if inertial is not None and inertial.running and horizon_s - inertial.t_s > _IMU_TIMEOUT_S:
            self._leave_inertial(inertial.t_s)

    def _leave_inertial(self, t_s: float) -> None:
        assert self._inertial is not None
        self._pose.continue_from(self._inertial.motion(t_s))
        self._inertial.stop()

    def _take_fix(self, fix: GnssFix) -> None:
        good = fix.fix >= FixType.FIX_2D and math.isfinite(fix.lat_deg) and math.isfinite(fix.lon_deg)
        used = self._positions.offer(fix.source, fix.t_s, good, int(fix.fix >= FixType.RTK_FLOAT))
        if used or self._fix is None or self._fix.source == fix.source:
            self._fix = fix
        if not used:
            return
        self._announce(fix)
        lever = self._levers.get(fix.source, ZERO)
        row = self._sensors.get(fix.source)
        sigma_m = max(fix.position_accuracy_m or _UNKNOWN_ACCURACY_M, row.accuracy_floor_m if row is not None else 0.0)
        north, east = self.frame.to_ned(fix.lat_deg, fix.lon_deg)
        rule = self._thesis.update(north, east) if self._parameters["NAV_WILD_RULE"] == _THESIS_RULE else None
        if not self._pose.started:
            self._first_fix(fix, north, east, lever, sigma_m)
            return
        solution = self._solution()
        added_m2 = self._grade.update(fix.t_s, fix.fix, sigma_m)
        if added_m2 > 0.0:
            solution.add_position_variance(added_m2)
        carrier_phase = fix.fix >= FixType.RTK_FLOAT
        fused_sigma_m = sigma_m if carrier_phase else _CORRELATED_FACTOR * sigma_m
        verdict = solution.position(fix.t_s, north, east, lever, fused_sigma_m, rule)
        if verdict is Verdict.RESET and self._inertial is not None:
            jump_m = math.hypot(north - self._last_place[0], east - self._last_place[1])
            text = f"Position reset by {jump_m:.0f} m ({fix.source})"
            self._say(fix.t_s, Severity.CRITICAL, "position_jumped", text)
        if verdict is not Verdict.REJECT:
            self._position_s = max(self._position_s, fix.t_s)
            wander_m = row.position_wander_m if row is not None else None
            if wander_m is None:
                wander_m = _CARRIER_WANDER_M if carrier_phase else _CORRELATED_SHARE * sigma_m
            self._slow_sigma_m = wander_m
            self._take_altitude(fix, lever)

    def _announce(self, fix: GnssFix) -> None:
        """Announce when another receiver takes over."""
        before, self._position_source = self._position_source, fix.source
        if before is not None and before != fix.source:
            text = f"Position source: {fix.source} (was {before})"
            self._say(fix.t_s, Severity.WARNING, "position_source", text)

    def _first_fix(self, fix: GnssFix, north: float, east: float, lever: Vector, sigma_m: float) -> None:
        approved = self._first.update(north, east, sigma_m, fix.t_s)
        if approved is None:
            return
        if distance_and_bearing(self._home.lat_deg, self._home.lon_deg, fix.lat_deg, fix.lon_deg)[0] > _FAR_FROM_HOME_M:
            self.frame = LocalFrame(fix.lat_deg, fix.lon_deg)
            approved = (0.0, 0.0)
            if self._inertial is not None:
                self._inertial.filter.gravity_mps2 = normal_gravity_mps2(fix.lat_deg)
        self._pose.begin(fix.t_s, *approved, lever, sigma_m)
        self._position_s = fix.t_s
        self._take_altitude(fix, lever)

    def _take_altitude(self, fix: GnssFix, lever: Vector) -> None:
        if fix.altitude_m is not None:
            share = _ALTITUDE_SHARE if self._altitude_known else 1.0
            self._altitude_m += share * (fix.altitude_m + lever[2] - self._altitude_m)
            self._altitude_known = True

    def _take_velocity(self, velocity: GroundVelocity) -> None:
        if not self._velocities.offer(velocity.source, velocity.t_s):
            return
        lever = self._levers.get(velocity.source, ZERO)
        course = self._headings.course(velocity)
        if course is not None:
            self._fuse_heading(velocity.t_s, course)
        row = self._sensors.get(velocity.source)
        sigma_mps = row.velocity_accuracy_mps if row is not None else _UNKNOWN_ACCURACY_MPS
        if self._fix is not None:
            sigma_mps *= _VELOCITY_SHARES.get(self._fix.fix, 1.0)
        for ahrs in self._ahrs.values():
            ahrs.velocity(velocity.t_s, velocity.north_mps, velocity.east_mps, sigma_mps, lever)
        if self._pose.started:
            verdict = self._solution().velocity(velocity.t_s, velocity.north_mps, velocity.east_mps, lever, sigma_mps)
            if verdict is not Verdict.REJECT:
                self._velocity_s = max(self._velocity_s, velocity.t_s)

    def _take_heading(self, reading: Heading) -> None:
        heading = self._headings.offer(reading, *self._place(), self._time.at_ns(reading.t_s))
        if heading is not None:
            self._fuse_heading(reading.t_s, heading)

    def _place(self) -> tuple[float, float]:
        """(lat_deg, lon_deg) for the declination."""
        fix = self._fix
        if fix is not None and fix.fix >= FixType.FIX_2D:
            return fix.lat_deg, fix.lon_deg
        return self._home.lat_deg, self._home.lon_deg

    def _fuse_heading(self, t_s: float, heading: TrueHeading) -> None:
        solution = self._solution()
        if heading.added_sigma_rad > 0.0:
            solution.add_heading_variance(heading.added_sigma_rad**2)
        if solution.heading(t_s, heading.yaw_rad, heading.sigma_rad) is not Verdict.REJECT:
            self._heading_s = max(self._heading_s, t_s)
            self._slow_sigma_rad = heading.slow_sigma_rad

    def _update_current(self, motion: Motion, thrust: Wrench | None, now_s: float) -> None:
        if self._current is None or self._aid is None:
            return
        passage: GroundMotion | None = None
        measured = now_s - self._position_s <= _CURRENT_AGE_S
        if self._pose.started and self._pose.oriented:
            speed, from_rad = self._wind.at(now_s)
            air = (
                (None, None)
                if speed is None or from_rad is None
                else (-speed * math.cos(from_rad), -speed * math.sin(from_rad))
            )
            passage = GroundMotion(motion.velocity[0], motion.velocity[1], motion.attitude[2], motion.rates[2], *air)
        self._current.update(now_s, thrust, passage, measured)
        solution = self._solution()
        if isinstance(solution, InertialSolution):
            aid = self._aid.update(now_s, now_s - max(self._position_s, self._velocity_s) <= _AID_AGE_S, motion)
            if aid is not None:
                solution.aid(*aid)

    def _heading_ok(self, sigma_rad: float, heading_age_s: float, position_age_s: float) -> bool:
        """Whether control may use the heading: measured lately, or carried by the gyro while its sigma is small and
        positions arrive."""
        tolerated_s = self._parameters["FS_POS_T"]
        if not self._pose.oriented or sigma_rad > _HEADING_USABLE_RAD:
            return False
        coasting = (
            isinstance(self._solution(), InertialSolution)
            and sigma_rad <= _HEADING_COAST_RAD
            and position_age_s <= tolerated_s
        )
        return heading_age_s <= tolerated_s or coasting

    def _side_readings(self, readings: Sequence[Reading], motion: Motion) -> None:
        """Take the readings that do not affect the motion: time of day and wind."""
        for reading in readings:
            if type(reading) is TimeOfDay:
                self._time.update(reading.t_s, reading.time_unix_ns)
            elif type(reading) is Wind and self._pose.oriented and self._winds.offer(reading.source, reading.t_s):
                yaw, (north, east, _) = motion.attitude[2], motion.velocity
                self._wind.update(reading.t_s, reading.speed_mps, reading.from_rad, yaw, north, east)

    def _motion(self, now_s: float) -> Motion:
        solution = self._solution()
        if isinstance(solution, InertialSolution):
            later = [reading for reading in self._pending if type(reading) is Imu and reading.t_s <= now_s]
            return solution.motion(now_s, later)
        motion, inertial = solution.motion(now_s), self._inertial
        if inertial is None or now_s - self._lag_s - inertial.t_s > _IMU_TIMEOUT_S:
            return motion
        roll, pitch = inertial.levelling.tilt() or (0.0, 0.0)
        return replace(motion, attitude=(roll, pitch, motion.attitude[2]), rates=inertial.rates)

    def _state(self, motion: Motion, now_s: float) -> NavState:
        (north, east, _), (vn, ve, _), (roll, pitch, yaw) = motion.position, motion.velocity, motion.attitude
        lat, lon = self.frame.to_geodetic(north, east)
        surge, sway = ned_to_body(vn, ve, yaw)
        position_age_s = now_s - self._position_s
        heading_age_s = now_s - self._heading_s
        tolerated_s = self._parameters["FS_POS_T"]
        position_sigma_m = math.hypot(motion.position_sigma_m, self._slow_sigma_m)
        yaw_sigma_rad = min(math.hypot(motion.yaw_sigma_rad, self._slow_sigma_rad), math.pi)
        accurate = position_sigma_m <= self._parameters["COM_POS_FS_EPH"]
        fix = self._fix
        heard = fix is not None and now_s - fix.t_s <= self._timeouts_s.get(fix.source, tolerated_s)
        wind_speed, wind_from = self._wind.at(now_s)
        current = (None if self._current is None else self._current.estimate(now_s)) or (None, None, None)
        return NavState(
            t_s=now_s,
            position_valid=self._pose.started and position_age_s <= tolerated_s and accurate,
            heading_valid=self._heading_ok(yaw_sigma_rad, heading_age_s, position_age_s),
            lat_deg=lat,
            lon_deg=lon,
            altitude_m=self._altitude_m,
            north_m=north,
            east_m=east,
            roll_rad=roll,
            pitch_rad=pitch,
            yaw_rad=yaw,
            surge_mps=surge,
            sway_mps=sway,
            north_mps=vn,
            east_mps=ve,
            roll_rate_radps=motion.rates[0],
            pitch_rate_radps=motion.rates[1],
            yaw_rate_radps=motion.rates[2],
            position_accuracy_m=position_sigma_m,
            velocity_accuracy_mps=motion.velocity_sigma_mps,
            heading_accuracy_rad=yaw_sigma_rad,
            position_age_s=position_age_s,
            heading_age_s=heading_age_s,
            imu_age_s=now_s - self._imu_s,
            fix=fix.fix if heard and fix is not None else FixType.NONE,
            satellites=fix.satellites if heard and fix is not None else None,
            hdop=fix.hdop if heard and fix is not None else None,
            time_unix_ns=self._time.at_ns(now_s),
            wind_speed_mps=wind_speed,
            wind_from_rad=wind_from,
            current_north_mps=current[0],
            current_east_mps=current[1],
            current_accuracy_mps=current[2],
        )
