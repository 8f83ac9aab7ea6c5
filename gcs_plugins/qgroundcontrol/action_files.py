"""The action files as QGroundControl reads them: "MavlinkActions" since version 5.0, "CustomActions" in 4.4.

Each kind has a folder of its own in QGroundControl's save folder. Only documented keys are written: some versions
refuse others, and one bad action makes the whole list empty. An action fires at one click, so the files hold only
those that are safe so; QGroundControl's own buttons ask for the rest. Source: MavlinkActionManager.cc,
CustomActionManager.cc.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from gcs_plugins.commands import ACTIONS, OperatorAction

FILE_TYPES = ("MavlinkActions", "CustomActions")
FLY_VIEW = "usv_fly_view.json"
JOYSTICK = "usv_joystick.json"


def entry(action: OperatorAction) -> dict[str, Any]:
    """One action. Params that are 0 are left out, as QGroundControl's default. Modes have the px4 persona's numbers:
    float32 holds each exactly."""
    params = {f"param{n}": value for n, value in enumerate(action.all_params(), start=1) if value != 0.0}
    return {"label": action.label, "description": action.text, "mavCmd": int(action.command), **params}


def text(file_type: str, actions: Sequence[OperatorAction]) -> str:
    """One file."""
    content = {"version": 1, "fileType": file_type, "actions": [entry(action) for action in actions]}
    return json.dumps(content, indent=2) + "\n"


def files() -> Mapping[str, str]:
    """Path in the save folder → text, of all files."""
    at_once = [action for action in ACTIONS if action.at_once]
    buttons = [action for action in at_once if action.joystick]
    made = {}
    for file_type in FILE_TYPES:
        made[f"{file_type}/{FLY_VIEW}"] = text(file_type, at_once)
        made[f"{file_type}/{JOYSTICK}"] = text(file_type, buttons)
    return made
