"""fault-matrix.md: what every fault does in every mode on every vessel, as expected and as seen."""

from __future__ import annotations

import html
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.generate.markdown import cell, code, number, page, section, table
from docs.generate.source import ROOT
from sitl.fault_matrix.cell import Observed, judge, limit_of, observed_of
from sitl.fault_matrix.table import NOTHING, Expected, FaultRow, Table, VesselRow, load

FOLDER = ROOT / "docs" / "results" / "matrix"
_INTRODUCTION = """Every fault, in every mode, on every bundled vessel, in lockstep with the simulated boat. A cell is
one run: the boat has sailed in its mode for 20 s, or a minute or more where it has to learn its gyro's bias by a
compass, when the fault begins. It is green when all this holds:

* the boat ends in the mode that is expected;
* the boat sent the expected text within 1 s of the moment at which it could know, and the ground station received it;
* the boat stayed within the stated distance of its place or line;
* its log is complete.

Point at a cell to see what happened. `sitl/fault_matrix/expected.toml` is the table of what is expected; the tests read
the same file. `make matrix` runs all cells again."""
_LEGEND = (
    ("ok", "as expected"),
    ("red", "not as expected"),
    ("none", "does not exist there"),
    ("open", "not run yet"),
)
_SIGNS = {"ok": "✓", "red": "✗", "none": "–", "open": "?"}

Seen = Mapping[tuple[str, str, str], Observed]


def fault_matrix(folder: Path = FOLDER) -> str:
    """The page."""
    expected, (seen, origins) = load(), _read(folder)
    legend = "  ".join(f"{_mark(kind, text)} {text}" for kind, text in _LEGEND)
    return page(
        "Fault matrix",
        _INTRODUCTION,
        f"{legend}\n\n{_count(expected, seen)} {' '.join(origins)}".rstrip(),
        *_open(expected),
        *(_vessel(expected, vessel, seen) for vessel in expected.vessels),
        section(2, "Cells that are not as expected", _reds(expected, seen)),
        section(2, "What is expected", _expectations(expected)),
        section(2, "What does not exist", _absences(expected)),
    )


def _open(table_: Table) -> list[str]:
    names = (*table_.open_modes, *table_.open_vessels)
    return [f"Nothing is expected yet of {', '.join(names)}."] if names else []


def _read(folder: Path) -> tuple[Seen, list[str]]:
    """What was seen, and when and at which commits."""
    seen: dict[tuple[str, str, str], Observed] = {}
    runs: set[tuple[str, str]] = set()
    for file in sorted(folder.glob("*.json")):
        data: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        runs.add((data["date"], data["commit"]))
        for row in data["cells"]:
            one = observed_of(row)
            seen[one.vessel, one.mode, one.fault] = one
    return seen, [f"Run on {date} at commit {code(commit)}." for date, commit in sorted(runs)]


def _kind(table_: Table, seen: Seen, vessel: VesselRow, mode: str, fault: FaultRow) -> tuple[str, str]:
    """Colour of a cell, and what happened."""
    wanted = table_.expected(vessel.name, mode, fault)
    if wanted.none:
        return "none", wanted.none
    one = seen.get((vessel.name, mode, fault.name))
    if one is None:
        return "open", "not run yet"
    problems = judge(table_, one)
    said = one.said(wanted)
    limit_m = limit_of(vessel, mode, wanted)
    parts = [
        one.after,
        "" if said is None else f"after {number(said[0])} s: {said[1]}",
        "" if one.off_m is None else f"{number(one.off_m)} m" + ("" if limit_m is None else f" of {number(limit_m)} m"),
        "; ".join(problems),
    ]
    return ("red" if problems else "ok"), ". ".join(part for part in parts if part)


def _mark(kind: str, title: str) -> str:
    return f'<span class="fault-{kind}" title="{html.escape(cell(title), quote=True)}">{_SIGNS[kind]}</span>'


def _vessel(table_: Table, vessel: VesselRow, seen: Seen) -> str:
    modes = [mode for mode in table_.modes if (vessel.name, mode) not in table_.absent]
    rows = [
        (fault.title, *(_mark(*_kind(table_, seen, vessel, mode, fault)) for mode in modes)) for fault in table_.faults
    ]
    weather = f"Wind {vessel.wind or '0'} m/s; receivers: {vessel.gnss}. The thruster is {code(vessel.thruster)}."
    return section(2, vessel.title, weather, table(("fault", *modes), rows))


def _count(table_: Table, seen: Seen) -> str:
    kinds = [
        _kind(table_, seen, vessel, mode, fault)[0]
        for vessel in table_.vessels
        for mode in table_.modes
        for fault in table_.faults
    ]
    words = ", ".join(f"{kinds.count(kind)} {text}" for kind, text in _LEGEND)
    return f"Of {len(kinds)} cells: {words}."


def _reds(table_: Table, seen: Seen) -> str:
    rows = []
    for one in seen.values():
        if problems := judge(table_, one):
            wanted = table_.expected(one.vessel, one.mode, table_.fault(one.fault))
            place = table_.vessel(one.vessel).title, one.mode, table_.fault(one.fault).title
            rows.append((*place, "; ".join(problems), wanted.red or "not known"))
    return table(("vessel", "mode", "fault", "what is wrong", "why"), rows) or "None."


def _expectations(table_: Table) -> str:
    parts = []
    for group in dict.fromkeys(fault.group for fault in table_.faults):
        rows = [row for fault in table_.faults if fault.group == group for row in _rules(table_, fault)]
        parts.append(section(3, group.capitalize(), table(("fault", "where", "afterwards", "said", "distance"), rows)))
    return "\n\n".join(part.strip("\n") for part in parts)


def _rules(table_: Table, fault: FaultRow) -> list[tuple[str, ...]]:
    """One row for all cells of a fault that expect the same."""
    same: dict[Expected, list[tuple[str, str]]] = {}
    for vessel in table_.vessels:
        for mode in table_.modes:
            wanted = table_.expected(vessel.name, mode, fault)
            if not wanted.none:
                same.setdefault(wanted, []).append((vessel.title, mode))
    rows = [
        (_where(table_, places), wanted.after, _said(wanted), f"× {number(wanted.far)}" if wanted.far else "any")
        for wanted, places in same.items()
    ]
    return [(f"{fault.title}: {fault.text}" if i == 0 else "", *row) for i, row in enumerate(rows)]


def _said(wanted: Expected) -> str:
    what = wanted.hears or ("" if wanted.says == NOTHING else wanted.says)
    return f"{code(what)} at {number(wanted.knowable_s)} s" if what else "nothing"


def _where(table_: Table, places: Sequence[tuple[str, str]]) -> str:
    """Modes, with the vessels where not all that have the mode are meant."""
    of_mode: dict[tuple[str, ...], list[str]] = {}
    for mode in table_.modes:
        vessels = tuple(vessel for vessel, one in places if one == mode)
        if vessels:
            having = [v.title for v in table_.vessels if (v.name, mode) not in table_.absent]
            of_mode.setdefault(() if len(vessels) == len(having) else vessels, []).append(mode)
    return "; ".join(
        ", ".join(modes) + (f" ({', '.join(vessels)})" if vessels else "") for vessels, modes in of_mode.items()
    )


def _absences(table_: Table) -> str:
    reasons: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for fault in table_.faults:
        for vessel in table_.vessels:
            for mode in table_.modes:
                wanted = table_.expected(vessel.name, mode, fault)
                if wanted.none and (vessel.name, mode) not in table_.absent:
                    reasons.setdefault((fault.title, wanted.none), []).append((vessel.title, mode))
    rows = [
        (f"{table_.vessel(vessel).title}, {mode}", "every fault", why) for (vessel, mode), why in table_.absent.items()
    ]
    rows += [(_where(table_, places), title, why) for (title, why), places in reasons.items()]
    return table(("where", "fault", "why"), rows)
