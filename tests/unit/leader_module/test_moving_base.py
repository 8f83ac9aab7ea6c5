"""The lead boat's receiver as a moving base: its RTCM, from its port over the link to the follower's assembler."""

from __future__ import annotations

from typing import Any

import pytest

from companion.io.mavlink.services.corrections import Assembler
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import Framer
from companion.io.mavlink.wire.links import MemoryLink
from companion.leader_module.link import LeadLink
from companion.leader_module.moving_base import RtcmTap, fragments
from tests.unit.io.sensors.test_nmea0183 import GGA, VTG
from tests.unit.io.test_rtcm import frame
from tests.wires import Wire


def assembled(messages: list[Any]) -> list[bytes]:
    assembler = Assembler()
    return [whole for one in messages for whole in assembler.take(one.flags, bytes(one.data[: one.len]))]


def test_frames_among_the_sentences_come_by_and_the_driver_gets_all() -> None:
    line = Wire()
    tap = RtcmTap(line)
    first, second = frame(300, 1), frame(25, 2)
    stream = GGA + first + VTG + second
    line.chunks = [(1.0, stream[:100]), (1.1, stream[100:])]
    assert b"".join(data for _, data in tap.read(1.2)) == stream
    assert tap.frames() == [first, second] and tap.frames() == []


def test_of_very_many_frames_the_newest_are_kept() -> None:
    line = Wire()
    tap = RtcmTap(line)
    frames = [frame(40, n) for n in range(40)]
    line.chunks = [(1.0, b"".join(frames))]
    tap.read(1.0)
    assert tap.frames() == frames[-16:]


def test_the_link_carries_them_whole() -> None:
    memory = MemoryLink("memory:lead")
    link = LeadLink(memory, 42, 1, 20.0, False, lambda now_s, text: None)
    frames = [frame(size, n) for n, size in enumerate((25, 180, 181, 720, 721, 1029))]
    link.send_corrections(frames, 5.0)
    sent = Framer().feed(memory.from_vessel())
    assert {(message.get_srcSystem(), message.get_srcComponent()) for message in sent} == {(42, 191)}
    assert assembled(sent) == frames


def test_a_line_that_is_full_gets_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is late is of no use, and it must not delay positions."""
    memory = MemoryLink("memory:lead")
    link = LeadLink(memory, 42, 1, 20.0, False, lambda now_s, text: None)
    monkeypatch.setattr(Endpoint, "backlog", 500)
    link.send_corrections([frame(300)], 5.0)
    assert memory.from_vessel() == b""


def test_every_fragment_says_where_it_belongs() -> None:
    flags = [message.flags for message in fragments(frame(900), 33)]
    assert flags == [0x09, 0x0B, 0x0D, 0x0F, 0x09]
    assert [message.flags for message in fragments(frame(100), 33)] == [0x08]
