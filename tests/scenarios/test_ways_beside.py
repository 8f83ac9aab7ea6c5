"""A way home that takes three seconds to find, in lockstep: the boat holds, then sails it. Judged by the truth."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from companion.core.work import settle
from companion.mission.plan import PlanItem, PlanKind
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import between, read_truth
from sitl.scenarios.rig import Conditions

MISSION = 0x04040000
ZONE, RADIUS_M = (11.0, 0.0), 4.0
TAKES_S = 3.0


class _TakesLong:
    """A worker whose work takes TAKES_S of the boat's time, on every machine."""

    def __init__(self, rig: LockstepRig) -> None:
        self._rig = rig
        self._running: list[tuple[float, Future[Any], Callable[[], Any]]] = []

    def submit(self, work: Callable[[], Any], urgent: bool = False) -> Future[Any]:
        future: Future[Any] = Future()
        self._running.append((self._rig.now_s + TAKES_S, future, work))
        return future

    def advance(self) -> None:
        for row in [row for row in self._running if row[0] <= self._rig.now_s]:
            self._running.remove(row)
            if row[1].set_running_or_notify_cancel():
                settle(row[1], row[2])


def test_rtl_holds_and_then_goes_round(tmp_path: Path) -> None:
    rig = LockstepRig(Conditions("revolt", seed=43, wind="2", gnss="rtk"), tmp_path)
    gcs, worker = GroundStation(rig), _TakesLong(rig)
    frame = LocalFrame(rig.config.home.lat_deg, rig.config.home.lon_deg)
    gcs.ready()
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(22.0, 0.0))])
    gcs.set_mode(MISSION)
    gcs.arm()
    gcs.wait("the end of the mission", lambda: 0 in gcs.reached, 200.0)
    lat_deg, lon_deg = frame.to_geodetic(*ZONE)
    zone = PlanItem(0, 5004, 0, RADIUS_M, 0.0, 0.0, 0.0, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
    rig.vessel.plans.replace(PlanKind.FENCE, [zone])
    parts = rig.vessel.supervisor.parts
    parts.charted.work_with(worker)
    asked_s = rig.now_s
    gcs.command(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)

    def under_way() -> bool:
        worker.advance()
        return parts.helm.mode.goes_round

    gcs.wait("the way home", under_way, 10.0)
    begun_s = rig.now_s
    gcs.wait("home", lambda: "RTL: at home, holding" in gcs.texts, 300.0)
    rig.close()
    truth = read_truth(tmp_path)
    waited = [(row["north_m"], row["east_m"]) for row in between(truth, asked_s, begun_s)]
    back = [(row["north_m"], row["east_m"]) for row in between(truth, begun_s)]
    assert "Planning a way" in gcs.texts
    assert TAKES_S <= begun_s - asked_s < TAKES_S + 0.5
    assert max(math.dist(place, waited[-1]) for place in waited) < 2.0
    assert min(math.dist(place, ZONE) for place in back) > RADIUS_M
    assert math.dist(back[-1], (0.0, 0.0)) < 2.0
