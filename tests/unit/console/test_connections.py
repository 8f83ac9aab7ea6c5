"""Connections that nobody uses shut nobody out, on a console that really listens."""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections.abc import Awaitable, Callable

import pytest

from companion.console import connections
from companion.console.server import Settings
from companion.console.serving import served
from tests.waiting import CAP_S

Talk = Callable[[int], Awaitable[None]]
NETWORK = Settings(control=True, host="0.0.0.0", token="a token of the test")


def with_console(talk: Talk, settings: Settings = NETWORK) -> None:
    """`talk(port)` beside a console on every address of this computer."""

    async def work() -> None:
        listener = socket.create_server(("0.0.0.0", 0))
        async with served(settings, listener):
            await talk(listener.getsockname()[1])

    asyncio.run(work())


async def idle(port: int, address: str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """A connection from that address of this computer, which asks for nothing."""
    return await asyncio.open_connection("127.0.0.1", port, local_addr=(address, 0))


async def answers(port: int, address: str) -> bool:
    """Whether the console's page is to be had from there."""
    with contextlib.suppress(OSError):
        reader, writer = await idle(port, address)
        writer.write(b"GET / HTTP/1.1\r\nHost: boat\r\n\r\n")
        with contextlib.closing(writer):
            return (await reader.readline()).startswith(b"HTTP/1.1 401")
    return False


async def kept(readers: list[asyncio.StreamReader]) -> int:
    """How many the console has not ended, once it had the time for it."""
    for _ in range(5):
        await asyncio.sleep(0.01)
    return sum(not reader.at_eof() and reader.exception() is None for reader in readers)


def test_one_device_that_opens_many_connections_shuts_out_itself_alone() -> None:
    """1,100 of them took every descriptor, and the console wrote megabytes of "Too many open files"."""

    async def talk(port: int) -> None:
        pairs = [await idle(port, "127.0.0.2") for _ in range(connections.MOST_OF_AN_ADDRESS + 10)]
        assert await kept([reader for reader, _ in pairs]) == connections.MOST_OF_AN_ADDRESS
        assert not await answers(port, "127.0.0.2")
        assert await answers(port, "127.0.0.3")
        for _, writer in pairs:
            writer.close()

    with_console(talk)


@pytest.mark.parametrize("path", ["login", "order"])
def test_a_request_whose_body_does_not_come_is_ended(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was waited for without end: four addresses took all connections so, and needed no token."""
    monkeypatch.setattr(connections, "BODY_S", 0.05)
    console = Settings(control=True) if path == "order" else NETWORK

    async def talk(port: int) -> None:
        reader, writer = await idle(port, "127.0.0.1")
        own = f"Host: localhost:{port}\r\nOrigin: http://localhost:{port}\r\nContent-Type: application/json\r\n"
        writer.write(f"POST /api/{path} HTTP/1.1\r\n{own}Content-Length: 40\r\n\r\n{{".encode())
        async with asyncio.timeout(CAP_S):
            assert (await reader.readline()).startswith(b"HTTP/1.1 408")
            await reader.read()
        writer.close()

    with_console(talk, console)


def test_who_has_asked_for_nothing_in_time_makes_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """From many addresses, so that the console has no room left at all."""
    monkeypatch.setattr(connections, "MOST", 20)

    async def talk(port: int) -> None:
        pairs = [await idle(port, f"127.0.0.{2 + n}") for n in range(20)]
        pairs[0][1].write(b"GET / HTTP/1.1\r\nHost: boat\r\n\r\n")
        assert (await pairs[0][0].readline()).startswith(b"HTTP/1.1 401")
        pairs[1][1].write(b"GET / HTTP/1.1\r\n")  # and no end
        assert not await answers(port, "127.0.0.99")
        loop = asyncio.get_running_loop()
        now_s = loop.time()
        monkeypatch.setattr(loop, "time", lambda: now_s + connections.FIRST_S + 1.0)
        assert await answers(port, "127.0.0.99")
        monkeypatch.undo()
        assert await kept([reader for reader, _ in pairs]) == 1
        for _, writer in pairs:
            writer.close()

    with_console(talk)
