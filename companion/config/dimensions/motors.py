"""Thrust of a thruster by what people know of it: its motor, its largest thrust, or its power and propeller."""

from __future__ import annotations

import math
import re
import tomllib
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib import resources
from itertools import pairwise
from typing import Any

from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import WATER_KGPM3, above_zero
from companion.config.kinds import Problem

_LBF_N = 4.44822
_POUNDS = re.compile(r"([\d.]*\d)\s*(?:lb|lbs|lbf)")
_TROLLING = re.compile(r"trolling[ _-]*(\d+(?:\.\d+)?) *lb")
_TROLLING_ASTERN, _TROLLING_PROPELLER_M = 0.75, 0.28
_ASTERN = 0.7  # of the thrust ahead: an open propeller that was made for ahead (Carlton 2012, ch. 6)
_EFFICIENCY = 0.45  # of motor, shaft and propeller at the bollard, against an ideal actuator disc
_BY_VOLTAGE = 1.2  # exponent of voltage beyond a motor's rows: T200's from 12 to 20 V
_RATE_1PS = 2.0  # full thrust in half a second


@dataclass(frozen=True, slots=True)
class Motor:
    """A row of the table: `thrust` as (V, ahead N, astern N) by rising voltage."""

    title: str
    thrust: tuple[tuple[float, float, float], ...]
    propeller_m: float
    source: str

    def at(self, voltage_v: float | None) -> tuple[float, float]:
        """(ahead, astern) in N at that voltage; None: at the highest one in the table."""
        rows = self.thrust
        if voltage_v is None or voltage_v == rows[-1][0]:
            return rows[-1][1:]
        if not rows[0][0] < voltage_v < rows[-1][0]:
            volts, ahead_n, astern_n = rows[0] if voltage_v <= rows[0][0] else rows[-1]
            scale = (voltage_v / volts) ** _BY_VOLTAGE
            return scale * ahead_n, scale * astern_n
        i = bisect_left([row[0] for row in rows], voltage_v)
        share = (voltage_v - rows[i - 1][0]) / (rows[i][0] - rows[i - 1][0])
        return (
            rows[i - 1][1] + share * (rows[i][1] - rows[i - 1][1]),
            rows[i - 1][2] + share * (rows[i][2] - rows[i - 1][2]),
        )


@cache
def table() -> Mapping[str, Motor]:
    """All motors by their key."""
    text = resources.files("companion.config.dimensions").joinpath("motors.toml").read_text(encoding="utf-8")
    return {
        key: Motor(
            row["title"],
            tuple((volts, ahead, astern) for volts, ahead, astern in row["thrust"]),
            row["propeller_m"],
            row["source"],
        )
        for key, row in tomllib.loads(text).items()
    }


def find(name: str) -> Motor | None:
    """The motor of that name, in any case and spacing; `trolling 55 lb` for a trolling motor by its thrust. None if
    there is none."""
    plain = name.lower().replace("blue robotics", "").replace("torqeedo", "")
    if found := _TROLLING.fullmatch(plain.strip()):
        ahead_n = float(found[1]) * _LBF_N
        return Motor(
            f"Trolling motor, {found[1]} lb",
            ((12.0, ahead_n, _TROLLING_ASTERN * ahead_n),),
            _TROLLING_PROPELLER_M,
            "rating in pound-force; astern and diameter of common trolling motors",
        )
    return table().get(re.sub(r"[^a-z0-9]", "", plain.replace(".0", "")))


def disc_thrust_n(power_w: float, propeller_m: float) -> float:
    """Bollard thrust by momentum theory: (2 ρ A)^(1/3) (η P)^(2/3), with η of motor and propeller against an ideal
    disc."""
    area_m2 = 0.25 * math.pi * propeller_m**2
    return math.cbrt(2.0 * WATER_KGPM3 * area_m2) * math.pow(_EFFICIENCY * power_w, 2.0 / 3.0)


def completed(
    rows: Sequence[Mapping[str, Any]],
) -> tuple[list[dict[str, Any]], list[Figure], list[Problem]]:
    """Raw `[[thruster]]` rows with their thrust filled in, the figures that were filled in, and what is wrong with the
    keys that this needs. Keys given by hand stay."""
    found: list[dict[str, Any]] = []
    figures: list[Figure] = []
    problems: list[Problem] = []
    for i, row in enumerate(rows):
        known, problem = _known(row)
        if problem is not None:
            problems.append((("thruster", i, problem[0]), problem[1]))
        name = str(row.get("name", i + 1))
        filled = {} if known is None else {key: value for key, value in known.values.items() if key not in row}
        found.append({**row, **filled})
        if known is not None:
            figures += [
                Figure(f"thruster.{name}.{key}", filled[key], known.factor, known.formula, known.source)
                for key in filled
            ]
    return found, figures, problems


@dataclass(frozen=True, slots=True)
class _Known:
    values: Mapping[str, float]
    factor: float
    formula: str
    source: str


def _known(row: Mapping[str, Any]) -> tuple[_Known | None, tuple[str, str] | None]:
    """What follows from a row, or (key, text) of what is wrong."""
    if row.get("kind") == "jet":
        return None, None
    numbers = _numbers(row)
    if "motor" in row:
        motor = find(str(row["motor"]))
        if motor is None:
            return None, ("motor", unknown_motor(str(row["motor"])))
        if "voltage_v" in row and not above_zero(row["voltage_v"]):
            return None, ("voltage_v", f"should be a number above 0, in V, not {row['voltage_v']!r}")
        ahead_n, astern_n = motor.at(numbers.get("voltage_v"))
        values = {**_thrust(ahead_n, astern_n, numbers), "propeller_m": motor.propeller_m}
        return _Known(values, 1.3, f"bollard thrust of {motor.title}", motor.source), None
    if "max_n" in numbers:
        astern_n = abs(numbers.get("min_n", -numbers.get("astern_n", _ASTERN * numbers["max_n"])))
        values = _thrust(numbers["max_n"], astern_n or _ASTERN * numbers["max_n"], numbers)
        return _Known(values, 1.5, "max_n; 0.7 of it astern", "Carlton, Marine Propellers (2012), 6"), None
    if "power_w" in numbers and numbers["power_w"] > 0.0 and numbers.get("propeller_m", 0.0) > 0.0:
        ahead_n = disc_thrust_n(numbers["power_w"], numbers["propeller_m"])
        values = _thrust(ahead_n, _ASTERN * ahead_n, numbers)
        return _Known(values, 1.6, "(2 ρ A)^(1/3) (0.45 P)^(2/3)", "momentum theory of an actuator disc"), None
    if row.get("max_n") is not None:
        pounds = _POUNDS.fullmatch(str(row["max_n"]).strip().lower())
        meant = f"; {pounds[1]} lb are {float(pounds[1]) * _LBF_N:.0f} N" if pounds else ""
        return None, ("max_n", f"should be a number, in N, not {row['max_n']!r}{meant}")
    text = 'is missing: largest thrust ahead, in N; or give motor = "T200", or power_w with propeller_m'
    return None, ("max_n", text)


def _numbers(row: Mapping[str, Any]) -> dict[str, float]:
    """The numbers of a row that thrust is made of."""
    keys = ("voltage_v", "power_w", "propeller_m", "max_n", "min_n", "ahead_n", "astern_n")
    numbers = {
        key: float(row[key])
        for key in keys
        if isinstance(row.get(key), (int, float)) and not isinstance(row[key], bool)
    }
    if "ahead_n" in numbers:
        numbers.setdefault("max_n", numbers["ahead_n"])
    return numbers


def _thrust(ahead_n: float, astern_n: float, given: Mapping[str, float]) -> dict[str, float]:
    """The keys of thrust, consistent with what was given by hand."""
    ahead_n = round(ahead_n, 1)
    max_n = given.get("max_n", given.get("ahead_n", ahead_n))
    min_n = given.get("min_n", -given.get("astern_n", round(astern_n, 1)))
    return {
        "max_n": max_n,
        "min_n": min_n,
        "ahead_n": max(ahead_n, max_n) if "max_n" in given else max_n,
        "astern_n": max(round(astern_n, 1), -min_n) if "min_n" in given else -min_n,
        "force_rate_nps": round(_RATE_1PS * max_n, 1),
    }


def unknown_motor(name: str) -> str:
    """What to say of a motor that is not in the table."""
    near = get_close_matches(name.lower(), table(), n=1, cutoff=0.5)
    hint = f", did you mean '{near[0]}'" if near else ""
    return f"no motor '{name}' in the table{hint}. It has {', '.join(table())} and 'trolling 55 lb'; or give max_n"


def rising(motor: Motor) -> bool:
    """Whether its rows rise in voltage and thrust, as `at` needs."""
    return all(low < high for one, other in pairwise(motor.thrust) for low, high in zip(one, other, strict=True))
