"""Measurements that come late, with the right times: from a receiver over a radio or a loaded hub."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from companion.core.geodesy import LocalFrame
from companion.core.readings import Imu, Reading
from companion.nav.error_state import ErrorStateFilter
from companion.nav.estimator import Estimator
from companion.nav.lever_arms import ZERO
from companion.nav.way_back import NOTHING, WayBack
from companion.params.store import Parameters
from tests.unit.nav.boat_truth import IMU_HZ, Passage, Voyage, config_of, navigate, readings_of, rms, sail

G = 9.82


def test_before_the_first_sample_nothing_is_known() -> None:
    assert WayBack().since(0.0, ErrorStateFilter(G), ZERO) == NOTHING


def circled(tilted_rad: float) -> tuple[WayBack, ErrorStateFilter]:
    """Two seconds on a circle of 5 m at 2 m/s, level, by a filter that has learnt only now how its sensor is tilted."""
    turn, back = 0.4, WayBack()
    force = (G * math.sin(tilted_rad), 0.8, -G * math.cos(tilted_rad))
    rates = (-turn * math.sin(tilted_rad), 0.0, turn * math.cos(tilted_rad))
    for k in range(201):
        back.take(k / 100, force, rates, 0.01)
    filter_ = ErrorStateFilter(G)
    yaw = turn * 2.0
    velocity = 2.0 * math.cos(yaw), 2.0 * math.sin(yaw), 0.0
    filter_.start(ZERO, velocity, (0.0, tilted_rad, yaw), [0.1] * 15)
    filter_.rates = rates
    return back, filter_


@pytest.mark.parametrize("tilted_rad", [0.0, 0.1])
def test_the_way_back_is_as_bent_as_the_boat_went(tilted_rad: float) -> None:
    back, filter_ = circled(tilted_rad)
    since = back.since(1.005, filter_, ZERO)
    now, then = 0.8, 0.4 * 1.005
    assert since.north_m == pytest.approx(5.0 * (math.sin(now) - math.sin(then)), abs=0.01)
    assert since.east_m == pytest.approx(5.0 * (math.cos(then) - math.cos(now)), abs=0.01)
    assert since.north_mps == pytest.approx(2.0 * (math.cos(now) - math.cos(then)), abs=0.01)
    assert since.east_mps == pytest.approx(2.0 * (math.sin(now) - math.sin(then)), abs=0.01)
    assert since.turned_rad == pytest.approx(now - then, abs=0.01)


def test_before_the_sample_that_is_nearest_the_velocity_changed_as_it_lately_does() -> None:
    """It counted as that of the sample: up to a step of a slow sensor too late."""
    back, filter_ = WayBack(), ErrorStateFilter(G)
    for k in range(21):
        back.take(0.1 * k, (0.5, 0.0, -G), (0.0, 0.0, 0.0), 0.1)
    filter_.velocity, filter_.gaining = (2.0, 1.0, 0.0), (0.5, 0.25)
    since = back.since(1.95, filter_, ZERO)
    assert (since.north_mps, since.east_mps) == pytest.approx((0.05 * 0.5, 0.05 * 0.25))
    assert (since.north_m, since.east_m) == pytest.approx((0.05 * 2.0, 0.05 * 1.0))


@pytest.mark.parametrize("delay", [30, 80, 100])
@pytest.mark.parametrize("radius_m", [5.0, 15.0])
def test_what_comes_late_with_the_right_time_is_as_good(delay: int, radius_m: float) -> None:
    """Velocities were taken as of now: 0.8 s late the boat was up to 2.9 m off."""
    voyage = Voyage(speed_mps=2.0, radius_m=radius_m, seed=722500)
    position, yaw, velocity = navigate(voyage, delay=delay, config=config_of(voyage)).errors(20.0)
    assert position.max() < 0.1
    assert rms(velocity) < 0.03
    assert math.degrees(rms(yaw)) < 0.3


def sailed(voyage: Voyage, lag_s: float, each_s: float = 0.0) -> tuple[Passage, list[str]]:
    """What the receiver says comes `lag_s` late, or is kept until the next full `each_s`."""
    config, truth, texts = config_of(voyage), sail(voyage), []
    estimator = Estimator(config, Parameters(), lambda now_s, kind, key, text: texts.append(text))
    said = readings_of(voyage, truth, LocalFrame(config.home.lat_deg, config.home.lon_deg))
    passage, kept = Passage(truth, [], []), list[tuple[float, Reading]]()
    batch: list[Reading] = []
    for k, row in enumerate(said):
        t_s = k / IMU_HZ
        arrives_s = math.ceil(t_s / each_s) * each_s if each_s else t_s + lag_s
        batch += [r for r in row if isinstance(r, Imu)]
        kept += [(arrives_s, r) for r in row if not isinstance(r, Imu)]
        batch += [r for at_s, r in kept if at_s <= t_s + 1e-6]
        kept = [(at_s, r) for at_s, r in kept if at_s > t_s + 1e-6]
        if k % 10 == 0:
            passage.states.append(estimator.update(batch, t_s))
            passage.rows.append(k)
            batch = []
    return passage, texts


def test_bursts_are_as_good_as_each_by_itself() -> None:
    passage, _ = sailed(Voyage(speed_mps=2.0, radius_m=15.0, seed=722502), 0.0, each_s=1.0)
    assert passage.errors(20.0)[0].max() < 0.1
    assert rms(passage.errors(20.0)[2]) < 0.03


def test_a_receiver_that_comes_late_is_not_told_to_be_wrong_by_its_times() -> None:
    voyage = Voyage(speed_mps=2.0, radius_m=15.0, seed=722503)
    _, texts = sailed(voyage, 0.3)
    assert not [text for text in texts if "late" in text]


def test_a_receiver_that_is_too_late_is_told() -> None:
    passage, texts = sailed(Voyage(speed_mps=1.0, radius_m=15.0, seed=722504), 1.5)
    assert [text for text in texts if "late" in text] == ["gnss comes 1.5 s late: not used"]
    assert not passage.states[-1].position_valid
    assert all(len(text) <= 50 for text in texts)
    assert np.isfinite(passage.errors(0.0)[0]).all()


def beside_a_spare(voyage: Voyage, arrives_s: Callable[[float], float]) -> tuple[Passage, list[str]]:
    """Two receivers; what the first says of a time comes at `arrives_s`."""
    config, truth, texts = config_of(voyage), sail(voyage), []
    receiver, imu = config.sensors
    config = replace(config, sensors=(receiver, replace(receiver, name="spare"), imu))
    estimator = Estimator(config, Parameters(), lambda now_s, kind, key, text: texts.append(text))
    said = readings_of(voyage, truth, LocalFrame(config.home.lat_deg, config.home.lon_deg))
    passage, kept, batch = Passage(truth, [], []), list[Reading](), list[Reading]()
    for k, row in enumerate(said):
        t_s = k / IMU_HZ
        of_receiver = [r for r in row if not isinstance(r, Imu)]
        kept += of_receiver
        batch += [r for r in row if isinstance(r, Imu)]
        batch += [r for r in kept if arrives_s(r.t_s) <= t_s + 1e-6]
        batch += [replace(r, source="spare") for r in of_receiver]
        kept = [r for r in kept if arrives_s(r.t_s) > t_s + 1e-6]
        if k % 10 == 0:
            passage.states.append(estimator.update(batch, t_s))
            passage.rows.append(k)
            batch = []
    return passage, texts


def test_a_line_that_was_held_up_once_is_no_receiver_that_is_too_late() -> None:
    """One fix out of a backlog was told to come late, and another receiver took over for it."""

    def arrives_s(t_s: float) -> float:
        return 31.6 + 0.5 * (t_s - 30.0) if 30.0 <= t_s < 31.6 else t_s

    passage, texts = beside_a_spare(Voyage(duration_s=50.0, radius_m=15.0, seed=724020), arrives_s)
    assert not [text for text in texts if "late" in text or "Position source" in text]
    assert passage.errors(20.0)[0].max() < 0.1


def test_another_receiver_takes_over_all_that_one_gives_that_is_too_late() -> None:
    """Its velocities and headings were still those in use, and nothing measured either."""
    passage, texts = beside_a_spare(Voyage(radius_m=15.0, seed=724022), lambda t_s: t_s + (1.5 if t_s > 20.0 else 0.0))
    assert [text for text in texts if "late" in text] == ["gnss comes 1.4 s late: not used"]
    assert passage.states[-1].heading_age_s < 0.5
    assert passage.errors(20.0)[0].max() < 0.1
    assert rms(passage.errors(20.0)[2]) < 0.03


def test_a_receiver_that_fell_silent_late_is_not_told_to_be_late_ever_since() -> None:
    """Its line held up the last fixes before a silence, and the first ones after it: the time between counted."""

    def arrives_s(t_s: float) -> float:
        if 20.0 <= t_s < 20.3 or 40.0 <= t_s < 40.3:
            return t_s + 1.6
        return math.inf if 20.3 <= t_s < 45.0 else t_s

    voyage = Voyage(duration_s=50.0, radius_m=15.0, seed=725720)
    _, texts = beside_a_spare(voyage, arrives_s)
    assert not [text for text in texts if "late" in text]
