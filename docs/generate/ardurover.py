"""The part of results.md that sets today's figures beside those of ArduRover on the same water."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.generate.markdown import number, section, table
from docs.generate.source import ROOT

ROWS = ROOT / "docs" / "results" / "ardurover.toml"
_TEXT = """ArduRover 4.7-dev, tuned with effort, sailed the plants of this project through its lockstep physics
interface, in the same weather and with the same receivers, judged from the plant's own record. Its figures are of one
or two seeds; of a range the better end stands here. "Then" is this project on the day of the comparison, "now" the mean
of the runs of the tables below, with the worst of them in brackets. The ratio is above 1 where the boat is better than
ArduRover. ArduRover's variation of thrust is known from ratios, to about a tenth.

Hold of ÅBOAT keeps a heading, which ArduRover's boat did not. In the wind and current of seeds 500 to 515 the least
power of both motors that balances them at that heading is 2.40 % in the mean (0.49 to 5.67), by the model of the hull.
No controller that keeps the heading takes less, so the ratio of that row is at most 0.65. Bow to the weather, 0.78 % is
enough."""


def rows() -> Sequence[Mapping[str, Any]]:
    """The rows as the file has them."""
    found: list[dict[str, Any]] = tomllib.loads(ROWS.read_text(encoding="utf-8"))["row"]
    return found


def beside_ardurover(folder: Path) -> str:
    """The section, from the measured tables in that folder; empty while none of them is measured."""
    names = {row["table"] for row in rows()}
    measured = {name: _runs(folder / f"{name}.json") for name in names if (folder / f"{name}.json").is_file()}
    known = [(row, measured.get(row["table"], {}).get(row["row"])) for row in rows()]
    shown = [_row(row, runs) for row, runs in known if runs]
    headers = ("task", "figure", "ArduRover", "then", "now", "runs", "ratio")
    return section(2, "Beside ArduRover", _TEXT, table(headers, shown)) if shown else ""


def _runs(file: Path) -> dict[str, list[Mapping[str, Any]]]:
    return {row["label"]: row["runs"] for row in json.loads(file.read_text(encoding="utf-8"))["rows"]}


def _row(row: Mapping[str, Any], runs: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    values = [value for run in runs if math.isfinite(value := run["metrics"].get(row["metric"], math.nan))]
    then = _digits(row["then"]) if "then" in row else ""
    if not values:
        return row["task"], row["figure"], _digits(row["theirs"]), then, "", "0", ""
    more = row.get("more", False)
    now, worst = sum(values) / len(values), min(values) if more else max(values)
    ratio = now / row["theirs"] if more else row["theirs"] / now
    shown = f"{ratio:.2f}" if ratio < 10.0 else f"{ratio:.0f}"
    return (
        row["task"],
        row["figure"],
        _digits(row["theirs"]),
        then,
        f"{_digits(now)} ({_digits(worst)})",
        str(len(values)),
        shown if ratio >= 1.0 else f"**{shown}**",
    )


def _digits(value: float) -> str:
    return number(float(f"{value:.3g}"))
