"""The console's server: the page, the stream of data to it, and its orders to the boat."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import json
import math
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aiohttp import WSMsgType, web

from companion.console.board import Board, Page, text_of
from companion.console.connections import Connections, body
from companion.console.doors import Doors
from companion.console.live import read_feed
from companion.console.operator import OperatorLink
from companion.console.orders import STOPS, OrderError, order_of
from companion.console.pace import Pace
from companion.console.replay import Player, Recording
from companion.console.tiles import Tiles
from companion.console.weather import keep_polar

STATIC = Path(__file__).parent / "static"
_PING_S = 30.0  # on a slow network a page still loads then, whose stream is full for so long
_BEAT_S = 2.0  # between two beats where nothing else goes
_LATEST_S = 5.0  # from when a page asks for an order until it goes to the boat
_LARGEST_REQUEST = 16 * 1024
_TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}


@dataclass(frozen=True, slots=True)
class Settings:
    """What a console shows, and to whom. `feed`: socket of a running companion; `log`: a recording instead of it.
    `control`: pages may command, over `link` (None: the first that the boat names), signed with `key`. `token`: for the
    login; None where none is needed."""

    feed: Path | None = None
    log: Recording | None = None
    control: bool = False
    link: str | None = None
    key: bytes | None = None
    system: int = 251
    host: str = "127.0.0.1"
    token: str | None = None
    tiles: Tiles | None = None


class Console:
    """The server of one console. Remembers the board, the link to the boat, and which pages are open."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._doors = Doors(settings.host, settings.token)
        self.connections = Connections()
        self._mode = {
            "replay": settings.log is not None,
            "control": settings.control and settings.log is None,
            "system": settings.system,
            "page": _page_version(),
            "tiles": None
            if settings.tiles is None
            else {"zooms": list(settings.tiles.zooms), "attribution": settings.tiles.attribution},
        }
        self.board = Board(self._mode)
        self._paces: set[Pace] = set()
        self._link = OperatorLink(self._url, self._attended, self._system, settings.key, settings.system)

    def application(self) -> web.Application:
        """What aiohttp serves."""
        app = web.Application(middlewares=[self.connections.heard, self._doors.guard], client_max_size=_LARGEST_REQUEST)
        app.router.add_get("/", self._page)
        app.router.add_get("/static/{name}", self._static)
        app.router.add_get("/tiles/{zoom:\\d+}/{column:\\d+}/{row:\\d+}", self._tile)
        app.router.add_post("/api/login", self._doors.login)
        app.router.add_post("/api/order", self._order)
        app.router.add_get("/api/stream", self._stream)
        app.cleanup_ctx.append(self._beside)
        return app

    async def _beside(self, app: web.Application) -> AsyncIterator[None]:
        """The tasks that run while the server does."""
        work = []
        if self._settings.feed is not None:
            work += [read_feed(self._settings.feed, self.board), keep_polar(self.board)]
            if self._settings.control:
                work.append(self._link.keep())
        tasks = [asyncio.create_task(one) for one in work]
        yield
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        self._link.close()

    # --- the page --------------------------------------------------------------------------------------------------

    async def _page(self, request: web.Request) -> web.StreamResponse:
        known = self._doors.known(request)
        body = (STATIC / ("index.html" if known else "login.html")).read_bytes()
        return web.Response(body=body, status=200 if known else 401, content_type="text/html", charset="utf-8")

    async def _static(self, request: web.Request) -> web.StreamResponse:
        path = STATIC / request.match_info["name"]
        kind = _TYPES.get(path.suffix)
        if kind is None or path.parent != STATIC or not path.is_file():
            return web.Response(status=404, text="no such file")
        return web.Response(body=path.read_bytes(), content_type=kind, charset="utf-8")

    async def _tile(self, request: web.Request) -> web.StreamResponse:
        if not self._doors.known(request):
            return web.Response(status=401, text="log in first")
        tiles = self._settings.tiles
        zoom, column, row = (int(request.match_info[name]) for name in ("zoom", "column", "row"))
        found = None if tiles is None or zoom > 30 else tiles.tile(zoom, column, row)
        if found is None:
            return web.Response(status=404, text="no such tile")
        return web.Response(body=found[0], content_type=found[1])

    # --- data ------------------------------------------------------------------------------------------------------

    async def _stream(self, request: web.Request) -> web.StreamResponse:
        socket = web.WebSocketResponse(heartbeat=_PING_S, max_msg_size=_LARGEST_REQUEST)
        await socket.prepare(request)
        page, pace = Page(), Pace(_now_s())
        player = None
        if self._settings.log is not None:
            player = Player(self._settings.log, page, self._mode)
        else:
            self.board.welcome(page)
            self._paces.add(pace)
        work = [asyncio.create_task(self._pass_on(page, pace, socket))]
        if player is not None:
            work.append(asyncio.create_task(player.play()))
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    with contextlib.suppress(ValueError, AttributeError, TypeError):
                        self._hear(json.loads(message.data), pace, player)
        finally:
            self.board.pages.discard(page)
            self._paces.discard(pace)
            for task in work:
                task.cancel()
            await asyncio.gather(*work, return_exceptions=True)
        return socket

    @staticmethod
    def _hear(message: Any, pace: Pace, player: Player | None) -> None:
        if "beat" in message:
            pace.take(message, _now_s())
        elif player is not None:
            player.order(message)

    @staticmethod
    async def _pass_on(page: Page, pace: Pace, socket: web.WebSocketResponse) -> None:
        """A page that takes nothing holds up this task alone."""
        with contextlib.suppress(ConnectionError):
            while not socket.closed:
                await pace.room()
                for text in await page.take(_BEAT_S):
                    await socket.send_str(text)
                await socket.send_str(text_of(pace.beat(_now_s())))

    def _attended(self) -> bool:
        """Whether a page is open that still answers."""
        return any(pace.lives(_now_s()) for pace in self._paces)

    # --- orders ----------------------------------------------------------------------------------------------------

    async def _order(self, request: web.Request) -> web.StreamResponse:
        if not self._mode["control"]:
            return _answer(403, "this console only shows; start it with --control")
        if request.content_type != "application/json":
            return _answer(415, "orders are JSON")
        try:
            asked = await body(request)
            if not isinstance(asked, dict):
                raise OrderError("an order is an object")
            order = order_of(asked, self._modes())
        except ValueError:
            return _answer(400, "no JSON")
        except OrderError as error:
            return _answer(400, str(error))
        latest_s = math.inf if asked["order"] in STOPS else _asked_s(asked) + _LATEST_S
        answer = await self._link.carry_out(order, latest_s)
        return _answer(200 if answer.done else 409, answer.text, answer.done)

    def _modes(self) -> Mapping[str, int]:
        hello = self.board.hello or {}
        return {row["name"]: row["px4"] for row in hello.get("modes", ())}

    def _system(self) -> int:
        return int((self.board.hello or {}).get("system", 1))

    def _url(self) -> str | None:
        """Of the link to the boat: as asked for, or the first of the boat's that listens and has its own persona."""
        if self._settings.link is not None:
            return self._settings.link
        links: list[Any] = (self.board.hello or {}).get("links", [])
        for url in links:
            plain, _, options = str(url).partition("?")
            scheme, _, address = plain.partition(":")
            if scheme in ("tcpin", "udpin") and "dialect=ardupilot" not in options:
                host, _, port = address.rpartition(":")
                host = "127.0.0.1" if host in ("", "0.0.0.0", "::") else host
                return f"{'tcpout' if scheme == 'tcpin' else 'udpout'}:{host}:{port}"
        return None


def _page_version() -> str:
    """Another one for each change of the page's files: a page that was opened before it loads itself anew."""
    digest = hashlib.sha256()
    for path in sorted(STATIC.iterdir()):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _now_s() -> float:
    return asyncio.get_running_loop().time()


def _asked_s(asked: Mapping[str, Any]) -> float:
    """When a page asked for an order, by the time that the last beat gave it and its own clock since: a network that
    was away may bring the order much later."""
    at_s = asked.get("at_s")
    return float(at_s) if isinstance(at_s, int | float) and math.isfinite(at_s) else _now_s()


def _answer(status: int, text: str, done: bool = False) -> web.Response:
    return web.json_response({"done": done, "text": text}, status=status)
