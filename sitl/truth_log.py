"""truth.csv: what the plant really did, at the plant's own time."""

from __future__ import annotations

from pathlib import Path
from typing import TextIO

from companion.core.types import Tick
from sitl.world import World

_COLUMNS = (
    "t_s,north_m,east_m,yaw_rad,surge_mps,sway_mps,yaw_rate_radps,"
    "wind_speed_mps,wind_from_rad,current_north_mps,current_east_mps"
)
_CONTACT_COLUMNS = ",contact_n,contact_gap_m,contact_surge_mps,contact_sway_mps"  # the speeds: when the boat touched last


class TruthLog:
    """Recorder that writes the truth beside the ticks."""

    def __init__(self, folder: Path, world: World, thrusters: tuple[str, ...]) -> None:
        self._world = world
        folder.mkdir(parents=True, exist_ok=True)
        self._file: TextIO = (folder / "truth.csv").open("w", encoding="utf-8", buffering=1)
        columns = _COLUMNS + "".join(f",{name}_force_n,{name}_azimuth_rad" for name in thrusters)
        columns += "".join(f",{name}_down" for name in world.truth.down)
        self._file.write(columns + (_CONTACT_COLUMNS if world.berth is not None else "") + "\n")

    def record(self, tick: Tick) -> None:
        self.write()

    def write(self) -> None:
        """A row of now."""
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
        self._file.close()
