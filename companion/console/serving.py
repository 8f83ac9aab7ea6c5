"""Serves a console until a signal ends it."""

from __future__ import annotations

import asyncio
import signal
import socket
import sys

from aiohttp import web

from companion.console.server import Console, Settings

_SHUTDOWN_S = 1.0


def serve(settings: Settings, port: int, beside: bool = False) -> int:
    """Listen and serve; the exit code. `beside`: until standard input ends too, as it does when the process that has
    started this one is gone. Raises OSError where the port is taken."""
    return asyncio.run(_serve(settings, port, beside))


async def _serve(settings: Settings, port: int, beside: bool) -> int:
    runner = web.AppRunner(Console(settings).application(), access_log=None, shutdown_timeout=_SHUTDOWN_S)
    await runner.setup()
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        asyncio.get_running_loop().add_signal_handler(number, ended.set)
    if beside:
        asyncio.get_running_loop().add_reader(0, ended.set)
    try:
        listener = socket.create_server((settings.host, port))
        await web.SockSite(runner, listener).start()
        shown = "localhost" if settings.host in ("127.0.0.1", "::1") else settings.host
        _say(f"console: http://{shown}:{listener.getsockname()[1]}/")
        if settings.token is not None:
            _say(f"token:   {settings.token}")
        await ended.wait()
    finally:
        await runner.cleanup()
    return 0


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()
