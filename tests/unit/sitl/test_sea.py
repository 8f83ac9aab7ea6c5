"""A boat in a sea state: first-order motion and drift against closed forms and a second calculation."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from companion.config.hull import HullConfig
from companion.config.sea import SeaState
from sitl.environment import WindModel
from sitl.hull import Hull
from sitl.sea import Sea
from sitl.sea_state import Components, components
from sitl.wave_hull import REFLECTED, DriftTable, Met, WaveHull, followed

DT_S = 0.01
BOAT = WaveHull(3.0, 0.72, 0.72, 0.23, 4.3, 440.0)
HULL = HullConfig(263.9, 306.4, 322.0)
STILL = WindModel(0.0, 0.0, 1)
NORTH, EAST = 0.0, 0.5 * math.pi


def regular(amplitude_m: float, omega: float, towards_rad: float) -> Components:
    def one(value: float) -> np.ndarray:
        return np.array([value])

    return Components(one(amplitude_m), one(omega), one(omega**2 / 9.81), one(towards_rad), one(0.3))


def sea_of(waves: Components, hull: Hull, boat: WaveHull = BOAT, drift: bool = True) -> Sea:
    return Sea(waves, boat, hull, STILL, seed=1, mass_kg=264.0, drift=drift)


def led(waves: Components, speed_mps: float, yaw_rad: float = 0.0, duration_s: float = 60.0) -> list[tuple[float, ...]]:
    """Rows of (roll, roll rate, pitch, pitch rate, heave, heave rate, heave acceleration) of a boat led along."""
    hull = Hull(HULL)
    sea, rows = sea_of(waves, hull), []
    for k in range(round(duration_s / DT_S)):
        way = speed_mps * k * DT_S
        hull.place(way * math.cos(yaw_rad), way * math.sin(yaw_rad), yaw_rad, speed_mps)
        sea.update(k * DT_S)
        rows.append(
            (
                sea.roll_rad, sea.roll_rate_radps, sea.pitch_rad, sea.pitch_rate_radps,
                sea.heave_m, sea.heave_mps, sea.heave_mps2,
            )
        )  # fmt: skip
    return rows


def crossings_radps(values: list[float]) -> float:
    at = [k for k, (a, b) in enumerate(itertools.pairwise(values)) if a < 0.0 <= b]
    return math.tau * (len(at) - 1) / ((at[-1] - at[0]) * DT_S)


@pytest.mark.parametrize("speed_mps", [0.0, 2.0, 6.0])
@pytest.mark.parametrize("towards_rad", [0.0, math.pi, math.radians(135.0)])
def test_waves_are_met_at_the_frequency_of_encounter(speed_mps: float, towards_rad: float) -> None:
    """ω_e = |ω − k U cos β|."""
    omega = 2.5
    met = abs(omega - omega**2 / 9.81 * speed_mps * math.cos(towards_rad))
    rows = led(regular(0.1, omega, towards_rad), speed_mps)
    assert crossings_radps([row[2] for row in rows]) == pytest.approx(met, rel=0.01)


def test_in_long_waves_the_boat_moves_as_the_water() -> None:
    """A circle of the waves' amplitude (Airy), the slope of the surface; no thruster and no damping is felt."""
    amplitude, omega = 0.1, 0.4  # 385 m long
    hull = Hull(HULL)
    sea, rows = sea_of(regular(amplitude, omega, NORTH), hull, drift=False), []
    for k in range(6000):
        sea.update(k * DT_S)
        hull.step_in_waves(0.0, 0.0, 0.0, DT_S, sea.orbit)
        rows.append((hull.north_m, hull.east_m, sea.heave_m, sea.pitch_rad, hull.water_surge_mps, hull.surge_mps2))
    norths, easts, heaves, pitches, through, felt = (np.array(column) for column in zip(*rows, strict=True))
    assert 0.5 * np.ptp(norths) == pytest.approx(amplitude, rel=0.02)
    assert np.ptp(easts) == pytest.approx(0.0, abs=1e-9)
    assert 0.5 * np.ptp(heaves) == pytest.approx(amplitude, rel=0.02)
    assert 0.5 * np.ptp(pitches) == pytest.approx(amplitude * omega**2 / 9.81, rel=0.02)
    assert 0.5 * np.ptp(felt[1:]) == pytest.approx(amplitude * omega**2, rel=0.02)
    assert np.abs(through).max() < 1e-6


def test_in_short_waves_it_lies_still_by_length_and_by_beam() -> None:
    """Waves as long as the boat pass under it from ahead, but push it from the side; as long as the beam, neither."""
    number_by_length, number_by_beam = math.tau / BOAT.length_m, math.tau / BOAT.beam_m

    def share(number: float, beta: float) -> float:
        one, omega = np.array([number]), np.array([math.sqrt(9.81 * number)])
        return float(followed(BOAT, Met(one, omega, omega, np.cos([beta]), np.sin([beta])))[0])

    assert share(number_by_length, 0.0) == pytest.approx(0.0, abs=1e-9)
    assert share(number_by_length, EAST) > 0.7
    assert share(number_by_beam, EAST) == pytest.approx(0.0, abs=1e-9)
    assert share(0.01, 0.7) == pytest.approx(1.0, abs=0.01)


def test_beam_seas_roll_and_head_seas_pitch_and_quartering_ones_yaw() -> None:
    head, beam = led(regular(0.1, 2.5, math.pi), 0.0), led(regular(0.1, 2.5, EAST), 0.0)
    head_pitch, head_roll = (np.std([row[i] for row in head]) for i in (2, 0))
    beam_pitch, beam_roll = (np.std([row[i] for row in beam]) for i in (2, 0))
    assert head_pitch > 0.02 and head_roll < 1e-9 and beam_roll > 0.02 and beam_pitch < 1e-9
    turned = []
    for towards in (math.pi, math.radians(135.0), EAST):
        sea = sea_of(regular(0.1, 2.5, towards), Hull(HULL))
        rates = []
        for k in range(1000):
            sea.update(k * DT_S)
            rates.append(sea.orbit[2])
        turned.append(float(np.std(rates)))
    assert turned[1] > 0.02 and turned[0] == pytest.approx(0.0, abs=1e-9) and turned[2] == pytest.approx(0.0, abs=1e-9)


def test_the_side_towards_a_crest_rises() -> None:
    """Surface higher to starboard: roll to port; higher ahead: bow up."""
    number = 0.4**2 / 9.81
    for towards, row in ((EAST, 0), (NORTH, 2)):
        rows = led(regular(0.5, 0.4, towards), 0.0, duration_s=16.0)
        slope = [0.5 * number * math.sin(0.4 * k * DT_S + 0.3) for k in range(len(rows))]
        sign = -1.0 if row == 0 else 1.0
        got = [one[row] for one in rows]
        assert np.corrcoef(got, slope)[0, 1] * sign > 0.99


def test_heave_is_the_integral_of_its_rate_and_acceleration() -> None:
    rows = led(components(SeaState(0.3, None, 2.3), 1.0, 3), 0.0, duration_s=30.0)
    heave, rate, acceleration = (np.array([row[i] for row in rows]) for i in (4, 5, 6))
    assert np.gradient(heave, DT_S)[1:-1] == pytest.approx(rate[1:-1], abs=2e-3)
    assert np.gradient(rate, DT_S)[1:-1] == pytest.approx(acceleration[1:-1], abs=2e-2)


@pytest.mark.parametrize("rate_radps", [0.0, 0.4])
def test_rates_lead_from_attitude_to_attitude_also_in_a_turn(rate_radps: float) -> None:
    """Rates that leave the turning of the hull among the waves out had an inertial filter believe in tilt that was not
    there."""
    hull = Hull(HULL)
    sea, rows = sea_of(components(SeaState(0.3, None, 2.3), 1.0, 3), hull), []
    for k in range(3000):
        hull.place(0.0, 0.0, rate_radps * k * DT_S)
        sea.update(k * DT_S)
        rows.append((sea.roll_rad, sea.roll_rate_radps, sea.pitch_rad, sea.pitch_rate_radps))
    for angle, rate in ((0, 1), (2, 3)):
        total = sum(row[rate] for row in rows[1:]) * DT_S
        assert total == pytest.approx(rows[-1][angle] - rows[0][angle], abs=1e-9)
    assert max(abs(row[1]) for row in rows) < 2.0  # no steps


def test_what_an_inertial_sensor_adds_up_ends_where_the_boat_is() -> None:
    hull = Hull(HULL)
    hull.place(0.0, 0.0, 0.4)
    sea = sea_of(components(SeaState(0.3, None, 2.3), 1.0, 5), hull)
    sea.update(0.0)
    hull.step_in_waves(0.0, 0.0, 0.0, DT_S, sea.orbit)
    north, east, yaw = hull.north_mps, hull.east_mps, hull.yaw_rad
    north_m, east_m = hull.north_m, hull.east_m
    for k in range(1, 6000):
        sea.update(k * DT_S)
        hull.step_in_waves(*sea.force(), DT_S, sea.orbit)
        middle = yaw + 0.5 * DT_S * hull.turn_radps
        yaw += DT_S * hull.turn_radps
        c, s = math.cos(middle), math.sin(middle)
        before = north, east
        north += DT_S * (c * hull.surge_mps2 - s * hull.sway_mps2)
        east += DT_S * (s * hull.surge_mps2 + c * hull.sway_mps2)
        north_m, east_m = north_m + 0.5 * DT_S * (north + before[0]), east_m + 0.5 * DT_S * (east + before[1])
    assert math.dist((north_m, east_m), (hull.north_m, hull.east_m)) < 0.02
    assert math.remainder(yaw - hull.yaw_rad, math.tau) == pytest.approx(0.0, abs=1e-6)


# --- drift -----------------------------------------------------------------------------------------------------------


def test_short_beam_waves_drift_it_by_the_formula() -> None:
    """½ρg R² A² L, on the parallel sides of a barge; from ahead over its beam; nothing in long waves."""
    barge = WaveHull(3.0, 0.72, 0.72, 0.23, 4.3, 440.0, blunt=True)
    for towards, index, width in ((EAST, 1, barge.length_m), (NORTH, 0, barge.beam_m)):
        for omega, share in ((20.0, 1.0), (0.3, 0.0)):
            sea = sea_of(regular(0.05, omega, towards), Hull(HULL), barge)
            sea.update(0.0)
            short = 0.5 * 1025.0 * 9.81 * REFLECTED * 0.05**2 * width
            assert sea.force()[index] == pytest.approx(share * short, abs=0.01 * short)


def test_against_the_waves_the_drift_grows_with_speed() -> None:
    """1 + 2 ω U/g (Faltinsen et al. 1980)."""
    waves, forces = regular(0.05, 6.0, math.pi), []
    for speed_mps in (0.0, 2.0):
        hull = Hull(HULL)
        hull.place(0.0, 0.0, 0.0, speed_mps)
        sea = sea_of(waves, hull)
        sea.update(0.0)
        forces.append(sea.force()[0])
    assert forces[1] / forces[0] == pytest.approx(1.0 + 2.0 * 6.0 * 2.0 / 9.81, rel=1e-6)


def test_newman_s_sum_against_the_double_sum() -> None:
    """Σ_j Σ_k a_j a_k ½(T_j + T_k) cos(θ_j − θ_k), written out; and its mean over half an hour, Σ a² T."""
    waves = components(SeaState(0.2, None, 1.88), math.radians(60.0), 4)
    hull = Hull(HULL)
    hull.place(3.0, -2.0, 0.3)
    sea = sea_of(waves, hull)
    beside = waves.towards_rad - 0.3
    met = Met(waves.number_radpm, waves.omega_radps, waves.omega_radps, np.cos(beside), np.sin(beside))
    table = DriftTable(BOAT).coefficients(BOAT, met, 0.0, 0.0)
    forces = []
    for k in range(18_000):
        t_s = 0.1 * k
        sea.update(t_s)
        forces.append(sea.force())
        if k % 3600:
            continue
        north, east = np.cos(waves.towards_rad), np.sin(waves.towards_rad)
        theta = waves.omega_radps * t_s - waves.number_radpm * (3.0 * north - 2.0 * east) + waves.phase_rad
        for force, row in zip(forces[-1], table, strict=True):
            summed = 0.0
            for a, t_a, theta_a in zip(waves.amplitude_m, row, theta, strict=True):
                for b, t_b, theta_b in zip(waves.amplitude_m, row, theta, strict=True):
                    summed += a * b * 0.5 * (t_a + t_b) * math.cos(theta_a - theta_b)
            assert force == pytest.approx(summed, rel=1e-9, abs=1e-9)
    means = np.mean(forces, axis=0)
    assert means == pytest.approx((waves.amplitude_m**2 * table).sum(axis=1), rel=0.05, abs=0.05)
    assert np.std(forces, axis=0)[1] > 0.3 * abs(means[1])  # groups of waves


def test_drift_can_be_left_out() -> None:
    sea = sea_of(regular(0.05, 6.0, EAST), Hull(HULL), drift=False)
    sea.update(0.0)
    assert sea.force() == (0.0, 0.0, 0.0)


def test_in_a_turn_the_rates_do_not_jump() -> None:
    """Ten times a second the response to the waves took another direction: its rate jumped by 1 rad/s within a sample, and an
    antenna beside the inertial sensor had another velocity than that told."""
    hull = Hull(HULL)
    waves = components(SeaState(0.25, EAST, 2.1), EAST, seed=3)
    sea, rates = sea_of(waves, hull), []
    for k in range(1200):
        yaw_rad = 0.37 * k * DT_S
        hull.place(8.0 / 0.37 * math.sin(yaw_rad), 8.0 / 0.37 * (1.0 - math.cos(yaw_rad)), yaw_rad, 8.0)
        sea.update(k * DT_S)
        rates.append(sea.roll_rate_radps)
    steps = [abs(b - a) for a, b in itertools.pairwise(rates[10:])]
    assert max(steps) < 0.3
