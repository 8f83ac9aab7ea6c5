"""Navigation without inertial sensors: positions, headings and velocities are low-pass filtered and differenced.

Source: a fading-memory filter of first degree (Morrison 1969; Brookner 1998, chapter 1): with θ = exp(−Δt/τ), the
share 1 − θ² of an innovation goes into the value, and (1 − θ)²/Δt of it into the rate.
"""

from __future__ import annotations

import math

from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned
from companion.nav.lever_arms import Vector
from companion.nav.outliers import HEADING_GATE, POSITION_GATE, VELOCITY_GATE, FirstWay, InnovationGate, Verdict
from companion.nav.solution import Motion, Offset, Place

_UNKNOWN_M = 1000.0  # one sigma, before there is a position
_TIME_S = 0.5
_TIME_SIGMA_M = 0.05  # noisier positions are smoothed longer, in proportion to the square root of their sigma
_TIME_LONGEST_S = 4.0
_VELOCITY_TIME_S = 0.5  # of a boat that does not turn; a velocity that may change is smoothed less
_VELOCITY_STEADY_MPS2 = 0.5
_VELOCITY_FRESH_S = 1.0  # measured velocities are used instead of differences while they come
_FIRST_STEP_S = 1.0  # a gap longer than this gives no new rate
_ACCELERATION_MPS2 = 0.3  # unmeasured acceleration of the boat
_SLOW_MPS, _TURN_RADPS = 0.5, 0.5  # a faster boat may turn that hard, which changes its velocity by speed times rate
_YAW_ACCELERATION_RADPS2 = 0.1
_ROUGH = 3.0  # sigmas of a heading, beyond which the one before it counts for nothing
_NOISE = 2.0  # sigmas of a velocity, up to which it is noise by which it differs
_BEHIND_MOST_RAD = 0.12  # a course of 15° stays usable until the next one, a second later
_RATES_FADE_S = 5.0  # time constant with which the rates decay without measurements
_AT_REST = FirstWay(0.0, 0.0, 0.5)


class PoseSolution:
    """A `Solution` from pose measurements alone; roll and pitch are 0.

    Remembers position, velocity, heading and yaw rate, each with the time of its last measurement, and by how much the
    velocity still differs from the last one that was measured: a boat that gathers way leaves it behind.
    """

    def __init__(self) -> None:
        self._t_s = self._position_t_s = self._yaw_t_s = self._velocity_t_s = -math.inf
        self._north = self._east = self._vn = self._ve = self._yaw = self._rate = 0.0
        self._sigma_m, self._sigma_mps, self._sigma_rad = 0.0, _AT_REST.sigma_mps, math.pi
        self.behind_mps = 0.0
        self._begun_s, self._first_mps = -math.inf, 0.0  # of a velocity that only the first positions have told
        # one sigma of heading and rate, by a rate of turn that was not known when the heading began
        self._behind_rad = self._behind_radps = 0.0
        self._position_gate = InnovationGate(POSITION_GATE)
        self._velocity_gate = InnovationGate(VELOCITY_GATE)
        self._heading_gate = InnovationGate(HEADING_GATE)

    @property
    def started(self) -> bool:
        """Whether there is a position."""
        return self._t_s > -math.inf

    @property
    def oriented(self) -> bool:
        """Whether there is a heading."""
        return self._yaw_t_s > -math.inf

    def continue_from(self, motion: Motion) -> None:
        """Continue from another solution's motion."""
        self._t_s = self._position_t_s = self._yaw_t_s = motion.t_s
        self._velocity_t_s = -math.inf
        (self._north, self._east, _), (self._vn, self._ve, _) = motion.position, motion.velocity
        self._yaw, self._rate = motion.attitude[2], motion.rates[2]
        self._sigma_m, self._sigma_mps, self._first_mps = motion.position_sigma_m, motion.velocity_sigma_mps, 0.0
        self._sigma_rad, self._behind_rad, self._behind_radps = motion.yaw_sigma_rad, 0.0, 0.0
        self.behind_mps = 0.0

    def begin(
        self, t_s: float, north_m: float, east_m: float, lever_m: Vector, sigma_m: float, way: FirstWay = _AT_REST
    ) -> None:
        """Start at the first position, with the velocity that it was reached by."""
        self._t_s = self._position_t_s = self._begun_s = t_s
        self._vn, self._ve, self._sigma_mps = way
        self._first_mps = way.sigma_mps
        self._set_position(north_m, east_m, lever_m, sigma_m)

    def position(
        self, t_s: float, north_m: float, east_m: float, lever_m: Vector, sigma_m: float, rule: Verdict | None = None
    ) -> Verdict:
        """As `Solution.position`."""
        ahead_s = t_s - self._t_s
        fade = self._fading(max(ahead_s, 0.0))
        arm_n, arm_e = body_to_ned(lever_m[0], lever_m[1], self._yaw_at(t_s))
        dn = north_m - arm_n - self._north - self._vn * fade
        de = east_m - arm_e - self._east - self._ve * fade
        turn_m = 0.5 * self._turning_mps2 * min(max(ahead_s, 0.0), _FIRST_STEP_S) ** 2
        sigma = math.hypot(sigma_m, self._position_sigma(ahead_s) + turn_m)
        verdict = rule or self._position_gate.update(dn, de, (dn * dn + de * de) / (sigma * sigma), sigma_m)
        if verdict is Verdict.RESET:
            self._set_position(north_m, east_m, lever_m, sigma_m)
        elif verdict is Verdict.ACCEPT and t_s > self._position_t_s:
            self._advance(t_s)
            self._blend(t_s, dn, de, sigma_m)
        if verdict is not Verdict.REJECT:
            self._t_s, self._position_t_s = max(t_s, self._t_s), max(t_s, self._position_t_s)
        return verdict

    def _advance(self, t_s: float) -> None:
        """Predict the position up to `t_s`."""
        ahead_s = t_s - self._t_s
        if ahead_s > 0.0:
            fade = self._fading(ahead_s)
            self._sigma_m = self._position_sigma(ahead_s)
            self._north += self._vn * fade
            self._east += self._ve * fade
            self._t_s = t_s

    def _blend(self, t_s: float, dn: float, de: float, sigma_m: float) -> None:
        dt = t_s - self._position_t_s
        time_s = min(_TIME_S * math.sqrt(max(sigma_m / _TIME_SIGMA_M, 1.0)), _TIME_LONGEST_S)
        theta = math.exp(-dt / time_s)
        gain = 1.0 - theta * theta
        self._north += gain * dn
        self._east += gain * de
        self._sigma_m = sigma_m * math.sqrt(gain)
        if t_s - self._velocity_t_s > _VELOCITY_FRESH_S and dt <= max(_FIRST_STEP_S, time_s):
            rate_gain = (1.0 - theta) ** 2 / dt
            self._vn += rate_gain * dn
            self._ve += rate_gain * de
            self._sigma_mps = math.hypot(max(sigma_m / time_s, 0.02), self._left_mps(t_s, max(time_s, dt)))

    def _left_mps(self, t_s: float, time_s: float) -> float:
        """One sigma of what is left in the velocity of what it began with: the filter forgets that with its two equal
        time constants."""
        passed = (t_s - self._begun_s) / time_s
        return self._first_mps * (1.0 + passed) * math.exp(-passed) if self._first_mps > 0.0 else 0.0

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
        arm_n, arm_e = body_to_ned(-self._rate * lever_m[1], self._rate * lever_m[0], self._yaw_at(t_s))
        dn, de = north_mps - arm_n - self._vn, east_mps - arm_e - self._ve
        gap_s = min(max(t_s - self._velocity_t_s, 0.0), 10.0)
        turning_mps2 = self._turning_mps2
        sigma_mps = math.hypot(sigma_mps, math.hypot(lever_m[0], lever_m[1]) * self._behind_radps)
        sigma = math.hypot(sigma_mps, self._sigma_mps + (_ACCELERATION_MPS2 + turning_mps2) * gap_s)
        verdict = rule or self._velocity_gate.update(dn, de, (dn * dn + de * de) / (sigma * sigma), sigma_mps)
        share = 0.0
        if verdict is not Verdict.REJECT:
            self._advance(t_s)
            time_s = _VELOCITY_TIME_S / (1.0 + turning_mps2 / _VELOCITY_STEADY_MPS2)
            share = 1.0 if verdict is Verdict.RESET else 1.0 - math.exp(-gap_s / time_s)
            self._vn += share * dn
            self._ve += share * de
            self._sigma_mps = math.hypot(sigma_mps, 0.5 * turning_mps2 * time_s)
            self._velocity_t_s, self._first_mps = t_s, 0.0
        if rule is not Verdict.REJECT:  # one that lies tells nothing
            behind_mps = (1.0 - share) * math.hypot(dn, de)
            self.behind_mps = behind_mps if behind_mps > _NOISE * sigma_mps else 0.0
        return verdict

    def heading(self, t_s: float, yaw_rad: float, sigma_rad: float, rule: Verdict | None = None) -> Verdict:
        """As `Solution.heading`; the first heading gives RESET."""
        if not self.oriented:
            self._begin_heading(t_s, yaw_rad, sigma_rad)
            return Verdict.RESET
        dt = t_s - self._yaw_t_s
        error = wrap_pi(yaw_rad - self._yaw_at(t_s))
        sigma = math.hypot(sigma_rad, self._yaw_sigma(dt) + _unfollowed_rad(dt))
        verdict = rule or self._heading_gate.update(error, 0.0, error * error / (sigma * sigma), sigma_rad)
        if verdict is Verdict.REJECT or dt < 0.0 or (dt == 0.0 and verdict is Verdict.ACCEPT):
            return verdict
        if verdict is Verdict.RESET or self._sigma_rad > _ROUGH * sigma_rad:
            self._begin_heading(t_s, yaw_rad, sigma_rad)
            return verdict
        theta = math.exp(-dt / _TIME_S)
        self._yaw = wrap_pi(self._yaw_at(t_s) + (1.0 - theta * theta) * error)
        behind_rad = self._behind(dt)
        self._behind_rad = theta * theta * behind_rad
        if dt <= _FIRST_STEP_S:
            rate_gain = (1.0 - theta) ** 2 / dt
            self._rate += rate_gain * error
            self._behind_radps -= rate_gain * behind_rad
        self._yaw_t_s, self._sigma_rad = t_s, sigma_rad
        return verdict

    def _begin_heading(self, t_s: float, yaw_rad: float, sigma_rad: float) -> None:
        """Begin at a heading: at the first, and where the one before is worth nothing beside it."""
        self._yaw, self._rate, self._yaw_t_s = yaw_rad, 0.0, t_s
        self._sigma_rad, self._behind_rad, self._behind_radps = sigma_rad, 0.0, _TURN_RADPS

    def _behind(self, gap_s: float) -> float:
        """One sigma of what the heading lags by, that long after the last one."""
        return min(self._behind_rad + self._behind_radps * self._fading(gap_s), _BEHIND_MOST_RAD)

    @property
    def _turning_mps2(self) -> float:
        """By what the boat's velocity may change in a turn."""
        return _TURN_RADPS * max(math.hypot(self._vn, self._ve) - _SLOW_MPS, 0.0)

    def place(self, t_s: float) -> Place:
        """As `Solution.place`."""
        fade = self._fading(max(t_s - self._t_s, 0.0)) if self.started else 0.0
        sigma_m = self._position_sigma(t_s - self._t_s) if self.started else 0.0
        north, east = self._north + self._vn * fade, self._east + self._ve * fade
        return Place(north, east, self._vn, self._ve, self._yaw_at(t_s), sigma_m)

    def offset(self, lever_m: Vector) -> Offset:
        """As `Solution.offset`."""
        north, east = body_to_ned(lever_m[0], lever_m[1], self._yaw)
        return Offset(north, east, -self._rate * east, self._rate * north)

    def add_position_variance(self, variance_m2: float) -> None:
        """Add to the variance of the position: it still holds the slow error of a worse fix."""
        self._sigma_m = math.hypot(self._sigma_m, math.sqrt(variance_m2))

    def add_heading_variance(self, variance_rad2: float) -> None:
        """As `Solution.add_heading_variance`."""
        self._sigma_rad = math.hypot(self._sigma_rad, math.sqrt(variance_rad2))

    def motion(self, now_s: float) -> Motion:
        """As `Solution.motion`."""
        dt = max(now_s - self._t_s, 0.0) if self.started else 0.0
        fade, left = self._fading(dt), math.exp(-dt / _RATES_FADE_S)
        yaw_gap_s = max(now_s - self._yaw_t_s, 0.0) if self.oriented else 0.0
        return Motion(
            now_s,
            (self._north + self._vn * fade, self._east + self._ve * fade, 0.0),
            (self._vn * left, self._ve * left, 0.0),
            (0.0, 0.0, self._yaw_at(now_s)),
            (0.0, 0.0, self._rate * math.exp(-yaw_gap_s / _RATES_FADE_S)),
            self._position_sigma(dt) if self.started else _UNKNOWN_M,
            math.hypot(self._sigma_mps + _ACCELERATION_MPS2 * min(dt, 10.0), self.behind_mps),
            min(self._yaw_sigma(yaw_gap_s), math.pi),
        )

    def _set_position(self, north_m: float, east_m: float, lever_m: Vector, sigma_m: float) -> None:
        arm_n, arm_e = body_to_ned(lever_m[0], lever_m[1], self._yaw)
        self._north, self._east, self._sigma_m = north_m - arm_n, east_m - arm_e, sigma_m

    def _yaw_at(self, t_s: float) -> float:
        return wrap_pi(self._yaw + self._rate * self._fading(max(t_s - self._yaw_t_s, 0.0))) if self.oriented else 0.0

    def _position_sigma(self, dt_s: float) -> float:
        gap_s = min(max(dt_s, 0.0), 60.0)
        return self._sigma_m + self._sigma_mps * gap_s + 0.5 * _ACCELERATION_MPS2 * gap_s * gap_s

    def _yaw_sigma(self, dt_s: float) -> float:
        gap_s = min(max(dt_s, 0.0), 60.0)
        sigma_rad = math.hypot(self._sigma_rad, self._behind(gap_s))
        return sigma_rad + 0.5 * _YAW_ACCELERATION_RADPS2 * gap_s * gap_s

    @staticmethod
    def _fading(dt_s: float) -> float:
        """The time in which a constant rate covers what a decaying rate covers in `dt_s`."""
        return _RATES_FADE_S * (1.0 - math.exp(-dt_s / _RATES_FADE_S))


def _unfollowed_rad(gap_s: float) -> float:
    """One sigma of what heading and rate lag by in a turn that begins or ends, `gap_s` after the last heading: the
    filter follows an angular acceleration by its time squared, and the rate by twice its time."""
    return _YAW_ACCELERATION_RADPS2 * _TIME_S * (_TIME_S + 2.0 * min(max(gap_s, 0.0), 60.0))
