"""One command as it came in COMMAND_LONG or COMMAND_INT, and what it is answered with."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.storing import Ticket
from companion.io.mavlink.wire.hub import Peer
from companion.mission.plan import GLOBAL_FRAMES
from companion.supervisor.supervisor import Supervisor

_INT32_MAX = 0x7FFFFFFF  # where COMMAND_INT has no room for NaN
_BEYOND_COUNTING = 2.0**32
_KEY = struct.Struct("<H7d")

Params = tuple[float, float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class CommandRequest:
    """A command. `params` may hold NaN and infinities; `frame` is None for COMMAND_LONG.

    In COMMAND_INT params 5 and 6 are x and y as they came: `place` gives the position that they mean.
    """

    command: int
    params: Params
    frame: int | None
    peer: Peer
    now_s: float
    confirmation: int = 0

    def whole(self, number: int) -> int | None:
        """Param `number` (from 1) as a whole number; None where it is none, or none that anything here is counted
        with."""
        value = self.params[number - 1]
        return int(value) if abs(value) < _BEYOND_COUNTING and value == int(value) else None

    def whole_or(self, number: int, otherwise: int) -> int | None:
        """As `whole`, but NaN, with which clients fill what they leave out, stands for `otherwise`."""
        return otherwise if math.isnan(self.params[number - 1]) else self.whole(number)

    @property
    def frame_is_global(self) -> bool:
        """A position in it is latitude and longitude."""
        return self.frame is None or self.frame in GLOBAL_FRAMES

    @property
    def place(self) -> tuple[float, float]:
        """(lat_deg, lon_deg) of a command with a position; NaN where it was left out."""
        x, y = self.params[4], self.params[5]
        if self.frame is None:
            return x, y
        return (math.nan if x == _INT32_MAX else x * 1e-7), (math.nan if y == _INT32_MAX else y * 1e-7)

    @property
    def names_no_place(self) -> bool:
        """Whether the position was left out: programs send NaN or 0 in both its params then."""
        lat_deg, lon_deg = self.place
        return (math.isnan(lat_deg) and math.isnan(lon_deg)) or (lat_deg, lon_deg) == (0.0, 0.0)

    @property
    def key(self) -> bytes:
        """Equal for a command and its retransmission."""
        return _KEY.pack(self.command, *self.params) + bytes((0xFF if self.frame is None else self.frame,))


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of a command, and the messages that go to who asked after the acknowledgement.

    The reason of a refusal is said to who asked, as a text of that kind. A handler that returns the supervisor's
    outcome as it is leaves that to the supervisor. The acknowledgement waits until what the command changes
    is stored: `stored` is its ticket; `sets_parameters`: parameters.
    """

    outcome: Outcome
    messages: Sequence[Any] = ()
    kind: TextKind = TextKind.REFUSAL
    later: bool = False  # whoever carries it out acknowledges it
    stored: Ticket | None = None
    sets_parameters: bool = False
    unstored: str = "In force but not stored"  # said where it could not be stored


SupervisorHandler = Callable[[Supervisor, CommandRequest], "Outcome | Answer"]


@dataclass(frozen=True, slots=True)
class CommandRow:
    """One operator command that the supervisor answers. `once`: done twice, it would do something else the second
    time, so a repetition is only acknowledged again."""

    number: int
    handler: SupervisorHandler
    once: bool = False


CommandHandler = Callable[[CommandRequest], "Outcome | Answer"]


def denied(reason: str) -> Answer:
    """Wrong whenever it is asked."""
    return Answer(Outcome(Result.DENIED, reason))


def unread(reason: str) -> Answer:
    """Wrong whenever it is asked. A program asked in order to read: that interrupts no operator."""
    return Answer(Outcome(Result.DENIED, reason), kind=TextKind.HINT)


def not_now(reason: str = "") -> Answer:
    """Could be right at another time."""
    return Answer(Outcome(Result.TEMPORARILY_REJECTED, reason))


DONE = Answer(ACCEPTED)
LATER = Answer(ACCEPTED, later=True)
UNSUPPORTED = Answer(Outcome(Result.UNSUPPORTED))


def is_place(lat_deg: float, lon_deg: float) -> bool:
    """A position on the globe that somebody meant: 0, 0 is what a client sends that has none."""
    return (
        math.isfinite(lat_deg)
        and math.isfinite(lon_deg)
        and abs(lat_deg) <= 90.0
        and abs(lon_deg) <= 180.0
        and (lat_deg, lon_deg) != (0.0, 0.0)
    )
