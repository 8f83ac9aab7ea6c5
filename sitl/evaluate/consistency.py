"""Sails that tell whether the estimator's covariance is that of its errors, and what comes out over many seeds.

NEES, the normalised estimation error squared, is that of position, velocity and heading, by the filter's own
covariance; NVS that of each variable alone; NIS, the normalised innovation squared, that of each kind of measurement.
The bias is the mean of an error over its sigma: a filter can have the right spread about the wrong place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.evaluate.normalised import Array, Verdict, judge_bias, judge_squares, normalised_squares
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import square
from sitl.scenarios.rig import Composer, Conditions, Rig

_MISSION = 0x04040000
_SIDE_M = 25.0
_ROUNDS = 4
_PATIENCE_S = 60.0  # FS_POS_T, so that no failsafe ends a run
_FRESH_S = 0.5  # an innovation that is older than that is not one of the instant

VARIABLES = ("north", "east", "velocity north", "velocity east", "heading")
PARTS: Mapping[str, tuple[int, ...]] = {
    "all five": (0, 1, 2, 3, 4),
    "position": (0, 1),
    "velocity": (2, 3),
    "heading": (4,),
}
SENSES: Mapping[str, int] = {"position": 2, "velocity": 2, "heading": 1}  # degrees of freedom of their innovations


@dataclass(frozen=True, slots=True)
class Case:
    """What is sailed: Hold, or a square where `sails`, with faults. `instants_s`: when it is judged."""

    sails: bool
    faults: tuple[str, ...]
    instants_s: tuple[float, ...]


_APART_S = (40.0, 70.0, 100.0)
CASES: Mapping[str, Case] = {
    "hold": Case(False, (), _APART_S),
    "mission": Case(True, (), _APART_S),
    "dropout": Case(True, ("gnss_lost@80+15",), (84.0, 88.0, 92.0, 94.8, 95.4, 97.0, 105.0)),
    "fix_changes": Case(
        True,
        ("rtk_float@60+20", "rtk_lost@100+20"),
        (61.0, 70.0, 79.8, 80.4, 82.0, 90.0, 101.0, 110.0, 119.8, 120.4, 122.0, 130.0),
    ),
}


@dataclass(frozen=True, slots=True)
class Believed:
    """What the boat believes at one time: its place and velocity in NED, its heading, their covariance (5 by 5), and
    the newest innovation of each sense: when, and its normalised square."""

    values: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]
    judged: Mapping[str, tuple[float, float]]


@dataclass(frozen=True, slots=True)
class Sample:
    """One instant of a run: errors, their covariance, and normalised squares of fresh innovations, by sense."""

    t_s: float
    errors: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]
    innovations: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Run:
    """One sail. `innovations`: mean normalised square of all innovations from the first instant to the last, by
    sense."""

    samples: tuple[Sample, ...]
    innovations: Mapping[str, float]


Look = Callable[[Rig], Believed | None]


def sail(case: Case, conditions: Conditions, compose: Composer, look: Look, folder: Path) -> Run:
    """Sail it. Raises GroundStationTimeout where the boat does not do what it is asked, ValueError where `look` sees
    no filter."""
    rig = compose(conditions, folder)
    try:
        gcs = GroundStation(rig)
        begin(gcs, case)
        gcs.sail(case.instants_s[0] - rig.now_s)
        innovations, samples = _Innovations(), [_sample(rig, look(rig))]
        for t_s in case.instants_s[1:]:
            while rig.now_s < t_s - 1e-9:
                gcs.step()
                innovations.take(_seen(rig, look(rig)))
            samples.append(_sample(rig, look(rig)))
        return Run(tuple(samples), innovations.means())
    finally:
        rig.close()


class _Innovations:
    """All innovations of a run. Remembers when the last of each sense came."""

    def __init__(self) -> None:
        self._squares: dict[str, list[float]] = {sense: [] for sense in SENSES}
        self._last_s: dict[str, float] = {}

    def take(self, believed: Believed) -> None:
        for sense, (t_s, value) in believed.judged.items():
            if sense in SENSES and self._last_s.get(sense) != t_s:
                self._last_s[sense] = t_s
                self._squares[sense].append(value / SENSES[sense])

    def means(self) -> dict[str, float]:
        return {sense: sum(values) / len(values) for sense, values in self._squares.items() if values}


def begin(gcs: GroundStation, case: Case) -> None:
    """Begin what is sailed."""
    gcs.ready()
    gcs.set_parameter("FS_POS_T", _PATIENCE_S)
    if not case.sails:
        gcs.hold_at_home(0.0)
        return
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    gcs.upload(
        [Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*corner)) for corner in square(_SIDE_M) * _ROUNDS]
    )
    gcs.set_mode(_MISSION)
    gcs.arm()


def _seen(rig: Rig, believed: Believed | None) -> Believed:
    if believed is None:
        raise ValueError(f"no filter runs at {rig.now_s:.1f} s")
    return believed


def _sample(rig: Rig, looked: Believed | None) -> Sample:
    believed = _seen(rig, looked)
    hull = rig.world.hull
    true = hull.north_m, hull.east_m, hull.north_mps, hull.east_mps, hull.yaw_rad
    errors = [value - is_ for value, is_ in zip(believed.values, true, strict=True)]
    errors[4] = math.remainder(errors[4], 2.0 * math.pi)
    fresh = {
        sense: value / SENSES[sense]
        for sense, (t_s, value) in believed.judged.items()
        if sense in SENSES and rig.now_s - t_s < _FRESH_S
    }
    return Sample(rig.now_s, tuple(errors), believed.covariance, fresh)


def verdicts(runs: Sequence[Run]) -> dict[str, dict[str, Verdict]]:
    """Of runs of one case: the kinds of figures, each by its parts."""
    samples = [run.samples for run in runs]
    errors = np.array([[sample.errors for sample in run] for run in samples])
    covariances = np.array([[sample.covariance for sample in run] for run in samples])
    sigmas = np.sqrt(np.diagonal(covariances, axis1=2, axis2=3))
    alone = errors / sigmas
    return {
        "NEES": {name: judge_squares(_squares(errors, covariances, part), len(part)) for name, part in PARTS.items()},
        "NVS": {name: judge_squares(alone[:, :, i] ** 2, 1) for i, name in enumerate(VARIABLES)},
        "bias": {name: judge_bias(alone[:, :, i]) for i, name in enumerate(VARIABLES)},
        "NIS": dict(_innovations(samples)),
    }


def _squares(errors: Array, covariances: Array, part: Sequence[int]) -> Array:
    rows = np.ix_(range(errors.shape[0]), range(errors.shape[1]), part, part)
    return normalised_squares(errors[:, :, part], covariances[rows])


def _innovations(runs: Sequence[Sequence[Sample]]) -> Iterator[tuple[str, Verdict]]:
    """By sense, at the instants at which every run has a fresh one."""
    for sense, freedom in SENSES.items():
        heard = [i for i in range(len(runs[0])) if all(sense in run[i].innovations for run in runs)]
        if heard:
            yield sense, judge_squares([[run[i].innovations[sense] for i in heard] for run in runs], freedom)


def spread(runs: Sequence[Run]) -> dict[str, list[tuple[float, float]]]:
    """By part of `PARTS` but the whole: RMS error and RMS sigma of one axis at each instant, in m, m/s and rad."""
    columns = list(zip(*(run.samples for run in runs), strict=True))
    parts = list(PARTS.items())[1:]
    return {name: [(_error(column, part), _sigma(column, part)) for column in columns] for name, part in parts}


def _error(samples: Sequence[Sample], part: Sequence[int]) -> float:
    return math.sqrt(np.mean([sample.errors[i] ** 2 for sample in samples for i in part]))


def _sigma(samples: Sequence[Sample], part: Sequence[int]) -> float:
    return math.sqrt(np.mean([sample.covariance[i][i] for sample in samples for i in part]))


def all_innovations(runs: Sequence[Run]) -> dict[str, float]:
    """Mean normalised square of all innovations of the runs, by sense."""
    return {
        sense: float(np.mean([run.innovations[sense] for run in runs]))
        for sense in SENSES
        if all(sense in run.innovations for run in runs)
    }
