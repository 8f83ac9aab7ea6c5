"""What the emulated devices print, read by others' code or by the standard's own words."""

from __future__ import annotations

import math
import struct
from dataclasses import replace
from datetime import date, time

import pynmea2
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.config.devices import SensorConfig
from companion.config.vessel import find, load
from companion.core.actuation import Beacon, Deployment, Light
from companion.core.geodesy import LocalFrame
from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import (
    BoardCommand,
    BoardStatus,
    FrameDecoder,
    Ident,
    IdentRequest,
    ThrusterDemand,
    encode,
)
from sitl import emulators
from sitl.battery import BatteryModel
from sitl.emulators.device import SensedWorld
from sitl.emulators.gnss import GnssEmulator, degrees_minutes
from sitl.emulators.microcontroller import MicrocontrollerEmulator
from sitl.emulators.wind_sensor import WindEmulator
from sitl.emulators.xsens import XsensEmulator
from sitl.environment import Waves, WindModel
from sitl.faults import Fault, Faults
from sitl.hull import Hull
from sitl.memory import MemoryStream
from sitl.thrusters import ThrusterModel, build
from sitl.world import EPOCH_UNIX_NS

VESSEL = load(find("revolt"))
GNSS, IMU = VESSEL.sensors
assert VESSEL.sitl is not None
PLANT = VESSEL.sitl.plants["as_sailed"]
FRAME = LocalFrame(VESSEL.home.lat_deg, VESSEL.home.lon_deg)


def surroundings(gnss: str = "rtk", faults: tuple[str, ...] = (), wind: WindModel | None = None) -> SensedWorld:
    wind = wind or WindModel(0.0, 0.0, 0)
    active = Faults(faults, VESSEL)
    active.update(0.0)
    hull = Hull(PLANT.hull)
    return SensedWorld(hull, Waves(wind, 0), wind, active, VESSEL.home, gnss, 1, EPOCH_UNIX_NS, 100.0)


def printed(
    around: SensedWorld, config: SensorConfig = GNSS, t_s: float = 1.25
) -> tuple[dict[str, pynmea2.NMEASentence], float]:
    stream = MemoryStream("gnss")
    GnssEmulator(config, stream.device, around).speak(t_s)
    ((arrival_s, data),) = stream.read(1e6)
    lines = data.decode("ascii").splitlines()
    assert all(line.startswith("$") and line[-3] == "*" for line in lines)
    sentences = [pynmea2.parse(line, check=True) for line in lines]
    return {sentence.sentence_type: sentence for sentence in sentences}, arrival_s


def test_sentences_parse_and_say_where_the_antenna_is() -> None:
    around = surroundings()
    around.hull.place(100.0, -50.0, math.radians(200.0), 0.8)
    said, _ = printed(around, replace(GNSS, x_m=0.0, z_m=0.0))
    assert set(said) == {"GGA", "HDT", "VTG", "ZDA"}
    north, east = FRAME.to_ned(said["GGA"].latitude, said["GGA"].longitude)
    assert (north, east) == pytest.approx((100.0, -50.0), abs=0.05)
    assert (said["GGA"].gps_qual, int(said["GGA"].num_sats), float(said["GGA"].horizontal_dil)) == (4, 18, 0.6)
    assert float(said["HDT"].heading) == pytest.approx(200.0, abs=1.0)
    assert float(said["VTG"].true_track) == pytest.approx(200.0, abs=8.0)
    assert float(said["VTG"].spd_over_grnd_kmph) / 3.6 == pytest.approx(0.8, abs=0.1)
    assert float(said["VTG"].spd_over_grnd_kts) == pytest.approx(
        float(said["VTG"].spd_over_grnd_kmph) / 1.852, abs=0.001
    )
    assert said["ZDA"].datetime.date() == date(2026, 6, 1)
    assert (
        said["ZDA"].timestamp.replace(tzinfo=None)
        == time(12, 0, 1, 250_000)
        == said["GGA"].timestamp.replace(tzinfo=None)
    )


@pytest.mark.parametrize(("grade", "quality"), [("rtk", 4), ("sbas", 2), ("standalone", 1)])
def test_quality_is_that_of_the_grade(grade: str, quality: int) -> None:
    assert printed(surroundings(grade))[0]["GGA"].gps_qual == quality


def test_without_a_fix_the_fields_are_empty_and_the_clock_runs_on() -> None:
    said, _ = printed(surroundings(faults=("gnss_lost@0",)))
    assert (said["GGA"].gps_qual, said["GGA"].lat, said["GGA"].lon) == (0, "", "")
    assert said["HDT"].heading in ("", None)
    assert said["VTG"].faa_mode == "N"
    assert said["ZDA"].timestamp is not None


def test_latency_delays_the_bytes() -> None:
    assert printed(surroundings(), replace(GNSS, latency_s=0.04))[1] == pytest.approx(1.29)


def test_midnight_turns_the_date() -> None:
    said, _ = printed(surroundings(), t_s=12 * 3600.0)
    assert said["ZDA"].datetime.date() == date(2026, 6, 2)
    assert said["ZDA"].timestamp.replace(tzinfo=None) == time(0, 0, 0)


@given(st.floats(-180.0, 180.0))
@settings(deadline=None, derandomize=True, max_examples=100)
def test_degrees_and_minutes_to_a_tenth_of_a_micro_minute(angle_deg: float) -> None:
    text = degrees_minutes(angle_deg, 3)
    assert len(text) == 13 and float(text[3:]) < 60.0
    assert int(text[:3]) + float(text[3:]) / 60.0 == pytest.approx(abs(angle_deg), abs=1e-9)


def test_almost_a_whole_degree_does_not_print_sixty_minutes() -> None:
    assert degrees_minutes(10.999999999999, 2) == "1100.0000000"


def test_southern_and_western_hemispheres() -> None:
    config = load(find("revolt"))
    around = replace(surroundings(), home=replace(config.home, lat_deg=-33.85, lon_deg=-151.2))
    said, _ = printed(around)
    assert (said["GGA"].latitude, said["GGA"].longitude) == pytest.approx((-33.85, -151.2), abs=1e-4)


def test_wind_sensor_prints_apparent_wind() -> None:
    around = surroundings(wind=WindModel(10.0, 0.0, 1))
    around.hull.place(0.0, 0.0, math.radians(90.0), 2.0)
    stream = MemoryStream("wind")
    device = emulators.sensor(replace(GNSS, name="wind", rate_hz=2.0), stream.device, around)
    assert isinstance(device, WindEmulator)
    angles, speeds = [], []
    for _ in range(500):
        device.speak(0.0)
    for _, data in stream.read(0.0):
        said = pynmea2.parse(data.decode("ascii"), check=True)
        angles.append(float(said.wind_angle))
        speeds.append(float(said.wind_speed))
    wind = around.wind
    x, y = 2.0 - wind.east_mps, wind.north_mps  # air over a boat that heads east, as seen from it
    assert sum(speeds) / 500 == pytest.approx(math.hypot(x, y), abs=0.05)
    assert sum(angles) / 500 == pytest.approx(math.degrees(math.atan2(y, x)) % 360.0, abs=0.5)


# --- MTData2 -------------------------------------------------------------------------------------------------------


def items(message: bytes) -> dict[int, bytes]:
    """By the protocol's words: preamble, bus id, message id, length, items, checksum."""
    assert message[:3] == b"\xfa\xff\x36"
    assert message[3] == len(message) - 5
    assert sum(message[1:]) & 0xFF == 0
    found, at = {}, 4
    while at < len(message) - 1:
        identifier, size = struct.unpack_from(">HB", message, at)
        found[identifier] = message[at + 3 : at + 3 + size]
        at += 3 + size
    assert at == len(message) - 1
    return found


def test_mtdata2_holds_what_the_model_measured() -> None:
    device = XsensEmulator(IMU, MemoryStream("imu").device, surroundings())
    roll, pitch, yaw = 0.1, -0.2, 2.5
    found = items(device.message((1.0, 2.0, -9.75, 0.5, -0.25, 0.125, roll, pitch, yaw), 12.3456))
    assert struct.unpack(">3f", found[0x4020]) == (1.0, 2.0, -9.75)
    assert struct.unpack(">3f", found[0x8020]) == (0.5, -0.25, 0.125)
    assert struct.unpack(">I", found[0x1060]) == (123456,)
    w, x, y, z = struct.unpack(">4f", found[0x2014])
    assert math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)) == pytest.approx(roll, abs=1e-6)
    assert math.asin(2 * (w * y - z * x)) == pytest.approx(pitch, abs=1e-6)
    assert math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) == pytest.approx(yaw, abs=1e-6)
    assert struct.unpack(">I", found[0xE020])[0] & 1


def test_mtdata2_counts_and_wraps() -> None:
    stream = MemoryStream("imu")
    device = XsensEmulator(IMU, stream.device, surroundings())
    for k in range(0x10002):
        device.speak(0.01 * k)
    messages = [items(data) for _, data in stream.read(0.01 * 0x10002)][-4:]
    assert [struct.unpack(">H", message[0x1020])[0] for message in messages] == [0xFFFE, 0xFFFF, 0, 1]


def test_mtdata2_sends_the_means_since_the_last_message() -> None:
    """At 10 Hz it sent what it felt in the last 10 ms."""
    stream, around = MemoryStream("imu"), surroundings()
    device = XsensEmulator(replace(IMU, rate_hz=10.0), stream.device, around)
    yaw_rad = 0.0
    for k in range(1, 101):
        around.hull.turn_radps = 1.0 + 0.1 * k
        yaw_rad += 0.01 * around.hull.turn_radps
        device.speak(0.01 * k)
    messages = [items(data) for _, data in stream.read(1.0)]
    rates = [struct.unpack(">3f", message[0x8020])[2] for message in messages]
    assert [struct.unpack(">I", message[0x1060])[0] for message in messages] == list(range(1000, 10001, 1000))
    assert sum(0.1 * rate for rate in rates) == pytest.approx(yaw_rad, abs=3e-3)
    assert rates[-1] == pytest.approx(1.0 + 0.1 * 95.5, abs=3e-3)


def test_lost_imu_is_silent() -> None:
    stream = MemoryStream("imu")
    XsensEmulator(IMU, stream.device, surroundings(faults=("imu_lost@0",))).speak(0.0)
    assert stream.read(1.0) == []


# --- the board -----------------------------------------------------------------------------------------------------


class Bench:
    """A board on a bench, with its three thrusters."""

    def __init__(self, *faults: str) -> None:
        self.stream = MemoryStream("microcontroller")
        self.faults = Faults(faults, VESSEL)
        self.thrusters: tuple[ThrusterModel, ...] = build(VESSEL.thrusters, 0.0, None)
        self.battery = BatteryModel(900.0)
        self.board = MicrocontrollerEmulator(
            VESSEL.actuators[0], self.stream.device, self.thrusters, self.battery, self.faults
        )
        self.t_s = 0.0

    def send(self, throttle: float = 0.5, armed: bool = True, count: int = 3) -> None:
        self.stream.write(encode(BoardCommand(1, armed, (ThrusterDemand(throttle, 0.1),) * count)), self.t_s)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 100)):
            self.t_s = round(self.t_s + 0.01, 6)
            self.faults.update(self.t_s)
            self.board.listen(self.t_s)
            for thruster in self.thrusters:
                thruster.step(0.01)

    def heard(self) -> list[object]:
        decoder = FrameDecoder()
        return [message for _, data in self.stream.read(1e9) for message in decoder.feed(data)]

    @property
    def forces(self) -> list[float]:
        return [thruster.force_n for thruster in self.thrusters]


def test_the_board_obeys_armed_commands_only() -> None:
    bench = Bench()
    bench.send(armed=False)
    bench.run(0.1)
    assert bench.forces == [0.0, 0.0, 0.0]
    bench.send()
    bench.run(0.1)
    assert bench.forces == pytest.approx([6.75, 6.75, 3.795])
    bench.send(armed=False)
    bench.run(0.1)
    assert bench.forces == [0.0, 0.0, 0.0]


def test_the_watchdog_goes_neutral_half_a_second_after_the_last_frame() -> None:
    bench = Bench()
    bench.send()
    bench.run(0.5)
    assert bench.forces[0] > 0.0 and not bench.board.status().neutral_by_watchdog
    bench.run(0.01)
    assert bench.forces == [0.0, 0.0, 0.0]
    assert bench.board.status().neutral_by_watchdog
    bench.send()
    bench.run(0.1)
    assert bench.forces[0] > 0.0 and not bench.board.status().neutral_by_watchdog


def test_damaged_frames_do_not_feed_the_watchdog() -> None:
    bench = Bench()
    bench.send()
    for _ in range(60):
        damaged = bytearray(encode(BoardCommand(1, True, (ThrusterDemand(0.5, 0.1),) * 3)))
        damaged[9] ^= 0x10
        bench.stream.write(bytes(damaged), bench.t_s)
        bench.run(0.01)
    assert bench.forces == [0.0, 0.0, 0.0]


def test_a_frame_for_another_number_of_thrusters_is_not_obeyed() -> None:
    bench = Bench()
    bench.send(count=2)
    bench.run(0.1)
    assert bench.forces == [0.0, 0.0, 0.0]
    assert bench.board.status().neutral_by_watchdog


def test_status_and_introduction() -> None:
    bench = Bench()
    bench.battery.step(120.0, 3600.0)
    bench.send()
    bench.run(0.2)
    bench.board.speak(bench.t_s)
    bench.board.speak(bench.t_s)
    ident, status, again = bench.heard()
    assert ident == Ident((1, 1, 0), 3, "microcontroller")
    assert isinstance(status, BoardStatus) and isinstance(again, BoardStatus)
    assert status.sequence == 1 and not status.rc_present and not status.leak_wet
    assert [each.throttle for each in status.thrusters] == pytest.approx([0.5, 0.5, 0.5], abs=1e-4)
    assert status.thrusters[0].azimuth_rad == pytest.approx(0.1, abs=1e-4) and status.thrusters[2].azimuth_rad is None
    assert status.remaining == pytest.approx(1.0 - 120.0 / 900.0, abs=0.003)
    assert status.voltage_v == pytest.approx(12.8 - 1.6 * 120.0 / 900.0 - 0.02 * 9.4, abs=0.02)
    bench.stream.write(encode(IdentRequest()), bench.t_s)
    bench.run(0.01)
    bench.board.speak(bench.t_s)
    assert bench.heard()[0] == Ident((1, 1, 0), 3, "microcontroller")


@pytest.mark.parametrize("fault", ["mcu_silent", "mcu_deaf"])
def test_a_board_that_hears_nothing_is_neutral(fault: str) -> None:
    bench = Bench(f"{fault}@1+2")
    for _ in range(25):
        bench.send()
        bench.run(0.1)
    assert bench.forces == [0.0, 0.0, 0.0]
    bench.board.speak(bench.t_s)
    assert bool(bench.heard()) == (fault == "mcu_deaf")
    for _ in range(10):
        bench.send()
        bench.run(0.1)
    assert bench.forces[0] > 0.0


def test_faults_in_the_status() -> None:
    bench = Bench("leak@1", "battery_low@2", "rc_safe@3+1", "rc_lost@5")
    seen = []
    for _ in range(6):
        bench.run(1.0)
        seen.append(bench.board.status())
    assert [status.leak_wet for status in seen] == [True] * 6
    assert [status.remaining for status in seen] == [1.0, 0.08, 0.08, 0.08, 0.08, 0.08]
    assert [status.rc_us[4] for status in seen] == [1000, 1000, 2000, 1000, 0, 0]
    assert [status.rc_lost for status in seen] == [False, False, False, False, True, True]
    assert all(status.rc_present for status in seen)


def test_a_dead_thruster_is_reported() -> None:
    bench = Bench()
    bench.thrusters[1].dead = True
    assert [state.ok for state in bench.board.status().thrusters] == [True, False, True]


def test_faults_may_come_late() -> None:
    bench = Bench()
    bench.run(1.0)
    bench.faults.add(Fault("leak", 1.0))
    bench.run(0.01)
    assert bench.board.status().leak_wet


def test_a_retractable_thruster_goes_where_it_is_told_armed_or_not() -> None:
    bench = Bench()
    bow = bench.thrusters[2]
    travel_s = VESSEL.thrusters[2].travel_s

    def command(lower: bool | None, seconds: float) -> list[Deployment | None]:
        for _ in range(round(seconds / 0.1)):
            bench.stream.write(encode(BoardCommand(1, False, (ThrusterDemand(0.0),) * 3, lower)), bench.t_s)
            bench.run(0.1)
        return [state.deployment for state in bench.board.status().thrusters]

    assert command(None, 1.0) == [None, None, Deployment.LOWERED]
    assert command(False, 1.0) == [None, None, Deployment.MOVING]
    assert bow.down == pytest.approx(1.0 - 1.0 / travel_s, abs=0.01)
    assert command(None, travel_s) == [None, None, Deployment.RETRACTED], "a travel once begun is ended"
    assert command(True, travel_s - 0.2)[2] is Deployment.MOVING
    assert command(True, 0.4)[2] is Deployment.LOWERED


def test_the_beacon_is_as_commanded_until_the_watchdog_has_the_board() -> None:
    bench = Bench()
    assert bench.board.beacon == Beacon()
    bench.run(0.6)
    assert bench.board.beacon == Beacon(green=Light.STEADY)  # nobody has commanded it yet
    command = BoardCommand(1, True, (ThrusterDemand(0.0),) * 3, None, Light.STEADY, Light.BLINK, Light.BLINK)
    bench.stream.write(encode(command), bench.t_s)
    bench.run(0.1)
    assert bench.board.beacon == Beacon(Light.STEADY, Light.BLINK, Light.BLINK)
    bench.run(0.6)
    assert bench.board.beacon == Beacon(Light.STEADY, Light.BLINK, Light.STEADY)


def test_servos_and_relays_obey_and_rest_when_nothing_comes() -> None:
    bench = Bench()
    config = replace(VESSEL.actuators[0], servos=("winch",), relays=("pump", "lamp"))
    bench.board = MicrocontrollerEmulator(config, bench.stream.device, bench.thrusters, bench.battery, bench.faults)
    bench.board.speak(bench.t_s)
    assert not any(isinstance(message, AuxiliaryState) for message in bench.heard()), "nothing before it was asked"
    bench.stream.write(encode(AuxiliaryDemand(4, (1900.0,), (True, False))), bench.t_s)
    bench.run(0.4)
    bench.board.speak(bench.t_s)
    assert bench.heard()[-1] == bench.board.outputs == AuxiliaryState(4, (1900.0,), (True, False))
    bench.stream.write(encode(AuxiliaryDemand(5, (), (True, False))), bench.t_s)  # for another board
    bench.run(0.2)
    assert (bench.board.outputs.servos_us, bench.board.outputs.relays) == ((None,), (False, False))
