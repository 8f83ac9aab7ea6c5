"""A tick for tests that need one."""

from __future__ import annotations

from dataclasses import replace

from companion.core.actuation import ActuatorCommand, Allocation, ThrusterCommand, ThrusterCondition, Wrench
from companion.core.decision import MissionProgress, MissionState, ModeId, Status
from companion.core.setpoint import PoseSetpoint
from companion.core.tick import DeviceHealth, Inputs, Tick
from tests.unit.estimates import AT_REST


def tick(t_s: float) -> Tick:
    nav = replace(
        AT_REST,
        t_s=t_s,
        lat_deg=63.4,
        lon_deg=10.4,
        north_m=1.5,
        east_m=-2.0,
        yaw_rad=0.3,
        surge_mps=0.4,
        north_mps=0.4,
        east_mps=0.1,
        yaw_rate_radps=0.01,
        heading_accuracy_rad=0.003,
        position_age_s=0.05,
        heading_age_s=0.05,
        imu_age_s=0.01,
        satellites=18,
    )
    status = Status(t_s, ModeId.HOLD, ModeId.HOLD, True, (), (), None, MissionProgress(MissionState.NO_MISSION, 0, 0))
    thrusters = (ThrusterCommand(10.0, 0.6, 0.1), ThrusterCommand(-7.0, -0.5, None))
    wrench = Wrench(3.0, 0.0, 1.0)
    return Tick(
        t_s=t_s,
        time_unix_ns=1_780_000_000_000_000_000 + round(t_s * 1e9),
        nav=nav,
        status=status,
        setpoint=PoseSetpoint(north_m=1.0, east_m=-2.0, yaw_rad=0.3),
        wrench=wrench,
        allocation=Allocation(thrusters, wrench, (False, False, False)),
        command=ActuatorCommand(t_s, True, thrusters),
        inputs=Inputs(),
        feedback=(None, None),
        health=(DeviceHealth("gnss", True, 0.05), DeviceHealth("imu", False, None, "no bytes yet")),
        conditions=(ThrusterCondition.READY, ThrusterCondition.MOVING),
    )
