"""How many connections the console keeps: so many from one address, so many in all, and none that asks for nothing.

Each takes a descriptor, of which a process has about a thousand. Without a limit a device in the network that opens
connections, by mistake or on purpose, shuts everybody else out, and needs no token for that.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from typing import Any

from aiohttp import web

MOST = 256
MOST_OF_AN_ADDRESS = 64  # a page has one for its stream, and up to six while it loads
FIRST_S = 10.0  # until the first request has arrived; who is later makes room for the next one that connects
IDLE_S = 30.0  # from an answer to the next request
BODY_S = 10.0  # from the head of a request to the end of its body

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


async def body(request: web.Request) -> Any:
    """The JSON in the body of a request. Raises ValueError for what is none, and HTTPRequestTimeout where it does not
    arrive in time: aiohttp waits for it without end."""
    try:
        async with asyncio.timeout(BODY_S):
            return await request.json()
    except TimeoutError:
        raise web.HTTPRequestTimeout from None


class Connections:
    """Those that are open: of each its address, and the time by which it must have asked for something."""

    def __init__(self) -> None:
        self._open: dict[Any, tuple[str, float]] = {}

    def protocols(self, serve: Callable[[], asyncio.Protocol]) -> Callable[[], asyncio.Protocol]:
        """What the event loop asks for the protocol of each connection; `serve()` gives that of one that is kept."""
        return lambda: _Met(lambda transport: self._meet(transport, serve))

    @web.middleware
    async def heard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """A request has arrived."""
        if (known := self._open.get(request.transport)) is not None:
            self._open[request.transport] = (known[0], math.inf)
        return await handler(request)

    def _meet(self, transport: asyncio.Transport, serve: Callable[[], asyncio.Protocol]) -> None:
        now_s = asyncio.get_running_loop().time()
        for one, (_, until_s) in self._open.items():
            if now_s > until_s:
                one.abort()
        self._open = {one: known for one, known in self._open.items() if not one.is_closing()}
        address = transport.get_extra_info("peername")[0]
        of_the_address = sum(known[0] == address for known in self._open.values())
        if len(self._open) >= MOST or of_the_address >= MOST_OF_AN_ADDRESS:
            transport.abort()
            return
        self._open[transport] = (address, now_s + FIRST_S)
        protocol = serve()
        transport.set_protocol(protocol)
        protocol.connection_made(transport)


class _Met(asyncio.Protocol):
    """Of a connection that has just been accepted."""

    def __init__(self, meet: Callable[[asyncio.Transport], None]) -> None:
        self._meet = meet

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Its address is known."""
        assert isinstance(transport, asyncio.Transport)
        self._meet(transport)
