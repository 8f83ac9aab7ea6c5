from __future__ import annotations

import pytest

from companion.core.decision import MissionProgress, MissionState, ModeId, Status, TextKind
from companion.io.mavlink.telemetry.statustext import prearm_texts, statustexts, unasked_prearm_texts


@pytest.mark.parametrize("length", [0, 1, 49, 50, 51, 99, 100, 101, 150, 399])
def test_chunks_give_the_text_again(length: int) -> None:
    text = ("abcdefghij" * 40)[:length]
    messages = statustexts(TextKind.ATTENTION, text, 7)
    assert "".join(message.text for message in messages) == text
    assert all(message.severity == TextKind.ATTENTION.severity for message in messages)
    if length <= 50:
        assert [(message.id, message.chunk_seq) for message in messages] == [(0, 0)]
    else:
        assert [(message.id, message.chunk_seq) for message in messages] == [(7, i) for i in range(len(messages))]
        assert len(messages[-1].text) < 50  # that is how a station knows the last


def test_long_texts_are_cut() -> None:
    messages = statustexts(TextKind.ROUTINE, "x" * 5000, 1)
    assert len(messages) == 8
    assert len(messages[-1].text) == 49


def test_plain_characters_only_and_no_tab_at_the_end() -> None:
    (message,) = statustexts(TextKind.ROUTINE, "turn −5° → “north”…\tnow\t", 1)
    assert message.text == 'turn -5 deg -> "north"... now'
    assert statustexts(TextKind.ROUTINE, "blåbær", 1)[0].text == "bl?b?r"


@pytest.mark.parametrize(("t_s", "unasked"), [(0.0, False), (2.9, False), (3.0, True)])
def test_refusals_in_the_first_seconds_are_sent_only_on_request(t_s: float, unasked: bool) -> None:
    status = Status(
        t_s,
        ModeId.HOLD,
        ModeId.HOLD,
        False,
        ("gnss: nothing received yet",),
        (),
        None,
        MissionProgress(MissionState.NO_MISSION, 0, 0),
    )
    assert prearm_texts(status) == ["PreArm: gnss: nothing received yet"]
    assert unasked_prearm_texts(status) == (prearm_texts(status) if unasked else [])
