"""Which run to sail next: for each safety property a search of its own, which learns from all runs.

Source: the tree-structured Parzen estimator, Bergstra et al. (2011), multivariate after Falkner et al. (2018), by
optuna.
"""

from __future__ import annotations

import itertools
import math
import random
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sitl.hunt.box import Box
from sitl.sweep.plan import Run
from sitl.sweep.rows import Row, SweepError

OPTUNA_MISSING = "a hunt needs optuna: pip install 'usv-companion[sweep]'"
BROKE_OFF = "broke_off"
"""The property that a run ends without an error of the program."""
_AT_RANDOM = 24  # runs before a search goes by what it has learned
_VIOLATED = -1.0  # as a share of what is far
_FAR = 1e6  # of a run that does not have the property, or whose violation is known


@dataclass(frozen=True, slots=True)
class Known:
    """A violation that is known: of a property, where a run has at least these faults, by name."""

    prop: str
    faults: frozenset[str]

    def covers(self, prop: str, run: Run) -> bool:
        """Whether a run's violation of a property is this one again."""
        return prop == self.prop and self.faults <= fault_names(run)


def fault_names(run: Run) -> frozenset[str]:
    """The names of a run's faults."""
    return frozenset(fault.partition("@")[0] for fault in run.faults)


def margins_of(row: Row) -> Mapping[str, float]:
    """A run's margins by property. A run without any, which an error ended, has that as its only one."""
    return row.safety if row.safety or row.error is None else {BROKE_OFF: -1.0}


class Search:
    """`ask` for a run, `tell` what came of it. The same seed and the same answers give the same questions."""

    def __init__(self, box: Box, seed: int, only: str | None = None) -> None:
        """`only`: the property that it is about. Raises SweepError without optuna."""
        try:
            import optuna
        except ImportError as error:
            raise SweepError(OPTUNA_MISSING) from error
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._optuna: Any = optuna
        self._box, self._seed, self._only = box, seed, only
        self._studies: dict[str, Any] = {}
        self._asked: dict[int, tuple[str, Any, Run]] = {}
        self._told: list[tuple[Any, Run, Mapping[str, float]]] = []
        self._known: list[Known] = []
        self._numbers = itertools.count()
        self._first = self._begin()

    def ask(self) -> tuple[int, Run]:
        """A number to `tell` by, and the run."""
        number = next(self._numbers)
        prop = self._turn(number)
        trial = self._study(prop).ask()
        run = self._box.draw(trial)
        self._asked[number] = prop, trial, run
        return number, run

    def tell(self, number: int, margins: Mapping[str, float]) -> None:
        """What came of a run: its margin for each property that it had."""
        prop, trial, run = self._asked.pop(number)
        self._told.append((trial, run, margins))
        self._studies[prop].tell(trial, self._value(prop, run, margins))
        for other, study in self._studies.items():
            if other != prop:
                study.add_trial(self._answered(trial, self._value(other, run, margins)))

    def know(self, found: Known) -> None:
        """From now on this violation is no find any more, and the searches look elsewhere."""
        self._known.append(found)
        self._studies.pop(found.prop, None)  # it is made anew from what was told

    def is_known(self, prop: str, run: Run) -> bool:
        """Whether a run's violation of a property is a known one."""
        return any(known.covers(prop, run) for known in self._known)

    def _begin(self) -> int:
        """Let the first runs have every fault once, two at a time. Returns how many runs do not go by what was
        learned."""
        kinds = list(self._box.faults)
        random.Random(self._seed).shuffle(kinds)
        pairs = [kinds[i : i + 2] for i in range(0, len(kinds), 2)]
        for pair in pairs:
            chosen = {f"fault{number}": kind for number, kind in enumerate(pair)}
            self._study(self._only or "").enqueue_trial({"faults": len(pair), **chosen})
        return len(pairs) + _AT_RANDOM

    def _turn(self, number: int) -> str:
        """Whose turn it is: of the properties whose margins differ, and that are not violated by weather alone."""
        seen: dict[str, set[float]] = {}
        for _, run, margins in self._told:
            for prop, margin in margins.items():
                if not self.is_known(prop, run):
                    seen.setdefault(prop, set()).add(margin)
        props = sorted(prop for prop, values in seen.items() if len(values) > 1 and self._only in (None, prop))
        return props[number % len(props)] if props and number >= self._first else self._only or ""

    def _study(self, prop: str) -> Any:
        if prop not in self._studies:
            with warnings.catch_warnings():  # `group` may still change, it says
                warnings.simplefilter("ignore")
                sampler = self._optuna.samplers.TPESampler(
                    n_startup_trials=_AT_RANDOM,
                    multivariate=True,
                    group=True,
                    constant_liar=True,
                    seed=self._seed + len(self._told),
                )
            study = self._optuna.create_study(sampler=sampler)
            for trial, run, margins in self._told:
                study.add_trial(self._answered(trial, self._value(prop, run, margins)))
            self._studies[prop] = study
        return self._studies[prop]

    def _answered(self, trial: Any, value: float) -> Any:
        return self._optuna.trial.create_trial(params=trial.params, distributions=trial.distributions, value=value)

    def _value(self, prop: str, run: Run, margins: Mapping[str, float]) -> float:
        margin = _clear(margins.get(prop, math.inf))
        return margin if math.isfinite(margin) and not self.is_known(prop, run) else _FAR


def violations(row: Row) -> list[str]:
    """The properties that a run violates, the clearest first."""
    found = {prop: _clear(margin) for prop, margin in margins_of(row).items()}
    return sorted((prop for prop, margin in found.items() if margin <= 0.0), key=lambda prop: found[prop])


def _clear(margin: float) -> float:
    """A margin, as a number: one that is none is violated by far."""
    return _VIOLATED if math.isnan(margin) else margin


def nearest(rows: Iterable[Row]) -> dict[str, Row]:
    """Of each property the run that came nearest to violating it, by name."""
    found: dict[str, Row] = {}
    for row in rows:
        for prop, margin in margins_of(row).items():
            if prop not in found or _clear(margin) < _clear(margins_of(found[prop])[prop]):
                found[prop] = row
    return dict(sorted(found.items()))


def counts(rows: Sequence[Row]) -> dict[str, tuple[int, int]]:
    """Of each property: how many runs violate it, and how many have it."""
    every = [margins_of(row) for row in rows]
    names = sorted({prop for margins in every for prop in margins})
    return {
        prop: (
            sum(_clear(margins.get(prop, 1.0)) <= 0.0 for margins in every),
            sum(prop in margins for margins in every),
        )
        for prop in names
    }
