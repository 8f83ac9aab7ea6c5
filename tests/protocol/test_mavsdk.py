"""A day's work by MAVSDK, from its wheel, against the running process."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk, System
from mavsdk.plugins.action import Action, OrbitYawBehavior
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.mission_raw import MissionItem, MissionRaw, MissionRawError
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import FlightMode, Telemetry

from companion.core.geodesy import LocalFrame
from companion.mission import files
from companion.mission.plan import PlanItem
from companion.params.spec import ParamType
from companion.params.table import TABLE
from tests.protocol.process import Companion
from tests.waiting import CAP_S, wait_until

pytestmark = pytest.mark.process

FRAME = LocalFrame(63.4389, 10.3990)
WAYPOINT, LOITER_TIME, DELAY, CONDITION_YAW, JUMP, SPEED = 16, 19, 93, 115, 177, 178
JUMP_TAG, DO_JUMP_TAG, FENCE_ENABLE, GUIDED_LIMITS, SET_REVERSE = 600, 601, 207, 222, 194


@contextmanager
def connected(companion: Companion) -> Iterator[System]:
    with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
        system = sdk.first_autopilot(CAP_S)
        assert system is not None, "MAVSDK found no autopilot"
        yield system


def start(mission: MissionRaw) -> None:
    """Start the mission. MAVSDK waits for the mode by the wall's clock: on a busy machine it is asked again."""

    def started() -> bool:
        try:
            mission.start_mission()
        except MissionRawError as error:
            if "TIMEOUT" not in str(error):
                raise
            return False
        return True

    wait_until(started, "MAVSDK has started the mission")


def item(seq: int, command: int, point: tuple[float, float] | None, *params: float, frame: int = 6) -> MissionItem:
    x, y = (round(1e7 * degrees) for degrees in FRAME.to_geodetic(*point)) if point else (0, 0)
    padded = (*params, *(0.0 for _ in range(4 - len(params))))
    return MissionItem(seq, frame if point else 2, command, int(seq == 0), 1, *padded, x, y, 0.0, 0)


def twelve_items() -> list[MissionItem]:
    """A small tour of everything that a mission may hold."""
    nan = math.nan
    return [
        item(0, SPEED, None, 1.0, 0.875, -1.0),
        item(1, WAYPOINT, (8.0, 0.0), 0.0, 0.0, 0.0, nan),
        item(2, WAYPOINT, (8.0, 8.0), 2.0, 1.0, 0.0, nan),
        item(3, CONDITION_YAW, None, 45.0, 0.0, 0.0, 0.0),
        item(4, DELAY, None, 1.0, -1.0, -1.0, -1.0),
        item(5, WAYPOINT, (0.0, 8.0), 0.0, 0.0, 0.0, nan),
        item(6, LOITER_TIME, (-4.0, 4.0), 2.0, 0.0, 0.0, nan),
        item(7, JUMP, None, 9.0, 1.0),
        item(8, WAYPOINT, (90.0, 90.0), 0.0, 0.0, 0.0, nan),
        item(9, WAYPOINT, (20.0, -8.0), 0.0, 0.0, 0.0, nan),
        item(10, WAYPOINT, (60.0, -8.0), 0.0, 0.0, 0.0, nan),
        item(11, WAYPOINT, (0.0, 0.0), 0.0, 0.0, 0.0, nan),
    ]


def fence_items() -> list[MissionItem]:
    corners = ((150.0, -150.0), (150.0, 150.0), (-150.0, 150.0), (-150.0, -150.0))
    polygon = [item(n, 5001, corner, 4.0, frame=5) for n, corner in enumerate(corners)]
    circle = item(4, 5004, (80.0, 80.0), 10.0, frame=5)
    for entry in (*polygon, circle):
        entry.mission_type, entry.autocontinue = 1, 0
    return [*polygon, circle]


def rally_items() -> list[MissionItem]:
    points = [item(0, 5100, (3.0, -3.0), frame=6), item(1, 5100, (30.0, 30.0), frame=6)]
    for point in points:
        point.mission_type = 2
    return points


def same(first: list[MissionItem], second: list[MissionItem]) -> bool:
    def key(i: MissionItem) -> tuple[Any, ...]:
        params = tuple("nan" if math.isnan(p) else p for p in (i.param1, i.param2, i.param3, i.param4, i.z))
        return (i.seq, i.frame, i.command, i.autocontinue, *params, i.x, i.y, i.mission_type)

    return [key(i) for i in first] == [key(i) for i in second]


def mode_names(system: System) -> dict[int, str]:
    """AVAILABLE_MODES as MAVSDK decodes them."""
    direct = MavlinkDirect(system)
    found: dict[int, dict[str, Any]] = {}

    def take(message: MavlinkMessage, _user: Any) -> None:
        fields = json.loads(message.fields_json)
        found[fields["mode_index"]] = fields

    direct.subscribe_message("AVAILABLE_MODES", take)
    request = {"target_system": 1, "target_component": 1, "command": 512, "confirmation": 0}
    request |= {"param1": 435.0} | {f"param{n}": 0.0 for n in range(2, 8)}
    direct.send_message(MavlinkMessage("COMMAND_LONG", 0, 0, 1, 1, json.dumps(request)))
    wait_until(lambda: bool(found) and len(found) == next(iter(found.values()))["number_modes"], "all modes")
    direct.destroy()
    return {fields["custom_mode"]: fields["mode_name"] for fields in found.values()}


def acknowledged(system: System, number: int, *params: float) -> int:
    """MAV_RESULT of a command that MAVSDK has no function for."""
    direct = MavlinkDirect(system)
    results: list[int] = []

    def take(message: MavlinkMessage, _user: Any) -> None:
        fields = json.loads(message.fields_json)
        if fields["command"] == number:
            results.append(fields["result"])

    direct.subscribe_message("COMMAND_ACK", take)
    padded = (*params, *(0.0 for _ in range(7 - len(params))))
    request = {"target_system": 1, "target_component": 1, "command": number, "confirmation": 0}
    request |= {f"param{n}": value for n, value in enumerate(padded, start=1)}
    direct.send_message(MavlinkMessage("COMMAND_LONG", 0, 0, 1, 1, json.dumps(request)))
    wait_until(lambda: bool(results), f"the answer to command {number}")
    direct.destroy()
    return results[0]


def test_marks_fence_and_guided_limits(tmp_path: Path) -> None:
    """Items and commands that MAVSDK passes on without knowing them."""
    plan = [
        item(0, WAYPOINT, (8.0, 0.0), 0.0, 0.0, 0.0, math.nan),
        item(1, JUMP_TAG, None, 7.0),
        item(2, WAYPOINT, (8.0, 8.0), 0.0, 0.0, 0.0, math.nan),
        item(3, FENCE_ENABLE, None, 1.0),
        item(4, DO_JUMP_TAG, None, 7.0, 2.0),
    ]
    companion = Companion(tmp_path, speed=5.0).start()
    with connected(companion) as system:
        mission = MissionRaw(system)
        mission.upload_mission(plan)
        assert same(plan, mission.download_mission())
        for command, params, result in (
            (DO_JUMP_TAG, (7.0,), 0),
            (DO_JUMP_TAG, (9.0,), 2),
            (GUIDED_LIMITS, (30.0, 0.0, 0.0, 50.0), 0),
            (FENCE_ENABLE, (0.0,), 0),
            (SET_REVERSE, (1.0,), 1),
        ):
            assert acknowledged(system, command, *params) == result, (command, params)
    companion.kill()


def test_connect_parameters_and_restart(tmp_path: Path) -> None:
    companion = Companion(tmp_path, speed=5.0).start()
    with connected(companion) as system:
        names = mode_names(system)
        assert names[0x00010000] == "Manual" and names[0x03040000] == "Hold" and names[0x04040000] == "Mission"
        parameters = Param(system)
        everything = parameters.get_all_params()
        served = {p.name: ParamType.INT32 for p in everything.int_params} | {
            p.name: ParamType.REAL32 for p in everything.float_params
        }
        assert served == {spec.name: spec.type for spec in TABLE}
        parameters.set_param_float("PATH_BW_SURGE", 0.5)
        parameters.set_param_int("NAV_DLL_ACT", 2)
        assert parameters.get_param_float("PATH_BW_SURGE") == 0.5
    companion.kill()
    with companion, connected(companion) as system:
        assert Param(system).get_param_float("PATH_BW_SURGE") == 0.5
        assert Param(system).get_param_int("NAV_DLL_ACT") == 2


def test_a_mission_from_upload_to_disarming(tmp_path: Path) -> None:
    with Companion(tmp_path, speed=10.0) as companion, connected(companion) as system:
        telemetry, action, mission = Telemetry(system), Action(system), MissionRaw(system)
        wait_until(lambda: telemetry.health_all_ok(), "healthy")
        wait_until(lambda: telemetry.health().is_armable, "ready to arm")

        mission.upload_mission(twelve_items())
        mission.upload_geofence(fence_items())
        mission.upload_rally_points(rally_items())
        assert same(mission.download_mission(), twelve_items())
        assert same(mission.download_geofence(), fence_items())
        assert same(mission.download_rallypoints(), rally_items())

        action.arm()
        wait_until(lambda: telemetry.armed(), "armed")
        start(mission)
        wait_until(lambda: telemetry.flight_mode() == FlightMode.MISSION, "Mission")
        wait_until(lambda: mission.mission_progress().current >= 2, "progress")

        mission.pause_mission()
        wait_until(lambda: telemetry.flight_mode() == FlightMode.HOLD, "Hold")
        paused_at = mission.mission_progress().current

        action.goto_location(*FRAME.to_geodetic(-6.0, -6.0), 0.0, math.nan)
        wait_until(lambda: near(telemetry, -6.0, -6.0), "the go-to point")

        start(mission)
        wait_until(lambda: telemetry.flight_mode() == FlightMode.MISSION, "Mission again")
        wait_until(lambda: mission.mission_progress().current >= 9, "the jump was taken")
        assert mission.mission_progress().current >= paused_at

        action.return_to_launch()
        wait_until(lambda: telemetry.flight_mode() == FlightMode.RETURN_TO_LAUNCH, "RTL")
        wait_until(lambda: near(telemetry, 0.0, 0.0) or near(telemetry, 3.0, -3.0), "home or a rally point")
        action.disarm()
        wait_until(lambda: not telemetry.armed(), "disarmed")


@pytest.mark.sweep
def test_do_orbit(tmp_path: Path) -> None:
    """Its client sends COMMAND_INT, the speed given, the number of orbits NaN."""
    with Companion(tmp_path, speed=10.0) as companion, connected(companion) as system:
        telemetry, action = Telemetry(system), Action(system)
        wait_until(lambda: telemetry.health().is_armable, "ready to arm")
        action.arm()
        wait_until(lambda: telemetry.armed(), "armed")
        centre = FRAME.to_geodetic(20.0, 5.0)
        action.do_orbit(-10.0, 0.5, OrbitYawBehavior.HOLD_FRONT_TO_CIRCLE_CENTER, *centre, 0.0)
        wait_until(lambda: telemetry.flight_mode() == FlightMode.POSCTL, "Circle, as MAVSDK knows it")
        quarters = [(20.0, 15.0), (30.0, 5.0), (20.0, -5.0), (10.0, 5.0)]  # counter-clockwise
        for _ in range(2):
            for place in quarters:
                wait_until(lambda place=place: near(telemetry, *place), f"the circle at {place}")
        action.hold()
        wait_until(lambda: telemetry.flight_mode() == FlightMode.HOLD, "Hold")


def test_a_mission_goes_on_where_a_power_cut_broke_it_off(tmp_path: Path) -> None:
    companion = Companion(tmp_path, speed=10.0)
    with companion, connected(companion) as system:
        telemetry, mission = Telemetry(system), MissionRaw(system)
        Param(system).set_param_int("MIS_ON_START", 1)
        mission.upload_mission(twelve_items())
        mission.upload_geofence(fence_items())
        mission.upload_rally_points(rally_items())
        wait_until(lambda: telemetry.health().is_armable, "ready to arm")
        Action(system).arm()
        start(mission)
        wait_until(lambda: mission.mission_progress().current >= 3, "under way")
        position = telemetry.position()
        companion.kill()
    companion.extra = (f"--home={position.latitude_deg},{position.longitude_deg},0",)
    with companion, connected(companion) as system:
        telemetry, mission = Telemetry(system), MissionRaw(system)
        wait_until(
            lambda: telemetry.flight_mode() == FlightMode.MISSION and not telemetry.armed(), "Mission again, disarmed"
        )
        assert same(mission.download_mission(), twelve_items())
        assert same(mission.download_geofence(), fence_items())
        assert same(mission.download_rallypoints(), rally_items())
        assert Param(system).get_param_int("MIS_ON_START") == 1
        wait_until(lambda: mission.mission_progress().current >= 2, "its place")
        wait_until(lambda: telemetry.health().is_armable, "ready to arm")
        home = telemetry.home()
        assert math.dist(FRAME.to_ned(home.latitude_deg, home.longitude_deg), (0.0, 0.0)) < 1.0, (
            "home is where the first run began"
        )
        assert not near(telemetry, 0.0, 0.0, within_m=3.0), "the boat itself is not"
        Action(system).arm()  # MAVSDK chooses Hold before it arms
        start(mission)
        wait_until(lambda: mission.mission_progress().current >= 5, "under way again")


@pytest.mark.parametrize(
    "name", ["harbour_survey", "river_corridor", "mixed_frames", "laps", "doubled_points", "orbits"]
)
def test_plans_of_ground_stations_as_mavsdk_reads_them(name: str, mission: MissionRaw) -> None:
    """MAVSDK's own reader of .plan files against ours, and its download against its upload."""
    path = Path(__file__).parents[2] / "mission_files" / f"{name}.plan"
    plan = files.read(path.name, path.read_text(encoding="utf-8"))
    if name != "river_corridor":  # MAVSDK reads no corridor scans
        imported = mission.import_qgroundcontrol_mission(str(path))
        lists = (
            (imported.mission_items, plan.mission),
            (imported.rally_items, plan.rally),
            (imported.geofence_items, plan.fence),
        )
        for theirs, ours in lists:
            assert [(i.command, i.x, i.y) for i in theirs] == [(i.command, i.x, i.y) for i in ours]
    items = [as_sent(i) for i in plan.mission]
    mission.upload_mission(items)
    assert same(mission.download_mission(), items)


def as_sent(i: PlanItem) -> MissionItem:
    """Numbers as the wire has them, in 32 bits."""
    p1, p2, p3, p4, z = struct.unpack("<5f", struct.pack("<5f", i.param1, i.param2, i.param3, i.param4, i.z))
    return MissionItem(i.seq, i.frame, i.command, int(i.seq == 0), i.autocontinue, p1, p2, p3, p4, i.x, i.y, z, 0)


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Iterator[MissionRaw]:
    with Companion(tmp_path_factory.mktemp("plans"), speed=2.0) as companion, connected(companion) as system:
        yield MissionRaw(system)


def near(telemetry: Telemetry, north_m: float, east_m: float, within_m: float = 1.5) -> bool:
    position = telemetry.position()
    north, east = FRAME.to_ned(position.latitude_deg, position.longitude_deg)
    return math.hypot(north - north_m, east - east_m) < within_m
