"""The metadata file of the events interface: messages, remedies, enumerations and groups of modes, as libevents reads
them.

Source: libevents, `validation/schema.json` and README. It is made of the table of events, the modes and the names in
the vessel file, so the texts are never sent over the link again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from companion.io.mavlink.telemetry import event_table as table
from companion.io.mavlink.telemetry.arming_events import ArmingEvents
from companion.io.mavlink.telemetry.event_table import EventRow
from companion.io.mavlink.wire.personas import Persona
from companion.modes.table import DECLARATIONS

_VERSION = 2


def events_json(events: ArmingEvents, persona: Persona) -> bytes:
    """The file for links of that persona, which has its own numbers of modes."""
    described = {
        "namespace": "usv",
        "enums": {
            table.MODES: _bits("Modes", [(mode.name.lower(), mode.value) for mode in DECLARATIONS]),
            table.COMPONENTS: _bits("Parts", [(part.name, part.label) for part in table.HEALTH_COMPONENTS]),
            table.DEVICES: _names("Device", events.devices),
            table.THRUSTERS: _names("Thruster", events.thrusters),
        },
        "event_groups": _groups(table.all_rows()),
        "supported_protocols": ["health_and_arming_check"],
        "navigation_mode_groups": {
            "groups": {str(number): [persona.custom_mode(mode)] for number, mode in enumerate(DECLARATIONS)}
        },
    }
    content = {"version": _VERSION, "components": {str(table.COMPONENT_ID): described}}
    return json.dumps(content, separators=(",", ":"), ensure_ascii=False).encode()


def _groups(rows: Iterable[EventRow]) -> dict[str, Any]:
    groups: dict[str, Any] = {}
    for row in rows:
        groups.setdefault(row.group, {"events": {}})["events"][str(row.sub_id)] = _event(row)
    return groups


def _event(row: EventRow) -> dict[str, Any]:
    described: dict[str, Any] = {
        "name": row.name,
        "message": row.message,
        "arguments": [{"type": kind, "name": name} for kind, name in row.arguments],
    }
    if row.remedy:
        described["description"] = row.remedy
    if row.kind:
        described["type"] = row.kind
    return described


def _bits(text: str, entries: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """A set of named bits."""
    rows = {str(1 << number): {"name": name, "description": label} for number, (name, label) in enumerate(entries)}
    return {"type": "uint16_t", "is_bitfield": True, "description": text, "entries": rows}


def _names(text: str, names: Iterable[str]) -> dict[str, Any]:
    """Names that count from 1."""
    rows = {str(number): {"name": name, "description": name} for number, name in enumerate(names, start=1)}
    return {"type": "uint8_t", "description": text, "entries": rows}
