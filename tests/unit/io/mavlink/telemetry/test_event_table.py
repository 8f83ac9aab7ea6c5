"""The table of events and its metadata, against the rules of libevents' schema."""

from __future__ import annotations

import ast
import json
import re
from collections import Counter
from typing import Any

import pytest

from companion.app import load_vessel
from companion.config.vessel import bundled
from companion.core.arming import ArmingCheck, ArmingFinding, ArmingReport
from companion.core.decision import ModeId
from companion.io.mavlink.telemetry import event_table as table
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.transfer.events_metadata import events_json
from companion.io.mavlink.wire.personas import GENERIC, PX4
from companion.modes.mode import Mode
from companion.modes.table import DECLARATIONS, ROWS
from companion.params.table import TABLE
from docs.generate.source import modules
from docs.generate.templates import plain, templates
from tests.events_client import Metadata, Parsed

NAMES = ArmingEvents(["gnss", "imu"], ["stern_port", "bow"])
FILE: dict[str, Any] = json.loads(events_json(NAMES, PX4))
SOURCES = {  # where the reasons for which a mode refuses are made
    ModeId.CIRCLE: ("modes.circle", "guidance.orbit", "fence.guard"),
    ModeId.TRIAL: ("modes.trial.mode", "fence.guard"),
    ModeId.MISSION: ("modes.mission", "modes.parts.mission_terms", "fence.allowed"),
    ModeId.RTL: ("modes.rtl", "modes.parts.return_point"),
    ModeId.DOCK: ("modes.dock", "modes.parts.docking"),
    ModeId.FOLLOW: ("modes.follow", "following.watch"),
    ModeId.OFFBOARD: ("modes.offboard",),
}
WRAPPED = {("companion.modes.offboard", "_refusal")}  # its reasons come behind "setpoints refused"
CHECKING = (
    "check",
    "refusal",
    "_refusal",
    "radius_refusal",
    "point_refusal",
    "line_refusal",
    "way",
    "silence",
    "fault",
)


def test_ids_are_unique() -> None:
    assert all(count == 1 for count in Counter(row.sub_id for row in table.all_rows()).values())
    assert all(count == 1 for count in Counter(row.name for row in table.all_rows()).values())


def test_the_file_keeps_the_rules_of_the_schema() -> None:
    assert FILE["version"] == 2
    (component,) = FILE["components"].values()
    assert re.fullmatch(r"[a-z][a-z0-9_]*", component["namespace"])
    for name, enum in component["enums"].items():
        assert re.fullmatch(r"[a-zA-Z][a-zA-Z0-9_]*_t", name)
        for value, entry in enum["entries"].items():
            assert value.isdigit() and re.fullmatch(r"[a-z][a-z0-9_]*", entry["name"])
            assert entry["description"] and "\n" not in entry["description"]
    for group, events in component["event_groups"].items():
        assert re.fullmatch(r"[a-z][a-z0-9_]*", group)
        for event in events["events"].values():
            assert re.fullmatch(r"[a-zA-Z][a-zA-Z0-9_]*", event["name"])
            assert re.fullmatch(r"[^\n]{1,120}", event["message"])
            assert set(event) <= {"name", "message", "description", "type", "arguments"}
            for number in re.findall(r"\{(\d+)", event["message"] + event.get("description", "")):
                assert 1 <= int(number) <= len(event["arguments"])
    assert set(component) == {
        "namespace",
        "enums",
        "event_groups",
        "supported_protocols",
        "navigation_mode_groups",
    }


def test_every_mode_is_in_one_group() -> None:
    for persona in (PX4, GENERIC):
        metadata = Metadata(json.loads(events_json(NAMES, persona)))
        groups = [metadata.group_of(persona.custom_mode(mode)) for mode in DECLARATIONS]
        assert [1 << group for group in groups] == [table.MODE_BITS[mode] for mode in DECLARATIONS]
    assert max(table.MODE_BITS.values()) < 1 << 16 and len(table.HEALTH_COMPONENTS) <= 16


def test_remedies_name_parameters_that_there_are() -> None:
    known = {spec.name for spec in TABLE}
    for row in table.all_rows():
        assert row.kind or row.remedy, f"{row.name} has no remedy"
        for name in re.findall(r"<param>(.*?)</param>", row.remedy):
            assert name in known, f"{row.name}: {name}"
        assert "<" not in re.sub(r"</?param>", "", row.remedy)


@pytest.mark.parametrize("vessel", bundled())
def test_names_of_every_bundled_vessel_fit(vessel: str) -> None:
    config = load_vessel(vessel)
    names = ArmingEvents([row.name for row in config.sensors], [row.name for row in config.thrusters])
    assert len(events_json(names, PX4)) < 20_000


FINDINGS = (
    (ArmingFinding(ArmingCheck.POSITION, "position not valid"), "Position not valid", 3),
    (ArmingFinding(ArmingCheck.HEADING, "heading not valid", blocks=False), "Heading not valid", 4),
    (ArmingFinding(ArmingCheck.DEVICE, "imu: silent", "imu", None), "imu: nothing heard", 3),
    (ArmingFinding(ArmingCheck.DEVICE, "gnss: silent", "gnss", 4.0), "gnss: no good data", 3),
    (ArmingFinding(ArmingCheck.DEVICE, "x: silent", "x", 4.0), "0: no good data", 3),
    (ArmingFinding(ArmingCheck.THRUSTER, "thruster bow has failed", "bow"), "Thruster bow has failed", 3),
    (ArmingFinding(ArmingCheck.BATTERY, "battery critical: 12 % left", value=0.12), "Battery critical: 12 % left", 3),
    (ArmingFinding(ArmingCheck.BATTERY_LOW, "battery low", value=0.2, blocks=False), "Battery low: 20 % left", 4),
    (ArmingFinding(ArmingCheck.LEAK, "water in the hull"), "Water in the hull", 3),
    (ArmingFinding(ArmingCheck.AUTHORITY, "safe switch"), "The transmitter's safe switch is on", 3),
    (ArmingFinding(ArmingCheck.KILL_SWITCH, "kill switch"), "The transmitter's kill switch is on", 3),
    (ArmingFinding(ArmingCheck.KILL_SWITCH_FAULT, "channel 9 of 8"), "The kill switch would not work", 3),
    (ArmingFinding(ArmingCheck.FENCE, "fence is being prepared: wait"), "The fence is being prepared", 3),
    (
        ArmingFinding(ArmingCheck.MODE, "item 7 is 60 km away", modes=frozenset({ModeId.MISSION})),
        "Mission: the destination is over 50 km away",
        3,
    ),
    (ArmingFinding(ArmingCheck.MODE, "what?", modes=frozenset({ModeId.RTL})), "RTL: it cannot be entered now", 3),
)


def test_every_kind_of_finding_has_its_event() -> None:
    assert {finding.check for finding, _, _ in FINDINGS} == set(ArmingCheck)
    metadata = Metadata(FILE)
    for finding, text, level in FINDINGS:
        contents = NAMES.report(ArmingReport((finding,), frozenset(), frozenset(ModeId), frozenset(ArmingCheck)))
        begin, check, end = map(metadata.parse, contents)
        assert (begin.name, end.name) == ("arming_check_summary", "health_summary")
        assert (check.text, check.level) == (text, level) and check.remedy
        modes = set(ModeId) if finding.modes is None else finding.modes
        assert check.values[0] == sum(1 << list(DECLARATIONS).index(mode) for mode in modes)
        bit = 1 << check.values[1]
        assert (begin.values[1] & bit != 0, begin.values[2] & bit != 0) == (finding.blocks, not finding.blocks)
        assert end.values[1] & bit
        assert begin.values[3:] == [0, (1 << len(DECLARATIONS)) - 1]


def reasons(module_names: tuple[str, ...]) -> set[str]:
    """Examples of the texts that the functions in CHECKING return."""
    found: set[str] = set()
    for module in modules("companion"):
        if module.name.removeprefix("companion.") not in module_names:
            continue
        for function in (node for node in ast.walk(module.tree) if isinstance(node, ast.FunctionDef)):
            if function.name in CHECKING and (module.name, function.name) not in WRAPPED:
                values = (node.value for node in ast.walk(function) if isinstance(node, ast.Return) and node.value)
                texts = [plain(text) for value in values for text in templates(value, function)]
                found |= {re.sub(r"\{[^}]*\}", "9", text) for text in texts if re.search(r"[a-z]{3} ", text)}
    return found


@pytest.mark.parametrize("mode", SOURCES)
def test_each_reason_of_a_mode_is_known(mode: ModeId) -> None:
    found = reasons(SOURCES[mode])
    assert found
    for reason in found:
        assert any(re.fullmatch(known.pattern, reason) for known in DECLARATIONS[mode].refusals), reason


def test_modes_without_reasons_of_their_own_have_no_check() -> None:
    without = {row.kind.declaration.id for row in ROWS if row.kind.check is Mode.check}
    assert without == set(ModeId) - set(SOURCES)


def test_a_refusal_lists_the_checks() -> None:
    event: Parsed = Metadata(FILE).parse(NAMES.not_armed(0x04040000))
    assert event.kind == "append_health_and_arming_messages" and event.group == "default"
    assert event.values == [0x04040000] and event.level == 3
