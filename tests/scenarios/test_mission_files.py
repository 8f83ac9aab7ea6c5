"""The example missions, uploaded by MAVLink and sailed to their end in lockstep."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli import LockstepRig
from companion.core.types import MissionState
from companion.io.mavlink import messages as mavlink
from companion.mission import files
from companion.mission.plan import PlanItem, PlanKind
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import Desk

FOLDER = Path(__file__).parents[2] / "mission_files"
FILES = sorted(path for path in FOLDER.iterdir() if path.suffix in (".plan", ".waypoints"))


def message(item: PlanItem, kind: PlanKind) -> object:
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, item.seq, item.frame, item.command, item.current, item.autocontinue,
        item.param1, item.param2, item.param3, item.param4, item.x, item.y, item.z, int(kind),
    )  # fmt: skip


def test_there_is_one_of_each_kind() -> None:
    assert {path.suffix for path in FILES} >= {".plan", ".waypoints"}


def vessel_of(path: Path) -> str:
    return "aboat" if path.name.startswith("aboat") else "revolt"


# the other routes of ÅBOAT are sailed by the scenario too
QUICK = [p if vessel_of(p) == "revolt" or "route_1" in p.name else pytest.param(p, marks=pytest.mark.sweep) for p in FILES]


@pytest.mark.parametrize("path", QUICK, ids=lambda path: path.name)
def test_sails_to_its_end(path: Path, tmp_path: Path) -> None:
    plan = files.read(path.name, path.read_text(encoding="utf-8"))
    desk = Desk(tmp_path, LockstepRig(Conditions(vessel_of(path), seed=3), tmp_path / "log"))
    desk.tick()
    desk.ready()
    for kind, items in ((PlanKind.MISSION, plan.mission), (PlanKind.FENCE, plan.fence), (PlanKind.RALLY, plan.rally)):
        assert desk.upload([message(item, kind) for item in items], int(kind)) == mavlink.MAV_MISSION_ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, 0x04040000))
    assert desk.result(400, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    progress = lambda: desk.vessel.executor.progress  # noqa: E731

    def finished() -> bool:
        if round(desk.rig.now_s * 10) % 10 == 0:
            desk.heartbeat()
        return progress().state is MissionState.COMPLETE or desk.latest("HEARTBEAT").custom_mode in (0x05040000, 0x03040000)

    desk.until("the end of the mission", finished, 900.0)
    assert progress().reached_seq is not None and not any("fail" in text.lower() for text in desk.texts())
    desk.close()
