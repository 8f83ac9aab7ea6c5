"""Surroundings, a mode and traffic as the guard against obstacles sees them, set by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from companion.config.vessel import VesselConfig
from companion.core.decision import ModeId, ModeInputs
from companion.core.estimate import Contact
from companion.core.events import EventLog
from companion.fence.guard import FenceGuard
from companion.mission.plan import Plans
from companion.obstacles.occupancy import Floats
from companion.obstacles.way_round import WayRound
from companion.params.store import Parameters
from tests.unit.obstacles.charted import FRAME

Place = tuple[float, float]


@dataclass
class NoShoals:
    way_m: float = float("inf")

    def way_along_m(self, along: Place) -> float:
        return self.way_m


@dataclass
class Seen:
    """Circles that lie, and what moves. `passing`: circles of the latter, as they are seen now."""

    circles: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    passing: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    moving: list[Contact] = field(default_factory=list)
    on: bool = True
    heard: bool = True
    shoals: NoShoals = field(default_factory=NoShoals)

    def lying(self, now_s: float) -> Floats:
        return self.circles

    def all_circles(self, now_s: float) -> Floats:
        return np.concatenate((self.circles, self.passing))

    def movers(self, now_s: float) -> list[Contact]:
        return self.moving


@dataclass
class Sailing:
    """A mode with a way; what it is told."""

    way: Sequence[Place] = ()
    goes_round: bool = False
    drifts: bool = False
    docking: bool = False
    by_stick: bool = False
    id: ModeId = ModeId.MISSION
    found: object = None
    laid: list[object] = field(default_factory=list)
    reason: str | None = None
    excused: int = 0
    held_point: Place | None = None

    def way_ahead(self) -> Sequence[Place]:
        return self.way

    def way_round(self, inputs: ModeInputs) -> WayRound[object]:
        end = self.way[-1]
        here = (inputs.nav.north_m, inputs.nav.east_m)

        def lay(found: object, inputs: ModeInputs) -> str | None:
            self.laid.append(found)
            return "no open water" if found is None else None

        return WayRound(lambda water: water.way(here, end), lay)

    def hold_instead(self, north_m: float, east_m: float) -> None:
        self.held_point = north_m, east_m

    def excuse(self) -> None:
        self.excused += 1


class NoTraffic:
    detour_ahead: Sequence[Place] = ()

    def give_up_detour(self) -> None:
        raise AssertionError("there is no detour")


def no_fence(config: VesselConfig, parameters: Parameters) -> FenceGuard:
    return FenceGuard(config, parameters, Plans(), EventLog(), lambda: FRAME, lambda: None)
