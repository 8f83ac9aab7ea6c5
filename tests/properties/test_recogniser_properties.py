"""Whatever comes in on a line: no exception, and the pieces in which it comes do not matter."""

from __future__ import annotations

import time

from hypothesis import given
from hypothesis import strategies as st

from companion.io.recognise import Overheard, Recogniser

MESSAGES = [
    b"$WIMWV,214.8,R,0.1,K,A*28\r\n",
    b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C\r\n",
    bytes.fromhex("faff3e00c3"),
    bytes.fromhex("d300133ed7d30202980edeef34b4bd62ac0941986f33360b98"),
    bytes.fromhex("b5620501020006010f38"),
    b"\xfa\xff\x36\xff",
    b"\xd3\x03\xff",
    b"\xb5\x62\x01\x07\xff\xff",
    b"$GPGGA,*",
    b"\x00\x02\x01",
    b"\xfe\x09",
    b"\xfd\x09\x00",
]
line = st.lists(st.one_of(st.sampled_from(MESSAGES), st.binary(max_size=12)), max_size=12).map(b"".join)


@given(line, st.lists(st.integers(1, 40), min_size=1, max_size=8))
def test_any_bytes_in_any_pieces(data: bytes, sizes: list[int]) -> None:
    whole, pieces, at, n = Recogniser(), Recogniser(), 0, 0
    whole.feed(data)
    while at < len(data):
        pieces.feed(data[at : at + sizes[n % len(sizes)]])
        at, n = at + sizes[n % len(sizes)], n + 1
    assert isinstance(whole.guess, str)
    if whole.verdict is not None:
        assert pieces.verdict is not None, "what is found at once is found piece by piece"


def test_floods_made_for_it_cost_little() -> None:
    """Bytes that seem to begin a message at every second place: 1 MB of each; CPU time, a call being what one read of a
    port brings."""
    for flood in (
        b"\xd3\x00",
        b"\xd3\x03",
        b"\xfa\xff",
        b"\xfa\xff\x36\xff",
        b"\xb5\x62\x00\x00\x00\x07",
        b"!AA,",
        b"$A,",
        b"\xfd\x00",
        b"\x00\x01",
        b"\xfe",
    ):
        overheard, worst_s, data = Overheard(600), 0.0, flood * (16384 // len(flood))
        for k in range(64):
            begin_s = time.process_time()
            overheard.hear(data, 600 + 16384 * (k + 1))
            assert isinstance(overheard.guess, str)
            worst_s = max(worst_s, time.process_time() - begin_s)
        print(f"{flood!r}: {1e3 * worst_s:.1f} ms")
        assert worst_s < 0.05, flood
