"""The example missions, uploaded by MAVLink and sailed to their end in lockstep."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.core.decision import MissionState
from companion.io.mavlink.wire import messages as mavlink
from companion.mission import files
from companion.mission.commands import DESTINATIONS
from companion.mission.plan import PlanItem, PlanKind
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import ITEM_FIELDS, Desk

FOLDER = Path(__file__).parents[2] / "mission_files"
FILES = sorted(path for path in FOLDER.iterdir() if path.suffix in (".plan", ".waypoints"))


def message(item: PlanItem, kind: PlanKind) -> object:
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, item.seq, item.frame, item.command, item.current, item.autocontinue,
        item.param1, item.param2, item.param3, item.param4, item.x, item.y, item.z, int(kind),
    )  # fmt: skip


def test_there_is_one_of_each_kind() -> None:
    assert {path.suffix for path in FILES} >= {".plan", ".waypoints"}


# the others are begun in every run and sailed to their end in the sweep
QUICK = ("trondheim_square.plan",)
LONG = (
    "orbits.plan",
    "aboat_island.plan",
    "aboat_route_1.plan",
    "aboat_route_2.plan",
    "aboat_route_3.plan",
    "aboat_route_4.plan",
)


def vessel_of(path: Path) -> str:
    return "aboat" if path.name.startswith("aboat") else "revolt"


def loaded(path: Path, tmp_path: Path) -> Desk:
    """A desk whose boat has the plan, armed and in Mission. What it gives back is what was sent, field by field."""
    plan = files.read(path.name, path.read_text(encoding="utf-8"))
    desk = Desk(tmp_path, LockstepRig(Conditions(vessel_of(path), seed=3), tmp_path / "log"))
    desk.tick()
    desk.ready()
    for kind, items in ((PlanKind.MISSION, plan.mission), (PlanKind.FENCE, plan.fence), (PlanKind.RALLY, plan.rally)):
        sent = [message(item, kind) for item in items]
        assert desk.upload(sent, int(kind)) == mavlink.MAV_MISSION_ACCEPTED
        back = [desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, item.seq, int(kind)))[0] for item in items]
        for one, other in zip(sent, back, strict=True):
            for name in ITEM_FIELDS:
                assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-7, nan_ok=True), (one.seq, name)
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, 0x04040000))
    assert desk.result(400, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    return desk


def sail(desk: Desk, what: str, done: Callable[[], bool], timeout_s: float) -> None:
    def check() -> bool:
        if round(desk.rig.now_s * 10) % 10 == 0:
            desk.heartbeat()
        return done()

    desk.until(what, check, timeout_s)
    assert not any("fail" in text.lower() for text in desk.texts())
    desk.close()


def to_its_end(desk: Desk, timeout_s: float) -> None:
    def finished() -> bool:
        ended = desk.vessel.executor.progress.state is MissionState.COMPLETE
        return ended or desk.latest("HEARTBEAT").custom_mode in (0x05040000, 0x03040000)

    sail(desk, "the end of the mission", finished, timeout_s)
    assert desk.vessel.executor.progress.reached_seq is not None


@pytest.mark.parametrize("path", [path for path in FILES if path.name in QUICK], ids=lambda path: path.name)
def test_sails_to_its_end(path: Path, tmp_path: Path) -> None:
    to_its_end(loaded(path, tmp_path), 900.0)


@pytest.mark.parametrize("path", [path for path in FILES if path.name not in QUICK], ids=lambda path: path.name)
def test_is_begun(path: Path, tmp_path: Path) -> None:
    """To its second place, or 12 s on the way there where that is long."""
    desk = loaded(path, tmp_path)
    first_s = math.inf

    def begun() -> bool:
        nonlocal first_s
        reached = desk.vessel.executor.progress.reached
        if reached > 0:
            first_s = min(first_s, desk.rig.now_s)
        return reached >= 2 or (path.name in LONG and desk.rig.now_s > first_s + 12.0)

    sail(desk, "the first items", begun, 300.0)


@pytest.mark.sweep
@pytest.mark.parametrize("path", [path for path in FILES if path.name not in QUICK], ids=lambda path: path.name)
def test_sails_to_its_end_too(path: Path, tmp_path: Path) -> None:
    desk = loaded(path, tmp_path)
    count = sum(item.command in DESTINATIONS for item in desk.vessel.plans.items(PlanKind.MISSION))
    to_its_end(desk, 7200.0)
    assert desk.vessel.executor.progress.reached >= count, "every waypoint"
