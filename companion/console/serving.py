"""Serves a console until a signal ends it."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import socket
import sys
from collections.abc import AsyncIterator

from aiohttp import web

from companion.console.connections import IDLE_S
from companion.console.server import Console, Settings

_SHUTDOWN_S = 1.0
_LINGER_S = 1.0  # after an answer, for the rest of a body that nobody reads


def serve(settings: Settings, port: int, beside: bool = False) -> int:
    """Listen and serve; the exit code. `beside`: until standard input ends too, as it does when the process that has
    started this one is gone. Raises OSError where the port is taken."""
    return asyncio.run(_serve(settings, port, beside))


async def _serve(settings: Settings, port: int, beside: bool) -> int:
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    if beside:
        asyncio.get_running_loop().add_reader(0, ended.set)
    listener = socket.create_server((settings.host, port))
    async with served(settings, listener):
        shown = "localhost" if settings.host in ("127.0.0.1", "::1") else settings.host
        _say(f"console: http://{shown}:{listener.getsockname()[1]}/")
        if settings.token is not None:
            _say(f"token:   {settings.token}")
        await ended.wait()
    return 0


@contextlib.asynccontextmanager
async def served(settings: Settings, listener: socket.socket) -> AsyncIterator[None]:
    """A console on a socket that listens."""
    console = Console(settings)
    runner = web.AppRunner(
        console.application(),
        access_log=None,
        shutdown_timeout=_SHUTDOWN_S,
        keepalive_timeout=IDLE_S,
        lingering_time=_LINGER_S,
    )
    await runner.setup()
    serve = runner.server
    assert serve is not None
    server = await asyncio.get_running_loop().create_server(console.connections.protocols(serve), sock=listener)
    try:
        yield
    finally:
        server.close()
        await runner.cleanup()


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()
