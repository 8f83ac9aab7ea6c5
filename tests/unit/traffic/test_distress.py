"""Distress beacons: each announced once, with bearing and distance."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.core.decision import Severity, TextKind
from companion.core.estimate import NO_ESTIMATE, TrackedTarget
from companion.core.events import EventLog
from companion.core.readings import AisTarget
from companion.traffic.distress import DistressWatch

HERE = replace(NO_ESTIMATE, lat_deg=60.41, lon_deg=22.07, position_valid=True)


def heard(mmsi: int, status: int | None, lat_deg: float | None = 60.42) -> TrackedTarget:
    return TrackedTarget(
        AisTarget(0.0, "ais", mmsi, lat_deg, None if lat_deg is None else 22.09, status=status), 0.0, 1
    )


def said(events: EventLog) -> list[tuple[Severity, str]]:
    return [(event.severity, event.text) for event in events.drain()]


@pytest.mark.parametrize(
    ("mmsi", "name"), [(970123456, "SART"), (972123456, "MOB"), (974123456, "EPIRB"), (230123456, "MMSI")]
)
def test_a_beacon_is_announced_once(mmsi: int, name: str) -> None:
    """It was kept as an ordinary vessel, and nobody was told."""
    events = EventLog()
    watch, ship = DistressWatch(events.say), heard(230000001, 0)
    for second in range(600):
        watch.update([ship, heard(mmsi, 14)], HERE, float(second))
    assert said(events) == [(TextKind.DANGER.severity, f"Distress: {name} {mmsi}, 1567 m at 045 deg")]
    watch.update([ship], HERE, 600.0)
    watch.update([ship, heard(mmsi, 14)], HERE, 601.0)
    assert len(said(events)) == 1, "it was lost, and is heard again"


def test_a_beacon_under_test_is_no_alarm_until_it_is_active() -> None:
    events = EventLog()
    watch = DistressWatch(events.say)
    for now_s, status in ((0.0, None), (1.0, None), (2.0, 14), (3.0, 14), (4.0, None)):
        watch.update([heard(972123456, status)], HERE, now_s)
    assert said(events) == [
        (TextKind.ROUTINE.severity, "Test of MOB 972123456, 1567 m at 045 deg"),
        (TextKind.DANGER.severity, "Distress: MOB 972123456, 1567 m at 045 deg"),
    ]


def test_a_beacon_without_a_place_is_announced_and_again_with_it() -> None:
    events = EventLog()
    watch = DistressWatch(events.say)
    for now_s, lat_deg in ((0.0, None), (1.0, None), (2.0, 59.9), (3.0, 59.9)):
        watch.update([heard(974123456, 14, lat_deg)], HERE, now_s)
    texts = [text for _, text in said(events)]
    assert texts == ["Distress: EPIRB 974123456, place not known", "Distress: EPIRB 974123456, 56.8 km at 179 deg"]
    assert max(map(len, texts)) <= 50
