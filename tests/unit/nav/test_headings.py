"""The heading source in use and its accuracy."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config import vessel as vessel_config
from companion.core.decision import TextKind
from companion.core.geomagnetism import declination_rad
from companion.core.readings import FixType, GnssFix, GroundVelocity, Heading, HeadingBy, Imu, Reading
from companion.nav.estimator import Estimator
from companion.nav.headings import HeadingSources, TrueHeading
from companion.params.store import Parameters
from tests.unit.nav.boat_truth import Voyage, navigate

REVOLT = vessel_config.load(vessel_config.find("revolt"))
PLACE = (63.4389, 10.3990, 1_780_315_200_000_000_000)


class Listener:
    """Heading sources of a vessel with a baseline and a compass, and what they announce."""

    def __init__(self) -> None:
        self.said: list[tuple[TextKind, str]] = []
        self.sources = HeadingSources(REVOLT, lambda _t, severity, name, text: self.said.append((severity, text)))

    def hear(
        self, t_s: float, source: str, yaw_rad: float, by: HeadingBy, accuracy_rad: float | None = None
    ) -> TrueHeading | None:
        measured = self.sources.measured(Heading(t_s, source, yaw_rad, accuracy_rad, by), *PLACE)
        return None if measured is None else self.sources.offer(measured)


def test_a_magnetic_heading_is_made_true() -> None:
    found = Listener().hear(0.0, "imu", math.radians(-178.0), HeadingBy.MAGNETIC)
    assert found is not None
    assert math.degrees(found.yaw_rad) == pytest.approx(-178.0 + 5.236, abs=0.01)  # WMM2025 for Trondheim, June 2026
    assert found.sigma_rad > found.slow_sigma_rad >= math.radians(2.0)
    compass = Listener().hear(0.0, "imu", 1.0, HeadingBy.COMPASS)
    assert compass is not None and compass.yaw_rad == 1.0


def test_a_file_tells_the_noise_of_headings() -> None:
    """A compass whose file tells none counts as three times as noisy as it is accurate."""
    noise_rad = math.radians(0.05)
    gnss, imu = (replace(row, heading_noise_rad=noise_rad) for row in REVOLT.sensors)
    sources = HeadingSources(replace(REVOLT, sensors=(gnss, imu)), lambda *_: None)
    compass = Heading(0.0, "imu", 1.0, 0.02, HeadingBy.COMPASS)
    told, untold = sources.measured(compass, *PLACE), HeadingSources(REVOLT, lambda *_: None).measured(compass, *PLACE)
    baseline = sources.measured(Heading(0.0, "gnss", 1.0, 0.02, HeadingBy.BASELINE), *PLACE)
    assert told is not None and untold is not None and baseline is not None
    assert told.sigma_rad == baseline.sigma_rad == noise_rad
    assert untold.sigma_rad == pytest.approx(0.06) and told.wander_rad == untold.wander_rad


def test_near_the_magnetic_pole_a_magnetic_heading_is_ignored() -> None:
    sources = HeadingSources(REVOLT, lambda *_: None)
    assert declination_rad(86.0, 142.0, 2026.4) is None
    assert sources.measured(Heading(0.0, "imu", 1.0, None, HeadingBy.MAGNETIC), 86.0, 142.0, PLACE[2]) is None


def test_baseline_before_compass_and_back_after_a_while() -> None:
    """Both on one device too: the rank is by kind, then by the vessel's file."""
    listener = Listener()
    assert listener.hear(0.0, "gnss", 1.0, HeadingBy.BASELINE) is not None
    assert listener.hear(0.1, "imu", 1.1, HeadingBy.MAGNETIC) is None
    assert listener.hear(0.1, "gnss", 1.1, HeadingBy.COMPASS) is None
    fallen = listener.hear(2.5, "imu", 1.0, HeadingBy.COMPASS)  # time-out of the receiver is 2 s
    assert fallen is not None and fallen.added_sigma_rad == fallen.slow_sigma_rad > 0.0
    back = []
    for k in range(80):
        t_s = 3.0 + 0.1 * k
        listener.hear(t_s, "imu", 1.0, HeadingBy.COMPASS)
        back.append(listener.hear(t_s, "gnss", 1.0, HeadingBy.BASELINE))
    first = next(found for found in back if found is not None)
    assert back.index(first) == pytest.approx(50, abs=1)
    assert first.added_sigma_rad == pytest.approx(
        math.radians(2.1)
    )  # the compass's slow error is still in the estimate
    assert [severity for severity, _ in listener.said] == [TextKind.ROUTINE, TextKind.ATTENTION, TextKind.ROUTINE]
    assert [text for _, text in listener.said] == [
        "Heading source: gnss",
        "Heading source: imu compass (gnss lost)",
        "Heading source: gnss",
    ]


def test_course_is_the_last_resort() -> None:
    listener = Listener()
    listener.hear(0.0, "gnss", 1.0, HeadingBy.BASELINE)
    north = GroundVelocity(1.5, "gnss", 1.5, 0.0)
    assert listener.sources.course(north) is None  # there was a heading 1.5 s ago
    assert listener.sources.course(replace(north, t_s=3.0, north_mps=0.9)) is None  # too slow to mean anything
    found = listener.sources.course(replace(north, t_s=3.1, east_mps=1.5))
    assert found is not None and found.yaw_rad == pytest.approx(math.pi / 4.0) and found.sigma_rad > math.radians(10.0)
    assert listener.sources.course(replace(north, t_s=3.5)) is None  # once a second
    slow = listener.sources.course(replace(north, t_s=4.2, north_mps=0.75))
    assert slow is not None and found is not None and slow.sigma_rad > found.sigma_rad  # slowed by a turn, in use
    assert listener.sources.course(replace(north, t_s=5.3, north_mps=0.65)) is None
    assert listener.sources.course(replace(north, t_s=6.5, north_mps=0.9)) is None  # no longer in use
    assert listener.said[-1][0] is TextKind.ATTENTION and "course over ground" in listener.said[-1][1]


def test_course_does_not_wait_for_a_heading_that_lies() -> None:
    listener = Listener()
    listener.hear(0.0, "gnss", 1.0, HeadingBy.BASELINE)
    north = GroundVelocity(0.5, "gnss", 1.5, 0.0)
    assert listener.sources.course(north) is None
    assert listener.sources.course(north, blind=True) is not None


def at_rest(compass: HeadingBy, offset_rad: float) -> tuple[Estimator, list[str]]:
    """A minute at rest, bow 0.7 rad, with a receiver of one antenna and an inertial sensor with a compass."""
    said: list[str] = []
    estimator = Estimator(REVOLT, Parameters(), lambda _t, _severity, _name, text: said.append(text))
    for k in range(600):
        t_s = 0.1 * k
        row: list[Reading] = [Imu(t_s - 0.01 * j, "imu", 0.0, 0.0, -9.8217, 0.0, 0.0, 0.0) for j in range(9, -1, -1)]
        row.append(GnssFix(t_s, "gnss", 63.4389, 10.3990, 12.0, FixType.RTK_FIXED, 12, 0.8, 0.02))
        row.append(GroundVelocity(t_s, "gnss", 0.0, 0.0))
        row.append(Heading(t_s, "imu", 0.7 - offset_rad, None, compass))
        estimator.update(row, t_s)
    return estimator, said


@pytest.mark.parametrize("by", [HeadingBy.COMPASS, HeadingBy.MAGNETIC])
def test_a_boat_with_a_compass_alone_has_a_heading_at_rest(by: HeadingBy) -> None:
    declination = declination_rad(63.4389, 10.3990, 2027.5) if by is HeadingBy.MAGNETIC else 0.0
    assert declination is not None
    estimator, said = at_rest(by, declination)
    state = estimator.update([], 60.0)
    assert state.heading_valid and state.position_valid
    assert state.yaw_rad == pytest.approx(0.7, abs=math.radians(0.2))
    assert math.degrees(state.heading_accuracy_rad) > 1.8  # a compass's slow error does not average away in a minute
    assert said == ["Heading source: imu compass"]


def test_the_gyro_carries_the_heading_while_positions_come() -> None:
    """A minute without any heading: valid for as long as the filter is sure, and as good as it says."""

    def no_heading(k: int, row: list[Reading]) -> list[Reading]:
        return [reading for reading in row if not isinstance(reading, Heading)] if 40.0 <= row[0].t_s < 100.0 else row

    passage = navigate(Voyage(duration_s=105.0, speed_mps=0.0, seed=3), no_heading)
    assert all(state.heading_valid for state in passage.states if state.t_s > 35.0)
    states = {round(state.t_s, 1): state for state in passage.states}
    assert states[99.0].heading_age_s == pytest.approx(59.05, abs=0.01)
    error = passage.errors(98.0, 99.9)[1].max()
    assert error < 3.0 * states[99.0].heading_accuracy_rad
    assert math.degrees(states[99.0].heading_accuracy_rad) < 3.0


def test_from_baseline_to_compass_and_back_there_is_no_jump() -> None:
    """The compass is 4° off: the heading goes over slowly, and is right again within a second of the baseline's
    return."""

    def lose(_: int, row: list[Reading]) -> list[Reading]:
        t_s = row[0].t_s
        heading = [reading for reading in row if isinstance(reading, Heading)]
        if not heading:
            return row
        compass = Heading(
            t_s, "imu", math.remainder(heading[0].yaw_rad + math.radians(4.0), 2.0 * math.pi), None, HeadingBy.COMPASS
        )
        return [reading for reading in row if not (isinstance(reading, Heading) and 40.0 <= t_s < 60.0)] + [compass]

    passage = navigate(Voyage(duration_s=75.0, seed=4), lose, tick_every=5)
    position, yaw, _ = passage.errors(38.0)
    assert math.degrees(yaw.max()) < 4.5 and position.max() < 0.12
    steps = [
        math.remainder(b.yaw_rad - a.yaw_rad, 2.0 * math.pi)
        for a, b in zip(passage.states, passage.states[1:], strict=False)
    ]
    jumps = [abs(step) for step, state in zip(steps, passage.states, strict=False) if 38.0 < state.t_s < 60.0]
    assert math.degrees(max(jumps)) < 1.5
    assert math.degrees(passage.errors(67.0)[1].max()) < 1.0
