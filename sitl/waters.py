"""Other boats in the same waters, all at the time of whoever asks.

Several worlds in one process may share one waters: each brings it up to its own time, so it moves once, and vessels that tick in turn at the same rate see
it at the same moment. Places are north and east of one home, which all of these vessels must have. In processes of their own nothing is shared: each
simulates its own hull, and of a leader knows what comes over its link; given the same script, seed and departure a process can have the
leader's wake as well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config import HomeConfig
from sitl.lead_boat import STEP_HZ, LeadBoat
from sitl.leader_script import script
from sitl.sensors import CommonWander
from sitl.wake import Wake


@dataclass(frozen=True, slots=True)
class OtherBoat:
    """A lead boat to be: its name, its script (`sitl.leader_script`), where it lies at first, when it departs (None: when it is told), its receiver."""

    name: str
    script: str
    start: tuple[float, float, float] = (0.0, 0.0, 0.0)  # north and east of home in m, heading in rad
    depart_s: float | None = None
    gnss: str = "standalone"


def waters_of(others: Sequence[OtherBoat], home: HomeConfig, seed: int, common_share: float = 0.0) -> Waters:
    """The boats, each with errors of its own from the seed and its name. Raises ConfigError for a script, grade or share that does not exist."""
    common = CommonWander(common_share, seed) if common_share > 0.0 else None
    boats = []
    for other in others:
        boat = LeadBoat(other.name, home, script(other.script), start=other.start, gnss=other.gnss, seed=seed, common=common)
        if other.depart_s is not None:
            boat.depart(other.depart_s)
        boats.append(boat)
    return Waters(boats, common)


class Waters:
    """`advance(now_s)`: take the whole steps that have become due. `common`: the part of position errors that all receivers here share."""

    def __init__(self, boats: Sequence[LeadBoat], common: CommonWander | None = None) -> None:
        self.boats = tuple(boats)
        self.common = common
        self._steps = 0

    @property
    def wakes(self) -> tuple[Wake, ...]:
        return tuple(boat.wake for boat in self.boats)

    def advance(self, now_s: float) -> None:
        due = math.floor(now_s * STEP_HZ + 1e-6)
        while self._steps < due:
            self._steps += 1
            for boat in self.boats:
                boat.step()
