"""The power goes in mid-mission: what was on the disk at that moment is all that the next run has."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from companion.core.decision import MissionState, ModeId
from companion.io.mavlink.wire import messages as mavlink
from companion.mission import files
from companion.mission.plan import PlanKind
from companion.record.state_file import StateFile
from tests.afloat import BoatAfloat
from tests.protocol.desk import Desk
from tests.scenarios.test_mission_files import FOLDER, message

LAPS = files.read("laps.plan", (FOLDER / "laps.plan").read_text(encoding="utf-8"))
LISTS = {
    PlanKind.MISSION: LAPS.mission,
    PlanKind.FENCE: LAPS.fence,
    PlanKind.RALLY: files.read("x.plan", (FOLDER / "mixed_frames.plan").read_text(encoding="utf-8")).rally,
}


def desk_of(run: BoatAfloat) -> Desk:
    desk = Desk(Path(), run)  # type: ignore[arg-type]
    desk.tick()
    return desk


def sail_until(desk: Desk, what: str, done: object, timeout_s: float = 200.0) -> None:
    assert callable(done)

    def check() -> bool:
        if round(desk.rig.now_s * 10) % 10 == 0:
            desk.heartbeat()
        return bool(done())

    desk.until(what, check, timeout_s)


@pytest.fixture(scope="module")
def cut(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, object], tuple[float, float]]:
    """The disk after the cut, where the mission stood, and where the boat is."""
    folder = tmp_path_factory.mktemp("cut")
    desk = desk_of(BoatAfloat(folder / "state"))
    desk.ready()
    desk.tell(mavlink.MAVLink_param_set_message(1, 1, b"NAV_ACC_RAD", 2.0, 9))
    for kind, items in LISTS.items():
        assert desk.upload([message(item, kind) for item in items], int(kind)) == mavlink.MAV_MISSION_ACCEPTED
    assert desk.result(300, 6.0) == mavlink.MAV_RESULT_ACCEPTED, "from the last corner of a lap"
    assert desk.result(400, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    sail_until(desk, "the next lap, past the condition", lambda: desk.vessel.executor.progress.seq == 4)
    desk.tick(2)  # what a tick decides is on the disk with the next one
    shutil.copytree(folder / "state", folder / "disk")
    truth = desk.rig.world.truth
    snapshot = desk.vessel.executor.snapshot()
    assert snapshot["jumps"] == {"7": 1} and snapshot["held"] == [2, 3]
    desk.close()
    return folder / "disk", snapshot, (truth.north_m, truth.east_m)


@pytest.mark.parametrize(("on_start", "mode"), [(0, ModeId.HOLD), (1, ModeId.MISSION)])
def test_all_is_there_and_the_boat_holds_or_goes_on_by_parameter(
    on_start: int, mode: ModeId, cut: tuple[Path, dict[str, object], tuple[float, float]], tmp_path: Path
) -> None:
    disk, snapshot, place = cut
    shutil.copytree(disk, tmp_path / "state")
    state = StateFile(tmp_path / "state")
    parameters, _ = state.load_parameters()
    state.save_parameters({**parameters, "MIS_ON_START": on_start})
    state.close()
    run = BoatAfloat(tmp_path / "state", place=place)
    vessel = run.vessel
    for kind, items in LISTS.items():
        assert [(i.command, i.x, i.y) for i in vessel.plans.items(kind)] == [(i.command, i.x, i.y) for i in items], kind
    assert vessel.parameters["NAV_ACC_RAD"] == 2.0
    assert vessel.executor.snapshot() == snapshot, "the item, the jumps taken, the speed, what a condition holds back"
    desk = desk_of(run)
    status = vessel.supervisor.status(desk.rig.now_s)
    assert (status.mode, status.armed, status.mission.state) == (mode, False, MissionState.PAUSED)
    desk.ready()
    home = vessel.supervisor.status(desk.rig.now_s).home
    assert home is not None and vessel.frame.to_ned(home.lat_deg, home.lon_deg) == pytest.approx(
        vessel.frame.to_ned(63.4389, 10.399), abs=0.5
    )
    assert desk.result(400, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    sail_until(desk, "a while", lambda: desk.rig.now_s > 12.0)
    away_m = ((run.world.truth.north_m - place[0]) ** 2 + (run.world.truth.east_m - place[1]) ** 2) ** 0.5
    if mode is ModeId.HOLD:
        assert away_m < 1.0 and vessel.executor.progress.state is MissionState.PAUSED
        assert desk.result(300) == mavlink.MAV_RESULT_ACCEPTED
    sail_until(desk, "the next waypoint", lambda: vessel.executor.progress.reached == int(str(snapshot["reached"])) + 1)
    assert vessel.executor.progress.reached_seq == 4
    desk.close()
