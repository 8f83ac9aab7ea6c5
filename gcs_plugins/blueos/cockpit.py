"""Offers Cockpit the actions of the table that are safe at one click, and buttons of a standard gamepad for some.

Shape: Cockpit, "External Integrations" and src/libs/blueos/schemas.ts (September 2026). Cockpit knows boats from
ArduPilot only, so the mode numbers are those of a link with ?dialect=ardupilot. A message goes to system 1, the default
of MAV_SYS_ID. Cockpit asks before its own commands only: a MAVLink message action is sent at once, so there are none
but those that are safe so. (A JavaScript action could ask, but Cockpit runs it at its start too.)
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from gcs_plugins.commands import ACTIONS, OperatorAction

EXTRAS = Path(__file__).with_name("cockpit_extras.json")
_PREFIX = "usv-companion"
_VERSION = "1.0.0"


def extras() -> dict[str, Any]:
    """The content of cockpit_extras.json."""
    return {
        "targetSystem": "Cockpit",
        "targetCockpitApiVersion": "1.0.0",
        "widgets": [],
        "actions": [_action(action) for action in ACTIONS if action.at_once],
        "joystickSuggestions": [
            {
                "id": f"{_PREFIX}-gamepad",
                "name": "USV companion on a standard gamepad",
                "description": "Hold and sticks by buttons, nudges and turns by the cross, stop with shift",
                "buttonMappingSuggestions": [_suggestion(action) for action in ACTIONS if action.button is not None],
                "version": _VERSION,
            }
        ],
    }


def text() -> str:
    """The text of cockpit_extras.json."""
    return json.dumps(extras(), indent=2) + "\n"


def _action(action: OperatorAction) -> dict[str, Any]:
    fields: dict[str, tuple[str, Any]] = {
        "target_system": ("number", 1),
        "target_component": ("number", 1),
        "command": ("type_struct_enum", f"MAV_CMD_{action.command.name}"),
        "confirmation": ("number", 0),
        **{f"param{n}": ("number", value) for n, value in enumerate(action.all_params(rover_numbers=True), start=1)},
    }
    message = {name: {"type": kind, "value": value} for name, (kind, value) in fields.items()}
    name = f"USV {action.label}"
    config = {"name": name, "messageType": "COMMAND_LONG", "messageConfig": message}
    return {
        "id": f"{_PREFIX}-{action.name}",
        "name": name,
        "type": "mavlink-message",
        "config": config,
        "version": _VERSION,
    }


def _suggestion(action: OperatorAction) -> dict[str, Any]:
    return {
        "id": f"{_PREFIX}-button-{action.name}",
        "actionProtocol": "cockpit-action",
        "actionName": f"USV {action.label}",
        "actionId": f"{_PREFIX}-{action.name}",
        "button": action.button,
        "modifierKey": "shift" if action.shift else "regular",
        "description": action.text,
    }
