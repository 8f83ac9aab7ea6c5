"""What the boat does about a lie: which channels it uses, what it says and asks, what the answers do."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field, replace

import pytest

from companion.core.decision import TextKind
from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.monitor import IntegrityMonitor
from companion.nav.outliers import Verdict
from companion.params.store import Parameters
from tests.unit.nav.integrity.honest_boat import Boat, Spoil, another, moved, sped, turned
from tests.unit.nav.integrity.lies import ACCELEROMETER, GYRO, HEADING, IMU, POSITION, VELOCITY, frozen_imu, noisy
from tests.unit.nav.integrity.seen import TICK_S

QUESTION = "Is gnss right? Accept or reject it"
JUMPED = "gnss position jumped 5.0 m: not used"


@dataclass
class Watch:
    """A boat under the monitor; what it said, and its verdict on each position."""

    parameters: dict[str, float] = field(default_factory=dict)
    now_s: float = 0.0
    said: list[tuple[float, TextKind, str]] = field(default_factory=list)
    verdicts: list[Verdict | None] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.store = Parameters(self.parameters)
        self.monitor = IntegrityMonitor(self.store, lambda t_s, kind, name, text: self.said.append((t_s, kind, text)))
        self.boat, self.rng = Boat(), random.Random(1)

    def go(self, seconds: float, spoil: Spoil | None = None, driven: bool = True) -> list[str]:
        """Sail on; the texts meanwhile."""
        before, from_s, self.verdicts = len(self.said), self.now_s, []
        for _ in range(round(seconds / TICK_S)):
            self.now_s += TICK_S
            evidence = self.boat.evidence(self.now_s, self.rng)
            evidence.driven = driven
            if spoil is not None:
                spoil(evidence, self.now_s - from_s)
            self.verdicts += [self.monitor.screen_position(seen) for seen in evidence.positions]
            for velocity in evidence.velocities:
                self.monitor.screen_velocity(velocity)
            for heading in evidence.headings:
                self.monitor.screen_heading(heading)
            self.monitor.update(evidence, self.now_s)
        return [text for _, _, text in self.said[before:]]

    def trusts(self, channel: Channel) -> bool:
        return self.monitor.trusts(channel.sense, channel.source)


def jumped(evidence: Evidence, age_s: float) -> None:
    moved(evidence, 5.0)


def known(**parameters: float) -> Watch:
    watch = Watch(parameters)
    assert watch.go(10.0) == []
    return watch


def test_a_lie_is_said_once_asked_about_once_and_not_used() -> None:
    watch = known()
    assert watch.go(20.0, jumped) == [JUMPED, QUESTION]
    assert [kind for _, kind, _ in watch.said] == [TextKind.ALARM] * 2
    assert set(watch.verdicts) == {Verdict.REJECT}
    assert not watch.trusts(POSITION) and watch.trusts(VELOCITY) and watch.trusts(HEADING)
    (distrust,) = watch.monitor.state
    assert (distrust.sense, distrust.source, distrust.fault) == ("position", "gnss", "jumped 5.0 m")
    assert distrust.excluded and distrust.asks and distrust.since_s == pytest.approx(10.1, abs=0.1)


def test_off() -> None:
    watch = known(NAV_INTEG=0)
    assert watch.go(20.0, jumped) == []
    assert watch.trusts(POSITION) and watch.monitor.state == ()
    assert set(watch.verdicts) == {None}


def test_report_only() -> None:
    watch = known(NAV_INTEG=1)
    assert watch.go(20.0, jumped) == ["gnss position jumped 5.0 m: still used"]
    assert watch.said[0][1] is TextKind.ATTENTION
    assert watch.trusts(POSITION) and not watch.monitor.state[0].excluded
    assert set(watch.verdicts) == {None}


@pytest.mark.parametrize("parameters", [{"NAV_INTEG": 1}, {"NAV_JUMP_ACT": 0}])
def test_what_is_used_on_waits_for_no_answer(parameters: dict[str, float]) -> None:
    watch = known(**parameters)
    watch.go(3.0, jumped)
    assert watch.monitor.answer(True, watch.now_s) == "no sensor waits for an answer"
    watch.go(1.0, jumped)
    assert set(watch.verdicts) == {None}


def test_report_only_widens_nothing() -> None:
    watch = known(NAV_INTEG=1)
    assert watch.go(10.0, noisy())
    assert watch.monitor.sigma_m("gnss", 0.02) == 0.02


def test_turned_off_under_way_it_trusts_at_once() -> None:
    watch = known()
    watch.go(2.0, jumped)
    watch.store.set("NAV_INTEG", 0)
    assert watch.go(1.0, jumped) == []
    assert watch.trusts(POSITION) and watch.monitor.state == ()


# --- jumps -----------------------------------------------------------------------------------------------------------


def test_a_jump_may_be_followed_by_the_usual_rule() -> None:
    watch = known(NAV_JUMP_ACT=0)
    assert watch.go(20.0, jumped) == ["gnss position jumped 5.0 m: still used"]
    assert watch.trusts(POSITION) and set(watch.verdicts) == {None}
    assert not watch.monitor.state[0].excluded


def test_other_lies_are_not_followed_by_that() -> None:
    watch = known(NAV_JUMP_ACT=0)
    assert watch.go(2.0, frozen_imu) == ["imu repeats: not used"]
    assert not watch.trusts(IMU)


@pytest.mark.parametrize(("act", "integrity"), [(1, 2), (2, 2), (1, 1)])
def test_a_jump_that_another_receiver_confirms(act: int, integrity: int) -> None:
    """Both go 5 m; the second, which was silent, comes back there."""
    watch, follows = Watch({"NAV_JUMP_ACT": act, "NAV_INTEG": integrity}), (act, integrity) == (1, 2)

    def two(evidence: Evidence, age_s: float) -> None:
        another(evidence, 0.0)

    def second_gone(evidence: Evidence, age_s: float) -> None:
        """The estimate has drifted; the other receiver comes back and says so, within what dead reckoning explains."""
        another(evidence, 5.0)
        evidence.positions = [
            seen._replace(estimate_sigma_m=2.0) if seen.source == "spare" else seen for seen in evidence.positions
        ]
        moved(evidence, 5.0)

    watch.go(10.0, two)
    watch.go(5.0)  # the other is silent
    texts = watch.go(1.0, second_gone)
    confirmed = "gnss position followed: confirmed by another"
    assert (confirmed in texts) is follows
    assert (Verdict.RESET in watch.verdicts) is follows
    assert watch.trusts(POSITION) is (follows or integrity == 1)


# --- the answer ------------------------------------------------------------------------------------------------------


def test_accepted_its_next_reading_counts_and_it_is_used_on() -> None:
    watch = known()
    watch.go(3.0, jumped)
    assert watch.monitor.answer(True, watch.now_s) is None
    assert watch.said[-1][1:] == (TextKind.ATTENTION, "gnss position followed: accepted")
    assert watch.trusts(POSITION) and watch.monitor.state == ()
    assert watch.go(10.0, jumped) == []
    assert watch.verdicts.count(Verdict.RESET) == 1 and watch.verdicts[0] is Verdict.RESET
    assert set(watch.verdicts[1:]) == {None}


def test_rejected_it_asks_no_more() -> None:
    watch = known()
    watch.go(3.0, jumped)
    assert watch.monitor.answer(False, watch.now_s) is None
    assert watch.said[-1][2] == "gnss position rejected"
    assert watch.go(10.0, jumped) == [] and not watch.trusts(POSITION)
    assert not watch.monitor.state[0].asks
    assert watch.monitor.answer(True, watch.now_s) == "no sensor waits for an answer"
    assert watch.go(10.0) == ["gnss position is good again"] and watch.trusts(POSITION)


@pytest.mark.parametrize("accept", [True, False])
def test_only_what_is_asked_about_can_be_answered(accept: bool) -> None:
    watch = known()
    assert watch.monitor.answer(accept, watch.now_s) == "no sensor waits for an answer"
    watch.go(2.0, frozen_imu)
    assert watch.monitor.answer(accept, watch.now_s) == "no sensor waits for an answer"
    assert not watch.trusts(IMU)


def test_an_answer_is_for_all_that_is_asked() -> None:
    watch = known()

    def both(evidence: Evidence, age_s: float) -> None:
        moved(evidence, 5.0)
        turned(evidence, math.pi / 2)

    watch.go(3.0, both)
    assert not watch.trusts(POSITION) and not watch.trusts(HEADING)
    assert watch.monitor.answer(True, watch.now_s) is None
    assert watch.trusts(POSITION) and watch.trusts(HEADING)


# --- in time ---------------------------------------------------------------------------------------------------------


def test_it_is_used_again_when_nothing_has_spoken_against_it_for_five_seconds() -> None:
    watch = known()
    watch.go(3.0, jumped)
    assert watch.go(4.9) == [] and not watch.trusts(POSITION)
    assert watch.go(1.5) == ["gnss position is good again"] and watch.trusts(POSITION)
    assert watch.said[-1][1] is TextKind.ROUTINE


def test_a_lie_that_comes_back_is_said_again() -> None:
    watch = known()
    watch.go(3.0, jumped)
    watch.go(10.0)
    assert JUMPED in watch.go(3.0, jumped)


def test_disarming_clears_all() -> None:
    watch = known()
    watch.go(3.0, jumped)
    assert watch.go(0.2, jumped, driven=False) == []
    assert watch.trusts(POSITION) and watch.monitor.state == ()
    assert watch.go(10.0, jumped) == [], "where it is when the boat is armed is where it is"


def test_what_only_disarming_clears_stays() -> None:
    watch = known()

    def upside_down(evidence: Evidence, age_s: float) -> None:
        for seen in evidence.velocities:
            assert seen.inertial_north_mps is not None
        evidence.imu = [replace(imu, x_mps2=-imu.x_mps2) for imu in evidence.imu]
        evidence.velocities = [
            seen._replace(inertial_north_mps=seen.off_north_mps - seen.north_mps) for seen in evidence.velocities
        ]

    watch.go(20.0)
    assert watch.go(15.0, upside_down) == ["imu x axis reversed: not used"]
    assert watch.go(20.0) == [] and not watch.trusts(ACCELEROMETER)
    assert watch.trusts(GYRO) and watch.trusts(IMU), "only what lies"
    watch.go(0.1, driven=False)
    assert watch.trusts(ACCELEROMETER)


def test_what_a_lying_inertial_sensor_made_of_a_receiver_is_void() -> None:
    """The sums of its forces run away, and the receiver seems to jump beside them; then one of its axes is found to be
    stuck."""
    watch = known()

    def runs_away(evidence: Evidence, age_s: float) -> None:
        moved(evidence, 5.0)
        evidence.raw_imu = [replace(imu, x_mps2=0.3) for imu in evidence.raw_imu]

    said = watch.go(1.0, runs_away)
    assert "imu x axis stuck: not used" in said
    assert watch.trusts(POSITION) and watch.monitor.answer(True, watch.now_s) == "no sensor waits for an answer"


# --- several at once -------------------------------------------------------------------------------------------------


def test_a_receiver_that_freezes_whole_is_said_in_one_text() -> None:
    watch = known()
    last: list[Evidence] = []

    def frozen(evidence: Evidence, age_s: float) -> None:
        last.append(evidence)
        first = last[0]
        evidence.positions = [
            seen._replace(lat_deg=first.positions[0].lat_deg, lon_deg=first.positions[0].lon_deg)
            for seen in evidence.positions
        ]
        evidence.velocities = [seen._replace(raw=first.velocities[0].raw) for seen in evidence.velocities]
        evidence.headings = [seen._replace(raw=first.headings[0].raw) for seen in evidence.headings]

    texts = watch.go(5.0, frozen)
    assert len(texts) <= 2 and texts[-1].endswith("repeats: not used")
    assert not any(watch.trusts(channel) for channel in (POSITION, VELOCITY, HEADING))


def test_the_position_of_a_receiver_whose_velocity_lies_is_kept_out_until_it_is_judged() -> None:
    watch = known()
    texts = watch.go(2.0, lambda evidence, _: sped(evidence, 0.5))
    assert texts == ["gnss velocity jumped 0.5 m/s: not used", QUESTION]
    assert set(watch.verdicts[2:]) == {Verdict.REJECT}, "from the first suspicion on"
    watch.go(1.5, lambda evidence, _: sped(evidence, 0.5))
    assert watch.verdicts[-1] is None and watch.trusts(POSITION), "nothing has spoken against the position itself"


def test_a_worse_finding_replaces_one_that_is_used_on() -> None:
    watch = known()
    draw = noisy()
    assert watch.go(5.0, draw) == ["gnss position is noisier than it claims: still used"]
    assert watch.trusts(POSITION)
    assert watch.monitor.sigma_m("gnss", 0.02) > 0.05

    def gone(evidence: Evidence, age_s: float) -> None:
        draw(evidence, age_s)
        moved(evidence, 500.0)

    assert watch.go(5.0, gone)[-2:] == ["gnss position jumped 500 m: not used", QUESTION]
    assert not watch.trusts(POSITION)


def test_texts_are_short_and_name_a_remedy_or_a_result() -> None:
    watch = known()
    watch.go(3.0, jumped)
    watch.monitor.answer(False, watch.now_s)
    watch.go(10.0)
    watch.go(3.0, jumped)
    watch.monitor.answer(True, watch.now_s)
    assert all(len(text) <= 50 for _, _, text in watch.said)


def test_an_unknown_channel_is_trusted() -> None:
    assert Watch().monitor.trusts(Sense.WIND, "nobody")


def in_doubt(spoil: Spoil) -> Spoil:
    """The same, while the times of the receiver's values are in doubt."""

    def spoilt(evidence: Evidence, age_s: float) -> None:
        spoil(evidence, age_s)
        evidence.driven, evidence.maybe_late = False, True

    return spoilt


def far_off(evidence: Evidence, age_s: float) -> None:
    moved(evidence, 50.0)


def test_a_jump_that_no_latency_explains_stands_while_times_are_in_doubt() -> None:
    watch = Watch()
    watch.go(20.0)
    assert "gnss position jumped 50 m: not used" in watch.go(2.0, far_off)
    watch.go(10.0, in_doubt(far_off))
    assert set(watch.verdicts) == {Verdict.REJECT} and not watch.trusts(POSITION)
    watch.go(8.0, far_off)
    assert set(watch.verdicts) == {Verdict.REJECT} and not watch.trusts(POSITION)


def test_a_sensor_that_repeats_is_found_while_times_are_in_doubt_and_stays_so() -> None:
    watch = Watch()
    watch.go(20.0)
    watch.go(2.0, frozen_imu)
    assert not watch.trusts(IMU)
    watch.go(10.0, in_doubt(frozen_imu))
    assert not watch.trusts(IMU)
    later = Watch()
    later.go(20.0)
    later.go(5.0, in_doubt(frozen_imu))
    assert not later.trusts(IMU)


def test_what_late_readings_may_look_like_is_forgotten_while_times_are_in_doubt() -> None:
    watch = Watch()
    watch.go(20.0)
    watch.go(2.0, lambda evidence, age_s: turned(evidence, math.radians(20.0)))
    assert not watch.trusts(HEADING)
    watch.go(0.2, in_doubt(lambda evidence, age_s: turned(evidence, math.radians(20.0))))
    assert watch.trusts(HEADING)


def test_disarming_clears_all_in_doubt_too() -> None:
    watch = Watch()
    watch.go(20.0)
    watch.go(2.0, far_off)
    watch.go(2.0, in_doubt(far_off))
    assert not watch.trusts(POSITION)
    watch.go(0.2, far_off, driven=False)
    assert watch.trusts(POSITION)
