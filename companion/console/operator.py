"""The console as a ground station of its own: a MAVLink link to the boat, with a system id of its own.

The boat treats it as every other ground station: authority, operator control and signatures are the boat's. While no
page that may command is open, the console sends nothing: it must not stand in for an operator who is gone.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import socket
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.console.orders import CommandOrder, Order, ParameterOrder
from companion.io.transport.urls import TransportError, parse_url

SYSTEM = 251
_COMPONENT = 190  # MAV_COMP_ID_MISSIONPLANNER: a ground station
_BOAT_COMPONENT = 1
_HEARTBEAT_S = 1.0
_LONGEST_S = 6.0  # until the boat must have answered
_TRIES = 2  # in that time
_REASON_S = 0.3  # in which the boat's words follow its answer
_REPEATED_S = 30.0  # in which the boat does not say the same refusal to us again
_ERROR = 3  # MAV_SEVERITY_ERROR: refusals
_NUDGE = 31010  # its first parameter says what is asked, the others how much
_AHEAD = 1.0  # that parameter of a nudge, which counts from where the hold point is
_IN_PROGRESS = 5
_WORDS = {1: "not now", 2: "denied", 3: "not supported", 4: "failed", 5: "still in progress", 6: "cancelled"}
_RESTART = 246
_TRIAL, _UNDO = 31014, 2.0  # the second parameter
_NO_ANSWER = "the boat does not answer"
_SEE = f"{_NO_ANSWER}: see what it has done before you ask again"
_SEE_MOVED = f"{_NO_ANSWER}: see whether it has moved before you nudge again"


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of an order, with the boat's words."""

    done: bool
    text: str


class _Texts:
    """The boat's texts that follow an order, whole: those that are longer than a packet come in pieces."""

    def __init__(self) -> None:
        self._pieces: list[tuple[int, str]] = []

    def take(self, message: Any) -> None:
        """A STATUSTEXT."""
        if message.id and message.chunk_seq and self._pieces and self._pieces[-1][0] == message.id:
            self._pieces[-1] = (message.id, self._pieces[-1][1] + message.text)
        else:
            self._pieces.append((message.id, message.text))

    def __str__(self) -> str:
        return "; ".join(dict.fromkeys(text for _, text in self._pieces))


class _Reasons:
    """Why orders were refused lately. The boat does not repeat itself, but a page shows the reason each time."""

    def __init__(self) -> None:
        self._said: dict[tuple[float, ...], dict[str, float]] = {}

    def of(self, order: CommandOrder, result: int, said: str, now_s: float) -> str:
        """The reason of a refusal: what was `said` now, or else the one reason said before. Empty: not known."""
        what = (order.number, *(order.params[:1] if order.number == _NUDGE else order.params), result)
        key = tuple(0.0 if math.isnan(value) else value for value in what)
        recent = {text: at_s for text, at_s in self._said.get(key, {}).items() if now_s - at_s < _REPEATED_S}
        if said:
            recent[said] = now_s
        self._said[key] = recent
        return said or (next(iter(recent)) if len(recent) == 1 else "")


class OperatorLink:
    """The link. `url`: `tcpout:HOST:PORT` towards a `tcpin:` of the boat, `udpout:HOST:PORT` towards its `udpin:`; a
    function, since the boat names its links when it is heard. `attended()`: whether a page that may command is open."""

    def __init__(
        self,
        url: Callable[[], str | None],
        attended: Callable[[], bool],
        boat: Callable[[], int],
        key: bytes | None = None,
        system: int = SYSTEM,
    ) -> None:
        """`boat()`: its system id. `key`: signs all packets."""
        self._url, self._attended, self._boat = url, attended, boat
        self._out = mavlink.MAVLink(None, srcSystem=system, srcComponent=_COMPONENT)
        self._in = mavlink.MAVLink(None)
        self._in.robust_parsing = True
        if key is not None:
            self._out.signing.secret_key = key
            self._out.signing.link_id = 0
            self._out.signing.sign_outgoing = True
        self._signed = key is not None
        self._transport: asyncio.Transport | asyncio.DatagramTransport | None = None
        self._heard: list[Callable[[Any], None]] = []
        self._one_at_a_time = asyncio.Lock()
        self._reasons = _Reasons()
        self.fault = "not connected yet"

    async def keep(self) -> None:
        """For ever: connect while somebody attends, and send heartbeats."""
        while True:
            if self._attended():
                await self._connect()
                self._send(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
            elif self._transport is not None:
                self._transport.close()
                self._transport = None
            await asyncio.sleep(_HEARTBEAT_S)

    async def _connect(self) -> None:
        if self._transport is not None and not self._transport.is_closing():
            return
        url = self._url()
        if url is None:
            self.fault = "the boat has no link that listens; give --link, or the boat tcpin:127.0.0.1:5770"
            return
        try:
            endpoint = parse_url(url)
            loop = asyncio.get_running_loop()
            if endpoint.scheme == "udpout":
                transport, _ = await loop.create_datagram_endpoint(
                    lambda: _Listening(self._take), remote_addr=(endpoint.host, endpoint.port), family=socket.AF_INET
                )
                self._transport = transport
            else:
                stream, _ = await loop.create_connection(lambda: _Listening(self._take), endpoint.host, endpoint.port)
                self._transport = stream
            self.fault = ""
        except (OSError, TransportError) as error:
            self.fault = f"{url}: {error}"

    def close(self) -> None:
        """Close the link."""
        if self._transport is not None:
            self._transport.close()

    def _take(self, data: bytes) -> None:
        for message in self._in.parse_buffer(data) or ():
            if message.get_srcSystem() == self._boat() and message.get_type() != "BAD_DATA":
                for heard in list(self._heard):
                    heard(message)

    def _send(self, message: Any) -> None:
        transport = self._transport
        if transport is None or transport.is_closing():
            return
        if self._signed:
            self._stamp()
        packet = bytes(message.pack(self._out))
        self._out.seq = (self._out.seq + 1) % 256
        if isinstance(transport, asyncio.DatagramTransport):
            transport.sendto(packet)
        else:
            transport.write(packet)

    def _stamp(self) -> None:
        """The time of signatures: 10 µs since 2015, rising with each packet."""
        import time

        now = max(0, (time.time_ns() - 1_420_070_400_000_000_000) // 10_000)
        self._out.signing.timestamp = max(self._out.signing.timestamp + 1, now)

    async def carry_out(self, order: Order, latest_s: float = math.inf) -> Answer:
        """Send an order, and wait for the boat's answer. After `latest_s`, by the event loop's clock, it is not sent:
        what a person wanted then may be wrong now."""
        async with self._one_at_a_time:
            if asyncio.get_running_loop().time() > latest_s:
                return Answer(False, "came too late, and was not sent")
            await self._connect()
            if self._transport is None or self._transport.is_closing():
                return Answer(False, f"no link to the boat: {self.fault}")
            texts = _Texts()
            answer: asyncio.Future[Any] = asyncio.get_running_loop().create_future()

            def heard(message: Any) -> None:
                if message.get_type() == "STATUSTEXT" and message.severity <= _ERROR:
                    texts.take(message)
                elif not answer.done() and _answers(message, order):
                    answer.set_result(message)

            self._heard.append(heard)
            try:
                see = _see_first(order)
                tries = 1 if see else _TRIES
                for _ in range(tries):
                    self._send(self._message(order))
                    with contextlib.suppress(asyncio.TimeoutError):
                        message = await asyncio.wait_for(asyncio.shield(answer), _LONGEST_S / tries)
                        return await self._conclude(order, message, texts)
                return Answer(False, see or _NO_ANSWER)
            finally:
                self._heard.remove(heard)

    async def _conclude(self, order: Order, message: Any, texts: _Texts) -> Answer:
        if isinstance(order, ParameterOrder):
            if message.get_type() == "PARAM_VALUE" and math.isclose(message.param_value, order.value, rel_tol=1e-5):
                return Answer(True, f"{order.name} {order.value:g}")
            await asyncio.sleep(_REASON_S)
            return Answer(False, str(texts) or f"{order.name} not set")
        if message.result == 0:
            return Answer(True, "")
        await asyncio.sleep(_REASON_S)
        said = self._reasons.of(order, message.result, str(texts), asyncio.get_running_loop().time())
        return Answer(False, said or _WORDS.get(message.result, f"result {message.result}"))

    def _message(self, order: Order) -> Any:
        boat = self._boat()
        if isinstance(order, ParameterOrder):
            return mavlink.MAVLink_param_set_message(boat, _BOAT_COMPONENT, order.name.encode(), order.value, 9)
        if order.place is not None:
            lat, lon = (round(degrees * 1e7) for degrees in order.place)
            four = (*order.params, *(0.0,) * 4)[:4]
            return mavlink.MAVLink_command_int_message(
                boat, _BOAT_COMPONENT, 0, order.number, 0, 0, *four, lat, lon, 0.0
            )
        seven = (*order.params, *(0.0,) * 7)[:7]
        return mavlink.MAVLink_command_long_message(boat, _BOAT_COMPONENT, order.number, 0, *seven)


def _see_first(order: Order) -> str:
    """What a person is told of an order that does something else each time it comes, so that it is sent once, though
    its answer may be late: the boat would go twice as far, undo the model before too, or restart again. Else empty."""
    if not isinstance(order, CommandOrder):
        return ""
    if order.number == _NUDGE and order.params[0] == _AHEAD:
        return _SEE_MOVED
    return _SEE if order.number == _RESTART or (order.number == _TRIAL and order.params[1] == _UNDO) else ""


def _answers(message: Any, order: Order) -> bool:
    if isinstance(order, CommandOrder):
        return bool(
            message.get_type() == "COMMAND_ACK" and message.command == order.number and message.result != _IN_PROGRESS
        )
    return bool(message.get_type() == "PARAM_VALUE" and message.param_id == order.name)


class _Listening(asyncio.Protocol, asyncio.DatagramProtocol):
    """Passes on what arrives."""

    def __init__(self, take: Callable[[bytes], None]) -> None:
        self._take = take

    def data_received(self, data: bytes) -> None:
        """Of a stream."""
        self._take(data)

    def datagram_received(self, data: bytes, addr: Any) -> None:
        """Of a datagram socket."""
        self._take(data)
