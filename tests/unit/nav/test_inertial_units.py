"""Several inertial sensors: no jump at a switch, and one of three that lies has no part."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from companion.config.vessel import VesselConfig
from companion.core.readings import Imu, Reading
from companion.nav.inertial_units import InertialUnits, inertial_units, silences_s
from tests.unit.nav.boat_truth import Passage, Voyage, config_of, navigate, rms, sail

VOYAGE = Voyage(duration_s=70.0, seed=11)
SWITCH = replace(VOYAGE, duration_s=31.0)  # as long as what comes with BEGUN_S is looked at
BIASES = ((0.0, 0.0, 0.0), (0.25, -0.2, 0.1), (-0.15, 0.1, -0.2))  # m/s², beside that of the first
TURNS = (0.0, math.radians(0.6), math.radians(-0.4))  # rad/s
BEGUN_S = 25.0
Lie = Callable[[Imu], Imu | None]


def boat(count: int) -> VesselConfig:
    gnss, imu = config_of(VOYAGE).sensors
    more = [replace(imu, name=f"imu{k + 1}") for k in range(1, count)]
    return replace(config_of(VOYAGE), sensors=(gnss, imu, *more))


def unit(imu: Imu, number: int, draw: np.random.Generator) -> Imu:
    """The same sample by another unit: its own biases and noise, 3 ms later."""
    if number == 0:
        return imu
    (x, y, z), noise = BIASES[number], draw.standard_normal(6)
    return Imu(
        imu.t_s + 0.003 * number, f"imu{number + 1}",
        imu.x_mps2 + x + 0.01 * noise[0], imu.y_mps2 + y + 0.01 * noise[1], imu.z_mps2 + z + 0.01 * noise[2],
        imu.roll_rate_radps + 0.0017 * noise[3], imu.pitch_rate_radps + 0.0017 * noise[4],
        imu.yaw_rate_radps + TURNS[number] + 0.0017 * noise[5],
    )  # fmt: skip


def sailed(count: int, lie: Lie, blind: bool = False, voyage: Voyage = SWITCH) -> Passage:
    """`lie`: what becomes of the first unit's samples from BEGUN_S on. `blind`: no receiver and no heading from then
    on, so that the inertial sensors alone carry the estimate."""
    draw = np.random.default_rng(5)

    def alter(_: int, row: list[Reading]) -> list[Reading]:
        said: list[Reading] = []
        for reading in row:
            if not isinstance(reading, Imu):
                said += [] if blind and reading.t_s >= BEGUN_S else [reading]
                continue
            for number in range(count):
                sample: Imu | None = unit(reading, number, draw)
                if number == 0 and reading.t_s >= BEGUN_S:
                    sample = lie(reading)
                said += [] if sample is None else [sample]
        return said

    return navigate(voyage, alter, config=boat(count))


@cache
def honestly(count: int, blind: bool = False) -> tuple[float, float]:
    """The worst errors of a boat of which no unit lies."""
    return worst(sailed(count, lambda imu: imu, blind))


def worst(passage: Passage, after_s: float = BEGUN_S, before_s: float = BEGUN_S + 5.0) -> tuple[float, float]:
    """Largest errors of velocity (m/s) and of heading (degrees)."""
    _, yaw, velocity = passage.errors(after_s, before_s)
    return float(velocity.max()), math.degrees(float(yaw.max()))


def test_one_that_stops_leaves_no_trace() -> None:
    """Carried by the second unit's samples alone for five seconds, without a receiver: as well as by the first's."""
    honest, stopped = honestly(2, blind=True), worst(sailed(2, lambda _: None, blind=True))
    assert stopped[0] < honest[0] + 0.1 and stopped[1] < honest[1] + 0.2
    assert stopped[0] < 0.25


@pytest.mark.parametrize(
    "lie",
    [
        lambda imu: replace(imu, yaw_rate_radps=imu.yaw_rate_radps + 0.2),
        lambda imu: replace(imu, x_mps2=imu.x_mps2 + 2.0),
        lambda imu: replace(imu, y_mps2=-imu.y_mps2, roll_rate_radps=-imu.roll_rate_radps),
        lambda imu: replace(imu, x_mps2=0.0, y_mps2=0.0, z_mps2=0.0, yaw_rate_radps=0.0),
    ],
    ids=["turns", "pushes", "reversed", "zeros"],
)
def test_one_of_three_that_lies_has_no_part(lie: Lie) -> None:
    """From its first sample on, before anything has found that it lies: the boat here is not even armed."""
    honest, lied = honestly(3), worst(sailed(3, lie))
    assert lied[0] < honest[0] + 0.03 and lied[1] < honest[1] + 0.3


def test_the_biases_of_others_do_not_disturb() -> None:
    position, yaw, velocity = sailed(3, lambda imu: imu, voyage=VOYAGE).errors(30.0)
    assert rms(position) < 0.03 and math.degrees(rms(yaw)) < 0.3 and rms(velocity) < 0.03


def test_a_switch_to_a_unit_elsewhere_takes_its_place_into_account() -> None:
    """The other one sits two metres further ahead; the truth of its samples is that of its place."""
    begun_s = 60.0  # the biases are known well by then
    voyage = replace(SWITCH, duration_s=66.0, imu_lever=(2.0, 0.0, 0.0), speed_mps=1.5, radius_m=5.0)
    gnss, imu = config_of(VOYAGE).sensors
    config = replace(config_of(VOYAGE), sensors=(gnss, imu, replace(imu, name="imu2", x_m=2.0)))

    def alter(_: int, row: list[Reading]) -> list[Reading]:
        """Until begun_s both say what the second one feels; the first is as far off as its place makes it. It is in use
        from the start, since it speaks first."""
        said = [reading for reading in row if not isinstance(reading, Imu)]
        for reading in row:
            if isinstance(reading, Imu):
                turn = reading.yaw_rate_radps
                first = replace(reading, x_mps2=reading.x_mps2 + 2.0 * turn * turn)
                said += [first] if reading.t_s < begun_s else []
                said += [replace(reading, source="imu2")] if reading.t_s >= 0.5 else []
        return said

    passage = navigate(voyage, alter, config=config)
    position, _, velocity = passage.errors(begun_s, begun_s + 3.0)
    assert position.max() < 0.15 and velocity.max() < 0.25


def test_what_a_steady_turn_makes_of_a_unit_elsewhere_is_no_offset() -> None:
    """Two metres apart, half a minute into the turn; what the second one feels is the truth of its place. The estimate
    was 0.4 m/s and a degree off at the switch."""
    first, second = (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    voyage = Voyage(duration_s=66.0, seed=11, imu_lever=first, speed_mps=1.5, radius_m=3.0)
    there, draw = sail(replace(voyage, imu_lever=second)), np.random.default_rng(5)
    gnss, imu = config_of(voyage).sensors
    config = replace(config_of(voyage), sensors=(gnss, imu, replace(imu, name="imu2", x_m=1.0)))

    def alter(k: int, row: list[Reading]) -> list[Reading]:
        said = [reading for reading in row if not isinstance(reading, Imu) or reading.t_s < 60.0]
        felt = [*there.force[k].tolist(), *there.rates[k].tolist()]
        sample = Imu(float(there.t_s[k]), "imu2", *felt)
        return [*said, unit(replace(sample, source="imu"), 1, draw)]

    passage = navigate(voyage, alter, config=config)
    position, _, velocity = passage.errors(60.0)
    assert position.max() < 0.05 and velocity.max() < 0.05


@pytest.mark.parametrize(
    "voyage",
    [
        Voyage(duration_s=36.0, seed=11, speed_mps=1.5, radius_m=2.0, rests_s=25.0),
        Voyage(duration_s=36.0, seed=11, speed_mps=0.0, roll_rad=math.radians(15.0)),
    ],
    ids=["begins to turn", "rolls"],
)
def test_what_the_begin_of_a_turn_makes_of_units_in_line_is_no_motion(voyage: Voyage) -> None:
    """A metre apart, and up to the mast: the median of each axis was another one's from moment to moment."""
    levers = ((-1.0, 0.0, 0.0), (0.0, 0.0, -0.7), (1.0, 0.0, -1.4))
    truths, draw = [sail(replace(voyage, imu_lever=lever)) for lever in levers], np.random.default_rng(5)
    gnss, imu = config_of(replace(voyage, imu_lever=levers[0])).sensors
    more = [replace(imu, name=f"imu{k + 1}", x_m=levers[k][0], z_m=levers[k][2]) for k in (1, 2)]
    config = replace(config_of(voyage), sensors=(gnss, imu, *more))

    def alter(k: int, row: list[Reading]) -> list[Reading]:
        said = [reading for reading in row if not isinstance(reading, Imu)]
        for number, there in enumerate(truths):
            felt = [*there.force[k].tolist(), *there.rates[k].tolist()]
            said.append(unit(Imu(float(there.t_s[k]), "imu", *felt), number, draw))
        return said

    passage = navigate(voyage, alter, config=config)
    position, _, velocity = passage.errors(24.0)
    tilt = [s.roll_rad - passage.truth.attitude[k, 0] for s, k in zip(passage.states, passage.rows, strict=True)]
    assert position.max() < 0.05 and velocity.max() < 0.08
    assert math.degrees(max(map(abs, tilt[240:]))) < 0.7


def test_a_boat_with_one_has_nothing_to_bring_together() -> None:
    assert inertial_units(boat(1).sensors) is None and isinstance(inertial_units(boat(2).sensors), InertialUnits)
    assert silences_s(boat(1).sensors) == {row.name: row.timeout_s for row in boat(1).sensors}
    assert silences_s(boat(2).sensors) == {"gnss": 2.0, "imu": 0.05, "imu2": 0.05}
