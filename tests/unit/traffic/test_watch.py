"""Which vessels count: by AIS, and by what sensors see moving."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import find, load
from companion.core.estimate import Contact
from companion.core.events import EventLog
from companion.core.readings import AisTarget
from companion.params.store import Parameters
from companion.traffic.tracker import TrafficTracker
from companion.traffic.watch import TrafficWatch
from tests.unit.estimates import AT_REST
from tests.unit.obstacles.charted import FRAME

OTTER = load(find("otter"))
SEEN = Contact(-1, "mover 1", 42.0, 1.0, -1.0, 0.0, 1.5, None)


@pytest.mark.parametrize(("action", "counts"), [(0, [-1]), (1, [230_000_001]), (3, [230_000_001])])
def test_what_a_sensor_sees_counts_unless_a_vessel_that_counts_explains_it(action: int, counts: list[int]) -> None:
    """With CA_ACTION 0 a ship with AIS counted neither by that nor as what a lidar saw moving; one without was kept
    clear of."""
    parameters = Parameters()
    parameters.set("CA_ACTION", action)
    tracker = TrafficTracker()
    lat_deg, lon_deg = FRAME.to_geodetic(40.0, 0.0)
    report = AisTarget(
        0.0, "ais", 230_000_001, lat_deg, lon_deg, math.pi, 1.0, bow_m=4.0, stern_m=4.0, port_m=1.5, starboard_m=1.5
    )
    tracker.take(report, 0.0, None)
    watch = TrafficWatch(OTTER, parameters, tracker, EventLog(), lambda: FRAME, lambda _now_s: [SEEN])
    assert [one.mmsi for one in watch.contacts(AT_REST, 1.0, 0.0)] == counts
