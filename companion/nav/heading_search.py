"""Heading of a boat that has no compass, or has lost it: by its motion.

A bank of filters runs, each begun at another heading. The boat's accelerations, as its inertial sensor feels them, turn
with the heading into velocities; the filters whose heading is right predict what the receiver measures. The waves, or
a push ahead and astern, are enough. A boat that lies still tells nothing.

Source: Magill (1965), *Optimal adaptive estimation of sampled stochastic processes* (a bank of Kalman filters, weighed
by the likelihood of their innovations); Bar-Shalom, Li & Kirubarajan (2001), 11.6.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.angles import wrap_pi
from companion.core.readings import GroundVelocity, Imu
from companion.nav.error_state import ErrorStateFilter, Innovation
from companion.nav.inertial import InertialSolution
from companion.nav.lever_arms import Vector, relative
from companion.nav.outliers import VELOCITY_GATE
from companion.nav.validity import HEADING_COAST_RAD

_HYPOTHESES = 8
_SILENT_S = 2.0  # without a heading, before the search begins
_PERIOD_S = 0.19  # velocities come 5 times a second at most: their errors last
_VELOCITY_FACTOR = 1.5  # they count as that much noisier, since what is left of their errors is correlated
_LEAST_SIGMA_MPS = 0.02
_FOUND_RAD = 0.9 * HEADING_COAST_RAD  # the gyro may carry it from there
_LOST_RAD = math.radians(30.0)  # a filter that is less sure of its heading cannot find it by itself
_LEAST_WEIGHT = 1e-4
_LONGEST_GAP_S = 0.5  # of the samples
_LONGEST_SILENCE_S = 5.0  # of the velocities
_REJECTIONS = 20  # in a row, by all filters: the search begins anew
_DOWN_PERIOD_S = 0.2
_DOWN_VARIANCE = 0.3**2  # m² and (m/s)²: a boat stays on the water


def is_lost(yaw_sigma_rad: float) -> bool:
    """Whether a heading of that sigma must be searched for."""
    return yaw_sigma_rad > _LOST_RAD


class HeadingSearch:
    """Inertial samples and velocities → a filter that knows the heading.

    Call `heard` for each heading, `look` for each velocity that `is_due`, and `sample` while it runs, in the order of
    time. Remembers the filters with their weights, and since when there has been no heading.
    """

    def __init__(self) -> None:
        self._silent_since_s: float | None = None
        self._t_s = self._velocity_s = self._down_s = -math.inf
        self._filters: list[ErrorStateFilter] = []
        self._weights: list[float] = []
        self._rejections = 0

    @property
    def runs(self) -> bool:
        """Whether filters run."""
        return bool(self._filters)

    def heard(self, t_s: float) -> None:
        """There is a heading, or nothing to search with."""
        self._silent_since_s = t_s
        self._filters = []

    def sample(self, imu: Imu) -> None:
        """Take one inertial sample."""
        dt_s = imu.t_s - self._t_s
        if dt_s <= 0.0:
            return
        self._t_s = imu.t_s
        if dt_s > _LONGEST_GAP_S:
            self._filters = []
            return
        force = imu.x_mps2, imu.y_mps2, imu.z_mps2
        rates = imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps
        level = imu.t_s - self._down_s >= _DOWN_PERIOD_S
        for one in self._filters:
            one.predict(force, rates, dt_s)
            if level:
                one.fuse_down(0.0, _DOWN_VARIANCE, _DOWN_VARIANCE)
        if level:
            self._down_s = imu.t_s

    def is_due(self, t_s: float) -> bool:
        """Whether a velocity of that time is wanted: there has been no heading for a while."""
        if self._silent_since_s is None:
            self._silent_since_s = t_s
        return t_s - self._silent_since_s > _SILENT_S and t_s - self._velocity_s >= _PERIOD_S

    def look(
        self,
        velocity: GroundVelocity,
        lever_m: Vector,
        sigma_mps: float,
        inertial: InertialSolution,
        yaw_sigma_rad: float,
    ) -> ErrorStateFilter | None:
        """Take a velocity over ground of a receiver at `lever_m` (body axes), and begin where the heading, of
        `yaw_sigma_rad`, is lost. Returns the filter that has found it; its position means nothing."""
        if not inertial.feels:
            self.heard(velocity.t_s)
            return None
        if not self._filters:
            tilt = inertial.tilt()
            if not is_lost(yaw_sigma_rad) or tilt is None:
                return None
            speed_mps = math.hypot(velocity.north_mps, velocity.east_mps)
            self._begin(inertial.t_s, tilt, inertial.levelling.sigma_rad(speed_mps), inertial.filter)
        return self._weigh(velocity, relative(lever_m, inertial.lever_m), sigma_mps)

    def _begin(self, t_s: float, tilt: tuple[float, float], tilt_sigma_rad: float, known: ErrorStateFilter) -> None:
        """Begin with every heading at the next velocity.

        `t_s`: of the last sample; `tilt`: (roll_rad, pitch_rad); `known`: a filter that has the noise and the biases of
        the sensor.
        """
        spacing, noise = math.tau / _HYPOTHESES, known.noise
        sigmas = [1.0] * 6 + [tilt_sigma_rad, tilt_sigma_rad, 0.5 * spacing]
        sigmas += [noise.accelerometer_switch_on_mps2] * 3 + [noise.gyro_switch_on_radps] * 3
        self._filters = [ErrorStateFilter(known.gravity_mps2, noise) for _ in range(_HYPOTHESES)]
        for k, one in enumerate(self._filters):
            one.start((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (*tilt, wrap_pi(k * spacing)), sigmas)
            one.accelerometer_bias, one.gyro_bias = known.accelerometer_bias, known.gyro_bias
        self._weights = [1.0 / _HYPOTHESES] * _HYPOTHESES
        self._rejections, self._t_s, self._velocity_s = 0, t_s, -math.inf

    def _weigh(self, velocity: GroundVelocity, lever_m: Vector, sigma_mps: float) -> ErrorStateFilter | None:
        """Take a velocity of the point `lever_m` (body axes) from the inertial sensor. Returns the filter with the
        right heading, once that is known."""
        t_s, north_mps, east_mps = velocity.t_s, velocity.north_mps, velocity.east_mps
        if self._velocity_s == -math.inf or t_s - self._velocity_s > _LONGEST_SILENCE_S:
            for one in self._filters:
                one.reset_velocity(north_mps, east_mps, lever_m, (_VELOCITY_FACTOR * sigma_mps) ** 2)
            self._velocity_s = t_s
            return None
        self._velocity_s = t_s
        variance = (_VELOCITY_FACTOR * max(sigma_mps, _LEAST_SIGMA_MPS)) ** 2
        found = [one.velocity_innovation(north_mps, east_mps, lever_m, variance) for one in self._filters]
        if min(innovation.normalised_square for innovation in found) > VELOCITY_GATE.chi_square:
            self._reject()
            return None
        self._rejections = 0
        self._weights = _weighed(self._weights, found)
        for one, innovation in zip(self._filters, found, strict=True):
            one.fuse(innovation)
        if self._sigma_rad() > _FOUND_RAD:
            return None
        return self._filters[max(range(_HYPOTHESES), key=self._weights.__getitem__)]

    def _reject(self) -> None:
        """No filter could predict the velocity."""
        self._rejections += 1
        if self._rejections > _REJECTIONS:
            self._filters = []

    def _sigma_rad(self) -> float:
        """One sigma of the heading by all filters together: what each is unsure of, and how far they are apart."""
        weights, yaws = self._weights, [one.euler()[2] for one in self._filters]
        north = sum(weight * math.cos(yaw) for weight, yaw in zip(weights, yaws, strict=True))
        east = sum(weight * math.sin(yaw) for weight, yaw in zip(weights, yaws, strict=True))
        mean = math.atan2(east, north)
        variance = 0.0
        for weight, yaw, one in zip(weights, yaws, self._filters, strict=True):
            variance += weight * (one.sigmas()[2] ** 2 + wrap_pi(yaw - mean) ** 2)
        return math.sqrt(variance)


def _weighed(weights: Sequence[float], found: Sequence[Innovation]) -> list[float]:
    """The weights after innovations: times the likelihood of each, with sum 1. None falls so low that it could not rise
    again."""
    logs = [-0.5 * (one.normalised_square + math.log(one.s11 * one.s22 - one.s12 * one.s12)) for one in found]
    largest = max(logs)
    likely = [weight * math.exp(log - largest) for weight, log in zip(weights, logs, strict=True)]
    total = sum(likely)
    kept = [max(value / total, _LEAST_WEIGHT) for value in likely]
    return [value / sum(kept) for value in kept]
