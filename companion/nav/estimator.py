"""Readings → `NavState`: sorts readings in time, chooses sources, and passes them to the solution in use."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from companion.config.sensors import is_averaging
from companion.config.vessel import NavigatedBoat
from companion.core.actuation import Wrench
from companion.core.decision import TextKind
from companion.core.estimate import NavState, WaveMotion, air_of
from companion.core.events import SHORT_NAME, Announce, unheard
from companion.core.frames import ned_to_body
from companion.core.geodesy import LocalFrame
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
from companion.nav.antenna_pair import antenna_pairs
from companion.nav.corrections import corrections_of
from companion.nav.error_state import ErrorStateFilter
from companion.nav.fixes import Fixes, JudgedFix
from companion.nav.heading_search import HeadingSearch, is_lost
from companion.nav.headings import HeadingSources, TrueHeading
from companion.nav.inertial import InertialSolution, without_force
from companion.nav.inertial_source import InertialSource
from companion.nav.integrity.evidence import INERTIAL, LieFound, Sense
from companion.nav.lever_arms import ZERO, Vector, euler_of, lever_arms, normal_gravity_mps2
from companion.nav.measured_off import Wander
from companion.nav.model_aid import ModelAid
from companion.nav.mounting import Mounting
from companion.nav.outliers import Verdict
from companion.nav.reading_queue import ReadingQueue
from companion.nav.receiver_latency import ReceiverLatency
from companion.nav.side_readings import SideReadings
from companion.nav.solution import Motion
from companion.nav.solutions import Solutions
from companion.nav.sources import SourceSelector, plausible
from companion.nav.sternway import Sternway
from companion.nav.validity import Validity
from companion.nav.witness import Witness
from companion.params.store import Parameters

_UNCONFIRMED_S = 0.5  # shorter than the gates take to follow the receivers to where the estimate has gone
_IMU_TIMEOUT_S = 0.5
_LIE_SIGMA = 0.5  # m, m/s: of the motion that a lying inertial sensor leaves
_LIE_SIGMA_RAD = math.radians(15.0)  # of a heading that has followed a lie
_BY_MOTION_FACTOR = 2.0  # on the noise of positions and velocities that alone tell the heading


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
        self._levers = lever_arms(config.sensors)
        timeouts_s = {row.name: row.timeout_s for row in config.sensors}
        self._accuracies = SensorAccuracies(config.sensors)
        self._say = say
        self._corrections = corrections_of(config.sensors, parameters)
        self._headings = HeadingSources(config, say, self._corrections)
        self._search = HeadingSearch()
        self._ahrs = ahrs_headings(config, parameters, self._corrections, baseline_ahrs)
        self._mounting = Mounting(config, parameters)
        self._velocities = SourceSelector(timeouts_s)
        self._timeouts_s = timeouts_s
        self._receivers = ReceiverLatency()
        self._latencies_s = {row.name: row.latency_s for row in config.sensors}
        periods_s = {row.name: 1.0 / row.rate_hz for row in config.sensors if row.rate_hz}
        averaging = {row.name for row in config.sensors if is_averaging(row)}
        self._queue = ReadingQueue(self._latencies_s, self._receivers.late_s, periods_s, averaging)
        self._witness = Witness(parameters, say, self._levers)
        self._imus = InertialSource(config.sensors, self._corrections, self._mounting, self._witness)
        self._validity = Validity(parameters)
        self._solutions = Solutions()
        self._fixes = Fixes(config, parameters, say, self._accuracies, self._witness, self._validity, self._solutions)
        self._model = ModelAid(config, parameters)
        self._pairs = antenna_pairs(config.sensors)
        self._sternway = Sternway()
        self._side = SideReadings(timeouts_s, self._witness)
        self._unusable: set[str] = set()  # compasses of which that has been told
        self._here: tuple[float, float] | None = None  # latitude and longitude by the last possible estimate

    @property
    def inertial(self) -> InertialSolution | None:
        """The solution that the inertial sensor carries; None before its first reading."""
        return self._solutions.inertial

    @property
    def frame(self) -> LocalFrame:
        """The local plane."""
        return self._fixes.frame

    def update(self, readings: Sequence[Reading], now_s: float, thrust: Wrench | None = None) -> NavState:
        """Take the readings since the last call and return the state at `now_s`, which must not go back. `thrust`: the
        wrench that the thrusters gave since then; None if unknown (while disarmed, mooring lines may hold the boat, or
        others may drive its thrusters)."""
        readings = [
            self._imus.corrected(reading) if type(reading) is Imu else reading
            for reading in readings
            if plausible(reading, now_s)
        ]
        self._fixes.driven = thrust is not None
        self._sternway.update(thrust, now_s)
        self._queue.add(readings)
        for reading in self._queue.due(now_s):
            self._take(reading)
        self._check_imu(now_s - self._queue.lag_s)
        self._watch_latency()
        motion = self._motion(now_s)
        if thrust is not None and self._is_lost(motion, now_s):
            motion = self._begin_anew(motion, now_s)
        pose = self._solutions.pose
        self._side.take(readings, motion, pose.oriented)
        self._aid_by_model(motion, thrust, now_s)
        driven, late = thrust is not None and pose.started, self._receivers.unsettled(self._fixes.source)
        used, astern = self._imus.current, self._sternway.possible
        found = self._witness.conclude(driven, late, motion, self.inertial, self._model.current, now_s, used, astern)
        self._react(found)
        if self._witness.monitor.untrusted:
            self._validity.lied_s = now_s
        self._validity.apart_m = self._witness.monitor.apart_m(self._fixes.source)
        return self._state(motion, self._model.waves(now_s, thrust, motion, air_of(*self._side.wind(now_s))), now_s)

    def _is_lost(self, motion: Motion, now_s: float) -> bool:
        """Whether the boat cannot be as fast as the estimate, and no receiver says that it is."""
        return self._model.is_impossible(motion) and self._validity.unmeasured_s(now_s) > _UNCONFIRMED_S

    def _begin_anew(self, motion: Motion, now_s: float) -> Motion:
        """Forget an estimate that no boat can sail: it has lost itself, and speaks against receivers that are right.
        Returns the motion without it."""
        speed_mps = math.hypot(motion.velocity[0], motion.velocity[1])
        text = f"Estimate restarted: {speed_mps:.0f} m/s is impossible"
        self._say(now_s, TextKind.ALARM, "estimate_begun_anew", text)
        self._solutions.begin_anew()
        self._fixes.begin_anew()
        self._model.begin_anew()
        self._witness.monitor.begin_anew()
        return self._motion(now_s)

    def answer(self, accept: bool, now_s: float) -> str | None:
        """The operator's answer about a sensor that seems to lie: believe it, or not. Returns why not, or None."""
        return self._witness.monitor.answer(accept, now_s)

    def _react(self, findings: Sequence[LieFound]) -> None:
        """Undo what the filter has taken from sources that are found to lie."""
        inertial = self._solutions.inertial
        if not findings or inertial is None or not inertial.running:
            return
        carrying = {(sense, self._imus.current) for sense in INERTIAL}
        if any(finding.channel in carrying for finding in findings) and not self._imus.voted(inertial.t_s):
            self._solutions.leave_inertial(inertial.t_s, _LIE_SIGMA)
            self._solutions.doubt()
            return
        used = {
            (Sense.POSITION, self._fixes.source),
            (Sense.VELOCITY, self._velocities.current),
            (Sense.HEADING, self._headings.used),
        }
        if self._fixes.blend:
            used |= {(sense, name) for name in self._fixes.kinds for sense in (Sense.POSITION, Sense.VELOCITY)}
        taken = [finding for finding in findings if finding.channel in used and not finding.jump]
        if any(finding.loses for finding in taken):
            self._lose_heading(inertial)
            return
        if taken:
            self._fixes.forget_offsets()
        if taken and inertial.feels:
            inertial.go_back(min(finding.since_s for finding in taken))
        if any(finding.widens for finding in taken):
            inertial.add_heading_variance(_LIE_SIGMA_RAD**2)

    def _lose_heading(self, inertial: InertialSolution) -> None:
        """The heading has been wrong from the start; tilt and biases, which have hidden that, too."""
        self._solutions.leave_inertial(inertial.t_s, _LIE_SIGMA)
        inertial.forget_biases()
        self._solutions.pose.add_heading_variance(math.pi**2)
        self._fixes.forget_offsets()

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
            "position": self._fixes.source,
            "velocity": self._velocities.current,
            "heading": self._headings.used,
            "inertial": self._imus.current,
            "wind": self._side.wind_source,
        }

    def _watch_latency(self) -> None:
        """What measurements say of how late the receiver in use is."""
        inertial, source = self._solutions.feeling, self._fixes.source
        if inertial is None or source is None:
            return
        found = self._receivers.update(inertial, source)
        if found is not None:
            text = found.text(self._latencies_s.get(source, 0.0))
            self._say(inertial.t_s, TextKind.ATTENTION, "receiver_late", text)

    def _felt(self, measured: Imu) -> Imu:
        """The sample as it is used: without its forces, where those lie."""
        felt, feels = self._imus.felt(measured, self.frame.lat_deg)
        if feels is not None:
            self._feel(measured.source, feels)
        return felt

    def _feel(self, source: str, feels: bool) -> None:
        """Begin anew, with or without the forces of a sensor."""
        inertial = self._solutions.inertial
        if inertial is not None and source == self._imus.current:
            if inertial.running:
                self._solutions.leave_inertial(inertial.t_s, _LIE_SIGMA)
            inertial.feel(feels)

    def _take_imu(self, measured: Imu, felt: Imu) -> None:
        """`felt`: the sample as it is used. A sensor whose forces lie gives way to another."""
        before = self._imus.current
        imu = self._imus.chosen(measured, felt)
        if imu is None:
            return
        feels, inertial, pose = felt is measured, self._solutions.inertial, self._solutions.pose
        if before not in (None, imu.source) and inertial is not None and inertial.feels is not feels:
            self._feel(imu.source, feels)
        if inertial is None or before != imu.source:
            inertial = self._carried_by(imu, before)
            self._search.heard(imu.t_s)
        if inertial.running and (imu.t_s - inertial.t_s > _IMU_TIMEOUT_S or self._recalibrated(imu.source)):
            self._solutions.leave_inertial(inertial.t_s)
        inertial.sample(imu)
        if self._search.runs:
            self._search.sample(imu)
        self._validity.imu(imu.t_s)
        if not inertial.running and pose.started and pose.oriented:
            motion = pose.motion(imu.t_s)
            surge_mps, _ = ned_to_body(motion.velocity[0], motion.velocity[1], motion.attitude[2])
            tilt = inertial.levelling.tilt(surge_mps)
            if tilt is not None and not is_lost(motion.yaw_sigma_rad):
                fastest_mps = max(abs(surge_mps), pose.behind_mps)
                inertial.start(motion, tilt, inertial.levelling.sigma_rad(fastest_mps))

    def _carried_by(self, imu: Imu, before: str | None) -> InertialSolution:
        """The solution, from now on with the samples of that sensor."""
        lever, noise = self._levers.get(imu.source, ZERO), self._accuracies.imu(imu.source)
        inertial = self._solutions.inertial
        if inertial is None:
            inertial = InertialSolution(normal_gravity_mps2(self.frame.lat_deg), lever, noise)
            self._solutions.inertial = inertial
        else:
            inertial.carry_over(lever, noise)
            self._say(imu.t_s, TextKind.ATTENTION, "inertial_source", f"Inertial source: {imu.source} (was {before})")
        return inertial

    def _recalibrated(self, source: str) -> bool:
        """Whether a sensor has been calibrated since its last sample; what the filter knows of its biases is void
        then."""
        anew = self._imus.recalibrated(source)
        if anew and self._solutions.inertial is not None:
            self._solutions.inertial.forget_biases()
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
        if ahrs is None:
            return
        if declination is None:
            self._tell_unusable(field.t_s, field.source, "near the pole")
            return
        ahrs.field(field, declination, self._mounting.compass(field.source))
        if ahrs.steep_rad is not None:
            dip_deg = math.degrees(ahrs.steep_rad)
            self._tell_unusable(field.t_s, field.source, f"dip of {dip_deg:.0f} deg")

    def _tell_unusable(self, t_s: float, source: str, why: str) -> None:
        """Tell once that a compass gives no heading here."""
        if source not in self._unusable:
            self._unusable.add(source)
            self._say(t_s, TextKind.ATTENTION, "compass_unusable", f"{source[:SHORT_NAME]} compass unusable: {why}")

    def _check_imu(self, horizon_s: float) -> None:
        """Stop the inertial filter when its samples have stopped."""
        inertial = self._solutions.inertial
        if inertial is not None and inertial.running and horizon_s - inertial.t_s > _IMU_TIMEOUT_S:
            self._solutions.leave_inertial(inertial.t_s)

    def _measured_by(self, source: str) -> None:
        """A position or velocity of that receiver comes next. What the filter knows of how late the receiver in use is
        says nothing of another one, of which only its row tells."""
        if self._solutions.inertial is not None:
            filter_, used = self._solutions.inertial.filter, self._fixes.source in (None, source)
            filter_.late, filter_.unsure_s = used, 0.0 if used else self._accuracies.latency_s(source)

    def _take_fix(self, fix: GnssFix) -> None:
        self._measured_by(fix.source)
        judged = self._fixes.judge(fix)
        self._measured_by(fix.source)  # it may have taken over
        if judged.good and self._pairs:
            self._pair_heading(judged)
        self._fixes.fuse(judged, self._noisier)

    def _pair_heading(self, judged: JudgedFix) -> None:
        """The heading that a fix gives with that of another receiver."""
        fix, solution, tilt = judged.fix, self._solutions.used, (0.0, 0.0)
        if isinstance(solution, InertialSolution):
            roll, pitch, _ = euler_of(solution.filter.rotation)
            tilt = roll, pitch
        here, swing = solution.place(fix.t_s), solution.offset(judged.lever_m)
        velocity = here.north_mps + swing.north_mps, here.east_mps + swing.east_mps
        for pair in self._pairs:
            heading = pair.take(fix, judged.place, velocity, tilt, judged.sigma_m)
            if heading is not None:
                self._take_heading(heading)

    @property
    def _noisier(self) -> float:
        """The factor by which positions and velocities count as noisier: where they alone tell the heading, what is
        left of their slow errors would be taken for a turn."""
        return _BY_MOTION_FACTOR if self._headings.by_motion else 1.0

    def _take_velocity(self, velocity: GroundVelocity) -> None:
        if self._solutions.is_too_late(velocity.t_s):
            return
        self._measured_by(velocity.source)
        lever, rule = self._levers.get(velocity.source, ZERO), None
        fix = None if self._fixes.newest is None else self._fixes.kinds.get(velocity.source, self._fixes.newest.fix)
        sigma_mps = self._accuracies.velocity_mps(velocity, fix)
        if self._solutions.pose.started:
            rule = self._witness.velocity(velocity, lever, sigma_mps, self._solutions.used)
            self._time_velocity(velocity, lever)
        good = self._witness.trusts(Sense.VELOCITY, velocity.source)
        used = self._velocities.offer(velocity.source, velocity.t_s, good)
        if rule is Verdict.REJECT or not (used or (good and self._fixes.blend)):
            return
        if used:
            self._aid_heading(velocity, sigma_mps, lever)
            self._search_heading(velocity, sigma_mps, lever)
            if self._solutions.inertial is not None:
                self._solutions.inertial.filter.expect_walk(self._accuracies.walk_mps_rthz(velocity, fix, sigma_mps))
        if self._solutions.pose.started:
            rule = self._solutions.begins_anew(Sense.VELOCITY, rule)
            measured = velocity.north_mps, velocity.east_mps
            verdict = self._solutions.used.velocity(velocity.t_s, *measured, lever, self._noisier * sigma_mps, rule)
            if verdict is not Verdict.REJECT:
                self._validity.velocity(velocity.t_s)

    def _time_velocity(self, velocity: GroundVelocity, lever: Vector) -> None:
        """Let a velocity tell how late its receiver is."""
        inertial = self._solutions.feeling
        if inertial is not None and velocity.source == self._fixes.source:
            self._receivers.velocity(inertial, velocity.t_s, (velocity.north_mps, velocity.east_mps), lever)

    def _aid_heading(self, velocity: GroundVelocity, sigma_mps: float, lever: Vector) -> None:
        solution, known_rad, blind = self._solutions.used, math.inf, False
        if not isinstance(solution, InertialSolution):
            used = self._headings.used
            blind = used is not None and not self._witness.trusts(Sense.HEADING, used)
        elif self._headings.by_motion:
            known_rad = solution.filter.sigmas()[2]
        ahead = self._of_the_bow(velocity)
        course = None if ahead is None else self._headings.course(ahead, known_rad, blind)
        if course is not None:
            self._fuse_heading(velocity.t_s, course)
        astern = self._sternway.possible
        for ahrs in self._ahrs.values():
            ahrs.velocity(velocity.t_s, velocity.north_mps, velocity.east_mps, sigma_mps, lever, astern)

    def _of_the_bow(self, velocity: GroundVelocity) -> GroundVelocity | None:
        """The velocity, turned round where the boat goes stern first; None where nobody knows whether it does."""
        if not self._sternway.possible:
            return velocity
        motion = self._solutions.used.motion(velocity.t_s)
        if not self._solutions.pose.oriented or is_lost(motion.yaw_sigma_rad):
            return None
        surge_mps, _ = ned_to_body(velocity.north_mps, velocity.east_mps, motion.attitude[2])
        if surge_mps >= 0.0:
            return velocity
        return replace(velocity, north_mps=-velocity.north_mps, east_mps=-velocity.east_mps)

    def _search_heading(self, velocity: GroundVelocity, sigma_mps: float, lever: Vector) -> None:
        """Look for the heading by the boat's motion while nothing measures it."""
        inertial = self._solutions.inertial
        if inertial is None or not self._solutions.pose.started or not self._search.is_due(velocity.t_s):
            return
        yaw_sigma_rad = self._solutions.used.motion(inertial.t_s).yaw_sigma_rad
        found = self._search.look(velocity, lever, sigma_mps, inertial, yaw_sigma_rad)
        if found is not None:
            self._orient(inertial, found)

    def _orient(self, inertial: InertialSolution, found: ErrorStateFilter) -> None:
        """Go on with a filter that has found the heading."""
        t_s, motion = inertial.t_s, self._solutions.used.motion(inertial.t_s)
        # without a heading, the antenna may be on any side of the boat
        arm_m = max(math.hypot(lever[0], lever[1]) for lever in (*self._levers.values(), ZERO))
        inertial.continue_from(
            found, replace(motion, position_sigma_m=math.hypot(motion.position_sigma_m, 2.0 * arm_m))
        )
        self._solutions.pose.heading(t_s, found.euler()[2], found.sigmas()[2], Verdict.RESET)
        self._validity.heading(t_s, 0.0)
        self._headings.found_by_motion(t_s)
        self._search.heard(t_s)

    def _take_heading(self, reading: Heading, by_field_rad: float | None = None) -> None:
        """`by_field_rad`: of a heading that our own attitude filter gives, what the magnetic field alone says."""
        if self._solutions.is_too_late(reading.t_s):
            return
        measured = self._headings.measured(reading, *self._place(), self._side.time_ns(reading.t_s))
        if measured is None:
            self._tell_unusable(reading.t_s, reading.source, "near the pole")
            return
        inertial = self._solutions.inertial
        if inertial is not None and inertial.running and measured.source == self._fixes.source:
            self._receivers.heading(inertial, reading.t_s, measured.yaw_rad)
        rule = (
            self._witness.heading(reading, measured, self._solutions.used, by_field_rad)
            if self._solutions.pose.oriented
            else None
        )
        instead_of_course = self._headings.by_course and not isinstance(self._solutions.used, InertialSolution)
        heading = self._headings.offer(measured, self._witness.trusts(Sense.HEADING, measured.source))
        if heading is not None:
            if rule is None and instead_of_course:  # without a gyro a course tells little of the bow's direction
                rule = Verdict.RESET
            self._fuse_heading(reading.t_s, heading, self._solutions.begins_anew(Sense.HEADING, rule))

    def _place(self) -> tuple[float, float]:
        """(lat_deg, lon_deg) for the declination: that of the estimate, since a fix may be an outlier."""
        if self._here is not None:
            return self._here
        fix = self._fixes.newest
        if fix is not None and fix.fix >= FixType.FIX_2D:
            return fix.lat_deg, fix.lon_deg
        return self._home.lat_deg, self._home.lon_deg

    def _fuse_heading(self, t_s: float, heading: TrueHeading, rule: Verdict | None = None) -> None:
        solution, slow_sigma_rad = self._solutions.used, heading.slow_sigma_rad
        if self._solutions.inertial is not None:
            wander, common = Wander(slow_sigma_rad, heading.slow_time_s), 0.0 if heading.anew else 1.0
            self._solutions.inertial.filter.expect_heading_wander(wander, common)
            self._solutions.inertial.filter.heading_late = self._headings.used == self._fixes.source
        if isinstance(solution, InertialSolution):
            slow_sigma_rad = 0.0
        elif heading.added_sigma_rad > 0.0:
            solution.add_heading_variance(heading.added_sigma_rad**2)
        if solution.heading(t_s, heading.yaw_rad, heading.sigma_rad, rule) is not Verdict.REJECT:
            self._validity.heading(t_s, slow_sigma_rad)
            self._search.heard(t_s)

    def _aid_by_model(self, motion: Motion, thrust: Wrench | None, now_s: float) -> None:
        """Let the hull model learn from the motion, and carry the velocity on where nothing measures it."""
        usable = (
            self._solutions.pose.started and self._solutions.pose.oriented and not self._model.is_impossible(motion)
        )
        air = air_of(*self._side.wind(now_s))
        self._model.observe(now_s, thrust, motion if usable else None, air, self._validity)
        solution = self._solutions.used
        if isinstance(solution, InertialSolution):
            aid = self._model.velocity(now_s, motion, self._validity)
            if aid is not None:
                solution.aid(*aid)

    def _motion(self, now_s: float) -> Motion:
        solution = self._solutions.used
        if isinstance(solution, InertialSolution):
            later = self._imus.later(self._queue.pending, now_s)
            if not solution.feels:
                later = [without_force(imu, solution.filter.gravity_mps2) for imu in later]
            return solution.motion(now_s, later)
        motion, inertial = solution.motion(now_s), self._solutions.inertial
        if inertial is None or now_s - self._queue.lag_s - inertial.t_s > _IMU_TIMEOUT_S:
            return motion
        roll, pitch = inertial.levelling.tilt() or (0.0, 0.0)
        return replace(motion, attitude=(roll, pitch, motion.attitude[2]), rates=inertial.rates)

    def _state(self, motion: Motion, waves: WaveMotion | None, now_s: float) -> NavState:
        (north, east, _), (vn, ve, _), (roll, pitch, yaw) = motion.position, motion.velocity, motion.attitude
        lat, lon = self.frame.to_geodetic(north, east)
        if self._solutions.pose.started:
            self._here = self._here if self._model.is_impossible(motion) else (lat, lon)
        elif self._here is not None:  # an estimate that begins anew: where the boat was last
            lat, lon = self._here
            north, east = self.frame.to_ned(lat, lon)
        surge, sway = ned_to_body(vn, ve, yaw)
        validity, pose = self._validity, self._solutions.pose
        position_sigma_m, yaw_sigma_rad = validity.position_sigma_m(motion), validity.yaw_sigma_rad(motion)
        by_gyro = isinstance(self._solutions.used, InertialSolution)
        fix = self._fixes.newest
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
            altitude_m=self._fixes.altitude_m,
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
            jumps_followed=self._fixes.jumps_followed,
            position_covariance_m2=validity.covariance_m2(motion),
            judged=() if self._solutions.inertial is None else tuple(self._solutions.inertial.judged.values()),
            waves=waves,
        )
