"""How late a receiver is, on a small truth of its own: a boat that snakes and changes its speed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from companion.core.readings import Imu
from companion.nav.error_state import FilterNoise
from companion.nav.inertial import InertialSolution
from companion.nav.lever_arms import ZERO
from companion.nav.measured_off import Wander
from companion.nav.receiver_latency import LatencyFound, ReceiverLatency
from companion.nav.solution import Motion

G = 9.82
HZ, EVERY = 100, 10


@dataclass
class Sailed:
    """Findings with their times, and the largest errors in the last 20 s: position in m, heading in rad."""

    found: list[tuple[float, LatencyFound]] = field(default_factory=list)
    off_m: float = 0.0
    off_rad: float = 0.0
    unsettled_s: list[float] = field(default_factory=list)
    latency: ReceiverLatency = field(default_factory=ReceiverLatency)


def sail(late_s: float, seed: int = 1, swing_rad: float = 0.6, turned_rad: float = 0.0, from_s: float = 0.0) -> Sailed:
    """Sail with the latency watched and used. `swing_rad`: to each side; `turned_rad`: error of all headings; `from_s`:
    when the receiver becomes late."""
    draw = np.random.default_rng(seed)
    t = np.arange(110 * HZ) / HZ
    slow = np.clip(t / 10.0, 0.0, 1.0)  # from rest
    yaw, speed = swing_rad * slow * np.sin(0.35 * t), 3.0 * slow + np.sin(0.21 * t) * slow
    velocity = np.stack([speed * np.cos(yaw), speed * np.sin(yaw)], axis=1)
    position = np.cumsum(velocity, axis=0) / HZ
    change, turn = np.gradient(velocity, 1.0 / HZ, axis=0), np.gradient(yaw, 1.0 / HZ)
    c, s = np.cos(yaw), np.sin(yaw)
    ahead = c * change[:, 0] + s * change[:, 1] + 0.01 + 0.01 * draw.standard_normal(len(t))
    starboard = c * change[:, 1] - s * change[:, 0] - 0.01 + 0.01 * draw.standard_normal(len(t))
    rate = turn + 1e-3 + 1e-3 * draw.standard_normal(len(t))
    solution = InertialSolution(G, ZERO, FilterNoise(0.001, 1e-4))
    solution.expect_wander(Wander(0.008, 100.0), another=False)
    solution.filter.expect_heading_wander(Wander(math.radians(0.1), 60.0))
    solution.filter.expect_late(0.15)
    solution.filter.heading_late = True
    sailed = Sailed()
    for k in range(len(t)):
        solution.sample(Imu(float(t[k]), "imu", float(ahead[k]), float(starboard[k]), -G, 0.0, 0.0, float(rate[k])))
        if k == 2 * HZ:
            begun = Motion(float(t[k]), (*position[k].tolist(), 0.0), (*velocity[k].tolist(), 0.0), (0.0, 0.0, yaw[k]),
                           ZERO, 0.02, 0.1, 0.01)  # fmt: skip
            solution.start(begun, (0.0, 0.0))
        if k <= 2 * HZ or k % EVERY:
            continue
        is_late_s = late_s if t[k] >= from_s else 0.0
        then = min(max(k - round((is_late_s - sailed.latency.late_s("gnss")) * HZ), 0), len(t) - 1)
        noise = draw.standard_normal(5)
        north, east = (position[then] + 0.01 * noise[:2]).tolist()
        heading = float(yaw[then]) + turned_rad + math.radians(0.2) * float(noise[4])
        solution.position(float(t[k]), north, east, ZERO, 0.02)
        solution.velocity(float(t[k]), *(velocity[then] + 0.02 * noise[2:4]).tolist(), ZERO, 0.02)
        sailed.latency.heading(solution, float(t[k]), heading)
        solution.heading(float(t[k]), heading, math.radians(0.3))
        found = sailed.latency.update(solution, "gnss")
        if found is not None:
            sailed.found.append((float(t[k]), found))
        if sailed.latency.unsettled("gnss"):
            sailed.unsettled_s.append(float(t[k]))
        if t[k] > 90.0:
            motion = solution.motion(float(t[k]))
            off = motion.position[0] - position[k, 0], motion.position[1] - position[k, 1]
            sailed.off_m = max(sailed.off_m, math.hypot(*off))
            sailed.off_rad = max(sailed.off_rad, abs(motion.attitude[2] - float(yaw[k])))
    return sailed


@pytest.mark.parametrize("turned_rad", [0.0, math.radians(5.0)])
def test_of_a_receiver_that_is_as_its_row_says_nothing_is_found(turned_rad: float) -> None:
    sailed = sail(0.0, turned_rad=turned_rad)
    assert not sailed.found and sailed.latency.late_s("gnss") == 0.0
    assert not sailed.unsettled_s


@pytest.mark.parametrize("late_s", [0.3, -0.15])
def test_a_late_receiver_is_found_and_taken_out(late_s: float) -> None:
    sailed = sail(late_s)
    (t_s, found), *more = sailed.found
    assert not more and found.late_s == pytest.approx(late_s, abs=0.06) and t_s < 40.0
    assert sailed.latency.late_s("gnss") == pytest.approx(found.late_s, abs=1e-6)
    assert sailed.off_m < 0.1 and math.degrees(sailed.off_rad) < 0.4  # untouched: 1.2 m, 3.6 degrees
    assert found.text(0.1) == f"gnss is {0.1 + found.late_s:.2f} s late: the file says 0.10"


def test_a_receiver_that_becomes_late_under_way_is_found_and_taken_out() -> None:
    """The filter knew its latency to milliseconds, and has taken the jump of positions for a slow error."""
    sailed = sail(0.3, from_s=45.0)
    assert sailed.found[0][0] > 45.0 and sailed.off_m < 0.1 and math.degrees(sailed.off_rad) < 0.4


def test_of_another_receiver_nothing_is_known() -> None:
    assert sail(0.3).latency.late_s("other") == 0.0


def test_what_is_too_large_is_no_latency() -> None:
    assert not sail(0.8).found


def test_it_has_to_come_to_the_same_twice() -> None:
    before = LatencyFound("gnss", 0.3, 0.02)
    assert LatencyFound("gnss", 0.25, 0.02).agrees(before)
    assert not LatencyFound("gnss", -0.3, 0.02).agrees(before)
    joined = LatencyFound("gnss", 0.25, 0.04).joined(before)
    assert joined.late_s == pytest.approx(0.29) and joined.sigma_s == pytest.approx(0.02 * math.sqrt(0.8))


def test_its_times_are_in_doubt_from_when_it_is_seen_until_all_has_gone_over() -> None:
    sailed = sail(0.3)
    (t_s, found), *_ = sailed.found
    assert sailed.unsettled_s[0] < t_s and sailed.unsettled_s[-1] == pytest.approx(
        t_s + found.late_s / 0.1 + 2.0, abs=0.3
    )
    assert not sailed.latency.unsettled(None)
