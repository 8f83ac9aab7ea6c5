"""The console as a ground station: the answer to an order has the boat's reason."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.console import operator
from companion.console.operator import Answer, OperatorLink
from companion.console.orders import CommandOrder

_DENIED = 2
_LONG = "Dock refused: no berth: add a [dock] table or NAV_LAND item"


class Boat:
    """A boat on TCP that denies every command, after the texts given for it: of each, its pieces."""

    def __init__(self, texts: Sequence[Sequence[str]]) -> None:
        self._texts = list(texts)
        self._out = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self._in = mavlink.MAVLink(None)
        self.left = asyncio.Event()

    async def meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while data := await reader.read(4096):
            for message in self._in.parse_buffer(data) or ():
                if message.get_type() == "COMMAND_LONG":
                    for packet in self._answer(message.command):
                        writer.write(bytes(packet.pack(self._out)))
        writer.close()
        await writer.wait_closed()
        self.left.set()

    def _answer(self, command: int) -> list[mavlink.MAVLink_message]:
        pieces = self._texts.pop(0)
        number = 7 + len(self._texts) if len(pieces) > 1 else 0
        texts = [mavlink.MAVLink_statustext_message(3, piece.encode(), number, i) for i, piece in enumerate(pieces)]
        return [mavlink.MAVLink_command_ack_message(command, _DENIED), *texts]


def answers(texts: Sequence[Sequence[str]], *orders: CommandOrder) -> list[Answer]:
    """What becomes of orders, one after the other."""

    async def all_of_them() -> list[Answer]:
        boat = Boat(texts)
        server = await asyncio.start_server(boat.meet, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        link = OperatorLink(lambda: f"tcpout:127.0.0.1:{port}", lambda: True, lambda: 1)
        found = [await link.carry_out(order) for order in orders]
        link.close()
        await boat.left.wait()
        server.close()
        await server.wait_closed()
        return found

    return asyncio.run(all_of_them())


def test_a_reason_that_came_in_pieces_is_whole() -> None:
    """It was shown as "NAV_; LAND item"."""
    (answer,) = answers([(_LONG[:50], _LONG[50:])], CommandOrder(176, (1.0, 6.0)))
    assert answer == Answer(False, _LONG)


def test_a_refusal_has_its_reason_each_time() -> None:
    """The boat says it once in 30 s; the page showed "denied" from the second time on."""
    ahead, aside = CommandOrder(31010, (1.0, 0.5, 0.0, 0.0)), CommandOrder(31010, (1.0, 0.0, 0.5, 0.0))
    dock = CommandOrder(176, (1.0, 6.0))
    reason = "Nudge refused: this boat has no sideways thrust"
    found = answers([(reason,), (), (), ("Nudge refused: arm first",), ()], ahead, aside, dock, ahead, ahead)
    assert [one.text for one in found] == [
        reason,
        reason,
        "denied",  # another order, of which nothing is known
        "Nudge refused: arm first",
        "denied",  # one of two reasons
    ]


def test_an_order_that_waited_too_long_behind_others_is_not_sent() -> None:
    """Nudges that were asked for while the boat did not answer went out one by one when it came back."""

    async def late() -> Answer:
        link = OperatorLink(lambda: "tcpout:127.0.0.1:9", lambda: True, lambda: 1)
        return await link.carry_out(CommandOrder(176, (1.0, 6.0)), asyncio.get_running_loop().time() - 0.1)

    assert asyncio.run(late()) == Answer(False, "came too late, and was not sent")


@pytest.mark.parametrize(
    ("order", "times", "text"),
    [
        (CommandOrder(31010, (1.0, 1.0, 0.0, 0.0)), 1, "the boat does not answer: see whether it has moved"),
        (CommandOrder(31010, (2.0, 90.0)), 2, "the boat does not answer"),
        (CommandOrder(192, (-1.0, 1.0)), 2, "the boat does not answer"),
        (CommandOrder(31014, (0.0, 1.0)), 2, "the boat does not answer"),
        (CommandOrder(31014, (0.0, 2.0)), 1, "the boat does not answer: see what it has done"),
        (CommandOrder(246, (1.0,)), 1, "the boat does not answer: see what it has done"),
    ],
)
def test_what_would_do_more_the_second_time_is_not_sent_again(
    order: CommandOrder, times: int, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The boat went 2 m where 1 m was asked for: it takes a repetition after 2 s for another nudge. Of two accepted
    models it undid both, and it restarted twice."""
    monkeypatch.setattr(operator, "_LONGEST_S", 0.1)
    heard: list[int] = []

    async def asked() -> Answer:
        left = asyncio.Event()

        async def silent(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            parser = mavlink.MAVLink(None)
            while data := await reader.read(4096):
                heard.extend(m.command for m in parser.parse_buffer(data) or () if m.get_type() == "COMMAND_LONG")
            writer.close()
            await writer.wait_closed()
            left.set()

        async with await asyncio.start_server(silent, "127.0.0.1", 0) as server:
            port = server.sockets[0].getsockname()[1]
            link = OperatorLink(lambda: f"tcpout:127.0.0.1:{port}", lambda: True, lambda: 1)
            answer = await link.carry_out(order)
            link.close()
            await left.wait()
            return answer

    answer = asyncio.run(asked())
    assert not answer.done and answer.text.startswith(text)
    assert heard == [order.number] * times
