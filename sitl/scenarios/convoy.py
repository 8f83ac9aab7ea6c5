"""A lead boat with one or more followers: the packets of its module reach each follower at their time of arrival."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from sitl.lead_boat import LeadBoat
from sitl.leader_radio import EmulatedLeaderModule, RadioPath
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Rig
from sitl.scenarios.scenario import Settings, number
from sitl.shared_sea import SharedSea

FOLLOW = 0x08040000
_JITTER_SHARE = 0.3  # share of the latency


class FollowerGroundStation(GroundStation):
    """The ground station of one follower. Its `step` steps the whole convoy."""

    hears = frozenset({mavlink.MAVLINK_MSG_ID_TIMESYNC})

    def __init__(self, rig: Rig, convoy: Convoy, vessel: int) -> None:
        super().__init__(rig, vessel=vessel)
        self._convoy = convoy

    def step(self) -> None:
        """One tick of every follower."""
        self._convoy.step()

    def tick(self) -> None:
        """One tick of this follower alone."""
        super().step()

    def _take(self, message: Any) -> None:
        super()._take(message)
        self._convoy.heard(self, message)


class Convoy:
    """The lead boat, its module, and for each follower a radio path and a ground station. `step()` ticks all, which
    keeps their times equal.

    The lead boat is the first of the rigs' shared sea. The followers' system ids count from 1. Settings: kind, gnss,
    latency (mean, in s), loss (share).
    """

    def __init__(self, rigs: Sequence[Rig], settings: Settings) -> None:
        shared_sea = rigs[0].world.shared_sea
        if shared_sea is None:
            raise ValueError("the conditions have no lead boat")
        self._shared_sea: SharedSea = shared_sea
        self.boat: LeadBoat = shared_sea.boats[0]
        seed, latency_s = rigs[0].world.seed, number(settings, "latency")
        self.module = EmulatedLeaderModule(
            self.boat,
            kind=settings["kind"],
            gnss=settings["gnss"],
            moving_base=bool(settings.get("base")),
            seed=seed,
        )
        self.paths = tuple(
            RadioPath(
                f"follower {i}",
                latency_s=latency_s,
                jitter_s=_JITTER_SHARE * latency_s,
                loss=number(settings, "loss"),
                seed=seed,
            )
            for i in range(len(rigs))
        )
        self.ground_stations = tuple(FollowerGroundStation(rig, self, i + 1) for i, rig in enumerate(rigs))

    @property
    def now_s(self) -> float:
        """Time of the followers."""
        return self.ground_stations[0].rig.now_s

    def step(self) -> None:
        """One tick of every follower; before it, the packets that arrive until then."""
        next_s = self.now_s + 1.0 / self.ground_stations[0].rig.config.control_rate_hz
        self._speak(next_s)
        for ground_station, path in zip(self.ground_stations, self.paths, strict=True):
            for at_s, packet in path.arrived(next_s):
                ground_station.rig.deliver(packet, at_s)
            ground_station.tick()

    def heard(self, ground_station: FollowerGroundStation, message: Any) -> None:
        """A message from a follower: it reaches the module too, whose answer is sent back."""
        if message.get_type() != "TIMESYNC":
            return
        path = self.paths[self.ground_stations.index(ground_station)]
        at_s = path.arrival_s(self.now_s)
        if at_s is not None and (answer := self.module.answer(message, at_s)) is not None:
            path.take(at_s, answer)

    def sail(self, duration_s: float) -> None:
        """Step for `duration_s`."""
        end_s = self.now_s + duration_s
        while self.now_s < end_s - 1e-9:
            self.step()

    def follow(self) -> None:
        """Make all followers ready, in Follow and armed. The lead boat stays at rest."""
        for ground_station in self.ground_stations:
            if self.module.kind == "vehicle":
                ground_station.set_parameter("FOLL_SYSID", self.module.system)
            ground_station.ready()
            ground_station.set_mode(FOLLOW)
            ground_station.arm()

    def lose(self, what: str, duration_s: float) -> None:
        """Step through an outage from now on: of the "link", of the receiver of the "leader", or of the followers' own
        ("own"). It is over when this returns."""
        if what == "link":
            for path in self.paths:
                path.cuts.append((self.now_s, duration_s))
        elif what == "own":
            for ground_station in self.ground_stations:
                ground_station.rig.world.add_fault("gnss_lost", duration_s)
        else:
            self.boat.faults.add("gnss_lost")
        self.sail(duration_s)
        self.boat.faults.discard("gnss_lost")

    def _speak(self, until_s: float) -> None:
        while (sent_s := self.module.due_s) <= until_s:
            self._shared_sea.advance(sent_s)
            for packet in self.module.speak():
                for path in self.paths:
                    path.take(sent_s, packet)
