"""Memory streams: a port and the device behind it."""

from __future__ import annotations

from companion.core.ports import ByteStream
from sitl.memory import MemoryStream, garbling


def test_chunks_carry_the_time_of_their_arrival_and_not_before() -> None:
    stream = MemoryStream("gnss")
    stream.device.send(b"one", 1.0)
    stream.device.send(b"two", 1.1)
    assert stream.read(0.99) == []
    assert stream.read(1.0) == [(1.0, b"one")]
    assert stream.read(5.0) == [(1.1, b"two")]
    assert stream.read(6.0) == []


def test_the_device_hears_what_the_host_wrote() -> None:
    stream = MemoryStream("board")
    stream.write(b"go", 2.0)
    assert stream.device.receive(1.9) == []
    assert stream.device.receive(2.0) == [(2.0, b"go")]


def test_it_is_a_byte_stream() -> None:
    stream = MemoryStream("gnss")
    assert isinstance(stream, ByteStream)
    assert stream.fault() is None
    assert stream.fileno() is None


def test_a_port_that_nobody_reads_keeps_the_newest() -> None:
    stream = MemoryStream("gnss")
    for k in range(1000):
        stream.device.send(bytes([k % 256]) * 1000, 0.0)
    kept = stream.read(1.0)
    assert sum(len(data) for _, data in kept) <= 65536
    assert kept[-1][1] == bytes([999 % 256]) * 1000


def test_a_vanished_port_says_so_and_comes_back_empty() -> None:
    stream = MemoryStream("gnss")
    stream.device.send(b"before", 1.0)
    stream.write(b"before", 1.0)
    stream.device.unplug()
    assert "plugged in" in (stream.fault() or "")
    stream.device.send(b"into the void", 1.1)
    stream.write(b"into the void", 1.1)
    assert list(stream.read(2.0)) == []
    stream.device.plug()
    assert stream.fault() is None
    stream.device.send(b"after", 3.0)
    assert stream.read(3.0) == [(3.0, b"after")]
    assert stream.device.receive(9.0) == []


def test_closed_and_opened_again() -> None:
    stream = MemoryStream("gnss")
    stream.close()
    assert stream.fault() == "closed"
    stream.device.send(b"unheard", 1.0)
    assert list(stream.read(2.0)) == []
    stream.reopen()
    assert stream.fault() is None
    stream.device.send(b"heard", 3.0)
    assert stream.read(3.0) == [(3.0, b"heard")]


def test_a_bad_line_changes_one_byte_in_ten_either_way_and_the_same_with_the_same_seed() -> None:
    sent, stream = bytes(5000), MemoryStream("board")
    stream.garbles = garbling(3, "board")
    stream.device.send(sent, 0.0)
    stream.write(sent, 0.0)
    ((_, to_host),), ((_, to_device),) = stream.read(1.0), stream.device.receive(1.0)
    for data in (to_host, to_device):
        assert len(data) == len(sent) and 400 < sum(byte != 0 for byte in data) < 600
    assert to_host != to_device and to_host == garbling(3, "board")(sent) != garbling(4, "board")(sent)
    stream.garbles = None
    stream.device.send(sent, 2.0)
    assert stream.read(2.0) == [(2.0, sent)]
