"""The table of what is expected: `expected.toml`, read and checked."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("expected.toml")
NOTHING = "-"  # nothing is said, or no distance is promised


@dataclass(frozen=True, slots=True)
class VesselRow:
    """A vessel: its weather, what its faults are about, its speed and gap in Follow, how long it has sailed when a
    fault begins, s, and the greatest distance from its place or line in each mode without a fault, m."""

    name: str
    title: str
    wind: str
    gnss: str
    thruster: str
    bridge: str
    drifts: bool  # it keeps inside a watch circle
    leader_mps: float
    circle_m: float
    warm_s: float
    reach_m: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Expected:
    """What one cell expects.

    `after`: the mode afterwards, "same", or "neutral": the same mode without thrust. `says`: regular expression that
    the name of an event matches in full; NOTHING for none. `hears`: the same of the text, as ground stations hear it,
    for what a log cannot hold. `knowable_s`: from the onset, or from when the boat is outside; it is said a second
    later at most. `far`: greatest distance, as a multiple of the vessel's `reach_m`; 0 where none is promised. `none`:
    why the fault does not exist here. `red`: why the cell fails.
    """

    after: str = "same"
    says: str = NOTHING
    hears: str = ""
    knowable_s: float = 0.0
    far: float = 1.0
    none: str = ""
    red: str = ""


@dataclass(frozen=True, slots=True)
class FaultRow:
    """One fault. `sitl`: faults of the simulation that begin; `deed`: what somebody does instead (`deeds.py`).
    `over_s`: when it ends, after its onset; 0: never. `watch_s`: how long it is watched. `rules`: what is expected, the
    later ones over the earlier."""

    name: str
    title: str
    group: str
    text: str
    sitl: tuple[str, ...]
    deed: str
    over_s: float
    watch_s: float
    rules: tuple[Mapping[str, Any], ...]

    def expected(self, mode: str, group: str, vessel: str) -> Expected:
        """What is expected in this mode, of this group of modes, on this vessel."""
        found = Expected()
        for rule in self.rules:
            modes, vessels = rule.get("modes", (mode,)), rule.get("vessels", (vessel,))
            if vessel in vessels and (mode in modes or group in modes):
                found = replace(found, **{key: rule[key] for key in rule if key not in ("modes", "vessels")})
        return found


@dataclass(frozen=True, slots=True)
class Table:
    """`modes`: the group of each mode ("sticks" or "self"). `absent`: why a vessel does not have a mode. `open_modes`,
    `open_vessels`: those of which nothing is expected yet."""

    modes: Mapping[str, str]
    vessels: tuple[VesselRow, ...]
    faults: tuple[FaultRow, ...]
    absent: Mapping[tuple[str, str], str]
    open_modes: tuple[str, ...] = ()
    open_vessels: tuple[str, ...] = ()

    def expected(self, vessel: str, mode: str, fault: FaultRow) -> Expected:
        """What is expected of one cell."""
        if (vessel, mode) in self.absent:
            return Expected(none=self.absent[vessel, mode])
        return fault.expected(mode, self.modes[mode], vessel)

    def vessel(self, name: str) -> VesselRow:
        """The row of a vessel. Raises KeyError."""
        return next((row for row in self.vessels if row.name == name), None) or _missing("vessel", name)

    def fault(self, name: str) -> FaultRow:
        """The row of a fault. Raises KeyError."""
        return next((row for row in self.faults if row.name == name), None) or _missing("fault", name)

    def stages(self) -> Iterator[tuple[str, str]]:
        """(vessel, mode) of all that exist."""
        for vessel in self.vessels:
            for mode in self.modes:
                if (vessel.name, mode) not in self.absent:
                    yield vessel.name, mode

    def faults_in(self, vessel: str, mode: str) -> Sequence[FaultRow]:
        """The faults that exist there."""
        return [fault for fault in self.faults if not self.expected(vessel, mode, fault).none]


def _missing(what: str, name: str) -> Any:
    raise KeyError(f"no {what} named '{name}' in {FILE.name}")


def load(path: Path = FILE) -> Table:
    """The table. Raises KeyError or TypeError for a row with a missing or an unknown key."""
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    return Table(
        modes=data["modes"],
        vessels=tuple(VesselRow(**row) for row in data["vessel"]),
        faults=tuple(_fault(row) for row in data["fault"]),
        absent={(row["vessel"], row["mode"]): row["why"] for row in data["absent"]},
        open_modes=tuple(data["open_modes"]),
        open_vessels=tuple(data["open_vessels"]),
    )


def _fault(row: Mapping[str, Any]) -> FaultRow:
    return FaultRow(
        name=row["name"],
        title=row["title"],
        group=row["group"],
        text=row["text"],
        sitl=tuple(row.get("sitl", ())),
        deed=row.get("deed", ""),
        over_s=row.get("over_s", 0.0),
        watch_s=row["watch_s"],
        rules=tuple(row["expect"]),
    )
