"""Sensors that lie, as the emulators print it."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import ConfigError, find, load
from companion.core.geodesy import LocalFrame
from sitl.faults import Fault, Faults, parse
from sitl.lie_table import IMU_AXES, LIES
from sitl.lies import DepthLies, GnssLies, HeadingLies, ImuLies, WindLies
from sitl.sensors import GRADES, GnssSample, ImuSample

VESSEL = load(find("revolt"))
FRAME = LocalFrame(VESSEL.home.lat_deg, VESSEL.home.lon_deg)
AT_S = 10.0


def faults(*texts: str, now_s: float = AT_S) -> Faults:
    made = Faults(texts, VESSEL)
    made.update(now_s)
    return made


def sample(k: int = 0) -> GnssSample:
    lat, lon = FRAME.to_geodetic(0.1 * k, -0.2 * k)
    return GnssSample(GRADES["rtk"], (lat, lon, 3.0), 0.1, -0.2, 0.5 + 0.01 * k)


def liar(*texts: str, device: str = "gnss") -> tuple[Faults, GnssLies]:
    made = faults(*texts, now_s=0.0)
    return made, GnssLies(made, device, VESSEL.home, 1)


def told(text: str, age_s: float = 4.0, device: str = "gnss") -> tuple[float, float, GnssSample]:
    """How far the position is off, and the solution, `age_s` into the lie."""
    made, lies = liar(f"{text}@{AT_S}", device=device)
    lies.told(sample(0), AT_S - 0.05)
    made.update(AT_S + age_s)
    after = lies.told(sample(1), AT_S + age_s)
    assert after.position is not None
    north, east = FRAME.to_ned(*after.position[:2])
    return north - 0.1, east + 0.2, after


def test_parse_with_size_and_device() -> None:
    assert parse("gnss_jump=5@60+9", VESSEL) == Fault("gnss_jump", 60.0, 69.0, 5.0)
    assert parse("gnss_jump@60", VESSEL).size == 25.0
    assert parse("gnss_jump:gnss=-5@60", VESSEL) == Fault("gnss_jump", 60.0, math.inf, -5.0, "gnss")


@pytest.mark.parametrize(
    "text, why",
    [
        ("gnss_jump=@60", "NAME=SIZE"),
        ("gnss_jump=far@60", "NAME=SIZE"),
        ("gnss_jump=nan@60", "NAME=SIZE"),
        ("gnss_jump:kraken@60", "no sensor named 'kraken'; there is gnss, imu"),
        ("leak=3@60", "takes neither"),
        ("leak:gnss@60", "takes neither"),
    ],
)
def test_a_lie_badly_written_says_how(text: str, why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        parse(text, VESSEL)


@pytest.mark.parametrize(
    "text, distance_m, speed_mps",
    [
        ("gnss_jump=5", 5.0, 0.0),
        ("gnss_jump", 25.0, 0.0),
        ("position_creep", 2.0, 0.0),
        ("gnss_spoof", 2.0, 0.5),
        ("gnss_pull", 0.4, 0.2),
        ("velocity_off=1", 0.0, 1.0),
    ],
)
def test_positions_and_velocities_to_the_north_east(text: str, distance_m: float, speed_mps: float) -> None:
    north, east, after = told(text)
    assert (north, east) == pytest.approx((distance_m / math.sqrt(2.0),) * 2, abs=1e-3)
    assert (after.north_mps - 0.1, after.east_mps + 0.2) == pytest.approx((speed_mps / math.sqrt(2.0),) * 2)


def test_only_the_device_that_is_named_lies() -> None:
    assert told("gnss_jump:gnss=5")[0] == pytest.approx(5.0 / math.sqrt(2.0), abs=1e-3)
    assert told("gnss_jump:imu=5")[0] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("name", ["gnss_frozen", "position_frozen", "velocity_frozen", "heading_frozen"])
def test_what_repeats_and_what_goes_on(name: str) -> None:
    made, lies = liar(f"{name}@{AT_S}")
    before = lies.told(sample(0), AT_S - 0.05)
    made.update(AT_S)
    fresh = GnssSample(GRADES["rtk"], sample(5).position, 0.3, 0.4, 0.9)
    for k in range(3):
        after = lies.told(fresh, AT_S + 0.05 * k)
        assert (after.position == before.position) is (name in ("gnss_frozen", "position_frozen"))
        assert (after.north_mps == before.north_mps) is (name in ("gnss_frozen", "velocity_frozen"))
        assert (after.heading_rad == before.heading_rad) is (name in ("gnss_frozen", "heading_frozen"))


def test_headings_turned_and_creeping() -> None:
    assert told("heading_turned")[2].heading_rad == pytest.approx(0.51 - math.pi)
    assert told("heading_creep=2")[2].heading_rad == pytest.approx(0.51 + math.radians(8.0))
    compass = HeadingLies(faults("heading_turned=90@0"), "compass")
    assert compass.told(0.0, AT_S) == pytest.approx(math.pi / 2)


def test_headings_with_noise_that_nothing_reports() -> None:
    made = faults("heading_noise=20@0")
    compass, again = HeadingLies(made, "imu", 7), HeadingLies(made, "imu", 7)
    off = [compass.told(1.0, 1.0) - 1.0 for _ in range(400)]
    assert math.degrees(math.sqrt(sum(one * one for one in off) / len(off))) == pytest.approx(20.0, rel=0.15)
    assert again.told(1.0, 1.0) - 1.0 == off[0], "by the seed"
    assert told("heading_noise")[2].heading_rad not in (None, sample(1).heading_rad)


def test_noise_that_the_accuracy_does_not_show() -> None:
    made, lies = liar("accuracy_lie=0.5@0")
    made.update(AT_S)
    norths = []
    for _ in range(400):
        after = lies.told(sample(), AT_S)
        assert after.grade == GRADES["rtk"] and after.position is not None
        norths.append(FRAME.to_ned(*after.position[:2])[0])
    assert math.sqrt(sum(n * n for n in norths) / len(norths)) == pytest.approx(0.5, rel=0.1)


def test_absolute_time() -> None:
    made, lies = liar("time_jump=3@10", "time_fast=0.1@20")
    assert lies.time_off_s(5.0) == 0.0
    made.update(25.0)
    assert lies.time_off_s(25.0) == pytest.approx(3.5)


def test_the_last_sentences_come_again_with_their_time() -> None:
    made, lies = liar(f"gnss_stale@{AT_S}")
    before = lies.told(sample(0), AT_S - 0.05)
    assert lies.time_off_s(AT_S - 0.05) == 0.0
    made.update(AT_S + 3.0)
    assert lies.told(sample(5), AT_S + 3.0) == before
    assert lies.time_off_s(AT_S + 3.0) == pytest.approx(-3.05)


def test_places_that_cannot_be() -> None:
    position = told("gnss_mirrored")[2].position
    assert position is not None and position[0] == -FRAME.to_geodetic(0.1, -0.2)[0]
    position = told("altitude_off=50")[2].position
    assert position is not None and position[2] == 53.0


IMU: ImuSample = (1.0, 2.0, 3.0, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03)
NEXT: ImuSample = (1.5, 2.5, 3.5, 0.4, 0.5, 0.6, 0.02, 0.03, 0.04)


@pytest.mark.parametrize("axis", IMU_AXES)
def test_one_axis_of_an_inertial_sensor(axis: str) -> None:
    at = IMU_AXES.index(axis)
    for kind, expected in (("stuck", IMU[at]), ("reversed", -NEXT[at])):
        made = faults(f"imu_{axis}_{kind}@10", now_s=0.0)
        lies = ImuLies(made, "imu")
        assert lies.told(IMU, 9.9) == IMU
        made.update(10.0)
        said = lies.told(NEXT, 10.0)
        assert said[at] == expected
        assert said[:at] + said[at + 1 :] == NEXT[:at] + NEXT[at + 1 :]
    scaled = ImuLies(faults(f"imu_{axis}_scaled=0.8@0"), "imu").told(NEXT, 10.0)
    assert scaled[at] == pytest.approx(0.8 * NEXT[at]) and scaled[6:] == NEXT[6:]
    biased = ImuLies(faults(f"imu_{axis}_biased=2@0"), "imu").told(NEXT, 10.0)
    assert biased[at] - NEXT[at] == pytest.approx(2.0 if at < 3 else math.radians(2.0))


def test_a_whole_sample_repeats() -> None:
    made = faults("imu_repeats@10", now_s=0.0)
    lies = ImuLies(made, "imu")
    lies.told(IMU, 9.9)
    made.update(10.0)
    assert lies.told(NEXT, 10.0) == lies.told(NEXT, 10.1) == IMU


def test_forces_end_where_the_range_does() -> None:
    assert ImuLies(faults("imu_clipped=2@0"), "imu").told((-9.0, 1.0, -9.8, *NEXT[3:]), 10.0)[:3] == (-2.0, 1.0, -2.0)


def test_the_clock_of_an_inertial_sensor() -> None:
    lies = ImuLies(faults("imu_clock_jump=2@0", "imu_clock_fast=0.1@0"), "imu")
    assert lies.clock_off_s(AT_S) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("lie", "expected"), [("imu_doubled", b"aabbccdd"), ("imu_swapped", b"badc"), ("imu_repeats", b"abcd")]
)
def test_messages_that_come_twice_or_in_another_order(lie: str, expected: bytes) -> None:
    lies = ImuLies(faults(f"{lie}@0"), "imu")
    assert b"".join(part for one in (b"a", b"b", b"c", b"d") for part in lies.sent(one)) == expected


def test_a_message_that_waits_for_another_comes_when_the_lie_is_over() -> None:
    made = faults("imu_swapped@0+10", now_s=5.0)
    lies = ImuLies(made, "imu")
    assert list(lies.sent(b"a")) == []
    made.update(AT_S)
    assert list(lies.sent(b"b")) == [b"b", b"a"] and list(lies.sent(b"c")) == [b"c"]


def test_winds_of_another_side_and_unit() -> None:
    speed_mps, angle_rad = WindLies(faults("wind_scaled=2@0", "wind_turned=90@0"), "wind").told(3.0, 0.1)
    assert (speed_mps, angle_rad) == pytest.approx((6.0, 0.1 + math.pi / 2))


def test_depths_that_repeat_and_are_feet() -> None:
    made = faults("depth_scaled=3@0", "depth_frozen@10", now_s=5.0)
    lies = DepthLies(made, "imu")
    assert lies.told(2.0) == 6.0
    made.update(10.0)
    assert lies.told(1.0) == 6.0


def test_wind_repeats() -> None:
    made = faults("wind_frozen@10", now_s=0.0)
    lies = WindLies(made, "wind")
    assert lies.told(3.0, 0.1) == (3.0, 0.1)
    made.update(10.0)
    assert lies.told(4.0, 0.2) == (3.0, 0.1)


def test_every_lie_has_a_text() -> None:
    assert all(lie.text for lie in LIES.values())
