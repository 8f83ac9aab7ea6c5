"""The boat at one moment, with everything that its shell tells of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.arming import ArmingReport
from companion.core.decision import Event, ModeId, Status
from companion.core.tick import Tick
from companion.modes.mode import ModeInfo
from companion.params.store import Parameters
from companion.supervisor.mode_changes import Cause


@dataclass(frozen=True, slots=True)
class BoatSnapshot:
    """`tick`: the last one, None before the first; `status` may be newer. `cause`: why the mode changed last.
    `refusals`: why each mode cannot be chosen now. `sources`: the sensor in use for each kind of reading. `events`: the
    newest, oldest first. `in_control`: the system with operator control, 0 for none."""

    config: VesselConfig
    parameters: Parameters
    status: Status
    report: ArmingReport
    tick: Tick | None = None
    cause: Cause | None = None
    modes: Sequence[ModeInfo] = ()
    refusals: Mapping[ModeId, str | None] | None = None
    sources: Mapping[str, str | None] | None = None
    events: Sequence[Event] = ()
    in_control: int = 0
