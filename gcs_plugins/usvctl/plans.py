"""Missions, fences and rally points between files and the boat: any format that the companion reads and writes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mavsdk.plugins.mission_raw import MissionItem, MissionPlan, MissionRaw, MissionRawError, MissionRawResult

from companion.mission import files
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanFile
from gcs_plugins.usvctl.boat import Boat, Mistake, NoVessel, Refused
from gcs_plugins.usvctl.progress import transferred

_WAYPOINT, _JUMP = 16, 177
_MISSION, _FENCE, _RALLY = 0, 1, 2
_ANSWER_S = 5.0


def read(path: Path) -> PlanFile:
    """Raises PlanFileError with every problem, OSError, Mistake for what is no text."""
    try:
        return files.read(path.name, path.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        raise Mistake(f"{path}: not a text file in UTF-8") from error


def upload(boat: Boat, plan: PlanFile) -> None:
    """Replace the boat's plan by this one. Lists that the plan does not have are cleared."""
    raw = MissionRaw(boat.system)
    _checked(boat, _upload_mission, boat, raw, plan.mission)
    for kind, items, send in ((_FENCE, plan.fence, raw.upload_geofence), (_RALLY, plan.rally, raw.upload_rally_points)):
        if items:
            _checked(boat, send, [_sent(item, kind) for item in items])
        else:
            clear(boat, kind)


def download(boat: Boat) -> PlanFile:
    """The boat's present plan, with its home."""
    raw = MissionRaw(boat.system)
    mission, fence, rally = (
        _checked(boat, get) for get in (raw.download_mission, raw.download_geofence, raw.download_rallypoints)
    )
    boat.listen("HOME_POSITION")
    boat.wait(lambda: boat.newest("HOME_POSITION") is not None, _ANSWER_S)
    home = boat.newest("HOME_POSITION")
    place = None if home is None else (home["latitude"] * 1e-7, home["longitude"] * 1e-7, home["altitude"] * 1e-3)
    items = [_received(item) for item in mission]
    if boat.rover_numbers:
        items = [_moved(item, -1) for item in items[1:]]
    return PlanFile(tuple(items), tuple(map(_received, fence)), tuple(map(_received, rally)), place)


def clear(boat: Boat, kind: int) -> None:
    """Clear one list of the plan: 0 mission, 1 fence, 2 rally points."""
    boat.listen("MISSION_ACK")
    boat.forget("MISSION_ACK")
    boat.send("MISSION_CLEAR_ALL", mission_type=kind)
    if not boat.wait(lambda: (boat.newest("MISSION_ACK") or {}).get("mission_type") == kind, _ANSWER_S):
        raise NoVessel("no answer to the clearing of a list")
    if (boat.newest("MISSION_ACK") or {})["type"] != 0:
        raise Refused("a list of the plan could not be cleared")


def _upload_mission(boat: Boat, raw: MissionRaw, items: Sequence[PlanItem]) -> None:
    if not items:
        clear(boat, _MISSION)
        return
    shown = f"{len(items)} items"
    if boat.rover_numbers:  # item 0 is home there; the boat keeps its own
        items = [PlanItem(0, _WAYPOINT, 0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0), *(_moved(item, 1) for item in items)]
    plan = MissionPlan([_sent(item, _MISSION) for item in items])
    result = transferred(
        shown,
        lambda report: raw.upload_mission_with_progress_async(plan, report),
        lambda data: float(data.progress),
        lambda result: result == MissionRawResult.NEXT,
    )
    if result != MissionRawResult.SUCCESS:
        raise MissionRawError(result, "upload_mission()")


def _checked(boat: Boat, transfer: Callable[..., Any], *arguments: Any) -> Any:
    """The result of a transfer of MAVSDK. Raises Refused with the boat's reason, NoVessel when it fell silent."""
    heard = boat.texts_heard
    try:
        return transfer(*arguments)
    except MissionRawError as error:
        if error.result in (MissionRawResult.TIMEOUT, MissionRawResult.NO_SYSTEM):
            raise NoVessel("the boat fell silent during the transfer") from error
        raise Refused(boat.reason(heard) or error.result.name.lower().replace("_", " ")) from error


def _moved(item: PlanItem, places: int) -> PlanItem:
    """The item with its number, and the target of a jump, moved by `places`."""
    target = item.param1 + places if item.command == _JUMP else item.param1
    return replace(item, seq=item.seq + places, param1=target)


def _sent(i: PlanItem, kind: int) -> MissionItem:
    params = (i.param1, i.param2, i.param3, i.param4)
    return MissionItem(i.seq, i.frame, i.command, int(i.seq == 0), i.autocontinue, *params, i.x, i.y, i.z, kind)


def _received(i: MissionItem) -> PlanItem:
    return PlanItem(i.seq, i.command, i.frame, i.param1, i.param2, i.param3, i.param4, i.x, i.y, i.z, i.autocontinue)
