"""Motor check: a short push of each thruster, ahead and astern. The motion tells which thruster it was, which way it
pushes, and whether the compass points ahead. A propeller with a rudder pushes ahead with the blade to either side, too:
the turns tell whether the rudder steers, and which way."""

from __future__ import annotations

import math

from companion.config.devices import ThrusterConfig
from companion.core.actuation import ThrusterCommand
from companion.core.angles import wrap_pi
from companion.core.frames import ned_to_body
from companion.core.setpoint import NEUTRAL_SETPOINT, Setpoint, ThrusterSetpoint
from companion.modes.trial.expectation import Expectation
from companion.modes.trial.manoeuvres.manoeuvre import Begin, Manoeuvre, Scene
from companion.modes.trial.wiring import Fault, Motion, expected_motions, faults, rudder_fault

_FORCE_SHARE, _LEAST_SHARE = 0.6, 0.12  # of the largest thrust
_SETTLE_S = 2.0  # before the first push
_REST_S = 2.0  # between pushes: the thruster stops, and the estimate of the velocity comes to what the receiver says
_LATER_S = 1.6  # of it, after which the velocity is read; with a wrong heading it is wrong before
_LEAST_S, _MOST_S = 2.0, 4.0
_SEEN_MPS = 0.25  # motion that the weakest push should cause
_ENOUGH_MPS = 0.4  # motion beyond which a push is made weaker
_MEAN_S = 0.4  # at the ends of a push, over which the motion is averaged
_LAG_S = 0.6  # of thrusters and estimate
_BLADE_SHARE = 0.7  # of the stop, for the pushes with the rudder to a side
_TURN_NOISE_RADPS = math.radians(0.5)
_SPEED_NOISE = 0.5  # share of the accuracy of the velocity that is left in a difference


class MotorCheck(Manoeuvre):
    """Remembers the motion before a push, by its end and some time later, and that of each push. `faults`: what is
    wrong, once it is done."""

    name = "motor check"
    begins = Begin.HERE
    vital = True

    def __init__(self) -> None:
        self.faults: tuple[Fault, ...] | None = None
        self.observed: tuple[Motion | None, ...] = ()

    def expected_s(self, expectation: Expectation) -> float:
        """A usual boat's."""
        return 25.0

    def start(self, scene: Scene) -> None:
        """From the first thruster."""
        thrusters = scene.config.thrusters
        self.faults = None
        one_s = [math.hypot(*motion) for motion in expected_motions(scene.config, [1.0] * len(thrusters), 1.0)]
        weakest = min((one for i, one in enumerate(one_s) if self._usable(scene, i)), default=1.0)
        self._push_s = min(_MOST_S, max(_LEAST_S, _LAG_S + _SEEN_MPS / max(_FORCE_SHARE * weakest, 1e-6)))
        # no stronger than it must be: at speed the hull itself turns the boat
        enough = _ENOUGH_MPS / (self._push_s - _LAG_S)
        self._shares = [
            min(_FORCE_SHARE, max(_LEAST_SHARE, enough / one)) if self._usable(scene, i) else 0.0
            for i, one in enumerate(one_s)
        ]
        self._pushes = [
            (i, *push) for i, thruster in enumerate(thrusters) if self._shares[i] > 0.0 for push in _pushes_of(thruster)
        ]
        self._first: list[tuple[float, float, float, float]] = []
        self._last: list[tuple[float, float, float, float]] = []
        self._later: list[tuple[float, float, float, float]] = []
        self._found: dict[tuple[int, float, float], Motion] = {}
        self._noise_mps = 0.0

    @staticmethod
    def _usable(scene: Scene, i: int) -> bool:
        return i not in scene.inputs.failed and i not in scene.inputs.up

    def update(self, scene: Scene) -> Setpoint | None:
        """The push of this time; None after the last, when `faults` is known."""
        since_s = scene.t_s - _SETTLE_S
        if since_s < -_MEAN_S:
            return NEUTRAL_SETPOINT
        period_s = self._push_s + _REST_S
        number = int(max(0.0, since_s) // period_s)
        within_s = since_s - number * period_s
        nav = scene.nav
        sample = (nav.north_mps, nav.east_mps, nav.yaw_rad, nav.yaw_rate_radps)
        self._noise_mps = max(self._noise_mps, _SPEED_NOISE * nav.velocity_accuracy_mps)
        if number >= len(self._pushes):
            return self._judged(scene)
        if since_s < 0.0 or within_s >= self._push_s:
            self._later = [*self._later, sample][-max(1, round(_MEAN_S / scene.inputs.dt_s)) :]
            if self._last and within_s >= self._push_s + _LATER_S:
                self._note(number, scene)
        elif within_s > self._push_s - _MEAN_S:
            self._first, self._later = self._first or self._later, []
            self._last.append(sample)
        if not 0.0 <= within_s < self._push_s:
            return NEUTRAL_SETPOINT
        return self._push(scene, *self._pushes[number])

    def _push(self, scene: Scene, index: int, sign: float, blade: float) -> Setpoint:
        commands = []
        for i, thruster in enumerate(scene.config.thrusters):
            throttle = 0.0
            if i == index:
                full_n, most_n = (
                    (thruster.ahead_n, thruster.max_n) if sign > 0.0 else (thruster.astern_n, -thruster.min_n)
                )
                throttle = sign * math.sqrt(min(1.0, self._shares[i] * most_n / full_n))
            angle_rad = blade * _blade_rad(thruster) if i == index else thruster.azimuth_rad
            commands.append(ThrusterCommand(0.0, throttle, angle_rad if thruster.rudder else _rest(thruster)))
        return ThrusterSetpoint(tuple(commands))

    def _note(self, number: int, scene: Scene) -> None:
        """The change of motion in push `number`, in the axes of the heading in its middle: of the yaw rate by its end,
        of the velocity some time later."""
        before, end, later = _mean(self._first), _mean(self._last), _mean(self._later)
        yaw = before[2] + 0.5 * wrap_pi(end[2] - before[2])
        x, y = ned_to_body(later[0] - before[0], later[1] - before[1], yaw)
        turn = 0.5 * scene.expectation.length_m * (end[3] - before[3])
        self._found[self._pushes[number]] = (x, y, turn)
        self._first, self._last = [], []

    def _judged(self, scene: Scene) -> Setpoint | None:
        """The motions of both directions, the second taken with the opposite sign: what wind and current do is the same
        in both."""
        if self.faults is not None:
            return None
        if self._last:
            self._note(len(self._pushes) - 1, scene)
        observed: list[Motion | None] = []
        gusts: list[float] = []
        for i in range(len(scene.config.thrusters)):
            ahead, astern = self._found.get((i, 1.0, 0.0)), self._found.get((i, -1.0, 0.0))
            if ahead is not None and astern is not None:
                x, y, n = (0.5 * (a - b) for a, b in zip(ahead, astern, strict=True))
                observed.append((x, y, n))
                gusts.append(0.5 * (ahead[2] + astern[2]))  # what does not change sign with the push
            else:
                observed.append(ahead)
        self.observed = tuple(observed)
        expected = expected_motions(scene.config, self._shares, self._push_s - _LAG_S)
        gust = math.sqrt(sum(one * one for one in gusts) / len(gusts)) if gusts else 0.0
        found = faults(scene.config, expected, observed, self._noise_mps, gust)
        self.faults = (*found, *(self._rudder_faults(scene, gust) if not found else ()))
        return None

    def _rudder_faults(self, scene: Scene, gust: float) -> list[Fault]:
        """What the pushes with the blade to either side say."""
        config, found = scene.config, []
        half_m = 0.5 * scene.expectation.length_m
        noise_radps = math.hypot(gust / half_m, _TURN_NOISE_RADPS)
        for i, thruster in enumerate(config.thrusters):
            one, other = self._found.get((i, 1.0, 1.0)), self._found.get((i, 1.0, -1.0))
            if thruster.rudder is None or thruster.propeller_m is None or one is None or other is None:
                continue
            share = thruster.rudder.side_share(_blade_rad(thruster), thruster.propeller_m)
            side_n = share * self._shares[i] * thruster.max_n
            expected = 2.0 * thruster.rudder.x_m * side_n * (self._push_s - _LAG_S) / config.hull.m33_kgm2
            fault = rudder_fault(thruster.name, (one[2] - other[2]) / half_m, expected, noise_radps)
            found += [] if fault is None else [fault]
        return found


def _pushes_of(thruster: ThrusterConfig) -> list[tuple[float, float]]:
    """(ahead or astern, side of the blade) of each push of one thruster."""
    straight = [(1.0, 0.0), (-1.0, 0.0)] if thruster.min_n < 0.0 else [(1.0, 0.0)]
    return [*straight, (1.0, 1.0), (1.0, -1.0)] if thruster.rudder is not None else straight


def _blade_rad(thruster: ThrusterConfig) -> float:
    """The angle of the blade in the pushes to a side."""
    return _BLADE_SHARE * min(abs(thruster.azimuth_min_rad or 0.0), abs(thruster.azimuth_max_rad or 0.0))


def _rest(thruster: ThrusterConfig) -> float | None:
    return thruster.azimuth_rad if thruster.turns else None


def _mean(samples: list[tuple[float, float, float, float]]) -> tuple[float, float, float, float]:
    """Mean of velocities, heading and yaw rate."""
    count = len(samples)
    yaw = samples[0][2] + sum(wrap_pi(sample[2] - samples[0][2]) for sample in samples) / count
    north, east, turn = (sum(sample[k] for sample in samples) / count for k in (0, 1, 3))
    return north, east, yaw, turn
