"""The modes of the vessel, in the order in which ground stations show them. A new mode is one file and one row."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

from companion.config.vessel import VesselConfig
from companion.core.decision import ModeDeclaration, ModeId
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.fence.guard import FenceGuard
from companion.guidance.own_track import OwnTrack
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.modes.circle import CircleMode
from companion.modes.dock import DockMode
from companion.modes.follow import FollowMode
from companion.modes.forces import ForcesMode
from companion.modes.heading import HeadingMode
from companion.modes.hold import HoldMode
from companion.modes.manual import ManualMode
from companion.modes.mission import Destinations, MissionMode
from companion.modes.mode import Mode
from companion.modes.offboard import OffboardMode
from companion.modes.parts.berth import BerthChoice
from companion.modes.parts.docking import Docking
from companion.modes.parts.mission_fence import MissionFence
from companion.modes.parts.return_point import ReturnPoint
from companion.modes.rate import RateMode
from companion.modes.rtl import RtlMode
from companion.modes.trial.mode import TrialMode
from companion.obstacles.charted_fence import ChartedFence
from companion.params.store import Parameters


@dataclass(frozen=True, slots=True)
class Parts:
    """The parts from which modes are built. `frame` returns the estimator's local NED plane."""

    config: VesselConfig
    parameters: Parameters
    plans: Plans
    executor: MissionExecutor
    events: EventLog
    frame: Callable[[], LocalFrame]
    fence: FenceGuard
    charted: ChartedFence
    point: ReturnPoint
    berths: BerthChoice
    docking: Docking


class ModeRow(NamedTuple):
    """One mode class and the function that builds it."""

    kind: type[Mode]
    build: Callable[[Parts], Mode]


ROWS: tuple[ModeRow, ...] = (  # in display order; a mode's own failsafe is more severe than those of the rows below
    ModeRow(ManualMode, lambda p: ManualMode(p.config, p.parameters)),
    ModeRow(ForcesMode, lambda p: ForcesMode(p.config, p.parameters)),
    ModeRow(RateMode, lambda p: RateMode(p.config, p.parameters, p.events)),
    ModeRow(HeadingMode, lambda p: HeadingMode(p.config, p.parameters, p.events)),
    ModeRow(HoldMode, lambda p: HoldMode(p.config, p.parameters, p.events, p.fence)),
    ModeRow(MissionMode, lambda p: _mission(p)),
    ModeRow(RtlMode, lambda p: RtlMode(p.config, p.parameters, p.point, p.events, p.charted)),
    ModeRow(DockMode, lambda p: DockMode(p.config, p.docking, p.berths)),
    ModeRow(CircleMode, lambda p: CircleMode(p.config, p.parameters, p.events, p.frame, p.fence)),
    ModeRow(TrialMode, lambda p: TrialMode(p.config, p.parameters, p.events, p.frame, p.fence)),
    ModeRow(FollowMode, lambda p: FollowMode(p.config, p.parameters, p.events, p.fence)),
    ModeRow(OffboardMode, lambda p: OffboardMode(p.config, p.parameters, p.events, p.fence)),
)

DECLARATIONS: Mapping[ModeId, ModeDeclaration] = {row.kind.declaration.id: row.kind.declaration for row in ROWS}
"""The declaration of each mode, in display order."""


def _mission(p: Parts) -> MissionMode:
    fence = MissionFence(p.config, p.parameters, p.plans, p.executor, p.point, p.frame, p.charted)
    return MissionMode(
        p.config, p.parameters, p.executor, Destinations(p.point, p.berths, p.docking), p.events, p.frame, fence
    )


def build_modes(
    config: VesselConfig,
    parameters: Parameters,
    plans: Plans,
    executor: MissionExecutor,
    events: EventLog,
    frame: Callable[[], LocalFrame],
    charted: ChartedFence,
    track: OwnTrack,
) -> dict[ModeId, Mode]:
    """Every mode of the table, in display order. `track`: where the boat has been since it was armed."""
    fence = charted.guard
    point = ReturnPoint(parameters, plans, frame, fence, track)
    berths = BerthChoice(config, plans, frame)
    docking = Docking(config, parameters, events, fence)
    parts = Parts(config, parameters, plans, executor, events, frame, fence, charted, point, berths, docking)
    return {row.kind.declaration.id: row.build(parts) for row in ROWS}


M = TypeVar("M", bound=Mode)


def mode_of(modes: Mapping[ModeId, Mode], kind: type[M]) -> M:
    """The mode of class `kind`. Raises TypeError if another class is registered under its id."""
    mode = modes[kind.declaration.id]
    if not isinstance(mode, kind):
        raise TypeError(f"{kind.declaration.id.value} is a {type(mode).__name__}, not a {kind.__name__}")
    return mode
