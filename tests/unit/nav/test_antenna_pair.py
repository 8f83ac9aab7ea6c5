"""Heading from the positions of two receivers: its accuracy, and what gives none."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, GnssFix, GroundVelocity, Heading, Reading
from companion.nav.antenna_pair import AntennaPair
from companion.nav.lever_arms import Vector, rotate, rotation
from companion.nav.lever_arms import quaternion_of as attitude
from tests.unit.nav.boat_truth import Passage, Voyage, config_of, navigate, rms, sail

VOYAGE = Voyage(duration_s=90.0, seed=8)
CONFIG = config_of(VOYAGE)
GNSS = CONFIG.sensors[0]
BOW, STERN = replace(GNSS, name="bow", x_m=1.0, y_m=0.3, z_m=-0.5), replace(GNSS, name="stern", x_m=-1.0, y_m=-0.2)
BOW = replace(BOW, heading_with="stern")
STILL, LEVEL = (0.0, 0.0), (0.0, 0.0)


def fix(source: str, t_s: float = 0.0, kind: FixType = FixType.RTK_FIXED) -> GnssFix:
    return GnssFix(t_s, source, 0.0, 0.0, None, kind, 14, 0.8)


def places(yaw_rad: float, tilt: tuple[float, float] = LEVEL) -> dict[str, tuple[float, float]]:
    matrix = rotation(attitude(*tilt, yaw_rad))
    found = {}
    for row in (BOW, STERN):
        lever: Vector = (row.x_m, row.y_m, row.z_m)
        found[row.name] = rotate(matrix, lever)[:2]
    return found


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, -2.5, math.pi])
@pytest.mark.parametrize("tilt", [LEVEL, (0.2, -0.1)])
def test_the_heading_follows_from_two_places(yaw_rad: float, tilt: tuple[float, float]) -> None:
    pair, at = AntennaPair(BOW, STERN), places(yaw_rad, tilt)
    assert pair.take(fix("bow"), at["bow"], STILL, tilt, 0.02) is None
    heading = pair.take(fix("stern"), at["stern"], STILL, tilt, 0.02)
    assert heading is not None and heading.source == "bow+stern"
    assert math.remainder(heading.yaw_rad - yaw_rad, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_its_sigma_is_that_of_the_fixes_over_the_baseline() -> None:
    draw, pair = random.Random(1), AntennaPair(BOW, STERN)
    errors, said = [], 0.0
    for k in range(2000):
        at = places(0.4)
        for name in ("bow", "stern"):
            north, east = at[name][0] + draw.gauss(0.0, 0.02), at[name][1] + draw.gauss(0.0, 0.02)
            heading = pair.take(fix(name, 0.1 * k), (north, east), STILL, LEVEL, 0.02)
            if heading is not None:
                errors.append(heading.yaw_rad - 0.4)
                said = heading.accuracy_rad or 0.0
    assert len(errors) > 1990
    assert math.sqrt(sum(e * e for e in errors) / len(errors)) == pytest.approx(said, rel=0.05)
    assert math.degrees(said) == pytest.approx(0.79, abs=0.02)


def test_fixes_of_two_moments_are_brought_to_one() -> None:
    """The boat makes 3 m/s to the east, and the second fix comes 40 ms later."""
    pair, at = AntennaPair(BOW, STERN), places(0.7)
    pair.take(fix("bow", 10.0), at["bow"], (0.0, 3.0), LEVEL, 0.02)
    north, east = at["stern"]
    heading = pair.take(fix("stern", 10.02), (north, east + 0.06), (0.0, 3.0), LEVEL, 0.02)
    assert heading is not None and heading.yaw_rad == pytest.approx(0.7, abs=1e-9)


@pytest.mark.parametrize(
    "second, place_m, sigma_m",
    [
        (fix("stern", 0.5), (0.0, 0.0), 0.02),
        (fix("stern", kind=FixType.DGPS), (0.0, 0.0), 0.02),
        (fix("stern"), (0.4, 0.0), 0.02),
        (fix("stern"), (0.0, 0.0), 0.3),
        (fix("spare"), (0.0, 0.0), 0.02),
    ],
    ids=["another moment", "no carrier phase", "a baseline that is too long", "too rough", "another receiver"],
)
def test_what_gives_no_heading(second: GnssFix, place_m: tuple[float, float], sigma_m: float) -> None:
    pair, at = AntennaPair(BOW, STERN), places(0.0)
    pair.take(fix("bow"), at["bow"], STILL, LEVEL, sigma_m)
    north, east = at["stern"]
    assert pair.take(second, (north - place_m[0], east - place_m[1]), STILL, LEVEL, sigma_m) is None


# --- in the estimator -------------------------------------------------------------------------------------------------


def sailed(lost_s: float = math.inf) -> Passage:
    """No heading but that of two receivers two metres apart; one of them is lost at that time."""
    gnss, imu = CONFIG.sensors
    other = replace(gnss, name="fore", x_m=gnss.x_m + 2.0, heading_with="gnss")
    motion = sail(VOYAGE)
    places_m = (motion.position + motion.rotation @ [other.x_m, other.y_m, other.z_m])[:, :2].tolist()
    frame, draw = LocalFrame(CONFIG.home.lat_deg, CONFIG.home.lon_deg), random.Random(2)

    def both(k: int, row: list[Reading]) -> list[Reading]:
        said = [reading for reading in row if not isinstance(reading, Heading)]
        for reading in row:
            if isinstance(reading, GnssFix) and reading.t_s < lost_s:
                north, east = places_m[k]
                lat, lon = frame.to_geodetic(north + draw.gauss(0.0, 0.02), east + draw.gauss(0.0, 0.02))
                said.append(replace(reading, source="fore", lat_deg=lat, lon_deg=lon))
        return [reading for reading in said if not isinstance(reading, GroundVelocity) or reading.source == "gnss"]

    config = replace(CONFIG, sensors=(gnss, other, imu))
    return navigate(VOYAGE, both, config=config)


def test_the_gyro_averages_it_to_a_third_of_a_degree() -> None:
    _, yaw, _ = sailed().errors(30.0)
    assert math.degrees(rms(yaw)) < 0.35


def test_the_gyro_carries_it_on_when_one_is_lost() -> None:
    passage = sailed(lost_s=60.0)
    _, yaw, _ = passage.errors(60.0, 75.0)
    assert math.degrees(rms(yaw)) < 0.6
    assert passage.states[-1].position_valid
