"""Plans that a boat must not take: each is refused with the code, the item and the words that help, and what was in
force stays."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.mission import files
from companion.mission.plan import PlanKind
from companion.mission.plan import PlanResult as R
from tests.protocol.desk import Desk
from tests.scenarios.test_mission_files import message

FOLDER = Path(__file__).parent / "broken_plans"
BROKEN = {
    "unknown_command": (R.UNSUPPORTED, "mission item 2: command 211 is not supported; remove it"),
    "local_frame": (
        R.UNSUPPORTED_FRAME,
        "mission item 2: NAV_WAYPOINT is in frame 1; give latitude and longitude in a global frame",
    ),
    "negative_hold": (R.INVALID_PARAM1, "mission item 3: NAV_WAYPOINT hold time (param1) is -5; give 0 s or more"),
    "negative_radius": (R.INVALID_PARAM2, "mission item 1: NAV_WAYPOINT acceptance radius (param2) is -1"),
    "no_such_direction": (R.INVALID_PARAM3, "mission item 2: CONDITION_YAW direction (param3) is 2; give -1, 0 or 1"),
    "impossible_heading": (R.INVALID_PARAM4, "mission item 2: NAV_WAYPOINT heading (param4) is 400"),
    "fifth_actuator": (R.INVALID_PARAM5_X, "mission item 2: DO_SET_ACTUATOR sets actuator 5; in a mission use 1 to 4"),
    "other_actuator_set": (R.INVALID_PARAM7, "mission item 2: DO_SET_ACTUATOR is for set 3 of actuators"),
    "servo_that_is_not_there": (
        R.INVALID_PARAM1,
        "mission item 2: DO_SET_SERVO: there is no servo output 1: this boat has none",
    ),
    "endless_loop_of_nothing": (
        R.INVALID_PARAM1,
        "mission item 2: DO_JUMP to item 1 for ever, with nothing to do in between",
    ),
    "nothing_to_do": (R.INVALID, "mission: the mission has nothing to do; add a waypoint"),
    "rally_point_in_the_mission": (
        R.UNSUPPORTED,
        "mission item 2: RALLY_POINT belongs to the rally points, not to the mission",
    ),
    "no_place": (R.INVALID_PARAM5_X, "mission item 3: NAV_WAYPOINT is at latitude 0, longitude 0; give it a place"),
    "crossed_fence": (R.INVALID, "fence item 1: the polygon crosses itself, sides 1-2 and 3-4"),
}


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    found = Desk(tmp_path_factory.mktemp("broken"))
    found.tick()
    yield found
    found.close()


def test_every_file_is_in_the_table() -> None:
    assert {path.stem for path in FOLDER.iterdir()} == set(BROKEN) and len(BROKEN) >= 10


@pytest.mark.parametrize("name", BROKEN)
def test_refused_with_code_item_and_words(name: str, desk: Desk) -> None:
    result, words = BROKEN[name]
    plan = files.read(f"{name}.plan", (FOLDER / f"{name}.plan").read_text(encoding="utf-8"))
    kind, items = (PlanKind.FENCE, plan.fence) if plan.fence else (PlanKind.MISSION, plan.mission)
    good = files.read(
        "good.plan", (FOLDER.parents[2] / "mission_files" / "trondheim_square.plan").read_text(encoding="utf-8")
    )
    kept = good.fence if kind is PlanKind.FENCE else good.mission
    assert desk.upload([message(item, kind) for item in kept], int(kind)) == mavlink.MAV_MISSION_ACCEPTED
    before = desk.vessel.plans.items(kind)
    desk.received.clear()
    assert desk.upload([message(item, kind) for item in items], int(kind)) == result
    desk.tick(30)
    assert words in "".join(desk.texts()), desk.texts()
    assert desk.vessel.plans.items(kind) == before
