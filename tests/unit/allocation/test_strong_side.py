"""A thruster that has long pushed hard astern turns round to push ahead, where it is stronger, and pushes meanwhile."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.allocation.allocator import Allocator
from companion.allocation.geometry import thrusters_of
from companion.allocation.strong_side import StrongSide
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.params.store import Parameters

ABOAT, REVOLT = load(find("aboat")), load(find("revolt"))
DT_S = 0.1


def settled(a: Allocator, wrench: Wrench, for_s: float) -> list[Allocation]:
    return [a.update(wrench, DT_S) for _ in range(round(for_s / DT_S))]


def pushed_astern(config: VesselConfig = ABOAT) -> Allocator:
    """ÅBOAT after a moment to port: its stern thruster points to port and pushes to starboard in reverse."""
    a = Allocator(config, Parameters(config.parameters))
    settled(a, Wrench(0.0, 0.0, 60.0), 5.0)
    before = settled(a, Wrench(0.0, 150.0, 0.0), 3.0)[-1]
    assert min(command.force_n for command in before.thrusters) < -50.0, "the case is no longer that of this test"
    return a


def test_a_rising_wind_gets_the_full_thrust_of_both_thrusters() -> None:
    a = pushed_astern()
    settled(a, Wrench(0.0, 250.0, 0.0), 20.0)
    full = settled(a, Wrench(0.0, ABOAT.limits.sway_n, 0.0), 5.0)[-1]
    assert all(command.force_n > 0.0 for command in full.thrusters)
    assert full.achieved.sway_n == pytest.approx(ABOAT.limits.sway_n, rel=0.02)


def test_thrusters_that_hardly_reverse_turn_round_too() -> None:
    a = pushed_astern(reversing(80.0))
    full = settled(a, Wrench(0.0, 250.0, 0.0), 20.0)[-1]
    assert all(command.force_n > 0.0 for command in full.thrusters)
    assert full.achieved.sway_n == pytest.approx(250.0, rel=0.02)


def that_turns() -> Allocator:
    """ÅBOAT with a stern thruster that has just begun to turn to its strong side."""
    a, across = pushed_astern(), Wrench(0.0, 200.0, 0.0)
    while abs(a.update(across, DT_S).thrusters[1].azimuth_rad or 0.0) > 1.5:
        pass
    return a


@pytest.mark.parametrize("demand", [(-100.0, 0.0, 0.0), (0.0, -200.0, 0.0), (0.0, 0.0, -100.0)])
def test_a_demand_that_turns_is_given_though_a_thruster_turns_round(demand: tuple[float, float, float]) -> None:
    """ÅBOAT gave nothing for 4 s as the wind changed sides: its bow thruster might not reverse meanwhile."""
    found = [allocation.achieved for allocation in settled(that_turns(), Wrench(*demand), 4.5)][10:]
    limits = ABOAT.limits.surge_n, ABOAT.limits.sway_n, ABOAT.limits.yaw_nm
    missing = [
        max(
            abs(asked - got) / most
            for asked, got, most in zip(demand, (w.surge_n, w.sway_n, w.yaw_nm), limits, strict=True)
        )
        for w in found
    ]
    assert sum(missing) / len(missing) < 0.1


def test_the_others_do_not_wait_for_the_turn_of_a_thruster_that_has_failed() -> None:
    """ÅBOAT's bow thruster gave nothing for 4 s: it might not reverse beside one that turned without any thrust."""
    a = that_turns()
    a.set_failed(1, True)
    found = settled(a, Wrench(-60.0, 0.0, -60.0), 1.5)[-1]
    assert found.achieved.surge_n == pytest.approx(-60.0, rel=0.05)
    assert found.achieved.yaw_nm == pytest.approx(-60.0, rel=0.05)


@pytest.mark.parametrize("by_stick", [False, True])
def test_a_turn_does_not_go_on_after_neutral_or_sticks(by_stick: bool) -> None:
    """ÅBOAT was disarmed as its stern thruster began to turn. On its next sail that went on to abeam without thrust."""
    a, ahead = that_turns(), (ThrusterCommand(30.0, 0.35, 0.0),) * 2
    a.direct(ahead) if by_stick else a.neutral()
    found = settled(a, Wrench(100.0, 0.0, 0.0), 6.0)
    fresh = settled(Allocator(ABOAT, Parameters(ABOAT.parameters)), Wrench(100.0, 0.0, 0.0), 6.0)
    assert found[-1].thrusters[1].azimuth_rad == pytest.approx(fresh[-1].thrusters[1].azimuth_rad, abs=0.1)
    assert found[-1].achieved.surge_n == pytest.approx(100.0, rel=0.01)


def test_most_of_the_thrust_goes_on_while_it_turns() -> None:
    wanted_n = 200.0
    sailed = settled(pushed_astern(), Wrench(0.0, wanted_n, 0.0), 20.0)
    missing_ns = sum(wanted_n - allocation.achieved.sway_n for allocation in sailed) * DT_S
    assert missing_ns < 2.0 * wanted_n, "4 s of the turn without thrust would miss twice as much"
    assert all(abs(allocation.achieved.yaw_nm) < 0.15 * ABOAT.limits.yaw_nm for allocation in sailed)


def reversing(astern_n: float) -> VesselConfig:
    """ÅBOAT with thrusters that give so much in reverse."""
    weak = (replace(t, min_n=-astern_n, astern_n=astern_n) for t in ABOAT.thrusters)
    return replace(ABOAT, thrusters=tuple(weak))


def way_round(config: VesselConfig, mean_n: float, now_n: float, azimuth_deg: float) -> float | None:
    thrusters = thrusters_of(config)
    strong = StrongSide(thrusters)
    for _ in range(300):
        strong.see([mean_n] * len(thrusters), DT_S)
    target_rad = strong.way_round_rad(0, thrusters[0], now_n, math.radians(azimuth_deg))
    return None if target_rad is None else math.degrees(target_rad)


@pytest.mark.parametrize(
    ("mean_n", "now_n", "azimuth_deg", "target_deg"),
    [
        (-100.0, -90.0, -90.0, 90.0),  # in a lull
        (-100.0, -110.0, -90.0, None),  # not when more is asked than usual
        (-175.0, -180.0, -90.0, 90.0),  # but at its end, where no lull comes
        (-50.0, -40.0, -90.0, None),  # little is asked
        (100.0, 90.0, -90.0, None),  # pushes ahead
        (-100.0, -90.0, -50.0, 115.0),  # 15° off is near enough
        (-100.0, -90.0, -20.0, None),  # opposite lies what is forbidden
        (-100.0, -90.0, 90.0, -90.0),
    ],
)
def test_it_turns_where_that_gains_thrust(
    mean_n: float, now_n: float, azimuth_deg: float, target_deg: float | None
) -> None:
    assert way_round(ABOAT, mean_n, now_n, azimuth_deg) == (
        target_deg if target_deg is None else pytest.approx(target_deg)
    )


def test_a_thruster_that_is_as_strong_astern_stays() -> None:
    assert way_round(REVOLT, -20.0, -15.0, -90.0) is None


def test_a_thruster_that_does_not_reverse_has_no_way_round() -> None:
    assert way_round(reversing(0.0), 0.0, 0.0, -90.0) is None


def test_after_the_turn_it_has_to_push_astern_anew() -> None:
    thrusters = thrusters_of(ABOAT)
    strong = StrongSide(thrusters)
    for _ in range(300):
        strong.see([-100.0, -100.0], DT_S)
    strong.turned(0)
    assert strong.way_round_rad(0, thrusters[0], -90.0, -1.5) is None
    assert strong.way_round_rad(1, thrusters[1], -90.0, -1.5) is not None


def test_a_way_back_to_the_point_is_no_reason_to_turn() -> None:
    """It lasts some 10 s. In the middle of it the turn took sideways thrust for 4 s, and ÅBOAT was 0.9 m off."""
    thrusters = thrusters_of(ABOAT)
    strong, turns = StrongSide(thrusters), []
    for k in range(300):
        force_n = -90.0 if 100 <= k < 220 else -30.0
        strong.see([force_n, force_n], DT_S)
        turns.append(strong.way_round_rad(1, thrusters[1], force_n, -1.5))
    assert turns == [None] * 300
