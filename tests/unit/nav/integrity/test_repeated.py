"""Sources that repeat themselves."""

from __future__ import annotations

import math
import random

import pytest

from companion.core.readings import MagneticField, Wind
from companion.nav.integrity.evidence import Channel, Evidence, Sense
from companion.nav.integrity.repeated import Repeated
from tests.unit.nav.integrity.seen import METRE_DEG, heading, imu, inertial, position, sail, velocity

FROM_S = 10.0


def moving(k: int, now_s: float, rng: random.Random) -> Evidence:
    """An evidence whose boat moves and turns; two fixes, velocities and headings a tick are added by the tests."""
    return Evidence(inertial=inertial(0.02 * k, 0.0, 0.01 * k), north_mps=0.1, east_mps=0.0)


def fixes(frozen_s: float, resolution_m: float = 0.0, speed_mps: float = 0.1):  # type: ignore[no-untyped-def]
    def make(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence = moving(k, now_s, rng)
        evidence.north_mps = speed_mps
        for i in range(2):
            t_s = now_s + 0.05 * i - 0.05
            north_m = speed_mps * min(t_s, frozen_s) + (rng.gauss(0.0, 0.005) if t_s < frozen_s else 0.0)
            if resolution_m:
                north_m = round(north_m / resolution_m) * resolution_m
            evidence.positions.append(position(t_s, north_m))
        return evidence

    return make


def test_a_frozen_position_is_found_within_a_second() -> None:
    found = sail(Repeated(), fixes(FROM_S))
    assert found is not None
    assert found[0] - FROM_S < 1.0
    assert found[1].channel == Channel(Sense.POSITION, "gnss")
    assert found[1].fault == "repeats" and not found[1].asks
    assert found[1].since_s == pytest.approx(FROM_S, abs=0.1)


def test_a_coarse_receiver_on_a_slow_boat_is_believed() -> None:
    """Steps of 20 cm at 1 cm/s: the same position for 20 s."""
    assert sail(Repeated(), fixes(1e9, resolution_m=0.2, speed_mps=0.01), 120.0) is None


def test_a_boat_that_lies_still_may_have_a_receiver_that_does() -> None:
    assert sail(Repeated(), fixes(FROM_S, speed_mps=0.0)) is None


def test_nothing_is_judged_while_disarmed() -> None:
    repeated, rng = Repeated(), random.Random(1)
    make = fixes(FROM_S)
    for k in range(1, 300):
        assert not repeated.update(make(k, 0.1 * k, rng), 0.1 * k)


def test_velocity_and_heading() -> None:
    def make(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence, live = moving(k, now_s, rng), now_s < FROM_S
        evidence.velocities.append(velocity(now_s, rng.gauss(0.0, 0.1) if live else 0.123))
        evidence.headings.append(heading(now_s, rng.gauss(0.0, 0.1)))
        return evidence

    found = sail(Repeated(), make)
    assert found is not None and found[1].channel == Channel(Sense.VELOCITY, "gnss")

    def turned(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence, live = moving(k, now_s, rng), now_s < FROM_S
        evidence.inertial = None  # without a gyro nothing excuses repeats
        evidence.headings.append(heading(now_s, rng.gauss(0.0, 0.1) if live else 0.1, None))
        return evidence

    found = sail(Repeated(), turned)
    assert found is not None and found[1].channel == Channel(Sense.HEADING, "gnss")


def test_a_sample_of_an_inertial_sensor_within_half_a_second() -> None:
    def make(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence = moving(k, now_s, rng)
        for i in range(10):
            t_s = now_s + 0.01 * i - 0.09
            values = [rng.gauss(0.0, 0.01) for _ in range(6)] if t_s < FROM_S else [0.1] * 6
            evidence.raw_imu.append(imu(t_s, values))
        return evidence

    found = sail(Repeated(), make)
    assert found is not None and found[1].channel == Channel(Sense.IMU, "imu")
    assert found[0] - FROM_S <= 0.5


def test_fields_and_winds() -> None:
    def make(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence, live = moving(k, now_s, rng), now_s < FROM_S
        x = rng.random() if live else 0.5
        evidence.fields.append(MagneticField(now_s, "imu", x, 0.0, 1.0))
        return evidence

    found = sail(Repeated(), make)
    assert found is not None and found[1].channel == Channel(Sense.FIELD, "imu")

    def winds(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence = moving(k, now_s, rng)
        evidence.winds.append(Wind(now_s, "wind", 3.0 + (rng.random() if now_s < FROM_S else 0.0), 1.0))
        return evidence

    found = sail(Repeated(), winds, 40.0)
    assert found is not None and found[1].channel == Channel(Sense.WIND, "wind")
    assert found[0] - FROM_S >= 10.0


def test_a_calm_repeats() -> None:
    def make(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence = moving(k, now_s, rng)
        evidence.winds.append(Wind(now_s, "wind", 0.0, 0.0))
        return evidence

    assert sail(Repeated(), make, 60.0) is None


def test_the_resolution_is_of_the_receiver() -> None:
    assert pytest.approx(1.0) == METRE_DEG * 111_000.0


def test_a_boat_that_comes_back_does_not_excuse_a_frozen_receiver() -> None:
    """To and fro by 10 cm: it stays found, also where the boat is at its place again."""

    def make(k: int, now_s: float, rng: random.Random) -> Evidence:
        evidence = moving(k, now_s, rng)
        north_m = 0.1 * math.sin(now_s)
        evidence.north_mps = 0.1 * math.cos(now_s)
        evidence.positions.append(position(now_s, north_m + rng.gauss(0.0, 0.005) if now_s < FROM_S else 0.07))
        return evidence

    hypothesis, rng, found = Repeated(), random.Random(1), []
    for k in range(1, 400):
        evidence = make(k, 0.1 * k, rng)
        evidence.driven = True
        found.append(bool(hypothesis.update(evidence, 0.1 * k)))
    first = found.index(True)
    assert 0.1 * first < FROM_S + 3.0 and all(found[first:])
