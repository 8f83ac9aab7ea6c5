"""Sentences of the boat, read back by pynmea2 and by pynmeagps, which know nothing of each other."""

from __future__ import annotations

import math
import socket
from dataclasses import replace
from datetime import UTC, datetime, time
from typing import Any

import pynmea2
import pytest
from pynmeagps import NMEAReader

from companion.config.streams import NmeaOutConfig
from companion.config.vessel import ConfigError, find, load, parse
from companion.core.actuation import ThrusterCommand, ThrusterFeedback
from companion.core.decision import TextKind
from companion.core.readings import Corrections, FixType
from companion.core.setpoint import NeutralSetpoint, PathSetpoint, Point, Progress
from companion.core.tick import Inputs, Tick
from companion.io.nmea_out import NmeaOut, gga, rudders
from companion.io.transport.opener import TransportOpener
from tests.unit.record.ticks import tick as plain_tick
from tests.waiting import CAP_S
from tests.wires import Listening

KNOT = 1852.0 / 3600.0
REVOLT = load(find("revolt"))
ALL = ("GGA", "RMC", "VTG", "HDT", "ZDA", "XTE", "APB", "RSA")


def sailing() -> Tick:
    """North-east at 1 m/s, 3 m to starboard of its track, the next point 40 m north and 30 m east of the boat."""
    tick = plain_tick(12.5)
    nav = replace(
        tick.nav,
        lat_deg=-63.43891234567,
        lon_deg=-10.39912345678,
        yaw_rad=math.radians(359.996),
        north_mps=0.6,
        east_mps=0.8,
        altitude_m=1.25,
        time_unix_ns=1_780_315_200_370_000_000,
    )
    setpoint = PathSetpoint(
        math.radians(40.0),
        progress=Progress(
            target=Point(nav.north_m + 40.0, nav.east_m + 30.0),
            cross_track_error_m=3.0,
            course_rad=math.radians(30.0),
        ),
    )
    thrusters = (
        ThrusterCommand(10.0, 0.6, math.radians(20.0)),
        ThrusterCommand(10.0, 0.6, math.radians(-10.0)),
        ThrusterCommand(0.0, 0.0, None),
    )
    command = replace(tick.command, thrusters=thrusters)
    return replace(
        tick,
        nav=nav,
        setpoint=setpoint,
        command=command,
        inputs=Inputs(corrections=Corrections(12.0, "gnss", 1.5, 33)),
        feedback=(None,) * 3,
    )


def out(**more: Any) -> tuple[NmeaOut, Listening, list[tuple[Any, ...]]]:
    line, said = Listening(), []
    config = NmeaOutConfig("udpout:127.0.0.1:10110", sentences=ALL, **more)
    return NmeaOut(config, REVOLT.thrusters, line, lambda *event: said.append(event)), line, said


def read(data: bytes) -> tuple[dict[str, Any], dict[str, Any]]:
    """By pynmea2, and by pynmeagps."""
    lines = data.decode("ascii").split("\r\n")
    assert lines[-1] == "" and all(len(line) <= 82 for line in lines)
    first = [pynmea2.parse(line, check=True) for line in lines[:-1]]
    second = [NMEAReader.parse(line.encode() + b"\r\n", validate=1) for line in lines[:-1]]
    return {s.sentence_type: s for s in first}, {s.msgID: s for s in second}


def test_position_motion_and_time() -> None:
    one, two = read(out()[0].sentences(sailing()))
    assert list(one) == list(two) == list(ALL)
    for kind in ("GGA", "RMC"):
        assert (one[kind].latitude, one[kind].longitude) == pytest.approx(
            (-63.43891234567, -10.39912345678), abs=1.1e-8
        )
        assert (two[kind].lat, two[kind].lon) == pytest.approx((-63.43891234567, -10.39912345678), abs=1.1e-8)
        assert two[kind].time == time(12, 0, 0, 370_000)
    assert one["RMC"].datetime.replace(tzinfo=UTC) == datetime(2026, 6, 1, 12, 0, 0, 370_000, UTC)
    assert one["ZDA"].datetime == datetime(2026, 6, 1, 12, 0, 0, 370_000, UTC)
    assert (two["GGA"].quality, two["GGA"].numSV, two["GGA"].HDOP, two["GGA"].alt) == (4, 18, 0.7, 1.25)
    assert (two["GGA"].diffAge, int(two["GGA"].diffStation)) == (2.0, 33)
    assert float(two["RMC"].spd) == float(two["VTG"].sogn) == pytest.approx(1.0 / KNOT, abs=0.005) and float(
        two["VTG"].sogk
    ) == pytest.approx(3.6)
    assert float(two["RMC"].cog) == float(one["VTG"].true_track) == pytest.approx(53.13)
    assert float(one["HDT"].heading) == two["HDT"].headingT == 0.0, "never 360"


def test_track_and_rudders() -> None:
    """To starboard of the track one steers left; stern pods that push to starboard and to port stand as rudders the
    other way."""
    one, two = read(out()[0].sentences(sailing()))
    for kind in ("XTE", "APB"):
        assert (two[kind].ctrkerr * 1852.0, two[kind].dirs) == (pytest.approx(3.0, abs=0.01), "L")
    assert (one["XTE"].correction_dir, one["APB"].dir_steer, one["APB"].status_gen) == ("L", "L", "A")
    assert (two["APB"].bearO2D, two["APB"].bearD, two["APB"].bearS) == (30.0, 36.87, 40.0)
    assert float(one["APB"].bearing_to_dest) == pytest.approx(30.0)
    assert float(one["APB"].bearing_pres_dest) == pytest.approx(36.87) and float(
        one["APB"].heading_to_dest
    ) == pytest.approx(40.0)
    assert (float(one["RSA"].rsa_starboard), float(one["RSA"].rsa_port)) == (10.0, -20.0)
    turned = replace(sailing(), feedback=(None, ThrusterFeedback(12.5, "mcu", 1, 0.5, math.radians(-25.0), True), None))
    assert float(read(out()[0].sentences(turned))[0]["RSA"].rsa_starboard) == 25.0, (
        "where it is, rather than where it should be"
    )


def test_what_is_not_known_is_not_said() -> None:
    tick = plain_tick(1.0)
    lost = replace(
        tick,
        nav=replace(tick.nav, position_valid=False, heading_valid=False, fix=FixType.NONE, satellites=None, hdop=None),
    )
    one, _ = read(out()[0].sentences(replace(lost, setpoint=NeutralSetpoint())))
    assert set(one) == {"GGA", "RMC", "VTG", "ZDA"}
    assert one["GGA"].gps_qual == 0 and one["RMC"].status == "V" and one["GGA"].lat == "" == one["RMC"].lat
    rest = replace(tick, nav=replace(tick.nav, north_mps=0.01, east_mps=0.0, fix=FixType.NONE))
    one, _ = read(out()[0].sentences(rest))
    assert one["VTG"].true_track is None and one["GGA"].gps_qual == 6, "carried on by the estimate"
    assert gga(rest).startswith(b"$GPGGA,")


def test_rudders_of_other_boats() -> None:
    assert rudders(REVOLT.thrusters) == (1, 0)
    assert rudders(load(find("rescuerunner")).thrusters) == (0, None)
    assert rudders(REVOLT.thrusters[2:]) == (None, None)


@pytest.mark.parametrize("angle_deg", [0.0, 9.9999999999, -9.9999999999, 59.99999999999, 89.0, -0.00000001])
def test_minutes_never_reach_sixty(angle_deg: float) -> None:
    tick = plain_tick(0.0)
    one, two = read(
        out()[0].sentences(replace(tick, nav=replace(tick.nav, lat_deg=angle_deg, lon_deg=2.0 * angle_deg)))
    )
    assert one["GGA"].latitude == pytest.approx(angle_deg, abs=1e-8) and two["GGA"].lon == pytest.approx(
        2.0 * angle_deg, abs=1e-8
    )


def test_at_its_rate() -> None:
    sink, line, _ = out(rate_hz=2.0)
    for k in range(101):
        sink.record(plain_tick(0.1 * k))
    assert [round(t_s, 1) for t_s, _ in line.sent] == [0.5 * k for k in range(21)]
    fast, line, _ = out(rate_hz=50.0)
    for k in range(10):
        fast.record(plain_tick(0.1 * k))
    assert len(line.sent) == 10, "no faster than the control step"


def test_a_fault_is_said_once() -> None:
    sink, line, said = out()
    line.broken = "tcpout:10.0.0.9:10110: refused; nothing listens there yet"
    for k in range(300):
        sink.record(plain_tick(0.1 * k))
    assert [(event[1], event[3]) for event in said] == [(TextKind.ATTENTION, f"NMEA out: {line.broken}")]


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e300])
def test_numbers_that_are_none_never_end_a_run(value: float) -> None:
    for name in ("lat_deg", "lon_deg", "yaw_rad", "north_mps", "altitude_m", "hdop", "north_m"):
        sink, line, said = out()
        sink.record(replace(sailing(), nav=replace(sailing().nav, **{name: value})))
        assert line.sent or "no sentence" in said[0][3]
        assert not any(b"nan" in data or b"inf" in data for _, data in line.sent)


def test_over_udp() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plotter:
        plotter.bind(("127.0.0.1", 0))
        plotter.settimeout(CAP_S)
        config = NmeaOutConfig(f"udpout:127.0.0.1:{plotter.getsockname()[1]}")
        sink = NmeaOut(config, REVOLT.thrusters, TransportOpener().open("nmea_out", config.port), lambda *_: None)
        sink.record(sailing())
        assert set(read(plotter.recv(65535))[0]) == {"GGA", "RMC", "VTG", "HDT", "XTE", "APB", "RSA"}
        sink.close()


def test_in_a_vessels_file() -> None:
    text = find("revolt").read_text(encoding="utf-8")
    config = parse(
        text.replace(
            "[parameters]",
            '[[nmea_out]]\nport = "udpout:127.0.0.1:10110"\nrate_hz = 5\nsentences = ["GGA", "HDT"]\n[parameters]',
        ),
        "x",
    )
    assert config.nmea_out == (NmeaOutConfig("udpout:127.0.0.1:10110", 5.0, ("GGA", "HDT")),)
    with pytest.raises(ConfigError, match="nmea_out"):
        parse(
            text.replace(
                "[parameters]", '[[nmea_out]]\nport = "udpout:127.0.0.1:10110"\nsentences = ["GGB"]\n[parameters]'
            ),
            "x",
        )
