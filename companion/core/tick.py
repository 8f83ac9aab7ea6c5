"""Values of the step record: one cycle of the loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from companion.core.actuation import ActuatorCommand, Allocation, ThrusterCondition, ThrusterFeedback, Wrench
from companion.core.decision import Event, Status
from companion.core.estimate import NavState
from companion.core.payload import Forward, Shot
from companion.core.readings import Battery, Corrections, Depth, Leak, ManualInput, RcInput, Reading, Wind
from companion.core.setpoint import Setpoint

COMPUTER = "computer"  # the name under which the computer has its health
STORAGE = "storage"  # the name under which the state and the log have their health


@dataclass(frozen=True, slots=True)
class DeviceHealth:
    """State of one sensor, bridge or link, as its driver sees it, or of the storage. `age_s`: since the last good
    message; None before the first. `text`: what is wrong."""

    name: str
    ok: bool
    age_s: float | None
    text: str = ""


@dataclass(frozen=True, slots=True)
class Inputs:
    """The newest of the slow readings. `battery`: the one that counts; `batteries`: every pack, always in the same
    order, None for one that fell silent."""

    battery: Battery | None = None
    leak: Leak | None = None
    rc: RcInput | None = None
    manual: ManualInput | None = None
    wind: Wind | None = None
    depth: Depth | None = None
    corrections: Corrections | None = None
    batteries: tuple[Battery | None, ...] = ()

    def renewed(self, newest: Mapping[str, Any]) -> Inputs:
        """With these, by the names of the fields. As `dataclasses.replace`, which takes much for each tick."""
        get = newest.get
        return Inputs(
            get("battery", self.battery),
            get("leak", self.leak),
            get("rc", self.rc),
            get("manual", self.manual),
            get("wind", self.wind),
            get("depth", self.depth),
            get("corrections", self.corrections),
            get("batteries", self.batteries),
        )


@dataclass(frozen=True, slots=True)
class Tick:
    """One whole cycle of the loop. The log, the telemetry and all displays are made from this alone."""

    t_s: float
    time_unix_ns: int
    nav: NavState
    status: Status
    setpoint: Setpoint
    wrench: Wrench
    allocation: Allocation
    command: ActuatorCommand
    inputs: Inputs
    feedback: tuple[ThrusterFeedback | None, ...]
    health: tuple[DeviceHealth, ...]
    events: tuple[Event, ...] = field(default=())
    load: float = 0.0  # share of the control period spent computing
    readings: Sequence[Reading] = ()  # the readings that the estimator got
    conditions: tuple[ThrusterCondition, ...] = ()
    shots: tuple[Shot, ...] = ()  # pictures taken in this tick
    forwards: tuple[Forward, ...] = ()  # commands of missions for cameras and gimbals on the links
