"""The smallest case of a violation: fewer faults, less weather, rounder numbers, shorter times, while it lasts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from sitl.hunt.box import run_of
from sitl.sweep.plan import Run

Lasts = Callable[[Sequence[Run]], Sequence[bool]]
"""Which of these runs violate the property."""

_WEATHER = ("wind", "current", "waves")
_ERRORS = ("model_error", "windage_error", "plant_error", "loss")
_RIGHT_DEG = 45
_MOST_RUNS = 60


def shrunk(run: Run, defaults: Mapping[str, str], lasts: Lasts, at_once: int) -> Run:
    """The smallest run that was found with the same violation. `defaults`: the scenario's own settings; `at_once`: how
    many runs are asked for together."""
    left = _MOST_RUNS
    while (found := _first(list(smaller(run, defaults))[:left], lasts, at_once)) is not None:
        run, used = found
        left -= used
    return run


def _first(candidates: Sequence[Run], lasts: Lasts, at_once: int) -> tuple[Run, int] | None:
    """The first candidate that has the violation, and how many were asked for; None where none has it."""
    for begin in range(0, len(candidates), at_once):
        some = candidates[begin : begin + at_once]
        for candidate, yes in zip(some, lasts(some), strict=True):
            if yes:
                return candidate, begin + len(some)
    return None


def smaller(run: Run, defaults: Mapping[str, str]) -> Iterator[Run]:
    """Runs that are smaller by one step, the largest steps first."""
    settings = {**defaults, **dict(run.settings)}

    def changed(**settings_too: str) -> Run:
        return run_of(run.scenario, run.vessel, run.seed, {**settings, **settings_too}, run.faults, defaults)

    seen = {run}
    for candidate in (
        *_fewer_faults(run),
        *_calmer(settings, changed),
        *_usual(run, changed, defaults),
        *_weaker(settings, changed),
        *_simpler_faults(run),
        *([replace(run, seed=0)] if run.seed else []),
    ):
        if candidate not in seen:
            seen.add(candidate)
            yield candidate


def _fewer_faults(run: Run) -> Iterator[Run]:
    if len(run.faults) > 1:
        yield replace(run, faults=())
    yield from (replace(run, faults=tuple(f for f in run.faults if f != fault)) for fault in run.faults)


def _calmer(settings: Mapping[str, str], changed: Callable[..., Run]) -> Iterator[Run]:
    """Without wind, current, waves or errors of the model: all of them, then one after another."""
    there = [key for key in (*_WEATHER, *_ERRORS) if settings.get(key)]
    if len(there) > 1:
        yield changed(**dict.fromkeys(there, ""))
    yield from (changed(**{key: ""}) for key in there)


def _usual(run: Run, changed: Callable[..., Run], defaults: Mapping[str, str]) -> Iterator[Run]:
    """Other settings as the scenario has them."""
    yield from (
        changed(**{key: defaults[key]})
        for key, _ in run.settings
        if key not in (*_WEATHER, *_ERRORS) and key in defaults
    )


def _weaker(settings: Mapping[str, str], changed: Callable[..., Run]) -> Iterator[Run]:
    """Half of each, rounder numbers and rounder directions."""
    for key in (*_WEATHER, *_ERRORS):
        text, at, direction = settings.get(key, "").partition("@")
        if not text:
            continue
        amount = float(text)
        for less in (0.5 * amount, 0.75 * amount, amount):
            round_one = _rounded_down(less)
            if abs(round_one) < abs(amount) and round_one:
                yield changed(**{key: f"{round_one:g}{at}{direction}"})
        if at and int(direction) % _RIGHT_DEG:
            rounded = round(int(direction) / _RIGHT_DEG) * _RIGHT_DEG % 360
            yield changed(**{key: f"{text}@{rounded}"})


def _simpler_faults(run: Run) -> Iterator[Run]:
    """Shorter, and at a rounder time."""
    for i, fault in enumerate(run.faults):
        name, _, times = fault.partition("@")
        at, plus, duration = times.partition("+")
        kinds = [f"{name}@{at}+{less}" for less in _shorter(int(duration))] if plus else []
        kinds += [f"{name}@{rounder}{plus}{duration}" for rounder in _rounder(int(at))]
        yield from (replace(run, faults=(*run.faults[:i], kind, *run.faults[i + 1 :])) for kind in kinds)


def _shorter(duration_s: int) -> Iterator[int]:
    for less in (duration_s // 4, duration_s // 2, round(0.75 * duration_s)):
        if 0 < less < duration_s:
            yield less


def _rounder(at_s: int) -> Iterator[int]:
    for step in (30, 10, 5):
        if at_s % step and round(at_s / step) > 0:
            yield round(at_s / step) * step


def _rounded_down(amount: float) -> float:
    """Towards 0, to one figure."""
    if amount == 0.0:
        return 0.0
    digit = 10.0 ** math.floor(math.log10(abs(amount)) + 1e-9)
    return round(math.trunc(amount / digit + math.copysign(1e-9, amount)) * digit, 6)
