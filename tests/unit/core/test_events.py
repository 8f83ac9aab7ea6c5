"""Events are said once, and can be encoded."""

from __future__ import annotations

import os

from companion.core.decision import TextKind
from companion.core.events import EventLog


def test_a_file_whose_name_is_not_utf_8_can_be_told() -> None:
    """The run ended at the first event that named it: no log and no message can hold such a text."""
    events = EventLog()
    events.say(0.0, TextKind.ATTENTION, "state", f"{os.fsdecode(b'st')}{os.fsdecode(bytes([0xE9]))}: Größe ≥ 3")
    (event,) = events.drain()
    assert event.text == r"st\udce9: Größe ≥ 3" and event.text.encode()
