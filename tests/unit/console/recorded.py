"""A log folder of a ReVolt whose every value is known."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from companion.app import load_vessel
from companion.config.vessel import as_dict
from companion.core.actuation import ActuatorCommand, ThrusterCommand, ThrusterCondition, ThrusterFeedback
from companion.core.decision import Event, TextKind
from companion.core.setpoint import PoseSetpoint
from companion.core.tick import DeviceHealth
from companion.params.store import Parameters
from companion.record.recorder import LogFolder
from tests.unit.record.ticks import tick

REVOLT = load_vessel("revolt")


def write_log(folder: Path, seconds: int = 40) -> Path:
    """Ten ticks a second. The boat drifts 0.1 m/s north-east of its hold point, and turns 1 degree a second. The board
    measures the first thruster alone, until 30 s; the IMU is lost from 10 s to 15 s."""
    parameters = Parameters(REVOLT.parameters)
    manifest = {
        "vessel": "revolt",
        "parameters": {spec.name: parameters[spec.name] for spec in parameters.specs},
        "configuration": as_dict(REVOLT),
    }
    devices = [*(row.name for row in REVOLT.sensors), *(row.name for row in REVOLT.actuators)]
    log = LogFolder(folder, [t.name for t in REVOLT.thrusters], devices, manifest)
    thrusters = (
        ThrusterCommand(20.0, 0.86, math.radians(30.0)),
        ThrusterCommand(-10.0, -0.61, math.radians(-60.0)),
        ThrusterCommand(7.0, 0.68, None),
    )
    for n in range(10 * seconds):
        t_s = round(0.1 * n, 3)
        one = tick(t_s)
        nav = replace(one.nav, north_m=0.1 * t_s, east_m=0.1 * t_s, yaw_rad=math.radians(t_s), position_accuracy_m=0.25)
        events = (Event(t_s, TextKind.ALARM, "watch_alarm", f"Hold: off at {t_s:.0f}"),) if n % 100 == 50 else ()
        log.record(
            replace(
                one,
                nav=nav,
                setpoint=PoseSetpoint(1.0, -2.0, 0.3),
                command=ActuatorCommand(t_s, True, thrusters),
                conditions=(ThrusterCondition.READY,) * 3,
                events=events,
                readings=(ThrusterFeedback(t_s, "microcontroller", 0, 0.5, 0.2),) if t_s <= 30.0 else (),
                health=tuple(
                    DeviceHealth(
                        name, name != "imu" or not 10.0 <= t_s < 15.0, 0.0, "no bytes" if name == "imu" else ""
                    )
                    for name in devices
                ),
            )
        )
    log.close()
    return folder
