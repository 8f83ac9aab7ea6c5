"""Why the boat cannot be armed: as a list for those who use events, as texts for all others, and never as both."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from companion.core.arming import ArmingCheck, ArmingFinding
from companion.core.decision import Event, ModeId, TextKind
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.transfer.events_metadata import events_json
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import PX4
from tests.events_client import EventsClient, Metadata
from tests.unit.io.mavlink.hub.conftest import Rig

Named = Callable[[Sequence[Any], str], list[Any]]
NO_POSITION = ArmingFinding(ArmingCheck.POSITION, "No position")
NO_PLAN = ArmingFinding(ArmingCheck.MODE, "no mission loaded", modes=frozenset({ModeId.MISSION}))
HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3)
MANUAL, MISSION = 0x00010000, 0x04040000
METADATA, CHECKS = (512, 397.0), (401,)


class Station:
    """A ground station at one desk of a rig, which heart-beats and takes in events."""

    def __init__(self, rig: Rig, desk: int = 0) -> None:
        self.rig, self.desk = rig, desk
        self.metadata = Metadata(json.loads(events_json(ArmingEvents((), ()), PX4)))
        self.client = EventsClient(self.metadata, self._ask)
        self.texts: list[str] = []

    def _ask(self, first: int, last: int) -> None:
        self.rig.desks[self.desk].send(mavlink.MAVLink_request_event_message(1, 1, first, last))

    def hear(self) -> None:
        for message in self.rig.desks[self.desk].hear():
            self.take(message)

    def take(self, message: Any) -> None:
        self.client.take(message)
        if message.get_type() == "STATUSTEXT":
            self.texts.append(message.text)

    def command(self, number: int, *params: float) -> Any:
        answers = self.rig.command(number, *params, desk=self.desk)
        for message in answers:
            self.take(message)
        return next(message.result for message in answers if message.get_type() == "COMMAND_ACK")

    def prearms(self) -> list[str]:
        texts, self.texts = self.texts, []
        return [text for text in texts if text.startswith("PreArm")]


def live(stations: Sequence[Station], duration_s: float) -> None:
    rig = stations[0].rig
    for _ in range(round(duration_s)):
        for station in stations:
            rig.desks[station.desk].send(HEARTBEAT)
        rig.run(1.0)
        for station in stations:
            station.hear()


@pytest.fixture
def station(rig: Rig) -> Station:
    rig.supervisor.findings = (NO_POSITION, NO_PLAN)
    rig.supervisor.change(arming_refusals=("No position",))
    return Station(rig)


def test_the_list_comes_without_being_asked_for(station: Station) -> None:
    live([station], 5.0)
    report = station.client.reports[-1]
    manual, mission = (station.metadata.group_of(mode) for mode in (MANUAL, MISSION))
    assert report.of(manual) == ["Position not valid"]
    assert report.of(mission) == ["Position not valid", "Mission: no mission loaded"]
    assert report.can_arm == 0 and report.parts["gps"] == (True, True, False)
    assert report.checks[1].remedy == "Draw a plan and upload it."
    assert station.client.lost == 0


def test_a_change_is_reported_and_nothing_else(station: Station) -> None:
    live([station], 10.0)
    assert len(station.client.reports) == 1
    station.rig.supervisor.findings = ()
    live([station], 10.0)
    assert [len(report.checks) for report in station.client.reports] == [2, 0]
    assert station.client.reports[-1].can_arm == (1 << len(ModeId)) - 1


def test_one_that_uses_events_gets_no_texts(station: Station) -> None:
    """The sequence of QGroundControl, which may have the files from an earlier connection."""
    live([station], 2.0)
    assert station.command(*METADATA) == mavlink.MAV_RESULT_ACCEPTED
    live([station], 3.0)
    assert station.command(*CHECKS) == mavlink.MAV_RESULT_ACCEPTED
    live([station], 100.0)
    assert station.prearms() == []
    assert len(station.client.reports) == 2  # the second was asked for


def test_armed_too_it_gets_the_list(station: Station) -> None:
    station.rig.supervisor.change(armed=True)
    live([station], 5.0)
    station.command(*METADATA)
    assert station.command(*CHECKS) == mavlink.MAV_RESULT_ACCEPTED
    live([station], 2.0)
    assert len(station.client.reports) == 2


def test_reports_are_asked_for_once_a_second_at_most(station: Station) -> None:
    live([station], 5.0)
    station.command(*METADATA)
    for _ in range(50):
        station.command(*CHECKS)
        station.rig.tick()
        station.hear()
    assert 5 <= len(station.client.reports) - 1 <= 6


@pytest.mark.parametrize("asks", [(), (METADATA,), (CHECKS,)])
def test_all_others_get_texts(station: Station, asks: Sequence[tuple[float, ...]]) -> None:
    for number, *params in asks:
        station.command(int(number), *params)
    station.prearms()
    live([station], 70.0)
    assert 2 <= len(station.prearms()) <= 3


def test_who_does_not_use_events_is_answered_with_texts(station: Station) -> None:
    live([station], 1.0)
    assert station.command(*CHECKS) == mavlink.MAV_RESULT_ACCEPTED
    assert station.prearms() == ["PreArm: No position"]
    station.rig.supervisor.change(armed=True)
    station.rig.serve()
    assert station.command(*CHECKS) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED


def test_each_ground_station_has_what_it_knows(make_rig: type[Rig]) -> None:
    rig = make_rig(["memory:a", "memory:b", "memory:c?dialect=ardupilot"])
    rig.supervisor.findings = (NO_POSITION,)
    rig.supervisor.change(arming_refusals=("No position",))
    ground, proxy, rover = (Station(rig, desk) for desk in range(3))
    live([ground, proxy, rover], 2.0)
    ground.command(*METADATA)
    ground.command(*CHECKS)
    live([ground, proxy, rover], 65.0)
    assert (len(ground.prearms()), len(proxy.prearms()), len(rover.prearms())) == (0, 3, 3)
    assert ground.client.reports and proxy.client.reports
    assert rover.client.reports == [] and rover.client.lost == 0


def test_the_persona_of_ardupilot_hears_no_events(make_rig: type[Rig], named: Named) -> None:
    rig = make_rig(["memory:?dialect=ardupilot"])
    rig.supervisor.findings = (NO_POSITION,)
    rig.run(5.0)
    heard = rig.desk.hear()
    assert named(heard, "EVENT") == [] and named(heard, "CURRENT_EVENT_SEQUENCE") == []


def test_another_program_on_the_same_link_gets_texts_again(station: Station) -> None:
    live([station], 1.0)
    station.command(*METADATA)
    station.command(*CHECKS)
    live([station], 40.0)
    assert station.prearms() == []
    station.rig.run(40.0)  # silence
    station.hear()
    station.prearms()
    live([station], 8.0)
    assert station.prearms() == ["PreArm: No position"]


def test_two_behind_one_link_get_what_both_know(station: Station) -> None:
    live([station], 1.0)
    station.command(*METADATA)
    station.command(*CHECKS)
    station.rig.desk.system = 200
    station.rig.desk.send(HEARTBEAT)
    station.rig.desk.system = 255
    live([station], 6.0)
    assert station.prearms() == ["PreArm: No position"]


def test_a_refusal_to_arm_is_an_event_with_the_list(station: Station) -> None:
    live([station], 4.0)
    station.rig.tick(events=(Event(4.0, TextKind.REFUSAL, "arming_refused", "PreArm: No position"),))
    station.hear()
    (event,) = station.client.events
    assert (event.kind, event.level, event.text) == ("append_health_and_arming_messages", 3, "Not armed:")
    assert event.values == [PX4.custom_mode(ModeId.HOLD)]


def test_the_numbers_begin_anew_with_the_program(rig: Rig, named: Named) -> None:
    rig.run(2.0)
    before = named(rig.desk.hear(), "CURRENT_EVENT_SEQUENCE")
    assert before and {(message.sequence, message.flags) for message in before} == {(0, 1)}
    rig.run(3.0)
    heard = rig.desk.hear()
    events = named(heard, "EVENT")
    assert [event.sequence for event in events] == list(range(1, len(events) + 1))
    after = named(heard, "CURRENT_EVENT_SEQUENCE")
    assert (after[-1].sequence, after[-1].flags) == (len(events), 0)
