"""The part of results.md that says whether the estimate's covariance is that of its errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from docs.generate.markdown import code, section, table

_TEXT = """An estimate is only useful with its accuracy. The table has squared errors, divided by the covariance that
the filter claims and by their number: the mean of all seeds is 1 if the claim is correct, more if the filter is
over-confident, less if it is cautious.

* **NEES**, the normalised estimation error squared, of all five (position, velocity, heading) and of parts.
* **NIS**, the normalised innovation squared, of each kind of measurement, the newest at the instant.
* **NVS**, the normalised square of each variable alone. The letters have no common meaning; here they have this one.
* **Bias**, the mean of an error over its sigma: 0 for a filter without a systematic error.

A cell gives the mean over seeds and instants, and how many instants are in the two-sided 95 % band, chi-square with as
many degrees of freedom as seeds times numbers. If more are outside than chance explains, the cell says in which way.
Slow errors last 30 to 300 s here, so the instants are not independent of each other; the seeds are."""

_MEANINGS = {
    "hold": "Hold",
    "mission": "mission, a square of 25 m",
    "dropout": "mission, 15 s without receiver",
    "fix_changes": "mission, RTK fixed, 20 s float, fixed, 20 s plain, fixed",
}


def consistency(measured: Mapping[str, Any]) -> str:
    """The section, from what consistency.json holds."""
    parts = [part for row in measured["rows"] for part in _row(row)]
    return section(2, "How honest the estimate's covariance is", _TEXT, *parts)


def _row(row: Mapping[str, Any]) -> Iterator[str]:
    seeds = "–".join(map(str, row["seeds"]))
    yield f"**{row['label']}**, wind 2 m/s, seeds {seeds}:"
    yield _table(row["cases"], ("NEES", "NIS"))
    yield _table(row["cases"], ("NVS", "bias"))
    yield f"Measured on {row['date']} at commit {code(row['commit'])} by {code(row['command'])}."


def _table(cases: Mapping[str, Any], kinds: tuple[str, ...]) -> str:
    first = next(iter(cases.values()))["kinds"]
    columns = [(kind, part) for kind in kinds for part in first[kind]]
    headers = ["", *(_header(kind, part, first[kind][part]["band"]) for kind, part in columns)]
    return table(
        headers,
        [
            [_MEANINGS.get(name, name), *(_cell(found["kinds"][kind].get(part)) for kind, part in columns)]
            for name, found in cases.items()
        ],
    )


def _header(kind: str, part: str, band: list[float]) -> str:
    low, high = (f"{edge:.2f}".replace("-", "−") for edge in band)
    return f"{kind} {part} ({low} to {high})"


def _cell(verdict: Mapping[str, Any] | None) -> str:
    if verdict is None:
        return ""
    instants = len(verdict["means"])
    text = f"{verdict['mean']:.2f}, {instants - verdict['outside']} of {instants}".replace("-", "−")
    return text if verdict["word"] == "inside" else f"**{text}: {verdict['word']}**"
