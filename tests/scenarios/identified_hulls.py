"""How well a Trial identifies boats whose equations have terms that their file lacks, in wind, current and waves.

    python -m tests.scenarios.identified_hulls 200-249 --folder /tmp/identified --out identification.json

sails a Trial of each boat of `sitl.hidden_structure` where the folder has none yet, identifies it from the log, and
compares each quantity with the truth. `--track` sails hold, a square and RTL with the model as typed and as found.
Prints a line a boat, then a table of the quantities.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median

from companion.analysis.held_out import prediction, split
from companion.analysis.hull_fit import Estimate, fit
from companion.analysis.hull_model import HullModel
from companion.analysis.log_reader import open_log
from companion.analysis.manoeuvre import read_manoeuvre
from companion.analysis.trial_identify import identify_trial
from companion.analysis.trial_log import manoeuvres
from companion.cli.common import seeds
from sitl.hidden_hull import HiddenHull
from sitl.hidden_structure import structure_of, structured_hull, water_of
from tests.scenarios.hidden_hulls import (
    LONGEST_S,
    Kept,
    Weather,
    loaded_with,
    model_errors,
    sail_all,
    sail_trial,
)
from tests.scenarios.hidden_truth import truth_of

_NINETY_FIVE = 1.96


@dataclass(frozen=True, slots=True)
class Compared:
    """One quantity of one boat. `interval`: half of the 95 % one, None where the log says too little. `doubt`: one
    sigma of what was known before."""

    name: str
    value: float
    interval: float | None
    true: float
    typed: float
    doubt: float

    @property
    def covered(self) -> bool:
        """Whether the interval that is stated has the truth."""
        return self.interval is not None and abs(self.value - self.true) <= self.interval


@dataclass(frozen=True, slots=True)
class Identified:
    """One boat. `predicted`: error of the velocities over 10 s that were held out, as typed and as found; `apart`: the
    same, from the true model. `typed`, `found`: as sailed, None where not asked for."""

    seed: int
    propulsion: str
    water: str
    structure: str
    quantities: tuple[Compared, ...]
    predicted: tuple[float, float]
    apart: tuple[float, float]
    typed: Kept | None
    found: Kept | None

    @property
    def line(self) -> str:
        """For people."""
        stated = [one for one in self.quantities if one.interval is not None]
        words = [
            f"seed {self.seed} {self.propulsion}, {self.structure}, {self.water}",
            f"{sum(one.covered for one in stated)} of {len(stated)} intervals, {len(self.quantities)} quantities",
            f"error {self.predicted[0]:.3f} -> {self.predicted[1]:.3f}",
            f"from the true model {self.apart[0]:.3f} -> {self.apart[1]:.3f}",
        ]
        for name, kept in (("typed", self.typed), ("found", self.found)):
            if kept is not None:
                words.append(f"{name}: {kept.lost or 'kept'} ({kept.station_m:.2f}, {kept.path_m:.2f} m)")
        return " | ".join(words)


def study(seed: int, folder: Path, track: bool) -> Identified:
    """The boat of that seed, with its logs in `folder`."""
    boat, water = structured_hull(seed), water_of(structured_hull(seed))
    weather = Weather(water.wind, water.current_share, water.waves)
    trial = folder / "trial"
    if not (trial / "done").exists():
        sailed = sail_trial(boat, boat.real, trial, LONGEST_S, weather)
        (trial / "done").write_text(f"{sailed.mode} after {sailed.seconds:.0f} s\n", encoding="utf-8")
    log = open_log(trial)
    fitted, held_out = split(read_manoeuvre(log, []), manoeuvres(trial))
    model = HullModel(log, fitted, mounting=True)
    found = fit(log, fitted, mounting=True).estimates
    values = {one.name: one.value for one in found}
    predicted = prediction(log, held_out, model.model, values)
    typed = after = None
    if track:
        told = loaded_with(boat, identify_trial(log).overlay, folder / "told")
        typed = sail_all(boat, boat.known, folder / "typed", weather)
        after = sail_all(boat, told, folder / "found", weather)
    structure = [name for name, has in asdict(structure_of(seed)).items() if has]
    waves = f"waves {water.waves} m" if water.waves else "no waves"
    return Identified(
        seed=seed,
        propulsion=boat.propulsion,
        water=f"wind {water.wind} m/s, {waves}",
        structure=" ".join(structure) or "as its file",
        quantities=compared(boat, model, found),
        predicted=(math.nan, math.nan) if predicted is None else (predicted.before, predicted.after),
        apart=model_errors(boat, log, held_out, values),
        typed=typed,
        found=after,
    )


def compared(boat: HiddenHull, model: HullModel, found: Sequence[Estimate]) -> tuple[Compared, ...]:
    """All quantities that have a true value."""
    true = truth_of(boat, model)
    return tuple(
        Compared(
            name=one.name.split(" ")[0],
            value=one.value,
            interval=None if one.sigma is None else _NINETY_FIVE * one.sigma,
            true=true[one.name],
            typed=one.model,
            doubt=model.doubt(one.name),
        )
        for one in found
        if one.name in true
    )


def table(found: Sequence[Identified]) -> str:
    """A line a quantity: how often its interval was stated and had the truth, and the median errors and intervals, in
    what was doubted before."""
    everything = [one for boat in found for one in boat.quantities]
    lines = [f"{'':24}{'stated':>10}{'covered':>9}{'± / doubt':>11}{'error as typed':>16}{'as found':>10}"]
    for name in dict.fromkeys(one.name for one in everything):
        lines.append(_row(name, [one for one in everything if one.name == name]))
    lines.append(_row("all", everything))
    for index, before in enumerate(("predicted", "apart")):
        pairs = [(boat.predicted, boat.apart)[index] for boat in found]
        ratio = median(after / old for old, after in pairs)
        old, new = (median(pair[k] for pair in pairs) for k in (0, 1))
        lines.append(f"{before}: median {old:.3f} -> {new:.3f}, median ratio {ratio:.2f}")
    sailed = [(boat.typed, boat.found) for boat in found if boat.typed is not None and boat.found is not None]
    if sailed:
        lines.append(_tracked(sailed))
    return "\n".join(lines)


def _row(name: str, all_of: Sequence[Compared]) -> str:
    stated = [one for one in all_of if one.interval is not None]
    covered = sum(one.covered for one in stated) / len(stated) if stated else math.nan
    width = median((one.interval or 0.0) / one.doubt for one in stated) if stated else math.nan
    typed, now = (median(abs(x - one.true) / one.doubt for one, x in pairs) for pairs in _both(all_of))
    return f"{name:24}{len(stated):>5}/{len(all_of):<4}{covered:>9.2f}{width:>11.2f}{typed:>16.2f}{now:>10.2f}"


def _both(all_of: Sequence[Compared]) -> tuple[list[tuple[Compared, float]], list[tuple[Compared, float]]]:
    return [(one, one.typed) for one in all_of], [(one, one.value) for one in all_of]


def _tracked(sailed: Sequence[tuple[Kept, Kept]]) -> str:
    lost = [sum(bool(pair[k].lost) for pair in sailed) for k in (0, 1)]
    kept = [pair for pair in sailed if not pair[0].lost and not pair[1].lost]
    station = [median(pair[k].station_m for pair in kept) for k in (0, 1)]
    path = [median(pair[k].path_m for pair in kept) for k in (0, 1)]
    ratio = [median(new.station_m / old.station_m for old, new in kept), median(b.path_m / a.path_m for a, b in kept)]
    return (
        f"tracking of {len(sailed)} boats: lost control {lost[0]} -> {lost[1]}; of the {len(kept)} others, hold RMS "
        f"{station[0]:.2f} -> {station[1]:.2f} m (median ratio {ratio[0]:.2f}), path RMS {path[0]:.2f} -> "
        f"{path[1]:.2f} m ({ratio[1]:.2f})"
    )


def main() -> int:
    """Study the seeds; 0 if nine of ten stated intervals have the truth."""
    parser = argparse.ArgumentParser(description="identified hulls")
    parser.add_argument("seeds", nargs="+", type=seeds, help="such as 200-249 or 207")
    parser.add_argument("--folder", type=Path, required=True, help="for the logs")
    parser.add_argument("--track", action="store_true", help="sail as typed and as found")
    parser.add_argument("--out", type=Path, help="all figures as JSON")
    arguments = parser.parse_args()
    found = []
    for seed in itertools.chain.from_iterable(arguments.seeds):
        found.append(study(seed, arguments.folder / f"seed{seed}", arguments.track))
        print(found[-1].line, flush=True)
        if arguments.out is not None:
            arguments.out.write_text(json.dumps([asdict(one) for one in found], indent=1), encoding="utf-8")
    print(table(found))
    stated = [one for boat in found for one in boat.quantities if one.interval is not None]
    return 0 if sum(one.covered for one in stated) >= 0.9 * len(stated) else 1


if __name__ == "__main__":
    raise SystemExit(main())
