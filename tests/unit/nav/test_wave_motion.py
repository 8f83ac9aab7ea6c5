"""Wave motion told apart from slow motion: what is taken off, and what stays."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from companion.config import vessel as vessel_config
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import WaveMotion
from companion.nav.solution import Motion
from companion.nav.wave_motion import WaveObserver, WaveSpectrum

REVOLT = vessel_config.load(vessel_config.find("revolt"))
DT_S = 0.1
BANDWIDTHS = (0.5, 0.5)
Rate = Callable[[float], float]


def motion(north_mps: float, east_mps: float = 0.0, turn_radps: float = 0.0, yaw_rad: float = 0.0) -> Motion:
    return Motion(
        0.0, (0.0, 0.0, 0.0), (north_mps, east_mps, 0.0), (0.0, 0.0, yaw_rad), (0.0, 0.0, turn_radps), 0.01, 0.01, 0.01
    )


def met(
    north_mps: Rate,
    seconds: float = 120.0,
    thrust: Callable[[float], Wrench | None] = lambda _: ZERO_WRENCH,
    turn_radps: Rate = lambda _: 0.0,
    bandwidths: tuple[float, float] = BANDWIDTHS,
) -> list[tuple[float, WaveMotion | None]]:
    """(time, wave motion) of each tick."""
    observer = WaveObserver(REVOLT.hull, REVOLT.length_m)
    ticks = [DT_S * k for k in range(round(seconds / DT_S))]
    return [
        (t_s, observer.update(t_s, thrust(t_s), motion(north_mps(t_s), turn_radps=turn_radps(t_s)), bandwidths))
        for t_s in ticks
    ]


def swell(radps: float, amplitude_mps: float = 0.2) -> Rate:
    return lambda t_s: amplitude_mps * math.cos(radps * t_s)


@pytest.mark.parametrize("radps", [2.0, 3.3, 4.7])
@pytest.mark.parametrize("dt_s", [0.05, 0.1])
def test_the_frequency_is_found(radps: float, dt_s: float) -> None:
    spectrum = WaveSpectrum(1)
    for k in range(round(60.0 / dt_s)):
        spectrum.update((0.3 * math.sin(0.1 * k * dt_s) * 0.1 + math.cos(radps * k * dt_s),), (1.0,), dt_s)
    assert spectrum.radps == pytest.approx(radps, rel=0.02)
    assert spectrum.rms(0) == pytest.approx(math.sqrt(0.5), rel=0.4)


@pytest.mark.parametrize("radps", [2.0, 3.3, 4.7])
def test_the_waves_are_taken_off(radps: float) -> None:
    """Displacement and velocity, to a twentieth: their mean frequency is known that well."""
    last = met(swell(radps))[-100:]
    for t_s, waves in last:
        assert waves is not None and waves.radps == pytest.approx(radps, rel=0.02)
        assert waves.north_mps == pytest.approx(0.2 * math.cos(radps * t_s), abs=0.012)
        assert waves.north_m == pytest.approx(0.2 / radps * math.sin(radps * t_s), abs=0.012)
        assert waves.east_m == waves.east_mps == 0.0


def test_a_band_of_waves_is_taken_off_for_the_most_part() -> None:
    """Two components, 15 % off the mean on either side, as in SITL."""
    both = [2.37 * factor for factor in (0.87, 1.17)]

    def velocity(t_s: float) -> float:
        return 0.1 * sum(math.cos(radps * t_s) for radps in both)

    left = [velocity(t_s) - (waves.north_mps if waves else 0.0) for t_s, waves in met(velocity)[-600:]]
    assert math.sqrt(sum(v * v for v in left) / len(left)) < 0.3 * 0.1


def test_slow_motion_passes() -> None:
    """A drift, and a to and fro as slow as positioning itself, stay nearly whole while waves are taken off."""

    def slow(t_s: float) -> float:
        return 0.05 + 0.05 * math.cos(0.2 * t_s)

    wave = swell(3.3)
    left = [
        slow(t_s) + wave(t_s) - (waves.north_mps if waves else 0.0)
        for t_s, waves in met(lambda t_s: slow(t_s) + wave(t_s))[-628:]
    ]
    errors = [v - slow(0.1 * (k + 572)) for k, v in enumerate(left)]
    assert math.sqrt(sum(e * e for e in errors) / len(errors)) < 0.02
    assert sum(left) / len(left) == pytest.approx(0.05, abs=0.003)


def test_known_thrust_is_no_wave() -> None:
    """The boat's own acceleration passes without lag: the velocity after a push of 20 N for 2 s in waves."""

    def push(t_s: float) -> Wrench:
        return Wrench(20.0 if 100.0 <= t_s < 102.0 else 0.0, 0.0, 0.0)

    def gained(t_s: float) -> float:
        return 20.0 / REVOLT.hull.m11_kg * min(max(t_s - 99.9, 0.0), 2.0)

    wave = swell(3.3)
    after = [
        (t_s, wave(t_s) + gained(t_s) - waves.north_mps)
        for t_s, waves in met(lambda t_s: wave(t_s) + gained(t_s), 110.0, push)
        if waves is not None and 100.0 <= t_s < 104.0
    ]
    assert max(abs(velocity - gained(t_s)) for t_s, velocity in after) < 0.02


@pytest.mark.parametrize(
    "velocity, bandwidths",
    [
        (swell(3.3, 0.005), BANDWIDTHS),
        (swell(3.3), (1.5, 1.5)),
        (lambda t_s: 1.2 + swell(3.3)(t_s), BANDWIDTHS),
        (lambda t_s: 0.2 * math.cos(0.3 * t_s), BANDWIDTHS),
    ],
    ids=["calm", "a law as fast as the waves", "under way", "slow motion alone"],
)
def test_where_nothing_is_taken_off(velocity: Rate, bandwidths: tuple[float, float]) -> None:
    assert met(velocity, bandwidths=bandwidths)[-1][1] is None


def test_yaw_is_judged_by_itself() -> None:
    last = met(swell(3.3), turn_radps=lambda t_s: 0.1 * math.cos(3.3 * t_s))[-1][1]
    assert last is not None and last.yaw_rate_radps == pytest.approx(0.1 * math.cos(3.3 * 119.9), abs=0.01)
    last = met(swell(3.3))[-1][1]
    assert last is not None and last.yaw_rad == last.yaw_rate_radps == 0.0


def test_it_begins_without_a_step() -> None:
    """In rising waves no tick takes off much more than the one before."""
    wave = swell(3.3)
    seen = met(lambda t_s: min(1.0, t_s / 30.0) * wave(t_s))
    first = next(k for k, (_, waves) in enumerate(seen) if waves is not None)
    begun = [waves for _, waves in seen[first : first + 5]]
    assert all(waves is not None and abs(waves.north_mps) < 0.02 for waves in begun)


def test_it_begins_anew_while_the_thrust_is_unknown_and_after_a_jump_of_velocity() -> None:
    seen = met(swell(3.3), 60.0, lambda t_s: None if 40.0 <= t_s < 41.0 else ZERO_WRENCH)
    assert seen[395][1] is not None and seen[405][1] is None
    jumped = met(lambda t_s: swell(3.3)(t_s) + (3.0 if 50.0 <= t_s < 50.05 else 0.0), 60.0)
    assert all(waves is None or abs(waves.north_m) < 0.2 for _, waves in jumped)


def test_a_boat_that_brakes_makes_no_waves() -> None:
    """A light boat comes to rest before a wind of 20 N from astern. While it loses its speed, its damping falls by
    100 N: taken for waves, up to 0.2 m/s of its motion was left alone."""
    aboat = vessel_config.load(vessel_config.find("aboat"))
    hull, observer, wave = aboat.hull, WaveObserver(aboat.hull, aboat.length_m), swell(2.0, 0.06)
    speed_mps, taken_mps = 1.6, []
    for k in range(600):
        t_s = DT_S * k
        wanted_mps = max(0.0, 1.6 - 0.06 * max(0.0, t_s - 25.0))
        thrust_n = hull.drag_n(wanted_mps) - 20.0 + hull.m11_kg * (wanted_mps - speed_mps)
        waves = observer.update(t_s, Wrench(thrust_n, 0.0, 0.0), motion(speed_mps + wave(t_s)), (0.35, 0.45))
        taken_mps.append(0.0 if waves is None else waves.north_mps)
        speed_mps += DT_S * (thrust_n + 20.0 - hull.drag_n(speed_mps)) / hull.m11_kg
    whole = round(math.tau / 2.0 / DT_S)  # of a wave: what is left is no wave
    means = [sum(taken_mps[k : k + whole]) / whole for k in range(300, 570)]
    assert max(map(abs, means)) < 0.03


def test_a_boat_that_pushes_itself_to_and_fro_makes_no_waves() -> None:
    """One with an outboard did so in Hold: half of its own motion was taken off, and it went on for good."""
    mass_kg = REVOLT.hull.m11_kg

    def push(t_s: float) -> Wrench:
        return Wrench(40.0 if t_s % 4.0 < 2.0 else -40.0, 0.0, 0.0)

    velocities = [0.0]
    for k in range(600):
        force = push(DT_S * k).surge_n - REVOLT.hull.drag_n(velocities[-1])
        velocities.append(velocities[-1] + DT_S * force / mass_kg)
    found = met(lambda t_s: velocities[round(t_s / DT_S)], 60.0, lambda t_s: push(t_s - DT_S), bandwidths=(0.3, 0.3))
    assert all(waves is None or waves.north_mps == 0.0 for t_s, waves in found if t_s >= 6.0)


def test_a_gust_that_the_thrust_counters_makes_no_waves() -> None:
    """A gust turns a light boat with 60 Nm, and the thrust turns against it. Where the wind is not told, the turn by
    thrust alone counts for slow motion, and what the boat does instead for waves: damping acted on the wrong rate."""
    aboat = vessel_config.load(vessel_config.find("aboat"))
    wave = swell(2.0, 0.04)

    def taken_most_radps(wind_known: bool) -> float:
        observer, taken_radps = WaveObserver(aboat.hull, aboat.length_m), []
        for k in range(800):
            t_s = DT_S * k
            gust_nm = 60.0 * min(1.0, max(0.0, (t_s - 40.0) / 2.0))
            wind = Wrench(0.0, 0.0, gust_nm) if wind_known else None
            turning = motion(0.0, turn_radps=wave(t_s))
            waves = observer.update(t_s, Wrench(0.0, 0.0, -gust_nm), turning, (0.35, 0.45), wind=wind)
            taken_radps.append(0.0 if waves is None else waves.yaw_rate_radps)
        whole = round(math.tau / 2.0 / DT_S)  # of a wave: what is left is no wave
        return max(abs(sum(taken_radps[k : k + whole]) / whole) for k in range(390, 500))

    assert taken_most_radps(wind_known=True) < 0.005
    assert taken_most_radps(wind_known=False) > 0.05


def test_a_wind_that_comes_to_be_known_is_no_wave() -> None:
    """A boat that lies steadily against 60 Nm of wind while its wind sensor begins and ends to measure."""
    observer, wave = WaveObserver(REVOLT.hull, REVOLT.length_m), swell(2.0, 0.06)
    taken_radps = []
    for k in range(900):
        t_s = DT_S * k
        wind = Wrench(0.0, 0.0, 60.0) if 40.0 <= t_s < 65.0 else None
        turning = motion(0.0, turn_radps=wave(t_s))
        waves = observer.update(t_s, Wrench(0.0, 0.0, -60.0), turning, BANDWIDTHS, wind=wind)
        taken_radps.append(0.0 if waves is None else waves.yaw_rate_radps)
    assert max(map(abs, taken_radps[300:])) < 0.1
