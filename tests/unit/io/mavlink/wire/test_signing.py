"""Signatures, against pymavlink's own signer and verifier, and against everything that a stranger can send."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from companion.io.mavlink.wire.framer import Framer, frame, pack
from companion.io.mavlink.wire.signing import SAVE_PERIOD_S, SignatureVerdict, Signing, SigningState, unsigned
from tests.remembered import remembered

KEY, OTHER_KEY = bytes(range(32)), bytes(range(1, 33))
NOW_NS = 1_780_000_000_000_000_000
TICK_NS = 10_000
MINUTE = 60 * 100_000
EPOCH_NS = 1_420_070_400_000_000_000


class Clock:
    def __init__(self, ns: int = NOW_NS) -> None:
        self.ns = ns

    def __call__(self) -> int:
        return self.ns

    @property
    def stamp(self) -> int:
        return (self.ns - EPOCH_NS) // TICK_NS


class Kept:
    def __init__(self) -> None:
        self.states: list[SigningState] = []

    def __call__(self, state: SigningState) -> None:
        self.states.append(state)


def signing(key: bytes | None = KEY, clock: Clock | None = None, horizon: int = 0, kept: Kept | None = None) -> Signing:
    return Signing(clock or Clock(), SigningState(key, horizon), kept or Kept())


def station(key: bytes, stamp: int, link: int = 0, system: int = 255) -> Any:
    """pymavlink as a ground station that signs."""
    codec = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
    codec.signing.secret_key, codec.signing.timestamp, codec.signing.link_id, codec.signing.sign_outgoing = (
        key,
        stamp,
        link,
        True,
    )
    return codec


def heartbeat(codec: Any) -> bytes:
    return bytes(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(codec))


def test_what_pymavlink_signs_is_genuine() -> None:
    clock = Clock()
    ours, theirs = signing(clock=clock), station(KEY, clock.stamp)
    for _ in range(5):
        assert ours.judge(heartbeat(theirs)) is SignatureVerdict.GENUINE


def test_what_we_sign_pymavlink_takes() -> None:
    ours = signing()
    codec = mavlink.MAVLink(None)
    codec.signing.secret_key = KEY
    packed = pack(mavlink.MAVLink_attitude_message(1, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0))
    for sequence in range(5):
        data = ours.sign(frame(packed, sequence, 1, 1), packed.crc_extra, 3)
        (message,) = codec.parse_buffer(data)
        assert message.get_type() == "ATTITUDE" and message.get_signed() and message.get_link_id() == 3
    codec.signing.secret_key = OTHER_KEY
    codec.robust_parsing = True
    (bad,) = codec.parse_buffer(ours.sign(frame(packed, 9, 1, 1), packed.crc_extra, 4))
    assert bad.get_type() == "BAD_DATA"


def test_our_own_framer_reads_what_we_sign() -> None:
    packed = pack(mavlink.MAVLink_attitude_message(1, 0.1, 0.2, 0.3, 0.0, 0.0, 0.0))
    data = signing().sign(frame(packed, 0, 1, 1), packed.crc_extra, 0)
    (message,) = Framer().feed(data)
    assert message.get_type() == "ATTITUDE" and bytes(message.get_msgbuf()) == data


@pytest.mark.parametrize("key", [OTHER_KEY, None])
def test_another_key_or_none_is_forged(key: bytes | None) -> None:
    clock = Clock()
    assert signing(key, clock).judge(heartbeat(station(KEY, clock.stamp))) is SignatureVerdict.FORGED


def test_unsigned_packets_are_recognised() -> None:
    plain = bytes(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(mavlink.MAVLink(None, srcSystem=255)))
    assert signing().judge(plain) is SignatureVerdict.UNSIGNED
    assert signing().judge(b"\xfe\x09\x00\x01\x01\x00" + bytes(11)) is SignatureVerdict.UNSIGNED


def test_a_replay_is_stale_and_the_order_of_time_counts() -> None:
    clock = Clock()
    ours, theirs = signing(clock=clock), station(KEY, clock.stamp)
    first, second = heartbeat(theirs), heartbeat(theirs)
    assert [ours.judge(data) for data in (second, first, second)] == [
        SignatureVerdict.GENUINE,
        SignatureVerdict.STALE,
        SignatureVerdict.STALE,
    ]


def test_a_new_stream_may_be_a_minute_behind_and_no_more() -> None:
    clock = Clock()
    assert signing(clock=clock).judge(heartbeat(station(KEY, clock.stamp - MINUTE + 100))) is SignatureVerdict.GENUINE
    assert signing(clock=clock).judge(heartbeat(station(KEY, clock.stamp - MINUTE - 100))) is SignatureVerdict.STALE


def test_a_boat_whose_clock_is_behind_accepts_genuine_time() -> None:
    clock = Clock(0)
    ours = signing(clock=clock)
    real = Clock().stamp
    assert ours.judge(heartbeat(station(KEY, real))) is SignatureVerdict.GENUINE
    packed = pack(mavlink.MAVLink_heartbeat_message(11, 12, 0, 0, 4, 3))
    sent = ours.sign(frame(packed, 0, 1, 1), packed.crc_extra, 0)
    assert int.from_bytes(sent[-12:-6], "little") > real


@pytest.mark.parametrize("stamp", [2**48 - 1, 2**48 - 2, 85 * 366 * 24 * 3600 * 100_000])
def test_a_stamp_of_the_next_century_ends_nobodys_time(stamp: int) -> None:
    """The last stamp of all would make every later one stale, theirs and ours."""
    clock, kept = Clock(), Kept()
    ours = signing(clock=clock, kept=kept)
    assert ours.judge(heartbeat(station(KEY, stamp))) is SignatureVerdict.STALE
    ours.set_key(OTHER_KEY, stamp)
    ours.set_key(KEY, stamp)
    assert ours.judge(heartbeat(station(KEY, clock.stamp))) is SignatureVerdict.GENUINE
    packed = pack(mavlink.MAVLink_heartbeat_message(11, 12, 0, 0, 4, 3))
    sent = [ours.sign(frame(packed, 0, 1, 1), packed.crc_extra, 0)[-12:-6] for _ in range(3)]
    stamps = [int.from_bytes(one, "little") for one in sent]
    assert stamps == sorted(set(stamps)) and stamps[-1] < clock.stamp + MINUTE
    healed = signing(clock=clock, horizon=stamp)
    assert healed.judge(heartbeat(station(KEY, clock.stamp))) is SignatureVerdict.GENUINE, "a state file of before"


@given(st.integers(0, 2**48 - 1), st.integers(0, 255), st.binary(min_size=6, max_size=6))
def test_no_forgery_locks_a_genuine_peer_out(stamp: int, link: int, guess: bytes) -> None:
    """Not a packet with a time from the future, nor on the same stream: what is genuine stays genuine."""
    clock = Clock()
    ours, theirs = signing(clock=clock), station(KEY, clock.stamp)
    data = bytearray(heartbeat(theirs))
    data[-13], data[-12:-6], data[-6:] = link, stamp.to_bytes(6, "little"), guess
    if ours.judge(bytes(data)) is SignatureVerdict.GENUINE:  # 1 in 2⁴⁸
        return
    assert ours.judge(heartbeat(theirs)) is SignatureVerdict.GENUINE


def test_ten_thousand_of_each_kind_of_forgery() -> None:
    clock, draws = Clock(), random.Random(7)
    ours, theirs, stranger = signing(clock=clock), station(KEY, clock.stamp), station(OTHER_KEY, clock.stamp + 10**9)
    genuine = [heartbeat(theirs) for _ in range(50)]
    assert {ours.judge(data) for data in genuine} == {SignatureVerdict.GENUINE}
    for _ in range(10_000):
        assert ours.judge(heartbeat(stranger)) is SignatureVerdict.FORGED
        assert ours.judge(draws.choice(genuine)) is SignatureVerdict.STALE
        flipped = bytearray(draws.choice(genuine))
        place = draws.randrange(len(flipped))
        flipped[place] ^= 1 << draws.randrange(8)
        assert ours.judge(bytes(flipped)) is not SignatureVerdict.GENUINE
        future = bytearray(draws.choice(genuine))
        future[-12:-6] = draws.randrange(clock.stamp, 2**48).to_bytes(6, "little")
        assert ours.judge(bytes(future)) is SignatureVerdict.FORGED
    assert ours.judge(heartbeat(theirs)) is SignatureVerdict.GENUINE


def test_after_a_restart_what_was_heard_before_is_stale_and_new_packets_soon_count() -> None:
    clock, kept = Clock(), Kept()
    ours, theirs = signing(clock=clock, kept=kept), station(KEY, clock.stamp)
    heard = []
    for _ in range(200):
        clock.ns += 100_000_000
        theirs.signing.timestamp = clock.stamp
        heard.append(heartbeat(theirs))
        assert ours.judge(heard[-1]) is SignatureVerdict.GENUINE
    again = Signing(clock, kept.states[-1], Kept())  # as after kill -9: nothing was kept at the end
    assert {again.judge(data) for data in heard} == {SignatureVerdict.STALE}
    clock.ns += round((2 * SAVE_PERIOD_S + 0.1) * 1e9)
    theirs.signing.timestamp = clock.stamp
    assert again.judge(heartbeat(theirs)) is SignatureVerdict.GENUINE
    assert len(kept.states) <= 20.0 / SAVE_PERIOD_S + 2


def test_a_boat_that_only_sends_saves_no_more_often() -> None:
    clock, kept = Clock(), Kept()
    ours = signing(clock=clock, kept=kept)
    packed = pack(mavlink.MAVLink_heartbeat_message(11, 12, 0, 0, 4, 3))
    stamps = []
    for _ in range(1000):
        clock.ns += 20_000_000
        stamps.append(int.from_bytes(ours.sign(frame(packed, 0, 1, 1), packed.crc_extra, 0)[-12:-6], "little"))
    assert len(kept.states) <= 20.0 / SAVE_PERIOD_S + 2
    again = Signing(Clock(0), kept.states[-1], Kept())
    assert int.from_bytes(again.sign(frame(packed, 0, 1, 1), packed.crc_extra, 0)[-12:-6], "little") > stamps[-1]


def test_without_a_key_nothing_is_signed_and_nothing_kept() -> None:
    kept = Kept()
    ours = signing(None, kept=kept)
    packed = pack(mavlink.MAVLink_heartbeat_message(11, 12, 0, 0, 4, 3))
    assert ours.sign(frame(packed, 0, 1, 1), packed.crc_extra, 0) == frame(packed, 0, 1, 1)
    ours.close()
    assert kept.states == [] and not ours.has_key


def test_a_new_key_counts_at_once_and_no_key_ends_it() -> None:
    clock, kept = Clock(), Kept()
    ours = signing(None, clock, kept=kept)
    ours.set_key(KEY, clock.stamp)
    assert ours.judge(heartbeat(station(KEY, clock.stamp))) is SignatureVerdict.GENUINE
    ours.set_key(OTHER_KEY)
    assert ours.judge(heartbeat(station(KEY, clock.stamp + 10))) is SignatureVerdict.FORGED
    ours.set_key(None)
    assert ours.judge(heartbeat(station(OTHER_KEY, clock.stamp + 10))) is SignatureVerdict.FORGED
    assert kept.states[0].key == KEY and kept.states[-1].key is None
    with pytest.raises(ValueError, match="32 bytes"):
        ours.set_key(b"short")


def test_many_links_of_one_ground_station_do_not_fill_the_memory() -> None:
    clock = Clock()
    ours = signing(clock=clock)
    for n in range(600):
        clock.ns += 1_000_000
        assert (
            ours.judge(heartbeat(station(KEY, clock.stamp, link=n % 256, system=1 + n // 256)))
            is SignatureVerdict.GENUINE
        )
    assert remembered(ours) < 256 * 6


def test_a_log_keeps_no_signature() -> None:
    theirs = station(KEY, Clock().stamp)
    signed = heartbeat(theirs)
    plain = unsigned(signed, mavlink.MAVLink_heartbeat_message.crc_extra)
    (message,) = Framer().feed(plain)
    assert len(plain) == len(signed) - 13 and message.get_type() == "HEARTBEAT" and not plain[2] & 1
    assert unsigned(plain, 50) == plain and unsigned(signed, None) == signed


class Knowing(Clock):
    """A clock that may be known to be right."""

    known: int | None = None

    def unix_ns(self) -> int | None:
        return self.known


YEAR_NS = 366 * 86_400 * 1_000_000_000


def test_a_clock_of_the_future_locks_nobody_out_where_we_know_the_time() -> None:
    clock, kept = Knowing(), Kept()
    clock.known = clock.ns
    ours = Signing(clock, SigningState(KEY, 0), kept, clock.unix_ns)
    ahead = station(KEY, clock.stamp + 61 * 100_000, system=250)
    assert ours.judge(heartbeat(ahead)) is SignatureVerdict.AHEAD
    fast = station(KEY, clock.stamp + 59 * 100_000, system=251)
    assert ours.judge(heartbeat(fast)) is SignatureVerdict.GENUINE
    slow = station(KEY, clock.stamp - 59 * 100_000, system=252)
    assert ours.judge(heartbeat(slow)) is SignatureVerdict.GENUINE
    ours.set_key(OTHER_KEY, clock.stamp + 10**9)
    assert ours.judge(heartbeat(station(OTHER_KEY, clock.stamp))) is SignatureVerdict.GENUINE
    assert kept.states[-1].horizon < clock.stamp + 80 * 100_000


def test_what_a_clock_of_the_future_did_is_undone_when_we_learn_the_time() -> None:
    """Over a restart too. What counted before does not count again."""
    clock, kept = Knowing(), Kept()
    ours = Signing(clock, SigningState(KEY, 0), kept, clock.unix_ns)
    honest = station(KEY, clock.stamp)
    early = heartbeat(honest)
    assert ours.judge(early) is SignatureVerdict.GENUINE
    wrong = station(KEY, clock.stamp + 10 * YEAR_NS // TICK_NS, system=250)
    future = heartbeat(wrong)
    assert ours.judge(future) is SignatureVerdict.GENUINE
    late = station(KEY, clock.stamp, system=253)
    assert ours.judge(heartbeat(late)) is SignatureVerdict.STALE, "it cannot be told who is right"
    restarted = Signing(clock, kept.states[-1], Kept(), clock.unix_ns)
    for boat in (ours, restarted):
        clock.ns += 2_000_000_000
        clock.known = clock.ns
        assert boat.judge(early) is SignatureVerdict.STALE
        assert boat.judge(future) is SignatureVerdict.AHEAD
        clock.ns += 1_000_000_000
        clock.known = clock.ns
        late.signing.timestamp = wrong.signing.timestamp = clock.stamp
        assert boat.judge(heartbeat(late)) is SignatureVerdict.GENUINE
        assert boat.judge(heartbeat(wrong)) is SignatureVerdict.GENUINE, "its clock is right now"
        packed = pack(mavlink.MAVLink_heartbeat_message(11, 12, 0, 0, 4, 3))
        sent = boat.sign(frame(packed, 0, 1, 1), packed.crc_extra, 0)
        assert int.from_bytes(sent[-12:-6], "little") < clock.stamp + 1_000
        clock.known = None


def test_our_own_clock_in_the_next_century_does_not_freeze_our_time_stamps() -> None:
    ours = signing(clock=Clock(EPOCH_NS + (2**48 - 1) * TICK_NS))
    packed = pack(mavlink.MAVLink_heartbeat_message(11, 12, 0, 0, 4, 3))
    sent = [ours.sign(frame(packed, 0, 1, 1), packed.crc_extra, 0)[-12:-6] for _ in range(3)]
    assert len({int.from_bytes(one, "little") for one in sent}) == 3
