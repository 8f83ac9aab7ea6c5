"""The tracker: reports put together, the old ones forgotten, a flood survived, the dead reckoning against the
geodesic."""

from __future__ import annotations

import math
import tracemalloc

import pytest
from geographiclib.geodesic import Geodesic

from companion.core.geodesy import LocalFrame
from companion.core.readings import AisTarget
from companion.traffic.tracker import MOST_TARGETS, TrafficTracker, contact

HERE = (60.41, 22.07)
KNOT = 1852.0 / 3600.0


def motion(
    mmsi: int,
    t_s: float = 0.0,
    lat_deg: float = 60.41,
    speed_mps: float | None = 2.0,
    source: str = "ais",
    **more: float,
) -> AisTarget:
    return AisTarget(
        t_s, source, mmsi, lat_deg, 22.07, course_rad=more.pop("course_rad", 0.0), speed_mps=speed_mps, **more
    )


def test_motion_and_ship_data_are_merged() -> None:
    tracker = TrafficTracker()
    tracker.take(AisTarget(0.0, "ais", 7, bow_m=6.0, stern_m=2.0, port_m=1.0, starboard_m=2.0, name="NORA"), 0.0, HERE)
    tracker.take(motion(7, 1.0, heading_rad=1.0, status=3), 1.0, HERE)
    tracker.take(motion(7, 2.0, speed_mps=None), 2.0, HERE)
    (target,) = tracker.targets
    assert target.known.name == "NORA" and target.known.t_s == 2.0 and target.reports == 2
    assert target.known.heading_rad is None and target.known.speed_mps is None, (
        "what the last report leaves open is not known any more"
    )
    assert target.known.status == 3


def test_an_older_report_changes_no_motion() -> None:
    tracker = TrafficTracker()
    tracker.take(motion(7, 5.0, 60.42), 5.0, HERE)
    tracker.take(motion(7, 2.0, 60.43), 6.0, HERE)
    assert tracker.targets[0].known.lat_deg == 60.42 and tracker.targets[0].heard_s == 5.0


def test_silent_vessels_are_forgotten_slow_ones_later() -> None:
    tracker = TrafficTracker()
    tracker.take(motion(1, speed_mps=5.0), 0.0, HERE)
    tracker.take(motion(2, speed_mps=0.1), 0.0, HERE)
    tracker.update(80.0)
    assert [target.known.mmsi for target in tracker.targets] == [1, 2]
    tracker.update(200.0)
    assert [target.known.mmsi for target in tracker.targets] == [2], "at anchor it speaks every three minutes"
    tracker.update(500.0)
    assert tracker.targets == ()


def test_an_old_report_that_is_passed_on_again_and_again_keeps_no_vessel() -> None:
    tracker = TrafficTracker()
    for now_s in range(120):
        tracker.take(motion(7, 0.0, speed_mps=5.0, source="mavlink:2"), float(now_s), HERE)
        tracker.update(float(now_s))
        assert len(tracker.targets) == (now_s <= 90), now_s


def test_impossible_reports_are_ignored() -> None:
    tracker = TrafficTracker(own_mmsi=5)
    for report in (
        motion(0),
        motion(1_000_000_000),
        motion(5),
        motion(8, lat_deg=91.0),
        AisTarget(0.0, "ais", 9, 60.0, None),
    ):
        tracker.take(report, 0.0, HERE)
    assert tracker.targets == ()


def test_a_flood_of_vessels_neither_fills_the_memory_nor_drowns_the_near_ones() -> None:
    tracker = TrafficTracker()
    for n in range(10):
        tracker.take(motion(100 + n, 0.0, 60.411), 0.0, HERE)
        tracker.take(motion(100 + n, 1.0, 60.411), 1.0, HERE)
    tracemalloc.start()
    for n in range(100_000):
        if n % 1000 == 0:
            tracker.update(n * 0.0005)
        tracker.take(motion(1_000 + n, lat_deg=60.41 + 0.00001 * (n % 100), source="mavlink:7"), n * 0.0005, HERE)
    assert tracemalloc.get_traced_memory()[0] < 1_000_000
    tracemalloc.stop()
    assert len(tracker.targets) == MOST_TARGETS
    assert {100 + n for n in range(10)} <= {target.known.mmsi for target in tracker.targets}
    tracker.take(motion(77, lat_deg=60.41), 50.0, HERE)
    assert 77 in {target.known.mmsi for target in tracker.targets}, "a near one still finds room, from another source"


def test_dead_reckoning_against_the_geodesic() -> None:
    frame = LocalFrame(*HERE)
    tracker = TrafficTracker()
    tracker.take(motion(7, 0.0, speed_mps=6.0, course_rad=math.radians(70.0)), 0.0, HERE)
    there = contact(tracker.targets[0], frame, 30.0)
    line = Geodesic.WGS84.Direct(60.41, 22.07, 70.0, 180.0)
    assert there is not None and (there.north_m, there.east_m) == pytest.approx(
        frame.to_ned(line["lat2"], line["lon2"]), abs=0.01
    )
    assert there.radius_m == 10.0 and there.speed_mps == pytest.approx(6.0)


def test_the_middle_of_the_hull_not_the_antenna() -> None:
    """The antenna 225 m from the bow, 70 m from the stern, 1 m from port, 31 m from starboard; heading east."""
    tracker = TrafficTracker()
    sized = {"bow_m": 225.0, "stern_m": 70.0, "port_m": 1.0, "starboard_m": 31.0}
    tracker.take(motion(7, speed_mps=0.0, heading_rad=math.pi / 2, **sized), 0.0, HERE)
    there = contact(tracker.targets[0], LocalFrame(*HERE), 0.0)
    assert there is not None and (there.north_m, there.east_m) == pytest.approx((-15.0, 77.5), abs=1e-6)
    assert there.radius_m == pytest.approx(0.5 * math.hypot(295.0, 32.0))


@pytest.mark.parametrize(
    ("status", "speed_mps", "gone_m"), [(0, 0.3, 54.0), (1, 0.3, 0.0), (5, 0.3, 0.0), (1, 2.0, 360.0)]
)
def test_a_ship_at_anchor_reports_every_three_minutes_and_stays(status: int, speed_mps: float, gone_m: float) -> None:
    """It swings, and its receiver makes noise. One that makes way has only forgotten to change its status."""
    tracker = TrafficTracker()
    tracker.take(motion(7, speed_mps=speed_mps, status=status), 0.0, HERE)
    there = contact(tracker.targets[0], LocalFrame(*HERE), 180.0)
    assert there is not None and there.north_m == pytest.approx(gone_m, abs=0.1)
    assert there.speed_mps == pytest.approx(speed_mps if gone_m else 0.0)


def test_without_a_course_a_vessel_goes_where_its_bow_points() -> None:
    tracker = TrafficTracker()
    tracker.take(AisTarget(0.0, "ais", 7, *HERE, None, 3.0, heading_rad=0.5 * math.pi), 0.0, HERE)
    there = contact(tracker.targets[0], LocalFrame(*HERE), 10.0)
    assert there is not None and (there.north_m, there.east_m) == pytest.approx((0.0, 30.0), abs=0.1)
    tracker.take(AisTarget(1.0, "ais", 8, *HERE, None, 3.0), 1.0, HERE)
    unknown = contact(tracker.targets[1], LocalFrame(*HERE), 10.0)
    assert unknown is not None and unknown.speed_mps == 0.0


def test_a_vessel_without_a_position_is_no_contact() -> None:
    tracker = TrafficTracker()
    tracker.take(AisTarget(0.0, "ais", 7, name="NORA"), 0.0, HERE)
    assert contact(tracker.targets[0], LocalFrame(*HERE), 0.0) is None and tracker.targets[0].label == "NORA"
