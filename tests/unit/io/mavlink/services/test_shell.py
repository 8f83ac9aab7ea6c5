"""The shell: a line that sets a parameter is answered when the value is stored."""

from __future__ import annotations

from typing import Any

import pytest

from companion.io.mavlink.services.shell import PROMPT, ShellService
from companion.io.mavlink.wire import messages as mavlink
from companion.supervisor.shell import Reply, Setting
from tests.unit.io.mavlink.conftest import Desk
from tests.unit.io.mavlink.slow_storage import SlowStorage

SHELL, RESPOND = 10, 2


@pytest.fixture
def storage(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> SlowStorage:
    """`set` sets WP_SPEED to 2; any other line is said again."""

    def answer(line: str, boat: object) -> Reply:
        return Reply(("set",), Setting("WP_SPEED", 2.0)) if line == "set" else Reply((f"you said {line}",))

    monkeypatch.setattr("companion.io.mavlink.services.shell.answer", answer)
    monkeypatch.setattr("companion.io.mavlink.services.shell.snapshot_of", lambda vessel, events, now_s: None)
    desk.supervisor.refusal = lambda request, now_s: None  # type: ignore[attr-defined]
    desk.hub.version = "0.1.0"
    storage = desk.vessel.storage = SlowStorage()
    desk.serve(ShellService(desk.hub, desk.vessel))
    said(desk, "")
    return storage


def said(desk: Desk, text: str) -> str:
    data = list(text.encode().ljust(70, b"\0"))
    desk.tell(mavlink.MAVLink_serial_control_message(SHELL, RESPOND, 0, 0, len(text), data, 1, 1))
    return printed(desk)


def printed_for(desk: Desk, duration_s: float) -> str:
    return "".join(printed(desk) for _ in range(round(0.5 * duration_s)))


def printed(desk: Desk) -> str:
    desk.wait(1.0)
    desk.answer()
    desk.wait(1.0)
    replies: list[Any] = [m for m in desk.replies() if m.get_type() == "SERIAL_CONTROL"]
    return b"".join(bytes(m.data[: m.count]) for m in replies).decode()


def test_the_answer_and_the_lines_behind_it_wait_for_the_medium(desk: Desk, storage: SlowStorage) -> None:
    assert said(desk, "set\nhello\n") == "set\n"
    assert desk.parameters["WP_SPEED"] == 2.0, "it is in force at once"
    assert said(desk, "more\n") == ""
    storage.settle()
    answers = f"set\n{PROMPT}hello\nyou said hello\n{PROMPT}more\nyou said more\n{PROMPT}"
    assert printed(desk) == answers


def test_what_is_not_stored_is_said(desk: Desk, storage: SlowStorage) -> None:
    said(desk, "set\n")
    storage.fail("No space left")
    assert printed(desk) == f"In force but not stored: No space left\n{PROMPT}"


def test_what_is_typed_meanwhile_has_a_bound(desk: Desk, storage: SlowStorage) -> None:
    said(desk, "set\n")
    for _ in range(500):
        assert said(desk, "nonsense\n" * 7) == ""
    storage.settle()
    assert 100 < printed_for(desk, 60.0).count(f"{PROMPT}nonsense") < 450, "of 3,500"
