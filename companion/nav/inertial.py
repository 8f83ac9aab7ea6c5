"""Navigation with inertial sensors: levelling, the error-state filter, and the gates that reject outliers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from companion.core.angles import wrap_pi
from companion.core.estimate import Judged
from companion.core.readings import Imu
from companion.nav.error_state import ErrorStateFilter, FilterNoise, Innovation
from companion.nav.integrity.evidence import SETTLED_RADPS
from companion.nav.lanes import InertialMemory, InertialSums, Lane
from companion.nav.levelling import TILT_SIGMA_RAD, Levelling
from companion.nav.lever_arms import ZERO, Vector, euler_of, relative, rotate, velocity_ned
from companion.nav.measured_off import Wander
from companion.nav.outliers import HEADING_GATE, POSITION_GATE, VELOCITY_GATE, InnovationGate, Verdict
from companion.nav.slow_error import Limits, SlowError, has_jumped
from companion.nav.solution import Motion, Offset, Place
from companion.nav.way_back import LONGEST_S, NOTHING, Since, WayBack

_RATES_TIME_S = 0.05  # time constant of the low-pass on the published rates
_DOWN_PERIOD_S = 0.2
_FIRST_S = 1.0  # after the start, for the first position
_DOWN_SIGMA_M = 0.3
_DOWN_SIGMA_MPS = 0.3
_DOWN_SAMPLES = 15.0  # of them that share one error: the boat heaves as long as a wave, and its group, pass
_RESET_SIGMA_MPS = 0.1  # added to the velocity when the position is reset
_VELOCITIES_S = 2.0  # after the last one, no velocity holds the estimate
_ASTRAY_MPS, _ASTRAY_RAD = 5.0, math.radians(3.0)  # most that is added to one that has gone astray
_ANEW_SIGMA_MPS, _ANEW_TILT_SIGMA_RAD, _ANEW_YAW_SIGMA_RAD = 0.3, math.radians(3.0), math.radians(15.0)
_LIKELY_BIASES = 3.0  # sigmas of the gyro's bias at switch-on
_COMMON = 0.7  # correlation of the slow errors of two receivers: of plain ones 0.9, with corrections 0.5
_WANDERS = 4.0  # by which the slow error of a receiver may jump, as when other satellites come
_WRONG_FIX_M = 3.0  # a receiver with carrier phase may be off by that; further off, it is the estimate that was lost
_SLOW_POSITION = Limits(most=1.0, reach=2.0, doubt=1.0, least=0.05)
_SLOW_VELOCITY = Limits(most=0.0, reach=0.5, doubt=0.2, least=0.15)
_VELOCITY_DOUBTED_MPS = 0.02  # velocities that are no better do not tell what positions are off by
_SLOW_HEADING = Limits(most=0.0, reach=math.radians(10.0), doubt=math.radians(4.0), least=0.15)
_BACK, _BACK_SHARE = 3.0, 0.4  # sigmas of the slow error, and share of the jump, within which a receiver is back
_BENT_S = 0.03  # within which the way of the boat is straight
_LONGEST_COAST_S = 0.5
_UNFELT_MPS2_RTHZ = 1.0  # of a boat's acceleration, where no accelerometer tells: 1.5 m/s² for half a second
ACCELEROMETER_BIAS_LIMIT_MPS2 = 0.5
GYRO_BIAS_LIMIT_RADPS = math.radians(2.0)


def without_force(imu: Imu, gravity_mps2: float) -> Imu:
    """The sample with the force that a boat feels which is level and does not accelerate."""
    return replace(imu, x_mps2=0.0, y_mps2=0.0, z_mps2=-gravity_mps2)


class InertialSolution:
    """A `Solution` by the error-state filter. It runs from `start` until `stop`, or until a number is not finite.

    `feels`: the forces are measured. Without them the samples hold those of a boat that is level and does not
    accelerate (`without_force`), and count for little: velocities come from receivers, and the tilt stays near level.
    `imu_lever_m`: the IMU's place from the boat's origin. The sigmas are those of the errors, with the slow errors of
    the measurements. Remembers the filter, the gates, and the smoothed rates.
    """

    def __init__(self, gravity_mps2: float, imu_lever_m: Vector, noise: FilterNoise | None = None) -> None:
        self.filter = ErrorStateFilter(gravity_mps2, noise)
        self.running = False
        self.feels = True
        self._noise = self.filter.noise
        self.levelling = Levelling()
        self.t_s = -math.inf  # of the last sample
        self.rates: Vector = (0.0, 0.0, 0.0)
        self.odometer = InertialSums()
        self.judged: dict[str, Judged] = {}  # the newest verdict on each sense
        self._memory = InertialMemory()
        self._way_back = WayBack()
        self._imu_lever_m = imu_lever_m
        self._wander = Wander(0.0, 1.0)
        self._slow_position, self._slow_velocity = SlowError(_SLOW_POSITION), SlowError(_SLOW_VELOCITY)
        self._slow_heading = SlowError(_SLOW_HEADING)
        self._down_s = -math.inf
        self._position_s = self._velocity_s = -math.inf  # of the last position and velocity that were accepted
        self._begun_s: float | None = None  # until the first position
        self._anew: set[str] = set()  # senses whose next measurement counts alone
        self._position_gate = InnovationGate(POSITION_GATE)
        self._velocity_gate = InnovationGate(VELOCITY_GATE)
        self._heading_gate = InnovationGate(HEADING_GATE)

    def start(self, motion: Motion, tilt: tuple[float, float], tilt_sigma_rad: float = TILT_SIGMA_RAD) -> None:
        """Begin from another solution's motion and (roll_rad, pitch_rad). The biases learnt before stay, with the
        variances of a first start."""
        noise = self.filter.noise
        position_m, velocity_mps = max(motion.position_sigma_m, 0.02), max(motion.velocity_sigma_mps, 0.1)
        sigmas = [position_m, position_m, max(position_m, _DOWN_SIGMA_M)]
        sigmas += [velocity_mps, velocity_mps, max(velocity_mps, _DOWN_SIGMA_MPS)]
        sigmas += [tilt_sigma_rad, tilt_sigma_rad, max(motion.yaw_sigma_rad, 0.01)]
        sigmas += [noise.accelerometer_switch_on_mps2] * 3 + [noise.gyro_switch_on_radps] * 3
        attitude = (tilt[0], tilt[1], motion.attitude[2])
        self.filter.rates = self.rates
        self.filter.start((0.0, 0.0, 0.0), motion.velocity, attitude, sigmas)
        arm = rotate(self.filter.rotation, self._imu_lever_m)
        self.filter.position = (motion.position[0] + arm[0], motion.position[1] + arm[1], 0.0)
        self._begin()

    def continue_from(self, found: ErrorStateFilter, motion: Motion) -> None:
        """Begin from a filter of the same sensor that knows the heading, at another solution's position."""
        arm = rotate(found.rotation, self._imu_lever_m)
        position = motion.position[0] + arm[0], motion.position[1] + arm[1], 0.0
        self.filter.continue_from(found, position, max(motion.position_sigma_m, 0.02) ** 2)
        self._begin()

    def _begin(self) -> None:
        self._clear_gates()
        self.odometer.begin()
        self._memory.clear()
        self._begun_s = self.t_s
        self.running = True

    def _clear_gates(self) -> None:
        self._slow_position.begin()
        self._slow_velocity.begin()
        self._slow_heading.begin()
        for gate in (self._position_gate, self._velocity_gate, self._heading_gate):
            gate.clear()

    def stop(self) -> None:
        """Stop; the biases stay for the next start."""
        self.running = False

    def feel(self, feels: bool) -> None:
        """Forces are measured from the next `start` on, or not. Stops."""
        noise = self._noise
        self.filter.expect(noise if feels else replace(noise, accelerometer_mps2_rthz=_UNFELT_MPS2_RTHZ))
        self.filter.accelerometer_bias = ZERO
        self.feels = feels
        self.stop()

    def begin_anew(self) -> None:
        """Measurements have long been wrong, as late ones are: forget what they have made of attitude and biases, which
        hide each other. Without the accelerometers' biases, the tilt is the one that the sensor feels just now; the
        gyro's stay if they are likely. The next position and heading count alone."""
        bx, by, _ = self.filter.accelerometer_bias
        (roll, pitch, _), gravity_mps2 = self.filter.euler(), self.filter.gravity_mps2
        gyro_bias = self.filter.gyro_bias
        self.forget_biases()
        if max(map(abs, gyro_bias)) <= _LIKELY_BIASES * self.filter.noise.gyro_switch_on_radps:
            self.filter.gyro_bias = gyro_bias
        motion = self.motion(self.t_s)
        sigma_mps = max(motion.velocity_sigma_mps, _ANEW_SIGMA_MPS)
        unsure = replace(motion, velocity_sigma_mps=sigma_mps, yaw_sigma_rad=_ANEW_YAW_SIGMA_RAD)
        self.start(unsure, (roll - by / gravity_mps2, pitch + bx / gravity_mps2), _ANEW_TILT_SIGMA_RAD)
        self._anew = {"position", "heading"}

    def forget_jump(self) -> None:
        """If positions have jumped, it was a change of their latency, as is known now: the next one counts alone."""
        if self._slow_position.has_jumped:
            self._slow_position.begin()
            self._anew = {"position"}

    def carry_over(self, lever_m: Vector, noise: FilterNoise) -> None:
        """Go on with the samples of another sensor, at that place from the boat's origin."""
        filter_ = self.filter
        self._noise = noise
        if self.feels:
            filter_.expect(noise)
        further = relative(lever_m, self._imu_lever_m)
        self._imu_lever_m = lever_m
        if further == ZERO:
            return
        (n, e, d), (vn, ve, vd) = filter_.position, filter_.velocity
        arm, swing = rotate(filter_.rotation, further), velocity_ned(filter_.rotation, filter_.rates, further)
        filter_.position = n + arm[0], e + arm[1], d + arm[2]
        filter_.velocity = vn + swing[0], ve + swing[1], vd + swing[2]
        self.odometer.move(arm[:2], swing[:2])
        self.odometer.begin()
        self._memory.clear()
        self._way_back.clear()

    def forget_biases(self) -> None:
        """The sensor has been calibrated: what was learnt of it is void."""
        self.filter.accelerometer_bias = self.filter.gyro_bias = ZERO

    def sample(self, imu: Imu) -> None:
        """Take one IMU sample; one that is not newer than the last is ignored."""
        dt = imu.t_s - self.t_s
        force = (imu.x_mps2, imu.y_mps2, imu.z_mps2)
        rates = (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps)
        if dt <= 0.0:
            return
        self.t_s = imu.t_s
        self._smooth(rates, dt)
        self._way_back.take(imu.t_s, force, relative(rates, self.filter.gyro_bias), dt)
        if not self.running:
            self.levelling.update(imu.t_s, force, relative(rates, self.filter.gyro_bias))
            return
        self._predict(force, rates, dt)
        if imu.t_s - self._down_s >= _DOWN_PERIOD_S:
            self._down_s = imu.t_s
            self.filter.fuse_down(0.0, _DOWN_SAMPLES * _DOWN_SIGMA_M**2, _DOWN_SAMPLES * _DOWN_SIGMA_MPS**2)
            self._stop_if_diverged()
            self._bound_biases()
            self.odometer.learn(imu.t_s, self.filter.gyro_bias[2], self._bias_sigma_radps())
            self._memory.keep(imu.t_s, self.filter, self.swing)

    def _predict(self, force: Vector, rates: Vector, dt_s: float) -> None:
        """Advance filter and odometer by one sample."""
        filter_ = self.filter
        north, east, _ = filter_.velocity
        filter_.predict(force, rates, dt_s)
        after_north, after_east, _ = filter_.velocity
        self._memory.sample(self.t_s, force, rates, dt_s)
        self.odometer.add(dt_s, after_north - north, after_east - east, filter_.turn_radps, filter_.gyro_bias[2])

    def since(self, t_s: float, arm: Vector = ZERO) -> Since:
        """What a point `arm` from the sensor (body axes) has done since then."""
        return self._way_back.since(t_s, self.filter, arm)

    def _straight(self, t_s: float, arm: Vector, north_m: float, east_m: float) -> tuple[float, float]:
        """A position at `t_s` of a point of the hull, as it would be had the point come straight from there, at its
        velocity of now."""
        lag_s = self.t_s - t_s
        if lag_s <= _BENT_S:
            return north_m, east_m
        since, filter_ = self.since(t_s, arm), self.filter
        swing = velocity_ned(filter_.rotation, filter_.rates, arm)
        return (
            north_m + since.north_m - lag_s * (filter_.velocity[0] + swing[0]),
            east_m + since.east_m - lag_s * (filter_.velocity[1] + swing[1]),
        )

    def tilt(self) -> tuple[float, float] | None:
        """(roll_rad, pitch_rad) by the filter, or by gravity before it runs; None in the first second."""
        return self.filter.euler()[:2] if self.running else self.levelling.tilt()

    def go_back(self, since_s: float) -> bool:
        """Take the filter back to before `since_s`, and on from there by the inertial sensor alone: what was fused
        since is forgotten. False if it does not remember as far back."""
        if not self.running or not self._memory.go_back(since_s, self.t_s, self.filter):
            return False
        self._clear_gates()
        return True

    @property
    def doubts(self) -> tuple[float, float, float]:
        """One sigma of position and velocity on each axis (m, m/s) and of heading (rad), beside the filter's: it may
        have followed what was no motion."""
        return self._slow_position.doubt, self._slow_velocity.doubt, self._slow_heading.doubt

    @property
    def lanes(self) -> Sequence[Lane]:
        """Dead reckoning by the inertial sensor alone, from several times; of the sensor's place."""
        return self._memory.lanes

    @property
    def swing(self) -> tuple[float, float]:
        """Velocity of the sensor relative to the boat's origin, in NED."""
        north, east, _ = velocity_ned(self.filter.rotation, self.filter.rates, self._imu_lever_m)
        return north, east

    def _bias_sigma_radps(self) -> float:
        """One sigma of the gyro's bias about the vertical axis."""
        return math.sqrt(max(float(self.filter.covariance[14, 14]), 0.0))

    def place(self, t_s: float) -> Place:
        """As `Solution.place`, with the slow error and the latency that measurements have."""
        filter_, ahead_s = self.filter, t_s - self.t_s
        arm = rotate(filter_.rotation, self._imu_lever_m)
        swing = velocity_ned(filter_.rotation, filter_.rates, self._imu_lever_m)
        north, east = filter_.velocity[0] - swing[0], filter_.velocity[1] - swing[1]
        late_s, (gn, ge) = filter_.measured_late_s, filter_.gaining
        turned_s = ahead_s - filter_.late_s if filter_.heading_late else ahead_s
        ahead_s -= late_s
        yaw = math.atan2(filter_.rotation[3], filter_.rotation[0])
        since = NOTHING
        if self.t_s - t_s > _BENT_S:
            since = self.since(t_s, relative(ZERO, self._imu_lever_m))
            ahead_s, turned_s = ahead_s + self.t_s - t_s, turned_s + self.t_s - t_s
        return Place(
            filter_.position[0] + filter_.wander[0] - arm[0] + ahead_s * north - since.north_m,
            filter_.position[1] + filter_.wander[1] - arm[1] + ahead_s * east - since.east_m,
            north - late_s * gn - since.north_mps,
            east - late_s * ge - since.east_mps,
            wrap_pi(yaw + filter_.heading_wander + turned_s * filter_.rates[2] - since.turned_rad),
            filter_.measured_sigma_m(),
        )

    @property
    def lever_m(self) -> Vector:
        """The sensor's place from the boat's origin, in body axes."""
        return self._imu_lever_m

    def offset(self, lever_m: Vector) -> Offset:
        """As `Solution.offset`."""
        filter_ = self.filter
        arm = rotate(filter_.rotation, lever_m)
        swing = velocity_ned(filter_.rotation, filter_.rates, lever_m)
        return Offset(arm[0], arm[1], swing[0], swing[1])

    def position(
        self, t_s: float, north_m: float, east_m: float, lever_m: Vector, sigma_m: float, rule: Verdict | None = None
    ) -> Verdict:
        """As `Solution.position`."""
        lag_s = self.t_s - t_s
        if lag_s > LONGEST_S:
            return Verdict.REJECT
        arm, variance = relative(lever_m, self._imu_lever_m), sigma_m * sigma_m
        filter_ = self.filter
        north_m, east_m = self._straight(t_s, arm, north_m, east_m)
        innovation = filter_.position_innovation(north_m, east_m, arm, variance, lag_s)
        vn, ve, _ = filter_.velocity
        now = north_m + lag_s * vn, east_m + lag_s * ve
        if rule is None and (self._restarts("position") or self._begins(innovation)):
            filter_.reset_position(*now, arm, variance, 0.0)
            self._position_s = t_s
            return Verdict.ACCEPT
        apart_m, off_m = math.hypot(innovation.y1, innovation.y2), math.hypot(*filter_.wander)
        jumped = rule is None and self._jumps(t_s, innovation, apart_m)
        if jumped:
            filter_.widen_wander(apart_m * apart_m)
            innovation = filter_.position_innovation(north_m, east_m, arm, variance, lag_s)
        drifts = self._unheld(t_s)
        verdict = self._judge("position", t_s, self._position_gate, innovation, sigma_m, rule, drifts)
        if verdict is Verdict.RESET and rule is None and self._by_wander(apart_m, sigma_m):
            filter_.widen_wander(apart_m * apart_m)
            filter_.fuse(filter_.position_innovation(north_m, east_m, arm, variance, lag_s))
            jumped, verdict = True, Verdict.ACCEPT
        if jumped and self._is_back(t_s, off_m):
            filter_.reset_position(*now, arm, variance, 0.0)
        elif verdict is Verdict.RESET:
            gone_m = math.hypot(innovation.y1 + filter_.wander[0], innovation.y2 + filter_.wander[1])
            filter_.reset_position(*now, arm, variance, _RESET_SIGMA_MPS**2)
            self._doubt_motion(apart_m if drifts else 0.0, t_s - self._position_s)
            self._slow_position.jumped(t_s, gone_m if rule is None and gone_m <= _WRONG_FIX_M else 0.0)
        self._position_s = self._position_s if verdict is Verdict.REJECT else t_s
        return verdict

    def _doubt_motion(self, apart_m: float, passed_s: float) -> None:
        """An estimate that no velocity holds has gone astray by so much in that time: its velocity or tilt is wrong."""
        sigma_mps = min(apart_m / max(passed_s, _VELOCITIES_S), _ASTRAY_MPS)
        sigma_rad = min(2.0 * sigma_mps / (self.filter.gravity_mps2 * max(passed_s, _VELOCITIES_S)), _ASTRAY_RAD)
        self.filter.inflate_motion(sigma_mps**2, sigma_rad**2)

    def _unheld(self, t_s: float) -> bool:
        """Whether no velocity holds the estimate."""
        return t_s - self._velocity_s > _VELOCITIES_S

    def _jumps(self, t_s: float, innovation: Innovation, apart_m: float) -> bool:
        """Whether positions have jumped, by less than the gate rejects."""
        if not self._settled:
            return False
        trusted = self._slow_velocity.doubt <= _VELOCITY_DOUBTED_MPS
        self._slow_position.take(t_s, innovation, self._wander.sigma if trusted else None)
        return trusted and apart_m <= POSITION_GATE.always and has_jumped(innovation)

    def _is_back(self, t_s: float, before_m: float) -> bool:
        """Whether positions have jumped back to the boat. Away from it, one of both is right, before or now, and the
        boat stays unsure. `before_m`: how far off they were before."""
        off_m, said_m = math.hypot(*self.filter.wander), self._wander.sigma
        back = before_m > _BACK * said_m and off_m <= max(_BACK * said_m, _BACK_SHARE * before_m)
        if back or off_m > _BACK * said_m:
            self._slow_position.jumped(t_s, 0.0 if back else off_m)
        return back

    @property
    def _settled(self) -> bool:
        """Whether the filter knows its attitude: before, its innovations are its own."""
        return self.odometer.bias_sigma_radps <= SETTLED_RADPS

    def _restarts(self, sense: str) -> bool:
        """Whether this measurement counts alone."""
        if sense not in self._anew:
            return False
        self._anew.discard(sense)
        return True

    def _begins(self, innovation: Innovation) -> bool:
        """Whether the filter has just begun, at a position that came of such measurements: then it begins at this one,
        and knows what it is off by."""
        begun_s, self._begun_s = self._begun_s, None
        lately = begun_s is not None and self.t_s - begun_s < _FIRST_S
        return lately and innovation.normalised_square <= POSITION_GATE.chi_square

    def _by_wander(self, apart_m: float, sigma_m: float) -> bool:
        """Whether the slow error of the receiver explains where it is now. Then the boat has not gone there."""
        return apart_m <= _WANDERS * math.hypot(self._wander.sigma, sigma_m)

    def velocity(
        self,
        t_s: float,
        north_mps: float,
        east_mps: float,
        lever_m: Vector,
        sigma_mps: float,
        rule: Verdict | None = None,
    ) -> Verdict:
        """As `Solution.velocity`."""
        if self.t_s - t_s > LONGEST_S:
            return Verdict.REJECT
        arm, variance = relative(lever_m, self._imu_lever_m), sigma_mps * sigma_mps
        if self.t_s - t_s > _BENT_S:
            since = self.since(t_s, arm)
            north_mps, east_mps = north_mps + since.north_mps, east_mps + since.east_mps
        elif t_s > self.t_s:  # a slow inertial sensor has not come as far
            gn, ge = self.filter.gaining
            north_mps, east_mps = north_mps - (t_s - self.t_s) * gn, east_mps - (t_s - self.t_s) * ge
        innovation = self.filter.velocity_innovation(north_mps, east_mps, arm, variance, lag_s=self.t_s - t_s)
        if self._settled:
            self._slow_velocity.take(t_s, innovation)
        verdict = self._judge("velocity", t_s, self._velocity_gate, innovation, sigma_mps, rule)
        if verdict is not Verdict.REJECT:
            self._velocity_s = t_s
        if verdict is Verdict.RESET:
            self.filter.reset_velocity(north_mps, east_mps, arm, variance)
        return verdict

    def aid(self, north_mps: float, east_mps: float, sigma_mps: float, variance_m2: float = 0.0) -> None:
        """Fuse a modelled velocity of the boat's origin if it passes the gate. It never resets the filter.
        `variance_m2`: by which the position has become less sure meanwhile, on each axis."""
        innovation = self.filter.velocity_innovation(
            north_mps, east_mps, relative(ZERO, self._imu_lever_m), sigma_mps * sigma_mps, late=False
        )
        if innovation.normalised_square <= VELOCITY_GATE.chi_square:
            self.filter.fuse(innovation)
            self._bound_biases()
        self.filter.inflate_position(variance_m2)

    def heading(self, t_s: float, yaw_rad: float, sigma_rad: float, rule: Verdict | None = None) -> Verdict:
        """As `Solution.heading`."""
        lag_s = self.t_s - t_s
        if lag_s > LONGEST_S:
            return Verdict.REJECT
        if lag_s > _BENT_S:
            yaw_rad += self.since(t_s).turned_rad - lag_s * self.filter.rates[2]
        if rule is None and self._restarts("heading"):
            self.filter.reset_heading(yaw_rad + lag_s * self.filter.rates[2], sigma_rad * sigma_rad)
            return Verdict.ACCEPT
        innovation = self.filter.heading_innovation(yaw_rad, sigma_rad * sigma_rad, lag_s)
        if self._settled:
            self._slow_heading.take(t_s, innovation)
        verdict = self._judge("heading", t_s, self._heading_gate, innovation, sigma_rad, rule)
        if verdict is Verdict.RESET:
            self.filter.reset_heading(yaw_rad + lag_s * self.filter.rates[2], sigma_rad * sigma_rad)
        return verdict

    def _judge(
        self,
        sense: str,
        t_s: float,
        gate: InnovationGate,
        innovation: Innovation,
        sigma: float,
        rule: Verdict | None = None,
        drifts: bool = False,
    ) -> Verdict:
        """Fuse the innovation if `rule`, or else the gate, accepts it. Keep the verdict for people."""
        verdict = rule or gate.update(innovation.y1, innovation.y2, innovation.normalised_square, sigma, drifts)
        self.judged[sense] = Judged(
            sense, t_s, innovation.normalised_square, gate.chi_square, verdict is not Verdict.REJECT
        )
        if verdict is Verdict.ACCEPT:
            self.filter.fuse(innovation)
            self._bound_biases()
        return verdict

    def expect_wander(self, wander: Wander, another: bool) -> None:
        """The slow error of positions from now on. `another`: of another receiver."""
        self._wander = self._slow_position.expected(wander, self.t_s)
        self.filter.expect_wander(self._wander, _COMMON if another else 1.0)

    def add_heading_variance(self, variance_rad2: float) -> None:
        """As `Solution.add_heading_variance`."""
        self.filter.inflate_heading(variance_rad2)

    def motion(self, now_s: float, later: Sequence[Imu] = ()) -> Motion:
        """Motion of the boat's origin at `now_s`: predicted by the samples `later` than the filter's, then at constant
        velocity."""
        steps: list[tuple[Vector, Vector, float]] = []
        t_s = self.t_s
        for imu in later:
            if imu.t_s > t_s:
                force = (imu.x_mps2, imu.y_mps2, imu.z_mps2)
                steps.append((force, (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps), imu.t_s - t_s))
                t_s = imu.t_s
        position, velocity, matrix, rates = self.filter.preview(steps)
        arm, swing = rotate(matrix, self._imu_lever_m), velocity_ned(matrix, rates, self._imu_lever_m)
        coast_s = min(max(now_s - t_s, 0.0), _LONGEST_COAST_S)
        vn, ve, vd = relative(velocity, swing)
        roll, pitch, yaw = euler_of(matrix)
        sigma_m, sigma_mps, sigma_rad = self.filter.sigmas()
        doubt_m, doubt_mps, doubt_rad = self.doubts
        doubt_m2, covariance = doubt_m * doubt_m, self.filter.covariance
        return Motion(
            now_s,
            (position[0] - arm[0] + vn * coast_s, position[1] - arm[1] + ve * coast_s, position[2] - arm[2]),
            (vn, ve, vd),
            (roll, pitch, wrap_pi(yaw + rates[2] * coast_s)),
            self.rates,
            math.hypot(sigma_m, doubt_m),
            math.hypot(sigma_mps, doubt_mps),
            math.hypot(sigma_rad, doubt_rad),
            (float(covariance[0, 0]) + doubt_m2, float(covariance[0, 1]), float(covariance[1, 1]) + doubt_m2),
        )

    def _smooth(self, rates: Vector, dt_s: float) -> None:
        bias = self.filter.gyro_bias
        p, q, r = self.rates
        share = 1.0 - math.exp(-dt_s / _RATES_TIME_S)
        self.rates = (
            p + share * (rates[0] - bias[0] - p),
            q + share * (rates[1] - bias[1] - q),
            r + share * (rates[2] - bias[2] - r),
        )

    def _stop_if_diverged(self) -> None:
        """Stop if a number is not finite, and forget the biases."""
        if not self.filter.healthy():
            self.running = False
            self.rates = self.filter.accelerometer_bias = self.filter.gyro_bias = ZERO

    def _bound_biases(self) -> None:
        """Hold the biases within limits: a calibrated sensor does not exceed them, so the filter errs beyond."""
        self.filter.accelerometer_bias = _clipped(self.filter.accelerometer_bias, ACCELEROMETER_BIAS_LIMIT_MPS2)
        self.filter.gyro_bias = _clipped(self.filter.gyro_bias, GYRO_BIAS_LIMIT_RADPS)


def _clipped(vector: Vector, limit: float) -> Vector:
    x, y, z = vector
    if -limit <= x <= limit and -limit <= y <= limit and -limit <= z <= limit:
        return vector
    return max(-limit, min(limit, x)), max(-limit, min(limit, y)), max(-limit, min(limit, z))
