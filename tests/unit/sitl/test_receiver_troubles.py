"""Honest troubles of receivers: late, jittering, missing and reflected solutions."""

from __future__ import annotations

import itertools
import math
import statistics

import pytest

from companion.config.vessel import find, load
from companion.core.geodesy import LocalFrame
from sitl.faults import Faults
from sitl.receiver_troubles import ReceiverTroubles
from sitl.sensors import FLOAT, GnssSample

VESSEL = load(find("revolt"))
FRAME = LocalFrame(VESSEL.home.lat_deg, VESSEL.home.lon_deg)
DT_S = 0.05


def troubled(*texts: str) -> ReceiverTroubles:
    faults = Faults(texts, VESSEL)
    faults.update(1.0)
    return ReceiverTroubles(faults, "gnss", VESSEL.home, DT_S, 3)


def sample(t_s: float) -> GnssSample:
    return GnssSample(FLOAT, (*FRAME.to_geodetic(t_s, 0.0), 1.0), t_s, 0.0, 0.1 * t_s)


def sent(troubles: ReceiverTroubles, count: int = 100) -> list[tuple[float, GnssSample]]:
    found = []
    for k in range(count):
        t_s = DT_S * k
        solution = troubles.sent(sample(t_s), t_s)
        if solution is not None:
            found.append((t_s, solution))
    return found


def test_without_a_trouble_all_is_sent_as_it_was_measured() -> None:
    troubles = troubled()
    assert [solution == sample(t_s) for t_s, solution in sent(troubles)] == [True] * 100
    assert troubles.arrival_s(7.0) == 7.0


def test_late_values_are_those_of_then() -> None:
    ages_s = [t_s - solution.north_mps for t_s, solution in sent(troubled("gnss_late=0.3@0"))[6:]]
    assert ages_s == pytest.approx([0.3] * 94)
    assert sent(troubled("gnss_late:gnss=0.3@0"))[50][1].heading_rad == pytest.approx(0.1 * (2.5 - 0.3))
    assert sent(troubled("gnss_late:imu=0.3@0"))[50][1] == sample(2.5)  # another device


def test_values_can_be_late_by_seconds() -> None:
    ages_s = [t_s - solution.north_mps for t_s, solution in sent(troubled("gnss_late=5@0"), 400)[101:]]
    assert ages_s == pytest.approx([5.0] * 299)


def test_a_share_is_left_out() -> None:
    assert len(sent(troubled("gnss_dropped=0.3@0"), 4000)) == pytest.approx(2800, abs=100)


def test_jitter_delays_and_keeps_the_order() -> None:
    troubles = troubled("gnss_jitter=0.1@0")
    late_s = [troubles.arrival_s(0.2 * k) - 0.2 * k for k in range(500)]
    assert min(late_s) >= 0.0 and max(late_s) <= 0.1 and statistics.fmean(late_s) == pytest.approx(0.05, abs=0.01)
    close = [troubles.arrival_s(200.0 + 0.01 * k) for k in range(500)]
    assert close == sorted(close)


def test_multipath_has_its_size_and_comes_and_goes() -> None:
    norths = []
    for t_s, solution in sent(troubled("gnss_multipath=0.5@0"), 20_000):
        assert solution.position is not None
        norths.append(FRAME.to_ned(*solution.position[:2])[0] - t_s)
    assert math.sqrt(statistics.fmean(north * north for north in norths)) == pytest.approx(0.5, abs=0.2)
    steps = [abs(b - a) for a, b in itertools.pairwise(norths)]
    assert max(steps) < 0.2


def test_multipath_takes_as_long_where_solutions_are_left_out() -> None:
    lag, values = 200, {}
    for t_s, solution in sent(troubled("gnss_multipath=0.5@0", "gnss_dropped=0.7@0"), 200_000):
        assert solution.position is not None
        values[round(t_s / DT_S)] = FRAME.to_ned(*solution.position[:2])[0] - t_s
    pairs = [(value, values[k + lag]) for k, value in values.items() if k + lag in values]
    alike = sum(a * b for a, b in pairs) / sum(a * a for a, _ in pairs)
    assert alike == pytest.approx(math.exp(-lag * DT_S / 20.0), abs=0.12)
