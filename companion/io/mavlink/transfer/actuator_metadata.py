"""Actuator metadata: which thrusters there are, for the Actuators page of QGroundControl, which tests them
(MAV_CMD_ACTUATOR_TEST). Without it that page cannot tell how many motors a boat has.

Source: MAVLink, component_metadata/actuators.schema.json, version 2. Motors have PX4's numbers of output functions. An
output is shown only if a parameter tells its function: the read-only ACT_FUNC1 and so on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from companion.config.devices import ThrusterConfig
from companion.params.compatibility import FIRST_MOTOR, MOTORS
from companion.supervisor.motor_test import MOST_POWER


def actuators(thrusters: Sequence[ThrusterConfig]) -> dict[str, Any]:
    """The content of actuators.json: the thrusters in the order of the vessel's file, as many as there are
    parameters."""
    shown = thrusters[:MOTORS]
    reverse = any(thruster.min_n < 0.0 for thruster in shown)
    values = {"min": -MOST_POWER if reverse else 0.0, "max": MOST_POWER, "default": 0.0}
    functions = {str(FIRST_MOTOR + i): {"label": f"Motor {i + 1}"} for i in range(len(shown))}
    outputs = {
        "label": "Thrusters",
        "subgroups": [
            {
                "per-channel-parameters": [{"label": "Function", "name": "ACT_FUNC${i}", "function": "function"}],
                "channels": [{"label": thruster.name, "param-index": i} for i, thruster in enumerate(shown, start=1)],
            }
        ],
    }
    return {
        "version": 2,
        "outputs_v1": [outputs],
        "functions_v1": {"0": {"label": "Disabled"}, **functions},
        "mixer_v1": {
            "actuator-types": {
                "motor": {
                    "values": values,
                    "function-min": FIRST_MOTOR,
                    "function-max": FIRST_MOTOR + MOTORS - 1,
                    "label-index-offset": 1,
                },
                "DEFAULT": {"values": {"min": -1, "max": 1, "default": 0}},
            },
            "config": [{"option": "true", "title": "Thrusters", "actuators": [_geometry(shown)]}],
        },
    }


def _geometry(thrusters: Sequence[ThrusterConfig]) -> dict[str, Any]:
    """Names and places. They carry no `function`: QGroundControl would draw a multirotor of them."""
    columns = {
        "Ahead, m": [thruster.x_m for thruster in thrusters],
        "To starboard, m": [thruster.y_m for thruster in thrusters],
        "Pushes, deg": [round(math.degrees(thruster.azimuth_rad), 1) for thruster in thrusters],
    }
    return {
        "group-label": "Thrusters",
        "count": len(thrusters),
        "actuator-type": "motor",
        "required": True,
        "item-label-prefix": [thruster.name for thruster in thrusters],
        "per-item-parameters": [{"label": label, "value": values} for label, values in columns.items()],
    }
