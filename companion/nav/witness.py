"""Each reading set against the estimate, for the integrity monitor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TypeGuard

from companion.core.angles import wrap_pi
from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.plausible_time import is_plausible, year_of
from companion.core.readings import GnssFix, GroundVelocity, Heading, Imu, MagneticField, TimeOfDay, Wind
from companion.nav.current import CurrentObserver
from companion.nav.headings import Measured
from companion.nav.inertial import InertialSolution
from companion.nav.integrity.evidence import (
    SETTLED_RADPS,
    Evidence,
    HeadingSeen,
    InertialStep,
    InertialWay,
    LaneStep,
    LieFound,
    ModelStep,
    PositionSeen,
    Sense,
    VelocitySeen,
)
from companion.nav.integrity.monitor import IntegrityMonitor
from companion.nav.lever_arms import Vector
from companion.nav.no_imu import PoseSolution
from companion.nav.outliers import Verdict
from companion.nav.solution import Motion
from companion.params.store import Parameters

_CHANGED_S = 3.0  # after a change of what carries the estimate
_ALMANAC_S = 60.0  # how long a receiver may have a wrong time after it was switched on
_FRESH_S = 0.15  # age of the last inertial sample up to which its sums hold for a reading


class Witness:
    """Call a method for each reading, before it is used, and `conclude` once a tick. Remembers the evidence of the
    present tick, and since when the inertial sensor carries the estimate or not."""

    def __init__(
        self, parameters: Parameters, say: Announce, levers_m: Mapping[str, Vector] = MappingProxyType({})
    ) -> None:
        """`levers_m`: where sensors sit, from the boat's origin."""
        self.monitor = IntegrityMonitor(parameters, say)
        self._levers_m = levers_m
        self._say = say
        self._evidence = Evidence()
        self._carried = False  # by the inertial sensor
        self._changed_s = -math.inf  # when that changed
        self._dated: set[str] = set()  # receivers that have told a time that can be
        self._implausible_s: dict[str, float] = {}  # by receiver: since when its time cannot be; infinite once told

    def trusts(self, sense: Sense, source: str) -> bool:
        """Whether that sense of that source is used."""
        return self.monitor.trusts(sense, source)

    def raw(self, imu: Imu) -> None:
        """Note a sample as the sensor gave it, before calibration and in its own axes."""
        self._evidence.raw_imu.append(imu)

    def imu(self, imu: Imu) -> bool:
        """Note a sample; whether it may be used."""
        self._evidence.imu.append(imu)
        return self.turns(imu.source)

    def turns(self, source: str) -> bool:
        """Whether the rates of an inertial sensor may be used."""
        return not self.monitor.untrusted or (self.trusts(Sense.IMU, source) and self.trusts(Sense.GYRO, source))

    def field(self, field: MagneticField) -> bool:
        """Note a magnetic field; whether it may be used."""
        self._evidence.fields.append(field)
        return self.monitor.trusts(Sense.FIELD, field.source) and self.monitor.trusts(Sense.IMU, field.source)

    def wind(self, wind: Wind) -> bool:
        """Note a wind; whether it may be used."""
        self._evidence.winds.append(wind)
        return self.monitor.trusts(Sense.WIND, wind.source)

    def time(self, time: TimeOfDay) -> bool:
        """Note an absolute time; whether it may be used. One that cannot be now is not. A receiver that has told no
        other, since it has no almanac, does not lie; it is announced once that has lasted."""
        plausible = is_plausible(time.time_unix_ns)
        if plausible:
            self._dated.add(time.source)
        elif time.source not in self._dated:
            self._announce_implausible(time)
            return False
        self._evidence.times.append(time)
        return plausible and self.monitor.trusts(Sense.TIME, time.source)

    def _announce_implausible(self, time: TimeOfDay) -> None:
        since_s = self._implausible_s.setdefault(time.source, time.t_s)
        if time.t_s - since_s >= _ALMANAC_S:
            self._implausible_s[time.source] = math.inf
            text = f"{time.source} says year {year_of(time.time_unix_ns)}: time not used"
            self._say(time.t_s, TextKind.ATTENTION, "time_implausible", text)

    def position(
        self,
        fix: GnssFix,
        antenna: tuple[float, float],
        lever_m: Vector,
        sigma_m: float,
        solution: InertialSolution | PoseSolution,
    ) -> Verdict | None:
        """Note a fix, `antenna` in the local plane; the verdict on it, or None: the usual rule. No receiver that was
        good is judged while the inertial sensor has just begun to carry the estimate, or no longer does: a filter that
        begins under way must find its tilt, and without one a high antenna is beside the hull as it heels."""
        if self._has_changed(solution, fix.t_s) and self.trusts(Sense.POSITION, fix.source):
            return None
        here, arm = solution.place(fix.t_s), solution.offset(lever_m)
        north, east = antenna[0] - arm.north_m, antenna[1] - arm.east_m
        way = _way(solution, fix.t_s) if _feels(solution, fix.t_s) else None
        seen = PositionSeen(
            fix.t_s, fix.source, fix.lat_deg, fix.lon_deg, north, east, north - here.north_m, east - here.east_m,
            here.north_mps, here.east_mps, here.sigma_m, sigma_m, fix.fix, way,
            None if _fresh(solution, fix.t_s) else antenna,
        )  # fmt: skip
        self._evidence.positions.append(seen)
        return self.monitor.screen_position(seen)

    def _has_changed(self, solution: InertialSolution | PoseSolution, t_s: float) -> bool:
        carried = isinstance(solution, InertialSolution)
        if carried is not self._carried:
            self._carried, self._changed_s = carried, t_s
        return t_s - self._changed_s < _CHANGED_S

    def velocity(
        self, velocity: GroundVelocity, lever_m: Vector, sigma_mps: float, solution: InertialSolution | PoseSolution
    ) -> Verdict | None:
        """Note a velocity; the verdict on it, or None: the usual rule. Judged as a fix is."""
        if self._has_changed(solution, velocity.t_s) and self.trusts(Sense.VELOCITY, velocity.source):
            return None
        here, swing = solution.place(velocity.t_s), solution.offset(lever_m)
        north, east = velocity.north_mps - swing.north_mps, velocity.east_mps - swing.east_mps
        felt = _gained(solution) if _feels(solution, velocity.t_s) else (None, None)
        seen = VelocitySeen(
            velocity.t_s, velocity.source, (velocity.north_mps, velocity.east_mps), north, east,
            north - here.north_mps, east - here.east_mps, felt[0], felt[1], sigma_mps, here.yaw_rad,
        )  # fmt: skip
        self._evidence.velocities.append(seen)
        return self.monitor.screen_velocity(seen)

    def heading(
        self,
        reading: Heading,
        heading: Measured,
        solution: InertialSolution | PoseSolution,
        by_field_rad: float | None = None,
    ) -> Verdict | None:
        """Note a heading; the verdict on it, or None: the usual rule. `by_field_rad`: what the magnetic field alone
        says, where a filter has mixed it with the gyro: that is judged."""
        here, yaw_rad = solution.place(heading.t_s), heading.yaw_rad if by_field_rad is None else by_field_rad
        turned = None
        levelled = by_field_rad is None or _feels(solution, heading.t_s)  # by nothing but an assumption else
        if levelled and _fresh(solution, heading.t_s):
            turned = solution.odometer.turned_rad + solution.filter.rates[2] * (heading.t_s - solution.t_s)
        seen = HeadingSeen(
            heading.t_s, heading.source, reading.yaw_rad, yaw_rad, wrap_pi(yaw_rad - here.yaw_rad),
            heading.sigma_rad, heading.wander_rad, turned,
        )  # fmt: skip
        self._evidence.headings.append(seen)
        return self.monitor.screen_heading(seen)

    def conclude(
        self,
        driven: bool,
        maybe_late: bool,
        motion: Motion,
        inertial: InertialSolution | None,
        current: CurrentObserver | None,
        now_s: float,
        imu_used: str | None = None,
        astern: bool = False,
    ) -> list[LieFound]:
        """Judge the tick; returns what is found to lie from now on. `driven`, `maybe_late`: the boat is armed, and the
        times of the receiver's values are in doubt. `imu_used`: the inertial sensor in use. `astern`: the boat may
        go stern first."""
        evidence, self._evidence = self._evidence, Evidence()
        evidence.driven, evidence.maybe_late = driven and not maybe_late, driven and maybe_late
        evidence.imu_used, evidence.astern, evidence.levers_m = imu_used, astern, self._levers_m
        if inertial is not None and inertial.running:
            evidence.inertial = _inertial_step(inertial)
        if current is not None and evidence.driven:
            turn_radps = current.carried_turn_radps
            evidence.model = ModelStep(current.run, *current.carried, turn_radps, *current.pushed)
        evidence.turn_radps = motion.rates[2]
        evidence.north_mps, evidence.east_mps = motion.velocity[0], motion.velocity[1]
        return list(self.monitor.update(evidence, now_s))


def _way(solution: InertialSolution, t_s: float) -> InertialWay:
    """The way of the boat's origin, up to a time just before or after the last sample. What receivers are off by is
    none of it: it changes at once where the filter learns of it."""
    odometer, filter_, ahead_s = solution.odometer, solution.filter, t_s - solution.t_s
    arm = solution.offset(solution.lever_m)
    return InertialWay(
        odometer.north_m + ahead_s * odometer.north_mps - arm.north_m,
        odometer.east_m + ahead_s * odometer.east_mps - arm.east_m,
        filter_.velocity[0] - odometer.north_mps,
        filter_.velocity[1] - odometer.east_mps,
    )


def _gained(inertial: InertialSolution) -> tuple[float, float]:
    """What the accelerometers have added up to, of the boat's origin: their own place swings about it in a turn."""
    odometer, (north_mps, east_mps) = inertial.odometer, inertial.swing
    return odometer.north_mps - north_mps, odometer.east_mps - east_mps


def _inertial_step(inertial: InertialSolution) -> InertialStep:
    odometer = inertial.odometer
    (north_mps, east_mps), (swing_north, swing_east) = _gained(inertial), inertial.swing
    lanes = []
    for lane in inertial.lanes if inertial.feels else ():
        first, now = lane.first, lane.velocity
        sigma_mps = lane.sigma_mps(inertial.t_s)
        lanes.append(LaneStep(lane.from_s, first[0], first[1], now[0] - swing_north, now[1] - swing_east, sigma_mps))
    return InertialStep(
        odometer.run,
        north_mps,
        east_mps,
        odometer.turned_rad,
        odometer.bias_sigma_radps,
        tuple(lanes),
    )


def _fresh(solution: InertialSolution | PoseSolution, t_s: float) -> TypeGuard[InertialSolution]:
    """Whether inertial samples reach up to that time."""
    return isinstance(solution, InertialSolution) and abs(t_s - solution.t_s) <= _FRESH_S


def _feels(solution: InertialSolution | PoseSolution, t_s: float) -> TypeGuard[InertialSolution]:
    """Whether they do, with forces that are measured and speak against a receiver: a filter that has begun under way
    does not know its attitude yet."""
    return _fresh(solution, t_s) and solution.feels and solution.odometer.bias_sigma_radps <= SETTLED_RADPS
