"""The modes of the vessel, in the order in which ground stations show them."""

from __future__ import annotations

from collections.abc import Callable

from companion.config import VesselConfig
from companion.core.geodesy import LocalFrame
from companion.core.types import ModeId
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.modes.berth import BerthChoice
from companion.modes.dock import DockMode
from companion.modes.docking import Docking
from companion.modes.events import EventLog
from companion.modes.fence_guard import FenceGuard
from companion.modes.follow import FollowMode
from companion.modes.forces import ForcesMode
from companion.modes.heading import HeadingMode
from companion.modes.hold import HoldMode
from companion.modes.manual import ManualMode
from companion.modes.mission import MissionMode
from companion.modes.mission_fence import MissionFence
from companion.modes.mode import Mode
from companion.modes.offboard import OffboardMode
from companion.modes.rtl import ReturnPoint, RtlMode
from companion.params import Parameters


def build_modes(
    config: VesselConfig,
    parameters: Parameters,
    plans: Plans,
    executor: MissionExecutor,
    events: EventLog,
    frame: Callable[[], LocalFrame],
    fence: FenceGuard,
) -> dict[ModeId, Mode]:
    """Every mode of the table, in display order. `frame` gives the local NED plane that the estimator works in."""
    point = ReturnPoint(parameters, plans, frame, fence)
    berths = BerthChoice(config, plans, frame)
    mission_fence = MissionFence(config, parameters, plans, executor, point, berths, frame, fence)
    docking = Docking(config, parameters, events, fence)
    modes: tuple[Mode, ...] = (
        ManualMode(config, parameters),
        ForcesMode(config, parameters),
        HeadingMode(config, parameters),
        HoldMode(config, parameters, events, fence),
        MissionMode(config, parameters, executor, point, docking, berths, events, frame, mission_fence),
        RtlMode(config, parameters, point, events, fence),
        DockMode(config, docking, berths),
        FollowMode(config, parameters, events, fence),
        OffboardMode(config, parameters, events, fence),
    )
    return {mode.id: mode for mode in modes}
