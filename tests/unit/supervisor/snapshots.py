"""Snapshots of a boat, for what its shell says of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from companion.config import vessel as config_module
from companion.core.actuation import (
    ZERO_WRENCH,
    ActuatorCommand,
    Allocation,
    ThrusterCommand,
    ThrusterCondition,
)
from companion.core.arming import ArmingReport
from companion.core.decision import Home, MissionProgress, MissionState, ModeId, Status
from companion.core.estimate import NO_ESTIMATE
from companion.core.readings import Battery, FixType
from companion.core.setpoint import NEUTRAL_SETPOINT
from companion.core.tick import DeviceHealth, Inputs, Tick
from companion.params.store import Parameters
from companion.supervisor.snapshot import BoatSnapshot

CONFIG = config_module.load(config_module.find("revolt"))
NAV = replace(
    NO_ESTIMATE,
    position_valid=True,
    heading_valid=True,
    lat_deg=63.44,
    lon_deg=10.4,
    yaw_rad=-0.001,
    surge_mps=0.3,
    north_mps=0.3,
    position_accuracy_m=0.02,
    heading_accuracy_rad=0.01,
    position_age_s=0.1,
    heading_age_s=0.2,
    fix=FixType.RTK_FIXED,
)
STATUS = Status(
    10.0, ModeId.HOLD, ModeId.HOLD, False, (), (), Home(63.441, 10.4, 0.0), MissionProgress(MissionState.PAUSED, 2, 5)
)
_STILL = tuple(ThrusterCommand(0.0, 0.0, None) for _ in CONFIG.thrusters)


def tick_of(**changes: Any) -> Tick:
    tick = Tick(
        t_s=10.0,
        time_unix_ns=0,
        nav=NAV,
        status=STATUS,
        setpoint=NEUTRAL_SETPOINT,
        wrench=ZERO_WRENCH,
        allocation=Allocation(_STILL, ZERO_WRENCH, (False, False, False)),
        command=ActuatorCommand(10.0, False, _STILL),
        inputs=Inputs(battery=Battery(10.0, "board", 12.34, None, 0.56)),
        feedback=(),
        health=(DeviceHealth("gnss", True, 0.1), DeviceHealth("imu", False, None, "no data")),
        conditions=(ThrusterCondition.READY,) * len(CONFIG.thrusters),
    )
    return replace(tick, **changes)


def snapshot(
    status: Mapping[str, Any] | None = None, tick: Mapping[str, Any] | None = None, **changes: Any
) -> BoatSnapshot:
    """`status`, `tick`: fields that differ."""
    report = ArmingReport((), frozenset(), frozenset(), frozenset())
    boat = BoatSnapshot(CONFIG, Parameters(), replace(STATUS, **(status or {})), report, tick_of(**(tick or {})))
    return replace(boat, **changes)
