"""How late the values of the receiver in use are, beyond what its row says.

The filter holds it as a state and allows for it from the start. It is found here without what the filter has made of
late values: the gyro tells it from the receiver's headings in turns (`turn_latency.py`), gyro and accelerometers from
its velocities where the boat turns or gathers way (`velocity_latency.py`). What has come out twice is told, and goes
over from the filter's state to the times of the readings without a jump of the estimate. Where the filter agrees, its
figure is the better one; where it does not, the latency has changed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.nav.inertial import InertialSolution
from companion.nav.lever_arms import Vector, relative
from companion.nav.turn_latency import TurnLatency
from companion.nav.velocity_latency import VelocityLatency

_LEAST_S, _MOST_S = 0.04, 0.5  # a smaller one is left as it is; a larger one is no latency
_SURE_S = 0.05  # one sigma: one that headings tell no better is left as it is
_CHANGED_S = 0.1  # the same, at least, of one that has changed under way
_SUREST_S = 1e-3  # no latency is told better, even where nothing is left by chance
_HELD_SURE_S = 0.015  # the same, of what the filter has
_SIGMAS, _SIGMAS_AGAIN = 5.0, 3.0  # of what velocities tell, to count the first time, and when it agrees with that
_AGREES, _AGREES_SIGMAS = 0.25, 3.0  # by which it may differ the second time
_DOUBTED_S, _AGAIN_S = 10.0, 60.0  # a latency that was seen once is in doubt for so long, and not again before
_SETTLES_S = 2.0  # after one has gone over
_JOIN_SPS = 0.1  # s/s, with which it goes over to the readings: a boat at 3 m/s is moved by 0.3 m/s


@dataclass(frozen=True, slots=True)
class LatencyFound:
    """The values of the receiver `source` are `late_s` later than its row says; `sigma_s`: one sigma."""

    source: str
    late_s: float
    sigma_s: float

    def text(self, told_s: float) -> str:
        """For people, with the latency that the file says."""
        return f"{self.source} is {told_s + self.late_s:.2f} s late: the file says {told_s:.2f}"

    def agrees(self, before: LatencyFound) -> bool:
        """Whether it comes to the same as before."""
        reach_s = _AGREES * abs(before.late_s) + _AGREES_SIGMAS * math.hypot(before.sigma_s, self.sigma_s)
        return abs(self.late_s - before.late_s) <= reach_s

    def joined(self, before: LatencyFound) -> LatencyFound:
        """The mean of both, by their variances."""
        here, there = self.sigma_s**-2, before.sigma_s**-2
        late_s = (here * self.late_s + there * before.late_s) / (here + there)
        return LatencyFound(self.source, late_s, (here + there) ** -0.5)


@dataclass(slots=True)
class _Receiver:
    """`late_s`: what has gone over to its readings, `coming_s`: what is still to. `once`: what has been seen once,
    `once_s`: when. `settled_s`: when all had gone over, and the estimate with it."""

    late_s: float = 0.0
    coming_s: float = 0.0
    once: LatencyFound | None = None
    once_s: float = -math.inf
    settled_s: float = -math.inf


class ReceiverLatency:
    """Call `heading` and `velocity` for each one of the receiver in use, and `update` once a tick. Remembers of each
    receiver what was found, the receiver and the run of the filter that it watches, and the time."""

    def __init__(self) -> None:
        self._receivers: dict[str, _Receiver] = {}
        self._watched = ("", -1)
        self._t_s = 0.0
        self._turn, self._velocity = TurnLatency(), VelocityLatency()

    def late_s(self, source: str) -> float:
        """By how much the values of a receiver are later than its row says."""
        receiver = self._receivers.get(source)
        return 0.0 if receiver is None else receiver.late_s

    def unsettled(self, source: str | None) -> bool:
        """Whether the times of a receiver's values are in doubt, or change just now: what seems to lie may be late."""
        receiver = self._receivers.get(source) if source is not None else None
        if receiver is None:
            return False
        return self._t_s < receiver.settled_s or self._t_s - receiver.once_s < _DOUBTED_S

    def heading(self, inertial: InertialSolution, t_s: float, yaw_rad: float) -> None:
        """Take a heading of the receiver in use, whether it is used or not: one that lags seems to drift in a turn."""
        turn_radps = inertial.filter.turn_radps
        turned_rad = inertial.odometer.turned_rad - inertial.since(t_s).turned_rad
        self._turn.take(t_s, yaw_rad - turned_rad, turn_radps)

    def velocity(self, inertial: InertialSolution, t_s: float, velocity: tuple[float, float], lever_m: Vector) -> None:
        """Take a velocity of the antenna at `lever_m` of the receiver in use, whether it is used or not."""
        arm = relative(lever_m, inertial.lever_m)
        swing, since = inertial.offset(arm), inertial.since(t_s, arm)
        then = swing.north_mps - since.north_mps, swing.east_mps - since.east_mps
        self._velocity.take(t_s, velocity, inertial.lanes, then)

    def update(self, inertial: InertialSolution, source: str) -> LatencyFound | None:
        """Returns what is found anew of the receiver in use; nothing where its file tells the latency exactly."""
        if inertial.filter.late_sigma_s() == 0.0:
            return None
        receiver = self._receivers.get(source)
        if receiver is None:
            receiver = self._receivers[source] = _Receiver()
        self._join(inertial, receiver, self._watch(inertial, source))
        found = self._found(source, receiver)
        before = receiver.once
        if found is None:
            self._refute(receiver)
            return None
        self._begin()
        if before is None or not found.agrees(before):
            receiver.once = found
            held = _held(inertial, receiver, found)
            if not held.agrees(found):
                inertial.filter.doubt_late(found.late_s - held.late_s)
            if self._t_s - receiver.once_s >= _AGAIN_S:
                receiver.once_s = self._t_s
            return None
        judged = self._judge(inertial, receiver, found.joined(before))
        if judged is None:
            return None
        receiver.once, found = None, judged
        receiver.coming_s = found.late_s - receiver.late_s
        receiver.once_s = -math.inf
        receiver.settled_s = self._t_s + abs(receiver.coming_s) / _JOIN_SPS + _SETTLES_S
        return found

    @staticmethod
    def _judge(inertial: InertialSolution, receiver: _Receiver, found: LatencyFound) -> LatencyFound | None:
        """What is found, or what the filter has of it where both agree; None while that is not sure enough."""
        held = _held(inertial, receiver, found)
        if not held.agrees(found):
            inertial.filter.learn_late(found.late_s - receiver.late_s, max(found.sigma_s, _CHANGED_S))
            inertial.begin_anew()  # it holds what turns and starts have made of values that were late
            return found
        return held if held.sigma_s <= _HELD_SURE_S else None

    def _watch(self, inertial: InertialSolution, source: str) -> float:
        """Begin anew with another receiver, or another run of the filter. Returns the time since the last update, s."""
        t_s, watched = inertial.t_s, (source, inertial.odometer.run)
        if watched != self._watched:
            self._watched, self._t_s = watched, t_s
            self._begin()
        passed_s, self._t_s = max(t_s - self._t_s, 0.0), t_s
        return passed_s

    def _begin(self) -> None:
        """Look anew, at what comes from now on."""
        self._turn.begin()
        self._velocity.begin()

    def _found(self, source: str, receiver: _Receiver) -> LatencyFound | None:
        by_headings = self._told(source, receiver, self._turn.latency_s())
        if by_headings is not None and by_headings.sigma_s <= _SURE_S:
            return by_headings
        return self._told(source, receiver, self._velocity.latency_s(), receiver.once)

    def _refute(self, receiver: _Receiver) -> None:
        """Forget what has been seen once, where it should have shown again and has not."""
        once, latency = receiver.once, self._velocity.latency_s() or self._turn.latency_s()
        if once is None or latency is None:
            return
        apart_s = abs(once.late_s - receiver.late_s - latency[0])
        if apart_s > _SIGMAS * math.hypot(once.sigma_s, latency[1]):
            receiver.once = None

    @staticmethod
    def _told(
        source: str, receiver: _Receiver, latency: tuple[float, float] | None, once: LatencyFound | None = None
    ) -> LatencyFound | None:
        """What a latency and its sigma come to, where they tell anything. `once`: what it may confirm."""
        if latency is None:
            return None
        latency_s, sigma_s = latency
        sigma_s = max(sigma_s, _SUREST_S)
        found = LatencyFound(source, receiver.late_s + latency_s, sigma_s)
        sigmas = _SIGMAS if once is None or not found.agrees(once) else _SIGMAS_AGAIN
        tells = abs(latency_s) >= max(_LEAST_S, sigmas * sigma_s)
        return found if tells and abs(found.late_s) <= _MOST_S else None

    def _join(self, inertial: InertialSolution, receiver: _Receiver, passed_s: float) -> None:
        """Let a latency go over from the filter's estimate of it to the readings' times."""
        if receiver.coming_s == 0.0:
            return
        step_s = max(-_JOIN_SPS * passed_s, min(_JOIN_SPS * passed_s, receiver.coming_s))
        receiver.late_s += step_s
        receiver.coming_s -= step_s
        inertial.filter.late_s -= step_s
        if receiver.coming_s == 0.0:
            inertial.forget_jump()
        self._begin()


def _held(inertial: InertialSolution, receiver: _Receiver, found: LatencyFound) -> LatencyFound:
    """What the filter has of a latency that was found."""
    filter_ = inertial.filter
    return LatencyFound(found.source, receiver.late_s + filter_.late_s, filter_.late_sigma_s())
