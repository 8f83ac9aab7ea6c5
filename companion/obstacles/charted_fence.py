"""The fence and the chart together, as plans of a voyage ask for them: missions are checked, and led round, by both.

A mission that is uploaded is looked at beside the control thread: items in a chart's obstacles refuse it, and the ways
round what its legs cross are found there, so that they are at hand when it is entered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from companion.config.vessel import VesselConfig
from companion.core.geodesy import LocalFrame
from companion.core.ports import Worker
from companion.core.work import AtOnce, Lane
from companion.fence.allowed import Allowed, Place, Way
from companion.fence.guard import FenceGuard
from companion.mission.commands import DESTINATIONS
from companion.mission.plan import Adopt, PlanItem, PlanKind, PlanRefusal, PlanRefused, PlanResult, Plans
from companion.obstacles.chart_water import ChartKeeper
from companion.obstacles.open_water import OpenWater, Water
from companion.params.store import Parameters

_MOST_WAYS = 500  # remembered
_MOST_LOOKS = 200  # for ways, when a mission is uploaded

Found = dict[tuple[Place, Place], Way | None]


@dataclass(frozen=True, slots=True, eq=False)
class Allowance:
    """Where plans may send the boat, by fence and chart as they are at one moment. `found`: the ways found for them."""

    water: Water
    found: Found

    def in_lane(self, lane: Lane) -> Allowance:
        """The same for another thread (`FenceArea.in_lane`)."""
        return Allowance(self.water.in_lane(lane), self.found)

    @property
    def is_small(self) -> bool:
        """Whether there is no chart, and so small a fence that ways are found within a tick."""
        return self.water.chart is None and self.water.allowed.is_small

    def point_refusal(self, north_m: float, east_m: float, fenced: bool = True) -> str | None:
        """Why the boat may not be sent to that point; None where it may. `fenced` False: the chart alone counts."""
        chart = self.water.chart
        by_fence = self.water.allowed.point_refusal(north_m, east_m) if fenced else None
        return by_fence or (None if chart is None else chart.point_refusal(north_m, east_m))

    def line_refusal(self, line: Sequence[Place], fenced: bool = True) -> str | None:
        """Why the boat, at the begin of the line, may not be sent along it; None where it may. `fenced`: as above."""
        chart = self.water.chart
        by_fence = self.water.allowed.line_refusal(line) if fenced else None
        return by_fence or (None if chart is None else chart.line_refusal(line))

    def is_open(self, begin: Place, end: Place) -> bool:
        """Whether the boat at `begin` may be sent straight to `end`, by both."""
        return self.water.is_open(begin, end)

    def inside(self, places: Sequence[Place]) -> Sequence[bool]:
        """Whether the boat may be sent to each of the places."""
        by_fence, chart = self.water.allowed.inside(places), self.water.chart
        if chart is None:
            return by_fence
        return [a and b for a, b in zip(by_fence, chart.keeping.contains_each(places), strict=True)]

    def clear(self, lines: Sequence[Sequence[Place]]) -> Sequence[bool]:
        """Whether each line lies where the boat may be sent. False only means that `line_refusal` must tell."""
        return _clear(self.water, lines)

    def allows_berth(self, line: Sequence[Place]) -> bool:
        """As `Allowed.allows_berth`: a berth lies at the land."""
        return self.water.allowed.allows_berth(line)

    def way(self, begin: Place, end: Place) -> Way | None:
        """The shortest way that keeps clear of both; None where there is none."""
        if (begin, end) not in self.found:
            if len(self.found) >= _MOST_WAYS:
                self.found.clear()
            self.found[begin, end] = self.water.way(begin, end)
        return self.found.get((begin, end))


class ChartedFence:
    """`now` → fence and chart as they are. Remembers the ways found while neither changes. `worker` looks for ways that
    modes ask for; None: that is done at once."""

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        frame: Callable[[], LocalFrame],
        fence: FenceGuard,
        chart: ChartKeeper,
    ) -> None:
        self._fence = fence
        self._chart = chart
        self._water = OpenWater(config, parameters, fence, chart)  # without what sensors see
        self._parameters = parameters
        self._frame = frame
        self._worker: Worker = AtOnce()
        self._found: Found = {}
        self._found_key: object = None
        plans.prepare_by(PlanKind.MISSION, self.prepare)

    def work_with(self, worker: Worker) -> None:
        """Let `worker` look for ways."""
        self._worker = worker

    def submit(self, work: Callable[[], Any]) -> Future[Any]:
        """Carry out `work` that nobody waits for, beside the control thread where there is a worker."""
        return self._worker.submit(work)

    def submit_urgent(self, work: Callable[[], Any]) -> Future[Any]:
        """Carry out `work` that the boat waits for."""
        return self._worker.submit(work, urgent=True)

    @property
    def now(self) -> Allowance:
        """Fence and chart as they are now."""
        self._mind_key()
        return Allowance(self._water.now, self._found)

    @property
    def guard(self) -> FenceGuard:
        """The fence alone."""
        return self._fence

    @property
    def key(self) -> tuple[object, ...]:
        """Changes whenever the open water may have changed; () while there is neither a fence nor a chart."""
        return (*self._fence.key, *self._chart.key)

    def _mind_key(self) -> None:
        key = (self.key, self._parameters["NAV_ACC_RAD"])
        if key != self._found_key:
            self._found, self._found_key = {}, key

    def prepare(self, items: Sequence[PlanItem]) -> Callable[[], Adopt]:
        """The work that a new mission needs (`Plans.prepare_by`). It raises PlanRefused for one that the chart does not
        allow: an item in an obstacle, or no way round one (MIS_ROUND 0: a leg that crosses one)."""
        now, rounds, frame = self.now, bool(self._parameters["MIS_ROUND"]), self._frame()

        def work() -> Adopt:
            water = now.water.in_lane(Lane.USUAL)
            destinations = [item for item in items if item.command in DESTINATIONS]
            stops = [(item, frame.to_ned(item.lat_deg, item.lon_deg)) for item in destinations]
            _check_places(water, stops)
            found = dict(_looks(water, stops, rounds)) if rounds or water.chart is not None else {}

            def adopt() -> None:
                if self._found is now.found:
                    now.found.update(found)

            return adopt

        return work


Stops = Sequence[tuple[PlanItem, Place]]


def _check_places(water: Water, stops: Stops) -> None:
    """Raises PlanRefused for an item in a chart's obstacle."""
    if water.chart is None:
        return
    for (item, place), open_to_it in zip(
        stops, water.chart.keeping.contains_each([place for _, place in stops]), strict=True
    ):
        if not open_to_it:
            text = f"{water.chart.point_refusal(*place)}; move it"
            raise PlanRefused(PlanRefusal(PlanResult.INVALID_PARAM5_X, text, item.seq))


def _looks(water: Water, stops: Stops, rounds: bool) -> Iterator[tuple[tuple[Place, Place], Way | None]]:
    """The ways round what the legs cross. Raises PlanRefused where the chart leaves none."""
    legs = [(a, b) for (_, a), (_, b) in pairwise(stops)]
    charted = Water(water.circles, water.keep_m, Allowed(None, None, 0.0, water.allowed.radius_m), water.chart)
    looks = 0
    for (begin, end), (item, _), is_clear in zip(legs, stops[1:], _clear(water, legs), strict=True):
        if is_clear or water.clear(begin, end) or looks >= _MOST_LOOKS:
            continue
        looks += 1
        crosses = not charted.clear(begin, end)
        if crosses and not rounds:
            text = "way crosses a chart obstacle; draw it round"
            raise PlanRefused(PlanRefusal(PlanResult.INVALID_PARAM5_X, text, item.seq))
        if rounds:
            way = water.way(begin, end)
            if way is None and crosses and charted.way(begin, end) is None:
                text = "no way round a chart obstacle; move it"
                raise PlanRefused(PlanRefusal(PlanResult.INVALID_PARAM5_X, text, item.seq))
            yield (begin, end), way


def _clear(water: Water, lines: Sequence[Sequence[Place]]) -> Sequence[bool]:
    by_fence = water.allowed.clear(lines)
    if water.chart is None:
        return by_fence
    return [a and b for a, b in zip(by_fence, water.chart.keeping.covers_lines(lines), strict=True)]
