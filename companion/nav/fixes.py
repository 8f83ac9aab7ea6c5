"""Fixes of all receivers → the positions that the solution in use takes."""

from __future__ import annotations

import math
from typing import NamedTuple

from companion.config.vessel import NavigatedBoat
from companion.core.decision import TextKind
from companion.core.events import Announce
from companion.core.geodesy import LocalFrame, rough_distance_and_bearing
from companion.core.readings import FixType, GnssFix
from companion.nav.accuracies import SensorAccuracies
from companion.nav.altitude import Altitude
from companion.nav.blending import Offset, ReceiverBlend
from companion.nav.inertial import InertialSolution
from companion.nav.integrity.evidence import Sense
from companion.nav.lever_arms import ZERO, Vector, lever_arms, normal_gravity_mps2, relative
from companion.nav.no_imu import PoseSolution
from companion.nav.outliers import FirstPosition, ThesisOutlierRule, Verdict
from companion.nav.position_noise import PositionNoise
from companion.nav.solution import Place
from companion.nav.solutions import Solutions
from companion.nav.sources import GradeWatch, SourceSelector
from companion.nav.validity import Validity
from companion.nav.witness import Witness
from companion.params.store import Parameters

_PLANE_M = 50_000.0  # further from its origin, the plane is no map
_LIE_M = 1.5  # off by more after an inertial sensor has lied, the position begins anew
_THESIS_RULE = 1
_LATE_LASTS_S = 3.0  # for so long a line may catch up with what a hub or a radio has held back
_LATE_GAP_S = 10.0  # without a fix: what was late before says nothing of the next one
_LATE_TOLD_S = 60.0  # from one text about a receiver that is too late to the next


class JudgedFix(NamedTuple):
    """A fix that has been judged. `place`: of its antenna, north and east in m; `lever_m`: of the antenna from the
    boat's origin; `sigma_m`: on each axis. `good`: it may be used; `used`: it is of the receiver in use. `rule`: the
    verdict that replaces the gate's. `late`: the filter has gone on too far. It counts as one that has not come, for a
    line may have held it back."""

    fix: GnssFix
    place: tuple[float, float]
    lever_m: Vector
    sigma_m: float
    good: bool
    used: bool
    rule: Verdict | None
    late: bool = False


class Fixes:
    """Call `judge` for each fix, then `fuse` for what it returns.

    Remembers the receiver in use with its newest fix and slow error, the kind of fix of each receiver and their offsets
    from each other, the local plane, the altitude, and how many jumps were followed. `driven`: the boat is armed; the
    plane, in which modes hold places, stays where it is.
    """

    def __init__(
        self,
        config: NavigatedBoat,
        parameters: Parameters,
        say: Announce,
        accuracies: SensorAccuracies,
        witness: Witness,
        validity: Validity,
        solutions: Solutions,
    ) -> None:
        self.frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
        self.newest: GnssFix | None = None
        self.kinds: dict[str, FixType] = {}  # of each receiver
        self.jumps_followed = 0
        self.driven = False
        self._parameters, self._say = parameters, say
        self._levers = lever_arms(config.sensors)
        self._accuracies, self._witness, self._validity, self._solutions = accuracies, witness, validity, solutions
        self._receivers = SourceSelector({row.name: row.timeout_s for row in config.sensors})
        self._first = FirstPosition()
        self._thesis = ThesisOutlierRule()
        self._grade = GradeWatch()
        self._blend = ReceiverBlend()
        self._blended: dict[str, FixType] = {}  # the kind of fix of each receiver whose slow error the offsets hold
        self._wander_of: str | None = None  # the receiver whose slow error the inertial filter holds
        self._noises: dict[tuple[str, FixType], PositionNoise] = {}  # of each receiver and kind of fix
        self._altitude = Altitude(config.home.altitude_m)
        self._announced: str | None = None
        self._late_s: dict[str, tuple[float, float]] = {}  # of receivers that are too late: since when, and when last
        self._late_told_s = -math.inf

    @property
    def source(self) -> str | None:
        """The receiver in use; None before the first good fix."""
        return self._receivers.current

    @property
    def altitude_m(self) -> float:
        """Altitude of the boat's origin."""
        return self._altitude.altitude_m

    @property
    def blend(self) -> bool:
        """Whether several receivers are used at once."""
        chosen = self._parameters["NAV_BLEND"] and self._parameters["NAV_WILD_RULE"] != _THESIS_RULE
        return len(self.kinds) > 1 and bool(chosen)

    def begin_anew(self) -> None:
        """Look for the boat's position as at the start."""
        self._first = FirstPosition()

    def forget_offsets(self) -> None:
        """The estimate has been set anew: what receivers were off from it is void."""
        self._blend.clear()

    def judge(self, fix: GnssFix) -> JudgedFix:
        """Whether to use a fix, and how accurate it is."""
        good = fix.fix >= FixType.FIX_2D and math.isfinite(fix.lat_deg) and math.isfinite(fix.lon_deg)
        lever = self._levers.get(fix.source, ZERO)
        sigma_m = self._accuracies.position_m(fix)
        place = self.frame.to_ned(fix.lat_deg, fix.lon_deg)
        rule = None
        if good and self._solutions.pose.started:
            rule = self._witness.position(fix, place, lever, sigma_m, self._solutions.used)
            sigma_m = self._witness.monitor.sigma_m(fix.source, sigma_m)
        good = good and self._witness.trusts(Sense.POSITION, fix.source)
        late = self._is_too_late(fix)
        used = not late and self._receivers.offer(fix.source, fix.t_s, good, int(fix.fix >= FixType.RTK_FLOAT))
        if used or self.newest is None or self.newest.source == fix.source:
            self.newest = fix
        self.kinds[fix.source] = fix.fix
        return JudgedFix(fix, place, lever, sigma_m, good and not late, used, rule, late)

    def _is_too_late(self, fix: GnssFix) -> bool:
        """Whether the filter has gone on too far from where a fix is of; tells people where that lasts."""
        solution, source = self._solutions.used, fix.source
        if not isinstance(solution, InertialSolution) or not self._solutions.is_too_late(fix.t_s):
            self._late_s.pop(source, None)
            return False
        since_s, last_s = self._late_s.get(source, (-math.inf, -math.inf))
        if solution.t_s - last_s > _LATE_GAP_S:  # it was silent: its line is held up once more
            since_s = solution.t_s
        self._late_s[source] = since_s, solution.t_s
        lasted_s = solution.t_s - since_s
        if lasted_s >= _LATE_LASTS_S and solution.t_s - self._late_told_s >= _LATE_TOLD_S:
            self._late_told_s = solution.t_s
            text = f"{source} comes {solution.t_s - fix.t_s:.1f} s late: not used"
            self._say(solution.t_s, TextKind.ALARM, "receiver_too_late", text)
        return True

    def fuse(self, judged: JudgedFix, noisier: float) -> None:
        """Let the solution take it, where it is used. `noisier`: the factor by which its noise counts as larger."""
        fix, started = judged.fix, self._solutions.pose.started
        if not judged.good and not judged.late:
            self._blend.drop(fix.source)
        if judged.used:
            self._announce(fix)
            self._use(judged, noisier)
        elif judged.good and self.blend and started and judged.rule is None:
            self._fuse(judged, noisier, None)

    def _use(self, judged: JudgedFix, noisier: float) -> None:
        """Take a fix of the receiver in use."""
        rule, (north, east) = judged.rule, judged.place
        self.jumps_followed += rule is Verdict.RESET
        if self._parameters["NAV_WILD_RULE"] == _THESIS_RULE:
            rule = rule or self._thesis.update(north, east)
        if not self._solutions.pose.started:
            self._begin(judged)
            return
        if self._solutions.begins_anew(Sense.POSITION, rule) is Verdict.RESET:
            here = self._solutions.used.place(judged.fix.t_s)
            off_m = math.hypot(north - here.north_m, east - here.east_m)
            rule = Verdict.RESET if rule is Verdict.RESET or off_m > _LIE_M else rule
        self._fuse(judged, noisier, rule)

    def _begin(self, judged: JudgedFix) -> None:
        """Begin at the first positions, once they agree."""
        fix = judged.fix
        approved = self._first.update(*judged.place, judged.sigma_m, fix.t_s)
        if approved is None:
            return
        if self._is_off_the_plane(fix):
            self._move_plane(fix)
            approved = (0.0, 0.0)
        way = self._first.way(self._accuracies.noise_m(fix, judged.sigma_m))
        self._solutions.pose.begin(fix.t_s, *approved, judged.lever_m, judged.sigma_m, way)
        self._expect_wander(fix, self._accuracies.slow_m(fix, judged.sigma_m))  # before the inertial filter starts
        self._validity.begin(fix.t_s)
        self._altitude.take(fix, judged.lever_m)

    def _is_off_the_plane(self, fix: GnssFix) -> bool:
        frame = self.frame
        return rough_distance_and_bearing(frame.lat_deg, frame.lon_deg, fix.lat_deg, fix.lon_deg)[0] > _PLANE_M

    def _move_plane(self, fix: GnssFix) -> None:
        """Lay the local plane around a fix."""
        self.frame = LocalFrame(fix.lat_deg, fix.lon_deg)
        if self._solutions.inertial is not None:
            self._solutions.inertial.filter.gravity_mps2 = normal_gravity_mps2(fix.lat_deg)

    def _stay_on_the_plane(self, judged: JudgedFix, sigma_m: float) -> None:
        """Where the boat turns out to be off the plane, as after a first position that was not its own, lay another."""
        fix = judged.fix
        if self.driven or not self._is_off_the_plane(fix):
            return
        self._move_plane(fix)
        self._blend.clear()
        self._solutions.used.position(fix.t_s, 0.0, 0.0, judged.lever_m, sigma_m, Verdict.RESET)

    def _fuse(self, judged: JudgedFix, noisier: float, rule: Verdict | None) -> None:
        fix, place, sigma_m = judged.fix, judged.place, judged.sigma_m
        solution, leads, accuracies = self._solutions.used, fix.source == self.source, self._accuracies
        added_m2 = self._grade.update(fix.t_s, fix.fix, sigma_m) if leads else 0.0
        inertial = isinstance(solution, InertialSolution)
        if isinstance(solution, PoseSolution) and added_m2 > 0.0:
            solution.add_position_variance(added_m2)
        fused_sigma_m = noisier * self._noise_m(judged) if inertial else accuracies.fused_m(fix, sigma_m)
        slow_sigma_m = accuracies.slow_m(fix, sigma_m)
        if self.blend and rule is None:
            offset = self._offset(judged, fused_sigma_m, slow_sigma_m, leads)
            if offset is None:
                return
            place = place[0] - offset.north_m, place[1] - offset.east_m
            slow_sigma_m = offset.slow_sigma_m
        if leads:
            self._expect_wander(fix, slow_sigma_m)
        before = solution.place(fix.t_s)
        verdict = solution.position(fix.t_s, *place, judged.lever_m, fused_sigma_m, rule)
        if verdict is Verdict.RESET:
            self._blend.clear()
            self._announce_reset(fix, before, solution.place(fix.t_s))
        if verdict is not Verdict.REJECT:
            self._validity.position(fix.t_s, 0.0 if inertial else slow_sigma_m)
            if leads:
                self._altitude.take(fix, judged.lever_m)
                self._stay_on_the_plane(judged, fused_sigma_m)

    def _noise_m(self, judged: JudgedFix) -> float:
        """One sigma of the noise of a fix, by what is said of it and by how the receiver's positions scatter."""
        fix, inertial = judged.fix, self._solutions.inertial
        said_m = self._accuracies.noise_m(fix, judged.sigma_m)
        if inertial is None or not inertial.feels:
            return said_m
        noise = self._noises.setdefault((fix.source, fix.fix), PositionNoise())
        arm = relative(judged.lever_m, inertial.lever_m)
        here, since = inertial.offset(arm), inertial.since(fix.t_s, arm)
        way, lag_s, (vn, ve, _) = inertial.odometer, inertial.t_s - fix.t_s, inertial.filter.velocity
        north_m = judged.place[0] - here.north_m - way.north_m + since.north_m - lag_s * (vn - way.north_mps)
        east_m = judged.place[1] - here.east_m - way.east_m + since.east_m - lag_s * (ve - way.east_mps)
        noise.take(fix.t_s, way.run, north_m, east_m)
        return noise.sigma_m(said_m, self._accuracies.noise_m(fix, judged.sigma_m, 1.0))

    def _offset(self, judged: JudgedFix, sigma_m: float, slow_sigma_m: float, leads: bool) -> Offset | None:
        """What blending takes off a fix; None: the receiver is new."""
        solution, fix, place = self._solutions.used, judged.fix, judged.place
        here, arm = solution.place(fix.t_s), solution.offset(judged.lever_m)
        off_m = place[0] - arm.north_m - here.north_m, place[1] - arm.east_m - here.east_m
        kind = max(fix.fix, FixType.DGPS)  # the slow errors of plain fixes with and without corrections are alike
        before = self._blended.get(fix.source, kind)
        self._blended[fix.source] = kind
        better, anew = leads and kind > before, kind != before
        if better:  # it counts at once, as if alone
            self._blend.clear()
        sigma_m = math.hypot(sigma_m, self._unsure_s(fix.source, leads) * math.hypot(here.north_mps, here.east_mps))
        return self._blend.update(fix.source, fix.t_s, off_m, sigma_m, slow_sigma_m, leads, anew and not better)

    def _unsure_s(self, source: str, leads: bool) -> float:
        """One sigma of how late a receiver is, by which a boat under way leaves its fixes behind: the filter learns it
        of the one in use alone."""
        inertial = self._solutions.inertial
        return inertial.filter.late_sigma_s() if leads and inertial is not None else self._accuracies.latency_s(source)

    def _expect_wander(self, fix: GnssFix, slow_sigma_m: float) -> None:
        """Tell the inertial filter of the slow error of the receiver in use. Blended receivers have the one of all."""
        before, self._wander_of = self._wander_of, fix.source
        inertial = self._solutions.inertial
        if inertial is not None:
            another = before not in (None, fix.source) and not self.blend
            inertial.expect_wander(self._accuracies.wander(fix, slow_sigma_m), another)
            inertial.filter.expect_late(self._accuracies.latency_s(fix.source), before not in (None, fix.source))

    def _announce(self, fix: GnssFix) -> None:
        """Announce when another receiver takes over."""
        before, self._announced = self._announced, fix.source
        if before is not None and before != fix.source:
            text = f"Position source: {fix.source} (was {before})"
            self._say(fix.t_s, TextKind.ATTENTION, "position_source", text)

    def _announce_reset(self, fix: GnssFix, before: Place, after: Place) -> None:
        """Announce that the estimate has restarted from a fix, where an inertial sensor had carried it."""
        if self._solutions.inertial is not None:
            jump_m = math.hypot(after.north_m - before.north_m, after.east_m - before.east_m)
            text = f"Position reset by {jump_m:.0f} m ({fix.source})"
            self._say(fix.t_s, TextKind.ALARM, "position_jumped", text)
