"""Checks that the rest of a mission, as the boat would sail it, stays inside the fence and clear of the chart's
obstacles; else names the item. Makes what a mission's ways are led and laid by."""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.config.vessel import VesselConfig
from companion.core.decision import ModeInputs
from companion.core.geodesy import LocalFrame
from companion.core.work import Lane, Submit
from companion.fence.guard import FenceGuard
from companion.guidance.path_laying import TrackShape
from companion.mission.executor import MissionExecutor
from companion.mission.plan import PlanKind, Plans
from companion.modes.parts.mission_terms import MissionTerms, unfenced
from companion.modes.parts.return_point import ReturnPoint
from companion.modes.parts.search import SAME_PLACE_M, Key, Search
from companion.obstacles.charted_fence import ChartedFence
from companion.params.store import Parameters

_SHAPE = (
    "PATH_KIND",
    "NAV_ACC_RAD",
    "WP_CORNER",
    "PATH_EFFORT",
    "PATH_SURVEY",
    "WP_YAW_MODE",
    "MPC_XY_VEL_MAX",
    "PATH_YAW_RATE",
    "PATH_ACC_LAT",
    "RTL_USE_RALLY",
    "CIRC_RADIUS",
    "CIRC_DIR",
    "MIS_ROUND",
)


class MissionFence:
    """`refusal` checks the rest of the mission beside the control thread; `terms` is what its ways depend on now.

    The check has two parts: from the boat to the first place of the mission, anew whenever the boat has moved, and from
    there on. Until they are complete, a mission is refused only for what was found by then. Remembers the answers.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        executor: MissionExecutor,
        point: ReturnPoint,
        frame: Callable[[], LocalFrame],
        charted: ChartedFence,
    ) -> None:
        self._config = config
        self._parameters = parameters
        self._plans = plans
        self._executor = executor
        self._point = point
        self._frame = frame
        self._charted = charted
        self._first: Search[str | None] = Search(charted.submit)
        self._rest: Search[str | None] = Search(charted.submit)
        self._checked = True
        self._unfenced_of: tuple[int, frozenset[int]] = (0, frozenset())  # of the mission with that id

    @property
    def guard(self) -> FenceGuard:
        """The fence guard that checks single points and lines."""
        return self._charted.guard

    @property
    def submit_urgent(self) -> Submit:
        """Carries out what the boat waits for."""
        return self._charted.submit_urgent

    @property
    def key(self) -> Key:
        """Changes whenever fence or chart may have changed; () without."""
        return self._charted.key

    def terms(self, inputs: ModeInputs, shape: TrackShape, own_law: bool = True) -> MissionTerms:
        """What the ways of the mission depend on now."""
        return MissionTerms(
            self._config,
            self._parameters.frozen(),
            self._frame(),
            self._charted.now,
            self._unfenced,
            self._point.now(inputs.home),
            shape,
            own_law,
            bool(self.key),
        )

    def refusal(self, inputs: ModeInputs, shape: TrackShape) -> str | None:
        """Return which item leads out of the fence or into a chart obstacle, and why; None if none does as far as that
        is checked. Callers ask every tick while disarmed, so the answer is kept while the boat stays within 1 m."""
        nav, key = inputs.nav, self._key(inputs)
        self._checked = True
        if not self.key or not nav.position_valid:
            return None
        here = (nav.north_m, nav.east_m)
        first, rest = self._first.known(key, here, SAME_PLACE_M), self._rest.known(key, here)
        if first is None or rest is None:
            terms, tasks, others = self.terms(inputs, shape), self._executor.ahead(), self._executor.ahead()
            first = self._first.look(key, here, lambda: terms.in_lane(Lane.USUAL).first_refusal(tasks, here))
            rest = self._rest.look(key, here, lambda: terms.in_lane(Lane.USUAL).rest_refusal(others, here), math.inf)
            self._checked = first is not None and rest is not None
        newest = first or self._first.known(key, here)
        found = None if newest is None else newest.found
        return found or (None if rest is None else rest.found)

    @property
    def checked(self) -> bool:
        """Whether the check of the mission asked for last is complete."""
        return self._checked

    def _key(self, inputs: ModeInputs) -> Key:
        """What the check depends on, besides the boat's place."""
        progress, ids = self._executor.progress, [self._plans.plan_id(kind) for kind in PlanKind]
        shape = [self._parameters[name] for name in _SHAPE]
        return self.key, tuple(ids), progress.state, progress.seq, inputs.home, tuple(shape)

    @property
    def _unfenced(self) -> frozenset[int]:
        """See `unfenced`, of the mission in force."""
        if self._unfenced_of[0] != (mission := self._plans.plan_id(PlanKind.MISSION)):
            self._unfenced_of = mission, unfenced(self._plans.items(PlanKind.MISSION))
        return self._unfenced_of[1]
