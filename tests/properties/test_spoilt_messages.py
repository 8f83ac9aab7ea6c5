"""A hundred thousand spoilt messages of each protocol: what is believed is what a second reader, written apart, finds
to have a good checksum."""

from __future__ import annotations

import random
from collections import Counter
from functools import reduce
from operator import xor
from typing import Any

import pytest

from companion.config.devices import SensorConfig
from companion.io.sensors import open_sensor
from tests.remembered import remembered
from tests.unit.io.sensors import test_nmea0183 as nmea
from tests.unit.io.sensors import test_nmea0183_instruments as instruments
from tests.unit.io.sensors.test_mtdata2 import BY_HAND, FORCE, RATE, item, message
from tests.unit.io.sensors.test_vectornav import VNYMR
from tests.wires import Listening

SENTENCES = [
    nmea.GGA,
    nmea.RMC,
    nmea.VTG,
    nmea.HDT,
    nmea.ZDA,
    *(getattr(instruments, n) for n in ("GSA", "GSV", "ROT", "VWR", "DBT", "DPT", "VHW", "RSA")),
]
SENTENCES += [
    nmea.sentence("GNGST,120000.00,1.2,0.020,0.010,45.0,0.012,0.016,0.030"),
    nmea.sentence("WIMWV,214.8,R,0.1,K,A"),
]
SENTENCES += [
    nmea.sentence("HCHDG,98.3,1.0,W,12.6,E"),
    nmea.sentence("YXXDR,A,5.2,D,PTCH,A,7.4,D,ROLL"),
    nmea.sentence("VDVBW,2.0,-0.5,A,2.1,0.3,A"),
]
PACKETS = [
    BY_HAND,
    message(FORCE, RATE, item(0x2014, bytes(16))),
    message(item(0xC020, bytes(12)), extended=True),
    bytes.fromhex("faff3100d0"),
]
AT_ONCE = 20


def spoilt(generator: random.Random, whole: bytes) -> bytes:
    """Bits turned, a byte put in or taken out, the end cut off."""
    data = bytearray(whole)
    kind = generator.randrange(5)
    at = generator.randrange(len(data))
    if kind == 0:
        data[at] ^= 1 << generator.randrange(8)
    elif kind == 1:
        data[at : at + 1] = generator.randbytes(2)
    elif kind == 2:
        del data[at]
    elif kind == 3:
        del data[at:]
    else:
        for _ in range(4):
            data[generator.randrange(len(data))] = generator.randrange(256)
    return bytes(data).replace(b"!", b"?")


def feed(driver: str, stream: list[bytes]) -> tuple[Any, list[Any]]:
    line = Listening()
    sensor = open_sensor(SensorConfig("sensor", driver, "serial:/dev/x"), line)
    readings: list[Any] = []
    for k in range(0, len(stream), AT_ONCE):
        line.chunks = [(1e-3 * k, b"".join(stream[k : k + AT_ONCE]))]
        readings += sensor.read(1e-3 * k)
    return sensor, readings


def sentences_by_hand(stream: bytes, beginning: bytes = b"$", shortest: int = 6, longest: int = 120) -> Counter[bytes]:
    found: Counter[bytes] = Counter()
    for part in stream.split(beginning)[1:]:
        body, star, rest = part.partition(b"*")
        printable = not body.translate(None, bytes(range(0x20, 0x7F)))
        if star and printable and b"$" not in body and shortest <= len(body) <= longest:
            digits = rest[:2].decode("latin-1").upper()
            if digits == f"{reduce(xor, body):02X}":
                found[body] += 1
    return found


@pytest.mark.parametrize(
    ("driver", "whole", "beginning", "shortest", "longest"),
    [("nmea0183", SENTENCES, b"$", 6, 120), ("vectornav", [VNYMR], b"$VN", 3, 200)],
)
def test_sentences(driver: str, whole: list[bytes], beginning: bytes, shortest: int, longest: int) -> None:
    generator = random.Random(6)
    count = 100_000 if driver == "nmea0183" else 20_000
    stream = [spoilt(generator, generator.choice(whole)) if k % 50 else generator.choice(whole) for k in range(count)]
    good = sum((sentences_by_hand(b"".join(stream[k : k + 5000]) + b"\n") for k in range(0, count, 5000)), Counter())
    if beginning != b"$":
        good = Counter({body: n for body, n in good.items() if body.startswith(b"VN")})
    sensor, readings = feed(driver, stream)
    valid, bad = sensor.counts
    assert valid == pytest.approx(sum(good.values()), abs=5), (
        "but for those that the twenty seams of the second reader cut"
    )
    assert sum(good[one.strip()[1:-3]] for one in set(whole)) >= count // 50
    assert len(readings) < 1.3 * valid and all(reading.source == "sensor" for reading in readings)
    assert remembered(sensor) < 4000 and bad > 0.25 * count


def items_fit(data: bytes) -> bool:
    while len(data) >= 3:
        if len(data) < 3 + data[2]:
            return False
        data = data[3 + data[2] :]
    return True


def packets_by_hand(stream: bytes) -> int:
    found = at = 0
    while (at := stream.find(b"\xfa\xff", at)) >= 0:
        size = stream[at + 3] + 5 if at + 3 < len(stream) else 0
        if size == 260 and at + 6 <= len(stream):
            size = (stream[at + 4] << 8 | stream[at + 5]) + 7
        known = at + 3 < len(stream) and stream[at + 2] in (0x36, 0x31, 0xC1, 0xED, 0x11, 0x42)
        if known and size <= 2055 and at + size <= len(stream) and sum(stream[at + 1 : at + size]) % 256 == 0:
            found += stream[at + 2] != 0x36 or items_fit(
                stream[at + (6 if stream[at + 3] == 0xFF else 4) : at + size - 1]
            )
            at += size
        else:
            at += 1
    return found


def test_packets() -> None:
    generator = random.Random(7)
    count = 100_000
    stream = [
        spoilt(generator, generator.choice(PACKETS)) if k % 50 else generator.choice(PACKETS) for k in range(count)
    ]
    sensor, readings = feed("mtdata2", stream)
    valid, _ = sensor.counts
    assert valid == pytest.approx(packets_by_hand(b"".join(stream)), abs=2)
    assert valid > count // 50 * 0.9 and len(readings) < 1.1 * valid
    assert remembered(sensor) < 6000
