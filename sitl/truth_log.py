"""truth.csv and one file for each lead boat: what the boats really did, at the simulation's own time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

from companion.config.vessel import HomeConfig
from companion.core.geodesy import LocalFrame
from companion.core.tick import Tick
from sitl.lead_boat import LeadBoat
from sitl.world import World

_COLUMNS = [
    "t_s",
    "north_m",
    "east_m",
    "yaw_rad",
    "surge_mps",
    "sway_mps",
    "yaw_rate_radps",
    "wind_speed_mps",
    "wind_from_rad",
    "current_north_mps",
    "current_east_mps",
]
_CONTACT_COLUMNS = (
    "contact_n",
    "contact_gap_m",
    "contact_surge_mps",
    "contact_sway_mps",
)  # the speeds are those of the last touch
LEADER_COLUMNS = (
    "t_s",
    "north_m",
    "east_m",
    "yaw_rad",
    "speed_mps",
    "surge_mps",
    "yaw_rate_radps",
    "fix_north_m",
    "fix_east_m",
    "placed_north_m",
    "placed_east_m",
)


def truth_columns(thrusters: Sequence[str], retractable: Sequence[str], berth: bool) -> list[str]:
    """Header of truth.csv."""
    columns = [*_COLUMNS]
    for name in thrusters:
        columns += [f"{name}_force_n", f"{name}_azimuth_rad"]
    columns += [f"{name}_down" for name in retractable]
    return [*columns, *_CONTACT_COLUMNS] if berth else columns


class TruthLog:
    """Recorder that writes truth.csv, one row a tick."""

    def __init__(self, folder: Path, world: World, thrusters: tuple[str, ...]) -> None:
        self._world = world
        folder.mkdir(parents=True, exist_ok=True)
        self._file: TextIO = (folder / "truth.csv").open("w", encoding="utf-8", buffering=1)
        self._file.write(",".join(truth_columns(thrusters, tuple(world.truth.down), world.berth is not None)) + "\n")

    def record(self, tick: Tick) -> None:
        """Write a row; the tick itself is not used."""
        self.write()

    def write(self) -> None:
        """Write a row of the present truth."""
        t = self._world.truth
        row = (
            f"{t.t_s:.3f},{t.north_m:.5f},{t.east_m:.5f},{t.yaw_rad:.6f},{t.surge_mps:.5f},{t.sway_mps:.5f},{t.yaw_rate_radps:.6f}"
            f",{t.wind_speed_mps:.3f},{t.wind_from_rad:.4f},{t.current_north_mps:.4f},{t.current_east_mps:.4f}"
        )
        row += "".join(f",{force:.3f},{azimuth:.4f}" for force, azimuth in t.thrusters)
        row += "".join(f",{down:.3f}" for down in t.down.values())
        if (berth := self._world.berth) is not None:
            row += f",{berth.force_n:.3f},{berth.gap_m:.5f},{berth.touch_surge_mps:.5f},{berth.touch_sway_mps:.5f}"
        self._file.write(row + "\n")

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class LeaderTruthLog:
    """Recorder that writes the truth of a lead boat into a file with its name.

    Its time is the boat's own, at most one step (20 ms) before the tick's. `fix_…`: position by its receiver, moved on
    from the last fix; empty without one. `placed_…`: where the follower places it, in the plane of its own estimate;
    empty where it does not know.
    """

    def __init__(self, folder: Path, boat: LeadBoat, home: HomeConfig) -> None:
        self._boat, self._home = boat, LocalFrame(home.lat_deg, home.lon_deg)
        folder.mkdir(parents=True, exist_ok=True)
        self._file: TextIO = (folder / f"{boat.name}.csv").open("w", encoding="utf-8", buffering=1)
        self._file.write(",".join(LEADER_COLUMNS) + "\n")

    def record(self, tick: Tick) -> None:
        """Write a row, with where the tick has the leader."""
        leader = tick.status.leader
        self.write("," if leader is None else f"{leader.north_m:.4f},{leader.east_m:.4f}")

    def write(self, placed: str = ",") -> None:
        """Write a row of the present truth."""
        hull = self._boat.hull
        speed_mps = math.hypot(hull.north_mps, hull.east_mps)
        self._file.write(
            f"{self._boat.t_s:.3f},{hull.north_m:.5f},{hull.east_m:.5f},{hull.yaw_rad:.6f},{speed_mps:.5f},{hull.surge_mps:.5f},{hull.yaw_rate_radps:.6f},{self._fix()},{placed}\n"
        )

    def _fix(self) -> str:
        fix = self._boat.fix
        if fix is None or fix.lat_deg is None or fix.lon_deg is None:
            return ","
        north_m, east_m = self._home.to_ned(fix.lat_deg, fix.lon_deg)
        age_s = self._boat.t_s - fix.t_s
        return f"{north_m + fix.north_mps * age_s:.4f},{east_m + fix.east_mps * age_s:.4f}"

    def close(self) -> None:
        """Close the file."""
        self._file.close()
