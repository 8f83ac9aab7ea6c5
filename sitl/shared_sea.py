"""Lead boats that several simulated boats meet, all at the same time.

Worlds in one process may share one sea. Each steps it up to its own time, so it moves once; worlds that step in turn at
the same rate see it at the same moment. Places are north and east of one home, which all of them must have.

Processes share nothing: each simulates its own hull, and knows of a leader what comes over its link. With the same
script, seed and departure a process can also simulate the leader's wake.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.vessel import HomeConfig
from sitl.lead_boat import STEP_HZ, LeadBoat
from sitl.leader_script import script
from sitl.sensors import CommonWander
from sitl.wake import Wake


@dataclass(frozen=True, slots=True)
class LeadBoatConfig:
    """A lead boat: name, script (`sitl.leader_script`), start, time of departure (None: when told), grade of its
    receiver."""

    name: str
    script: str
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)  # north and east of home in m, heading in rad
    depart_s: float | None = None
    gnss: str = "standalone"


def build_shared_sea(
    others: Sequence[LeadBoatConfig], home: HomeConfig, seed: int, common_share: float = 0.0
) -> SharedSea:
    """The sea with these boats, each with its own errors from the seed and its name. `common_share`: of the slow
    position error, common to all receivers. Raises ConfigError for an unknown script or grade, or a share that is not 0
    to 1."""
    common = CommonWander(common_share, seed) if common_share > 0.0 else None
    boats = []
    for other in others:
        boat = LeadBoat(
            other.name, home, script(other.script), start=other.start, gnss=other.gnss, seed=seed, common=common
        )
        if other.depart_s is not None:
            boat.depart(other.depart_s)
        boats.append(boat)
    return SharedSea(boats, common)


class SharedSea:
    """The lead boats. `common`: the part of the position error that all receivers here share."""

    def __init__(self, boats: Sequence[LeadBoat], common: CommonWander | None = None) -> None:
        self.boats = tuple(boats)
        self.common = common
        self._steps = 0

    @property
    def wakes(self) -> tuple[Wake, ...]:
        """Those of all boats."""
        return tuple(boat.wake for boat in self.boats)

    def advance(self, now_s: float) -> None:
        """Take all steps that are due by `now_s`."""
        due = math.floor(now_s * STEP_HZ + 1e-6)
        while self._steps < due:
            self._steps += 1
            for boat in self.boats:
                boat.step()
