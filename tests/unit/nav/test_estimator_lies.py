"""The estimator among sensors that lie: what it stops using, what it forgets, what it goes on with and for how long."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import pytest

from companion.core.actuation import Wrench
from companion.core.decision import TextKind
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, GnssFix, GroundVelocity, Heading, Imu, Reading, TimeOfDay
from companion.nav.estimator import Estimator
from companion.nav.witness import Witness
from companion.params.store import Parameters
from tests.unit.nav.boat_truth import Voyage, config_of, readings_of, sail

TICK_EVERY = 10
LIE_S = 20.0
DRIFTING = Voyage(duration_s=40.0, speed_mps=0.1, radius_m=5.0)

Lie = Callable[[Reading, float], Reading | None]
"""(reading, time since the lie began) → what the sensor says instead; None: nothing."""


@dataclass
class Afloat:
    """An armed boat in Hold, so to say: its estimator, what it said, and how far it is off."""

    parameters: dict[str, float]
    voyage: Voyage = DRIFTING

    def __post_init__(self) -> None:
        config = config_of(self.voyage)
        self.truth = sail(self.voyage)
        self.said: list[str] = []
        self.estimator = Estimator(config, Parameters(self.parameters), self._say)
        frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
        self.rows = readings_of(self.voyage, self.truth, frame)
        self.k = 0
        self.state: NavState | None = None

    def _say(self, t_s: float, kind: TextKind, name: str, text: str) -> None:
        self.said.append(text)

    def go(self, to_s: float, lie: Lie | None = None) -> NavState:
        """Sail on to that time, lied to since `LIE_S`; the last state."""
        batch: list[Reading] = []
        while self.k < len(self.rows) and self.k <= round(to_s * 100):
            for reading in self.rows[self.k]:
                told = reading if lie is None or reading.t_s < LIE_S else lie(reading, reading.t_s - LIE_S)
                batch += [] if told is None else [told]
            if self.k % TICK_EVERY == 0:
                self.state = self.estimator.update(batch, float(self.truth.t_s[self.k]), Wrench(0.0, 0.0, 0.0))
                batch = []
            self.k += 1
        assert self.state is not None
        return self.state

    def off(self) -> tuple[float, float]:
        """(m, rad) of the last state from the truth."""
        assert self.state is not None
        row = round(self.state.t_s * 100)
        north, east, _ = self.truth.position[row]
        yaw_rad = math.remainder(self.state.yaw_rad - self.truth.attitude[row, 2], math.tau)
        return math.hypot(self.state.north_m - north, self.state.east_m - east), abs(yaw_rad)


def north_by(fix: GnssFix, metres: float) -> GnssFix:
    return replace(fix, lat_deg=fix.lat_deg + metres / 111_200.0)


def jump(metres: float) -> Lie:
    return lambda reading, age_s: north_by(reading, metres) if isinstance(reading, GnssFix) else reading


def creep(mps: float) -> Lie:
    return lambda reading, age_s: north_by(reading, mps * age_s) if isinstance(reading, GnssFix) else reading


def spoof(mps: float) -> Lie:
    def lie(reading: Reading, age_s: float) -> Reading:
        if isinstance(reading, GroundVelocity):
            return replace(reading, north_mps=reading.north_mps + mps)
        return creep(mps)(reading, age_s) or reading

    return lie


def heading_creep(degps: float) -> Lie:
    def lie(reading: Reading, age_s: float) -> Reading:
        if isinstance(reading, Heading):
            return replace(reading, yaw_rad=math.remainder(reading.yaw_rad + math.radians(degps) * age_s, math.tau))
        return reading

    return lie


def imu_repeats() -> Lie:
    first: list[Imu] = []

    def lie(reading: Reading, age_s: float) -> Reading:
        if not isinstance(reading, Imu):
            return reading
        first.append(reading)
        return replace(first[0], t_s=reading.t_s)

    return lie


def afloat(**parameters: float) -> Afloat:
    boat = Afloat(parameters)
    assert boat.go(LIE_S - 0.1).position_valid
    boat.said.clear()
    return boat


def test_a_jump_is_not_followed_and_the_velocity_carries_on() -> None:
    boat = afloat()
    state = boat.go(40.0, jump(50.0))
    assert boat.said == ["gnss position jumped 50 m: not used", "Is gnss right? Accept or reject it"]
    assert state.position_valid and state.heading_valid
    assert boat.off()[0] < 0.3
    assert state.distrusted[0].excluded and state.jumps_followed == 0


NOON_NS = 1_795_262_400_000_000_000
ROLLOVER_S = -1024 * 7 * 86400


@pytest.mark.parametrize("off_s", [10_800, -3600, ROLLOVER_S, 250_000_000_000])
def test_a_jump_of_the_receivers_time_changes_neither_the_time_nor_the_motion(off_s: int) -> None:
    """Hours, a week's number of ten bits, and the year 9948."""

    def ahead(reading: Reading, age_s: float) -> Reading:
        return (
            replace(reading, time_unix_ns=reading.time_unix_ns + off_ns) if isinstance(reading, TimeOfDay) else reading
        )

    off_ns, boat, honest = off_s * 10**9, afloat(), afloat()
    for row in (*boat.rows, *honest.rows):
        row += [TimeOfDay(f.t_s, f.source, NOON_NS + round(f.t_s * 1e9)) for f in row if isinstance(f, GnssFix)]
    state, expected = boat.go(40.0, ahead), honest.go(40.0)
    assert state.time_unix_ns == expected.time_unix_ns == NOON_NS + 40_000_000_000
    assert (state.north_m, state.east_m, state.yaw_rad) == (expected.north_m, expected.east_m, expected.yaw_rad)
    assert boat.said == [f"gnss time is off by {off_s:.1f} s: not used"] and not honest.said


def test_a_receiver_without_an_almanac_gives_no_time_and_is_told_once_it_has_lasted() -> None:
    said: list[str] = []
    witness = Witness(Parameters(), lambda *event: said.append(event[3]))
    in_2006_ns = NOON_NS + ROLLOVER_S * 10**9
    for t_s in range(100):
        assert not witness.time(TimeOfDay(float(t_s), "gnss", in_2006_ns + t_s * 10**9))
        assert said == ([] if t_s < 60 else ["gnss says year 2007: time not used"])
    assert not witness.monitor.state
    assert witness.time(TimeOfDay(100.0, "gnss", NOON_NS))
    assert not witness.time(TimeOfDay(101.0, "gnss", in_2006_ns)), "however it came about"


@pytest.mark.parametrize(
    ("off_m", "kind", "sigma_m"),
    [(20.0, FixType.RTK_FIXED, 0.03), (200.0, FixType.FIX_3D, 1.35), (1_700_000.0, FixType.FIX_3D, 1.35)],
)
def test_a_second_receiver_elsewhere_makes_no_liar_of_the_one_in_use(
    off_m: float, kind: FixType, sigma_m: float
) -> None:
    """A plotter in demonstration mode says that it is in another country. When both were told to be apart, the estimate
    took what the blend then expected of them for a way of the boat: the good receiver had jumped, and was left out."""
    boat = Afloat({})
    receiver, *rest = config_of(DRIFTING).sensors
    config = replace(config_of(DRIFTING), sensors=(receiver, *rest, replace(receiver, name="plotter")))
    boat.estimator = Estimator(config, Parameters(), boat._say)
    lat_deg = config.home.lat_deg - off_m / 111_200.0
    for row in boat.rows[::20]:
        fix = GnssFix(row[0].t_s, "plotter", lat_deg, config.home.lon_deg, 45.0, kind, 8, 0.9, sigma_m)
        row.append(fix)
    boat.go(30.0)
    (said,) = boat.said[1:]
    assert said.startswith("plotter position is ") and said.endswith(" m from gnss: still used")
    assert boat.estimator.sources["position"] == "gnss" and boat.off()[0] < 0.1


def test_carried_for_so_long_then_the_position_is_lost() -> None:
    """`FS_POS_ACT` acts on an estimate whose position is not valid."""
    boat = afloat(NAV_CARRY_T=10.0)
    assert boat.go(LIE_S + 9.5, jump(50.0)).position_valid
    lost = boat.go(LIE_S + 11.0, jump(50.0))
    assert not lost.position_valid
    assert not lost.heading_valid or lost.heading_age_s < 1.0


def test_without_velocity_the_inertial_sensor_and_model_carry_it_for_fs_pos_t() -> None:
    boat = afloat(FS_POS_T=4.0)
    assert boat.go(LIE_S + 3.5, spoof(1.0)).position_valid
    assert boat.off()[0] < 0.5
    assert not boat.go(LIE_S + 6.0, spoof(1.0)).position_valid


@pytest.mark.parametrize("accept", [True, False])
def test_the_operator_decides(accept: bool) -> None:
    boat = afloat()
    boat.go(25.0, jump(5.0))
    assert boat.estimator.answer(accept, 25.0) is None
    state = boat.go(32.0, jump(5.0))
    assert boat.off()[0] == pytest.approx(5.0 if accept else 0.0, abs=0.2)
    assert state.position_valid and state.jumps_followed == int(accept)
    assert boat.estimator.answer(accept, 32.0) == "no sensor waits for an answer"


def test_the_estimate_goes_back_to_before_a_creep() -> None:
    boat = afloat()
    boat.go(30.0, creep(0.3))
    assert boat.said[0] == "gnss position drifts: not used"
    assert boat.off()[0] < 0.2


def test_the_heading_goes_back_to_before_its_creep_and_the_gyro_carries_it() -> None:
    boat = afloat()
    state = boat.go(40.0, heading_creep(1.0))
    assert boat.said[0] == "gnss heading drifts: not used"
    assert state.heading_valid and math.degrees(boat.off()[1]) < 2.0


def test_an_inertial_sensor_that_repeats_is_done_without() -> None:
    boat = afloat()
    state = boat.go(32.0, imu_repeats())
    assert boat.said == ["imu repeats: not used"]
    assert boat.estimator.inertial is not None and not boat.estimator.inertial.running
    assert state.position_valid and state.heading_valid
    assert boat.off()[0] < 0.3


def all_repeats() -> Lie:
    """Inertial sensor and heading, which a board with a compass sends together."""
    first: dict[type, Reading] = {}

    def lie(reading: Reading, age_s: float) -> Reading:
        if not isinstance(reading, Imu | Heading):
            return reading
        return replace(first.setdefault(type(reading), reading), t_s=reading.t_s)

    return lie


def test_without_heading_and_gyro_the_course_is_taken_at_once() -> None:
    """Until then the heading stays while the boat turns: ÅBOAT turned by 50° on its circle, and lost its heading."""
    boat, lie = Afloat({}, Voyage(duration_s=40.0, speed_mps=2.0, radius_m=10.0)), all_repeats()
    boat.go(LIE_S - 0.1)
    boat.go(LIE_S + 1.2, lie)
    assert "Heading source: course over ground (gnss lost)" in boat.said
    assert not boat.go(LIE_S + 2.4, lie).heading_valid, "it is 25° off, and was believed"
    assert boat.go(LIE_S + 4.0, lie).heading_valid and math.degrees(boat.off()[1]) < 10.0


def axis_stuck(name: str) -> Lie:
    first: list[float] = []

    def lie(reading: Reading, age_s: float) -> Reading:
        if not isinstance(reading, Imu):
            return reading
        first.append(getattr(reading, name))
        return replace(reading, **{name: first[0]})

    return lie


def test_a_stuck_force_axis_leaves_the_gyro() -> None:
    boat = afloat()
    state = boat.go(32.0, axis_stuck("y_mps2"))
    assert boat.said == ["imu y axis stuck: not used"]
    inertial = boat.estimator.inertial
    assert inertial is not None and inertial.running and not inertial.feels
    assert state.position_valid and state.heading_valid
    off_m, off_rad = boat.off()
    assert off_m < 0.2 and math.degrees(off_rad) < 1.0


def test_a_stuck_rate_axis_is_done_without() -> None:
    boat = afloat()
    state = boat.go(32.0, axis_stuck("yaw_rate_radps"))
    assert boat.said == ["imu yaw axis stuck: not used"]
    assert boat.estimator.inertial is not None and not boat.estimator.inertial.running
    assert state.position_valid and state.heading_valid and boat.off()[0] < 0.3


def test_what_comes_right_is_used_again() -> None:
    boat = afloat()

    def passing(reading: Reading, age_s: float) -> Reading | None:
        return jump(5.0)(reading, age_s) if age_s < 3.0 else reading

    state = boat.go(32.0, passing)
    assert boat.said[-1] == "gnss position is good again"
    assert state.position_age_s < 0.2 and state.distrusted == () and boat.off()[0] < 0.1


def test_a_receiver_that_comes_back_after_long_is_believed_where_the_boat_may_have_drifted() -> None:
    """0.25 m/s for 90 s: as much as a current that has turned does, and dead reckoning cannot know."""

    def gone(reading: Reading, age_s: float) -> Reading | None:
        if isinstance(reading, Imu):
            return reading
        return None if age_s < 90.0 else jump(22.0)(reading, age_s)

    boat = Afloat({}, Voyage(duration_s=113.0, speed_mps=0.0))
    state = boat.go(LIE_S + 89.0, gone)
    assert boat.off()[0] < 2.0
    assert state.position_accuracy_m > 5.0
    state = boat.go(LIE_S + 93.0, gone)
    assert boat.off()[0] == pytest.approx(22.0, abs=0.3)
    assert state.position_valid and not state.distrusted
    assert not any("not used" in text for text in boat.said)


@pytest.mark.parametrize("turn_radps", [1.0, -2.0])
def test_a_boat_that_begins_to_spin_is_told_of_no_lie(turn_radps: float) -> None:
    """Its inertial sensor sits a metre ahead of the origin, and swings round it: an axis of it was taken for reversed,
    the receiver's velocity for one that jumped, and the boat was 14 m off in the end."""
    voyage = Voyage(
        duration_s=40.0, speed_mps=math.copysign(0.3, turn_radps), radius_m=0.3 / abs(turn_radps), rests_s=25.0,
        imu_lever=(1.0, 0.3, -0.5), lever=(-0.8, 0.3, -2.0),
    )  # fmt: skip
    boat = Afloat({}, voyage)
    boat.go(40.0)
    assert boat.said == ["Heading source: gnss"]
    off_m, off_rad = boat.off()
    assert off_m < 0.05 and off_rad < math.radians(0.5)


def test_report_only_follows_as_ever() -> None:
    boat = afloat(NAV_INTEG=1)
    boat.go(30.0, jump(5.0))
    assert boat.said[0] == "gnss position jumped 5.0 m: still used"
    assert boat.off()[0] == pytest.approx(5.0, abs=0.2)


def test_disarmed_boats_are_carried_about() -> None:
    """No thrust is known while disarmed."""
    boat = Afloat({})
    told = [[jump(5.0)(r, 0.0) if r.t_s > LIE_S else r for r in row] for row in boat.rows[:3000]]
    for k, row in enumerate(told):
        boat.estimator.update([reading for reading in row if reading is not None], 0.01 * k)
    assert not any("used" in text for text in boat.said)


def test_an_estimate_that_no_boat_can_sail_begins_anew() -> None:
    """Whatever drove it there: the receivers are right then, and are believed again."""
    boat = afloat()
    inertial = boat.estimator.inertial
    assert inertial is not None
    inertial.filter.velocity = (3000.0, -2000.0, 0.0)
    state = boat.go(LIE_S + 6.0)
    assert [text for text in boat.said if "restarted" in text] == ["Estimate restarted: 3606 m/s is impossible"]
    assert state.position_valid and state.heading_valid and not state.distrusted
    assert boat.off()[0] < 0.5 and boat.off()[1] < math.radians(3.0)
    assert state.current_north_mps is None or abs(state.current_north_mps) < 1.0


def test_meanwhile_the_boat_is_said_to_be_where_it_was() -> None:
    """It went to the origin of the local plane on the operator's map, and came back when positions had agreed."""
    boat = Afloat({})
    boat.rows = [[north_by(one, 900.0) if isinstance(one, GnssFix) else one for one in row] for row in boat.rows]
    before = boat.go(LIE_S)
    inertial = boat.estimator.inertial
    assert inertial is not None
    inertial.filter.velocity = (3000.0, -2000.0, 0.0)
    places = []
    for k in range(1, 40):
        state = boat.go(LIE_S + 0.1 * k)
        places += [state] if not state.position_valid and any("restarted" in text for text in boat.said) else []
    assert len(places) > 3
    for state in places:
        assert state.position_accuracy_m > 100.0
        assert math.hypot(state.north_m - before.north_m, state.east_m - before.east_m) < 5.0
        assert (state.lat_deg, state.lon_deg) == pytest.approx((before.lat_deg, before.lon_deg), abs=1e-4)


@pytest.mark.parametrize("silent_s", [3.0, 6.0, 9.0])
def test_a_high_antenna_does_not_jump_as_the_inertial_sensor_falls_silent_or_is_back(silent_s: float) -> None:
    """Its place on the hull is taken off by roll and pitch, which are none without the sensor and unsure at first: a
    receiver 1.5 m up was 0.3 m aside at once and called a liar, here 0.5 m and 1.2 m/s."""

    def silent(reading: Reading, age_s: float) -> Reading | None:
        return None if isinstance(reading, Imu) and age_s < silent_s else reading

    boat = Afloat({}, Voyage(duration_s=45.0, speed_mps=1.5, radius_m=4.0, roll_rad=0.25, lever=(0.0, 0.0, -2.5)))
    boat.go(LIE_S - 0.1)
    boat.said.clear()
    assert boat.go(45.0, silent).position_valid
    assert not [text for text in boat.said if "not used" in text]


def test_of_two_receivers_that_come_apart_one_is_wrong_and_the_accuracy_says_so() -> None:
    """By so little that neither can be told from the forces. Until they agree again, the boat may be at either."""
    parameters = {"COM_POS_FS_EPH": 1.0}
    boat, config = Afloat(parameters, replace(DRIFTING, duration_s=65.0)), config_of(DRIFTING)
    spare = next(replace(row, name="spare") for row in config.sensors if row.name == "gnss")
    two = replace(config, sensors=(*config.sensors, spare))
    boat.estimator = Estimator(two, Parameters(parameters), lambda t_s, kind, name, text: boat.said.append(text))
    for row in boat.rows:
        row += [replace(reading, source="spare") for reading in row if isinstance(reading, GnssFix)]
    degree_m = 111_000.0

    def creeping(reading: Reading, age_s: float) -> Reading:
        if isinstance(reading, GnssFix) and reading.source == "gnss":
            return replace(reading, lat_deg=reading.lat_deg + 0.04 * age_s / degree_m)
        return reading

    before, after = boat.go(LIE_S), boat.go(60.0, creeping)
    assert before.position_valid and before.position_accuracy_m < 0.1
    assert after.position_accuracy_m == pytest.approx(1.6, abs=0.2) and not after.position_valid
    assert any("m from" in text for text in boat.said)
