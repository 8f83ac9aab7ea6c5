"""A lead boat on the air: sends what its module, a ground station or a phone would, with losses, cuts and latency."""

from __future__ import annotations

import random
from typing import Any

from companion.core.readings import LeaderState, Wish

PHASE_S = 0.02  # of its messages against the ticks


class LeadBoat:
    """Starts `ahead_m` north of the origin and sails north. `on` False: the link is cut; `fix` False: no position;
    `wish` None: no module."""

    def __init__(
        self,
        boat: Any,
        rate_hz: float = 20.0,
        wish: Wish | None = Wish.NONE,
        system: int = 42,
        loss: float = 0.0,
        seed: int = 0,
    ) -> None:
        self.boat = boat
        self.interval_s = 1.0 / rate_hz
        self.wish, self.system, self.loss = wish, system, loss
        self.presses = 0
        self.on = self.fix = True
        self.ahead_m, self.speed_mps = 25.0, 0.5
        self.yaw_rad = 0.0
        self.latency_s = 0.0
        self.last_fix_s: float | None = None  # that was received
        self._draws = random.Random(seed)
        self._next_s = boat.now_s + PHASE_S

    def press(self, wish: Wish) -> None:
        """As the crew does; the next message tells of it."""
        self.wish, self.presses = wish, self.presses % 255 + 1

    def send(self, t_s: float) -> None:
        lat_deg, lon_deg = self.boat.point(self.ahead_m + self.speed_mps * t_s, 0.0)
        state = LeaderState(
            t_s,
            t_s + self.latency_s,
            f"mavlink:{self.system}",
            self.system,
            lat_deg if self.fix else None,
            lon_deg if self.fix else None,
            self.speed_mps,
            0.0,
            self.yaw_rad,
            0.0,
            1.0,
            self.wish,
            presses=self.presses,
        )
        self.boat.supervisor.leader_heard(state)
        if self.fix:
            self.last_fix_s = t_s

    def tick(self) -> None:
        """What arrives before the next tick of the boat, and that tick."""
        until_s = self.boat.now_s + 0.1
        while self._next_s + self.latency_s <= until_s:
            if self.on and self._draws.random() >= self.loss:
                self.send(self._next_s)
            self._next_s += self.interval_s
        self.boat.tick()

    def run(self, duration_s: float) -> None:
        for _ in range(round(duration_s * 10)):
            self.tick()
