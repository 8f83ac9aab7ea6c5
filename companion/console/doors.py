"""Who may look and who may command: where a request comes from, and the login by a token.

On this computer alone everybody is let in. Where the console listens to the network, a page must first give the token.
A request that changes something, and the stream of data, must come from the console's own page: another site that is
open in the same browser is refused, and so is a name that somebody has bent to this address.
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import secrets
from collections.abc import Awaitable, Callable
from urllib.parse import urlsplit

from aiohttp import web

from companion.console.connections import body

COOKIE = "usv_console_"  # and the port: of two consoles on one computer a browser sends each the cookies of both
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "manifest-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
_OPEN_TO_ALL = ("/api/login",)
_PENALTY_S = 0.5
_LOCAL_NAMES = ("localhost", "127.0.0.1", "::1")
_MOST_SESSIONS = 100

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def is_local(host: str) -> bool:
    """Whether an address is this computer's own."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Doors:
    """The checks of every request. `token` None: no login is needed."""

    def __init__(self, host: str, token: str | None) -> None:
        self._local = is_local(host)
        self._token = token
        self._sessions: list[str] = []
        self._waiting: set[str | None] = set()  # addresses that have just given a wrong token

    @property
    def needs_login(self) -> bool:
        """Whether pages must give the token first."""
        return self._token is not None

    def refusal(self, request: web.Request) -> web.Response | None:
        """Why a request is refused; None where it may pass."""
        if self._local and _name(request.host) not in _LOCAL_NAMES:
            return web.Response(status=403, text="not a name of this computer")
        if not request.path.startswith("/api/"):
            return None
        if not self._own_origin(request):
            return web.Response(status=403, text="not from the console's own page")
        if request.path not in _OPEN_TO_ALL and not self.known(request):
            return web.Response(status=401, text="log in first")
        return None

    def known(self, request: web.Request) -> bool:
        """Whether the page has logged in, or need not."""
        return self._token is None or request.cookies.get(_cookie(request), "") in self._sessions

    @staticmethod
    def _own_origin(request: web.Request) -> bool:
        origin = request.headers.get("Origin", "")
        if not origin:  # browsers leave it out only where they read from the page's own site
            return request.method == "GET" and request.headers.get("Sec-Fetch-Site", "") == "same-origin"
        return urlsplit(origin).netloc == request.host

    async def login(self, request: web.Request) -> web.Response:
        """A page gives the token, and gets a session. After a wrong one nothing that its address gives counts for a
        while: as many guesses at once would else each cost the same wait."""
        try:
            given = str((await body(request)).get("token", ""))
        except (ValueError, AttributeError):
            given = ""
        address = request.remote
        if address in self._waiting:
            return web.json_response({"done": False, "text": "wait a second, then try again"}, status=429)
        if self._token is not None and not hmac.compare_digest(given.encode(), self._token.encode()):
            self._waiting.add(address)
            await asyncio.sleep(_PENALTY_S)
            self._waiting.discard(address)
            return web.json_response({"done": False, "text": "wrong token"}, status=401)
        session = secrets.token_urlsafe(24)
        self._sessions = [*self._sessions[1 - _MOST_SESSIONS :], session]
        response = web.json_response({"done": True})
        response.set_cookie(_cookie(request), session, httponly=True, samesite="Strict", path="/")
        return response

    @web.middleware
    async def guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse what may not pass; the headers of every answer."""
        response: web.StreamResponse | None = self.refusal(request)
        if response is None:
            try:
                response = await handler(request)
            except web.HTTPException as error:
                response = web.Response(status=error.status, text=error.reason)
        if not response.prepared:
            response.headers.update(HEADERS)
        return response


def _cookie(request: web.Request) -> str:
    """The name of the cookie, by the port that the browser knows."""
    port = request.host.rpartition(":")[2]
    return COOKIE + (port if port.isdecimal() else "80")


def _name(host: str) -> str:
    """The name of a Host header, without its port."""
    return urlsplit(f"//{host}").hostname or ""
