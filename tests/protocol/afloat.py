"""A whole vessel on real links in a thread of this process: for clients that are not ours, on a simulated boat that the
test itself sets up and moves."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from companion.app import Surroundings, build
from companion.clock import PacedClock
from companion.config.vessel import VesselConfig
from companion.io.mavlink.wire.links import open_links
from companion.loop import run
from companion.record.state_file import StateFile
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions


class Afloat:
    """`vessel` and its `world`, whose truth is `real`; the controller knows `config`. State and log are in `folder`."""

    def __init__(
        self,
        folder: Path,
        config: VesselConfig,
        links: Sequence[str],
        *,
        real: VesselConfig | None = None,
        speed: float = 10.0,
        **conditions: Any,
    ) -> None:
        self.folder, self.config, self.links = folder, config, links
        self.real = real or config
        self.speed = speed
        self.conditions = WorldConditions(**conditions)
        self._stop = threading.Event()

    def __enter__(self) -> Afloat:
        self.world = World(self.real, self.conditions)
        self._state = StateFile(self.folder / "state")
        clock = PacedClock(self.speed, EPOCH_UNIX_NS)
        patience = max(1.0, self.speed)
        around = Surroundings(
            clock=clock,
            opener=self.world,
            world=self.world,
            links=open_links(self.links, patience),
            state=self._state,
            log_folder=self.folder / f"log-{len(list(self.folder.glob('log-*')))}",
            patience=patience,
        )
        self.vessel = build(self.config, around)
        self._stop.clear()
        self._thread = threading.Thread(target=run, args=(self.vessel, clock, self._stop.is_set), name="afloat")
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        self.vessel.close()
        self._state.close()
