"""What a boat did in a run: by the plant's truth, with mode and arming by the boat's own log, beside what lay around
it."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.config.vessel import VesselConfig
from sitl.obstacles import Obstacles
from sitl.scenarios.measure import EventRow, read_events
from sitl.scenarios.rig import Rig
from sitl.traffic import ScriptedVessel

Floats = NDArray[np.float64]
Corners = tuple[tuple[float, float], ...]

_CONTACT = ("contact_surge_mps", "contact_sway_mps")


@dataclass(frozen=True, slots=True)
class Leader:
    """A lead boat: a value a row of its file."""

    t_s: Floats
    north_m: Floats
    east_m: Floats


@dataclass(frozen=True, slots=True)
class Voyage:
    """A run. Arrays have a value a row of truth.csv.

    `forces_n`: a column a thruster. `contact_mps`: speed of the last touch of the berth, NaN before it and without a
    berth. `desired_m`: (north, east) that the boat steers for, NaN without. `fences`: (since when, corners) of the
    areas that it was told to stay in. `ordered_s`: when it was ordered something for the last time. `runaways`: whether
    each thruster has a fault by which it runs by itself.
    """

    config: VesselConfig
    parameters: Mapping[str, float]
    runaways: Sequence[bool]
    t_s: Floats
    north_m: Floats
    east_m: Floats
    yaw_rad: Floats
    forces_n: Floats
    contact_mps: Floats
    mode: NDArray[np.str_]
    armed: NDArray[np.bool_]
    desired_m: Floats
    events: Sequence[EventRow]
    fences: Sequence[tuple[float, Corners]]
    ordered_s: float
    obstacles: Obstacles
    traffic: Sequence[ScriptedVessel]
    leaders: Sequence[Leader]

    @property
    def period_s(self) -> float:
        """Mean time between two rows."""
        return float(self.t_s[-1] - self.t_s[0]) / max(1, len(self.t_s) - 1)

    def stretches(self, *modes: str) -> list[tuple[int, int]]:
        """Rows (first, after the last) of each stretch armed in one of these modes."""
        inside = np.concatenate([[False], np.isin(self.mode, modes) & self.armed, [False]])
        edges = np.flatnonzero(inside[1:] != inside[:-1])
        return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def read_voyage(folder: Path, rig: Rig, fences: Sequence[tuple[float, Corners]], ordered_s: float) -> Voyage | None:
    """The run whose log is in `folder`; None where it was over before its first second."""
    truth = _numbers(folder / "truth.csv")
    if len(truth["t_s"]) < rig.config.control_rate_hz:
        return None
    sea = rig.world.shared_sea
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    mode, armed, desired = _states(folder / "ticks.csv", truth["t_s"])
    nothing = np.full(len(truth["t_s"]), math.nan)
    return Voyage(
        config=rig.config,
        parameters=manifest["parameters"],
        runaways=[rig.world.faults.planned(f"thruster_{one.name}_runaway") for one in rig.config.thrusters],
        t_s=truth["t_s"],
        north_m=truth["north_m"],
        east_m=truth["east_m"],
        yaw_rad=np.unwrap(truth["yaw_rad"]),
        forces_n=np.column_stack([truth[f"{thruster.name}_force_n"] for thruster in rig.config.thrusters]),
        contact_mps=np.hypot(*(truth.get(name, nothing) for name in _CONTACT)),
        mode=mode,
        armed=armed,
        desired_m=desired,
        events=read_events(folder),
        fences=tuple(fences),
        ordered_s=ordered_s,
        obstacles=rig.world.obstacles,
        traffic=tuple(rig.world.traffic.vessels),
        leaders=[_leader(folder / f"{boat.name}.csv") for boat in (() if sea is None else sea.boats)],
    )


def _numbers(path: Path, columns: int | None = None) -> dict[str, Floats]:
    """Columns of a file of numbers, by name; `columns`: only the first ones."""
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")[:columns]
        rows = np.loadtxt(file, delimiter=",", usecols=range(len(names)), ndmin=2)
    return {name: rows[:, i] for i, name in enumerate(names)} if len(rows) else {name: np.zeros(0) for name in names}


def _leader(path: Path) -> Leader:
    rows = _numbers(path, 3)
    return Leader(rows["t_s"], rows["north_m"], rows["east_m"])


def _states(path: Path, t_s: Floats) -> tuple[NDArray[np.str_], NDArray[np.bool_], Floats]:
    """Mode, arming and desired position at each time, as of the last tick before it."""
    with path.open(encoding="utf-8") as file:
        rows: list[dict[str, Any]] = [row for row in csv.DictReader(file) if row["mode"]]
    ticks = np.array([float(row["t_s"]) for row in rows])
    at = np.clip(np.searchsorted(ticks, t_s + 1e-3, side="right") - 1, 0, len(rows) - 1)
    desired = np.array([[_number(row["desired_north_m"]), _number(row["desired_east_m"])] for row in rows])
    modes = np.array([row["mode"] for row in rows])
    return modes[at], np.array([row["armed"] == "1" for row in rows])[at], desired[at]


def _number(text: str | None) -> float:
    return float(text) if text else math.nan
