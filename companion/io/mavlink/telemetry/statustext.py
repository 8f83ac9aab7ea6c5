"""STATUSTEXT messages."""

from __future__ import annotations

from typing import Any

from companion.core.decision import Status, TextKind
from companion.io.mavlink.wire import messages as mavlink

CHUNK = 50
_MOST_CHUNKS = 8
SETTLING_S = 3.0  # within it, all devices of a healthy boat are heard for the first time
_PLAIN = str.maketrans(
    {
        "°": " deg",
        "−": "-",
        "–": "-",
        "—": "-",
        "…": "...",
        "→": "->",
        "’": "'",
        "‘": "'",
        "“": '"',
        "”": '"',
        "·": "*",
        "²": "2",
        "×": "x",
        "\t": " ",
        "\n": " ",
    }
)


def statustexts(kind: TextKind, text: str, number: int) -> list[Any]:
    """One message for a text of up to 50 bytes, else chunks with the id `number` (not 0), the last one shorter than 50
    bytes.

    The text becomes plain ASCII, because ground stations show other bytes in different ways. It never ends in a tab:
    QGroundControl hides such texts.
    """
    data = text.translate(_PLAIN).strip().encode("ascii", errors="replace")
    data = data[: CHUNK * _MOST_CHUNKS - 1]
    if len(data) <= CHUNK:
        return [mavlink.MAVLink_statustext_message(kind.severity, data, 0, 0)]
    starts = range(0, len(data) + 1, CHUNK)  # an exact multiple ends in an empty chunk
    return [
        mavlink.MAVLink_statustext_message(kind.severity, data[start : start + CHUNK], number, i)
        for i, start in enumerate(starts)
    ]


def prearm_texts(status: Status) -> list[str]:
    """Why the vessel cannot be armed, in the form that ground stations show beside the arming switch; empty while
    armed."""
    return [] if status.armed else [f"PreArm: {reason}" for reason in status.arming_refusals]


def unasked_prearm_texts(status: Status) -> list[str]:
    """As `prearm_texts`, but none in the first 3 s of vessel time, when devices have not been heard yet."""
    return prearm_texts(status) if status.t_s >= SETTLING_S else []
