"""A whole vessel on a state directory, whose time is the test's."""

from __future__ import annotations

from pathlib import Path

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.io.mavlink.wire.links import MemoryLink
from companion.record.disk import REAL_DISK, Disk
from companion.record.state_file import StateFile
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions


class BoatAfloat:
    """What `tests.protocol.desk.Desk` needs of a rig. `beside`: writers and worker run in threads of their own."""

    def __init__(
        self,
        state: Path,
        log_folder: Path | None = None,
        *,
        beside: bool = False,
        disk: Disk = REAL_DISK,
        place: tuple[float, float] = (0.0, 0.0),
        link: str = "memory:desk",
        vessel: str = "revolt",
    ) -> None:
        """`place`: where the boat begins, (north_m, east_m). `link`: the URL of its link."""
        config = load_vessel(vessel)
        self.world = World(config, WorldConditions(seed=3))
        self.world.set_state(*place)
        self.state = StateFile(state)
        self._clock = SimulatedClock(EPOCH_UNIX_NS)
        self._link = MemoryLink(link)
        around = Surroundings(
            self._clock, self.world, self.world, [self._link], self.state, log_folder, beside=beside, disk=disk
        )
        self.vessel = build(config, around)
        self._steps = 0

    @property
    def now_s(self) -> float:
        return self._clock.now_s()

    def step(self) -> None:
        self._clock.wait(self._steps * self.vessel.period_s, ())
        self.vessel.tick(self._clock.now_s())
        self._steps += 1

    def send(self, data: bytes) -> None:
        self._link.to_vessel(data)

    def receive(self) -> bytes:
        return self._link.from_vessel()

    def close(self) -> None:
        self.vessel.close()
        self.state.close()
