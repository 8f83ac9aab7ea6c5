"""Readings → `NavState`: sorts readings in time, chooses sources, and passes them to the solution in use."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from companion.config.vessel import NavigatedBoat
from companion.core.actuation import Wrench
from companion.core.decision import TextKind
from companion.core.estimate import NavState, WaveMotion, air_of
from companion.core.events import Announce, unheard
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
)
from companion.nav.accuracies import SensorAccuracies
from companion.nav.ahrs_heading import AttitudeFilter, ahrs_headings
from companion.nav.altitude import Altitude
from companion.nav.antenna_pair import antenna_pairs
from companion.nav.blending import Offset, ReceiverBlend
from companion.nav.corrections import corrections_of
from companion.nav.error_state import ErrorStateFilter
from companion.nav.heading_search import HeadingSearch, is_lost
from companion.nav.headings import HeadingSources, TrueHeading
from companion.nav.inertial import InertialSolution, without_force
from companion.nav.inertial_source import InertialSource
from companion.nav.integrity.evidence import INERTIAL, LieFound, Sense
from companion.nav.lever_arms import ZERO, Vector, euler_of, normal_gravity_mps2
from companion.nav.measured_off import Wander
from companion.nav.model_aid import ModelAid
from companion.nav.mounting import Mounting
from companion.nav.no_imu import PoseSolution
from companion.nav.outliers import FirstPosition, ThesisOutlierRule, Verdict
from companion.nav.reading_queue import ReadingQueue
from companion.nav.receiver_latency import ReceiverLatency
from companion.nav.side_readings import SideReadings
from companion.nav.solution import Motion, Place
from companion.nav.sources import GradeWatch, SourceSelector, plausible
from companion.nav.validity import Validity
from companion.nav.witness import Witness
from companion.params.store import Parameters

_FAR_FROM_HOME_M = 50_000.0
_UNCONFIRMED_S = 0.5  # shorter than the gates take to follow the receivers to where the estimate has gone
_IMU_TIMEOUT_S = 0.5
_LIE_M = 1.5  # off by more after such a lie, the position begins anew
_LIE_SIGMA = 0.5  # m, m/s: of the motion that a lying inertial sensor leaves
_LIE_SIGMA_RAD = math.radians(15.0)  # of a heading that has followed a lie
_BY_MOTION_FACTOR = 2.0  # on the noise of positions and velocities that alone tell the heading
_THESIS_RULE = 1


class Estimator:
    """Readings of a tick, in any order → motion of the boat's origin at `now_s`, in NED around `frame`.

    The filter runs behind the present (`ReadingQueue`). The later inertial samples carry its result to the present.
    Without inertial sensors, while they are silent, or before there is a heading, the low-pass filter of `no_imu` takes
    over. A boat without a hull model (a lead boat) has no estimate of the current. While the boat is armed, the
    integrity monitor says which sources are not used. Remembers the filters, the sources in use, and when a reading of
    each kind was last accepted.
    """

    def __init__(
        self,
        config: NavigatedBoat,
        parameters: Parameters,
        say: Announce = unheard,
        baseline_ahrs: Callable[[float], AttitudeFilter] | None = None,
    ) -> None:
        """`say`: announces changes of source and position resets. `baseline_ahrs`: makes the thesis's attitude filter,
        which AHRS_LAW 1 chooses, from the gravity in m/s²."""
        self._parameters = parameters
        self._home = config.home
        self.frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
        self._levers: dict[str, Vector] = {row.name: (row.x_m, row.y_m, row.z_m) for row in config.sensors}
        timeouts_s = {row.name: row.timeout_s for row in config.sensors}
        self._accuracies = SensorAccuracies(config.sensors)
        self._say = say
        self._corrections = corrections_of(config.sensors, parameters)
        self._positions, self._headings = SourceSelector(timeouts_s), HeadingSources(config, say, self._corrections)
        self._search = HeadingSearch()
        self._ahrs = ahrs_headings(config, parameters, self._corrections, baseline_ahrs)
        self._mounting = Mounting(config, parameters)
        self._velocities = SourceSelector(timeouts_s)
        self._timeouts_s = timeouts_s
        self._receivers = ReceiverLatency()
        self._latencies_s = {row.name: row.latency_s for row in config.sensors}
        self._queue = ReadingQueue(self._latencies_s, self._receivers.late_s)
        self._witness = Witness(parameters, say)
        self._imus = InertialSource(config.sensors, self._corrections, self._mounting, self._witness)
        self._jumps_followed = 0
        self._validity = Validity(parameters)
        self._anew: set[Sense] = set()  # of what the next measurement counts, after an inertial sensor has lied
        self._inertial: InertialSolution | None = None
        self._pose = PoseSolution()
        self._first = FirstPosition()
        self._thesis = ThesisOutlierRule()
        self._model = ModelAid(config, parameters)
        self._grade = GradeWatch()
        self._blend = ReceiverBlend()
        self._pairs = antenna_pairs(config.sensors)
        self._fix_types: dict[str, FixType] = {}  # of each receiver
        self._wander_of: str | None = None  # the receiver whose slow error the inertial filter holds
        self._side = SideReadings(timeouts_s, self._witness)
        self._fix: GnssFix | None = None
        self._here: tuple[float, float] | None = None  # the estimate's latitude and longitude at the last tick
        self._altitude = Altitude(config.home.altitude_m)
        self._position_source: str | None = None

    @property
    def inertial(self) -> InertialSolution | None:
        """The solution that the inertial sensor carries; None before its first reading."""
        return self._inertial

    def update(self, readings: Sequence[Reading], now_s: float, thrust: Wrench | None = None) -> NavState:
        """Take the readings since the last call and return the state at `now_s`, which must not go back. `thrust`: the
        wrench that the thrusters gave since then; None if unknown (while disarmed, mooring lines may hold the boat, or
        others may drive its thrusters)."""
        readings = [
            self._imus.corrected(reading) if type(reading) is Imu else reading
            for reading in readings
            if plausible(reading, now_s)
        ]
        self._queue.add(readings)
        for reading in self._queue.due(now_s):
            self._take(reading)
        self._check_imu(now_s - self._queue.lag_s)
        self._watch_latency()
        motion = self._motion(now_s)
        if thrust is not None and self._is_lost(motion, now_s):
            motion = self._begin_anew(motion, now_s)
        self._side.take(readings, motion, self._pose.oriented)
        self._aid_by_model(motion, thrust, now_s)
        driven = thrust is not None and self._pose.started and not self._receivers.unsettled(self._positions.current)
        used = self._imus.current
        self._react(self._witness.conclude(driven, motion, self._inertial, self._model.current, now_s, used))
        if self._witness.monitor.untrusted:
            self._validity.lied_s = now_s
        return self._state(motion, self._model.waves(now_s, thrust, motion), now_s)

    def _is_lost(self, motion: Motion, now_s: float) -> bool:
        """Whether the boat cannot be as fast as the estimate, and no receiver says that it is."""
        return self._model.is_impossible(motion) and self._validity.unmeasured_s(now_s) > _UNCONFIRMED_S

    def _begin_anew(self, motion: Motion, now_s: float) -> Motion:
        """Forget an estimate that no boat can sail: it has lost itself, and speaks against receivers that are right.
        Returns the motion without it."""
        speed_mps = math.hypot(motion.velocity[0], motion.velocity[1])
        text = f"Estimate begins anew: {speed_mps:.0f} m/s is impossible"
        self._say(now_s, TextKind.ALARM, "estimate_begun_anew", text)
        if self._inertial is not None:
            self._inertial.stop()
            self._inertial.forget_biases()
        self._pose, self._first = PoseSolution(), FirstPosition()
        self._model.begin_anew()
        self._witness.monitor.begin_anew()
        return self._motion(now_s)

    def answer(self, accept: bool, now_s: float) -> str | None:
        """The operator's answer about a sensor that seems to lie: believe it, or not. Returns why not, or None."""
        return self._witness.monitor.answer(accept, now_s)

    def _react(self, findings: Sequence[LieFound]) -> None:
        """Undo what the filter has taken from sources that are found to lie."""
        inertial = self._inertial
        if not findings or inertial is None or not inertial.running:
            return
        carrying = {(sense, self._imus.current) for sense in INERTIAL}
        if any(finding.channel in carrying for finding in findings) and not self._imus.voted(inertial.t_s):
            self._leave_inertial(inertial.t_s, _LIE_SIGMA)
            self._anew = {Sense.POSITION, Sense.VELOCITY, Sense.HEADING}
            return
        used = {
            (Sense.POSITION, self._positions.current),
            (Sense.VELOCITY, self._velocities.current),
            (Sense.HEADING, self._headings.used),
        }
        if self._blends:
            used |= {(sense, name) for name in self._fix_types for sense in (Sense.POSITION, Sense.VELOCITY)}
        taken = [finding for finding in findings if finding.channel in used and not finding.jump]
        if taken:
            self._blend.clear()
        if taken and inertial.feels:
            inertial.go_back(min(finding.since_s for finding in taken))
        if any(finding.widens for finding in taken):
            inertial.add_heading_variance(_LIE_SIGMA_RAD**2)

    def _begins_anew(self, sense: Sense, rule: Verdict | None) -> Verdict | None:
        """RESET for the first measurement that nothing speaks against, after an inertial sensor has lied: what it has
        added up to counts no longer."""
        if not self._anew or sense not in self._anew or rule is not None:
            return rule
        self._anew.discard(sense)
        return Verdict.RESET

    def _take(self, reading: Reading) -> None:
        kind = type(reading)
        if kind is Imu:
            felt = self._felt(reading)  # type: ignore[arg-type]
            self._take_imu(reading, felt)  # type: ignore[arg-type]
            self._turn_ahrs(felt)
        elif kind is GnssFix:
            self._take_fix(reading)  # type: ignore[arg-type]
        elif kind is Heading:
            self._take_heading(reading)  # type: ignore[arg-type]
        elif kind is MagneticField:
            self._take_field(reading)  # type: ignore[arg-type]
        else:
            self._take_velocity(reading)  # type: ignore[arg-type]

    @property
    def sources(self) -> Mapping[str, str | None]:
        """The sensor in use for each kind of reading, None before the first."""
        return {
            "position": self._positions.current,
            "velocity": self._velocities.current,
            "heading": self._headings.used,
            "inertial": self._imus.current,
            "wind": self._side.wind_source,
        }

    def _watch_latency(self) -> None:
        """What measurements say of how late the receiver in use is."""
        inertial, source = self._feeling, self._positions.current
        if inertial is None or source is None:
            return
        found = self._receivers.update(inertial, source)
        inertial.late_sigma_s = self._receivers.unsure_s(source)
        if found is not None:
            text = found.text(self._latencies_s.get(source, 0.0))
            self._say(inertial.t_s, TextKind.ATTENTION, "receiver_late", text)

    def _solution(self) -> InertialSolution | PoseSolution:
        inertial = self._inertial
        return inertial if inertial is not None and inertial.running else self._pose

    @property
    def _feeling(self) -> InertialSolution | None:
        """The inertial solution while it runs, by forces too; None else."""
        inertial = self._inertial
        return inertial if inertial is not None and inertial.running and inertial.feels else None

    def _felt(self, measured: Imu) -> Imu:
        """The sample as it is used: without its forces, where those lie."""
        felt, feels = self._imus.felt(measured, self.frame.lat_deg)
        if feels is not None:
            self._feel(measured.source, feels)
        return felt

    def _feel(self, source: str, feels: bool) -> None:
        """Begin anew, with or without the forces of a sensor."""
        if self._inertial is not None and source == self._imus.current:
            if self._inertial.running:
                self._leave_inertial(self._inertial.t_s, _LIE_SIGMA)
            self._inertial.feel(feels)

    def _take_imu(self, measured: Imu, felt: Imu) -> None:
        """`felt`: the sample as it is used. A sensor whose forces lie gives way to another."""
        before = self._imus.current
        imu = self._imus.chosen(measured, felt)
        if imu is None:
            return
        feels = felt is measured
        if before not in (None, imu.source) and self._inertial is not None and self._inertial.feels is not feels:
            self._feel(imu.source, feels)
        inertial = self._inertial
        if inertial is None or before != imu.source:
            inertial = self._carried_by(imu, before)
            self._search.heard(imu.t_s)
        if inertial.running and (imu.t_s - inertial.t_s > _IMU_TIMEOUT_S or self._recalibrated(imu.source)):
            self._leave_inertial(inertial.t_s)
        inertial.sample(imu)
        if self._search.runs:
            self._search.sample(imu)
        self._validity.imu(imu.t_s)
        if not inertial.running and self._pose.started and self._pose.oriented:
            motion = self._pose.motion(imu.t_s)
            surge_mps, _ = ned_to_body(motion.velocity[0], motion.velocity[1], motion.attitude[2])
            tilt = inertial.levelling.tilt(surge_mps)
            if tilt is not None and not is_lost(motion.yaw_sigma_rad):
                inertial.start(motion, tilt, inertial.levelling.sigma_rad(surge_mps))

    def _carried_by(self, imu: Imu, before: str | None) -> InertialSolution:
        """The solution, from now on with the samples of that sensor."""
        lever, noise = self._levers.get(imu.source, ZERO), self._accuracies.imu(imu.source)
        if self._inertial is None:
            self._inertial = InertialSolution(normal_gravity_mps2(self.frame.lat_deg), lever, noise)
        else:
            self._inertial.carry_over(lever, noise)
            self._say(imu.t_s, TextKind.ATTENTION, "inertial_source", f"Inertial source: {imu.source} (was {before})")
        return self._inertial

    def _recalibrated(self, source: str) -> bool:
        """Whether a sensor has been calibrated since its last sample; what the filter knows of its biases is void
        then."""
        anew = self._imus.recalibrated(source)
        if anew and self._inertial is not None:
            self._inertial.forget_biases()
        return anew

    def _turn_ahrs(self, imu: Imu) -> None:
        ahrs = self._ahrs.get(imu.source) if self._witness.trusts(Sense.IMU, imu.source) else None
        if ahrs is None:
            return
        ahrs.trust(not self._imus.lies(imu.source), self._witness.trusts(Sense.GYRO, imu.source))
        heading = ahrs.imu(imu)
        if heading is not None:
            self._take_heading(heading, ahrs.by_field_rad)

    def _take_field(self, field: MagneticField) -> None:
        ahrs = self._ahrs.get(field.source) if self._witness.field(field) else None
        declination = (
            self._headings.declination(*self._place(), self._side.time_ns(field.t_s)) if ahrs is not None else None
        )
        if ahrs is not None and declination is not None:
            ahrs.field(field, declination, self._mounting.compass(field.source))

    def _check_imu(self, horizon_s: float) -> None:
        """Stop the inertial filter when its samples have stopped."""
        inertial = self._inertial
        if inertial is not None and inertial.running and horizon_s - inertial.t_s > _IMU_TIMEOUT_S:
            self._leave_inertial(inertial.t_s)

    def _leave_inertial(self, t_s: float, least_sigma: float = 0.0) -> None:
        """Go on without inertial sensors. `least_sigma`: of position and velocity, in m and m/s."""
        assert self._inertial is not None
        motion = self._inertial.motion(t_s)
        sigma_m, sigma_mps = max(motion.position_sigma_m, least_sigma), max(motion.velocity_sigma_mps, least_sigma)
        self._pose.continue_from(replace(motion, position_sigma_m=sigma_m, velocity_sigma_mps=sigma_mps))
        self._inertial.stop()

    def _take_fix(self, fix: GnssFix) -> None:
        good = fix.fix >= FixType.FIX_2D and math.isfinite(fix.lat_deg) and math.isfinite(fix.lon_deg)
        lever = self._levers.get(fix.source, ZERO)
        sigma_m = self._accuracies.position_m(fix)
        north, east = self.frame.to_ned(fix.lat_deg, fix.lon_deg)
        rule = None
        if good and self._pose.started:
            rule = self._witness.position(fix, (north, east), lever, sigma_m, self._solution())
            sigma_m = self._witness.monitor.sigma_m(fix.source, sigma_m)
        good = good and self._witness.trusts(Sense.POSITION, fix.source)
        used = self._positions.offer(fix.source, fix.t_s, good, int(fix.fix >= FixType.RTK_FLOAT))
        if used or self._fix is None or self._fix.source == fix.source:
            self._fix = fix
        self._fix_types[fix.source] = fix.fix
        if good and self._pairs:
            self._pair_heading(fix, (north, east), lever, sigma_m)
        if not good:
            self._blend.drop(fix.source)
        if used:
            self._announce(fix)
            self._use_fix(fix, (north, east), lever, sigma_m, rule)
        elif good and self._blends and self._pose.started and rule is None:
            self._fuse_position(fix, (north, east), lever, sigma_m, None)

    def _pair_heading(self, fix: GnssFix, place: tuple[float, float], lever: Vector, sigma_m: float) -> None:
        """The heading that a fix gives with that of another receiver."""
        solution, tilt = self._solution(), (0.0, 0.0)
        if isinstance(solution, InertialSolution):
            roll, pitch, _ = euler_of(solution.filter.rotation)
            tilt = roll, pitch
        here, swing = solution.place(fix.t_s), solution.offset(lever)
        velocity = here.north_mps + swing.north_mps, here.east_mps + swing.east_mps
        for pair in self._pairs:
            heading = pair.take(fix, place, velocity, tilt, sigma_m)
            if heading is not None:
                self._take_heading(heading)

    def _use_fix(
        self, fix: GnssFix, place: tuple[float, float], lever: Vector, sigma_m: float, rule: Verdict | None
    ) -> None:
        """Take a fix of the receiver in use."""
        north, east = place
        self._jumps_followed += rule is Verdict.RESET
        if self._parameters["NAV_WILD_RULE"] == _THESIS_RULE:
            rule = rule or self._thesis.update(north, east)
        if not self._pose.started:
            self._first_fix(fix, north, east, lever, sigma_m)
            return
        if self._begins_anew(Sense.POSITION, rule) is Verdict.RESET:
            here = self._solution().place(fix.t_s)
            off_m = math.hypot(north - here.north_m, east - here.east_m)
            rule = Verdict.RESET if rule is Verdict.RESET or off_m > _LIE_M else rule
        self._fuse_position(fix, place, lever, sigma_m, rule)

    @property
    def _blends(self) -> bool:
        """Whether several receivers are used at once."""
        chosen = self._parameters["NAV_BLEND"] and self._parameters["NAV_WILD_RULE"] != _THESIS_RULE
        return len(self._fix_types) > 1 and bool(chosen)

    def _fuse_position(
        self, fix: GnssFix, place: tuple[float, float], lever: Vector, sigma_m: float, rule: Verdict | None
    ) -> None:
        solution, leads = self._solution(), fix.source == self._positions.current
        added_m2 = self._grade.update(fix.t_s, fix.fix, sigma_m) if leads else 0.0
        inertial = isinstance(solution, InertialSolution)
        if isinstance(solution, PoseSolution) and added_m2 > 0.0:
            solution.add_position_variance(added_m2)
        accuracies = self._accuracies
        fused_sigma_m = (
            self._noisier * accuracies.noise_m(fix, sigma_m) if inertial else accuracies.fused_m(fix, sigma_m)
        )
        slow_sigma_m = accuracies.slow_m(fix, sigma_m)
        if self._blends and rule is None:
            offset = self._offset(fix, place, lever, fused_sigma_m, slow_sigma_m, leads)
            if offset is None:
                return
            place = place[0] - offset.north_m, place[1] - offset.east_m
            slow_sigma_m = offset.slow_sigma_m
        if leads:
            self._expect_wander(fix, slow_sigma_m)
        before = solution.place(fix.t_s)
        verdict = solution.position(fix.t_s, *place, lever, fused_sigma_m, rule)
        if verdict is Verdict.RESET:
            self._blend.clear()
            self._announce_reset(fix, before, solution.place(fix.t_s))
        if verdict is not Verdict.REJECT:
            self._validity.position(fix.t_s, 0.0 if inertial else slow_sigma_m)
            if leads:
                self._altitude.take(fix, lever)

    def _expect_wander(self, fix: GnssFix, slow_sigma_m: float) -> None:
        """Tell the inertial filter of the slow error of the receiver in use. Blended receivers have the one of all."""
        before, self._wander_of = self._wander_of, fix.source
        if self._inertial is not None:
            another = before not in (None, fix.source) and not self._blends
            self._inertial.expect_wander(self._accuracies.wander(fix, slow_sigma_m), another)

    @property
    def _noisier(self) -> float:
        """The factor by which positions and velocities count as noisier: where they alone tell the heading, what is
        left of their slow errors would be taken for a turn."""
        return _BY_MOTION_FACTOR if self._headings.by_motion else 1.0

    def _offset(
        self, fix: GnssFix, place: tuple[float, float], lever: Vector, sigma_m: float, slow_sigma_m: float, leads: bool
    ) -> Offset | None:
        """What blending takes off a fix; None: the receiver is new."""
        solution = self._solution()
        here, arm = solution.place(fix.t_s), solution.offset(lever)
        off_m = place[0] - arm.north_m - here.north_m, place[1] - arm.east_m - here.east_m
        return self._blend.update(fix.source, fix.t_s, off_m, sigma_m, slow_sigma_m, leads)

    def _announce_reset(self, fix: GnssFix, before: Place, after: Place) -> None:
        """Announce that the estimate has restarted from a fix, where an inertial sensor had carried it."""
        if self._inertial is not None:
            jump_m = math.hypot(after.north_m - before.north_m, after.east_m - before.east_m)
            text = f"Position reset by {jump_m:.0f} m ({fix.source})"
            self._say(fix.t_s, TextKind.ALARM, "position_jumped", text)

    def _announce(self, fix: GnssFix) -> None:
        """Announce when another receiver takes over."""
        before, self._position_source = self._position_source, fix.source
        if before is not None and before != fix.source:
            text = f"Position source: {fix.source} (was {before})"
            self._say(fix.t_s, TextKind.ATTENTION, "position_source", text)

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
        self._validity.begin(fix.t_s)
        self._altitude.take(fix, lever)

    def _take_velocity(self, velocity: GroundVelocity) -> None:
        lever, rule = self._levers.get(velocity.source, ZERO), None
        fix = None if self._fix is None else self._fix_types.get(velocity.source, self._fix.fix)
        sigma_mps = self._accuracies.velocity_mps(velocity, fix)
        if self._pose.started:
            rule = self._witness.velocity(velocity, lever, sigma_mps, self._solution())
            self._time_velocity(velocity, lever)
        good = self._witness.trusts(Sense.VELOCITY, velocity.source)
        used = self._velocities.offer(velocity.source, velocity.t_s, good)
        if rule is Verdict.REJECT or not (used or (good and self._blends)):
            return
        if used:
            self._aid_heading(velocity, sigma_mps, lever)
            self._search_heading(velocity, sigma_mps, lever)
            if self._inertial is not None:
                self._inertial.filter.expect_walk(self._accuracies.walk_mps_rthz(velocity, fix, sigma_mps))
        if self._pose.started:
            rule = self._begins_anew(Sense.VELOCITY, rule)
            measured = velocity.north_mps, velocity.east_mps
            verdict = self._solution().velocity(velocity.t_s, *measured, lever, self._noisier * sigma_mps, rule)
            if verdict is not Verdict.REJECT:
                self._validity.velocity(velocity.t_s)

    def _time_velocity(self, velocity: GroundVelocity, lever: Vector) -> None:
        """Let a velocity tell how late its receiver is."""
        inertial = self._feeling
        if inertial is not None and velocity.source == self._positions.current:
            self._receivers.velocity(inertial, velocity.t_s, (velocity.north_mps, velocity.east_mps), lever)

    def _aid_heading(self, velocity: GroundVelocity, sigma_mps: float, lever: Vector) -> None:
        solution, known_rad = self._solution(), math.inf
        if self._headings.by_motion and isinstance(solution, InertialSolution):
            known_rad = solution.filter.sigmas()[2]
        course = self._headings.course(velocity, known_rad)
        if course is not None:
            self._fuse_heading(velocity.t_s, course)
        for ahrs in self._ahrs.values():
            ahrs.velocity(velocity.t_s, velocity.north_mps, velocity.east_mps, sigma_mps, lever)

    def _search_heading(self, velocity: GroundVelocity, sigma_mps: float, lever: Vector) -> None:
        """Look for the heading by the boat's motion while nothing measures it."""
        inertial = self._inertial
        if inertial is None or not self._pose.started or not self._search.is_due(velocity.t_s):
            return
        yaw_sigma_rad = self._solution().motion(inertial.t_s).yaw_sigma_rad
        found = self._search.look(velocity, lever, sigma_mps, inertial, yaw_sigma_rad)
        if found is not None:
            self._orient(inertial, found)

    def _orient(self, inertial: InertialSolution, found: ErrorStateFilter) -> None:
        """Go on with a filter that has found the heading."""
        t_s, motion = inertial.t_s, self._solution().motion(inertial.t_s)
        # without a heading, the antenna may be on any side of the boat
        arm_m = max(math.hypot(lever[0], lever[1]) for lever in (*self._levers.values(), ZERO))
        inertial.continue_from(
            found, replace(motion, position_sigma_m=math.hypot(motion.position_sigma_m, 2.0 * arm_m))
        )
        self._pose.heading(t_s, found.euler()[2], found.sigmas()[2], Verdict.RESET)
        self._validity.heading(t_s, 0.0)
        self._headings.found_by_motion(t_s)
        self._search.heard(t_s)

    def _take_heading(self, reading: Heading, by_field_rad: float | None = None) -> None:
        """`by_field_rad`: of a heading that our own attitude filter gives, what the magnetic field alone says."""
        measured = self._headings.measured(reading, *self._place(), self._side.time_ns(reading.t_s))
        if measured is None:
            return
        inertial = self._inertial
        if inertial is not None and inertial.running and measured.source == self._positions.current:
            self._receivers.heading(inertial, reading.t_s, measured.yaw_rad)
        rule = self._witness.heading(reading, measured, self._solution(), by_field_rad) if self._pose.oriented else None
        heading = self._headings.offer(measured, self._witness.trusts(Sense.HEADING, measured.source))
        if heading is not None:
            self._fuse_heading(reading.t_s, heading, self._begins_anew(Sense.HEADING, rule))

    def _place(self) -> tuple[float, float]:
        """(lat_deg, lon_deg) for the declination: that of the estimate, since a fix may be a wild one."""
        if self._here is not None:
            return self._here
        fix = self._fix
        if fix is not None and fix.fix >= FixType.FIX_2D:
            return fix.lat_deg, fix.lon_deg
        return self._home.lat_deg, self._home.lon_deg

    def _fuse_heading(self, t_s: float, heading: TrueHeading, rule: Verdict | None = None) -> None:
        solution, slow_sigma_rad = self._solution(), heading.slow_sigma_rad
        if self._inertial is not None:
            wander, common = Wander(slow_sigma_rad, heading.slow_time_s), 0.0 if heading.anew else 1.0
            self._inertial.filter.expect_heading_wander(wander, common)
        if isinstance(solution, InertialSolution):
            slow_sigma_rad = 0.0
        elif heading.added_sigma_rad > 0.0:
            solution.add_heading_variance(heading.added_sigma_rad**2)
        if solution.heading(t_s, heading.yaw_rad, heading.sigma_rad, rule) is not Verdict.REJECT:
            self._validity.heading(t_s, slow_sigma_rad)
            self._search.heard(t_s)

    def _aid_by_model(self, motion: Motion, thrust: Wrench | None, now_s: float) -> None:
        """Let the hull model learn from the motion, and carry the velocity on where nothing measures it."""
        usable = self._pose.started and self._pose.oriented and not self._model.is_impossible(motion)
        air = air_of(*self._side.wind(now_s))
        self._model.observe(now_s, thrust, motion if usable else None, air, self._validity)
        solution = self._solution()
        if isinstance(solution, InertialSolution):
            aid = self._model.velocity(now_s, motion, self._validity)
            if aid is not None:
                solution.aid(*aid)

    def _motion(self, now_s: float) -> Motion:
        solution = self._solution()
        if isinstance(solution, InertialSolution):
            later = self._imus.later(self._queue.pending, now_s)
            if not solution.feels:
                later = [without_force(imu, solution.filter.gravity_mps2) for imu in later]
            return solution.motion(now_s, later)
        motion, inertial = solution.motion(now_s), self._inertial
        if inertial is None or now_s - self._queue.lag_s - inertial.t_s > _IMU_TIMEOUT_S:
            return motion
        roll, pitch = inertial.levelling.tilt() or (0.0, 0.0)
        return replace(motion, attitude=(roll, pitch, motion.attitude[2]), rates=inertial.rates)

    def _state(self, motion: Motion, waves: WaveMotion | None, now_s: float) -> NavState:
        (north, east, _), (vn, ve, _), (roll, pitch, yaw) = motion.position, motion.velocity, motion.attitude
        lat, lon = self.frame.to_geodetic(north, east)
        if self._pose.started:
            self._here = lat, lon
        surge, sway = ned_to_body(vn, ve, yaw)
        validity, pose = self._validity, self._pose
        position_sigma_m, yaw_sigma_rad = validity.position_sigma_m(motion), validity.yaw_sigma_rad(motion)
        by_gyro = isinstance(self._solution(), InertialSolution)
        fix = self._fix
        heard = fix is not None and now_s - fix.t_s <= self._timeouts_s.get(fix.source, self._parameters["FS_POS_T"])
        wind_speed, wind_from = self._side.wind(now_s)
        observer = self._model.current
        current = (None if observer is None else observer.estimate(now_s)) or (None, None, None)
        return NavState(
            t_s=now_s,
            position_valid=pose.started and validity.position_valid(position_sigma_m, now_s),
            heading_valid=pose.oriented
            and validity.heading_valid(yaw_sigma_rad, now_s, by_gyro, self._headings.by_motion),
            lat_deg=lat,
            lon_deg=lon,
            altitude_m=self._altitude.altitude_m,
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
            position_age_s=now_s - validity.position_s,
            heading_age_s=now_s - validity.heading_s,
            imu_age_s=now_s - validity.imu_s,
            fix=fix.fix if heard and fix is not None else FixType.NONE,
            satellites=fix.satellites if heard and fix is not None else None,
            hdop=fix.hdop if heard and fix is not None else None,
            time_unix_ns=self._side.time_ns(now_s),
            wind_speed_mps=wind_speed,
            wind_from_rad=wind_from,
            current_north_mps=current[0],
            current_east_mps=current[1],
            current_accuracy_mps=current[2],
            distrusted=self._witness.monitor.state,
            jumps_followed=self._jumps_followed,
            position_covariance_m2=validity.covariance_m2(motion),
            judged=() if self._inertial is None else tuple(self._inertial.judged.values()),
            waves=waves,
        )
