"""Arming checks as a list, by MAVSDK's events plug-in against the running process, and over a link that loses half."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from mavsdk import ComponentType, Configuration, Mavsdk, System
from mavsdk.plugins.action import Action, ActionError
from mavsdk.plugins.events import Event, Events, EventsError, HealthAndArmingCheckReport, LogLevel
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.mission_raw import MissionRaw
from mavsdk.plugins.telemetry import Telemetry

from companion.cli.rig import LockstepRig
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.transfer.events_metadata import events_json
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import PX4
from sitl.scenarios.rig import Conditions
from tests.events_client import EventsClient, Metadata
from tests.protocol.desk import Desk
from tests.protocol.process import Companion
from tests.protocol.test_mavsdk import item
from tests.waiting import CAP_S, wait_until


@contextmanager
def connected(companion: Companion) -> Iterator[System]:
    with Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION)) as sdk:
        sdk.add_any_connection(f"udpin://127.0.0.1:{companion.udp_port}")
        system = sdk.first_autopilot(CAP_S)
        assert system is not None, "MAVSDK found no autopilot"
        yield system


def report_of(events: Events) -> HealthAndArmingCheckReport | None:
    try:
        return events.get_health_and_arming_checks_report()
    except EventsError:
        return None


def may_arm(events: Events) -> bool:
    report = report_of(events)
    return report is not None and report.current_mode_intention.can_arm_or_run


def problems(events: Events) -> dict[str, str]:
    """Message → remedy of all problems in the last report; empty before the first."""
    report = report_of(events)
    return {} if report is None else {one.message: one.description for one in report.all_problems}


def choose_follow(system: System) -> None:
    """Main mode 4, sub-mode 8."""
    direct = MavlinkDirect(system)
    request = {"target_system": 1, "target_component": 1, "command": 176, "confirmation": 0}
    request |= {"param1": 1.0, "param2": 4.0, "param3": 8.0} | {f"param{n}": 0.0 for n in range(4, 8)}
    direct.send_message(MavlinkMessage("COMMAND_LONG", 0, 0, 1, 1, json.dumps(request)))
    direct.destroy()


def arm(system: System) -> str:
    """MAVSDK's result."""
    try:
        Action(system).arm()
    except ActionError as error:
        return str(error.result.name)
    return "SUCCESS"


@pytest.mark.process
def test_mavsdk_lists_the_checks_with_their_remedies(tmp_path: Path) -> None:
    """A plan comes, a mode without its leader is chosen, arming is refused."""
    with Companion(tmp_path, speed=5.0) as companion, connected(companion) as system:
        events, telemetry, mission = Events(system), Telemetry(system), MissionRaw(system)
        said: list[Event] = []
        texts: list[str] = []
        events.subscribe_events(lambda event, _: said.append(event))
        telemetry.subscribe_status_text(lambda text, _: texts.append(text.text))
        wait_until(lambda: problems(events).get("Mission: no mission loaded"), "the first report")
        assert problems(events)["Mission: no mission loaded"] == "Draw a plan and upload it."
        wait_until(lambda: may_arm(events), "may be armed")
        mission.upload_mission([item(0, 16, (8.0, 0.0), 0.0, 0.0, 0.0, math.nan)])
        wait_until(lambda: "Mission: no mission loaded" not in problems(events), "the plan is there")

        choose_follow(system)
        wait_until(lambda: not may_arm(events), "Follow without a leader")
        report = report_of(events)
        assert report is not None
        now = report.current_mode_intention.problems
        assert [(one.message, one.log_level) for one in now] == [("Follow: no leader heard", LogLevel.ERROR)]
        parts = {part.name: part for part in report.health_components}
        assert parts["modes"].has_error and not parts["gps"].has_error and parts["gps"].is_present
        assert arm(system) == "COMMAND_DENIED"
        wait_until(lambda: bool(said), "the refusal")
        assert said[-1].event_name == "arming_refused" and "Follow: no leader heard" in said[-1].message
        wait_until(lambda: "PreArm: Follow: no leader heard" in texts, "the text for all others")


class LossyDesk(Desk):
    """A desk whose link loses a share of all messages, both ways."""

    def __init__(self, folder: Path, share: float) -> None:
        super().__init__(folder, LockstepRig(Conditions("revolt", seed=3), folder / "log"))
        self._chance, self._share = random.Random(7), share

    def lossy(self, messages: list[Any]) -> list[Any]:
        return [message for message in messages if self._chance.random() >= self._share]


def test_the_list_is_whole_over_a_link_that_loses_half(tmp_path: Path) -> None:
    desk = LossyDesk(tmp_path, 0.5)
    config = desk.vessel.config
    devices = [row.name for row in (*config.sensors, *config.actuators)]
    content = json.loads(events_json(ArmingEvents(devices, [row.name for row in config.thrusters]), PX4))
    asked: list[Any] = []
    client = EventsClient(
        Metadata(content), lambda first, last: asked.append(mavlink.MAVLink_request_event_message(1, 1, first, last))
    )

    def hear(messages: list[Any]) -> None:
        for message in desk.lossy(messages):
            client.take(message)

    def group() -> int:
        return Metadata(content).group_of(0x00010000)

    for _ in range(600):
        hear(desk.tick())
        waiting, asked[:] = list(asked), []
        for request in desk.lossy(waiting):
            hear(desk.tell(request))
        if client.reports and client.reports[-1].can_arm >> group() & 1:
            break
    assert client.reports[-1].of(group()) == [] and client.lost == 0
    assert "Follow: no leader heard" in [check.text for check in client.reports[-1].checks]
    desk.close()
