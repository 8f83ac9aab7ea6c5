"""A lead boat in company with one or more followers: its module's packets reach each of them between its ticks, at the time at which they arrive."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from sitl.lead_boat import LeadBoat
from sitl.leader_radio import LeaderModule, RadioPath
from sitl.scenarios.rig import Rig
from sitl.scenarios.scenario import Settings, number
from sitl.scenarios.station import Station
from sitl.waters import Waters

FOLLOW = 0x08040000
_JITTER_SHARE = 0.3  # of the latency


class Escort(Station):
    """The ground station of one follower in company: a step of it is a step of all."""

    def __init__(self, rig: Rig, company: Company, vessel: int) -> None:
        super().__init__(rig, vessel=vessel)
        self._company = company

    def step(self) -> None:
        self._company.step()

    def tick(self) -> None:
        """One tick of this follower alone."""
        super().step()

    def _take(self, message: Any) -> None:
        super()._take(message)
        self._company.heard(self, message)


class Company:
    """The lead boat, its module, and for each follower a path of its packets and an escort. `step()` all in turn, which keeps them at one time.

    The boat is the first one of the rigs' waters; the followers' system ids count from 1. Settings: kind, gnss, latency (s, mean), loss (share).
    """

    def __init__(self, rigs: Sequence[Rig], settings: Settings) -> None:
        waters = rigs[0].world.waters
        if waters is None:
            raise ValueError("no other boats in the conditions")
        self._waters: Waters = waters
        self.boat: LeadBoat = waters.boats[0]
        seed, latency_s = rigs[0].world.seed, number(settings, "latency")
        self.module = LeaderModule(self.boat, kind=settings["kind"], gnss=settings["gnss"], seed=seed)
        self.paths = tuple(
            RadioPath(f"follower {i}", latency_s=latency_s, jitter_s=_JITTER_SHARE * latency_s, loss=number(settings, "loss"), seed=seed)
            for i in range(len(rigs))
        )
        self.escorts = tuple(Escort(rig, self, i + 1) for i, rig in enumerate(rigs))

    @property
    def now_s(self) -> float:
        return self.escorts[0].rig.now_s

    def step(self) -> None:
        """One tick of every follower, and before it what reaches it until then."""
        next_s = self.now_s + 1.0 / self.escorts[0].rig.config.control_rate_hz
        self._speak(next_s)
        for escort, path in zip(self.escorts, self.paths, strict=True):
            for at_s, packet in path.arrived(next_s):
                escort.rig.hear(packet, at_s)
            escort.tick()

    def heard(self, escort: Escort, message: Any) -> None:
        """A message of a follower, which reaches the module too, and what that answers."""
        if message.get_type() != "TIMESYNC":
            return
        path = self.paths[self.escorts.index(escort)]
        at_s = path.arrival_s(self.now_s)
        if at_s is not None and (answer := self.module.answer(message, at_s)) is not None:
            path.take(at_s, answer)

    def sail(self, duration_s: float) -> None:
        end_s = self.now_s + duration_s
        while self.now_s < end_s - 1e-9:
            self.step()

    def follow(self) -> None:
        """All ready, armed and in Follow; the lead boat is still at rest."""
        for escort in self.escorts:
            if self.module.kind == "vehicle":
                escort.set_parameter("FOLL_SYSID", self.module.system)
            escort.ready()
            escort.set_mode(FOLLOW)
            escort.arm()

    def lose(self, what: str, duration_s: float) -> None:
        """Sail through an outage from now on: of the "link", of the fixes of the "leader", or of those of the followers ("own"). Its end is when
        this returns."""
        if what == "link":
            for path in self.paths:
                path.cuts.append((self.now_s, duration_s))
        elif what == "own":
            for escort in self.escorts:
                escort.rig.world.add_fault("gnss_lost", duration_s)
        else:
            self.boat.faults.add("gnss_lost")
        self.sail(duration_s)
        self.boat.faults.discard("gnss_lost")

    def _speak(self, until_s: float) -> None:
        while (sent_s := self.module.due_s) <= until_s:
            self._waters.advance(sent_s)
            for packet in self.module.speak():
                for path in self.paths:
                    path.take(sent_s, packet)
