"""LocalFrame against geographiclib's geodesics."""

import math

import pytest
from geographiclib.geodesic import Geodesic

from companion.core.geodesy import LocalFrame, distance_and_bearing, rough_distance_and_bearing


@pytest.mark.parametrize("lat_deg", [-60.0, 0.0, 43.0, 63.4389, 80.0])
@pytest.mark.parametrize("azimuth_deg", range(0, 360, 30))
@pytest.mark.parametrize(("distance_m", "tolerance_m"), [(10.0, 1e-6), (1000.0, 1e-4), (10_000.0, 0.05)])
def test_local_plane_agrees_with_geodesics(
    lat_deg: float, azimuth_deg: float, distance_m: float, tolerance_m: float
) -> None:
    end = Geodesic.WGS84.Direct(lat_deg, 10.399, azimuth_deg, distance_m)
    north_m, east_m = LocalFrame(lat_deg, 10.399).to_ned(end["lat2"], end["lon2"])
    assert north_m == pytest.approx(distance_m * math.cos(math.radians(azimuth_deg)), abs=tolerance_m)
    assert east_m == pytest.approx(distance_m * math.sin(math.radians(azimuth_deg)), abs=tolerance_m)


@pytest.mark.parametrize("point", [(0.0, 0.0), (20.0, -35.0), (-4000.0, 9000.0), (30_000.0, 30_000.0)])
def test_there_and_back(point: tuple[float, float]) -> None:
    frame = LocalFrame(63.4389, 10.3990)
    assert frame.to_ned(*frame.to_geodetic(*point)) == pytest.approx(point, abs=1e-3)


def test_across_the_date_line() -> None:
    north_m, east_m = LocalFrame(0.0, 179.9999).to_ned(0.0, -179.9999)
    assert (north_m, east_m) == (pytest.approx(0.0, abs=1e-6), pytest.approx(22.264, abs=0.01))
    assert LocalFrame(0.0, 179.9999).to_geodetic(0.0, 22.264)[1] == pytest.approx(-179.9999, abs=1e-6)


@pytest.mark.parametrize("end", [(63.45, 10.41), (60.43, 22.16), (-33.9, 18.4), (0.0, 0.0), (63.0, -179.0)])
def test_a_rough_distance_is_within_six_thousandths(end: tuple[float, float]) -> None:
    exact_m, exact_rad = distance_and_bearing(63.4389, 10.3990, *end)
    rough_m, rough_rad = rough_distance_and_bearing(63.4389, 10.3990, *end)
    assert rough_m == pytest.approx(exact_m, rel=0.006)
    assert math.remainder(rough_rad - exact_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=0.02)
    assert rough_distance_and_bearing(*end, *end)[0] == 0.0


@pytest.mark.parametrize("lat_deg", [-60.0, 0.0, 63.4389, 80.0])
@pytest.mark.parametrize("azimuth_deg", range(0, 360, 45))
@pytest.mark.parametrize("length_m", [10.0, 500.0, 19_000.0])
def test_a_rough_distance_is_right_near_by(lat_deg: float, azimuth_deg: float, length_m: float) -> None:
    end = Geodesic.WGS84.Direct(lat_deg, 179.99, azimuth_deg, length_m)
    rough_m, _ = rough_distance_and_bearing(lat_deg, 179.99, end["lat2"], end["lon2"])
    assert rough_m == pytest.approx(length_m, rel=1e-4)


def test_distance_and_bearing() -> None:
    distance_m, bearing_rad = distance_and_bearing(63.0, 10.0, 63.0, 10.01)
    vertical_radius_m = 6378137.0 / math.sqrt(1.0 - 0.00669437999 * math.sin(math.radians(63.0)) ** 2)
    assert distance_m == pytest.approx(vertical_radius_m * math.cos(math.radians(63.0)) * math.radians(0.01), abs=1e-3)
    assert math.degrees(bearing_rad) == pytest.approx(90.0, abs=0.01)
