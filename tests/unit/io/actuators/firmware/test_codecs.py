"""The C codec and the Python codec read the same bytes: every accept must agree, and no damaged frame may pass but by
the chance of its CRC."""

from __future__ import annotations

import math
import random
import struct
import subprocess
from binascii import crc_hqx
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from pathlib import Path

import pytest

from companion.core.actuation import Deployment, Light
from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import (
    BoardCommand,
    BoardStatus,
    FrameDecoder,
    Ident,
    IdentRequest,
    Message,
    Radio,
    ThrusterDemand,
    ThrusterState,
    decode,
    encode,
    frame,
    unframe,
)
from tests.unit.io.actuators.firmware.host import ENVIRONMENT
from tests.waiting import CAP_S

EDGES = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    15,
    16,
    17,
    31,
    32,
    33,
    63,
    64,
    127,
    128,
    254,
    255,
)  # where rules of fields change their mind


def heard_by_c(program: Path, wire: bytes) -> tuple[list[tuple[int, bytes]], int, int]:
    """Accepts as (offset of the last byte, frame), and what the receiver counted: frames, errors."""
    done = subprocess.run([str(program)], input=wire, capture_output=True, check=True, timeout=CAP_S, env=ENVIRONMENT)
    accepts, at = [], 0
    while at < len(done.stdout):
        offset, length = struct.unpack_from("<IH", done.stdout, at)
        accepts.append((offset, done.stdout[at + 6 : at + 6 + length]))
        at += 6 + length
    frames, errors = map(int, done.stderr.split())
    return accepts, frames, errors


def heard_by_python(wire: bytes) -> tuple[list[tuple[int, bytes]], int, int]:
    decoder, accepts, at = FrameDecoder(), [], 0
    while at < len(wire):
        end = wire.find(b"\0", at)
        end = len(wire) - 1 if end < 0 else end
        accepts += [(end, encode(message)) for message in decoder.feed(wire[at : end + 1])]
        at = end + 1
    return accepts, decoder.frames, decoder.errors


def any_message(rng: random.Random) -> Message:
    def throttle() -> float:
        return rng.randint(-10000, 10000) / 10000

    def azimuth() -> float | None:
        return rng.choice((None, rng.randint(-31415, 31415) / 1e4))

    n, kind = rng.choice((0, 1, 2, 3, 3, 3, 16)), rng.randrange(7)
    if kind < 2:
        demands = tuple([ThrusterDemand(throttle(), azimuth()) for _ in range(n)])
        lights = [rng.choice(list(Light)) for _ in range(3)]
        return BoardCommand(rng.randrange(256), rng.random() < 0.5, demands, rng.choice((None, True, False)), *lights)
    if kind == 2:
        deployments = (None, *Deployment)
        states = tuple(
            [ThrusterState(throttle(), azimuth(), rng.random() < 0.5, rng.choice(deployments)) for _ in range(n)]
        )
        flags = [rng.random() < 0.5 for _ in range(6)]
        rc_us = tuple([rng.choice((0, 1000, 1500, 2000, 65535)) for _ in range(8)])
        measured = rng.choice((None, 12.345)), rng.choice((None, -1.5, 2000.0)), rng.choice((None, 0.0, 1.0))
        return BoardStatus(rng.randrange(256), *flags[:4], *measured, rc_us, states, *flags[4:])
    if kind == 3:
        name = "".join(chr(rng.randrange(128)) for _ in range(rng.randrange(33)))
        return rng.choice((IdentRequest(), Ident((rng.randrange(256), 0, 1), rng.randrange(256), name)))
    if kind == 6:
        return Radio(rng.randbytes(rng.choice((1, 20, 64))))
    pulses = tuple([rng.choice((None, 500.0, 1500.0, 2500.0)) for _ in range(n)])
    relays = tuple([rng.random() < 0.5 for _ in range(rng.randrange(17))])
    return (AuxiliaryDemand if kind == 4 else AuxiliaryState)(rng.randrange(256), pulses, relays)


def damaged(wire: bytes, rng: random.Random) -> bytes:
    """A frame as a bad wire leaves it: never as it was."""
    out = bytearray(wire)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 8))):
        at, kind = rng.randrange(len(out)), rng.randrange(6)
        if kind <= 1:
            out[at] ^= 1 << rng.randrange(8)
        elif kind == 2:
            out[at] = rng.randrange(256)
        elif kind == 3 and len(out) > 4:
            del out[at : at + rng.randrange(1, 4)]
        elif kind == 4:
            out[at:at] = rng.randbytes(rng.randrange(1, 4))
        else:
            out[at : at + 8] = rng.randbytes(len(out[at : at + 8]))
    return bytes(out)


def absurd(wire: bytes, rng: random.Random) -> bytes:
    """A message with a few bytes changed before its CRC is made: what the rules of the fields alone must catch."""
    raw = unframe(wire[1:-1])
    assert raw is not None
    body = bytearray(raw[:-2])
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(body)) if rng.random() < 0.5 else min(rng.randrange(8), len(body) - 1)
        body[at] = rng.choice(
            (
                body[at] ^ 1 << rng.randrange(8),
                (body[at] + rng.choice((-1, 1))) % 256,
                rng.choice(EDGES),
                rng.randrange(256),
            )
        )
    if rng.random() < 0.3:
        body = body[: rng.randrange(len(body) + 1)] if rng.random() < 0.5 else body + rng.randbytes(rng.randrange(1, 6))
    return frame(bytes(body) + struct.pack("<H", crc_hqx(bytes(body), 0xFFFF)))


def fuzzed(count: int, seed: int) -> Iterator[tuple[bytes, bytes | None]]:
    """What goes over the wire, and the frame that may be heard of it. Absurd ones may be heard as what they are."""
    rng = random.Random(seed)
    messages = [encode(any_message(rng)) for _ in range(2000)]
    for _ in range(count):
        sound, dice = rng.choice(messages), rng.random()
        if dice < 0.60:
            yield damaged(sound, rng), sound
        elif dice < 0.80:
            wire = absurd(sound, rng)
            yield wire, wire
        elif dice < 0.90:
            yield sound, sound
        else:
            yield rng.randbytes(rng.randrange(300)).replace(b"\0", b"\x01" if dice < 0.95 else b"\0"), None


def compare(program: Path, count: int, seed: int) -> tuple[int, int, int]:
    """(frames heard, frames heard that nobody sent, frames that only their CRC gave away), once both codecs agree on
    every accept and every error."""
    pieces, starts, meant, at = [], [], [], 0
    for wire, sound in fuzzed(count, seed):
        pieces.append(wire)
        starts.append(at)
        meant.append(sound)
        at += len(wire)
    stream = b"".join(pieces) + b"\0"
    by_c, by_python = heard_by_c(program, stream), heard_by_python(stream)
    assert by_c == by_python
    false = 0
    for offset, heard in by_c[0]:
        i = bisect_right(starts, offset) - 1
        j = bisect_left(starts, starts[i])  # pieces may be empty
        false += _canonical(heard) not in {
            _canonical(sound) for sound in meant[max(0, j - 3) : i + 1] if sound is not None
        }
    return len(by_c[0]), false, sum(map(_only_crc_is_wrong, stream.split(b"\0")))


def _only_crc_is_wrong(encoded: bytes) -> bool:
    """Whether it would be a message if its CRC said so."""
    raw = unframe(encoded) if len(encoded) <= 254 else None
    if raw is None or len(raw) < 4 or raw[0] != 1 or crc_hqx(raw[:-2], 0xFFFF) == struct.unpack("<H", raw[-2:])[0]:
        return False
    return decode(frame(raw[:-2] + struct.pack("<H", crc_hqx(raw[:-2], 0xFFFF)))[1:-1]) is not None


def _canonical(wire: bytes) -> bytes:
    """Astern may be said as −31416 and as 31416."""
    message = decode(wire[1:-1])
    return wire if message is None else encode(message)


def _most_by_chance(count: int) -> int:
    """Of frames that only a CRC of 16 bits keeps out: passed by fewer than one run in a million with more of them."""
    expected, most, tail = count / 65536, 0, 1.0 - math.exp(-count / 65536)
    while tail > 1e-6:
        most += 1
        tail -= math.exp(-expected) * expected**most / math.factorial(most)
    return most


def test_both_codecs_hear_the_same_in_100_000_fuzzed_frames(host_codec: Path) -> None:
    heard, false, kept_out = compare(host_codec, 100_000, seed=20)
    assert heard > 10_000 and kept_out > 5_000 and false <= _most_by_chance(kept_out)


@pytest.mark.sweep
def test_both_codecs_hear_the_same_in_a_million_fuzzed_frames(host_codec: Path) -> None:
    heard, false, kept_out = compare(host_codec, 1_000_000, seed=21)
    print(
        f"{heard} heard, {false} of them never sent; {kept_out} kept out by their CRC alone, of which {kept_out / 65536:.1f} pass by chance"
    )
    assert heard > 100_000 and kept_out > 50_000 and false <= _most_by_chance(kept_out)


def test_both_ends_of_the_azimuth_mean_astern(host_codec: Path) -> None:
    """A direction a hair to port of astern rounds to π on both sides."""
    sent = encode(BoardCommand(0, True, (ThrusterDemand(0.1, -math.pi + 1e-6),)))
    ((_, heard),), _, _ = heard_by_c(host_codec, sent)
    assert heard == sent == encode(BoardCommand(0, True, (ThrusterDemand(0.1, math.pi),)))


def test_the_check_value_of_the_crc_and_the_longest_frames(host_codec: Path) -> None:
    longest = BoardStatus(
        0,
        True,
        True,
        True,
        True,
        65.534,
        -2147483.647,
        1.0,
        (65535,) * 8,
        (ThrusterState(-1.0, 3.1, True, Deployment.LOWERED),) * 16,
        True,
        True,
    )
    sent = [
        longest,
        BoardCommand(255, True, (ThrusterDemand(1.0, -3.1),) * 16, True, Light.BLINK, Light.BLINK, Light.BLINK),
    ]
    sent += [AuxiliaryDemand(9, (2500.0,) * 16, (True,) * 16), Ident((255, 255, 255), 255, "x" * 32), Radio(bytes(64))]
    accepts, frames, errors = heard_by_c(host_codec, b"".join(map(encode, sent)))
    assert [heard for _, heard in accepts] == [encode(message) for message in sent] and (frames, errors) == (5, 0)


def _command(throttle: int, azimuth: int) -> bytes:
    return struct.pack("<6Bhh", 1, 1, 0, 1, 0, 1, throttle, azimuth)


def _ident(length: int) -> bytes:
    return bytes((1, 4, 1, 0, 0, 3, length)) + b"n" * length


@pytest.mark.parametrize(
    ("within", "beyond"),
    [
        (_command(10000, 0), _command(10001, 0)),
        (_command(-10000, 0), _command(-10001, 0)),
        (_command(0, 31416), _command(0, 31417)),
        (_command(0, -31416), _command(0, -31417)),
        (_command(0, -32768), _command(0, -32767)),
        (_ident(32), _ident(33)),
        (struct.pack("<5BBBH", 1, 5, 0, 0, 0, 0, 1, 500), struct.pack("<5BBBH", 1, 5, 0, 0, 0, 0, 1, 499)),
        (struct.pack("<5BBBH", 1, 6, 0, 0, 0, 0, 1, 2500), struct.pack("<5BBBH", 1, 6, 0, 0, 0, 0, 1, 2501)),
        (bytes((1, 7)) + b"r" * 64, bytes((1, 7)) + b"r" * 65),
        (bytes((1, 7)) + b"r", bytes((1, 7))),
        (struct.pack("<5BBB", 1, 5, 0, 255, 127, 15, 0), struct.pack("<5BBB", 1, 5, 0, 255, 255, 15, 0)),
    ],
)
def test_the_last_value_that_can_be_and_the_first_that_cannot(within: bytes, beyond: bytes, host_codec: Path) -> None:
    wire = b"".join(frame(body + struct.pack("<H", crc_hqx(body, 0xFFFF))) for body in (within, beyond))
    assert heard_by_c(host_codec, wire) == heard_by_python(wire)
    assert heard_by_python(wire)[1:] == (1, 1)
