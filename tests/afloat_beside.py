"""A whole vessel whose writers and worker run in threads of their own, as on a boat, while its time is the test's."""

from __future__ import annotations

from pathlib import Path

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.io.mavlink.wire.links import MemoryLink
from companion.record.disk import REAL_DISK, Disk
from companion.record.state_file import StateFile
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions


class BoatBeside:
    """What `tests.protocol.desk.Desk` needs of a rig. Its state and logs are below `folder`."""

    def __init__(self, folder: Path, disk: Disk = REAL_DISK, logs: bool = True) -> None:
        config = load_vessel("revolt")
        self.world = World(config, WorldConditions(seed=3))
        self.state = StateFile(folder / "state")
        self._clock = SimulatedClock(EPOCH_UNIX_NS)
        self._link = MemoryLink("memory:desk")
        log_folder = folder / "logs" / "run" if logs else None
        around = Surroundings(
            self._clock, self.world, self.world, [self._link], self.state, log_folder, beside=True, disk=disk
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
