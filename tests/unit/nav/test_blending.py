"""Several receivers by weight: where their mean is, and that none comes or goes with a step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import pytest

from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, GnssFix, GroundVelocity, Heading, Imu, Reading
from companion.nav.blending import ReceiverBlend
from tests.unit.nav.boat_truth import Passage, Voyage, config_of, navigate

DT_S = 0.1
Spot = Callable[[float], float | None]
"""Where a receiver says that the boat is, northward; None: it is silent."""


class Afloat:
    """A filter that goes to each fix by its weight, and the blend before it."""

    def __init__(self, sigmas_m: Mapping[str, float]) -> None:
        self.blend, self.sigmas_m = ReceiverBlend(), sigmas_m
        self.north_m, self.now_s = 0.0, 0.0
        self.slow_sigma_m = 0.0

    def go(self, seconds: float, spots: Mapping[str, Spot]) -> list[float]:
        seen = []
        for _ in range(round(seconds / DT_S)):
            self.now_s += DT_S
            leads = next((name for name, spot in spots.items() if spot(self.now_s) is not None), None)
            for name, spot in spots.items():
                north, sigma = spot(self.now_s), self.sigmas_m[name]
                if north is None:
                    continue
                off = north - self.north_m, 0.0
                offset = self.blend.update(name, self.now_s, off, sigma, 0.7 * sigma, name == leads)
                if offset is not None:
                    self.north_m += 0.02 / sigma**2 * (off[0] - offset.north_m)
                    self.slow_sigma_m = offset.slow_sigma_m
            seen.append(self.north_m)
        return seen


def test_one_receiver_alone_is_taken_as_it_is() -> None:
    boat = Afloat({"a": 1.0})
    assert boat.go(60.0, {"a": lambda _: 0.8})[-1] == pytest.approx(0.8, abs=0.01)
    assert boat.slow_sigma_m == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize("sigmas", [(1.0, 1.0), (0.5, 1.0)])
def test_two_meet_at_their_mean_by_inverse_variance(sigmas: tuple[float, float]) -> None:
    boat = Afloat({"a": sigmas[0], "b": sigmas[1]})
    share = sigmas[0] ** -2 / (sigmas[0] ** -2 + sigmas[1] ** -2)
    last = boat.go(200.0, {"a": lambda _: 0.0, "b": lambda _: 2.0})[-1]
    assert last == pytest.approx(2.0 * (1.0 - share), abs=0.02)


def test_none_comes_or_goes_with_a_step() -> None:
    """The mean moves by a metre each time, no faster than 8 cm/s."""
    boat = Afloat({"a": 1.0, "b": 1.0})
    seen = boat.go(300.0, {"a": lambda t_s: None if t_s > 200.0 else 0.0, "b": lambda t_s: 2.0 if t_s > 50.0 else None})
    assert seen[int(49.0 / DT_S)] == pytest.approx(0.0, abs=0.01)
    assert seen[int(199.0 / DT_S)] == pytest.approx(1.0, abs=0.02)
    assert seen[-1] == pytest.approx(2.0, abs=0.05)
    assert max(abs(np.diff(seen))) < 0.08 * DT_S


def test_the_accuracy_knows_what_is_still_to_be_absorbed() -> None:
    boat = Afloat({"a": 1.0, "b": 1.0})
    both = {"a": lambda t_s: 0.0 if t_s < 100.0 else None, "b": lambda _: 4.0}
    boat.go(99.0, both)
    settled = boat.slow_sigma_m
    boat.go(5.0, both)
    assert settled == pytest.approx(0.7, abs=0.02) and boat.slow_sigma_m > 1.5
    boat.go(100.0, both)
    assert boat.slow_sigma_m == pytest.approx(0.7, abs=0.05)


def test_another_kind_of_fix_begins_where_the_boat_is() -> None:
    """What a receiver was off by went with the kind of fix; what it is off by now is followed as ever."""
    boat = Afloat({"a": 1.0, "b": 1.0})
    boat.go(100.0, {"a": lambda _: -2.0, "b": lambda _: 2.0})
    before_m = boat.north_m
    offset = boat.blend.update("a", boat.now_s + DT_S, (5.0 - before_m, 0.0), 1.0, 0.7, True, anew=True)
    assert offset is not None
    assert 5.0 - before_m - offset.north_m == pytest.approx(0.0, abs=0.05)


# --- in the estimator -------------------------------------------------------------------------------------------------

VOYAGE = Voyage(duration_s=180.0, speed_mps=0.5, seed=3)
SPARE_S = 8.0  # when the second begins
FRAME = LocalFrame(config_of(VOYAGE).home.lat_deg, config_of(VOYAGE).home.lon_deg)


def pair(first_m: float, second_m: float, lost_s: float, blend: float) -> Passage:
    """Two SBAS receivers whose slow errors are those distances to the north; the first is lost at that time."""
    config = config_of(VOYAGE)
    gnss, imu = config.sensors
    config = replace(config, sensors=(gnss, replace(gnss, name="spare"), imu))

    def moved(reading: Reading, metres: float) -> Reading:
        if not isinstance(reading, GnssFix):
            return reading
        north, east = FRAME.to_ned(reading.lat_deg, reading.lon_deg)
        lat, lon = FRAME.to_geodetic(north + metres, east)
        return replace(reading, lat_deg=lat, lon_deg=lon, fix=FixType.DGPS, position_accuracy_m=0.5)

    def both(_: int, row: list[Reading]) -> list[Reading]:
        said = [reading for reading in row if not isinstance(reading, GnssFix | GroundVelocity)]
        for reading in row:
            if isinstance(reading, GnssFix | GroundVelocity):
                if reading.t_s < lost_s:
                    said.append(moved(reading, first_m))
                if reading.t_s > SPARE_S:
                    said.append(replace(moved(reading, second_m), source="spare"))
        return [reading for reading in said if not (isinstance(reading, Heading) and reading.source == "spare")]

    return navigate(VOYAGE, both, config=config, parameters={"NAV_BLEND": blend})


def off(passage: Passage) -> np.ndarray:
    return np.array(
        [s.north_m - passage.truth.position[k, 0] for s, k in zip(passage.states, passage.rows, strict=True)]
    )


def test_the_estimate_is_between_them_and_makes_no_step_where_one_is_lost() -> None:
    error = off(pair(0.6, -0.4, 140.0, 1.0))
    assert -0.2 < np.mean(error[1200:1395]) < 0.4  # the first came first, and the filter holds on to it
    assert np.abs(error[1430] - error[1395]) < 0.15
    assert error[-1] < np.mean(error[1200:1395]) - 0.1


def test_without_blending_the_first_alone_counts() -> None:
    error = off(pair(0.6, -0.4, 1e9, 0.0))
    assert np.mean(error[1200:1395]) == pytest.approx(0.6, abs=0.08)


@pytest.mark.parametrize("plain_s", [(0.0, 30.0), (30.0, 40.0)])
def test_both_come_back_to_carrier_phase_without_the_offsets_of_plain_fixes(plain_s: tuple[float, float]) -> None:
    voyage = replace(VOYAGE, duration_s=60.0)
    gnss, imu = config_of(voyage).sensors
    config = replace(config_of(voyage), sensors=(gnss, replace(gnss, name="spare"), imu))

    def said(fix: GnssFix, plain_m: float) -> GnssFix:
        if not plain_s[0] <= fix.t_s < plain_s[1]:
            return fix
        north, east = FRAME.to_ned(fix.lat_deg, fix.lon_deg)
        lat, lon = FRAME.to_geodetic(north + plain_m, east)
        return replace(fix, lat_deg=lat, lon_deg=lon, fix=FixType.DGPS, position_accuracy_m=0.5)

    def both(_: int, row: list[Reading]) -> list[Reading]:
        fixes = [reading for reading in row if isinstance(reading, GnssFix)]
        others = [reading for reading in row if not isinstance(reading, GnssFix)]
        spare = [replace(said(fix, -0.6), source="spare") for fix in fixes]
        return [*others, *(said(fix, 0.8) for fix in fixes), *spare]

    passage = navigate(voyage, both, config=config)
    after = passage.errors(plain_s[1] + 2.0)[0]
    assert after.max() < 0.06
    assert passage.states[-1].position_accuracy_m < 0.03


def test_one_receiver_costs_and_changes_nothing() -> None:
    """Bit for bit."""
    one, other = (navigate(Voyage(duration_s=20.0), parameters={"NAV_BLEND": v}).states[-1] for v in (0.0, 1.0))
    assert (one.north_m, one.east_m, one.yaw_rad) == (other.north_m, other.east_m, other.yaw_rad)
    assert math.isfinite(one.position_accuracy_m) and one.position_accuracy_m == other.position_accuracy_m


@pytest.mark.parametrize(("first_s", "second_s", "limit_m"), [(0.3, 0.0, 0.1), (0.0, 0.3, 0.1), (0.0, 0.0, 0.1)])
def test_how_late_one_is_says_nothing_of_the_other(first_s: float, second_s: float, limit_m: float) -> None:
    """At 3 m/s and with carrier phase, values that are later than the file says; the latency that the filter found for
    the first was taken off the second, too: the boat was 0.6 m off, whichever of them was late."""
    voyage = Voyage(duration_s=50.0, speed_mps=3.0, radius_m=15.0, rests_s=10.0, seed=3)
    config = config_of(voyage)
    gnss, imu = config.sensors
    gnss = replace(gnss, latency_accuracy_s=0.15)
    config = replace(config, sensors=(gnss, replace(gnss, name="spare"), imu))
    rows: list[list[Reading]] = []

    def late(k: int, row: list[Reading]) -> list[Reading]:
        rows.append([reading for reading in row if not isinstance(reading, Imu)])
        said = [reading for reading in row if isinstance(reading, Imu)]
        for source, late_s in (("gnss", first_s), ("spare", second_s)):
            then = k - round(100 * late_s)
            said += [replace(one, t_s=one.t_s + late_s, source=source) for one in (rows[then] if then >= 0 else ())]
        return said

    position, _, _ = navigate(voyage, late, config=config).errors(12.0)
    assert position.max() < limit_m
